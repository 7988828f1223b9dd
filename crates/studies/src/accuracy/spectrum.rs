//! Suite `spectrum`: the leading Floquet multiplier by the dense ways and by those that use the structure.

use std::hint::black_box;

use vibrochain_breather::{Family, Finder, Orbit, breathers};
use vibrochain_floquet::{
    Analyser, Complex, DMatrix, FloquetError, Method as Path, Tolerance, eigenvalues, even_monodromy, full_monodromy,
};
use vibrochain_lattice::Point;
use vibrochain_truth::{Complex as TrueComplex, DEFAULT_BITS, Real, TrueOrbit, TrueSpectrum};

use crate::accuracy::meter::Meter;
use crate::accuracy::paper::{general_eigenvalues, general_monodromy_of};
use crate::accuracy::table::{Row, Table};
use crate::accuracy::{Suite, computation};
use vibrochain_cli::common::error::CliError;

pub(super) const SUITE: Suite = Suite {
    name: "spectrum",
    title: "Floquet multipliers",
    prose: "The leading non-trivial multiplier of three breathers on rings of N = 5, 20 and 100 (γ₁ = 0.2, γ₂ = 0.1, a = \
            0.4). The truth is a root of the secular determinant in 57 digits. Each method computes all multipliers it \
            has.\n\n- *general exponential*: the paper's way, exp(Aφ) by a general algorithm and eigenvalues of the dense \
            product;\n- *exact propagator, whole ring*: the same matrix with flights from the ring's cosine transform;\n- \
            *even subspace*: only modes even about the impacting mass: half the dimension;\n- *reversible block*: half of \
            that again, with the trivial pair removed exactly;\n- *secular function*: all multipliers as zeros of a scalar \
            function. This is what `mapgen orbit` does, unless a certificate fails; then there is no line.\n\nA dense \
            solver splits the trivial pair of a conservative orbit by the square root of rounding (last column).",
    error: "distance of the leading non-trivial multiplier μ from the true one",
    run,
};

/// Work space that a sweep would keep from orbit to orbit.
struct Tools {
    finder: Finder,
    analyser: Analyser,
    dense: Analyser,
}

impl Tools {
    fn new(sites: usize) -> Self {
        Self { finder: Finder::new(sites), analyser: Analyser::default(), dense: Analyser::dense() }
    }
}

/// All multipliers a method finds, those of the trivial pair included if it has them; `None` where it does not apply.
type Method = fn(&Orbit, &mut Tools) -> Option<Result<Vec<Complex<f64>>, CliError>>;

const METHODS: &[(&str, Method)] = &[
    ("general exponential", |orbit, _| {
        let found = general_eigenvalues(general_monodromy_of(orbit.lattice().ok()?));
        Some(found.ok_or_else(|| computation("the eigenvalues of a general monodromy matrix did not come out")))
    }),
    ("exact propagator, whole ring", |orbit, _| Some(dense(full_monodromy(orbit)))),
    ("even subspace", |orbit, _| Some(dense(even_monodromy(orbit)))),
    ("reversible block", |orbit, tools| {
        orbit.is_reversible().then(|| {
            let answer = tools.dense.stability(orbit, &mut tools.finder, Tolerance::Rounding);
            answer.map(|answer| answer.multipliers).map_err(computation)
        })
    }),
    ("secular function", |orbit, tools| {
        match tools.analyser.stability(orbit, &mut tools.finder, Tolerance::Rounding) {
            Ok(answer) => (answer.verdict.method == Path::Secular).then_some(Ok(answer.multipliers)),
            Err(error) => Some(Err(computation(error))),
        }
    }),
];

/// The orbits: family, ω, A, e; γ₁ = 0.2, γ₂ = 0.1, a = 0.4.
const CASES: [(&str, Family, f64, f64, f64); 3] = [
    ("conservative double-sided, ω = 1.5", Family::DoubleSided, 1.5, 0.0, 1.0),
    ("conservative single-sided, ω = 0.8", Family::SingleSided, 0.8, 0.0, 1.0),
    ("forced double-sided, ω = 1.5, A = 0.1, e = 0.9", Family::DoubleSided, 1.5, 0.1, 0.9),
];

fn run(meter: &mut Meter<'_>) -> Result<Table, CliError> {
    let mut table = Table::default();
    let sizes: &[usize] = if meter.is_quick() { &[5] } else { &[5, 20, 100] };
    for (case, family, omega, amplitude, e) in CASES {
        for &n in sizes {
            let ring = Point::ring(n + 1).gamma1(0.2).gamma2(0.1);
            let model = ring.omega(omega).asymmetry(0.4).amplitude(amplitude).restitution(e).model()?;
            let orbits = breathers(&model, family).map_err(computation)?.orbits;
            let orbit = orbits.first().ok_or_else(|| computation(format!("no breather: {case}, N = {n}")))?;
            let mut tools = Tools::new(n + 1);
            let truth = truth(orbit, &mut tools)?;
            for &(method, multipliers) in METHODS {
                let setting = format!("N = {n}");
                meter.tell(case, method, &setting);
                if multipliers(orbit, &mut tools).is_none() {
                    continue;
                }
                let all = || multipliers(black_box(orbit), &mut tools).unwrap_or_else(|| Ok(Vec::new()));
                let (found, seconds) = meter.time(all)?;
                let error = distance(&found, &truth);
                let note = if model.is_conservative() { trivial_pair(&found) } else { String::new() };
                table.rows.push(Row {
                    case: case.to_owned(),
                    method: method.to_owned(),
                    setting,
                    seconds,
                    error,
                    note,
                });
            }
        }
    }
    Ok(table)
}

/// The leading non-trivial multiplier (one of those of largest modulus) in many digits.
fn truth(orbit: &Orbit, tools: &mut Tools) -> Result<TrueComplex, CliError> {
    let verdict = tools.dense.verdict(orbit, &mut tools.finder, Tolerance::Rounding).map_err(computation)?;
    let exact = TrueOrbit::refine(orbit, DEFAULT_BITS).map_err(computation)?;
    let spectrum = TrueSpectrum::new(&exact).map_err(computation)?;
    let (multiplier, moved) = spectrum.refine((verdict.leading.re, verdict.leading.im)).map_err(computation)?;
    // A multiplier that came from elsewhere would be another one.
    if moved > 1e-6 {
        return Err(computation(format!("no true multiplier near {}", verdict.leading)));
    }
    Ok(multiplier)
}

/// Distance of the nearest of `found` from the truth.
fn distance(found: &[Complex<f64>], truth: &TrueComplex) -> f64 {
    let off = |value: f64, truth: &Real| (truth - &Real::new(value, DEFAULT_BITS)).to_f64();
    found.iter().map(|mu| off(mu.re, &truth.re).hypot(off(mu.im, &truth.im))).fold(f64::INFINITY, f64::min)
}

fn dense(matrix: Result<DMatrix<f64>, FloquetError>) -> Result<Vec<Complex<f64>>, CliError> {
    let mut values = Vec::new();
    eigenvalues(&matrix.map_err(computation)?, &mut values).map_err(computation)?;
    Ok(values)
}

/// How far the two multipliers nearest to 1 are from it: a conservative orbit has μ = 1 twice, exactly.
fn trivial_pair(found: &[Complex<f64>]) -> String {
    let mut distances: Vec<f64> = found.iter().map(|mu| (mu - 1.0).norm()).collect();
    distances.sort_by(f64::total_cmp);
    match distances.get(1) {
        Some(0.0) => "trivial pair taken out beforehand".to_owned(),
        Some(split) => format!("trivial pair off by {split:.0e}"),
        None => String::new(),
    }
}
