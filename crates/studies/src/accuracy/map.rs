//! Suite `map`: classes of the paper's map by its own procedure and by the closed forms.

use vibrochain_breather::Family;
use vibrochain_floquet::Tolerance;
use vibrochain_lattice::{Chain, Model};

use crate::accuracy::Suite;
use crate::accuracy::meter::Meter;
use crate::accuracy::paper::{BLUR, Kernels};
use crate::accuracy::table::{Row, Table};
use vibrochain_cli::common::error::CliError;
use vibrochain_maps::cell::{Class, Status, Task, Worker};

pub(super) const SUITE: Suite = Suite {
    name: "map",
    title: "A map",
    prose: "The paper's conservative map at N = 20 (γ₁ = 0.2, a = 0.4) on a coarse grid: which breather exists in a cell, \
            and whether it is stable. The truth is this program's map, so that its own rows are 0 by definition; the suite `spectrum` compares its multipliers with 57 digits.\n\n- *series and samples*: the paper's formulas as printed, J harmonics, 64 samples a period;\n- *series and general exponential*: the same, then the \
            monodromy matrix by a general exponential; stable if none grows by more than 1e-5 a period;\n- *closed form \
            and general exponential*: that with exact kernels;\n- *closed form*: what `mapgen sweep` does.\n\nA thousand \
            harmonics are enough for existence. For stability 2000 are not: next to grazing saltation is \
            large. The trivial pair splits, and the split counts as growth.",
    error: "share of the cells with the wrong class",
    run,
};

/// What a method says of a cell: the breather, and whether it is stable.
type Answer = Option<(Family, bool)>;

fn run(meter: &mut Meter<'_>) -> Result<Table, CliError> {
    let (columns, rows) = if meter.is_quick() { (15, 10) } else { (100, 60) };
    let mut models = Vec::new();
    for j in 1..=rows {
        for i in 0..columns {
            let omega = 0.4 + 2.6 * f64::from(i) / f64::from(columns - 1);
            let chain = Chain::new(21, 0.2, 0.3 * f64::from(j) / f64::from(rows))?;
            models.push(Model::conservative(chain, omega, 0.4)?);
        }
    }
    let mut worker = Worker::new(21);
    let task = |stability| Task {
        families: vec![Family::DoubleSided, Family::SingleSided],
        words: Vec::new(),
        symmetric: false,
        stability,
        tolerance: Tolerance::Rounding,
        collisions: false,
        impulse: false,
    };
    let (with_stability, existence) = (task(true), task(false));
    // Cells whose class the closed form does not give are left out.
    let truth: Vec<Answer> = {
        let mut known = Vec::new();
        let mut answers = Vec::new();
        for model in models {
            let cell = worker.cell(&model, &with_stability);
            if let (Some(class), Status::Ok) = (cell.class, cell.status) {
                known.push(model);
                answers.push(answer(class));
            }
        }
        models = known;
        answers
    };
    let mut table = Table::default();
    let mut measure = |case: &str, method: &str, setting: String, classify: &mut dyn FnMut(&Model) -> Answer| {
        meter.tell(case, method, &setting);
        let (found, seconds) = meter.time(|| {
            let cells = models.iter().map(|model| meter.go_on().map(|()| classify(model)));
            cells.collect::<Result<Vec<Answer>, CliError>>()
        })?;
        let pairs = || found.iter().zip(&truth);
        let other_family = pairs().filter(|(found, truth)| family(found) != family(truth)).count();
        // Same breather, other verdict.
        let mistaken = |stable| {
            let same = pairs().filter(|(found, truth)| found != truth && family(found) == family(truth));
            same.filter(|(_, truth)| truth.is_some_and(|truth| truth.1 == stable)).count()
        };
        let (wrong, note) = if case == EXISTENCE {
            (other_family, format!("{other_family} of {} cells", truth.len()))
        } else {
            let (stable, unstable) = (mistaken(true), mistaken(false));
            let note = format!(
                "of {} cells: existence {other_family}, stable taken for unstable {stable}, unstable for stable {unstable}",
                truth.len()
            );
            (other_family + stable + unstable, note)
        };
        let cells = truth.len().max(1) as f64;
        let (case, method) = (case.to_owned(), method.to_owned());
        let (seconds, error) = (seconds / cells, wrong as f64 / cells);
        table.rows.push(Row { case, method, setting, seconds, error, note });
        Ok::<(), CliError>(())
    };
    let (lengths, fewer): (&[u32], &[u32]) = if meter.is_quick() {
        (&[3, 100], &[3, 100])
    } else {
        (&[10, 30, 100, 300, 1000, 2000], &[10, 100, 1000, 2000])
    };
    for &terms in lengths {
        let mut classify = |model: &Model| Kernels::by_series(model, terms).family(model).map(|family| (family, true));
        measure(EXISTENCE, "series and samples", format!("J = {terms}"), &mut classify)?;
    }
    let mut ours = |model: &Model, task: &Task| worker.cell(model, task).class.and_then(answer);
    measure(EXISTENCE, "closed form", "no term left out".to_owned(), &mut |model| ours(model, &existence))?;
    for &terms in fewer {
        let mut classify = |model: &Model| general(model, &Kernels::by_series(model, terms));
        measure(STABILITY, "series and general exponential", format!("J = {terms}"), &mut classify)?;
    }
    measure(STABILITY, "closed form and general exponential", "no term left out".to_owned(), &mut |model| {
        general(model, &Kernels::closed(model)?)
    })?;
    measure(STABILITY, "closed form", "no term left out".to_owned(), &mut |model| ours(model, &with_stability))?;
    Ok(table)
}

const EXISTENCE: &str = "existence";
const STABILITY: &str = "existence and stability";

fn family(answer: &Answer) -> Option<Family> {
    answer.map(|(family, _)| family)
}

fn answer(class: Class) -> Answer {
    match class {
        // Words are not among the families of this study.
        Class::None | Class::StableWord | Class::UnstableWord | Class::Word => None,
        Class::StableDouble | Class::Double => Some((Family::DoubleSided, true)),
        Class::StableSingle | Class::Single => Some((Family::SingleSided, true)),
        Class::UnstableDouble => Some((Family::DoubleSided, false)),
        Class::UnstableSingle => Some((Family::SingleSided, false)),
    }
}

/// Existence by samples, stability by the dense multipliers. Without eigenvalues the breather does not count as stable.
fn general(model: &Model, kernels: &Kernels) -> Answer {
    let family = kernels.family(model)?;
    let radius = kernels.spectral_radius(model, family);
    Some((family, radius.is_some_and(|radius| radius <= 1.0 + BLUR)))
}
