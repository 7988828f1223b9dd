//! Bifurcation points of random models against conditions in 50 digits: what must vanish changes its sign within the error
//! that comes with the answer, and no point comes twice.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use vibrochain_breather::{Family, Hit, Orbit, breathers};
use vibrochain_floquet::{Event, Evidence, Located, Search, locate};
use vibrochain_lattice::{Chain, Model, Parameter, Part};
use vibrochain_testkit::Values::{Either, Even, Is, Log};
use vibrochain_testkit::{Random, Ranges};
use vibrochain_truth::{Complex, DEFAULT_BITS, Real, TrueOrbit, TrueSpectrum};

fn draw(random: &mut Random, families: &[Family]) -> (Model, Family) {
    let family = random.of(families);
    let slowest = if family == Family::PeriodDoubled { 0.7 } else { 0.4 };
    let model = random.model(&Ranges {
        sites: [2, 7],
        gamma1: Log(0.05, 0.8),
        gamma2: Log(1e-3, 0.4),
        omega: Log(slowest, 2.0),
        asymmetry: Either(1.0 / 3.0, &Is(0.0), &Even(0.0, 0.9)),
        amplitude: Log(0.05, 2.0),
        restitution: Log(0.05, 1.0),
    });
    (model, family)
}

/// The orbit in many digits at another value of the parameter, close by: from this one in steps over which it hardly moves,
/// or, where its impulses vanish and none is short enough, the one of the list that is nearest.
fn moved(orbit: &Orbit, free: Parameter, value: f64) -> Option<TrueOrbit> {
    let start = orbit.model().unwrap().get(free);
    let (mut here, mut gone, mut step) = (orbit.clone(), 0.0, 1.0);
    while step > 1e-2 {
        let to: f64 = gone + step;
        let Some(truth) = refined(&here, free, if to < 1.0 { start + to * (value - start) } else { value }) else {
            step *= 0.25;
            continue;
        };
        if to >= 1.0 {
            return Some(truth);
        }
        let hits: Vec<_> = truth
            .impacts()
            .iter()
            .map(|hit| Hit::new(hit.site, hit.barrier, hit.time.to_f64(), hit.impulse.to_f64()))
            .collect();
        here = Orbit::from_impulses(truth.model(), truth.force_periods(), truth.psi()?.to_f64(), &hits).ok()?;
        gone = to;
    }
    let list = breathers(&orbit.model().unwrap().with(free, value).ok()?, orbit.family()).ok()?.orbits;
    let strengths = |orbit: &Orbit| -> Vec<f64> { orbit.impacts().iter().map(|hit| hit.impulse).collect() };
    let apart = |other: &Orbit| {
        let pairs = strengths(orbit).into_iter().zip(strengths(other));
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    let nearest = list.iter().min_by(|a, b| apart(a).total_cmp(&apart(b)))?;
    (apart(nearest) < 1e-6).then(|| TrueOrbit::refine(nearest, DEFAULT_BITS).ok())?
}

/// The orbit in many digits that stands next to this one scaled.
fn refined(orbit: &Orbit, free: Parameter, value: f64) -> Option<TrueOrbit> {
    let model = orbit.model().unwrap().with(free, value).ok()?;
    let part = model.period() / orbit.model().unwrap().period();
    let hits: Vec<_> = orbit.impacts().iter().map(|hit| Hit { time: part * hit.time, ..Hit::from(hit) }).collect();
    let psi = part * orbit.psi()?;
    TrueOrbit::refine(&Orbit::from_impulses(&model, orbit.force_periods(), psi, &hits).ok()?, DEFAULT_BITS).ok()
}

/// What vanishes at the event.
fn condition(orbit: &TrueOrbit, event: Event, sign: Evidence) -> Option<Real> {
    let spectrum = TrueSpectrum::new(orbit).ok()?;
    let at = |z: f64| Some(spectrum.characteristic(&Complex::new(z, 0.0, 256))?.re);
    match (event, sign) {
        (Event::PeriodDoubling, _) => at(-1.0),
        (Event::NeimarkSacker, Evidence::Multiplier(multiplier)) => {
            let (found, _) = spectrum.refine((multiplier.re, multiplier.im)).ok()?;
            Some(found.norm_sqr() - 1.0)
        }
        _ => at(1.0),
    }
}

/// Whether the condition changes its sign within `times` the error.
fn holds(found: &Located, event: Event, free: Parameter, times: f64) -> Option<bool> {
    let reach = times * found.error.max(f64::EPSILON * found.value.abs());
    let side = |sign: f64| condition(&moved(&found.orbit, free, found.value + sign * reach)?, event, found.evidence);
    Some(side(-1.0)?.is_negative() != side(1.0)?.is_negative())
}

fn every_claim_holds(event: Event, families: &[Family], seed: u64, wanted: usize) {
    let mut random = Random(seed);
    let (mut checked, mut undecided, mut twice, mut wrong) = (0, 0, 0, Vec::new());
    while checked < wanted {
        let (model, family) = draw(&mut random, families);
        // What is claimed is held against lattices without dashpots.
        let all: Vec<Parameter> =
            Parameter::of(1).iter().copied().filter(|one| one.row().part != Part::Dashpots).collect();
        let free = random.of(&all);
        let Ok(list) = breathers(&model, family) else { continue };
        if list.orbits.is_empty() {
            continue;
        }
        let which = random.below(list.orbits.len());
        let orbit = &list.orbits[which];
        let search = Search::new(orbit, event, free);
        let Ok(answer) = locate(orbit, &search) else { continue };
        for place in &answer.unresolved {
            assert!(search.from <= place.from && place.from < place.to && place.to <= search.to, "{place:?}");
        }
        for (i, found) in answer.located.iter().enumerate() {
            let story = || {
                format!(
                    "{} {} {which} {model:?} {} ± {:e} {:?}",
                    family.name(),
                    free.name(),
                    found.value,
                    found.error,
                    found.evidence
                )
            };
            for other in &answer.located[..i] {
                // Two that are apart by more than their errors are two: each shows by a change of sign.
                let near = 16.0 * (found.error + other.error) + 1e-12 * found.value.abs();
                let known = (other.value - found.value).abs() < near && sign_distance(other, found) < 1e-3;
                if known {
                    println!("twice: {} {}", story(), other.value);
                    twice += 1;
                }
            }
            // No step is longer than a fiftieth of the range.
            assert!(found.error < 0.02 * (search.to - search.from), "{}", story());
            // A point that is no orbit has none in many digits to show it.
            if found.orbit.residual() > 1e-9 {
                println!("no orbit, residual {:e}: {}", found.orbit.residual(), story());
                wrong.push(None);
            }
            match holds(found, event, free, 1.0) {
                Some(true) => checked += 1,
                Some(false) => {
                    let by = (1..12).find(|&k| holds(found, event, free, 10f64.powi(k)) == Some(true));
                    println!("off by 10^{by:?} errors: {}", story());
                    wrong.push(by);
                    checked += 1;
                }
                None => {
                    println!("undecided: {}", story());
                    undecided += 1;
                }
            }
        }
    }
    println!("{event:?}: {checked} checked, {undecided} undecided, {twice} twice, {} wrong", wrong.len());
    assert!(wrong.is_empty() && twice == 0 && undecided <= wanted / 50);
}

/// Distance of the multipliers that two events stand for.
fn sign_distance(a: &Located, b: &Located) -> f64 {
    match (a.evidence, b.evidence) {
        (Evidence::Multiplier(a), Evidence::Multiplier(b)) => (a - b).norm(),
        _ => f64::INFINITY,
    }
}

const ALL: [Family; 3] = [Family::SingleSided, Family::DoubleSided, Family::PeriodDoubled];

#[test]
fn neimark_sacker_points() {
    every_claim_holds(Event::NeimarkSacker, &ALL, 1025, 80);
}

#[test]
fn period_doublings() {
    every_claim_holds(Event::PeriodDoubling, &ALL, 1026, 80);
}

#[test]
#[ignore = "a minute: cargo test --workspace --test located -- --ignored slow"]
fn slow_hundreds_of_claims_hold() {
    every_claim_holds(Event::NeimarkSacker, &ALL, 1025, 200);
    every_claim_holds(Event::PeriodDoubling, &ALL, 1026, 200);
}

/// det(M+1) has a pole where an impulse vanishes, and changes its sign there: period doublings were claimed with errors up to 1.5.
#[test]
fn no_period_doubling_where_an_impulse_vanishes() {
    type Point = (usize, [f64; 2], f64, f64, f64, f64);
    let at = |(sites, gamma, omega, asymmetry, amplitude, restitution): Point| {
        let chain = Chain::new(sites, gamma[0], gamma[1]).unwrap();
        chain.point().omega(omega).asymmetry(asymmetry).amplitude(amplitude).restitution(restitution).model().unwrap()
    };
    let (single, double) = (Family::SingleSided, Family::DoubleSided);
    let (mut passed, mut checked) = (0, 0);
    for (family, free, which, point) in [
        (
            single,
            Parameter::Asymmetry,
            1,
            (
                6,
                [0.13128215970411553, 0.03235024838886176],
                0.9351463226213632,
                0.14658371304857037,
                0.6430170251262677,
                0.4377708621646284,
            ),
        ),
        (
            double,
            Parameter::Amplitude,
            1,
            (
                6,
                [0.21215714324021337, 0.0018296048747921863],
                1.3174773368790378,
                0.24191272035863817,
                1.5090393646901175,
                0.23771400063522716,
            ),
        ),
        (
            double,
            Parameter::Asymmetry,
            1,
            (
                6,
                [0.3011450330381241, 0.009747549763144266],
                1.113074635812392,
                0.0,
                0.5949017946505337,
                0.8000338775474019,
            ),
        ),
        (
            single,
            Parameter::Asymmetry,
            1,
            (
                7,
                [0.0862821248702133, 0.04290155138883672],
                1.0760725391123347,
                0.0,
                0.7084164423085295,
                0.46704222393852757,
            ),
        ),
        // Of another search over frequency.
        (
            single,
            Parameter::Omega,
            0,
            (
                3,
                [0.5634290634011464, 0.000723177781571438],
                0.8110496069729074,
                0.1217098569379993,
                0.1189976266655569,
                0.19196072991101001,
            ),
        ),
    ] {
        let orbit = &breathers(&at(point), family).unwrap().orbits[which];
        let search = |event| locate(orbit, &Search::new(orbit, event, free)).unwrap();
        // The branch passes an impact without speed.
        let without_speed = |found: &Located| matches!(found.evidence, Evidence::Impact(_));
        passed += search(Event::Grazing).located.iter().filter(|found| without_speed(found)).count();
        for found in search(Event::PeriodDoubling).located {
            assert!(found.error < 1e-9, "{} ± {:e}", found.value, found.error);
            assert!(found.orbit.impacts().iter().all(|hit| hit.impulse.abs() > 1e-9), "{found:?}");
            assert_eq!(holds(&found, Event::PeriodDoubling, free, 1.0), Some(true), "{found:?}");
            checked += 1;
        }
    }
    assert!(passed >= 5 && checked >= 1, "{passed} {checked}");
}

/// Rounding moves |μ| = 1 by more than a step of the branch.
#[test]
fn what_rounding_hides_is_not_claimed() {
    let chain = Chain::new(6, 0.5155634975092167, 0.001196266818595037).unwrap();
    let (omega, a, amplitude, e) = (1.2437879739461413, 0.8436503755841729, 1.5999503171718452, 0.9999999998293126);
    let model = chain.point().omega(omega).asymmetry(a).amplitude(amplitude).restitution(e).model().unwrap();
    let orbit = &breathers(&model, Family::DoubleSided).unwrap().orbits[0];
    let answer = locate(orbit, &Search::new(orbit, Event::NeimarkSacker, Parameter::Gamma1)).unwrap();
    assert!(!answer.unresolved.is_empty());
    assert!(answer.unresolved.iter().all(|place| place.from < place.to && place.to - place.from < 0.02), "{answer:?}");
}

/// Where an impulse vanishes all pairs that it damps cross the circle at once, and the norm of the matrix is beyond bounds: that is told as the
/// grazing, and as no crossing of any of them.
#[test]
fn pairs_that_cross_where_an_impact_has_no_speed_are_a_grazing() {
    let few = Chain::new(3, 0.5634290634011464, 0.000723177781571438).unwrap();
    let many = Chain::new(7, 0.3147881568261216, 0.010101123740918238).unwrap();
    let point = few.point().omega(0.8110496069729074).asymmetry(0.1217098569379993);
    let single = point.amplitude(0.1189976266655569).restitution(0.19196072991101001).model();
    let double =
        many.point().omega(1.25493740972605).amplitude(1.2061699217080546).restitution(0.19064866532199548).model();
    let event = Event::NeimarkSacker;
    for (model, family, which, free, from, to) in [
        (single, Family::SingleSided, 0, Parameter::Omega, 0.6180658545154553, 1.0855360650147243),
        (double, Family::DoubleSided, 1, Parameter::Amplitude, 1.1088245130508192, 1.267455773691816),
    ] {
        let orbit = &breathers(&model.unwrap(), family).unwrap().orbits[which];
        let [crossings, grazings] =
            [event, Event::Grazing].map(|event| locate(orbit, &Search { event, free, from, to }).unwrap().located);
        assert!(crossings.is_empty(), "{crossings:?}");
        let found = grazings.iter().find(|one| one.orbit.impacts()[0].impulse.abs() < 1e-9).unwrap();
        assert!(found.error < 1e-9, "{found:?}");
        // At the grazing itself there is no impact to be refined.
        let [below, above] = [1.0 - 1e-6, 1.0 + 1e-6].map(|part| {
            let list =
                breathers(&orbit.model().unwrap().with(free, part * found.value).unwrap(), family).unwrap().orbits;
            let strength = |orbit: &&Orbit| orbit.impacts()[0].impulse.abs();
            let nearest = list.iter().min_by(|a, b| strength(a).total_cmp(&strength(b))).unwrap();
            TrueOrbit::refine(nearest, DEFAULT_BITS).unwrap().impacts()[0].impulse.is_negative()
        });
        assert!(below != above, "{} ± {:e}", found.value, found.error);
    }
}

/// Without force: the edges of thin stripes are known to some units of the last digit.
#[test]
fn period_doublings_of_a_conservative_orbit() {
    let model = Model::conservative(Chain::new(11, 0.2, 0.1).unwrap(), 1.3, 0.4).unwrap();
    let orbit = &breathers(&model, Family::DoubleSided).unwrap().orbits[0];
    let search = Search { event: Event::PeriodDoubling, free: Parameter::Omega, from: 1.05, to: 1.6 };
    let answer = locate(orbit, &search).unwrap();
    let condition = |orbit: &Orbit, value: f64| {
        let there = model.with(Parameter::Omega, value).unwrap();
        let part = there.period() / orbit.model().unwrap().period();
        let hits: Vec<Hit> =
            orbit.impacts().iter().map(|hit| Hit { time: part * hit.time, ..Hit::from(hit) }).collect();
        let moved = Orbit::from_impulses(&there, 1, 0.0, &hits).unwrap();
        let spectrum = TrueSpectrum::new(&TrueOrbit::refine(&moved, DEFAULT_BITS).unwrap()).unwrap();
        spectrum.characteristic(&Complex::new(-1.0, 0.0, 256)).unwrap().re.is_negative()
    };
    for one in &answer.located {
        let reach = one.error.max(f64::EPSILON * one.value);
        let [below, above] = [-reach, reach].map(|by| condition(&one.orbit, one.value + by));
        println!("{} ± {:e}: {below} {above}", one.value, one.error);
        assert!(below != above && one.error < 1e-12, "{} ± {:e}", one.value, one.error);
    }
    assert!(answer.located.len() >= 4, "{}", answer.located.len());
}
