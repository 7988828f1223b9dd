//! What orbits do as a frequency comes to a resonance, where the closed forms have no answer.
//!
//! The term of a mode in the kernel grows like one over its distance from a harmonic. Impulses that do not push that mode feel nothing
//! of it, by symmetry or because they vanish against each other in the limit, and their orbits go through the resonance. All others
//! lose their impulses there.

use std::fmt;

use vibrochain_lattice::{Model, Parameter, Resonance, Shapes, Short};

use crate::orbit::{Hit, Impact, Orbit};
use crate::structures::branch::resonances::STILL;

/// How far beside a resonance orbits are looked at, relative: what the mean of both sides is wrong by goes with the square, and rounding
/// with the inverse. Impulses that are balanced in the limit only push by the square, too, which is still beyond rounding.
const ASIDE: f64 = 1e-6;

/// Impulses on both sides that differ by less, relative to the largest, have one limit.
const ALIKE: f64 = 1e-2;

/// Whether a harmonic of the impulses pushes a mode.
pub(crate) fn pushes(orbit: &Orbit, shapes: &Shapes, mode: usize, harmonic: f64) -> bool {
    let rate = harmonic * orbit.frequency();
    let share = |one: &Impact, other: &Impact| {
        let turned = (rate * (one.time - other.time)).cos();
        one.impulse * other.impulse * shapes.even(mode, one.site, other.site) * turned
    };
    let impacts = orbit.impacts();
    let size: f64 = impacts.iter().map(|impact| share(impact, impact)).sum();
    let all = impacts.iter().flat_map(|one| impacts.iter().map(move |other| share(one, other)));
    all.sum::<f64>() > STILL * size
}

/// What becomes of an orbit at a resonance.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Limit {
    /// Its impacts in the limit, which is the same from both sides; to six digits or so.
    pub impacts: Vec<Hit>,
    /// Whether it pushes the mode on neither side, and not only in the limit.
    pub spared: bool,
    /// A frequency beside the resonance, where an orbit like it is found.
    pub omega: f64,
}

impl Limit {
    /// The limits of all orbits that `find` has at the frequencies beside a resonance; none where it finds not as many on both sides.
    pub fn all<E>(
        model: &Model,
        resonance: &Resonance,
        mut find: impl FnMut(&Model) -> Result<Vec<Orbit>, E>,
    ) -> Result<Vec<Self>, E> {
        let mut side = |by: f64| match model.with(Parameter::Omega, model.omega() * (1.0 + by)) {
            Ok(model) => find(&model),
            Err(_) => Ok(Vec::new()),
        };
        let (below, above) = (side(-ASIDE)?, side(ASIDE)?);
        if below.len() != above.len() {
            return Ok(Vec::new());
        }
        let shapes = Shapes::new(model.chain());
        Ok(below.iter().zip(&above).filter_map(|pair| Self::between(pair, resonance, &shapes)).collect())
    }

    fn between((below, above): (&Orbit, &Orbit), resonance: &Resonance, shapes: &Shapes) -> Option<Self> {
        let pairs = || below.impacts().iter().zip(above.impacts());
        let largest = pairs().fold(0.0, |most: f64, (one, other)| most.max(one.impulse.abs()).max(other.impulse.abs()));
        let alike = below.impacts().len() == above.impacts().len()
            && pairs().all(|(one, other)| {
                one.site == other.site
                    && one.barrier == other.barrier
                    && (one.impulse - other.impulse).abs() <= ALIKE * largest
            });
        let mean = |(one, other): (&Impact, &Impact)| Hit {
            time: 0.5 * (one.time + other.time),
            impulse: 0.5 * (one.impulse + other.impulse),
            ..one.into()
        };
        let still = |orbit: &Orbit| !pushes(orbit, shapes, resonance.mode, resonance.harmonic as f64);
        alike.then(|| Self {
            impacts: pairs().map(mean).collect(),
            spared: still(below) && still(above),
            omega: above.omega(),
        })
    }
}

impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "from both sides the orbit goes over into one with impulses")?;
        for (i, Hit { site, impulse, .. }) in self.impacts.iter().enumerate() {
            write!(f, "{} {impulse:.6} of site {site}", if i > 0 { "," } else { "" })?;
        }
        if self.spared {
            write!(
                f,
                ", which never push that mode; any motion of it that leaves the masses that are hit at rest may be added"
            )?;
        } else {
            write!(f, ", which in the limit do not push that mode, and with it as it must swing then")?;
        }
        write!(f, "; omega = {} gives one like it", Short(self.omega))
    }
}
