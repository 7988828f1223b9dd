//! An event of a structure's orbits, followed through a window of two numbers of the structure.
//!
//! The orbit's equations with the event's test function are one system with the second number free: a branch of its solutions is the curve.

use nalgebra::Complex;
use vibrochain_breather::line::{Line, Step, chord_error, joined, side_ahead, trace};
use vibrochain_breather::system::{System, Vector, unit};
use vibrochain_breather::{
    BranchError, Manifold, ManifoldPoint, Obstruction, StructureContinuation, StructureFamily, StructureOrbit,
    structure_admissibility,
};
use vibrochain_lattice::Stop;

use super::diagram::{FAINT, TOUCHES, UNBOUNDED, resonance_at, strength};
use super::event::{AtEvent, EventSystem};
use super::stability::multipliers_there;
use super::test_function::{Test, minus_one, speed};
use crate::bracket::crossing;
use crate::curve::{CurveEnd, CurveError, CurvePoint, EventCurve, Special, SpecialPoint};
use crate::locate::{Event, Evidence, Located};

/// From where an event was located the curve is no farther than this.
const START: f64 = 1e-3;

/// What holds symmetric orbits together, in units of their equations, is no more than this: rounding.
const PUSHED: f64 = 1e-8;

/// Points as near as this are one.
const SAME: f64 = 1e-6;

/// A curve of an event of a structure's orbits.
pub type StructureCurve = EventCurve<StructureOrbit>;

/// A rectangle in the plane of two numbers of a structure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StructureWindow {
    /// Least values.
    pub from: [f64; 2],
    /// Largest values.
    pub to: [f64; 2],
}

impl StructureWindow {
    /// A place as parts of both sides.
    #[must_use]
    pub fn parts(&self, values: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|i| (values[i] - self.from[i]) / (self.to[i] - self.from[i]))
    }

    fn holds(&self, values: [f64; 2]) -> bool {
        (0..2).all(|i| (self.from[i]..=self.to[i]).contains(&values[i]))
    }
}

type Foot = ManifoldPoint<AtEvent, 1>;

/// Values of both numbers.
fn values(foot: &Foot) -> [f64; 2] {
    let z = foot.coordinates();
    [z[z.len() - 2], z[z.len() - 1]]
}

/// Something that happens on a curve where its value changes the sign.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Monitor {
    special: Special,
    /// Which of several of one kind.
    which: usize,
    value: f64,
}

struct Way<'a> {
    manifold: &'a mut Manifold<EventSystem, 1>,
    test: Test,
    event: Event,
    window: StructureWindow,
    first: f64,
    monitors: Vec<Monitor>,
    special: Vec<(usize, Special, f64)>,
    why: BranchError,
}

/// Follows the event that was located, of orbits of `family` at two values, both ways through a window. A straight line between neighbouring
/// points is no farther than `tolerance` from the curve, as a part of the window's sides.
///
/// # Errors
/// [`CurveError`]. What stops the curve on its way is its end, not an error.
pub fn structure_curve(
    located: &Located<StructureOrbit>,
    family: &StructureFamily,
    start: [f64; 2],
    window: StructureWindow,
    tolerance: f64,
    stop: &Stop,
) -> Result<StructureCurve, CurveError> {
    let StructureWindow { from, to } = window;
    if !((0..2).all(|i| from[i] < to[i]) && window.holds(start)) {
        let message = format!("the start {start:?} is not in the window from {from:?} to {to:?}");
        return Err(BranchError::Model(message).into());
    }
    if !(1e-12..=0.01).contains(&tolerance) {
        return Err(CurveError::Tolerance(tolerance));
    }
    let (orbit, event) = (&located.orbit, located.event);
    let (test, mark) = test_of(located).ok_or(CurveError::NotThere(event))?;
    let sides = [0, 1].map(|i| to[i] - from[i]);
    let mut base = StructureContinuation::through(orbit, family.clone(), &start, &sides, stop)?;
    let origin = base.origin()?;
    let mut manifold = Manifold::<EventSystem, 1>::of(EventSystem::new(base, test, &origin, mark));
    let z = manifold.system().origin()?;
    let last = z.len() - 1;
    // Where the curve stands still in one number it moves in the other.
    let first = manifold.correct(&z, &[unit(z.len(), last)], START, false);
    let first = first.or_else(|_| manifold.correct(&z, &[unit(z.len(), last - 1)], START, false));
    stop.heard()?;
    let first = first.map_err(|_| CurveError::NotThere(event))?;
    // μ, which is 0 as long as both numbers keep the symmetry.
    if test == Test::One && z.len() > origin.len() && first.tangents()[0][origin.len() - 2].abs() > PUSHED {
        let message = "orbits of this symmetry, which they lose here, exist at no other value of one of the two numbers: no curve passes";
        return Err(BranchError::Model(message.to_owned()).into());
    }
    let strongest = strength(&first.orbit().orbit);
    let mut follow = |foot: Foot| {
        let mut way = Way {
            manifold: &mut manifold,
            test,
            event,
            window,
            first: strongest,
            monitors: Vec::new(),
            special: Vec::new(),
            why: BranchError::NoConvergence,
        };
        way.monitors = way.monitored(&foot);
        let (feet, end) = trace(&mut way, foot, tolerance);
        (feet, way.special, end)
    };
    let (behind, special_behind, end_behind) = follow(first.reversed());
    let (ahead, special_ahead, end) =
        if end_behind == CurveEnd::Closed { (vec![first], Vec::new(), CurveEnd::Closed) } else { follow(first) };
    stop.heard()?;
    let before = behind.len();
    let feet = joined(behind, ahead);
    let behind = special_behind.into_iter().map(|(at, special, error)| (before - 1 - at, special, error));
    let ahead = special_ahead.into_iter().map(|(at, special, error)| (before - 1 + at, special, error));
    let mut special: Vec<SpecialPoint> = behind
        .chain(ahead)
        .map(|(point, special, error)| SpecialPoint { special, point, values: values(&feet[point]), error })
        .collect();
    special.sort_by_key(|one| one.point);
    let points = feet.iter().map(|foot| described(&mut manifold, foot, test)).collect();
    Ok(EventCurve {
        event,
        evidence: located.evidence,
        points,
        special,
        ends: [end_behind, end],
        evaluations: manifold.evaluations(),
        spectra: 0,
    })
}

/// What vanishes at an event that was located, and its mark there.
fn test_of(located: &Located<StructureOrbit>) -> Option<(Test, Option<f64>)> {
    let orbit = &located.orbit;
    Some(match (located.event, located.evidence) {
        (Event::Pitchfork, _) if orbit.is_conservative() => (Test::AnotherOne, None),
        (Event::Fold | Event::Pitchfork, _) => (Test::One, None),
        (Event::PeriodDoubling, _) => (Test::MinusOne, None),
        (Event::NeimarkSacker, Evidence::Multiplier(mu)) => {
            let lossless = orbit.model().structure().is_lossless();
            (if lossless { Test::Collision } else { Test::Circle }, Some(mu.arg().abs()))
        }
        (Event::Grazing, Evidence::Impact(i)) => (Test::Velocity(i), None),
        (Event::Grazing, Evidence::Touch(touch)) => {
            (Test::Touch(touch.site, touch.barrier), Some(touch.time / orbit.period()))
        }
        _ => return None,
    })
}

impl Way<'_> {
    /// What changes its sign where something else happens.
    fn monitored(&self, foot: &Foot) -> Vec<Monitor> {
        let AtEvent { orbit, mark, determinant } = foot.orbit();
        let mut monitors = Vec::new();
        let mut add = |special, which, value| monitors.push(Monitor { special, which, value });
        for (i, impact) in orbit.impacts().iter().enumerate() {
            if self.test != Test::Velocity(i) {
                add(
                    Special::With(Event::Grazing),
                    1 + i,
                    impact.barrier.sign() * impact.velocity_before / speed(orbit),
                );
            }
        }
        let own = if self.event == Event::Grazing { TOUCHES } else { 0.0 };
        if let Some(margin) = structure_admissibility(orbit).ok().and_then(|told| told.margin) {
            add(Special::With(Event::Grazing), 0, margin * orbit.model().omega() / speed(orbit) + own);
        }
        if self.test != Test::One {
            add(Special::With(Event::Fold), 0, *determinant);
        }
        if self.test != Test::MinusOne {
            add(Special::With(Event::PeriodDoubling), 0, minus_one(orbit));
        }
        if let (Test::Circle | Test::Collision, Some(theta)) = (self.test, *mark) {
            add(Special::OneToThree, 0, theta.cos() + 0.5);
            add(Special::OneToFour, 0, theta.cos());
        }
        self.multipliers(orbit, &mut add);
        monitors
    }

    /// Another multiplier where the curve's own is, and pairs on the circle.
    fn multipliers(&self, orbit: &StructureOrbit, add: &mut dyn FnMut(Special, usize, f64)) {
        // An impact without velocity leaves no multiplier that could be told.
        if matches!(self.test, Test::Velocity(_)) || orbit.model().structure().is_lossless() {
            return;
        }
        // Where multipliers cannot be computed no special point is reported; the curve itself does not need them.
        let Some(values) = multipliers_there(orbit) else { return };
        let own = match self.test {
            Test::One => Some((1.0, Special::OneToOne)),
            Test::MinusOne => Some((-1.0, Special::OneToTwo)),
            _ => None,
        };
        if let Some((goal, strong)) = own {
            let distance = |mu: &Complex<f64>| (mu - goal).norm();
            let nearest = values.iter().map(distance).fold(f64::INFINITY, f64::min);
            let rest = values.iter().filter(|mu| distance(mu) > nearest);
            add(strong, 0, rest.map(|mu| (mu - goal) / (1.0 + mu.norm())).product::<Complex<f64>>().re);
        }
        let upper = values.iter().filter(|mu| mu.im > 0.0);
        let mut growths: Vec<f64> = upper.map(|mu| mu.norm().ln()).collect();
        if self.test == Test::Circle {
            let own = growths.iter().map(|growth| growth.abs()).fold(f64::INFINITY, f64::min);
            growths.retain(|growth| growth.abs() > own);
        }
        growths.sort_by(|a, b| b.total_cmp(a));
        growths.into_iter().enumerate().for_each(|(k, growth)| add(Special::With(Event::NeimarkSacker), k, growth));
    }

    /// Where on a step a monitor vanishes.
    fn located(&mut self, from: &Foot, length: f64, monitor: Monitor, last: f64) -> Option<(Foot, f64)> {
        let at = |way: &mut Self, s: f64| -> Option<f64> {
            let foot = way.manifold.step(from, s).ok()?;
            way.monitored(&foot).into_iter().find(|one| one.is(&monitor)).map(|one| one.value)
        };
        let (s, error) = crossing([monitor.value, last], length, |s| at(self, s))?;
        Some((self.manifold.step(from, s).ok()?, error))
    }
}

impl Monitor {
    fn is(&self, other: &Self) -> bool {
        (self.special, self.which) == (other.special, other.which)
    }
}

impl Line for Way<'_> {
    type Point = Foot;
    type End = CurveEnd;

    const CLOSED: CurveEnd = CurveEnd::Closed;
    const LONG: CurveEnd = CurveEnd::Long;

    fn ahead(&mut self, passed: &[Foot], length: f64) -> Option<Step<Foot, CurveEnd>> {
        let last = passed.last()?;
        let next = match self.manifold.step(last, length) {
            // Symmetry is lost with the numbers themselves: no symmetric orbits are there that could lose it.
            Ok(next) if self.test == Test::One && next.orbit().mark.is_some_and(|push| push.abs() > PUSHED) => {
                return None;
            }
            Ok(next) => next,
            Err(why) => {
                self.why = why;
                return None;
            }
        };
        if self.window.holds(values(&next)) {
            return Some(Step::On(next));
        }
        let [here, there] = [last, &next].map(|foot| self.window.parts(values(foot)));
        let (which, goal, share) = side_ahead(here, [there[0] - here[0], there[1] - here[1]])?;
        let mut z: Vector =
            last.coordinates().iter().zip(next.coordinates()).map(|(a, b)| a + share * (b - a)).collect();
        let place = z.len() - 2 + which;
        z[place] = if goal > 0.0 { self.window.to[which] } else { self.window.from[which] };
        // The row heads the way of the step.
        let row = unit(z.len(), place).iter().map(|x| x * (2.0 * goal - 1.0)).collect();
        let edge = self.manifold.correct(&z, &[row], START.max(length), false);
        Some(Step::Out(edge.ok(), CurveEnd::Edge))
    }

    fn bend(&self, through: [&Foot; 3]) -> f64 {
        let [a, b, c] = through;
        let lengths = [self.manifold.distance(a, b), self.manifold.distance(b, c)];
        chord_error(through.map(|foot| self.window.parts(values(foot))), lengths)
    }

    fn closed(&mut self, passed: &[Foot], next: &Foot) -> Option<Foot> {
        let (start, last) = (passed.first()?, passed.last()?);
        if passed.len() < 3 {
            return None;
        }
        let (to_start, to_next) = (self.manifold.length_between(last, start), self.manifold.length_between(last, next));
        if !(0.0 < to_start && to_start <= to_next) {
            return None;
        }
        let there = self.manifold.step(last, to_start).ok()?;
        (self.manifold.distance(&there, start) <= SAME).then(|| start.clone())
    }

    fn pass(&mut self, passed: &mut Vec<Foot>, next: Foot) {
        let monitors = self.monitored(&next);
        if let Some(last) = passed.last().cloned() {
            let length = self.manifold.length_between(&last, &next);
            let mut found: Vec<(f64, Foot, Special, f64)> = Vec::new();
            for before in self.monitors.clone() {
                let Some(after) = monitors.iter().find(|one| one.is(&before)) else { continue };
                if (before.value > 0.0) == (after.value > 0.0) {
                    continue;
                }
                if let Some((foot, error)) = self.located(&last, length, before, after.value) {
                    found.push((self.manifold.length_between(&last, &foot), foot, before.special, error));
                }
            }
            found.sort_by(|a, b| a.0.total_cmp(&b.0));
            for (_, foot, special, error) in found {
                self.special.push((passed.len(), special, error));
                passed.push(foot);
            }
            // Two folds meet where the curve turns back in both numbers.
            if self.event == Event::Fold
                && let [.., one, two] = &passed[..]
            {
                let [a, b, c] = [one, two, &next].map(|foot| self.window.parts(values(foot)));
                if (b[0] - a[0]) * (c[0] - b[0]) + (b[1] - a[1]) * (c[1] - b[1]) < 0.0 {
                    self.special.push((passed.len() - 1, Special::Cusp, length));
                }
            }
        }
        self.monitors = monitors;
        passed.push(next);
    }

    fn ended(&mut self, passed: &mut Vec<Foot>) -> Option<CurveEnd> {
        let AtEvent { orbit, mark, .. } = passed.last()?.orbit();
        // Along a grazing the only impact has no impulse anywhere.
        let strength = if matches!(self.test, Test::Velocity(_)) { self.first } else { strength(orbit) };
        if strength > UNBOUNDED * self.first {
            return Some(CurveEnd::Unbounded);
        }
        if strength < FAINT * self.first {
            return Some(CurveEnd::ImpulsesVanish);
        }
        let theta = mark.filter(|_| matches!(self.test, Test::Circle | Test::Collision))?;
        if theta <= 0.0 {
            return Some(CurveEnd::Special(Special::OneToOne));
        }
        (theta >= std::f64::consts::PI).then_some(CurveEnd::Special(Special::OneToTwo))
    }

    fn lost(&self, passed: &[Foot]) -> CurveEnd {
        let resonance = passed.last().and_then(|foot| resonance_at(&foot.orbit().orbit));
        resonance.map_or_else(|| CurveEnd::Lost(self.why.clone()), CurveEnd::Resonance)
    }
}

fn described(manifold: &mut Manifold<EventSystem, 1>, foot: &Foot, test: Test) -> CurvePoint<StructureOrbit> {
    let AtEvent { orbit, mark, .. } = foot.orbit();
    let physical = structure_admissibility(orbit).ok().map(|told| match told.obstruction {
        None => true,
        Some(Obstruction::Crossing { excess, .. }) => excess <= TOUCHES * speed(orbit) / orbit.model().omega(),
        Some(Obstruction::WrongSign { velocity_before, .. }) => velocity_before.abs() <= TOUCHES * speed(orbit),
    });
    let angle =
        mark.filter(|_| matches!(test, Test::Circle | Test::Collision)).map(|theta| theta / std::f64::consts::PI);
    CurvePoint { values: values(foot), error: error(manifold.system(), foot), orbit: orbit.clone(), angle, physical }
}

/// What rounding does to both numbers, in units of the window's sides.
fn error(system: &mut EventSystem, foot: &Foot) -> f64 {
    let z = foot.coordinates();
    let mut of = || {
        let here = system.evaluate(z).ok()?;
        let bordered = system.bordered(z, &here, foot.tangents()).ok()?.transposed();
        let of_number = |place: usize| {
            let row = bordered.solve(&unit(z.len(), place))?;
            Some(row.iter().zip(&here.kept).map(|(row, error)| row.abs() * error).sum::<f64>())
        };
        Some(of_number(z.len() - 2)?.hypot(of_number(z.len() - 1)?))
    };
    of().unwrap_or(f64::INFINITY)
}
