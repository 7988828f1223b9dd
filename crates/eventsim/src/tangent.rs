//! Tangent vectors: what becomes of small perturbations of a run, to first order and without a step size.
//!
//! **Flight** is linear, so that a perturbation flies as the lattice does without force and barriers: the same series
//! ([`crate::series`]), in steps as long as their remainder allows.
//!
//! **Impact.** A mass that is displaced by δu arrives earlier by δu/v⁻. It then flies with v⁺ instead of v⁻ for that time, and
//! with its acceleration α, which the impact does not change, has gained α δu/v⁻ less before and as much more after, turned by −e:
//!
//! ```text
//! δu⁺ = −e δu⁻ ,      δv⁺ = −e δv⁻ + (1+e) (α/v⁻) δu⁻ .
//! ```
//!
//! Masses that hit together keep this form each: positions do not jump, so none changes the acceleration of another. At a graze,
//! v⁻ = 0, there is no linear map, and the vectors say so from then on.
//!
//! **Rest.** A mass at rest is where its barrier is and has no velocity, whatever is done to the others: δu = δv = 0 from the
//! event `stick` on. The instants of that and of its release move with the perturbation, but velocity (and at the release
//! acceleration, too) vanishes there, so that they count to second order only.

use vibrochain_lattice::{Ends, Model};

use crate::cascade::Change;
use crate::directions::Directions;
use crate::engine::Engine;
use crate::error::TangentError;
use crate::event::EventKind;
use crate::series::Rows;
use crate::stencil::{Extent, links};
use crate::units::{MAX_ORDER, ORDERS, Units};
use crate::weights::Weights;

/// Tangent vectors of a run: small perturbations of its state, carried along by [`Simulation::run_with`](crate::Simulation::run_with).
///
/// They belong to a model, not to a simulation: taken off one that has ended they ride on with the next, from the state in which it
/// is. Lengths are Euclidean over displacements and velocities, the latter in internal units (of a rate between half of
/// the lattice's fastest and that); exponents do not depend on that.
///
/// ```
/// use vibrochain_eventsim::{Growth, Limits, Simulation, Tangents, Time};
/// use vibrochain_lattice::{Chain, Model};
///
/// // A hot ring is chaotic.
/// let model = Model::conservative(Chain::new(5, 0.2, 0.1)?, 1.5, 0.4)?;
/// let mut simulation = Simulation::new(&model, 0.0, &[0.0; 5], &[2.0, -1.0, 1.5, 0.5, -0.5])?;
/// let mut tangents = Tangents::random(&model, 1, 7)?;
/// let mut growth = Growth::default();
/// for period in 1..=200 {
///     simulation.run_with(&mut tangents, &Limits::until(Time::new(&model, period, 0.0)), |_| {})?;
///     growth.reach(simulation.time().to_f64(), tangents.orthonormalise()[0]);
/// }
/// let exponent = growth.exponent().ok_or("no exponent")?;
/// assert!(exponent.value > 5.0 * exponent.error, "{exponent:?}");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Tangents {
    model: Model,
    units: Units,
    links: Vec<[u32; 4]>,
    horizons: [f64; ORDERS.len()],
    /// Displacements and velocities of each vector, internal units.
    directions: Directions,
    rows: Rows,
    scratch: [Vec<f64>; 2],
}

impl Tangents {
    /// `count` orthonormal vectors in random directions; the same seed gives the same ones.
    ///
    /// # Errors
    /// [`TangentError::Count`] if there are none, more than 4096 or more than two a mass.
    pub fn random(model: &Model, count: usize, seed: u64) -> Result<Self, TangentError> {
        Ok(Self::with(model, Directions::random(count, model.chain().sites(), seed)?))
    }

    /// Of given directions, displacements and velocities, which need be neither orthogonal nor of length 1.
    ///
    /// # Errors
    /// [`TangentError::Count`], [`TangentError::Entries`].
    pub fn of(model: &Model, vectors: &[(Vec<f64>, Vec<f64>)]) -> Result<Self, TangentError> {
        let scale = Units::new(model).scale;
        let own = vectors.iter().map(|(u, v)| [u.clone(), v.iter().map(|v| v / scale).collect()]);
        Ok(Self::with(model, Directions::of(own.collect(), model.chain().sites())?))
    }

    fn with(model: &Model, directions: Directions) -> Self {
        let units = Units::new(model);
        let sites = model.chain().sites();
        Self {
            model: *model,
            links: links(&units.chain),
            horizons: units.free_horizons(),
            directions,
            rows: Rows::new(sites),
            scratch: [vec![0.0; sites], vec![0.0; sites]],
            units,
        }
    }

    /// Number of vectors.
    pub fn count(&self) -> usize {
        self.directions.vectors.len()
    }

    /// Displacements and velocities of vector `i` as it is now, if there are so many: as the flow has left it since it was given, or
    /// made orthonormal.
    pub fn vector(&self, i: usize) -> Option<(Vec<f64>, Vec<f64>)> {
        let [u, v] = self.directions.vectors.get(i)?;
        Some((u.clone(), v.iter().map(|v| v * self.units.scale).collect()))
    }

    /// Whether the run has grazed a barrier: no linear map goes through that, and growth and vectors mean nothing.
    pub fn has_grazed(&self) -> bool {
        self.directions.grazed
    }

    /// What [`Tangents::orthonormalise`] has told last; zeros if the vectors have not been made orthonormal yet, by that or on the way.
    pub fn growth(&self) -> &[f64] {
        &self.directions.logs
    }

    /// Makes the vectors orthonormal, in their order, and tells the logarithm of what each direction has grown since the
    /// beginning: of the first the length, of the first two the area, and so on, are their sums. −∞ where rest has taken all
    /// of a direction.
    ///
    /// A vector that outgrows the others 10⁸ times is seen to on the way.
    pub fn orthonormalise(&mut self) -> &[f64] {
        self.directions.orthonormalise()
    }

    /// The vectors on a run that is at `now` since the base of its engine.
    pub(crate) fn mount(&mut self, model: &Model, engine: &Engine, now: f64) -> Result<Riders<'_>, TangentError> {
        if self.model != *model {
            return Err(TangentError::OtherModel);
        }
        engine.ring.resting.iter().for_each(|&site| self.hold(site));
        Ok(Riders { tangents: self, at: engine.clock.after(now), resting: engine.ring.resting.clone() })
    }

    /// Carries all vectors through free flight, with some masses at rest.
    fn fly(&mut self, time: f64, resting: &[usize]) {
        let mut left = time;
        let mut weights = Weights::zero();
        let ends = if self.units.is_row { self.units.chain.ends() } else { Ends::Fixed };
        let sites = self.scratch[0].len();
        let extent = Extent { columns: sites, beyond: [Some(ends); 2], links: &self.links, resting, soft: &[] };
        while left > 0.0 {
            let last = ORDERS.len() - 1;
            let enough = self.horizons.iter().position(|&horizon| horizon >= left).unwrap_or(last);
            let (order, step) = (ORDERS[enough], left.min(self.horizons[enough]));
            weights.plain(step, order, &self.units.inverse_factorial);
            for [u, v] in &mut self.directions.vectors {
                self.rows.data[1..=sites].copy_from_slice(u);
                let stride = self.rows.stride;
                self.rows.data[stride + 1..][..sites].copy_from_slice(v);
                self.rows.expand_chain(extent, &self.units, &[0.0; MAX_ORDER + 1], order, |_, _, _| {});
                let [u_next, v_next] = &mut self.scratch;
                self.rows.at_all(u, &weights, u_next, v_next);
                std::mem::swap(u, u_next);
                std::mem::swap(v, v_next);
            }
            left -= step;
        }
    }

    fn change(&mut self, change: &Change) {
        let &Change { site, before, force: acceleration, kind, .. } = change;
        match kind {
            EventKind::Impact if before == 0.0 => self.directions.grazed = true,
            EventKind::Impact => {
                let restitution = self.units.restitution;
                let kick = (1.0 + restitution) * acceleration / before;
                for [u, v] in &mut self.directions.vectors {
                    v[site] = kick * u[site] - restitution * v[site];
                    u[site] *= -restitution;
                }
            }
            EventKind::Stick => self.hold(site),
            EventKind::Release => {}
        }
    }

    /// A mass at rest has no perturbation.
    fn hold(&mut self, site: usize) {
        for [u, v] in &mut self.directions.vectors {
            (u[site], v[site]) = (0.0, 0.0);
        }
    }
}

/// Who is told of events while a run is under way, and must not touch it.
pub(crate) trait Company {
    /// What has happened at `now` since the base.
    fn meet(&mut self, engine: &Engine, now: f64, changes: &[Change]);
}

/// Nobody.
pub(crate) struct Alone;

impl Company for Alone {
    fn meet(&mut self, _: &Engine, _: f64, _: &[Change]) {}
}

/// Tangent vectors on a run.
pub(crate) struct Riders<'a> {
    tangents: &'a mut Tangents,
    /// The clock at the instant of the vectors.
    at: (u64, f64),
    /// Masses at rest since then.
    resting: Vec<usize>,
}

impl Riders<'_> {
    /// Carries the vectors to `now` since the base.
    pub(crate) fn fly_to(&mut self, engine: &Engine, now: f64) {
        let (periods, offset) = self.at;
        self.tangents.fly(now - engine.clock.until(periods, offset), &self.resting);
        self.at = engine.clock.after(now);
    }
}

impl Company for Riders<'_> {
    fn meet(&mut self, engine: &Engine, now: f64, changes: &[Change]) {
        self.fly_to(engine, now);
        changes.iter().for_each(|change| self.tangents.change(change));
        self.tangents.directions.keep_apart();
        self.resting.clone_from(&engine.ring.resting);
    }
}
