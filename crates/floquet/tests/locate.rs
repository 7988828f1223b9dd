//! Bifurcation points with digits known from elsewhere (the errata of the paper), and answers where there is no event.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use vibrochain_breather::{BreatherError, Family, Motion, Orbit, breathers};
use vibrochain_floquet::{
    Answer, Course, End, Event, EventSide, Evidence, LocateError, Located, Mechanism, Search, Unresolved,
    diagram_until, eigenvalues, full_monodromy, locate, locate_until,
};
use vibrochain_lattice::{Barrier, Chain, Force, Harmonic, ImpulseResponse, Model, Parameter, Point, Spectrum, Stop};
use vibrochain_testkit::Values::{Is, Log};
use vibrochain_testkit::{Random, Ranges};

fn model(gamma: (f64, f64), omega: f64, asymmetry: f64, force: (f64, f64)) -> Model {
    let ring = Point::ring(21).gamma1(gamma.0).gamma2(gamma.1);
    ring.omega(omega).asymmetry(asymmetry).amplitude(force.0).restitution(force.1).model().unwrap()
}

fn orbit(model: &Model, family: Family, which: usize) -> Orbit {
    breathers(model, family).unwrap().orbits.swap_remove(which)
}

fn search(orbit: &Orbit, event: Event, free: Parameter, range: Option<(f64, f64)>) -> Answer {
    let mut search = Search::new(orbit, event, free);
    if let Some((from, to)) = range {
        (search.from, search.to) = (from, to);
    }
    locate(orbit, &search).unwrap()
}

/// The single-sided breather that doubles its period and folds.
fn doubling() -> Orbit {
    orbit(&model((0.2, 0.1), 1.07, 0.8, (0.165, 0.25)), Family::SingleSided, 0)
}

#[test]
fn period_doubling_of_the_errata_hands_over_to_the_doubled_orbit() {
    let answer = search(&doubling(), Event::PeriodDoubling, Parameter::Amplitude, None);
    let found = &answer.located[0];
    // Three more digits than the nine of the errata.
    assert!((found.value - 0.158908086).abs() < 5e-10, "{}", found.value);
    assert!(found.error < 1e-12, "{:e}", found.error);
    let Evidence::Multiplier(multiplier) = found.evidence else { panic!("{:?}", found.evidence) };
    assert!((multiplier + 1.0).norm() < 1e-10);
    // Supercritical: below it the single-sided orbit is unstable and the doubled one stable.
    let [below, above] = found.sides.as_slice() else { panic!("{:?}", found.sides) };
    assert!(below.value < found.value && found.value < above.value);
    assert_eq!([below.physical, above.physical], [Some(true); 2]);
    let [below, above] = [below.stability, above.stability];
    assert!(below.mechanism == Some(Mechanism::PeriodDoubling) && above.stable);
    let branching = found.branching.as_ref().unwrap();
    assert!(!branching.above && branching.value < found.value);
    let [doubled] = branching.orbits.as_slice() else { panic!("{branching:?}") };
    assert!(doubled.physical == Some(true) && doubled.verdict.is_some_and(|verdict| verdict.stable));
    assert_eq!(doubled.orbit.family(), Family::PeriodDoubled);
}

#[test]
fn fold_of_the_errata_where_the_force_is_just_strong_enough() {
    let answer = search(&doubling(), Event::Fold, Parameter::Amplitude, None);
    let found = &answer.located[0];
    // The least amplitude of the quadratic for the impulse, which knows nothing of branches.
    let weak = model((0.2, 0.1), 1.07, 0.8, (0.1, 0.25));
    let reason = breathers(&weak, Family::SingleSided).unwrap().completeness.reason().unwrap();
    let vibrochain_breather::NoBreather::ForceTooWeak { threshold } = reason else { panic!("{reason:?}") };
    assert!((found.value - threshold).abs() < 1e-14, "{} {threshold}", found.value);
    assert!((found.value - 0.157927457267).abs() < 1e-12);
    assert!(found.error < 1e-14 && (found.value - threshold).abs() <= found.error, "{:e}", found.error);
    // Looking for something else, the fold is where the way ends.
    let answer = search(&doubling(), Event::NeimarkSacker, Parameter::Amplitude, Some((0.15, 0.166)));
    assert!(matches!(answer.ends[0], (value, End::Fold { .. }) if (value - threshold).abs() < 1e-14));
}

#[test]
fn neimark_sacker_of_the_errata() {
    let start = orbit(&model((0.2, 0.1), 0.92, 0.7, (0.05, 0.9)), Family::SingleSided, 0);
    let answer = search(&start, Event::NeimarkSacker, Parameter::Gamma2, Some((0.07, 0.11)));
    // Pairs cross that do not lead, too: this is the one where stability is lost.
    let lost =
        |sides: &[EventSide]| matches!(sides, [below, above] if below.stability.stable != above.stability.stable);
    let found = answer.located.iter().find(|found| lost(&found.sides)).unwrap();
    assert!((found.value - 0.088347387971).abs() < 1e-12, "{}", found.value);
    assert!(found.error < 1e-11, "{:e}", found.error);
    let Evidence::Multiplier(multiplier) = found.evidence else { panic!("{:?}", found.evidence) };
    assert!((multiplier.norm() - 1.0).abs() < 1e-13 && multiplier.im != 0.0);
}

#[test]
fn grazing_of_the_errata_from_both_families() {
    let expected = 0.9304428418073;
    let start = orbit(&model((0.2, 0.1), 0.92, 0.4, (0.1, 0.9)), Family::SingleSided, 0);
    let answer = search(&start, Event::Grazing, Parameter::Omega, Some((0.9, 0.95)));
    let found = &answer.located[0];
    assert!((found.value - expected).abs() < 1e-13, "{}", found.value);
    assert!(found.error < 1e-13, "{:e}", found.error);
    let Evidence::Touch(touch) = found.evidence else { panic!("{:?}", found.evidence) };
    assert_eq!((touch.site, touch.barrier), (0, Barrier::Upper));
    assert!((touch.time / found.orbit.period() - 0.51121).abs() < 1e-5);
    // The double-sided one ends there, where its impact on the upper barrier has no velocity left.
    let start = orbit(&model((0.2, 0.1), 0.95, 0.4, (0.1, 0.9)), Family::DoubleSided, 0);
    let answer = search(&start, Event::Grazing, Parameter::Omega, Some((0.9, 1.0)));
    let found = &answer.located[0];
    assert!((found.value - expected).abs() < 1e-13, "{}", found.value);
    assert_eq!(found.evidence, Evidence::Impact(0));
    assert!(found.orbit.impacts()[0].impulse.abs() < 1e-13);
}

#[test]
fn pitchfork_of_figure_nine_from_the_symmetric_orbit_and_from_the_pair() {
    let expected = 0.524585314448;
    let at = |e: f64| model((0.1, 0.05), 1.33, 0.0, (1.5, e));
    for (e, which) in [(0.5, 0), (0.6, 1), (0.6, 0), (0.6, 3)] {
        let start = orbit(&at(e), Family::DoubleSided, which);
        let answer = search(&start, Event::Pitchfork, Parameter::Restitution, Some((0.4, 0.7)));
        let found = &answer.located[0];
        assert!((found.value - expected).abs() < 1e-12, "{e} {which} {}", found.value);
        let branching = found.branching.as_ref().unwrap();
        assert!(branching.above && branching.orbits.len() == 2);
        assert!(branching.orbits.iter().all(|branched| branched.verdict.is_some_and(|verdict| verdict.stable)));
    }
}

#[test]
fn what_is_not_there_is_an_answer() {
    let start = doubling();
    let answer = search(&start, Event::Grazing, Parameter::Amplitude, Some((0.16, 0.17)));
    assert!(answer.located.is_empty());
    assert_eq!(answer.ends, [(0.16, End::Range), (0.17, End::Range)]);
    // The first mode that a falling frequency meets: the highest one, Ω² = .2 + .4 sin²(10π/21), with ω itself.
    let answer = search(&start, Event::Grazing, Parameter::Omega, Some((0.5, 1.2)));
    let highest = (0.2 + 0.4 * (10.0 * std::f64::consts::PI / 21.0).sin().powi(2)).sqrt();
    let (value, End::Resonance(resonance)) = &answer.ends[0] else { panic!("{:?}", answer.ends) };
    assert!((value - highest).abs() < 1e-13 && (resonance.harmonic, resonance.mode) == (1, 10));
    let outside = Search { from: 0.2, to: 0.3, ..Search::new(&start, Event::Fold, Parameter::Amplitude) };
    assert!(matches!(locate(&start, &outside), Err(LocateError::Range { .. })));
}

/// Without force: what the closed form of the single-sided orbit and a scan of verdicts say.
#[test]
fn conservative_orbits() {
    let at = |omega: f64| Model::conservative(Chain::new(21, 0.2, 0.1).unwrap(), omega, 0.4).unwrap();
    let single = orbit(&at(0.95), Family::SingleSided, 0);
    // The two families meet at grazing.
    let grazing = search(&single, Event::Grazing, Parameter::Omega, Some((0.9, 1.0)));
    let double = orbit(&at(0.97), Family::DoubleSided, 0);
    let meeting = search(&double, Event::Grazing, Parameter::Omega, Some((0.9, 1.0)));
    assert!((grazing.located[0].value - meeting.located[0].value).abs() < 1e-13, "{grazing:?} {meeting:?}");
    // Impulses grow without bound where χ₂ vanishes, −2K₀(0) in closed form.
    let far = search(&single, Event::Fold, Parameter::Omega, None);
    let (limit, End::Unbounded) = far.ends[1] else { panic!("{:?}", far.ends) };
    let chi2 = |omega: f64| {
        let response = ImpulseResponse::new(&Spectrum::new(*at(1.0).chain()), omega).unwrap();
        response.value(0, 0.0)
    };
    assert!(chi2(limit - 1e-3) * chi2(limit + 1e-3) < 0.0, "{limit}");
    // A verdict changes at each point, by the mechanism looked for.
    for (event, mechanism) in
        [(Event::PeriodDoubling, Mechanism::PeriodDoubling), (Event::NeimarkSacker, Mechanism::NeimarkSacker)]
    {
        let answer = search(&single, event, Parameter::Omega, Some((0.91, 0.96)));
        assert!(answer.located.len() >= 2, "{answer:?}");
        for found in &answer.located {
            assert!(found.error < 1e-12, "{found:?}");
            let [below, above] = found.sides.as_slice() else { panic!("{:?}", found.sides) };
            let [below, above] = [below.stability, above.stability];
            assert!(below.stable != above.stable, "{found:?}");
            assert!(below.mechanism.or(above.mechanism) == Some(mechanism), "{found:?}");
        }
    }
}

/// The bands of the paper's conservative maps with multipliers above +1 begin where energy is extreme, not at pitchforks.
#[test]
fn a_multiplier_of_conservative_orbits_is_one_where_their_energy_is_extreme() {
    let at = |omega: f64| Model::conservative(Chain::new(21, 0.2, 0.1).unwrap(), omega, 0.4).unwrap();
    // At any instant between impacts: from the masses alone.
    let energy = |omega: f64, family: Family| {
        let mut motion = Motion::of(&orbit(&at(omega), family, 0)).unwrap();
        motion.at(0, 0.7);
        let mass = |n: usize| motion.site(n % 21);
        let one = |n: usize| {
            let (own, stretch) = (mass(n), mass(n).displacement - mass(n + 1).displacement);
            0.5 * (own.velocity.powi(2) + 0.2 * own.displacement.powi(2) + 0.1 * stretch.powi(2))
        };
        (0..21).map(one).sum::<f64>()
    };
    for (family, omega, range) in [(Family::SingleSided, 0.8, (0.79, 0.95)), (Family::DoubleSided, 0.98, (0.97, 1.1))] {
        let answer = search(&orbit(&at(omega), family, 0), Event::Pitchfork, Parameter::Omega, Some(range));
        let [found] = answer.located.as_slice() else { panic!("{:?}", answer.located) };
        let h = 1e-3;
        let [below, here, above] = [-h, 0.0, h].map(|step| energy(found.value + step, family));
        let (slope, curvature) = ((above - below) / (2.0 * h), (above + below - 2.0 * here) / (h * h));
        // How far the vertex of the parabola is from there.
        assert!((slope / curvature).abs() < 10.0 * h * h && curvature.abs() > 1.0, "{found:?}: {slope} {curvature}");
        assert!(found.branching.is_none(), "{found:?}");
        let said: Vec<_> = found.sides.iter().map(|side| side.stability.mechanism).collect();
        assert_eq!(said, [Some(Mechanism::PlusOne), None]);
    }
}

/// Elastic impacts under a force: symmetric in time, so that asymmetric pairs branch off although a ≠ 0.
#[test]
fn pitchfork_of_orbits_that_are_mirror_images_in_time() {
    let ring = Point::ring(8).gamma1(0.1).gamma2(0.05);
    let at = |omega: f64| ring.omega(omega).asymmetry(0.1).amplitude(1.476).model().unwrap();
    let half = |orbit: &Orbit| (orbit.phi().unwrap() / orbit.period() - 0.5).abs();
    let orbits = breathers(&at(2.053), Family::DoubleSided).unwrap().orbits;
    let mut seen = 0;
    for start in orbits.iter().filter(|orbit| half(orbit) < 1e-12) {
        for found in &search(start, Event::Pitchfork, Parameter::Omega, Some((1.2, 2.5))).located {
            assert!(half(&found.orbit) < 1e-12 && found.error < 1e-12, "{found:?}");
            let Some(branching) = &found.branching else { continue };
            assert!(branching.orbits.iter().all(|branched| half(&branched.orbit) > 1e-4));
            seen += 1;
        }
    }
    assert!(seen > 0);
}

/// The force keeps its shape along the branch: existence ends where a search over single points says.
#[test]
fn fold_under_a_square_wave() {
    let terms =
        [(1, 1.0), (3, -0.3), (5, 0.1)].map(|(number, size)| Harmonic { number, amplitude: 0.165 * size, phase: 0.0 });
    let chain = Chain::new(21, 0.2, 0.1).unwrap();
    let model =
        chain.point().omega(1.07).asymmetry(0.8).under(&Force::new(&terms).unwrap()).restitution(0.25).model().unwrap();
    let start = orbit(&model, Family::SingleSided, 0);
    let found = search(&start, Event::Fold, Parameter::Amplitude, None).located.swap_remove(0);
    assert!(found.error < 1e-12 && found.orbit.model().unwrap().force().harmonics().len() == 3, "{found:?}");
    let count = |amplitude: f64| {
        let model = model.with(Parameter::Amplitude, amplitude).unwrap();
        breathers(&model, Family::SingleSided).unwrap().orbits.len()
    };
    let (outside, inside) = (found.value - 1e-9, found.value + 1e-9);
    assert_eq!(count(outside) + 2, count(inside), "{}", found.value);
}

/// Next to a resonance the next branch is near: neither fold nor period doubling is made of a jump to it.
#[test]
fn doubled_orbits_next_to_a_resonance_end_there() {
    let forced = |sites, gamma: (f64, f64), omega, asymmetry, force: (f64, f64)| {
        let chain = Chain::new(sites, gamma.0, gamma.1).unwrap();
        chain.point().omega(omega).asymmetry(asymmetry).amplitude(force.0).restitution(force.1).model().unwrap()
    };
    let gamma = (0.5605742964292665, 0.2915428976251419);
    let model = forced(5, gamma, 0.41160825497750986, 0.0, (1.2042279128292654, 0.5745149336048461));
    let start = orbit(&model, Family::PeriodDoubled, 0);
    let answer = search(&start, Event::Fold, Parameter::Omega, Some((0.3487998719873891, 0.5248964336666763)));
    // 3ω = Ω₂
    let limit = (gamma.0 + 4.0 * gamma.1 * (0.4 * std::f64::consts::PI).sin().powi(2)).sqrt() / 3.0;
    assert!(answer.located.is_empty(), "{:?}", answer.located);
    assert!(matches!(answer.ends[1], (value, End::Resonance(_)) if (value - limit).abs() < 1e-12), "{:?}", answer.ends);

    let gamma = (0.2923993824358212, 0.23368050995425213);
    let model = forced(6, gamma, 0.7127270839524065, 0.763723908831504, (1.0344610634242684, 0.5776254683327479));
    let start = orbit(&model, Family::PeriodDoubled, 1);
    let range = (0.5441892546716248, 0.9279724015128715);
    let answer = search(&start, Event::PeriodDoubling, Parameter::Omega, Some(range));
    // ω = Ω₁
    let limit = (gamma.0 + gamma.1).sqrt();
    assert!(answer.located.is_empty(), "{:?}", answer.located);
    assert!(matches!(answer.ends[1], (value, End::Resonance(_)) if (value - limit).abs() < 1e-12), "{:?}", answer.ends);
    assert!(answer.evaluations < 30_000, "{}", answer.evaluations);
}

/// Without force and symmetry in time: four multipliers off the circle that meet on the real axis are no event, nor the end.
#[test]
fn a_quadruple_that_turns_real_is_passed() {
    let chain = Chain::new(6, 0.2790465016543734, 0.13606569615937517).unwrap();
    let model = Model::conservative(chain, 0.3245, 0.0).unwrap();
    let start = orbit(&model, Family::DoubleSided, 0);
    assert!(!start.is_reversible());
    let answer = search(&start, Event::NeimarkSacker, Parameter::Omega, Some((0.3222, 0.325)));
    assert_eq!(answer.ends, [(0.3222, End::Range), (0.325, End::Range)]);
    assert!(answer.located.is_empty(), "{:?}", answer.located);
}

/// An impulse that vanishes damps nothing: all pairs of multipliers that feel it meet the circle together, from inside before and to the outside
/// behind. That is the grazing, and no crossing of any of them.
#[test]
fn where_an_impulse_vanishes_no_pair_is_told_to_cross() {
    let (mut met, mut most) = (0, 0);
    for (sites, asymmetry) in [(3, 0.0), (5, 0.0), (11, 0.0), (5, 0.4), (11, 0.4)] {
        let chain = Chain::new(sites, 0.2, 0.1).unwrap();
        let model = chain.point().omega(1.07).asymmetry(asymmetry).amplitude(0.4).restitution(0.8).model().unwrap();
        let starts = breathers(&model, Family::DoubleSided).unwrap().orbits;
        let all = |event| {
            let of = |start| search(start, event, Parameter::Amplitude, Some((0.2, 1.0)));
            starts.iter().map(of).collect::<Vec<_>>()
        };
        let found = all(Event::Grazing).into_iter().zip(all(Event::NeimarkSacker));
        for (grazing, crossings) in found
            .flat_map(|(grazings, crossings)| grazings.located.into_iter().map(move |one| (one, crossings.clone())))
        {
            let Evidence::Impact(impact) = grazing.evidence else { continue };
            let apart = |one: &Located| (one.value - grazing.value).abs() > one.error + grazing.error;
            let values: Vec<f64> = crossings.located.iter().map(|one| one.value).collect();
            assert!(crossings.located.iter().all(apart), "{sites} {asymmetry}: {values:?} {}", grazing.value);
            let holds = |one: &Unresolved| (one.from..=one.to).contains(&grazing.value);
            assert!(!crossings.unresolved.iter().any(holds), "{:?}", crossings.unresolved);
            // Pairs outside on both sides of it, by a matrix that no search knows.
            let outside = [0.9999, 1.0001].map(|part| {
                let model = model.with(Parameter::Amplitude, part * grazing.value).unwrap();
                let strength = |orbit: &Orbit| orbit.impacts()[impact].impulse.abs();
                let all = breathers(&model, Family::DoubleSided).unwrap().orbits;
                let beside = all.into_iter().min_by(|a, b| strength(a).total_cmp(&strength(b))).unwrap();
                let mut values = Vec::new();
                eigenvalues(&full_monodromy(&beside).unwrap(), &mut values).unwrap();
                values.iter().filter(|mu| mu.im > 1e-7 && mu.norm() > 1.0 + 1e-10).count()
            });
            println!("{sites} {asymmetry} {} {outside:?}", grazing.value);
            most = most.max(outside[0].abs_diff(outside[1]));
            met += 1;
        }
    }
    assert!(met >= 5 && most >= 4, "{met} {most}");
}

/// Where a branch shrinks towards a resonance, or both impulses of a doubled orbit vanish, it is as small as the last steps of
/// Newton's method elsewhere, and as rounding of its eigenvalues.
#[test]
fn nothing_is_claimed_of_what_is_no_orbit_or_no_crossing() {
    let forced = |sites, gamma: (f64, f64), omega, asymmetry, force: (f64, f64)| {
        let chain = Chain::new(sites, gamma.0, gamma.1).unwrap();
        chain.point().omega(omega).asymmetry(asymmetry).amplitude(force.0).restitution(force.1).model().unwrap()
    };
    let mut checked = 0;
    for (gamma, omega, asymmetry, force) in [
        ((0.3896118758806526, 0.0027248961637510237), 0.80343848753203, 0.0, (1.183717629843272, 0.8433981063691507)),
        (
            (0.644585775149362, 0.0039669192151900075),
            0.990921956366333,
            0.7271126241525541,
            (1.2094433315450985, 0.4103432077598916),
        ),
    ] {
        let start = orbit(&forced(2, gamma, omega, asymmetry, force), Family::SingleSided, 0);
        let answer = search(&start, Event::PeriodDoubling, Parameter::Omega, None);
        for found in &answer.located {
            assert!(found.orbit.residual() < 1e-10, "{} {:e}", found.value, found.orbit.residual());
            checked += 1;
        }
        assert!(matches!(answer.ends[0].1, End::Resonance(_)), "{:?}", answer.ends);
    }
    assert!(checked >= 3, "{checked}");
    let gamma = (0.05518576549186375, 0.001122958578322989);
    let model = forced(3, gamma, 1.4780437267829847, 0.0, (0.4586211115410338, 0.5195325079821023));
    let start = orbit(&model, Family::PeriodDoubled, 2);
    let answer = search(&start, Event::NeimarkSacker, Parameter::Asymmetry, None);
    assert!((answer.ends[1].0 - 0.784627).abs() < 1e-6, "{:?}", answer.ends);
    assert!(answer.located.iter().all(|found| found.value < 0.7846), "{:?}", answer.located);
}

/// Where doubled orbits are.
const SLOW_TO_FAST: Ranges =
    Ranges { sites: [2, 8], gamma1: Log(0.05, 0.8), gamma2: Log(1e-3, 0.4), omega: Log(0.7, 2.0), ..Ranges::FORCED };

/// Where two impacts with vanishing impulses merge: by hand, the motion that the force drives alone, Ã cos ωt, touches the barrier,
/// |Ã| = 1 − a.
#[test]
fn doubled_orbits_end_where_their_impulses_vanish() {
    let mut random = Random(27);
    let ranges = Ranges { asymmetry: Log(0.01, 0.9), restitution: Log(0.05, 1.0), ..SLOW_TO_FAST };
    let (mut found, mut elsewhere) = (0, Vec::new());
    for _ in 0..600 {
        let model = random.model(&ranges);
        let free = random.of(&[Parameter::Asymmetry, Parameter::Amplitude, Parameter::Omega]);
        let Ok(list) = breathers(&model, Family::PeriodDoubled) else { continue };
        let Some(orbit) = list.orbits.last() else { continue };
        let answer = locate(orbit, &Search::new(orbit, Event::Fold, free)).unwrap();
        for (value, end) in &answer.ends {
            let there = model.with(free, *value).unwrap();
            let reach = (there.amplitude() / (there.chain().gamma1() - there.omega().powi(2))).abs();
            match end {
                End::ImpulsesVanish => {
                    assert!((reach - (1.0 - there.asymmetry())).abs() < 1e-13 * (1.0 + reach), "{value} {there:?}");
                    found += 1;
                }
                End::Lost(_) | End::Unwatched(_) => elsewhere.push((*value, end.clone())),
                _ => {}
            }
        }
    }
    assert!(found >= 10 && elsewhere.is_empty(), "{found} {elsewhere:?}");
}

/// Right at e = 1 all multipliers are on the circle: no crossing, and no way lost.
#[test]
fn the_way_to_elastic_impacts_ends_with_its_range() {
    let mut random = Random(28);
    let ranges = Ranges { asymmetry: Log(0.01, 0.9), restitution: Is(0.9), ..SLOW_TO_FAST };
    let mut there = 0;
    for _ in 0..60 {
        let model = random.model(&ranges);
        let Ok(list) = breathers(&model, Family::DoubleSided) else { continue };
        for orbit in &list.orbits {
            let answer = locate(orbit, &Search::new(orbit, Event::NeimarkSacker, Parameter::Restitution)).unwrap();
            let up = &answer.ends[1];
            assert!(!matches!(up.1, End::Lost(_)) || up.0 < 0.97, "{up:?} {model:?}");
            there += usize::from(*up == (1.0, End::Range));
        }
    }
    assert!(there >= 20, "{there}");
}

#[test]
fn who_does_not_wait_any_longer_is_heard_at_every_step() {
    let orbit = doubling();
    let search = Search::new(&orbit, Event::PeriodDoubling, Parameter::Amplitude);
    let course = Course { generations: 1, ..Course::new(&orbit, Parameter::Amplitude) };
    // Raised at the look after so many.
    let after = |patience: usize| {
        let looks = Arc::new(AtomicUsize::new(0));
        let counter = looks.clone();
        (looks, Stop::when(move || counter.fetch_add(1, Ordering::Relaxed) >= patience))
    };
    let (looks, never) = after(usize::MAX);
    drop(locate_until(&orbit, &search, &never).unwrap());
    let whole = looks.swap(0, Ordering::Relaxed);
    drop(diagram_until(&orbit, &course, &never).unwrap());
    let all = looks.load(Ordering::Relaxed);
    assert!(whole > 20 && all > 60, "{whole} {all}");
    // At the first, in the middle, at the last.
    for (steps, run) in [(whole, false), (all, true)] {
        for patience in [0, steps / 2, steps - 1] {
            let (looks, stop) = after(patience);
            let ended = if run {
                diagram_until(&orbit, &course, &stop).map(drop)
            } else {
                locate_until(&orbit, &search, &stop).map(drop)
            };
            let stopped = [LocateError::Stopped, LocateError::from(BreatherError::from(vibrochain_lattice::Stopped))];
            assert!(ended.as_ref().is_err_and(|error| stopped.contains(error)), "{ended:?}");
            let looks = looks.load(Ordering::Relaxed);
            // What fails at once is tried again in other ways, without an orbit.
            assert!(looks <= patience + 2000, "{patience} {looks}");
        }
    }
}
