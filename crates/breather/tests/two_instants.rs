//! Conservative orbits of two instants on rings, rows and layers against a scan of φ that shares no code with the search: stiffness
//! matrices by hand, their modes by Jacobi's rotations, impulses by elimination, changes of sign of a combination of Newton's rows, all
//! of which must vanish. What is called complete is held against it, over lattices and words.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use std::f64::consts::TAU;

use vibrochain_breather::{Completeness, Finder, NoBreather, Orbit, OrbitList, Scope, Word};
use vibrochain_lattice::{Chain, Ends, Model};

/// Lattices of `length` masses a layer.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Ring,
    Free,
    Fixed,
    /// Two layers of a ring, and of a free row.
    Layers,
    LayersOfRows,
}

fn chain(kind: Kind, length: usize, gamma1: f64, gamma2: f64) -> Chain {
    let ring = Chain::new(length, gamma1, gamma2).unwrap();
    let layers = |chain: Chain| chain.with_layers(2, 0.6 * gamma2, Ends::Free).unwrap();
    match kind {
        Kind::Ring => ring,
        Kind::Free => ring.with_ends(Ends::Free),
        Kind::Fixed => ring.with_ends(Ends::Fixed),
        Kind::Layers => layers(ring),
        Kind::LayersOfRows => layers(ring.with_ends(Ends::Free)),
    }
}

/// The stiffness matrix, spring by spring.
fn stiffness(kind: Kind, length: usize, gamma1: f64, gamma2: f64) -> Vec<Vec<f64>> {
    let layers = if matches!(kind, Kind::Layers | Kind::LayersOfRows) { 2 } else { 1 };
    let mut matrix = vec![vec![0.0; length * layers]; length * layers];
    let mut spring = |i: usize, j: Option<usize>, k: f64| {
        matrix[i][i] += k;
        if let Some(j) = j {
            matrix[j][j] += k;
            matrix[i][j] -= k;
            matrix[j][i] -= k;
        }
    };
    for layer in 0..layers {
        let at = |n: usize| layer * length + n;
        for n in 0..length {
            spring(at(n), None, gamma1);
            if n + 1 < length {
                spring(at(n), Some(at(n + 1)), gamma2);
            } else if matches!(kind, Kind::Ring | Kind::Layers) {
                spring(at(n), Some(at(0)), gamma2);
            }
            if layer > 0 {
                spring(n, Some(at(n)), 0.6 * gamma2);
            }
        }
        if kind == Kind::Fixed {
            spring(at(0), None, gamma2);
            spring(at(length - 1), None, gamma2);
        }
    }
    matrix
}

/// Frequencies and modes, [mode][mass].
fn modes(mut a: Vec<Vec<f64>>) -> Vec<(f64, Vec<f64>)> {
    let n = a.len();
    let mut v: Vec<Vec<f64>> = (0..n).map(|i| (0..n).map(|j| f64::from(u8::from(i == j))).collect()).collect();
    for _ in 0..60 {
        for p in 0..n {
            for q in p + 1..n {
                if a[p][q].abs() < 1e-300 {
                    continue;
                }
                let (sin, cos) = (0.5 * (2.0 * a[p][q]).atan2(a[q][q] - a[p][p])).sin_cos();
                for k in 0..n {
                    (a[k][p], a[k][q]) = (cos * a[k][p] - sin * a[k][q], sin * a[k][p] + cos * a[k][q]);
                }
                for k in 0..n {
                    (a[p][k], a[q][k]) = (cos * a[p][k] - sin * a[q][k], sin * a[p][k] + cos * a[q][k]);
                }
                for row in &mut v {
                    (row[p], row[q]) = (cos * row[p] - sin * row[q], sin * row[p] + cos * row[q]);
                }
            }
        }
    }
    (0..n).map(|k| (a[k][k].sqrt(), v.iter().map(|row| row[k]).collect())).collect()
}

struct Problem {
    modes: Vec<(f64, Vec<f64>)>,
    period: f64,
    /// Mass, stop, and whether it is hit at φ.
    hits: Vec<(usize, f64, bool)>,
}

impl Problem {
    /// K and K′ between two masses at 0 ≤ t < T; K′ at 0 is the mean of both sides.
    fn kernel(&self, i: usize, j: usize, t: f64) -> [f64; 2] {
        let offset = t - 0.5 * self.period;
        self.modes.iter().fold([0.0; 2], |[value, slope], (w, shape)| {
            let size = shape[i] * shape[j] / (2.0 * (0.5 * w * self.period).sin());
            [value + size * (w * offset).cos() / w, slope - if t == 0.0 { 0.0 } else { size * (w * offset).sin() }]
        })
    }

    /// Impulses for given φ, and what Newton's law leaves at each impact, relative to the largest impulse.
    fn newton(&self, phi: f64) -> Option<(Vec<f64>, Vec<f64>)> {
        let n = self.hits.len();
        let time = |late: bool| if late { phi } else { 0.0 };
        let between = |i: usize, j: usize| {
            let ((to, _, late), (from, _, other)) = (self.hits[i], self.hits[j]);
            self.kernel(to, from, (time(late) - time(other)).rem_euclid(self.period))
        };
        let kernels: Vec<Vec<[f64; 2]>> = (0..n).map(|i| (0..n).map(|j| between(i, j)).collect()).collect();
        let mut rows: Vec<Vec<f64>> =
            (0..n).map(|i| kernels[i].iter().map(|kernel| kernel[0]).chain([self.hits[i].1]).collect()).collect();
        for column in 0..n {
            let pivot = (column..n).max_by(|&i, &j| rows[i][column].abs().total_cmp(&rows[j][column].abs()))?;
            rows.swap(column, pivot);
            for i in (0..n).filter(|&i| i != column) {
                let factor = rows[i][column] / rows[column][column];
                let above = rows[column].clone();
                rows[i].iter_mut().zip(above).for_each(|(entry, above)| *entry -= factor * above);
            }
        }
        let impulses: Vec<f64> = (0..n).map(|i| rows[i][n] / rows[i][i]).collect();
        let largest = impulses.iter().fold(0.0, |most: f64, p| most.max(p.abs()));
        let left = |i: usize| (0..n).map(|j| kernels[i][j][1] * impulses[j]).sum::<f64>() / largest;
        let left = (0..n).map(left).collect();
        largest.is_finite().then_some((impulses, left))
    }

    /// All φ of orbits, in (0, T) without T/2, and their impulses.
    fn scan(&self, points: usize) -> Vec<(f64, Vec<f64>)> {
        let combined = |phi: f64| {
            let (_, left) = self.newton(phi)?;
            Some(left.iter().enumerate().map(|(i, left)| left * (1.0 + 0.37 * (i as f64 * 2.1).sin())).sum::<f64>())
        };
        let phi = |i: usize| (i as f64 + 0.37) * self.period / points as f64;
        let mut orbits = Vec::new();
        for i in 0..points - 1 {
            let (mut low, mut high) = (phi(i), phi(i + 1));
            let (Some(first), Some(last)) = (combined(low), combined(high)) else { continue };
            if (first < 0.0) == (last < 0.0) {
                continue;
            }
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                let Some(value) = combined(middle) else { break };
                if (value < 0.0) == (first < 0.0) { low = middle } else { high = middle }
            }
            let Some((impulses, left)) = self.newton(low) else { continue };
            let trivial = [0.0, 0.5, 1.0].iter().any(|part| (low - part * self.period).abs() < 2e-5 * self.period);
            if !trivial && left.iter().all(|left| left.abs() < 1e-8) {
                orbits.push((low, impulses));
            }
        }
        orbits
    }
}

/// Words by lattice: of one mass and of several, at the same and at other masses, alike by a symmetry and not.
const WORDS: [(Kind, usize, &[&str]); 5] = [
    (
        Kind::Ring,
        4,
        &["0+,0-", "0-,0-", "0+,0+", "0+2+,0-2-", "0+1+,0-1-", "0+1-,0-1+", "0+,1-", "0+,1-3-", "0+1+2+,0-1-2-"],
    ),
    (Kind::Free, 3, &["0+,0-", "1+,1-", "0-,0-", "2+,2+", "0+2+,0-2-", "0+1+,0-1-", "0+2-,0-2+", "0+,2-", "0+2+,1-"]),
    (Kind::Fixed, 3, &["0+,0-", "1+,1-", "1-,1-", "0+2+,0-2-", "0+1-,0-1+", "1+,0-2-", "0+1+,1-2-"]),
    (Kind::Layers, 3, &["0+,0-", "0-,0-", "0:0+0:1+,0:0-0:1-", "0:0+0:1-,0:0-0:1+", "0:0+1:1+,0:0-1:1-", "0:0+,0:1-"]),
    (Kind::LayersOfRows, 2, &["0+,0-", "0:0+1:0+,0:0-1:0-", "0:0+0:1+1:0+1:1+,0:0-0:1-1:0-1:1-", "0:0+,1:1-"]),
];

/// When the last impacts of the physical orbits of a list are, rising.
fn physical_times(finder: &mut Finder, found: &OrbitList) -> Vec<f64> {
    let mut physical = |orbit: &&Orbit| finder.admissibility(orbit).unwrap().is_physical();
    let mut times: Vec<f64> =
        found.orbits.iter().filter(|orbit| physical(orbit)).map(|orbit| orbit.impacts().last().unwrap().time).collect();
    times.sort_by(f64::total_cmp);
    times
}

/// Soft points on all lattices, with centred gaps or not: every orbit of the scan is in the list, none but orbits is, and maps ask for
/// no fewer.
#[test]
fn lists_of_two_instants_are_complete() {
    let mut random = fastrand::Rng::with_seed(35);
    let mut compared = vec![vec![0; 9]; WORDS.len()];
    let (mut physical, mut open, mut rounds) = (0, 0, 0);
    for round in 0..24 {
        for (place, (kind, length, words)) in WORDS.into_iter().enumerate() {
            let (gamma1, gamma2) = (0.02 + 0.1 * random.f64(), 0.25 + 0.35 * random.f64());
            let (omega, a) = (0.3 + 0.5 * random.f64(), if round % 3 == 0 { 0.0 } else { 0.15 * random.f64() });
            let chain = chain(kind, length, gamma1, gamma2);
            let model = Model::conservative(chain, omega, a).unwrap();
            let (mut finder, mut found) = (Finder::new(chain.sites()), OrbitList::default());
            let modes = modes(stiffness(kind, length, gamma1, gamma2));
            for (number, text) in words.iter().enumerate() {
                let word: Word = text.parse().unwrap();
                if finder.find_word(&model, &word, Scope::All, &mut found).is_err() {
                    continue;
                }
                rounds += 1;
                if !found.completeness.is_established() {
                    open += 1;
                    continue;
                }
                let hits = (word.instants().iter().enumerate())
                    .flat_map(|(late, letters)| letters.iter().map(move |letter| (letter, late == 1)))
                    .map(|(letter, late)| (letter.layer * length + letter.site, model.barrier(letter.barrier), late))
                    .collect();
                let problem = Problem { modes: modes.clone(), period: TAU / omega, hits };
                let scanned = problem.scan(1000);
                let repeats = word.instants()[0] == word.instants()[1];
                let phi = |orbit: &Orbit| orbit.impacts().last().unwrap().time;
                let half = 0.5 * model.period();
                for (time, impulses) in &scanned {
                    if repeats && *time > half {
                        continue;
                    }
                    compared[place][number] += 1;
                    let near = |orbit: &&Orbit| (phi(orbit) - time).abs() < 1e-7 * half;
                    let Some(orbit) = found.orbits.iter().find(near) else {
                        let listed: Vec<f64> = found.orbits.iter().map(phi).collect();
                        panic!("{text} {model}: {time} {impulses:?} is missing: {:?}, {listed:?}", found.completeness)
                    };
                    for (impact, impulse) in orbit.impacts().iter().zip(impulses) {
                        let apart = (impact.impulse - impulse).abs();
                        assert!(apart < 1e-6 * impulse.abs().max(1.0), "{text} {model}: {time} {impulses:?} {orbit:?}");
                    }
                }
                let sound =
                    |orbit: &Orbit| orbit.residual() < 1e-10 * orbit.strongest_impulse().unwrap().abs().max(1.0);
                assert!(found.orbits.iter().all(sound), "{text} {model}");
                let all = physical_times(&mut finder, &found);
                finder.find_word(&model, &word, Scope::Candidates, &mut found).unwrap();
                let asked = physical_times(&mut finder, &found);
                assert!(found.completeness.is_established() && all == asked, "{text} {model}: {all:?} {asked:?}");
                let others = all.iter().filter(|phi| **phi != half && **phi != 0.0).count();
                physical += others;
                finder.find_word(&model, &word, Scope::SymmetricCandidates, &mut found).unwrap();
                let left_out = matches!(found.completeness, Completeness::Asked { .. });
                assert!(left_out || others == 0, "{text} {model}: {:?}", found.completeness);
            }
        }
    }
    for ((_, _, words), compared) in WORDS.iter().zip(&compared) {
        for (text, count) in words.iter().zip(compared) {
            println!("{text}: {count}");
        }
    }
    println!("{physical} physical, {open} of {rounds} lists open");
    assert!(physical > 10 && open * 100 < rounds, "{physical} {open} {rounds}");
    // Of words that symmetry makes one impact of a block, and of one mass, there are many.
    for (place, number) in [(0, 0), (0, 1), (0, 2), (0, 3), (0, 4), (1, 0), (1, 2), (2, 1), (3, 2), (4, 1)] {
        assert!(compared[place][number] > 5, "{:?}", WORDS[place].2[number]);
    }
}

/// 40 digits by hand: two impacts alike.
#[test]
fn two_impacts_on_one_barrier_without_force() {
    let model = Model::conservative(Chain::new(5, 0.4, 0.42).unwrap(), 0.343, 0.2).unwrap();
    let (mut finder, mut found) = (Finder::new(5), OrbitList::default());
    let word: Word = "0-,0-".parse().unwrap();
    finder.find_word(&model, &word, Scope::All, &mut found).unwrap();
    assert!(found.completeness.is_established());
    let physical: Vec<_> = found.orbits.iter().filter(|o| finder.admissibility(o).unwrap().is_physical()).collect();
    let [orbit] = physical.as_slice() else { panic!("{physical:?}") };
    let [first, second] = orbit.impacts() else { panic!() };
    assert!((second.time - 6.801_142_509_463_48).abs() < 1e-13);
    assert!([first, second].iter().all(|impact| (impact.impulse - 0.631_175_282_223_376_5).abs() < 1e-13));
    assert!((finder.admissibility(orbit).unwrap().margin.unwrap() - 0.110).abs() < 5e-4);
    // Above the band every list ends with the one that repeats.
    let fast = Model::conservative(*model.chain(), 2.0, 0.2).unwrap();
    finder.find_word(&fast, &word, Scope::All, &mut found).unwrap();
    assert_eq!(found.completeness.reason(), Some(NoBreather::RepeatsSooner));
    assert!(found.completeness.is_established());
}

/// A free row of two masses is a ring of two with half the coupling, whose one spring counts twice.
#[test]
fn a_row_of_two_is_a_ring_of_two_with_half_the_coupling() {
    for (omega, known) in [(0.6, Some(2.630_158_611_762_719_3)), (0.56, None)] {
        let row = Chain::new(2, 0.04, 0.5).unwrap().with_ends(Ends::Free);
        let [row, ring] = [row, Chain::new(2, 0.04, 0.25).unwrap()].map(|chain| {
            let model = Model::conservative(chain, omega, 0.0).unwrap();
            let (mut finder, mut found) = (Finder::new(2), OrbitList::default());
            finder.find_word(&model, &"0+,0-".parse().unwrap(), Scope::Candidates, &mut found).unwrap();
            assert!(found.completeness.is_established());
            let physical = |orbit: &Orbit| finder.admissibility(orbit).unwrap().is_physical();
            found.orbits.retain(physical);
            found.orbits.iter().map(|orbit| orbit.impacts()[1]).collect::<Vec<_>>()
        });
        assert!(row.len() == 2 && ring.len() == 2, "{row:?} {ring:?}");
        for (one, other) in row.iter().zip(&ring) {
            assert!((one.time - other.time).abs() + (one.impulse - other.impulse).abs() < 1e-12);
        }
        if let Some(known) = known {
            assert!((row[0].time - known).abs() < 1e-13 && (row[0].impulse - 1.024_823_027_288_772).abs() < 1e-13);
        }
    }
}

/// What no search reaches is not called complete: more instants, masses that feel nothing of each other, a force on several masses at once that no symmetry makes alike.
#[test]
fn what_is_not_searched_is_not_complete() {
    let ring = |gamma2: f64| Chain::new(6, 0.2, gamma2).unwrap();
    let free = |gamma2: f64| Model::conservative(ring(gamma2), 1.5, 0.2).unwrap();
    let forced = ring(0.05).point().omega(1.5).asymmetry(0.2).amplitude(0.1).restitution(0.9).model().unwrap();
    let far = Model::conservative(Chain::new(400, 0.2, 1e-3).unwrap(), 1.5, 0.2).unwrap();
    for (model, text) in [
        (free(0.05), "0+3+,3-,0-3+,3-"),
        (free(0.05), "0+,0-,3+,3-"),
        (free(0.0), "0+,3-"),
        (free(0.0), "0+1-,2+3-"),
        (far, "0+,200-"),
        (forced, "0+1-,0-1+"),
        (forced, "0-1-3-"),
        (forced, "0-,1-,2-,3-"),
    ] {
        let mut found = OrbitList::default();
        let word: Word = text.parse().unwrap();
        Finder::new(model.chain().sites()).find_word(&model, &word, Scope::All, &mut found).unwrap();
        assert!(!found.completeness.is_established(), "{text} {model}: {:?}", found.completeness);
    }
    // Nothing holds the ring as a whole: a singular system of what is alike went on for ever.
    let adrift = Model::conservative(Chain::new(20, 0.0, 0.1).unwrap(), 0.45, 0.0).unwrap();
    let mut found = OrbitList::default();
    Finder::new(20).find_word(&adrift, &"0+4+9+,0-4-9-".parse().unwrap(), Scope::All, &mut found).unwrap();
    assert!(found.completeness.is_established(), "{:?}", found.completeness);
    // Two instants and three have proved lists.
    for (model, text) in [
        (forced, "0-,1-"),
        (forced, "0-,1-,2-"),
        (forced, "0+1+,0-1-"),
        (forced, "0-2-4-,0-2-4-,0+2+4+"),
        (free(0.05), "0+,0-,3+"),
        (free(0.05), "0+3+,0-3-,0-3-"),
    ] {
        Finder::new(6).find_word(&model, &text.parse().unwrap(), Scope::All, &mut found).unwrap();
        assert!(found.completeness.is_established(), "{text} {model}: {:?}", found.completeness);
    }
    // And what needs none is: one instant, modes all slower than the orbit.
    for text in ["0-", "0+1+3-", "0+3-,0-3+", "0+1+2-,0-1-2+"] {
        let mut found = OrbitList::default();
        Finder::new(6).find_word(&free(0.05), &text.parse().unwrap(), Scope::All, &mut found).unwrap();
        assert!(found.completeness.is_established() && found.orbits.len() == 1, "{text}: {:?}", found.completeness);
    }
}
