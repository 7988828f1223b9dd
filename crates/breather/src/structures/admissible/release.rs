//! What a contact does right after its impact. It is on its barrier there: the first of velocity, acceleration and jerk that is larger than its
//! error decides whether it leaves or begins to rest. After a plastic impact the velocity is 0, and the sign of a distance nearby is rounding.

use crate::error::BreatherError;
use crate::structures::flight::ContactMotion;
use crate::structures::orbit::ContactOrbit;

/// Impacts closer than this part of the period are at one instant.
pub(super) const TOGETHER: f64 = 1e-12;

/// Rounding of a term with the few operations that it takes.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// How an impact ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Release {
    /// The contact leaves, and is surely off its barrier for so long; 0 where its velocity tells.
    Leaves(f64),
    /// It is pressed to its barrier, with this acceleration.
    Rests(f64),
}

/// A number with its error.
#[derive(Debug, Clone, Copy)]
struct Estimate {
    value: f64,
    error: f64,
}

impl Estimate {
    /// 1 or −1; 0 of one that may be 0.
    fn sign(self) -> f64 {
        if self.value.abs() > self.error { self.value.signum() } else { 0.0 }
    }
}

impl Release {
    /// After impact `number`.
    ///
    /// # Errors
    /// [`BreatherError::Undecided`] where all three are below their errors.
    pub(super) fn after(
        orbit: &ContactOrbit,
        motion: &ContactMotion<'_>,
        number: usize,
    ) -> Result<Self, BreatherError> {
        let impact = &orbit.impacts()[number];
        let last = last_at_once(orbit, motion, number);
        let velocity = velocity(orbit, number, last);
        if velocity.sign() != 0.0 {
            return Ok(Self::Leaves(0.0));
        }
        let contact = impact.site;
        let [_, _, acceleration, jerk] = motion.jet(contact, last, 0.0);
        let acceleration = Estimate { value: acceleration, error: acceleration_error(orbit, number, acceleration) };
        let jerk = Estimate { value: jerk, error: motion.error(contact, 3, last) };
        let decided = if acceleration.sign() == 0.0 { jerk.sign() } else { acceleration.sign() };
        // Away from the barrier is positive.
        let away = -impact.barrier.sign();
        match away * decided {
            0.0 => Err(BreatherError::Undecided { contact, impact: number }),
            decided if decided < 0.0 => Ok(Self::Rests(acceleration.value)),
            _ => {
                let flight = motion.until_next(last);
                let bound = motion.bound(contact, 4, last, [0.0, flight]);
                let bend = (away * acceleration.value - acceleration.error).max(0.0);
                Ok(Self::Leaves(convex(bend, away * jerk.value - jerk.error, bound).min(flight)))
            }
        }
    }
}

/// For half so long g″ surely keeps its sign: a + js − Bs²/2 is positive up to the root.
fn convex(acceleration: f64, jerk: f64, bound: f64) -> f64 {
    let root = (jerk * jerk + 2.0 * bound * acceleration).sqrt();
    // Without cancellation.
    let whole = if jerk > 0.0 { (jerk + root) / bound } else { 2.0 * acceleration / (root - jerk) };
    if whole.is_nan() { 0.0 } else { 0.5 * whole }
}

/// The last impact at the same instant: the flight after it is where the contact moves.
fn last_at_once(orbit: &ContactOrbit, motion: &ContactMotion<'_>, number: usize) -> usize {
    let count = orbit.impacts().len();
    let together = |i: usize| motion.until_next(i) <= TOGETHER * orbit.period();
    let later = (0..count).map(|more| (number + more) % count).find(|&i| !together(i));
    later.unwrap_or(number)
}

/// −e g′⁻, and what impacts of others at the same instant give to it.
fn velocity(orbit: &ContactOrbit, number: usize, last: usize) -> Estimate {
    let (impacts, structure) = (orbit.impacts(), orbit.model().structure());
    let impact = &impacts[number];
    let restitution = structure.contacts()[impact.site].restitution;
    let own = || structure.mobility(impact.site, impact.site);
    let mobility = orbit.response().mobility(impact.site).unwrap_or_else(own);
    let of_impulse = restitution / (1.0 + restitution) * mobility * orbit.estimate(number).impulse;
    let own = Estimate { value: impact.velocity_after, error: of_impulse + ROUNDING * impact.velocity_after.abs() };
    let count = impacts.len();
    let others = (1..=(last + count - number) % count).map(|more| (number + more) % count);
    others.fold(own, |sum, place| {
        let other = &impacts[place];
        let by = structure.mobility(impact.site, other.site);
        let given = by * other.impulse;
        let error = by.abs() * orbit.estimate(place).impulse + ROUNDING * given.abs();
        Estimate { value: sum.value + given, error: sum.error + error }
    })
}

/// That of g″⁺: the one before, and of what dashpots make the impact change.
fn acceleration_error(orbit: &ContactOrbit, number: usize, after: f64) -> f64 {
    let impact = &orbit.impacts()[number];
    let jump = (after - impact.acceleration).abs();
    let part = orbit.estimate(number).impulse / impact.impulse.abs().max(f64::MIN_POSITIVE);
    orbit.estimate(number).acceleration + jump * (part + ROUNDING) + ROUNDING * after.abs()
}

impl ContactOrbit {
    /// The acceleration after an impact that takes all velocity, where it turns the contact begins to rest; with its error. `None` of others.
    ///
    /// # Errors
    /// [`BreatherError`] at a resonance.
    pub fn acceleration_after(&self, number: usize) -> Result<Option<[f64; 2]>, BreatherError> {
        let Some(impact) = self.impacts().get(number) else { return Ok(None) };
        if self.model().structure().contacts()[impact.site].restitution != 0.0 {
            return Ok(None);
        }
        let motion = ContactMotion::new(self)?;
        let last = last_at_once(self, &motion, number);
        let [_, _, acceleration, _] = motion.jet(impact.site, last, 0.0);
        Ok(Some([acceleration, acceleration_error(self, number, acceleration)]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// While g″ ≥ a + js − Bs²/2 the least that it can be is positive for as long as told, and not for three times as long.
    #[test]
    fn a_contact_stays_away_as_long_as_told() {
        let mut checked = 0;
        for a in [0.0, 1e-12, 1e-3, 2.0] {
            for j in [-3.0, -1e-6, 0.0, 1e-6, 3.0] {
                for bound in [1e-3, 1.0, 1e6] {
                    let told = convex(a, j, bound);
                    let least = |s: f64| a + j * s - 0.5 * bound * s * s;
                    if a == 0.0 && j <= 0.0 {
                        assert_eq!(told, 0.0);
                        continue;
                    }
                    assert!(
                        told > 0.0 && (1..=100).all(|n| least(told * f64::from(n) / 100.0) > 0.0),
                        "{a} {j} {bound}"
                    );
                    assert!(least(3.0 * told) < 0.0, "{a} {j} {bound}");
                    checked += 1;
                }
            }
        }
        assert_eq!(checked, 51);
        assert!(convex(1.0, 1.0, 0.0) > 1e300);
    }
}
