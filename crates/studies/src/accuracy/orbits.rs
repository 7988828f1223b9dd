//! Suite `orbits`: impulses, φ and ψ of breathers by the paper's procedure and by this program's.

use std::f64::consts::TAU;
use std::hint::black_box;

use vibrochain_breather::{Family, Finder, Orbit, OrbitList, breathers};
use vibrochain_lattice::{ImpulseResponse, Model, Point, Spectrum};
use vibrochain_truth::{DEFAULT_BITS, Real, TrueOrbit};

use crate::accuracy::meter::Meter;
use crate::accuracy::series::{Chi, Series};
use crate::accuracy::table::{Row, Table};
use crate::accuracy::{Suite, computation};
use vibrochain_cli::common::error::CliError;

pub(super) const SUITE: Suite = Suite {
    name: "orbits",
    title: "Breathers",
    prose: "Impulses of the two conservative families, and impulses, φ and ψ of a forced breather (A = 0.1, e = 0.9; N = \
            20, γ₁ = 0.2, γ₂ = 0.1, a = 0.4). The truth solves the conditions at the impacts in 57 digits.\n\n- *series*: \
            the paper's procedure with J harmonics. Under a force it samples 64 values of φ;\n- \
            *closed-form kernels*: the same with exact kernels;\n- *enclosures*: what the program does, with proof that \
            there are no more solutions.\n\nA scan finds only zeros whose sign changes show between its samples; the enclosures find all, under a force in less time.",
    error: "largest of the errors of the impulses (over the largest one), of φ over the period, of ψ over that of the force",
    run,
};

/// Name, family, ω, A, e.
const CASES: [(&str, Family, f64, f64, f64); 3] = [
    ("conservative double-sided, ω = 1.5", Family::DoubleSided, 1.5, 0.0, 1.0),
    ("conservative single-sided, ω = 0.85", Family::SingleSided, 0.85, 0.0, 1.0),
    ("forced double-sided, ω = 1.5", Family::DoubleSided, 1.5, 0.1, 0.9),
];

/// Values of φ at which a(φ) is looked at.
const SCAN: u32 = 64;

/// What a method says of an orbit: (time, impulse) of each impact, and ψ.
#[derive(Debug, Clone, PartialEq)]
struct Answer {
    impacts: Vec<(f64, f64)>,
    psi: Option<f64>,
}

impl Answer {
    fn of(orbit: &Orbit) -> Self {
        Self { impacts: orbit.impacts().iter().map(|impact| (impact.time, impact.impulse)).collect(), psi: orbit.psi() }
    }

    fn error(&self, truth: &TrueOrbit) -> f64 {
        let real = |x: f64| Real::new(x, DEFAULT_BITS);
        let off = |value: f64, truth: &Real| (truth - &real(value)).to_f64().abs();
        let period = truth.period().to_f64();
        let force_period = period / f64::from(truth.force_periods());
        let largest = truth.impacts().iter().map(|impact| impact.impulse.to_f64().abs()).fold(0.0, f64::max);
        let pairs = self.impacts.iter().zip(truth.impacts());
        let impacts = pairs
            .map(|(&(time, impulse), truth)| {
                (off(time, &truth.time) / period).max(off(impulse, &truth.impulse) / largest)
            })
            .fold(0.0, f64::max);
        let psi = self.psi.zip(truth.psi()).map_or(0.0, |(psi, truth)| {
            // A phase next to 0 may have come out next to the whole period.
            let off = off(psi, truth);
            off.min((off - force_period).abs()) / force_period
        });
        if impacts.is_finite() && psi.is_finite() { impacts.max(psi) } else { f64::INFINITY }
    }
}

fn run(meter: &mut Meter<'_>) -> Result<Table, CliError> {
    let lengths: &[u32] = if meter.is_quick() { &[10, 100] } else { &[10, 100, 1000, 2000, 10_000, 100_000] };
    let mut table = Table::default();
    for (case, family, omega, amplitude, e) in CASES {
        let ring = Point::ring(21).gamma1(0.2).gamma2(0.1);
        let model = ring.omega(omega).asymmetry(0.4).amplitude(amplitude).restitution(e).model()?;
        let orbits = breathers(&model, family).map_err(computation)?.orbits;
        let orbit = orbits.first().ok_or_else(|| computation(format!("no breather: {case}")))?;
        let truth = TrueOrbit::refine(orbit, DEFAULT_BITS).map_err(computation)?;
        let mut measure = |method: &str, setting: String, find: &mut dyn FnMut() -> Result<Vec<Answer>, CliError>| {
            meter.tell(case, method, &setting);
            let (answers, seconds) = meter.time(find)?;
            let error = answers.iter().map(|answer| answer.error(&truth)).fold(f64::INFINITY, f64::min);
            let (case, method) = (case.to_owned(), method.to_owned());
            // As wrong as can be.
            let (error, note) = if error < 1.0 { (error, count(answers.len())) } else { (1.0, "not found".to_owned()) };
            table.rows.push(Row { case, method, setting, seconds, error, note });
            Ok::<(), CliError>(())
        };
        for &terms in lengths {
            measure("series", format!("J = {terms}"), &mut || {
                let series = Series::new(black_box(model.chain()), omega, terms, 0);
                Ok(by_paper(&model, family, &|chi, phi| series.chi(chi, phi)))
            })?;
        }
        let (mut spectrum, mut response) = (Spectrum::new(*model.chain()), ImpulseResponse::vacant(model.chain()));
        measure("closed-form kernels", "no term left out".to_owned(), &mut || {
            spectrum.reset(*black_box(model.chain()));
            response.reset(&spectrum, omega).map_err(computation)?;
            Ok(by_paper(&model, family, &|chi, phi| match chi {
                Chi::One => -2.0 * response.value(0, phi),
                Chi::Two => -2.0 * response.value(0, 0.0),
                Chi::Three => 2.0 * response.derivative(0, phi),
            }))
        })?;
        // A finder that has met the chain before would be spared the setup that the others have.
        let (vacant, mut found) = (Finder::new(21), OrbitList::default());
        measure("enclosures", "all solutions".to_owned(), &mut || {
            vacant.clone().find(black_box(&model), family, &mut found).map_err(computation)?;
            Ok(found.orbits.iter().map(Answer::of).collect())
        })?;
    }
    Ok(table)
}

fn count(solutions: usize) -> String {
    if solutions == 1 { "1 solution".to_owned() } else { format!("{solutions} solutions") }
}

/// The paper's procedure with any kernels.
fn by_paper(model: &Model, family: Family, chi: &dyn Fn(Chi, f64) -> f64) -> Vec<Answer> {
    let (half, a) = (0.5 * model.period(), model.asymmetry());
    let answer = |impacts: &[(f64, f64)]| vec![Answer { impacts: impacts.to_vec(), psi: None }];
    let chi2 = chi(Chi::Two, 0.0);
    match (family, model.is_conservative()) {
        (Family::DoubleSided, true) => {
            let chi1 = chi(Chi::One, half);
            let (mean, part) = (1.0 / (chi2 - chi1), a / (chi1 + chi2));
            answer(&[(0.0, -2.0 * (mean + part)), (half, 2.0 * (mean - part))])
        }
        (Family::SingleSided, true) => answer(&[(0.0, 2.0 * (1.0 - a) / chi2)]),
        (Family::DoubleSided, false) => Forced { model, chi2, chi }.solutions(),
        _ => Vec::new(),
    }
}

/// The forced double-sided breather for given φ (paper, sec. II B, misprints mended).
struct Forced<'a> {
    model: &'a Model,
    chi2: f64,
    chi: &'a dyn Fn(Chi, f64) -> f64,
}

/// What belongs to a φ on one of the two branches of ψ.
#[derive(Debug, Clone, Copy)]
struct Branch {
    phi: f64,
    psi: f64,
    p1: f64,
    p2: f64,
    /// a(φ), the asymmetry that this φ belongs to.
    asymmetry: f64,
}

impl Forced<'_> {
    /// Both branches, where they exist.
    fn branches(&self, phi: f64) -> [Option<Branch>; 2] {
        let (omega, q) = (self.model.omega(), self.model.loss());
        let force = self.model.amplitude() / (self.model.chain().gamma1() - omega * omega);
        let (chi1, chi2, chi3) = ((self.chi)(Chi::One, phi), self.chi2, (self.chi)(Chi::Three, phi));
        let (sin, cos) = (omega * phi).sin_cos();
        let s = q * q + chi3 * chi3;
        let d = chi2 - chi1;
        // The positions' difference: P cos ωψ + Q sin ωψ = 2S/Ã.
        let p = s * (1.0 - cos) + omega * d * (q - chi3) * sin;
        let qq = s * sin + omega * d * ((q - chi3) * cos - (q + chi3));
        let opening = (2.0 * s / (p.hypot(qq) * force)).acos();
        [1.0, -1.0].map(|sign| {
            let angle = qq.atan2(p) + sign * opening;
            let (g0, g1) = (force * angle.cos(), force * (angle + omega * phi).cos());
            let (w0, w1) = (-force * omega * angle.sin(), -force * omega * (angle + omega * phi).sin());
            let (p1, p2) = ((chi3 * w0 - q * w1) / s, (q * w0 + chi3 * w1) / s);
            let asymmetry = 0.5 * ((p2 - p1) * (chi1 + chi2) + g0 + g1);
            // Without a real opening everything is NaN.
            asymmetry.is_finite().then(|| Branch { phi, psi: angle.rem_euclid(TAU) / omega, p1, p2, asymmetry })
        })
    }

    /// Where a(φ) = a changes sign between neighbours of a scan, refined by the secant in its bracket.
    fn solutions(&self) -> Vec<Answer> {
        let period = self.model.period();
        let at = |i: u32| self.branches(period * (f64::from(i) + 0.5) / f64::from(SCAN));
        let mut answers = Vec::new();
        let mut previous = at(0);
        for i in 1..SCAN {
            let current = at(i);
            for branch in 0..2 {
                if let (Some(low), Some(high)) = (previous[branch], current[branch])
                    && (self.excess(&low) < 0.0) != (self.excess(&high) < 0.0)
                    && let Some(root) = self.refine(branch, low, high)
                {
                    let impacts = vec![(0.0, -2.0 * root.p2), (root.phi, 2.0 * root.p1)];
                    answers.push(Answer { impacts, psi: Some(root.psi) });
                }
            }
            previous = current;
        }
        answers
    }

    fn excess(&self, branch: &Branch) -> f64 {
        branch.asymmetry - self.model.asymmetry()
    }

    /// Regula falsi, the weight of an end that stays put halved (Illinois).
    fn refine(&self, branch: usize, mut low: Branch, mut high: Branch) -> Option<Branch> {
        let (mut f_low, mut f_high) = (self.excess(&low), self.excess(&high));
        for _ in 0..80 {
            let phi = (low.phi * f_high - high.phi * f_low) / (f_high - f_low);
            let middle = self.branches(phi)[branch]?;
            let f = self.excess(&middle);
            if f == 0.0
                || (high.phi - low.phi).abs() < 4.0 * f64::EPSILON * high.phi
                || phi == low.phi
                || phi == high.phi
            {
                return Some(middle);
            }
            if (f < 0.0) == (f_low < 0.0) {
                (low, f_low) = (middle, f);
                f_high *= 0.5;
            } else {
                (high, f_high) = (middle, f);
                f_low *= 0.5;
            }
        }
        Some(high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_procedure_with_exact_kernels_finds_the_forced_breathers() {
        let ring = Point::ring(21).gamma1(0.2).gamma2(0.1);
        let model = ring.omega(1.5).asymmetry(0.4).amplitude(0.1).restitution(0.9).model().unwrap();
        let response = ImpulseResponse::new(&Spectrum::new(*model.chain()), 1.5).unwrap();
        let chi = |chi, phi| match chi {
            Chi::One => -2.0 * response.value(0, phi),
            Chi::Two => -2.0 * response.value(0, 0.0),
            Chi::Three => 2.0 * response.derivative(0, phi),
        };
        let answers = by_paper(&model, Family::DoubleSided, &chi);
        let orbits = breathers(&model, Family::DoubleSided).unwrap().orbits;
        assert!(!answers.is_empty() && answers.len() <= orbits.len());
        for answer in &answers {
            let near = |orbit: &&Orbit| {
                let pairs = answer.impacts.iter().zip(orbit.impacts());
                pairs
                    .clone()
                    .all(|((t, p), impact)| (t - impact.time).abs() < 1e-9 && (p - impact.impulse).abs() < 1e-9)
                    && (answer.psi.unwrap() - orbit.psi().unwrap()).abs() < 1e-9
            };
            assert_eq!(orbits.iter().filter(near).count(), 1, "{answer:?}");
        }
    }
}
