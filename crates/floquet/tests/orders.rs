//! Orders of signatures against verdicts: where the order changes between two stable orbits there is an unstable one.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use vibrochain_breather::{Finder, OrbitList, Scope, Word};
use vibrochain_floquet::{Analyser, OrderFinder, SignatureOrder, Tolerance};
use vibrochain_lattice::{Chain, Ends, Model};

/// A line in ω, and who looks at its points.
struct Line {
    chain: Chain,
    word: Word,
    asymmetry: f64,
    amplitude: f64,
    finder: Finder,
    analyser: Analyser,
    orders: OrderFinder,
    found: OrbitList,
}

impl Line {
    fn new(chain: Chain, word: &str, asymmetry: f64, amplitude: f64) -> Self {
        let finder = Finder::new(chain.sites());
        let word = word.parse().unwrap();
        let (analyser, orders, found) = (Analyser::default(), OrderFinder::default(), OrbitList::default());
        Self { chain, word, asymmetry, amplitude, finder, analyser, orders, found }
    }

    /// Whether the first orbit is stable, and its order; nothing where there is none, or its stability is open.
    fn at(&mut self, omega: f64) -> Option<(bool, SignatureOrder)> {
        let model =
            self.chain.point().omega(omega).asymmetry(self.asymmetry).amplitude(self.amplitude).model().unwrap();
        self.finder.find_word(&model, &self.word, Scope::All, &mut self.found).ok()?;
        let orbit = self.found.orbits.first()?;
        let verdict = self.analyser.verdict(orbit, &mut self.finder, Tolerance::Rounding).ok()?;
        let order = self.orders.of(orbit).unwrap().unwrap();
        (!verdict.undecided).then_some((verdict.stable, order))
    }

    /// Whether there is an unstable orbit between two stable ones of different order: halved to where the order changes.
    fn hides_a_stripe(&mut self, mut low: f64, mut high: f64, at_low: SignatureOrder) -> bool {
        for _ in 0..44 {
            let middle = 0.5 * (low + high);
            match self.at(middle) {
                Some((true, order)) if order == at_low => low = middle,
                Some((true, _)) => high = middle,
                Some((false, _)) => return true,
                // Closer to the edge of a stripe than rounding tells.
                None => return true,
            }
        }
        false
    }
}

#[test]
fn between_stable_orbits_of_different_order_there_is_an_unstable_one() {
    let ring = |sites| Chain::new(sites, 0.2, 0.07).unwrap();
    let layers = ring(4).with_layers(2, 0.05, Ends::Free).unwrap();
    let (mut changes, mut stripes, mut forced, mut alike, mut across) = (0, 0, 0, 0, 0);
    for (chain, word, amplitude) in [
        (ring(6), "0+1+,0-1-", 0.0),
        (ring(10), "0+3+,0-3-", 0.0),
        (ring(6).with_ends(Ends::Free), "0+1+,0-1-", 0.0),
        (ring(7).with_ends(Ends::Free), "2-3-", 0.0),
        (layers, "0:0+0:1+,0:0-0:1-", 0.0),
        // Under a force: from the whole monodromy matrix.
        (ring(8), "0+,0-", 0.1),
        (ring(6), "0+1+,0-1-", 0.1),
    ] {
        let mut line = Line::new(chain, word, 0.2, amplitude);
        let points = 300;
        let omega = |i: usize| 1.0 + 1.5 * i as f64 / f64::from(points);
        let seen: Vec<_> = (0..=points as usize).map(|i| line.at(omega(i))).collect();
        for i in 0..points as usize {
            let (Some((true, one)), Some((true, other))) = (seen[i], seen[i + 1]) else { continue };
            if one == other {
                alike += 1;
                continue;
            }
            changes += 1;
            let hides = line.hides_a_stripe(omega(i), omega(i + 1), one);
            stripes += usize::from(hides);
            forced += usize::from(hides && amplitude > 0.0);
        }
        // Beyond a stripe that points have met it is another, too.
        for part in seen.windows(3) {
            if let [Some((true, one)), Some((false, _)), Some((true, other))] = part {
                assert_ne!(one, other, "{chain} {word}");
                across += 1;
            }
        }
    }
    println!("{changes} changes, {stripes} stripes, {forced} under a force, {alike} alike, {across} across");
    assert!(changes >= 20 && stripes == changes && forced >= 5, "{changes} {stripes} {forced}");
    assert!(alike > 500 && across > 5, "{alike} {across}");
}

#[test]
fn orders_are_refused_where_a_matrix_would_take_too_long() {
    let chain = Chain::new(201, 0.2, 0.07).unwrap();
    let model = Model::conservative(chain, 1.5, 0.2).unwrap();
    let (mut finder, mut found) = (Finder::new(201), OrbitList::default());
    finder.find_word(&model, &"0+1+,0-1-".parse().unwrap(), Scope::All, &mut found).unwrap();
    let refused = OrderFinder::default().of(&found.orbits[0]).unwrap_err();
    assert!(refused.to_string().contains("201") && refused.to_string().contains("200"), "{refused}");
}
