//! Stable or not, for orbits that are not reversible: by the exact count where there is one, by all multipliers otherwise.

use nalgebra::Complex;
use vibrochain_breather::Orbit;
use vibrochain_lattice::ImpulseResponse;

use super::doubt::Doubt;
use super::forced::SecularMultipliers;
use super::forced_count::OutsideCounter;
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
        let counted = match self.counter.count(orbit, response) {
            Ok(count) if count.total() == 0 => {
                return Ok(SecularVerdict {
                    outcome: Outcome::Stable,
                    reason: Reason::NoneOutside,
                    leading: None,
                    growth: 0.0,
                    growth_error: 0.0,
                    clearance: f64::INFINITY,
                });
            }
            Ok(count) => Some(count.total()),
            Err(_) => None,
        };
        self.multipliers.set(orbit, response)?;
        let (values, errors) = self.multipliers.multipliers()?;
        let leading = values.iter().zip(errors).max_by(|a, b| a.0.norm_sqr().total_cmp(&b.0.norm_sqr()));
        let Some((&leading, &error)) = leading else { return Err(Doubt::NotReversible) };
        let growth = excess(leading);
        let clearance = values.iter().map(|z| excess(*z).abs()).fold(f64::INFINITY, f64::min);
        if let Some(wanted) = counted {
            let found = values.iter().zip(errors).filter(|(z, error)| excess(**z) > -**error).count();
            let surely = values.iter().zip(errors).filter(|(z, error)| excess(**z) > **error).count();
            if wanted < surely || wanted > found {
                return Err(Doubt::Incomplete { found, wanted });
            }
        }
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
}

/// |μ| − 1 without the cancellation of the modulus itself.
fn excess(z: Complex<f64>) -> f64 {
    let square = (z.re - 1.0).mul_add(z.re + 1.0, z.im * z.im);
    square / (1.0 + z.norm())
}
