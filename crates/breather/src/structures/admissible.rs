//! Is an orbit of a structure physical? Every contact must stay inside its barriers between its impacts: decided by bounds, not samples.
//!
//! With d the distance to a barrier and B ≥ |g″| on the rest of a flight, d stays positive until the root of d + d′h − Bh²/2: steps to these
//! roots pass no contact.

use vibrochain_lattice::Barrier;

use super::error::StructureOrbitError;
use super::flight::StructureMotion;
use super::orbit::StructureOrbit;
use crate::admissible::answer::{Admissibility, Approach, Obstruction};

/// Distances below this part of a contact's reach are a touch.
const TOUCH: f64 = 1e-13;

/// Impacts closer than this part of the period are at one instant.
const TOGETHER: f64 = 1e-12;

/// Steps for one contact in one flight; a graze of 1e-13 takes some dozens.
const MOST_STEPS: usize = 2_000_000;

/// Whether an orbit is physical, with the least distance at a turning point or what is in the way; contacts stand in place of sites.
///
/// # Errors
/// [`StructureOrbitError`] at a resonance.
pub fn structure_admissibility(orbit: &StructureOrbit) -> Result<Admissibility, StructureOrbitError> {
    let impacts = orbit.impacts();
    for (number, impact) in impacts.iter().enumerate() {
        if impact.barrier.sign() * impact.velocity_before <= 0.0 {
            let obstruction = Obstruction::WrongSign {
                impact: number,
                site: impact.contact,
                time: impact.time,
                velocity_before: impact.velocity_before,
            };
            return Ok(Admissibility { margin: None, obstruction: Some(obstruction), closest: None });
        }
    }
    let motion = StructureMotion::new(orbit)?;
    let mut closest: Option<(f64, Approach)> = None;
    let together = TOGETHER * orbit.period();
    // Those that are hit come first: the others are seldom nearer.
    let contacts = orbit.model().structure().contacts();
    let mut order: Vec<usize> = (0..contacts.len()).collect();
    order.sort_by_key(|&contact| !impacts.iter().any(|impact| impact.contact == contact));
    for contact in order {
        let stops = &contacts[contact];
        for barrier in [Barrier::Lower, Barrier::Upper] {
            let Some(stop) = stops.barrier(barrier) else { continue };
            for i in 0..impacts.len() {
                let (begins, length) = (impacts[i].time, motion.until_next(i));
                if length <= together {
                    continue;
                }
                // Most contacts are far from their barriers, and stay there.
                let room = barrier.sign() * (stop - motion.still(contact));
                if closest.as_ref().is_some_and(|(least, _)| room - motion.most_excursion(contact, i) > least.max(0.0)) {
                    continue;
                }
                let here = |time: f64| {
                    impacts.iter().any(|impact| {
                        let apart = (impact.time - time).rem_euclid(orbit.period());
                        impact.contact == contact
                            && impact.barrier == barrier
                            && apart.min(orbit.period() - apart) <= together
                    })
                };
                let watch = Watch {
                    motion: &motion,
                    contact,
                    barrier,
                    stop,
                    i,
                    length,
                    touch: TOUCH * stops.reach().max(f64::MIN_POSITIVE),
                };
                if let Some((least, s)) = watch.least(here(begins), here(begins + length)) {
                    let time = (begins + s).rem_euclid(orbit.period());
                    if closest.as_ref().is_none_or(|(other, _)| least < *other) {
                        closest = Some((least, Approach { site: contact, barrier, time }));
                    }
                }
            }
        }
    }
    let obstruction = closest.as_ref().filter(|(least, _)| *least <= 0.0).map(|(least, approach)| {
        Obstruction::Crossing { site: approach.site, barrier: approach.barrier, time: approach.time, excess: -least }
    });
    let (margin, closest) = match closest {
        Some((least, approach)) => (Some(least), Some(approach)),
        None => (None, None),
    };
    Ok(Admissibility { margin, obstruction, closest })
}

/// One contact and one barrier in one flight.
struct Watch<'a> {
    motion: &'a StructureMotion<'a>,
    contact: usize,
    barrier: Barrier,
    stop: f64,
    i: usize,
    length: f64,
    touch: f64,
}

impl Watch<'_> {
    /// The distance to the barrier and its derivative.
    fn distance(&self, s: f64) -> [f64; 2] {
        let [place, velocity, _] = self.motion.contact(self.contact, self.i, s);
        let sign = self.barrier.sign();
        [sign * (self.stop - place), -sign * velocity]
    }

    /// The least distance at a turning point or end of the flight, and where; `None` if it only goes. `leaves`, `arrives`: it is on the
    /// barrier at the ends.
    fn least(&self, leaves: bool, arrives: bool) -> Option<(f64, f64)> {
        let bend = |s: f64| self.motion.most_acceleration(self.contact, self.i, s, self.length) * (1.0 + 1e-12);
        let whole = bend(0.0);
        let (first, last) = (self.distance(0.0), self.distance(self.length));
        let mut s = if leaves { (1.999 * first[1] / whole).max(0.0) } else { 0.0 };
        let end = if arrives { self.length - (1.999 * -last[1] / whole).max(0.0) } else { self.length };
        let mut least: Option<(f64, f64)> = None;
        let mut keep = |d: f64, s: f64| {
            if least.is_none_or(|(other, _)| d < other) {
                least = Some((d, s));
            }
        };
        if leaves {
            // Between its first turn and here it comes back no farther than this.
            s = s.min(end);
        }
        let mut before: Option<(f64, f64)> = None;
        for _ in 0..MOST_STEPS {
            let [d, slope] = self.distance(s);
            if let Some((s_before, slope_before)) = before
                && slope_before < 0.0
                && slope >= 0.0
            {
                let turn = self.turning(s_before, s);
                keep(self.distance(turn)[0], turn);
            }
            if d <= self.touch {
                // Beyond, or as good as there: how far it goes.
                let turn = self.deepest(s);
                keep(self.distance(turn)[0].min(0.0), turn);
                return least;
            }
            if s >= end {
                break;
            }
            let bend = bend(s).max(f64::MIN_POSITIVE);
            let step = (slope + (slope * slope + 2.0 * bend * d).sqrt()) / bend;
            before = Some((s, slope));
            s = (s + step.max(1e-9 * self.length)).min(end);
        }
        least
    }

    /// Where the distance turns between two places.
    fn turning(&self, mut low: f64, mut high: f64) -> f64 {
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if self.distance(middle)[1] < 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    }

    /// The first turn after a place beyond the barrier.
    fn deepest(&self, from: f64) -> f64 {
        let step = 1e-3 * self.length;
        let mut s = from;
        while s < self.length {
            let next = (s + step).min(self.length);
            if self.distance(next)[1] >= 0.0 {
                return self.turning(s, next);
            }
            s = next;
        }
        self.length
    }
}
