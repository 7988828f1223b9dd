//! Maps (figures 10 and 15): an ordinary sweep.

use std::convert::Infallible;

use vibrochain_floquet::{Mechanism, Tolerance};

use crate::figures::drawn::{Drawn, Picture};
use vibrochain_cli::common::error::CliError;
use vibrochain_lattice::Stop;
use vibrochain_maps::cell::{Cell, Class};
use vibrochain_maps::scene::Scene;
use vibrochain_maps::summary::Summary;
use vibrochain_maps::sweep::{Ended, sweep};
use vibrochain_maps::table::{RowWriter, header};

/// Computes the figure.
///
/// # Errors
/// [`CliError`].
pub(super) fn draw(scene: &Scene, pool: &rayon::ThreadPool, stop: &Stop) -> Result<Drawn, CliError> {
    let mut table = header(scene).into_bytes();
    let mut all: Vec<Cell> = Vec::new();
    let writer = RowWriter::new(scene, false);
    let ended = sweep(
        scene,
        pool,
        stop,
        |_| {},
        |range, cells| {
            all.extend_from_slice(cells);
            table.extend(writer.rows(range, cells).text);
            Ok::<_, Infallible>(())
        },
    );
    let summary = match ended {
        Ended::Complete(summary) => summary,
        Ended::Stopped | Ended::Failed(_) => return Err(CliError::Interrupted),
    };
    let findings = findings(scene, &all, &summary);
    Ok(Drawn { picture: Picture::map(scene, &all), table, more: Vec::new(), findings })
}

fn findings(scene: &Scene, cells: &[Cell], summary: &Summary) -> Vec<String> {
    let share = |count: usize| format!("{count} ({:.1} %)", 100.0 * count as f64 / cells.len().max(1) as f64);
    let mut lines = vec![
        "| class | cells | through +1 | period doubling (−1) | Neimark–Sacker |\n|---|---|---|---|---|".to_owned(),
    ];
    for class in Class::ALL {
        let of_class = || cells.iter().filter(|cell| cell.class == Some(class));
        let count = of_class().count();
        if count == 0 {
            continue;
        }
        let by =
            |which: fn(Mechanism) -> bool| match of_class().filter(|cell| cell.mechanism.is_some_and(which)).count() {
                0 => String::new(),
                count => count.to_string(),
            };
        let plus = by(Mechanism::is_through_plus_one);
        let [doubling, torus] = [by(|it| it == Mechanism::PeriodDoubling), by(|it| it == Mechanism::NeimarkSacker)];
        lines.push(format!("| {} | {} | {plus} | {doubling} | {torus} |", class.name(), share(count)));
    }
    let unknown = cells.iter().filter(|cell| cell.class.is_none()).count();
    if unknown > 0 {
        lines.push(format!("| not decided (see `status` in the table) | {} | | | |", share(unknown)));
    }
    let mut found = vec![lines.join("\n")];
    let radius = |class: Class, keep: &dyn Fn(f64) -> bool| {
        let of_class = cells.iter().filter(|cell| cell.class == Some(class));
        of_class.filter(|cell| cell.spectral_radius.is_some_and(keep)).count()
    };
    if !scene.is_conservative() {
        let mut excesses: Vec<f64> = cells
            .iter()
            .filter(|cell| cell.class == Some(Class::UnstableDouble))
            .filter_map(|cell| cell.spectral_radius.map(|radius| radius - 1.0))
            .collect();
        excesses.sort_by(f64::total_cmp);
        let excess = |part: f64| excesses.get((part * excesses.len() as f64) as usize).copied().unwrap_or_default();
        let weak = |excess: f64| radius(Class::UnstableDouble, &|r| r < 1.0 + excess);
        match scene.task.tolerance {
            Tolerance::Rounding => found.push(format!(
                "Of the unstable double-sided cells {} grow by less than 1 % a period, {} by less than 0.1 %; the median \
                 excess is {:.1e} a period, a tenth of them have less than {:.1e}.",
                share(weak(0.01)),
                share(weak(0.001)),
                excess(0.5),
                excess(0.1)
            )),
            Tolerance::Excess(excess) => found.push(format!(
                "Of the stable double-sided cells {} have a multiplier outside the circle, with excess below {excess} a period.",
                share(radius(Class::StableDouble, &|r| r > 1.0 + 1e-9))
            )),
        }
    }
    let exists = |cell: &Cell| cell.class.is_some_and(|class| class != Class::None);
    let x = &scene.axes[0];
    let columns = x.points();
    let last = cells.iter().enumerate().filter(|(_, cell)| exists(cell)).map(|(k, _)| k % columns).max();
    if let Some(last) = last {
        let ends = format!("The largest {} with a physical breather is {:.4}", x.parameter.symbol(), x.value(last));
        found.push(format!("{ends}; worst residual of an orbit {:.1e}.", summary.worst_residual));
    }
    found
}
