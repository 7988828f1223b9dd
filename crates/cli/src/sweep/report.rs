//! What a sweep has found, in a few lines for people.

use crate::common::threads::cores;
use vibrochain_floquet::Tolerance;
use vibrochain_maps::absence::Absence;
use vibrochain_maps::cell::{Class, Status};
use vibrochain_maps::grid::Grid;
use vibrochain_maps::manifest::Effort;
use vibrochain_maps::obstructions::Obstructed;
use vibrochain_maps::scene::Axis;
use vibrochain_maps::summary::{SLOW, Summary};

/// Contacts and impacts that are told of each reason; the manifest has more.
const MOST_TOLD: usize = 4;

/// "1 cell", "2 cells".
pub(crate) fn counted(count: impl TryInto<u64>, thing: &str) -> String {
    // (A count that is beyond 64 bits is none that a machine can hold.)
    let count = count.try_into().unwrap_or(u64::MAX);
    if count == 1 { format!("1 {thing}") } else { format!("{count} {thing}s") }
}

/// "400 × 300": the points of the axes.
pub(crate) fn grid<S: Grid>(scene: &S) -> String {
    points(&scene.axes().iter().map(Axis::points).collect::<Vec<_>>())
}

/// The same of the points themselves.
pub(crate) fn points(counts: &[usize]) -> String {
    if counts.is_empty() {
        return "one point".to_owned();
    }
    counts.iter().map(usize::to_string).collect::<Vec<_>>().join(" × ")
}

/// What a table has.
pub(crate) fn size<S: Grid>(scene: &S, summary: &Summary) -> String {
    format!("{} ({})", counted(summary.cells(), "cell"), grid(scene))
}

/// The summary of a finished table.
pub(crate) fn report<S: Grid>(scene: &S, summary: &Summary, effort: Option<&Effort>) -> String {
    let cells = summary.cells();
    let mut lines = vec![size(scene, summary)];
    let share = |count: u64| 100.0 * count as f64 / cells as f64;
    for (class, count) in summary.by_name(S::class_name).into_iter().filter(|(_, count)| *count > 0) {
        lines.push(format!("  {class:<16} {count:>9}  {:5.1} %", share(count)));
    }
    for (absence, count) in Absence::ALL.into_iter().zip(summary.absences).filter(|(_, count)| *count > 0) {
        lines.push(format!("    none in {count}: {}", absence.told()));
        lines.extend(obstructed(summary, absence));
    }
    lines.extend(scene.explained().1.into_iter().map(|line| format!("    {line}")));
    // Under a force hardly anything is strictly stable, and most of it grows so slowly that nobody sees it.
    if summary.slow > 0 && scene.tolerance() == Some(Tolerance::Rounding) {
        let unstable = [Class::UnstableDouble, Class::UnstableSingle, Class::UnstableWord];
        let unstable: u64 = unstable.iter().map(|class| summary.classes[*class as usize]).sum();
        lines.push(format!(
            "{} of the {unstable} unstable cells grow by less than {} % a period: --threshold {SLOW} calls them stable",
            summary.slow,
            100.0 * SLOW
        ));
    }
    for (status, &count) in Status::ALL.iter().zip(&summary.statuses).skip(1).filter(|(_, count)| **count > 0) {
        lines.push(format!("  status {:<16} {count:>9}", status.name()));
    }
    lines.extend(effort.map(speed));
    lines.push(format!("worst residual of an orbit {:.1e}", summary.worst_residual));
    lines.join("\n")
}

/// The commonest contacts and impacts of a reason.
fn obstructed(summary: &Summary, absence: Absence) -> impl Iterator<Item = String> {
    let of_reason = summary.obstructions.all().into_iter().filter(move |one| one.absence == absence);
    of_reason.take(MOST_TOLD).map(|Obstructed { contact, impact, cells, after: [from, to], .. }| {
        let later = if to > 0.0 { format!(", {from:.4} to {to:.4} of a period later") } else { String::new() };
        format!("      contact {contact} at impact {impact}{later}: {cells}")
    })
}

/// How fast it went.
pub(crate) fn speed(effort: &Effort) -> String {
    speed_on(effort, cores())
}

/// The same, on a machine of so many cores.
fn speed_on(effort: &Effort, cores: usize) -> String {
    let Effort { threads, computed_cells, wall_seconds } = *effort;
    // Threads that share a core do not each have one.
    let per_cell = wall_seconds * 1e6 * threads.min(cores) as f64 / computed_cells.max(1) as f64;
    let plural = if threads == 1 { "" } else { "s" };
    format!("{wall_seconds:.3} s on {threads} thread{plural}, {per_cell:.2} µs per cell and core")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn threads_beyond_the_cores_make_no_cell_dearer() {
        let told = |threads| speed_on(&Effort { threads, computed_cells: 1_000_000, wall_seconds: 1.5 }, 2);
        assert_eq!(told(1), "1.500 s on 1 thread, 1.50 µs per cell and core");
        assert_eq!(told(2), "1.500 s on 2 threads, 3.00 µs per cell and core");
        assert_eq!(told(200), "1.500 s on 200 threads, 3.00 µs per cell and core");
    }
}
