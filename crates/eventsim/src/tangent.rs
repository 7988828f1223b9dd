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

use crate::directions::Directions;
use crate::error::TangentError;
use crate::structure::{Motion, Riders, System, TangentVectors};
use vibrochain_lattice::Model;

/// What a model's masses do, under its force at a phase.
pub(crate) fn system(model: &Model, psi: f64) -> System {
    let harmonics = model.force().harmonics().iter().filter(|harmonic| harmonic.amplitude != 0.0);
    let numbers: Vec<u32> = harmonics.map(|harmonic| harmonic.number).collect();
    System::of_operator(model.operator(), model.stop(), &numbers, (model.omega(), psi))
}

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
    inner: TangentVectors,
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
        let own = vectors.iter().map(|(u, v)| [u.clone(), v.clone()]);
        let mut tangents = Self::with(model, Directions::of(own.collect(), model.chain().sites())?);
        let scale = tangents.inner.scale();
        let velocities = tangents.inner.directions.vectors.iter_mut().flat_map(|[_, v]| v);
        velocities.for_each(|v| *v /= scale);
        Ok(tangents)
    }

    fn with(model: &Model, directions: Directions) -> Self {
        Self { model: *model, inner: TangentVectors::of_system(system(model, 0.0), directions) }
    }

    /// Number of vectors.
    pub fn count(&self) -> usize {
        self.inner.directions.vectors.len()
    }

    /// Displacements and velocities of vector `i` as it is now, if there are so many: as the flow has left it since it was given, or
    /// made orthonormal.
    pub fn vector(&self, i: usize) -> Option<(Vec<f64>, Vec<f64>)> {
        let [u, v] = self.inner.directions.vectors.get(i)?;
        Some((u.clone(), v.iter().map(|v| v * self.inner.scale()).collect()))
    }

    /// Whether the run has grazed a barrier: no linear map goes through that, and growth and vectors mean nothing.
    pub fn has_grazed(&self) -> bool {
        self.inner.directions.grazed
    }

    /// What [`Tangents::orthonormalise`] has told last; zeros if the vectors have not been made orthonormal yet, by that or on the way.
    pub fn growth(&self) -> &[f64] {
        &self.inner.directions.logs
    }

    /// Makes the vectors orthonormal, in their order, and tells the logarithm of what each direction has grown since the
    /// beginning: of the first the length, of the first two the area, and so on, are their sums. −∞ where rest has taken all
    /// of a direction.
    ///
    /// A vector that outgrows the others 10⁸ times is seen to on the way.
    pub fn orthonormalise(&mut self) -> &[f64] {
        self.inner.directions.orthonormalise()
    }

    /// The vectors on a run that is at `now` since its base.
    pub(crate) fn mount(&mut self, model: &Model, motion: &Motion, now: f64) -> Result<Riders<'_>, TangentError> {
        if self.model != *model {
            return Err(TangentError::OtherModel);
        }
        Ok(self.inner.mount(motion, now))
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]
mod tests {
    use super::system;
    use crate::series::tests::empty;
    use crate::units::{MAX_ORDER, ORDERS, REMAINDER};
    use vibrochain_lattice::{Force, Harmonic, Model, Point};

    fn model(g1: f64, g2: f64, omega: f64, amplitude: f64) -> Model {
        Point::ring(21).gamma1(g1).gamma2(g2).omega(omega).asymmetry(0.4).amplitude(amplitude).model().unwrap()
    }

    /// From the softest to the stiffest.
    #[test]
    fn rates_are_of_order_one_for_any_model() {
        for (g1, g2, omega, amplitude) in
            [(0.2, 0.1, 1.5, 0.0), (1e100, 1e99, 1.0, 0.0), (0.0, 1e-300, 1e-100, 0.0), (0.2, 0.1, 1e100, 1.0)]
        {
            let system = system(&model(g1, g2, omega, amplitude), 0.0);
            let local = system.local.as_ref().unwrap();
            assert!((1.0..2.0).contains(&(system.fastest / local.scale)), "{} {}", system.fastest, local.scale);
            let horizons = local.horizons;
            assert!(horizons.windows(2).all(|h| 0.0 < h[0] && h[0] < h[1]) && horizons[7] < 2.0, "{horizons:?}");
        }
    }

    #[test]
    fn derivatives_of_a_force_of_several_harmonics_are_those_of_its_sum() {
        let harmonic = |number, amplitude, phase| Harmonic { number, amplitude, phase };
        let force = Force::new(&[harmonic(1, 0.7, 0.4), harmonic(5, -0.2, 1.0)]).unwrap();
        let model = Point::ring(3).gamma1(0.2).gamma2(0.1).omega(13.0).asymmetry(0.4).under(&force).model().unwrap();
        let system = system(&model, 0.0);
        let local = system.local.as_ref().unwrap();
        assert!((system.fastest - 65.0).abs() < 1e-12);
        for i in 0..30 {
            let t = 0.11 * f64::from(i);
            let turned = system.loads.turned(t);
            let direct = 0.7 * (13.0 * t + 0.4).cos() - 0.2 * (65.0 * t + 1.0).cos();
            assert!((local.load(&turned, 1, 0) - direct).abs() < 1e-12);
            let third = 0.7 * 13f64.powi(3) * (13.0 * t + 0.4).sin() - 0.2 * 65f64.powi(3) * (65.0 * t + 1.0).sin();
            assert!((local.load(&turned, 1, 3) - third).abs() < 1e-12 * 65f64.powi(3));
        }
    }

    /// The motion that a force in resonance drives: what its series leaves out beyond an order is below the rounding of its size at the end of
    /// that order's window, and no window is much shorter than that asks for.
    #[test]
    fn what_a_series_leaves_out_is_below_rounding() {
        for (g1, g2, omega, forced) in
            [(0.2, 0.1, 1.5, 0.0), (0.2, 0.1, 0.3, 0.5), (1.0, 0.0, 1.0, 3.0), (0.2, 0.1, 7.0, 0.1)]
        {
            let system = system(&model(g1, g2, omega, forced), 0.0);
            let local = system.local.as_ref().unwrap();
            let rate = local.growth.rate;
            // Sizes of the derivatives of U cos rs + V/r sin rs + A/2r · s sin rs.
            let d = |k: i32| 3.1 * rate.powi(k) + 0.5 * f64::from(k) * forced * rate.powi(k - 2);
            let mut rows = empty(1);
            for k in 0..=MAX_ORDER {
                let entry = k * rows.stride + 1;
                rows.data[entry] = d(k as i32);
            }
            for (order, longest) in ORDERS.into_iter().zip(local.horizons) {
                rows.order = order;
                let horizon = local.certified(&rows, longest, system.fastest);
                let (mut place, mut velocity, mut weight) = (0.0, 0.0, 1.0);
                for k in 1..order as i32 + 40 {
                    if k > order as i32 {
                        velocity += d(k) * weight;
                    }
                    weight *= horizon / f64::from(k);
                    if k > order as i32 {
                        place += d(k) * weight;
                    }
                }
                let size = (0..4).map(|k| d(k) / rate.powi(k)).fold(0.0, f64::max);
                let (place, velocity) = (place / size, velocity / rate / size);
                assert!(place <= REMAINDER && velocity <= 1.2 * REMAINDER, "{order} {horizon}: {place:e} {velocity:e}");
                assert!(velocity > REMAINDER / 8.0, "{order} {horizon}: {velocity:e}");
            }
        }
    }
}
