//! Which modes collide: Krein's form on the eigenvectors of the dense monodromy matrix, which knows nothing of secular
//! functions, against what the frequencies of the modes say.

use std::f64::consts::{PI, TAU};

use faer::MatRef;
use vibrochain_breather::{Family, Finder, Orbit, OrbitList};
use vibrochain_floquet::{Complex, DressedModes, InternalMode, Secular, Signature, bare_signature, even_monodromy};
use vibrochain_lattice::{Chain, ImpulseResponse, Model, Point, Spectrum};
use vibrochain_testkit::Values::{Either, Even, Is};
use vibrochain_testkit::{Random, Ranges};

use super::krein::{Krein, apart, excess};

const BOTH: [Family; 2] = [Family::SingleSided, Family::DoubleSided];

/// All of them.
pub(crate) fn dense(orbit: &Orbit) -> Vec<Krein> {
    let matrix = even_monodromy(orbit).unwrap();
    let size = matrix.nrows();
    let half = size / 2;
    let spectrum = Spectrum::new(*orbit.model().unwrap().chain());
    let eigen = MatRef::from_column_major_slice(matrix.as_slice(), size, size).eigen().unwrap();
    let (values, vectors) = (eigen.S().column_vector(), eigen.U());
    (0..size)
        .map(|i| {
            let entry = |row: usize| Complex::new(vectors[(row, i)].re, vectors[(row, i)].im);
            let form = |k: usize| {
                // The first half are displacements times max(Ω, ω).
                let x = entry(k) / spectrum.frequencies()[k].max(orbit.frequency());
                (x.conj() * entry(k + half)).im
            };
            (Complex::new(values[i].re, values[i].im), (0..half).map(form).sum())
        })
        .collect()
}

pub(crate) struct Bench {
    pub(crate) finder: Finder,
    pub(crate) found: OrbitList,
    pub(crate) modes: DressedModes,
}

impl Bench {
    pub(crate) fn new() -> Self {
        Self { finder: Finder::new(21), found: OrbitList::default(), modes: DressedModes::default() }
    }

    /// The symmetric orbit of that family, and its modes.
    pub(crate) fn orbit(&mut self, family: Family, sites: usize, g2: f64, omega: f64, a: f64) -> Option<Orbit> {
        self.orbit_of(family, &Model::conservative(Chain::new(sites, 0.2, g2).unwrap(), omega, a).unwrap())
    }

    pub(crate) fn orbit_of(&mut self, family: Family, model: &Model) -> Option<Orbit> {
        self.finder.find_symmetric(model, family, &mut self.found).ok()?;
        let orbit = self.found.orbits.pop()?;
        self.modes.replace(self.finder.prepared(&orbit).unwrap()).unwrap();
        Some(orbit)
    }

    pub(crate) fn response<'a>(&'a mut self, orbit: &'a Orbit) -> &'a ImpulseResponse {
        self.finder.prepared(orbit).unwrap().response()
    }

    pub(crate) fn physical(&mut self, orbit: &Orbit) -> bool {
        self.finder.admissibility(orbit).unwrap().is_physical()
    }
}

#[test]
fn free_modes_turn_forward_with_positive_form() {
    // Flight without impacts: the matrix is block diagonal, its eigenvectors are (1, ±iΩ).
    let mut random = Random(1);
    for _ in 0..200 {
        let (g2, omega) = (random.between(0.01, 0.5), random.between(0.2, 3.0));
        let spectrum = Spectrum::new(Chain::new(12, 0.2, g2).unwrap());
        let Ok(response) = ImpulseResponse::new(&spectrum, omega) else { continue };
        for (k, frequency) in spectrum.frequencies().iter().enumerate() {
            let multiplier = Complex::from_polar(1.0, frequency * TAU / omega);
            let (x, velocity) = (Complex::new(1.0, 0.0), Complex::new(0.0, *frequency));
            let form = (x.conj() * velocity).im;
            let upper = if multiplier.im > 0.0 { form } else { -form };
            let expected = if upper > 0.0 { Signature::Positive } else { Signature::Negative };
            if multiplier.im.abs() > 1e-9 {
                assert_eq!(bare_signature(&response, k), Some(expected));
            }
        }
    }
    let spectrum = Spectrum::new(Chain::new(4, 0.25, 0.0).unwrap());
    // 2Ω = ω: −1 is its own mirror image.
    assert_eq!(bare_signature(&ImpulseResponse::new(&spectrum, 1.0).unwrap(), 0), None);
}

#[test]
fn above_twice_the_band_the_dressed_modes_are_the_multipliers() {
    let (mut random, mut bench, mut checked) = (Random(2), Bench::new(), 0);
    for i in 0..400 {
        let sites = 2 + (random.unit() * 20.0) as usize;
        let g2 = random.between(0.01, 0.5);
        let top = (0.2 + 4.0 * g2).sqrt();
        let (omega, a) = (top * random.between(2.05, 6.0), random.between(0.0, 0.9));
        let orbit = bench.orbit(BOTH[i % 2], sites, g2, omega, a).unwrap();
        let values = dense(&orbit);
        let all: Vec<f64> = bench.modes.frequencies().flatten().collect();
        // Single-sided breathers are no breathers up there: one mode may have left the band, and the circle, too.
        let left = values.iter().filter(|(z, _)| z.norm() > 1.0 + 1e-5).count();
        assert!(left == 0 || BOTH[i % 2] == Family::SingleSided && left == 1);
        assert_eq!(all.len() + left, bench.modes.count() - 1, "{orbit:?}");
        for dressed in all {
            let (nearest, form) = values
                .iter()
                .min_by(|a, b| {
                    let to = |z: Complex<f64>| (z - Complex::from_polar(1.0, dressed * TAU / omega)).norm();
                    to(a.0).total_cmp(&to(b.0))
                })
                .unwrap();
            let error = (nearest - Complex::from_polar(1.0, dressed * TAU / omega)).norm();
            // The dense solver splits the trivial pair, and what comes near it, by 1e-7; and next to one of the nodes that stand
            // for the modes of a long ring, pole and correction cancel.
            let allowed = if nearest.re > 0.999 { 1e-6 } else { 1e-9 };
            assert!(error < allowed, "{error:e} {orbit:?}");
            assert!(*form > 0.0, "{form} {dressed} {orbit:?}");
            checked += 1;
        }
    }
    assert!(checked > 1800, "{checked}");
}

/// In a stable orbit the multipliers with positive form are e^{iΩ̃T}, one for each pair of neighbours Ω_k < Ω̃ < Ω_{k+1}; those
/// with negative form are their mirror images.
#[test]
fn every_dressed_mode_of_a_stable_orbit_has_its_multiplier_with_its_signature() {
    let (mut random, mut bench) = (Random(3), Bench::new());
    let (mut folded, mut close, mut wrong) = (0, 0, 0);
    for i in 0..3000 {
        let sites = 3 + (random.unit() * 20.0) as usize;
        let (g2, omega, a) = (random.between(0.02, 0.3), random.between(0.7, 2.0), random.between(0.0, 0.8));
        let Some(orbit) = bench.orbit(BOTH[i % 2], sites, g2, omega, a) else { continue };
        let top = (0.2 + 4.0 * g2).sqrt();
        if omega < top || omega > 2.0 * top || !bench.physical(&orbit) {
            continue;
        }
        let values = dense(&orbit);
        if excess(&values) > 1e-5 {
            continue;
        }
        for dressed in bench.modes.frequencies().flatten().collect::<Vec<_>>() {
            let phase = dressed * TAU / omega;
            // The nearest one with positive form, the trivial pair aside.
            let distance = values
                .iter()
                .filter(|(z, form)| *form > 0.0 && (z - 1.0).norm() > 1e-5)
                .map(|(z, _)| apart(z.arg(), phase))
                .fold(PI, f64::min);
            folded += 1;
            close += usize::from(distance < 0.005 * TAU);
            // With negative form the mirror images are as near, and it is no more than chance that one is at the phase itself.
            let other = values
                .iter()
                .filter(|(z, form)| *form < 0.0 && (z - 1.0).norm() > 1e-5)
                .map(|(z, _)| apart(z.arg(), phase))
                .fold(PI, f64::min);
            wrong += usize::from(other < distance);
        }
    }
    assert!(folded > 3000, "{folded}");
    assert!(close as f64 > 0.97 * folded as f64, "{close} of {folded}");
    assert!((wrong as f64) < 0.05 * folded as f64, "{wrong} of {folded}");
}

/// Whatever signature is told, of orbits of all kinds: Krein's form has that sign on the eigenvector of the multiplier in the
/// upper half plane that is next to e^{±iΩ̃T}. The sign of the bare mode would be wrong again and again.
#[test]
fn every_signature_told_is_that_of_the_form_on_the_multiplier_next_to_the_dressed_mode() {
    let (mut random, mut bench, mut secular) = (Random(7), Bench::new(), Secular::default());
    // Of stable physical orbits, and of all others.
    let (mut modes, mut told, mut bare_wrong) = ([0, 0], [0, 0], [0, 0]);
    let ranges = Ranges {
        sites: [2, 23],
        omega: Even(0.3, 3.0),
        asymmetry: Either(0.2, &Is(0.0), &Even(0.0, 0.9)),
        ..Ranges::CONSERVATIVE
    };
    let chain = Chain::new(15, 0.5448393244032546, 0.049273526372998165).unwrap();
    let carried_past = Model::conservative(chain, 1.6210549604807942, 0.0).unwrap();
    for i in 0..5000 {
        let model = if i == 0 { carried_past } else { random.model(&ranges) };
        let Some(orbit) = bench.orbit_of(BOTH[i % 2], &model) else { continue };
        if secular.replace(bench.finder.prepared(&orbit).unwrap()).is_err() {
            continue;
        }
        let Ok((roots, _)) = secular.roots() else { continue };
        let signatures = bench.modes.signatures(&bench.finder.at_contacts(&orbit).unwrap(), roots);
        assert_eq!(signatures.len(), bench.modes.count());
        let values = dense(&orbit);
        let other = usize::from(excess(&values) > 1e-5 || !bench.physical(&orbit));
        bench.orbit_of(BOTH[i % 2], &model);
        // Where a dense solver has the signs, too.
        let upper: Vec<(f64, f64)> = values
            .iter()
            .filter(|(z, _)| z.im > 0.0 && (z.norm() - 1.0).abs() < 1e-6 && (z - 1.0).norm() > 1e-4)
            .map(|(z, form)| (z.arg(), *form))
            .collect();
        for (k, signature) in signatures.iter().enumerate() {
            let Some(dressed) = bench.modes.frequency(k) else {
                assert_eq!(*signature, None);
                continue;
            };
            modes[other] += 1;
            let Some(signature) = signature else { continue };
            let phase = dressed * model.period();
            let place = Complex::from_polar(1.0, phase).arg().abs();
            let (_, form) = upper.iter().min_by(|a, b| (a.0 - place).abs().total_cmp(&(b.0 - place).abs())).unwrap();
            let expected = if *form > 0.0 { Signature::Positive } else { Signature::Negative };
            assert_eq!(*signature, expected, "mode {k} at {phase}, {form}, {upper:?}, {orbit:?}");
            told[other] += 1;
            bare_wrong[other] += u32::from(bare_signature(bench.response(&orbit), k) != Some(expected));
        }
        if i == 0 {
            // The breather has carried mode 4 past −1: 3.134 of the bare ring has become 3.18.
            assert_eq!(signatures[4], Some(Signature::Negative));
            assert_eq!(bare_signature(bench.response(&orbit), 4), Some(Signature::Positive));
        }
    }
    assert!(told[0] > 10_000 && told[1] > 10_000, "{told:?}");
    assert!(
        told[0] as f64 > 0.995 * modes[0] as f64 && told[1] as f64 > 0.8 * modes[1] as f64,
        "{told:?} of {modes:?}"
    );
    assert!(bare_wrong[0] > 50, "{bare_wrong:?}");
}

/// Krein's form positive, and not the trivial pair.
fn positive(values: &[Krein]) -> impl Iterator<Item = f64> + '_ {
    values.iter().filter(|(z, form)| *form > 0.0 && (z - 1.0).norm() > 1e-4).map(|(z, _)| z.arg())
}

/// The mode that a breather has drawn out of the band.
#[test]
fn the_internal_mode_has_its_multiplier_with_its_signature() {
    let (mut random, mut bench) = (Random(5), Bench::new());
    let (mut localised, mut physical, mut complete) = ([0, 0], [0, 0], [0, 0]);
    let (mut slow, mut close) = (0, 0);
    let (mut emitting, mut growing) = (0, 0);
    for i in 0..9000 {
        let sites = 3 + (random.unit() * 20.0) as usize;
        let (g2, omega, a) = (random.between(0.02, 0.3), random.between(0.45, 1.2), random.between(0.0, 0.8));
        let Some(orbit) = bench.orbit(BOTH[i % 2], sites, g2, omega, a) else { continue };
        let Some(own) = bench.modes.internal_mode().copied() else { continue };
        emitting += usize::from(own.loss != 0.0);
        growing += usize::from(own.loss < 0.0);
        let values = dense(&orbit);
        if excess(&values) > 1e-5 {
            continue;
        }
        let phase = own.frequency * TAU / omega;
        assert!((0.0..TAU).contains(&phase));
        let distance = positive(&values).map(|arg| apart(arg, phase)).fold(PI, f64::min);
        if own.loss == 0.0 {
            // Where nothing else is in the band, it is a multiplier; next to others of the ring that are badly conditioned
            // a dense solver has fewer digits.
            assert!(distance < 1e-6, "{distance:e} {own:?} {orbit:?}");
            let sign = if phase < PI { Signature::Positive } else { Signature::Negative };
            assert_eq!(own.signature(omega), Some(sign));
            localised[i % 2] += 1;
            // None has been counted twice, and none is missing.
            let all = bench.modes.frequencies().flatten().count() == bench.modes.count() - 1;
            if bench.physical(&orbit) {
                physical[i % 2] += 1;
                complete[i % 2] += usize::from(all);
            }
        } else if own.loss.abs() < 0.01 * omega {
            slow += 1;
            close += usize::from(distance < 0.02 * TAU);
        }
    }
    for i in 0..2 {
        assert!(localised[i] > 100 && physical[i] > 40, "{localised:?} {physical:?}");
        assert_eq!(complete[i], physical[i]);
    }
    // The waves are of the other sign.
    assert!(growing as f64 > 0.9 * emitting as f64, "{growing} of {emitting}");
    assert!(slow > 200 && close as f64 > 0.95 * f64::from(slow), "{close} of {slow}");
}

/// Waves of the other sign that the mode emits make it grow, on a ring as without end, if that is fast enough.
#[test]
fn an_internal_mode_that_grows_before_its_waves_are_back_makes_the_orbit_unstable() {
    let (mut random, mut bench) = (Random(6), Bench::new());
    let (mut all, mut unstable, mut as_fast) = (0, 0, 0);
    for _ in 0..6000 {
        let sites = 6 + (random.unit() * 16.0) as usize;
        let (g2, omega, a) = (random.between(0.02, 0.3), random.between(0.45, 1.2), random.between(0.0, 0.8));
        let Some(orbit) = bench.orbit(Family::SingleSided, sites, g2, omega, a) else { continue };
        // e times as large before a wave has come back around the ring, in 2π over the mean distance of neighbouring modes.
        let bare = bench.response(&orbit).frequencies();
        let spacing = (bare[bare.len() - 1] - bare[0]) / (bare.len() - 1) as f64;
        let grows = |own: &InternalMode| -own.loss * TAU > spacing;
        let Some(own) = bench.modes.internal_mode().copied().filter(grows) else { continue };
        let values = dense(&orbit);
        all += 1;
        unstable += usize::from(excess(&values) > 1e-3);
        let phase = own.frequency * TAU / omega;
        let expected = (-own.loss * TAU / omega).exp();
        let near = |size: f64| (0.75..1.0 / 0.75).contains(&(size / expected));
        as_fast += usize::from(
            values.iter().any(|(z, _)| near(z.norm()) && apart(z.arg().abs(), phase.min(TAU - phase)) < 0.3),
        );
    }
    assert!(all > 200, "{all}");
    assert!(unstable as f64 > 0.95 * all as f64, "{unstable} of {all}");
    assert!(as_fast as f64 > 0.7 * all as f64, "{as_fast} of {all}");
}

#[test]
fn the_internal_mode_doubles_the_period_against_itself() {
    let (mut bench, mut doubled, mut stable) = (Bench::new(), 0, 0);
    for i in 0..400 {
        let omega = 0.68 + 2e-4 * f64::from(i);
        let Some(orbit) = bench.orbit(Family::SingleSided, 6, 0.2, omega, 0.4) else { continue };
        let values = dense(&orbit);
        let leading = values.iter().map(|(z, _)| *z).find(|z| z.re < -1.0 - 1e-5 && z.im.abs() < 1e-9);
        let Some(own) = bench.modes.internal_mode().copied() else { continue };
        // From there to the end of the row; where two others have met besides, all the same.
        assert_eq!(own.frequency == 0.5 * omega, leading.is_some(), "{omega} {own:?} {leading:?}");
        let Some(leading) = leading else {
            stable += 1;
            continue;
        };
        let collision = bench.modes.collision(Complex::new(leading.re, 0.0)).unwrap();
        assert_eq!((collision.modes, collision.harmonic, own.signature(omega)), ((3, 3), 1, None));
        assert!(collision.detuning.unwrap().abs() < 1e-15);
        doubled += 1;
    }
    assert!(doubled > 200 && stable > 100, "{doubled} {stable}");
}

/// The signs of the residues are not the signatures: counted on the orbits of a map.
#[test]
fn residues_change_sign_where_signatures_do_not() {
    let (mut random, mut bench, mut secular) = (Random(4), Bench::new(), Secular::default());
    let (mut equal, mut all) = (0_u32, 0_u32);
    for i in 0..2000 {
        let sites = 5 + (random.unit() * 35.0) as usize;
        let (g2, omega, a) = (random.between(0.01, 1.0), random.between(0.3, 3.0), random.between(0.0, 0.9));
        let Some(orbit) = bench.orbit(BOTH[i % 2], sites, g2, omega, a) else { continue };
        if secular.replace(bench.finder.prepared(&orbit).unwrap()).is_err() {
            continue;
        }
        let form = secular.residues();
        for (place, residue) in form.residues().iter().enumerate() {
            let Some(signature) = bare_signature(bench.response(&orbit), form.mode(place).unwrap()) else { continue };
            all += 1;
            equal += u32::from((*residue > 0.0) == (signature == Signature::Positive));
        }
    }
    let share = f64::from(equal) / f64::from(all);
    assert!(all > 10_000 && (0.6..0.9).contains(&share), "{share} of {all}");
}

#[test]
fn orbits_without_mirror_symmetry_have_no_dressed_modes() {
    let ring = Point::ring(21).gamma1(0.2).gamma2(0.1);
    let model = ring.omega(1.5).asymmetry(0.4).amplitude(0.1).restitution(0.9).model().unwrap();
    let mut bench = Bench::new();
    bench.finder.find(&model, Family::DoubleSided, &mut bench.found).unwrap();
    let orbit = bench.found.orbits.pop().unwrap();
    bench.modes.replace(bench.finder.prepared(&orbit).unwrap()).unwrap();
    assert!(bench.modes.count() == 0 && bench.modes.collision(Complex::new(0.3, 1.1)).is_none());
}
