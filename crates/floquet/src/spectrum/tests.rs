//! Errors of multipliers against the same equations written down otherwise: in another unit of time, with modes in another order.

use vibrochain_breather::{BlochEquations, Family, Finder, LinearImpact, breathers};
use vibrochain_lattice::{BlochKernel, Chain, Spectrum};
use vibrochain_testkit::Random;

use super::clusters::zeros;
use super::function::SpectralFunction;
use super::refine::{DataError, Origin};
use super::verdict::{origins, told};
use super::zero::Zero;
use crate::analyser::Analyser;
use crate::verdict::Tolerance;
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

/// Impacts of no loss between undamped modes, which may begin at any time.
fn lossless(random: &mut Random) -> BlochEquations {
    let (modes, contacts, period) = (2 + random.below(6), 1 + random.below(3), random.between(2.0, 6.0));
    let mut kernel = BlochKernel::new(period, contacts);
    for _ in 0..modes {
        let shapes: Vec<f64> = (0..contacts).map(|_| random.between(-1.0, 1.0)).collect();
        kernel.push_oscillator(random.log(0.3, 5.0), 0.0, &shapes);
    }
    let impact = |i: usize, random: &mut Random| LinearImpact {
        contact: random.below(contacts),
        time: period * (i as f64 + random.between(0.0, 0.9)) / 4.0,
        impulse: random.between(0.3, 2.0),
        restitution: 1.0,
        acceleration_before: 0.0,
    };
    let impacts = (0..2 + random.below(3)).map(|i| impact(i, random)).collect();
    BlochEquations::conservative(kernel, impacts)
}

/// The same equations with their impacts changed, and what J₀ holds of accelerations over ωP then.
fn with_impacts(
    equations: &BlochEquations,
    conservative: bool,
    impacts: Vec<LinearImpact>,
) -> (BlochEquations, Vec<f64>) {
    let kernel = equations.kernel().clone();
    let changed =
        if conservative { BlochEquations::conservative(kernel, impacts) } else { BlochEquations::new(kernel, impacts) };
    let size = changed.size();
    let slides = (0..size / 2).map(|i| changed.constant(false)[(2 * i + 1) * (size + 1)]).collect();
    (changed, slides)
}

/// A time, an impulse or an acceleration that is off moves each multiplier by as much as is told: by finite differences, to a part of a hundred.
#[test]
fn each_datum_moves_each_multiplier_as_far_as_is_told() {
    let mut random = Random(78);
    let mut checked = [[0; 3]; 2];
    for round in 0..400 {
        let conservative = round % 2 == 1;
        let equations = if conservative { lossless(&mut random) } else { equations(&mut random, 1.0, false) };
        let function = SpectralFunction::new(&equations, conservative);
        if function.shift.is_some() != conservative {
            continue;
        }
        let (n, omega, h) = (equations.impacts().len(), equations.omega(), 1e-6);
        // An impulse alone is felt by way of an orbit's own derivative.
        let (i, kind) = (random.below(n), if conservative { random.below(2) } else { 2 * random.below(2) });
        let aside = |by: f64| {
            let mut impacts = equations.impacts().to_vec();
            match kind {
                0 => impacts[i].time += by,
                1 => {
                    impacts[i].impulse *= 1.0 + by;
                    impacts[i].acceleration_before *= 1.0 + by;
                }
                _ => impacts[i].acceleration_before += by * omega * impacts[i].impulse,
            }
            with_impacts(&equations, conservative, impacts)
        };
        let ([(minus, low), (plus, high)], mut origin) = ([-h, h].map(aside), Origin::default());
        for j in 0..n {
            let slide = 0.5 * (high[j] - low[j]);
            let of_impact = |of: usize| if j == i && kind == of { h } else { 0.0 };
            origin.push(DataError { slide, time: of_impact(0), share: of_impact(1) });
        }
        for zero in zeros(&equations, conservative, &[]).list.iter().filter(|zero| zero.settled) {
            let ask = |equations: &BlochEquations, data: &[Origin]| {
                SpectralFunction::new(equations, conservative).refine(zero.z, data)
            };
            let (Some(exact), Some(told)) = (ask(&equations, &[]), ask(&equations, std::slice::from_ref(&origin)))
            else {
                continue;
            };
            let (Some(minus), Some(plus)) = (ask(&minus, &[]), ask(&plus, &[])) else { continue };
            let (moved, told) = (0.5 * modulus(plus.z - minus.z), told.error - exact.error);
            let bent = 0.5 * modulus(plus.z + minus.z - exact.z * 2.0);
            if exact.error > 1e-3 * moved || bent > 1e-3 * moved {
                continue;
            }
            assert!((told / moved - 1.0).abs() < 0.01, "{round} {kind} {i} {}: {moved:e} {told:e}", zero.z);
            checked[usize::from(conservative)][kind] += 1;
        }
    }
    let [lossy, lossless] = checked;
    assert!(lossy[0].min(lossy[2]) > 200 && lossless[0].min(lossless[1]) > 200, "{checked:?}");
}

/// A step that is enough is within its error of the multiplier, and what bounds the data's errors is no less than they are.
#[test]
fn a_step_that_is_enough_is_within_its_error() {
    let mut random = Random(79);
    let (mut checked, mut felt) = (0, 0);
    for round in 0..200 {
        let equations = lossless(&mut random);
        let function = SpectralFunction::new(&equations, true);
        if function.shift.is_none() {
            continue;
        }
        let size = random.log(1e-14, 1e-10);
        let mut datum = || DataError {
            slide: size * random.between(-1.0, 1.0),
            time: size * random.between(-1.0, 1.0),
            share: size * random.between(-1.0, 1.0),
        };
        let data: [Origin; 2] = [(); 2].map(|()| equations.impacts().iter().map(|_| datum()).collect());
        for zero in zeros(&equations, true, &[]).list.iter().filter(|zero| zero.settled) {
            let Some(exact) = function.refine(zero.z, &data) else { continue };
            for off in [0.0, 1e-9, 1e-7] {
                let Some(step) = function.refine_to(1e-6, exact.z + off, &data) else { continue };
                let name = format!("{round} {off} {exact:?} {step:?}");
                assert!(modulus(step.z - exact.z) <= step.rounding + exact.rounding, "{name}");
                // The length of the step is in both errors.
                assert!(step.error - step.rounding >= 0.999 * (exact.error - exact.rounding), "{name}");
                checked += 1;
                felt += usize::from(exact.error > 10.0 * exact.rounding && off == 0.0);
            }
        }
    }
    assert!(checked > 600 && felt > 100, "{checked} {felt}");
}

/// A period that is off by a part moves the multipliers no farther than is told of it, whether modes swing, creep or do both, next to their
/// poles and away from them; and what is told is no idle number.
#[test]
fn a_period_that_is_off_moves_multipliers_within_their_errors() {
    let (part, mut checked, mut near) = (1e-9, [0; 3], [0; 3]);
    for seed in 0..240 {
        let kind = seed as usize % 3;
        let made = |part: f64| {
            let mut random = Random(2000 + seed);
            let period = random.between(1.0, 5.0);
            let mut kernel = BlochKernel::new(period * (1.0 + part), 1);
            for _ in 0..1 + random.below(3) {
                let damping = [random.log(1e-3, 0.5), 1.0, 1.0 + random.log(1e-2, 1.0)][kind];
                // Hardly felt, a mode leaves its multipliers next to its poles.
                kernel.push_oscillator(random.log(0.1, 2.0), damping, &[random.log(1e-4, 1.0)]);
            }
            let impact = LinearImpact {
                contact: 0,
                time: 0.0,
                impulse: random.between(0.2, 2.0),
                restitution: random.between(0.3, 0.99),
                acceleration_before: random.between(-1.0, 1.0),
            };
            (kernel, impact)
        };
        let [(kernel, impact), (longer, later)] = [0.0, part].map(made);
        let told = BlochEquations::new(kernel.of_uncertain_period(part), vec![impact]);
        let moved = BlochEquations::new(longer, vec![later]);
        let [told, moved] = [told, moved].map(|equations| zeros(&equations, false, &[]));
        if !(told.certified && moved.certified) {
            continue;
        }
        for zero in &told.list {
            let off = moved.list.iter().map(|other| modulus(other.z - zero.z)).fold(f64::INFINITY, f64::min);
            assert!(off <= zero.error, "{seed} {}: {off:e} {:e}", zero.z, zero.error);
            checked[kind] += 1;
            near[kind] += usize::from(zero.error < 100.0 * off);
        }
    }
    assert!(checked.iter().all(|count| *count > 80), "{checked:?}");
    assert!(near.iter().zip(checked).all(|(near, checked)| 2 * near > checked), "{near:?} {checked:?}");
}

/// Next to a resonance an orbit's own errors mix multipliers that are far apart: its equations are counted as they are, and no multiplier is
/// lost, or they are not counted. Rings of 1 to 8 masses, hardly coupled, against the eigenvalues of a matrix.
#[test]
fn next_to_resonances_no_verdict_of_the_equations_is_false() {
    let tolerance = Tolerance::Rounding;
    let (mut random, mut dense) = (Random(97), Analyser::dense());
    let (mut claims, mut uncounted, mut unstable, mut wrong) = ([0; 2], 0, [0; 2], Vec::new());
    // Of these two a radius of 2.6 could be taken for 1 ± 0.03, and one that is 4.5e-8 away for known to 4.4e-9.
    let lossless = Chain::new(4, 0.43400692865900176, 0.0010022677886832544).unwrap().point();
    let lossless = lossless.omega(0.3301549433761315).asymmetry(0.0731860578923146).model().unwrap();
    let forced = Chain::new(4, 0.8043304507464611, 0.0013359481506561625).unwrap().point();
    let forced = forced.omega(0.2994443633954566).asymmetry(0.06461518481993055);
    let forced = forced.amplitude(0.287803569948888).restitution(0.6461665472837259).model().unwrap();
    let mut models = vec![(lossless, false), (forced, true)];
    while models.len() < 600 {
        let (masses, is_forced) = (1 + random.below(8), random.chance(0.5));
        let chain = Chain::new(masses, random.between(0.05, 1.0), random.log(1e-4, 1e-2)).unwrap();
        let spectrum = Spectrum::new(chain);
        let near = random.of(spectrum.frequencies()) / (1 + random.below(3)) as f64;
        let omega = near * (1.0 + random.of(&[1.0, -1.0]) * random.log(1e-9, 1e-2));
        let point = chain.point().omega(omega).asymmetry(random.between(0.0, 0.8));
        let forced = point.amplitude(random.between(0.02, 0.3)).restitution(random.between(0.5, 1.0));
        models.push(((if is_forced { forced } else { point }).model().unwrap(), is_forced));
    }
    for (model, is_forced) in models {
        let mut finder = Finder::new(model.chain().sites());
        for family in [Family::SingleSided, Family::DoubleSided] {
            let Ok(found) = breathers(&model, family) else { continue };
            for orbit in &found.orbits {
                let Ok(known) = orbit.at_contacts(finder.stop()) else { continue };
                let (equations, _) = known.bloch_equations();
                let data = origins(&equations, known.error_origins());
                let Ok((verdict, multipliers)) = told(&equations, !is_forced, &data, tolerance) else {
                    uncounted += 1;
                    continue;
                };
                let Ok(right) = dense.stability(orbit, &mut finder, tolerance) else { continue };
                let error = verdict.resolution + right.verdict.resolution;
                let radius = right.verdict.spectral_radius;
                let room = 1e-12 * (1.0 + radius);
                let off = (verdict.spectral_radius - radius).abs();
                let decided = !verdict.undecided && !right.verdict.undecided;
                if off > 4.0 * error + room || decided && verdict.stable != right.verdict.stable {
                    wrong.push(format!("{model} {family:?}: {verdict:?} {multipliers:?} {right:?}"));
                }
                claims[usize::from(is_forced)] += 1;
                unstable[usize::from(is_forced)] += usize::from(radius > 1.1 && !verdict.undecided);
            }
        }
    }
    assert!(wrong.is_empty(), "{} of {claims:?}: {}", wrong.len(), wrong[0]);
    assert!(claims.iter().all(|count| *count > 900) && 8 * uncounted < claims[0] + claims[1], "{claims:?} {uncounted}");
    assert!(unstable.iter().all(|count| *count > 80), "{unstable:?}");
}
