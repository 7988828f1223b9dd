//! Events of any linear structure: where they are, how well that is known, and what branches do there, against closed forms and the same
//! branches from elsewhere.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use std::f64::consts::PI;
use std::path::{Path, PathBuf};

use vibrochain_breather::Orbit;
use vibrochain_floquet::{
    BranchRequest, Complex, Diagram, End, Event, FollowedBranch, Tolerance, Walk, Window, branches, event_curves,
    stability,
};
use vibrochain_lattice::Stop;
use vibrochain_maps::structure::along::{family, numbers};
use vibrochain_maps::structure::{Setting, StructureScene};

fn scene(name: &str) -> StructureScene {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenes/structures");
    StructureScene::read(&root.join(name)).unwrap().unwrap()
}

fn of_text(text: &str) -> StructureScene {
    StructureScene::of_text(text, Path::new(".")).unwrap()
}

fn orbits(scene: &StructureScene) -> Vec<Orbit> {
    scene.model().unwrap().orbits(scene.word.as_ref().unwrap(), scene.force_periods).unwrap().orbits
}

fn course([from, to]: [f64; 2], generations: u32) -> BranchRequest {
    BranchRequest { from, to, events: Event::ALL.to_vec(), generations, tolerance: Tolerance::Rounding }
}

fn branch(scene: &StructureScene, (orbit, value): (&Orbit, f64), setting: Setting, range: [f64; 2]) -> FollowedBranch {
    let diagram = branches(orbit, &family(scene, &[setting]), value, &course(range, 0), &Stop::default());
    diagram.unwrap().branches.swap_remove(0)
}

fn diagram(scene: &StructureScene, number: usize, setting: Setting, range: [f64; 2]) -> Diagram {
    let (value, family) = (scene.get(setting).unwrap(), family(scene, &[setting]));
    branches(&orbits(scene)[number], &family, value, &course(range, 1), &Stop::default()).unwrap()
}

/// A ball between walls at ±1 of a box that is shaken with acceleration A cos ωt loses the symmetry of its two impacts where a change of the first
/// comes back after half a period with the opposite sign: by hand, at 2ω² = A(π²/2 − 2)/√(1 + (π(1−e)/2(1+e))²).
fn pitchfork_of_a_ball(amplitude: f64, restitution: f64) -> f64 {
    let slope = 0.5 * PI * (1.0 - restitution) / (1.0 + restitution);
    (0.5 * amplitude * (0.5 * PI * PI - 2.0) / slope.hypot(1.0)).sqrt()
}

#[test]
fn symmetry_is_lost_where_it_is_lost_by_hand() {
    let scene = scene("impact-pair.toml");
    let omega = pitchfork_of_a_ball(1.0, 0.6);
    let mut met = 0;
    for orbit in &orbits(&scene) {
        for range in [[0.7, 1.4], [0.9, 3.0], [0.5, 2.0]] {
            let branch = branch(&scene, (orbit, 1.0), Setting::Omega, range);
            let lost: Vec<_> = branch.events().filter(|one| one.event == Event::Pitchfork).collect();
            let [lost] = lost[..] else { panic!("{lost:?}") };
            assert!(lost.error < 1e-12 && (lost.value - omega).abs() <= lost.error, "{} ± {}", lost.value, lost.error);
            // Those that are not symmetric end there.
            let asymmetric = (orbit.impacts()[1].time / orbit.period() - 0.5).abs() > 1e-3;
            assert_eq!(asymmetric, branch.ends.contains(&(lost.value, End::Pitchfork)), "{:?}", branch.ends);
            met += usize::from(asymmetric);
        }
    }
    assert_eq!(met, 6);
    // Whichever way one comes there, the others go on from there.
    for number in 0..3 {
        let diagram = diagram(&scene, number, Setting::Omega, [0.92, 1.4]);
        assert!(diagram.dead_ends.is_empty(), "{number}: {:?}", diagram.dead_ends);
        let symmetric = |branch: &&FollowedBranch| {
            branch.points().all(|point| (point.orbit.impacts()[1].time / point.orbit.period() - 0.5).abs() < 1e-9)
        };
        let two = |branch: &&FollowedBranch| branch.points().all(|one| one.orbit.impacts().len() == 2);
        assert_eq!(diagram.branches.iter().filter(symmetric).filter(two).count(), 1, "{number}");
        assert!(diagram.branches.iter().filter(two).count() >= 2, "{number}");
    }
}

#[test]
fn a_loss_of_symmetry_is_followed_as_a_curve() {
    let scene = scene("impact-pair.toml");
    let window = Window { from: [0.3, 0.3], to: [3.0, 3.0] };
    let settings = [Setting::Omega, Setting::Load];
    let orbit = &orbits(&scene)[0];
    let branch = branch(&scene, (orbit, 1.0), Setting::Omega, [0.7, 1.4]);
    let lost = branch.events().find(|one| one.event == Event::Pitchfork).unwrap();
    let curve = event_curves([lost], &numbers(&scene, &settings).unwrap(), &Walk::new(window, 1e-3)).unwrap().remove(0);
    assert!(curve.points.len() > 10, "{:?}", curve.ends);
    for point in &curve.points {
        let off = (point.values[0] - pitchfork_of_a_ball(point.values[1], 0.6)).abs();
        assert!(off < 1e-12 && point.error < 1e-11, "{:?} {off:e}", point.values);
    }
    let ends = [curve.points[0].values, curve.points[curve.points.len() - 1].values];
    assert!(ends.iter().any(|end| end[1] == 0.3) && ends.iter().any(|end| end[1] == 3.0), "{ends:?}");
    // With a spring a shift of one wall ends the symmetry, and the loss of it.
    let text = "omega = 1\nword = \"0+,0-\"\n[structure]\nmasses = [1]\nstiffness = [[0.05]]\n[[contact]]\nat = 0\nlower = -1\nupper = 1\n\
        restitution = 0.6\n[force]\nload = [1]\n";
    let scene = of_text(text);
    let (mut refused, mut cusps) = (Vec::new(), Vec::new());
    for orbit in &orbits(&scene) {
        let branch = self::branch(&scene, (orbit, 1.0), Setting::Omega, [0.7, 1.6]);
        for lost in branch.events().filter(|one| one.event == Event::Pitchfork) {
            let settings = [Setting::Omega, "contact.0.upper".parse().unwrap()];
            let window = Window { from: [0.7, 0.5], to: [1.6, 1.5] };
            match event_curves([lost], &numbers(&scene, &settings).unwrap(), &Walk::new(window, 1e-3)) {
                Err(error) => {
                    assert!(error.to_string().contains("orbits of this symmetry"), "{error}");
                    refused.push(lost.value);
                }
                // From an asymmetric orbit next to it: folds, of which it is the cusp.
                Ok(curve) => {
                    assert!(lost.error > 1e-12, "{}", lost.error);
                    cusps.extend(curve);
                }
            }
        }
    }
    assert!(!refused.is_empty());
    for point in cusps.iter().flat_map(|curve| &curve.points) {
        let (off, shift) = (refused[0] - point.values[0], (point.values[1] - 1.0).abs());
        if (1e-6..1e-4).contains(&shift) {
            assert!((0.04..0.09).contains(&(off / shift.powf(2.0 / 3.0))), "{:?}", point.values);
        }
    }
}

/// From another orbit of the branch and over another range rounding is another, and all told errors hold and are small.
#[test]
fn told_errors_are_true_and_small() {
    let scenes = ["impact-pair", "shaw-holmes", "bouncing-ball", "grazing", "gear-rattle", "energy-sink", "pounding"];
    let (mut compared, mut branches) = (0, 0);
    for name in scenes {
        let scene = scene(&format!("{name}.toml"));
        for setting in [Setting::Omega, Setting::Load, "contact.0.restitution".parse().unwrap()] {
            let value = scene.get(setting).unwrap();
            let most = if setting == Setting::Omega || setting == Setting::Load { 1.4 * value } else { 0.99 };
            let range = [0.7 * value, most];
            let wider = [0.65 * value, if most < 1.0 { 0.995 } else { 1.45 * value }];
            for number in 0..orbits(&scene).len() {
                for own in diagram(&scene, number, setting, range).branches {
                    branches += 1;
                    // From a point that is not next to an event.
                    let points: Vec<_> = own.points().collect();
                    let point = points[points.len() / 2];
                    let again = branch(&scene, (&point.orbit, point.value), setting, wider);
                    for one in own.events() {
                        assert!(one.error <= 1e-9 * one.value.abs(), "{name} {setting} {}: {one:?}", one.event.name());
                        let apart = |other: &vibrochain_floquet::Located| (other.value - one.value).abs();
                        let alike = again.events().filter(|other| other.event == one.event);
                        let Some(other) = alike.min_by(|a, b| apart(a).total_cmp(&apart(b))) else { continue };
                        // Others of one kind lie farther apart; a branch that ends before has none.
                        if apart(other) < 1e-6 * one.value.abs() {
                            let allowed = one.error + other.error;
                            assert!(
                                apart(other) <= allowed,
                                "{name} {setting}: {} {:e} {allowed:e}",
                                one.value,
                                apart(other)
                            );
                            compared += 1;
                        }
                    }
                }
            }
        }
    }
    assert!(compared > 100 && branches > 40, "{compared} {branches}");
}

/// x″ + 0.1x′ + x = cos ωt with a stop at 0.1: doubled orbits end where their two impacts vanish together, on the motion that touches the stop,
/// 1 = 0.1√((1−ω²)² + (0.1ω)²); and others come back to those of one impact at the doubling on their other side.
#[test]
fn doubled_orbits_end_at_a_grazing_and_at_a_doubling() {
    let scene = scene("shaw-holmes.toml");
    let found = diagram(&scene, 0, Setting::Omega, [0.5, 4.5]);
    let square = 0.5 * (1.99 + (1.99_f64 * 1.99 + 4.0 * 99.0).sqrt());
    let vanishing =
        found.branches.iter().flat_map(|branch| &branch.ends).find(|end| end.1 == End::ImpulsesVanish).unwrap();
    assert!((vanishing.0 - square.sqrt()).abs() < 1e-12, "{vanishing:?}");
    assert!(found.branches.iter().flat_map(|one| &one.ends).all(|end| !matches!(end.1, End::Lost(_))));
    let doublings: Vec<_> = found.branches[0].events().filter(|one| one.event == Event::PeriodDoubling).collect();
    assert_eq!(doublings.len(), 3);
    let doubled: Vec<_> =
        found.branches[1..].iter().filter(|one| one.points().all(|one| one.orbit.force_periods() == 2)).collect();
    // One connects two doublings, and is not told twice.
    assert_eq!(doubled.len(), 2);
    let end = doubled.iter().flat_map(|one| &one.ends).find(|end| end.1 == End::PeriodDoubling).unwrap();
    assert!((end.0 - doublings[1].value).abs() <= 2.0 * doublings[1].error, "{end:?}");
}

/// Multipliers of a ball without a spring from its flights and impacts, by hand; next to a double pole at 1, and along folds and branch points.
#[test]
fn multipliers_next_to_folds_and_rigid_modes_are_those_by_hand() {
    let (mut near, mut count, mut most): (usize, usize, f64) = (0, 0, 0.0);
    for name in ["impact-pair.toml", "bouncing-ball.toml"] {
        let scene = scene(name);
        for number in 0..orbits(&scene).len() {
            let diagram = diagram(&scene, number, Setting::Load, [0.5, 2.5]);
            for point in diagram.branches.iter().flat_map(FollowedBranch::points) {
                let (impacts, period) = (point.orbit.impacts(), point.orbit.period());
                let fastest = impacts.iter().map(|one| one.velocity_before.abs()).fold(0.0, f64::max);
                if impacts.iter().any(|one| one.velocity_before.abs() < 1e-3 * fastest) {
                    continue;
                }
                let told = stability(&point.orbit, Tolerance::Rounding).unwrap();
                // (δx, δv) from just before one impact to just before the next.
                let mut matrix = [[1.0, 0.0], [0.0, 1.0]];
                for (i, impact) in impacts.iter().enumerate() {
                    let e = scene.get("contact.0.restitution".parse().unwrap()).unwrap();
                    let after = impacts.get(i + 1).map_or(period, |next| next.time) - impact.time;
                    let pull = (1.0 + e) * impact.acceleration / impact.velocity_before;
                    for column in 0..2 {
                        let [place, velocity] = [matrix[0][column], matrix[1][column]];
                        let [place, velocity] = [-e * place, -e * velocity + pull * place];
                        matrix[0][column] = place + after * velocity;
                        matrix[1][column] = velocity;
                    }
                }
                let half = Complex::new(0.5 * (matrix[0][0] + matrix[1][1]), 0.0);
                let product = matrix[0][0] * matrix[1][1] - matrix[0][1] * matrix[1][0];
                let root = (half * half - product).sqrt();
                let size = matrix.iter().flatten().map(|entry: &f64| entry.abs()).fold(1.0, f64::max);
                for mu in [half + root, half - root] {
                    let apart = told.multipliers.iter().map(|other| (other - mu).norm()).fold(f64::INFINITY, f64::min);
                    // Two that meet by the root of rounding.
                    let allowed = 1e-11 * size * size / root.norm().max(1e-6);
                    assert!(apart <= allowed, "{name} {}: {mu} {apart:e} {allowed:e}", point.value);
                    most = most.max(apart);
                    near += usize::from((mu - 1.0).norm() < 1e-4);
                }
                let verdict = told.verdict;
                let excess = (half + root).norm().max((half - root).norm()) - 1.0;
                assert!(
                    (verdict.excess() - excess).abs()
                        <= verdict.resolution + 1e-11 * size * size / root.norm().max(1e-6)
                );
                count += 1;
            }
        }
    }
    assert!(near > 5 && count > 500 && most < 1e-6, "{near} {count} {most:e}");
}

/// Without a load nothing restores what is lost: no branch of orbits of a given frequency goes on as losses begin.
#[test]
fn losses_without_a_load_are_refused() {
    let scene = scene("clamped-chain.toml");
    let orbit = &orbits(&scene)[0];
    for (setting, range) in [("restitution", [0.5, 1.0]), ("damping", [-0.1, 0.1])] {
        let setting = setting.parse().unwrap();
        let value = scene.get(setting).unwrap();
        let followed = branches(orbit, &family(&scene, &[setting]), value, &course(range, 0), &Stop::default());
        assert!(followed.unwrap_err().to_string().contains("losses end the motion"), "{setting}");
    }
    assert!(branch(&scene, (orbit, 0.7), Setting::Omega, [0.65, 0.75]).points().count() > 10);
}
