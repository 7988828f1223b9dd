//! Errors of multipliers against the same equations written down otherwise: in another unit of time, with modes in another order.

use vibrochain_breather::{BlochEquations, LinearImpact};
use vibrochain_lattice::BlochKernel;
use vibrochain_testkit::Random;

use super::solve::{Zero, zeros};
use crate::zeros::modulus;

/// One to nine modes that die, one impact to three at one contact or two, in units of time so many times shorter, modes from the first or the last.
fn equations(random: &mut Random, unit: f64, backwards: bool) -> BlochEquations {
    let (count, contacts, period) = (1 + random.below(9), 1 + random.below(2), random.between(1.0, 8.0));
    let mut modes: Vec<(f64, f64, Vec<f64>)> = (0..count)
        .map(|_| {
            let shapes = (0..contacts).map(|_| random.between(-1.0, 1.0)).collect();
            (random.log(0.3, 30.0), random.log(1e-4, 0.9), shapes)
        })
        .collect();
    if backwards {
        modes.reverse();
    }
    let mut kernel = BlochKernel::new(period * unit, contacts);
    modes.iter().for_each(|(frequency, damping, shapes)| kernel.push_oscillator(frequency / unit, *damping, shapes));
    let impact = |i: usize, random: &mut Random| LinearImpact {
        contact: random.below(contacts),
        time: unit * period * (i as f64 + random.between(0.0, 0.9)) / 3.0,
        impulse: random.between(0.2, 2.0) / unit,
        restitution: random.between(0.3, 0.99),
        acceleration_before: random.between(-1.0, 1.0) / (unit * unit),
    };
    let impacts = (0..1 + random.below(3)).map(|i| impact(i, random)).collect();
    BlochEquations::new(kernel, impacts)
}

/// What rounding makes of a multiplier is within its error, and errors are no idle numbers: of each list they are within a thousand times what two
/// ways of rounding differ by at their worst.
#[test]
fn errors_of_multipliers_cover_what_rounding_does() {
    let (mut compared, mut lists, mut near) = (0, 0, 0);
    for seed in 0..300 {
        let written = |unit: f64, backwards: bool| equations(&mut Random(1000 + seed), unit, backwards);
        let [one, other] = [written(1.0, false), written(3.0, true)].map(|own| zeros(&own, false, &[]));
        if !(one.certified && other.certified) {
            continue;
        }
        lists += 1;
        let mut worst = 0.0_f64;
        for zero in &one.list {
            let away = |other: &&Zero| modulus(other.z - zero.z);
            let nearest = other.list.iter().min_by(|a, b| away(a).total_cmp(&away(b))).unwrap();
            let (off, error) = (away(&nearest), zero.error + nearest.error);
            assert!(off <= error, "{seed}: {} {off:e} {error:e}", zero.z);
            worst = worst.max(off / error);
            compared += 1;
        }
        near += usize::from(worst > 1e-3);
    }
    assert!(lists > 200 && compared > 1000 && near > lists * 3 / 4, "{lists} {compared} {near}");
}
