//! All breathers under a force of several harmonics. The plain cosine has its own, faster ways: `forced_single`,
//! `forced_double`.
//!
//! Single-sided, with U = 2pS₀ the static displacement, c = 1 + gK̂(0), l = qg/2:
//!
//! ```text
//! cU + G(ψ) = a − 1,   Ġ(ψ) + lU = 0        hence   cĠ(ψ) + l(a − 1 − G(ψ)) = 0 ,
//! ```
//!
//! an analytic function of one variable. So is D Ġ(ψ) + qG(ψ) − q, whose zeros are the double-sided orbits with φ = T/2
//! where those solve by themselves. All others with two impacts are zeros in the plane, `harmonic_impacts`.
//!
//! A force whose harmonics are all multiples of one repeats within the period T; ψ then runs over that repetition alone,
//! because orbits with other ψ are the same.

use vibrochain_lattice::simd::lanes::{LANES, Lane};
use vibrochain_lattice::{ImpulseResponse, Model, Wave};

use crate::error::NoBreather;
use crate::orbit::Draft;
use crate::roots::dual::{Algebra, Dual};
use crate::roots::interval::{Clearance, Enclosed, Zeros, one_by_one};
use crate::roots::planar::PlanarZeros;
use crate::search::families::conservative::single_sided_draft;
use crate::search::families::harmonic_impacts::HarmonicImpacts;
use crate::search::families::pattern::Pattern;
use crate::search::families::two_impacts::{SYMMETRIC, SYMMETRIC_GUARD, shortest_flight};

/// α Ġ(ψ) + β G(ψ) + γ.
struct Line<'a> {
    steady: &'a Wave,
    velocity: f64,
    displacement: f64,
    constant: f64,
}

impl Enclosed for Line<'_> {
    fn clearances(&self, phases: Lane, radii: Lane) -> [Clearance; LANES] {
        one_by_one(phases, radii, |psi, radius| self.enclose(psi, radius))
    }

    fn at(&self, psi: f64) -> (f64, f64) {
        self.enclose(psi, 0.0).at_centre()
    }
}

impl Line<'_> {
    fn enclose(&self, psi: f64, radius: f64) -> Dual {
        let mut sum = Dual::wave(0.0, 0.0, 0.0, 0.0, radius).shifted(self.constant);
        for term in self.steady.terms() {
            let (sin, cos) = (term.rate * psi + term.phase).sin_cos();
            let (g, v) = (self.displacement * term.amplitude, -self.velocity * term.rate * term.amplitude);
            sum = sum + Dual::wave(g * cos, g * sin, term.rate, g.abs(), radius);
            sum = sum + Dual::wave(v * sin, -v * cos, term.rate, v.abs(), radius);
        }
        sum
    }

    /// All zeros on one repetition of the force, each in 0 … `repeat`, appended to `zeros`.
    fn zeros(&self, repeat: f64, zeros: &mut Zeros) {
        let pieces = 8 + (repeat * self.steady.top_rate()) as usize;
        // A start that no symmetry puts a zero on.
        let start = -0.1234 * repeat;
        zeros.find(self, start, start + repeat, pieces, |_| 64.0 * f64::EPSILON * repeat);
        // The ends are one point.
        if let [first, .., last] = zeros.simple[..]
            && last - first >= repeat * (1.0 - 64.0 * f64::EPSILON)
        {
            zeros.simple.pop();
        }
    }
}

/// The least period of the force.
fn repetition(model: &Model) -> f64 {
    model.period() / f64::from(model.force().repetitions())
}

/// A chain whose force has a given motion.
#[derive(Clone, Copy)]
pub(crate) struct Forced<'a> {
    pub(crate) model: &'a Model,
    /// Of the orbit's period.
    pub(crate) response: &'a ImpulseResponse,
    /// The motion under the force alone.
    pub(crate) steady: &'a Wave,
}

impl Forced<'_> {
    /// The static stiffness, without which impacts on one barrier, whose impulses add up, drive the chain away.
    pub(crate) fn static_stiffness(&self) -> Result<f64, NoBreather> {
        let stiffness = self.response.static_stiffness();
        if stiffness == 0.0 { Err(NoBreather::NetImpulse) } else { Ok(stiffness) }
    }
}

/// The searches for zeros along a line and in the plane.
pub(crate) struct Searches<'a> {
    pub(crate) zeros: &'a mut Zeros,
    pub(crate) plane: &'a mut PlanarZeros,
}

impl Searches<'_> {
    /// Places of which neither search can tell.
    fn open(&self) -> usize {
        self.zeros.unresolved.len() + self.zeros.exhausted + self.plane.unresolved.len() + self.plane.exhausted
    }
}

/// None at all is an answer only if no place was left open.
pub(crate) fn outcome(count: usize, open: usize) -> Result<(), NoBreather> {
    if count + open == 0 { Err(NoBreather::NoPhase) } else { Ok(()) }
}

/// All single-sided solutions.
pub(crate) fn single_sided(
    forced: &Forced<'_>,
    zeros: &mut Zeros,
    mut found: impl FnMut(Draft),
) -> Result<(), NoBreather> {
    let &Forced { model, response, steady } = forced;
    let (q, g) = (model.loss(), forced.static_stiffness()?);
    let gap = 1.0 - model.asymmetry();
    let (c, l) = (1.0 + g * response.dynamic_at_impulse(), 0.5 * q * g);
    // Lengths and velocities on one footing.
    let (omega, loss) = (model.omega(), l / model.omega());
    let norm = c.hypot(loss);
    if !(norm > 0.0 && norm.is_finite()) {
        return Err(NoBreather::Singular);
    }
    let line = Line { steady, velocity: c / omega / norm, displacement: -loss / norm, constant: -loss / norm * gap };
    let repeat = repetition(model);
    line.zeros(repeat, zeros);
    let mut count = 0;
    for &psi in &zeros.simple {
        let [displacement, velocity, ..] = steady.jet(psi);
        let u = ((c / norm) * (-gap - displacement) - (loss / norm) * (velocity / omega)) / norm;
        let p = 0.5 * g * u;
        if p.is_finite() {
            count += 1;
            found(single_sided_draft(response, psi.rem_euclid(repeat), p, u));
        }
    }
    outcome(count, zeros.unresolved.len() + zeros.exhausted)
}

/// All double-sided solutions.
pub(crate) fn double_sided(
    forced: &Forced<'_>,
    searches: &mut Searches<'_>,
    mut found: impl FnMut(Draft),
) -> Result<(), NoBreather> {
    let &Forced { model, response, steady } = forced;
    let Searches { zeros, plane } = &mut *searches;
    let (omega, q, a) = (model.omega(), model.loss(), model.asymmetry());
    let pattern = Pattern::DOUBLE_SIDED;
    let problem = HarmonicImpacts::new(pattern, model, response, steady);
    let (half, repeat) = (0.5 * response.period(), repetition(model));
    let mut count = 0;
    let mut emit = |place: [f64; 2]| {
        let Some(draft) = draft(&problem, response, (pattern, repeat), place) else { return };
        count += 1;
        found(draft);
    };
    let edge = half - shortest_flight(response, steady.bound(1));
    let d = 2.0 * (response.dynamic_at_half() - response.dynamic_at_impulse());
    if q * a * (response.static_stiffness() * d).abs() <= SYMMETRIC {
        let norm = q.hypot(omega * d);
        let line = Line { steady, velocity: d / norm, displacement: q / norm, constant: -q / norm };
        line.zeros(repeat, zeros);
        zeros.simple.iter().for_each(|&psi| emit([0.0, psi + 0.5 * half]));
        problem.zeros(plane, -edge, -SYMMETRIC_GUARD * half, repeat);
        problem.zeros(plane, SYMMETRIC_GUARD * half, edge, repeat);
    } else {
        problem.zeros(plane, -edge, edge, repeat);
    }
    plane.simple.iter().for_each(|&place| emit(place));
    outcome(count, searches.open())
}

/// The orbit at a zero in the plane, if the conditions determine it.
fn draft(
    problem: &HarmonicImpacts<'_>,
    response: &ImpulseResponse,
    (pattern, repeat): (Pattern, f64),
    place: [f64; 2],
) -> Option<Draft> {
    let solution = problem.solution(place)?;
    let psi = (place[1] - 0.5 * (0.5 * response.period() + solution.delta)).rem_euclid(repeat);
    Some(solution.draft(response, pattern, psi))
}

/// All solutions with both impacts on one barrier, each begun at the impact that [`listed`] says.
pub(crate) fn alike(
    pattern: Pattern,
    forced: &Forced<'_>,
    searches: &mut Searches<'_>,
    mut found: impl FnMut(Draft),
) -> Result<(), NoBreather> {
    forced.static_stiffness()?;
    let &Forced { model, response, steady } = forced;
    let Searches { zeros, plane } = &mut *searches;
    let problem = HarmonicImpacts::new(pattern, model, response, steady);
    let (half, repeat) = (0.5 * response.period(), repetition(model));
    let [from, to] = listed(pattern, model, half);
    problem.zeros(plane, from, to, repeat);
    let mut middle = Vec::new();
    if pattern.turns_round() && model.loss() == 0.0 {
        // At δ = 0 all that is left is Ġ(ψ) = 0; half a repetition later the other impact begins.
        let line = Line { steady, velocity: 1.0 / model.omega(), displacement: 0.0, constant: 0.0 };
        line.zeros(repeat, zeros);
        let first = zeros.simple.first().copied().unwrap_or_default();
        zeros.simple.retain(|psi| *psi < first + 0.5 * repeat * (1.0 - SYMMETRIC_GUARD));
        middle.extend(zeros.simple.iter().map(|psi| [0.0, psi + 0.5 * half]));
    }
    let mut count = 0;
    for &place in plane.simple.iter().chain(&middle) {
        let Some(draft) = draft(&problem, response, (pattern, repeat), place) else { continue };
        count += 1;
        found(draft);
    }
    outcome(count, searches.open())
}

/// The δ of orbits with two impacts on one barrier, each of which solves twice, at δ and −δ: in one period of the force it begins with
/// the shorter flight, doubled with the longer one. Where δ = 0 solves by itself, with impacts alike that repeat after half the time or
/// without loss, it is left out.
pub(crate) fn listed(pattern: Pattern, model: &Model, half: f64) -> [f64; 2] {
    let (edge, guard) = (half * (1.0 - SYMMETRIC_GUARD), SYMMETRIC_GUARD * half);
    match pattern.turns_round() {
        true => [-edge, if model.loss() == 0.0 { -guard } else { 0.0 }],
        false => [guard, edge],
    }
}

#[cfg(test)]
mod tests {
    use vibrochain_lattice::{Chain, Force, Harmonic};
    use vibrochain_testkit::Random;

    use super::*;

    fn forced(random: &mut Random) -> Model {
        let harmonic = |number: u32, size: f64, random: &mut Random| Harmonic {
            number,
            amplitude: size * random.between(0.5, 1.0),
            phase: random.between(-3.0, 3.0),
        };
        let force =
            Force::new(&[harmonic(1, 0.3, random), harmonic(3, 0.3, random), harmonic(5, 0.2, random)]).unwrap();
        let chain = Chain::new(1 + random.below(4), random.between(0.2, 1.0), 0.1).unwrap();
        Model::conservative(chain, random.between(0.4, 1.8), 0.2).unwrap().point().under(&force).model().unwrap()
    }

    /// As many as there are changes of sign on a fine grid.
    #[test]
    fn all_zeros_of_a_wave_are_found_once() {
        let (mut random, mut count) = (Random(5), 0);
        for _ in 0..60 {
            let model = forced(&mut random);
            let Ok(steady) = model.steady_response() else { continue };
            let [velocity, displacement, constant] = [1.0, 1.0, 0.3].map(|size| random.between(-size, size));
            let line = Line { steady: &steady, velocity, displacement, constant };
            let (mut zeros, repeat) = (Zeros::default(), repetition(&model));
            line.zeros(repeat, &mut zeros);
            let value = |psi: f64| {
                let [place, speed, ..] = steady.jet(psi);
                velocity * speed + displacement * place + constant
            };
            let points = 4000;
            let at = |i: usize| value(repeat * (i as f64 + 0.37) / points as f64);
            let changes = (0..points).filter(|&i| (at(i) > 0.0) != (at(i + 1) > 0.0)).count();
            assert!(zeros.unresolved.is_empty() && zeros.exhausted == 0);
            assert_eq!(zeros.simple.len(), changes, "{model:?}");
            let size = velocity.abs() * steady.bound(1) + displacement.abs() * steady.bound(0) + constant.abs();
            assert!(zeros.simple.iter().all(|psi| value(*psi).abs() < 1e-12 * size), "{model:?}");
            count += changes;
        }
        assert!(count > 60, "{count}");
    }

    #[test]
    fn none_is_an_answer_only_where_no_place_is_open() {
        let (mut zeros, mut plane) = (Zeros::default(), PlanarZeros::default());
        zeros.unresolved.extend([0.1; 2]);
        zeros.exhausted += 3;
        plane.unresolved.extend([[0.1; 2]; 5]);
        plane.exhausted += 7;
        let searches = Searches { zeros: &mut zeros, plane: &mut plane };
        assert_eq!(searches.open(), 17);
        assert!(matches!(outcome(0, 0), Err(NoBreather::NoPhase)) && outcome(0, 1).is_ok() && outcome(1, 0).is_ok());
    }
}
