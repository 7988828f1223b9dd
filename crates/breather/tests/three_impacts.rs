//! Lists of three impacts with proof, against Newton's method from many starts.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use std::sync::Arc;

use vibrochain_breather::{Completeness, Hit, LoadedStructure, Orbit, Proof, Word};
use vibrochain_lattice::{Barrier, Complex, Contact, LinearMode, ModalStructure, ModeShape};
use vibrochain_testkit::Random;

type Letters = [(usize, Barrier); 3];

fn word(letters: &Letters) -> Word {
    let name =
        |&(contact, side): &(usize, Barrier)| format!("{contact}{}", if side == Barrier::Upper { '+' } else { '-' });
    letters.each_ref().map(name).join(",").parse().unwrap()
}

/// One to four modes, below, at and above critical damping, and two contacts.
fn random_structure(random: &mut Random) -> ModalStructure {
    let count = 1 + random.below(4);
    let mut mode = || {
        let (frequency, ratio) =
            (random.log(0.3, 5.0), [random.log(1e-3, 0.9), 1.0, 1.5][random.below(3).min(random.below(3))]);
        let contacts = vec![random.between(-1.0, 1.0), random.between(-1.0, 1.0)];
        let shape = ModeShape { contacts, coordinates: Vec::new(), still: random.between(-0.1, 0.1) };
        let load = Complex::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0));
        LinearMode::oscillator(ratio * frequency, frequency * frequency * (1.0 - ratio * ratio), &shape, &[load])
    };
    let modes = (0..count).map(|_| mode()).collect();
    let contact = || Contact { lower: Some(-0.3), upper: Some(0.2), restitution: 0.8 };
    ModalStructure::new(vec![contact(), contact()], vec![1], modes).unwrap()
}

/// Orbits of three pushing impacts that starts lead to, each told once.
fn led_to(model: &LoadedStructure, letters: &Letters, periods: u32, starts: usize, random: &mut Random) -> Vec<Orbit> {
    let period = model.period() * f64::from(periods);
    let mut led: Vec<Orbit> = Vec::new();
    for _ in 0..starts {
        let mut times = [0.0, random.between(0.0, period), random.between(0.0, period)];
        times.sort_by(f64::total_cmp);
        let impact =
            |i: usize| Hit::new(letters[i].0, letters[i].1, times[i], -letters[i].1.sign() * random.log(0.01, 3.0));
        let start: Vec<_> = (0..3).map(impact).collect();
        let psi = random.between(0.0, model.period());
        let Ok(orbit) = model.orbit_near(periods, psi, &start) else { continue };
        let impacts = orbit.impacts();
        let (t, sizes) =
            ([0, 1, 2].map(|i| impacts[i].time), [0, 1, 2].map(|i| impacts[i].impulse * impacts[i].barrier.sign()));
        let apart = [t[1] - t[0], t[2] - t[1], period - t[2]];
        if apart.iter().any(|apart| *apart < 2e-4 * period) || sizes.iter().any(|size| *size > -1e-7) {
            continue;
        }
        // One of fewer impacts, gone through several times.
        let alike = |a: f64, b: f64| (a - b).abs() < 1e-6;
        if (0..2).all(|i| alike(apart[i], apart[i + 1]) && alike(sizes[i], sizes[i + 1]))
            && letters.iter().all(|l| *l == letters[0])
        {
            continue;
        }
        if !led.iter().any(|other| same(other, &orbit)) {
            led.push(orbit);
        }
    }
    led
}

fn same(a: &Orbit, b: &Orbit) -> bool {
    let apart = |orbit: &Orbit, i: usize| {
        let later = if i == 2 { orbit.period() } else { orbit.impacts()[i + 1].time };
        later - orbit.impacts()[i].time
    };
    // Newton's method may end where conditions are met but times are known poorly.
    let errors =
        [a, b].into_iter().flat_map(|orbit| orbit.contacts().unwrap().impact_errors()).map(|error| 2.0 * error.time);
    let room = errors.fold(1e-6 * a.period(), f64::max);
    (0..3).any(|turn| {
        (0..3).all(|i| {
            let (own, other) = (&a.impacts()[i], &b.impacts()[(i + turn) % 3]);
            (own.site, own.barrier) == (other.site, other.barrier)
                && (own.impulse - other.impulse).abs() < 1e-6 * (1.0 + own.impulse.abs())
                && (apart(a, i) - apart(b, (i + turn) % 3)).abs() < room
        })
    })
}

/// How a list of complete or open ones compares with what starts lead to.
#[derive(Default, Debug)]
struct Tally {
    lists: usize,
    complete: usize,
    open: usize,
    orbits: usize,
    led: usize,
    boxes: usize,
}

impl Tally {
    fn compare(&mut self, name: &str, model: &LoadedStructure, letters: &Letters, periods: u32, random: &mut Random) {
        let word = word(letters);
        let Ok(found) = model.orbits(&word, periods) else { return };
        self.lists += 1;
        println!("{name} {word}/{periods}: {} {:?}", found.orbits.len(), found.completeness);
        if let Completeness::Open { .. } = found.completeness {
            self.open += 1;
        }
        let Some(Proof::BranchAndPrune { boxes }) = found.completeness.proof() else { return };
        self.boxes += boxes;
        self.complete += 1;
        self.orbits += found.orbits.len();
        let led = led_to(model, letters, periods, 1000, &mut Random(random.below(1 << 20) as u64));
        for orbit in &led {
            self.led += 1;
            assert!(
                found.orbits.iter().any(|other| same(other, orbit)),
                "{name} {word} over {periods}: {:?} psi {:?} not in {:?}",
                orbit.impacts(),
                orbit.psi(),
                found.orbits.iter().map(|orbit| orbit.impacts().to_vec()).collect::<Vec<_>>()
            );
        }
    }
}

fn letters(random: &mut Random, contacts: &[Contact]) -> Letters {
    [(); 3].map(|()| {
        let contact = random.below(contacts.len().min(3));
        let (upper, lower) = (contacts[contact].upper.is_some(), contacts[contact].lower.is_some());
        (contact, if upper && (!lower || random.chance(0.5)) { Barrier::Upper } else { Barrier::Lower })
    })
}

#[test]
fn complete_lists_of_random_structures_lack_nothing_that_starts_lead_to() {
    let mut random = Random(91);
    let mut tally = Tally::default();
    for round in 0..40 {
        let structure = Arc::new(random_structure(&mut random));
        let model = LoadedStructure::new(structure, random.between(0.5, 3.0)).unwrap();
        let letters = letters(&mut random, model.structure().contacts());
        let periods = 1 + random.below(3) as u32;
        tally.compare(&format!("random {round}"), &model, &letters, periods, &mut random);
    }
    println!("{tally:?}");
    assert!(tally.complete > 35 && tally.led > 40, "{tally:?}");
}

/// Without a load or a loss.
#[test]
fn complete_lists_of_free_motions_lack_nothing_that_starts_lead_to() {
    let mut random = Random(29);
    let mut tally = Tally::default();
    for round in 0..80 {
        let angles = [(); 3].map(|()| random.between(0.0, std::f64::consts::TAU));
        // Two masses that feel nothing of an impact at the other one, at once, or two places of a continuum.
        let of_masses = round % 2 == 1;
        let [[a, b], [c, d], [e, f]] = angles.map(|angle| [angle.cos(), angle.sin()]);
        let rotation = [[a * c, b * c, d], [-b * e - a * d * f, a * e - b * d * f, c * f]];
        let mut mode = |k: usize| {
            let frequency = random.log(0.3, 3.0);
            let contacts = if of_masses {
                rotation.map(|row| row[k]).to_vec()
            } else {
                vec![random.between(-1.0, 1.0), random.between(-1.0, 1.0)]
            };
            let shape = ModeShape { contacts, coordinates: Vec::new(), still: random.between(-0.1, 0.1) };
            LinearMode::oscillator(0.0, frequency * frequency, &shape, &[])
        };
        let modes = (0..3).map(&mut mode).collect();
        let contact = || Contact { lower: Some(-0.3), upper: Some(0.2), restitution: 1.0 };
        let structure = ModalStructure::new(vec![contact(), contact()], vec![], modes).unwrap();
        let model = LoadedStructure::new(Arc::new(structure), random.between(0.5, 3.0)).unwrap();
        let letters = letters(&mut random, model.structure().contacts());
        tally.compare(&format!("free {round}"), &model, &letters, 1, &mut random);
    }
    println!("{tally:?}");
    assert!(tally.lists > 70 && tally.complete == tally.lists && tally.led > 40, "{tally:?}");
}
