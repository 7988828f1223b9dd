//! The linearised equations of an orbit as its data are given, however it would be refined.

use vibrochain_breather::{BlochEquations, LinearImpact, Orbit};

/// J(z) of the impacts of an orbit as it has them.
pub fn equations_as_given(orbit: &Orbit) -> BlochEquations {
    let (model, sites) = (orbit.model().unwrap(), orbit.hit_sites());
    let contacts: Vec<Vec<usize>> = sites.iter().map(|site| vec![*site]).collect();
    let hit: Vec<usize> = (0..sites.len()).collect();
    let felt = model.felt_structure(&contacts).unwrap().participating_modes(&hit);
    let kernel = felt.kernel(orbit.period(), &hit);
    let impacts = orbit.impacts().iter().map(|impact| LinearImpact {
        contact: sites.iter().position(|site| *site == impact.site).unwrap(),
        time: impact.time,
        impulse: impact.impulse,
        restitution: model.restitution(),
        acceleration_before: impact.acceleration,
    });
    let impacts = impacts.collect();
    if model.is_conservative() {
        BlochEquations::conservative(kernel, impacts)
    } else {
        BlochEquations::new(kernel, impacts)
    }
}
