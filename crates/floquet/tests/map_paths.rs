//! What maps and large rings need faster, held against all zeros of the impacts' determinant: breathers at one site without force, with
//! losses, words of several sites by a matrix, and rings whose sums go over poles far apart at once.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use vibrochain_breather::{Family, Finder, OrbitList, Scope, Word};
use vibrochain_floquet::{Analyser, FloquetError, ImpactSpectrum, Method, Tolerance};
use vibrochain_lattice::{Chain, Model};
use vibrochain_testkit::{Meeting, Random, Ranges, Values};

#[derive(Debug, Default)]
struct Tally {
    compared: usize,
    stable: usize,
    unstable: usize,
    open: usize,
}

/// The words of a kind on a lattice, and the tally of their orbits.
fn verdicts_agree(seed: u64, ranges: &Ranges, word: impl Fn(&mut Random, &Chain) -> Option<String>) -> Tally {
    let (mut random, mut tally) = (Random(seed), Tally::default());
    for round in 0..900 {
        let (chain, model) = (random.lattice(ranges), random.model(ranges));
        let omega = match round % 4 {
            // Next to stripes and coincident poles.
            0 => random.meeting(&chain, random_meeting(round), 3, Values::Log(1e-9, 1e-2)).clamp(0.3, 3.0),
            _ => model.omega(),
        };
        let Ok(model) = model.point().on(&chain).omega(omega).model() else { continue };
        let Some(word) = word(&mut random, &chain) else { continue };
        let word: Word = word.parse().unwrap();
        let (mut finder, mut found) = (Finder::new(chain.sites()), OrbitList::default());
        if finder.find_word(&model, &word, Scope::Symmetric, &mut found).is_err() {
            continue;
        }
        for orbit in found.orbits.iter().take(2) {
            let (mut fast, mut whole) = (Analyser::default(), Analyser::default());
            let fast = match fast.verdict(orbit, &mut finder, Tolerance::Rounding) {
                Err(FloquetError::Grazing { .. }) => continue,
                fast => fast.unwrap(),
            };
            let whole = whole.stability(orbit, &mut finder, Tolerance::Rounding).unwrap().verdict;
            let told = format!("{word} {model} {fast:?} {whole:?}");
            let off = (fast.excess() - whole.excess()).abs();
            let allowed = 4.0 * (fast.resolution + whole.resolution) + 1e-12 * (1.0 + whole.excess());
            assert!(off <= allowed, "{told} {off:e}");
            tally.compared += 1;
            if fast.undecided || whole.undecided {
                tally.open += 1;
                continue;
            }
            assert_eq!((fast.stable, fast.mechanism), (whole.stable, whole.mechanism), "{told}");
            *(if fast.stable { &mut tally.stable } else { &mut tally.unstable }) += 1;
        }
    }
    println!("{tally:?}");
    tally
}

fn random_meeting(round: usize) -> Meeting {
    if round.is_multiple_of(8) { Meeting::Sum } else { Meeting::Difference }
}

impl Tally {
    fn is_sound(&self) -> bool {
        let many = self.compared > 250 && self.stable > 60 && self.unstable > 60;
        many && 10 * self.open <= self.compared
    }
}

fn place(chain: &Chain, site: usize) -> String {
    let (n, layer) = chain.layout().place(site);
    format!("{n}:{layer}")
}

const CONSERVATIVE: Ranges = Ranges { sites: [2, 14], gamma2: Values::Log(1e-4, 0.3), ..Ranges::CONSERVATIVE };

#[test]
fn breathers_at_one_site() {
    let tally = verdicts_agree(1, &CONSERVATIVE, |random, chain| {
        let site = place(chain, random.below(chain.sites()));
        Some(random.of(&["S+,S-", "S-"]).replace('S', &site))
    });
    assert!(tally.is_sound(), "{tally:?}");
}

#[test]
fn words_of_several_sites() {
    // Two that hardly feel each other have a pair of multipliers at 1 as far as rounding can tell.
    let ranges = Ranges { gamma2: Values::Log(2e-2, 0.3), ..CONSERVATIVE };
    let tally = verdicts_agree(2, &ranges, |random, chain| {
        let [site, other] = [(), ()].map(|()| random.below(chain.sites()));
        let (one, other) = (place(chain, site), (site != other).then(|| place(chain, other))?);
        Some(random.of(&["A+B+,A-B-", "A-B-"]).replace('A', &one).replace('B', &other))
    });
    assert!(tally.is_sound(), "{tally:?}");
}

#[test]
fn breathers_with_losses() {
    let ranges = Ranges { sites: [2, 9], gamma2: Values::Log(1e-4, 0.3), ..Ranges::FORCED };
    let tally = verdicts_agree(3, &ranges, |random, chain| {
        let site = place(chain, random.below(chain.sites()));
        Some(random.of(&["S+,S-", "S-", "S-,S-"]).replace('S', &site))
    });
    assert!(tally.is_sound(), "{tally:?}");
}

/// 301 modes that feel the impacts: more than any sum over pairs is taken of.
#[test]
fn large_rings_have_the_multipliers_of_the_spectrum() {
    let (mut finder, mut found, mut analyser) = (Finder::new(601), OrbitList::default(), Analyser::default());
    let (mut compared, mut unstable) = (0, 0);
    for (omega, gamma2, amplitude) in [(0.8, 0.1, 0.0), (1.5, 0.1, 0.0), (0.9, 0.01, 0.0), (1.5, 0.1, 0.1)] {
        let chain = Chain::new(601, 0.2, gamma2).unwrap();
        let model = match amplitude > 0.0 {
            true => chain.point().omega(omega).asymmetry(0.4).amplitude(amplitude).restitution(0.9).model().unwrap(),
            false => Model::conservative(chain, omega, 0.4).unwrap(),
        };
        for family in [Family::SingleSided, Family::DoubleSided] {
            finder.find_symmetric(&model, family, &mut found).unwrap();
            let Some(orbit) = found.orbits.first() else { continue };
            let own = analyser.stability(orbit, &mut finder, Tolerance::Rounding).unwrap();
            assert_eq!(own.verdict.method, Method::Secular);
            let (equations, _) = finder.at_contacts(orbit).unwrap().bloch_equations();
            let spectrum = if amplitude > 0.0 {
                ImpactSpectrum::new(&equations)
            } else {
                ImpactSpectrum::conservative(&equations)
            };
            if !spectrum.is_certified {
                continue;
            }
            for (mu, error) in spectrum.multipliers.iter().zip(&spectrum.errors) {
                let off = own.multipliers.iter().map(|other| (mu - other).norm()).fold(f64::INFINITY, f64::min);
                assert!(off <= 10.0 * error + 1e-8 * mu.norm(), "{model} {family:?}: {mu} {off:e} {error:e}");
            }
            let largest = spectrum.multipliers.iter().map(|mu| mu.norm()).fold(0.0, f64::max);
            assert!((own.verdict.spectral_radius / largest - 1.0).abs() < 1e-9, "{largest} {:?}", own.verdict);
            compared += 1;
            unstable += usize::from(!own.verdict.stable);
        }
    }
    assert!(compared >= 7 && unstable > 0 && unstable < compared, "{compared} {unstable}");
}
