//! The linearised equations of an orbit, J(z).

use std::sync::Arc;

use vibrochain_lattice::{BlochKernel, Complex, LinearMode};

use super::errors::ImpactError;
use super::masses::Masses;
use super::orbit::{ContactOrbit, in_order};
use crate::equations::{BlochEquations, LinearImpact};
use crate::orbit::impact::Impact;

/// All that J(z) is made of.
struct Linearised {
    modes: Arc<Vec<LinearMode>>,
    /// The contacts that are hit, rising.
    hit: Vec<usize>,
    impacts: Vec<LinearImpact>,
    period: f64,
    /// The relative error of the period.
    part: f64,
    conservative: bool,
}

impl Linearised {
    fn equations(self) -> BlochEquations {
        let Self { modes, hit, impacts, period, part, conservative } = self;
        let kernel = BlochKernel::of_modes(&modes, period, &hit);
        // Of a large lattice they take as much room as what follows.
        drop(modes);
        let kernel = kernel.of_uncertain_period(if part.is_finite() { part } else { 0.0 });
        if conservative { BlochEquations::conservative(kernel, impacts) } else { BlochEquations::new(kernel, impacts) }
    }
}

impl ContactOrbit {
    /// Its linearised equations J(z), and the poles of modes that none of its contacts feels.
    pub fn bloch_equations(&self) -> (BlochEquations, Vec<[Complex<f64>; 2]>) {
        let mut spared = self.response().kernel.felt.spared.clone();
        // Without dashpots those of a lattice that its structure leaves out are on the circle.
        if let Some(Masses { lattice, shapes, .. }) = self.model().masses().filter(|masses| masses.lattice.is_damped())
        {
            spared.extend(shapes.unfelt_poles(lattice.springs(), lattice.dashpots()));
        }
        (self.linearised(self.impacts()).equations(), spared)
    }

    /// J(z) alone, of an orbit that nobody else holds: all else that it knows of its modes is given back before.
    pub fn into_bloch_equations(self: Arc<Self>) -> BlochEquations {
        let linearised = self.linearised(self.impacts());
        drop(self);
        linearised.equations()
    }

    /// J(z) with the impacts as far away as one origin of errors may have them; `None` where they are no impacts of a period in order.
    pub fn bloch_equations_aside(&self, origin: &[ImpactError]) -> Option<BlochEquations> {
        let mut impacts = self.impacts().to_vec();
        for (impact, error) in impacts.iter_mut().zip(origin) {
            impact.time += error.time;
            impact.impulse += error.impulse;
            impact.acceleration += error.acceleration;
        }
        let kept = impacts.iter().zip(self.impacts()).all(|(aside, own)| aside.impulse * own.impulse > 0.0);
        let ordered = in_order(impacts.iter().map(|impact| impact.time), self.period());
        (kept && ordered).then(|| self.linearised(&impacts).equations())
    }

    fn linearised(&self, impacts: &[Impact]) -> Linearised {
        let mut hit: Vec<usize> = self.impacts().iter().map(|impact| impact.site).collect();
        hit.sort_unstable();
        hit.dedup();
        let contacts = self.model().structure().contacts();
        let impact = |impact: &Impact| LinearImpact {
            contact: hit.partition_point(|&contact| contact < impact.site),
            time: impact.time,
            impulse: impact.impulse,
            restitution: contacts[impact.site].restitution,
            acceleration_before: impact.acceleration,
        };
        Linearised {
            modes: self.response().kernel.felt.modes.clone(),
            impacts: impacts.iter().map(impact).collect(),
            hit,
            period: self.period(),
            part: self.period_error() / self.period(),
            conservative: self.is_conservative(),
        }
    }
}
