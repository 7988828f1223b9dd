//! Zeros outside a circle by the turns along it, against dense eigenvalues of the whole monodromy matrix.

use vibrochain_breather::{Condition, Finder, Hit, Orbit};
use vibrochain_lattice::{Barrier, Chain, Model};
use vibrochain_testkit::{Ranges, Values};

use super::Random;
use crate::eigen::eigenvalues;
use crate::secular::OutsideCircle;

/// Impacts of whatever times and strengths at two to five sites: whether they are motions between barriers does not matter here.
#[test]
fn zeros_outside_are_those_of_the_whole_lattice() {
    let (mut random, mut circle) = (Random(51), OutsideCircle::default());
    let ranges =
        Ranges { sites: [3, 9], gamma1: Values::Log(0.05, 1.0), gamma2: Values::Log(0.01, 0.4), ..Ranges::FORCED };
    let (mut counted, mut on_unit_circle, mut some, mut many, mut layered, mut refused) = (0, 0, 0, 0, 0, 0);
    for case in 0..150 {
        let chain: Chain = if case % 2 == 0 { random.chain(&ranges) } else { random.lattice(&ranges) };
        let sites = chain.sites();
        let e = if case % 5 == 0 { 1.0 } else { random.between(0.3, 0.999) };
        let model = Model::forced(chain, random.between(0.7, 2.5), 0.3, 0.2, e).unwrap();
        let mut times: Vec<f64> = (0..2 + random.below(6)).map(|_| random.unit() * model.period()).collect();
        times.sort_by(f64::total_cmp);
        let mut hit = |time: &f64| {
            let barrier = if random.chance(0.5) { Barrier::Upper } else { Barrier::Lower };
            Hit::new(random.below(sites.min(5)), barrier, *time, -barrier.sign() * random.between(0.5, 2.0))
        };
        let hits: Vec<Hit> = times.iter().map(&mut hit).collect();
        let orbit = Orbit::from_impulses(&model, 1, 0.4, &hits).unwrap();
        if orbit.impact_site().is_some() {
            continue;
        }
        let mut values = Vec::new();
        eigenvalues(&crate::full_monodromy(&orbit).unwrap(), &mut values).unwrap();
        let mut finder = Finder::new(sites);
        if circle.set(finder.prepared(&orbit).unwrap(), &Condition::default()).is_err() {
            refused += 1;
            continue;
        }
        for distance in [0.0, 1e-6, random.log(1e-5, 0.1), random.log(0.1, 10.0), 30.0] {
            let doubtful = |value: f64| (value - distance).abs() < 1e-9 * (1.0 + value.abs());
            // Modes that feel no impact are on the unit circle, and no zeros.
            let outside = values.iter().map(|z| z.norm() - 1.0).filter(|value| *value > distance.max(1e-9));
            let open = outside.clone().any(doubtful) || e == 1.0 && distance == 0.0;
            let near = distance == 0.0 && values.iter().any(|z| (z.norm() - 1.0).abs() < 1e-8);
            if open {
                continue;
            }
            let Ok(turns) = circle.turns(1.0 + distance) else {
                assert!(distance <= 1e-6, "{distance} {model}");
                refused += 1;
                continue;
            };
            assert!(
                near || turns.outside == outside.clone().count(),
                "{distance} {} {model} {values:?}",
                turns.outside
            );
            counted += usize::from(!near);
            on_unit_circle += usize::from(distance == 0.0 && !near);
            some += usize::from(turns.outside > 0);
            many += usize::from(turns.outside > 3);
            layered += usize::from(chain.layers() > 1);
        }
    }
    let counts = [counted, on_unit_circle, some, many, layered, refused];
    println!("{counts:?}");
    assert!(counted > 350 && on_unit_circle > 30 && some > 150 && many > 50 && layered > 50, "{counts:?}");
    assert!(refused < counted / 20, "{counts:?}");
}
