//! What tests against many digits share.

use vibrochain_breather::{Condition, Orbit};
use vibrochain_truth::TrueOrbit;

/// The errors that an orbit's condition claims, against many digits.
pub(crate) fn assert_claims_hold(orbit: &Orbit, condition: &Condition, truth: &TrueOrbit) {
    for ((impact, true_impact), claimed) in orbit.impacts().iter().zip(truth.impacts()).zip(&condition.impacts) {
        let errors = [
            (&true_impact.impulse - impact.impulse, claimed.impulse),
            (&true_impact.time - impact.time, claimed.time),
            (&true_impact.acceleration - impact.acceleration, claimed.acceleration),
        ];
        for (error, claimed) in errors {
            let error = error.to_f64().abs();
            // Without equality a time at 0 would have to be better than exact.
            assert!(error <= claimed.max(f64::EPSILON), "{error:e} {claimed:e} {orbit:?}");
        }
    }
}
