//! The orbits that branch off at a period doubling or a pitchfork, a small step away on the side where they exist.
//!
//! They are reached along their own branch, which leaves the bifurcation across the one that was followed and bends in the
//! parameter: no other orbit can be taken for them, and the bend tells the side.

use crate::events::bounded;
use vibrochain_breather::system::System;
use vibrochain_breather::{BranchPoint, ContactOrbit, Pace, SolutionCurve, SolutionPoint};

use super::answer::{BranchedOrbit, Branching, Event};
use super::ends::BranchEnds;
use super::switch::{bifurcation, shrinking};
use crate::verdict::Tolerance;

/// Lengths tried for the first step along the new branch, from the longest of all down to 1e-6, where rounding of the equations, divided by
/// the step, is as large as the bend.
const TRIES: i32 = 8;

/// As near as this part of the distance, the rest is Newton's method at a fixed parameter.
const ARRIVED: f64 = 0.05;

/// Two orbits whose values differ by this part of the distance are at one value.
const TOGETHER: f64 = 1e-9;

/// Bends at a step and at its half agree to this part where the curve is a parabola.
const PARABOLA: f64 = 0.2;

/// A small step away from an event, as a part of the parameter.
const AWAY: f64 = 1e-4;

impl BranchEnds {
    /// The orbits that branch off from one at a value, if it is known how they do: a small step away in the parameter where they reach that far,
    /// otherwise as near as they do.
    pub(super) fn branch_off(&mut self, event: Event, (orbit, value): (&ContactOrbit, f64)) -> Option<Branching> {
        let distance = AWAY * value.abs().max(1e-2 * self.range);
        let pair = event == Event::Pitchfork;
        let (mut branch, start) = self.leaving((orbit, value), &bifurcation(event, orbit)?).ok()?;
        let (length, bend) =
            shrinking(Pace::LONGEST, TRIES).find_map(|length| Some((length, bend(&mut branch, &start, length)?)))?;
        let ways = [start.clone(), start.reversed()];
        let mut points = [distance, bend.abs() * length * length].into_iter().find_map(|distance| {
            let points: Option<Vec<_>> = ways.iter().map(|way| reach(&mut branch, way, bend, distance)).collect();
            // Both of a pair at one value.
            let together =
                |points: &[BranchPoint]| (points[0].value() - points[1].value()).abs() <= TOGETHER * distance;
            points.filter(|points| !pair || together(points))
        })?;
        if !pair {
            // The two ways give one orbit, begun at other times.
            points.truncate(1);
        }
        let value = points.first()?.value();
        points.sort_by(|a, b| a.orbit().phi().unwrap_or(0.0).total_cmp(&b.orbit().phi().unwrap_or(0.0)));
        let (watcher, name) = (&mut self.others, self.name);
        let orbits = points.into_iter().map(|point| {
            let orbit = bounded(point.orbit());
            let physical = watcher.admissibility(&orbit).ok().map(|answer| answer.is_physical());
            let verdict = watcher.verdict(&orbit, Tolerance::Rounding).ok();
            Some(BranchedOrbit { physical, verdict, orbit: orbit.into_orbit(name).ok()? })
        });
        Some(Branching { value, above: bend > 0.0, orbits: orbits.collect::<Option<_>>()? })
    }
}

/// The point at `distance` in the parameter, on the side that the bend leads to.
fn reach<S: System>(
    branch: &mut SolutionCurve<S>,
    way: &SolutionPoint<S::Orbit>,
    bend: f64,
    distance: f64,
) -> Option<SolutionPoint<S::Orbit>> {
    let parabola = |moved: f64| (distance / moved).sqrt();
    let mut length = parabola(bend.abs()).min(Pace::LONGEST_TO_AN_END);
    for _ in 0..TRIES {
        let there = branch.step(way, length).ok()?;
        let moved = (there.value() - way.value()) * bend.signum();
        if (moved / distance - 1.0).abs() <= ARRIVED {
            // Next to a resonance there may be no telling orbits at one value apart; this one is as good.
            return branch.at(&there, way.value() + bend.signum() * distance).ok().or(Some(there));
        }
        let next = (length * parabola(moved)).min(Pace::LONGEST_TO_AN_END);
        // Folds back before, or bends less than it did; NaN where it went to the other side.
        if next.is_nan() || next == length {
            return None;
        }
        length = next;
    }
    None
}

/// κ of λ₀ + κσ², from lengths σ and σ/2, which need not know λ₀; `None` where the curve is no parabola yet.
fn bend<S: System>(branch: &mut SolutionCurve<S>, start: &SolutionPoint<S::Orbit>, length: f64) -> Option<f64> {
    let mut value = |part: f64| branch.step(start, part * length).ok().map(|point| point.value());
    let (whole, half, quarter) = (value(1.0)?, value(0.5)?, value(0.25)?);
    let (far, near) = ((whole - half) / 0.75, (half - quarter) / 0.1875);
    (far != 0.0 && (near / far - 1.0).abs() <= PARABOLA).then(|| near / (length * length))
}
