//! All multipliers of one orbit of any word as the zeros of one determinant, against dense matrices: rings, rows and layers; with and
//! without force and losses; next to stripes, coincident poles and no coupling at all; where multipliers are double.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use vibrochain_breather::{BlochEquations, Finder, LinearImpact, Orbit, OrbitList, Scope, Word};
use vibrochain_floquet::{Analyser, Complex, FloquetError, ImpactSpectrum, Method, Tolerance, stability};
use vibrochain_lattice::{BlochKernel, Chain, Ends, Model, Parameter, Point};
use vibrochain_testkit::{Meeting, Random, Ranges, Values};

#[derive(Debug, Default)]
struct Tally {
    orbits: usize,
    certified: usize,
    rings: usize,
    layered: usize,
    walls: usize,
    lossy: usize,
    elastic: usize,
    many: usize,
    unstable: usize,
    spared: usize,
    /// Distances from dense multipliers, in their plane.
    off: Vec<f64>,
}

/// ν of a multiplier, in whose plane dense eigenvalues of reciprocal pairs are not split by roots.
fn half_sum(z: Complex<f64>) -> Complex<f64> {
    (z + z.inv()) * 0.5
}

impl Tally {
    /// All multipliers against those of a matrix.
    fn compare(&mut self, orbit: &Orbit, finder: &mut Finder) {
        let conservative = orbit.model().unwrap().is_conservative();
        let dense = match Analyser::dense().stability(orbit, finder, Tolerance::Rounding) {
            Err(FloquetError::Grazing { .. }) => return,
            dense => dense.unwrap(),
        };
        let (equations, _) = finder.at_contacts(orbit).unwrap().bloch_equations();
        let spectrum =
            if conservative { ImpactSpectrum::conservative(&equations) } else { ImpactSpectrum::new(&equations) };
        let told = format!("{} {}", Word::of(orbit), orbit.model().unwrap());
        let free = 2 * (orbit.model().unwrap().chain().sites() - equations.kernel().modes().len());
        let trivial = if conservative { 2 } else { 0 };
        assert_eq!(spectrum.multipliers.len() + free + trivial, dense.multipliers.len(), "{told}");
        self.orbits += 1;
        self.certified += usize::from(spectrum.is_certified);
        if !spectrum.is_certified {
            return;
        }
        let elastic = orbit.model().unwrap().loss() == 0.0;
        let mut open = dense.multipliers.clone();
        let mut farthest: f64 = 0.0;
        // A matrix knows none of its eigenvalues better than its norm and the next one allow.
        let rounding = 64.0 * f64::EPSILON * open.iter().map(|w| w.norm()).fold(0.0, f64::max);
        for (z, error) in spectrum.multipliers.iter().zip(&spectrum.errors) {
            let distance = |w: &Complex<f64>| {
                if elastic { (half_sum(*w) - half_sum(*z)).norm() } else { (w - z).norm() }
            };
            // Of two that share ν the nearer one.
            let key = |w: &Complex<f64>| distance(w) + 1e-6 * (w - z).norm();
            let nearest = (0..open.len()).min_by(|&i, &j| key(&open[i]).total_cmp(&key(&open[j]))).unwrap();
            let off = distance(&open.swap_remove(nearest));
            let scale = 1.0 + z.norm().max(1.0 / z.norm());
            let gaps = spectrum.multipliers.iter().filter(|w| *w != z).map(|w| (w - z).norm());
            let known = rounding / gaps.fold(1.0, f64::min);
            let steep = if elastic { 0.5 * (1.0 - z.powi(-2)).norm() * error + error * error } else { *error };
            assert!(off <= 4.0 * steep + 1e-8 * scale.powi(2) + known, "{z} {off:e} {error:e} {told}");
            farthest = farthest.max(off / scale);
        }
        self.off.push(farthest);
        let chain = orbit.model().unwrap().chain();
        self.rings += usize::from(chain.is_ring());
        self.layered += usize::from(chain.layers() > 1);
        self.walls += usize::from(chain.has_walls());
        self.lossy += usize::from(!elastic);
        self.elastic += usize::from(elastic && !conservative);
        self.many += usize::from(orbit.impacts().len() > 3);
        self.unstable += usize::from(spectrum.multipliers.iter().any(|z| z.norm() > 1.0 + 1e-6));
        self.spared += usize::from(free > 0);
    }

    fn median(&mut self) -> f64 {
        self.off.sort_by(f64::total_cmp);
        self.off[self.off.len() / 2]
    }
}

const CONSERVATIVE: Ranges = Ranges { sites: [2, 9], gamma2: Values::Log(1e-7, 0.3), ..Ranges::CONSERVATIVE };
const FORCED: Ranges = Ranges { sites: [2, 6], gamma2: Values::Log(1e-7, 0.02), ..Ranges::FORCED };

fn words_hold(seed: u64, rounds: usize) -> Tally {
    let mut random = Random(seed);
    let mut tally = Tally::default();
    for round in 0..rounds {
        let forced = round % 2 == 1;
        let ranges = if forced { &FORCED } else { &CONSERVATIVE };
        let (chain, model) = (random.lattice(ranges), random.model(ranges));
        let omega = match round % 8 {
            // Next to stripes and coincident poles.
            2 | 3 => {
                let meeting = random.of(&[Meeting::Sum, Meeting::Difference]);
                random.meeting(&chain, meeting, 3, Values::Log(1e-11, 1e-3)).clamp(0.3, 3.0)
            }
            _ => model.omega(),
        };
        let model = model.point().on(&chain).omega(omega).model().unwrap();
        let word: Option<Word> = if forced {
            random.of(&["0+,0-", "0-", "0-,0-", "0-1-", "0+1+,0-1-", "0+1-,0-1+"]).parse().ok()
        } else {
            random.word(&chain)
        };
        let (mut finder, mut found) = (Finder::new(chain.sites()), OrbitList::default());
        let Some(word) = word else { continue };
        if finder.find_word(&model, &word, Scope::All, &mut found).is_err() {
            continue;
        }
        for orbit in found.orbits.iter().take(2) {
            // Next to a resonance the matrix knows nothing.
            if finder.condition(orbit).unwrap().resonance > 1e-8 {
                tally.compare(orbit, &mut finder);
            }
        }
    }
    tally
}

#[test]
fn all_multipliers_are_those_of_the_matrix() {
    let mut tally = words_hold(1, 500);
    let median = tally.median();
    println!("{median:e} {:?}", Tally { off: Vec::new(), ..tally });
    assert!(median < 1e-12 && tally.orbits > 300 && 100 * tally.certified >= 95 * tally.orbits);
    let counts = [tally.rings, tally.layered, tally.walls, tally.lossy, tally.many, tally.unstable, tally.spared];
    assert!(counts.iter().all(|&count| count > 40) && tally.elastic > 15, "{counts:?}");
}

#[test]
#[ignore = "minutes: cargo test --workspace --test spectrum -- --ignored slow"]
fn slow_all_multipliers_of_ten_thousand_words_are_those_of_the_matrix() {
    let mut tally = words_hold(2, 10_000);
    let median = tally.median();
    println!("{median:e} {:?}", Tally { off: Vec::new(), ..tally });
    assert!(median < 1e-12 && tally.orbits > 6000 && 100 * tally.certified >= 96 * tally.orbits);
}

/// Every mass of a ring hits alike: its multipliers are those of four blocks, two of them twice.
#[test]
fn double_multipliers_of_a_ring_that_hits_all_around_are_told() {
    let model = Model::conservative(Chain::new(6, 1.0, 0.1).unwrap(), 1.4, 0.9).unwrap();
    let (mut finder, mut found) = (Finder::new(6), OrbitList::default());
    finder.find_word(&model, &"0-1-2-3-4-5-".parse().unwrap(), Scope::All, &mut found).unwrap();
    let answer = stability(&found.orbits[0], Tolerance::Rounding).unwrap();
    assert!(answer.verdict.stable && !answer.verdict.undecided, "{:?}", answer.verdict);
    assert_eq!((answer.verdict.method, answer.verdict.resolution), (Method::Secular, 0.0));
    let mut traces: Vec<f64> = answer.multipliers.iter().map(|z| 2.0 * z.re).collect();
    assert!(answer.multipliers.iter().all(|z| (z.norm() - 1.0).abs() < 1e-14));
    traces.sort_by(f64::total_cmp);
    // By symmetry: k = 3 once, k = 2 and 1 twice, and the trivial pair.
    for (i, expected) in [-0.012, 0.498, 0.498, 1.531, 1.531, 2.0].into_iter().enumerate() {
        let pair = &traces[2 * i..2 * i + 2];
        let near = [-0.012, 0.498, 1.531, 2.0].iter().map(|x| (x - pair[0]).abs()).fold(1.0, f64::min);
        assert!(near < 1e-3 && (pair[0] - pair[1]).abs() < 1e-12, "{i} {expected} {traces:?}");
    }
}

/// The same of rings of other lengths, hit on one side or on both, and of layers: as the matrix has them, and hardly one left open.
#[test]
fn symmetric_words_are_not_left_open() {
    let mut random = Random(9);
    let (mut checked, mut stable, mut held, mut open) = (0, 0, 0, 0);
    for round in 0..60 {
        let sites = 3 + round % 5;
        let gamma1 = random.between(0.3, 1.5);
        let mut chain = Chain::new(sites, gamma1, random.between(0.01, 0.1) * gamma1).unwrap();
        let layers = 1 + round % 2;
        if layers == 2 {
            chain = chain.with_layers(2, 0.05 * gamma1, Ends::Free).unwrap();
        }
        let side = |sign: char| -> String {
            (0..layers).flat_map(|layer| (0..sites).map(move |n| format!("{n}:{layer}{sign}"))).collect()
        };
        let word = if round % 3 == 0 { side('-') } else { format!("{},{}", side('+'), side('-')) };
        let omega = gamma1.sqrt() * random.between(1.05, 1.9);
        let model = Model::conservative(chain, omega, random.between(0.1, 0.9)).unwrap();
        let (mut finder, mut found) = (Finder::new(chain.sites()), OrbitList::default());
        if finder.find_word(&model, &word.parse().unwrap(), Scope::All, &mut found).is_err() {
            continue;
        }
        for orbit in found.orbits.iter().take(1) {
            let Ok(answer) = stability(orbit, Tolerance::Rounding) else { continue };
            let dense = Analyser::dense().stability(orbit, &mut finder, Tolerance::Rounding).unwrap();
            let radius = |all: &[Complex<f64>]| all.iter().map(|z| z.norm()).fold(1.0, f64::max);
            let (own, other) = (radius(&answer.multipliers), radius(&dense.multipliers));
            assert!((own - other).abs() < 1e-6 * other, "{word} {model} {own} {other}");
            stable += usize::from(answer.verdict.stable);
            held += usize::from(answer.verdict.stable && dense.verdict.undecided);
            open += usize::from(answer.verdict.undecided);
            checked += 1;
        }
    }
    println!("{checked} {stable} {held} {open}");
    // Of two layers as stiff as the row blocks of different symmetry may all but coincide.
    assert!(checked > 25 && stable > 5 && held > 3 && 10 * open <= checked, "{checked} {stable} {held} {open}");
}

/// Without coupling each mass that is hit has the multipliers it has alone, and coupling that is next to nothing moves them by as much.
#[test]
fn uncoupled_words_are_as_many_masses_alone() {
    let mut checked = 0;
    for (word, alone) in [("0-2-", "0-"), ("0+2+,0-2-", "0+,0-")] {
        let chain = Chain::new(4, 0.5, 0.0).unwrap();
        let model = chain.point().omega(1.3).asymmetry(0.4).amplitude(0.4).restitution(0.7).model().unwrap();
        let find = |model: &Model, word: &str| {
            let (mut finder, mut found) = (Finder::new(model.chain().sites()), OrbitList::default());
            finder.find_word(model, &word.parse().unwrap(), Scope::All, &mut found).unwrap();
            found.orbits
        };
        for coupling in [0.0, 1e-12] {
            let both = model.with(Parameter::Gamma2, coupling).unwrap();
            for orbit in find(&both, word) {
                let answer = stability(&orbit, Tolerance::Rounding).unwrap();
                let own: Vec<Complex<f64>> =
                    answer.multipliers.iter().copied().filter(|z| (z.norm() - 1.0).abs() > 1e-6).collect();
                let ring = Point::ring(1).gamma1(0.5).gamma2(0.0);
                let one = ring.omega(1.3).asymmetry(0.4).amplitude(0.4).restitution(0.7).model().unwrap();
                let singles: Vec<_> =
                    find(&one, alone).iter().map(|orbit| stability(orbit, Tolerance::Rounding).unwrap()).collect();
                assert_eq!(own.len(), 4, "{word} {coupling} {own:?}");
                for z in own {
                    let all = singles.iter().flat_map(|single| &single.multipliers);
                    let off = all.map(|w| (w - z).norm()).fold(f64::INFINITY, f64::min);
                    assert!(off < 1e-9, "{word} {coupling} {z} {off:e}");
                }
                checked += 1;
            }
        }
    }
    assert!(checked >= 4, "{checked}");
}

/// Where two multipliers meet they are told together, with the circle that holds both as their error. One mass with a dashpot that hits once
/// a period: their product is e²·e^{−2ζΩT}, and their sum grows linearly with the acceleration before the impact.
#[test]
fn two_that_meet_are_told() {
    let (frequency, damping, period, restitution) = (1.3, 0.1, 4.0, 0.8_f64);
    let spectrum = |acceleration_before: f64| {
        let mut kernel = BlochKernel::new(period, 1);
        kernel.push_oscillator(frequency, damping, &[1.0]);
        let impact = LinearImpact { contact: 0, time: 0.0, impulse: -1.0, restitution, acceleration_before };
        ImpactSpectrum::new(&BlochEquations::new(kernel, vec![impact]))
    };
    let sum = |acceleration: f64| spectrum(acceleration).multipliers.iter().sum::<Complex<f64>>().re;
    let product = (restitution * f64::exp(-damping * frequency * period)).powi(2);
    let mut told = 0;
    for double in [product.sqrt(), -product.sqrt()] {
        let (one, two) = (sum(1.0), sum(2.0));
        let meeting = 1.0 + (2.0 * double - one) / (two - one);
        for off in [0.0, 1e-16, -1e-16, 1e-14, -1e-14, 1e-12, -1e-12, 1e-10, -1e-10, 1e-8, -1e-8, 1e-6, -1e-6] {
            let there = spectrum(meeting + off);
            assert!(there.is_certified && there.multipliers.len() == 2, "{double} {off}: {there:?}");
            let apart = (0.25 * (off * (two - one)).powi(2) + double * off * (two - one)).abs().sqrt();
            for (multiplier, error) in there.multipliers.iter().zip(&there.errors) {
                let distance = ((multiplier - double).norm() - apart).abs();
                assert!(distance <= 1e-7 + apart * 1e-2 && *error < 1e-2, "{double} {off}: {multiplier} {error}");
                told += 1;
            }
        }
    }
    assert_eq!(told, 52);
}
