//! Stable or not, for orbits that are not reversible: by the exact count where there is one, by all multipliers otherwise.

use nalgebra::Complex;
use vibrochain_breather::{Condition, Orbit};
use vibrochain_lattice::ImpulseResponse;

use super::aberth::evaluate;
use super::doubt::Doubt;
use super::forced::SecularMultipliers;
use super::forced_count::OutsideCounter;
use super::growth::excess;
use super::verdict::{Outcome, Reason, SecularVerdict};

/// Work space for verdicts on orbits with a force or losses, all impacts at one site.
///
/// ```
/// use vibrochain_breather::{Family, Finder, Found};
/// use vibrochain_floquet::{ForcedSecular, Outcome};
/// use vibrochain_lattice::{Chain, Model};
/// let model = Model::forced(Chain::new(21, 0.2, 0.1)?, 1.5, 0.4, 0.1, 0.9)?;
/// let (mut finder, mut found, mut secular) = (Finder::new(21), Found::default(), ForcedSecular::default());
/// finder.find(&model, Family::DoubleSided, &mut found)?;
/// let verdict = secular.verdict(&found.orbits[0], finder.response())?;
/// assert!(verdict.outcome == Outcome::Unstable && (verdict.growth - 0.0016290236374028).abs() < 1e-11);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct ForcedSecular {
    counter: OutsideCounter,
    multipliers: SecularMultipliers,
    moved: SecularMultipliers,
    values: Vec<Complex<f64>>,
    errors: Vec<f64>,
}

impl ForcedSecular {
    /// The verdict. For elastic impacts multipliers stay on the circle, which this form cannot tell from next to it: it then
    /// says marginal where it does not say unstable.
    ///
    /// # Errors
    /// [`Doubt`]; [`Doubt::NotReversible`] also for conservative orbits, whose trivial pair this form does not split off.
    pub fn verdict(&mut self, orbit: &Orbit, response: &ImpulseResponse) -> Result<SecularVerdict, Doubt> {
        if orbit.model().is_conservative() {
            return Err(Doubt::NotReversible);
        }
        self.solve(orbit, response)?;
        let (values, errors) = self.multipliers();
        let leading = values.iter().zip(errors).max_by(|a, b| a.0.norm_sqr().total_cmp(&b.0.norm_sqr()));
        let Some((&leading, &error)) = leading else { return Err(Doubt::NotReversible) };
        let growth = excess(leading);
        let clearance = values.iter().map(|z| excess(*z).abs()).fold(f64::INFINITY, f64::min);
        let real = leading.im.abs() <= error;
        let (outcome, reason) = if growth > error {
            (Outcome::Unstable, if real { Reason::RealRoot } else { Reason::ComplexPair })
        } else if growth < -error {
            (Outcome::Stable, Reason::NoneOutside)
        } else {
            (Outcome::Marginal, Reason::Tangency)
        };
        let leading = Some(if real { Complex::new(leading.re, 0.0) } else { leading });
        Ok(SecularVerdict { outcome, reason, leading, growth, growth_error: error, clearance })
    }

    /// All multipliers of the even subspace, held against the count of those outside the circle where there is one.
    pub(crate) fn solve(&mut self, orbit: &Orbit, response: &ImpulseResponse) -> Result<(), Doubt> {
        self.multipliers.set(orbit, response)?;
        let (values, errors) = self.multipliers.multipliers()?;
        self.values.clear();
        self.values.extend_from_slice(values);
        self.errors.clear();
        self.errors.extend_from_slice(errors);
        // The count takes a pass over the modes for each of them.
        if !self.multipliers.is_large()
            && let Ok(count) = self.counter.count(orbit, response)
        {
            let beyond = |sign: f64| {
                let outside = |(z, error): &(&Complex<f64>, &f64)| excess(**z) > sign * **error;
                self.values.iter().zip(&self.errors).filter(outside).count()
            };
            let (wanted, surely, found) = (count.total(), beyond(1.0), beyond(-1.0));
            if wanted < surely || wanted > found {
                return Err(Doubt::Incomplete { found, wanted });
            }
        }
        Ok(())
    }

    /// The multipliers last solved for, and their errors.
    pub(crate) fn multipliers(&self) -> (&[Complex<f64>], &[f64]) {
        (&self.values, &self.errors)
    }

    /// Adds what the errors of the orbit's own data, of its saltations and times, do to each multiplier: by difference
    /// quotients of the secular function, each error with the worst sign.
    pub(crate) fn add_errors_of(
        &mut self,
        orbit: &Orbit,
        condition: &Condition,
        response: &ImpulseResponse,
    ) -> Result<(), Doubt> {
        let Self { multipliers: form, moved, values, errors, .. } = self;
        let (e, q) = (orbit.model().restitution(), orbit.model().loss());
        let top = response.frequencies().iter().copied().fold(response.omega(), f64::max);
        for (i, (impact, known)) in orbit.impacts().iter().zip(&condition.impacts).enumerate() {
            let (kappa, impulse) = (form.kappas[i], impact.impulse.abs());
            // κ' = −v̈/P, and rounded.
            let rounded = 4.0 * f64::EPSILON * kappa.abs();
            let kappa_error = (known.acceleration + kappa.abs() * known.impulse) / impulse + rounded;
            let kappa_step = STEP * (kappa.abs() + response.omega());
            // Only differences of times count.
            let time_error = if i == 0 { 0.0 } else { known.time + f64::EPSILON * orbit.period() };
            for (error, step, of_time) in [(kappa_error, kappa_step, false), (time_error, STEP / top, true)] {
                if error == 0.0 {
                    continue;
                }
                moved.times.clone_from(&form.times);
                moved.kappas.clone_from(&form.kappas);
                (if of_time { &mut moved.times } else { &mut moved.kappas })[i] += step;
                // The certificate is the orbit's own business; here a derivative is all.
                match moved.assemble(e, q, response) {
                    Ok(()) | Err(Doubt::Certificate { .. }) => {}
                    Err(doubt) => return Err(doubt),
                }
                if form.is_large() {
                    let moves = form.large.moved(&moved.large);
                    errors.iter_mut().zip(moves).for_each(|(total, by)| *total += by * (error / step));
                    continue;
                }
                for (z, total) in values.iter().zip(errors.iter_mut()) {
                    let (here, there) = (evaluate(form, *z), evaluate(moved, *z));
                    *total += (there.f - here.f).norm() / here.slope.norm() * (error / step);
                }
            }
        }
        Ok(())
    }

    /// The multipliers with complex ones in exactly conjugate pairs and real ones without imaginary part.
    pub(crate) fn symmetric_multipliers(&self) -> Vec<Complex<f64>> {
        if self.multipliers.is_large() {
            // They are found that way.
            return self.values.clone();
        }
        let mut open: Vec<Complex<f64>> = self.values.clone();
        let mut paired = Vec::with_capacity(open.len());
        while let Some(z) = open.pop() {
            let distance = |w: &Complex<f64>| (w - z.conj()).norm();
            let nearest = (0..open.len()).min_by(|&i, &j| distance(&open[i]).total_cmp(&distance(&open[j])));
            match nearest {
                // A real one is nearer to itself.
                Some(partner) if distance(&open[partner]) < 2.0 * z.im.abs() => {
                    open.swap_remove(partner);
                    paired.extend([z, z.conj()]);
                }
                _ => paired.push(Complex::new(z.re, 0.0)),
            }
        }
        paired
    }
}

/// Step of a difference quotient, relative to the natural size: error and rounding balance.
const STEP: f64 = 1e-7;
