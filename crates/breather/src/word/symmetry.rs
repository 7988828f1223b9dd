//! Words that a symmetry of the chain, of time or of the barriers turns into each other, and the smallest of them.

use vibrochain_lattice::{Barrier, Ends, Model};

use super::{Letter, Word};
use crate::orbit::Family;

impl Word {
    /// The smallest word that says the same of this model.
    pub fn canonical(&self, model: &Model) -> Self {
        let layout = model.chain().layout();
        let elastic = model.is_conservative();
        let centred = model.asymmetry() == 0.0;
        let places = self.places();
        let homes = |of: fn(&(usize, usize)) -> usize| {
            let mut homes: Vec<usize> = places.iter().map(of).collect();
            homes.sort_unstable();
            homes.dedup();
            homes
        };
        let along = moves(layout.length, layout.ends, &homes(|place| place.1));
        let across = moves(layout.layers, layout.layer_ends, &homes(|place| place.0));
        let mut smallest: Option<Self> = None;
        for exchanged in [false, true].into_iter().filter(|&exchanged| !exchanged || centred) {
            for reversed in [false, true].into_iter().filter(|&reversed| !reversed || elastic) {
                for (along, across) in along.iter().flat_map(|along| across.iter().map(move |across| (along, across))) {
                    let moved = self.moved([along, across], reversed, exchanged);
                    for shift in 0..moved.len() {
                        let mut instants = moved.clone();
                        instants.rotate_left(shift);
                        let word = Self { instants };
                        if smallest.as_ref().is_none_or(|smallest| word.precedes(smallest)) {
                            smallest = Some(word);
                        }
                    }
                }
            }
        }
        smallest.unwrap_or_else(|| self.clone())
    }

    /// By order, but that one impact is on the nearer barrier where the two are alike, as the family has it.
    fn precedes(&self, other: &Self) -> bool {
        let (single, of) = (self.family() == Some(Family::SingleSided), other.family() == Some(Family::SingleSided));
        if single == of { self < other } else { single }
    }

    fn moved(&self, [along, across]: [&Move; 2], reversed: bool, exchanged: bool) -> Vec<Vec<Letter>> {
        let letter = |&Letter { site, layer, barrier }: &Letter| {
            let barrier = match (exchanged, barrier) {
                (false, barrier) => barrier,
                (true, Barrier::Lower) => Barrier::Upper,
                (true, Barrier::Upper) => Barrier::Lower,
            };
            Letter { site: along.of(site), layer: across.of(layer), barrier }
        };
        let mut instants: Vec<Vec<Letter>> = (self.instants.iter())
            .map(|letters| {
                let mut letters: Vec<Letter> = letters.iter().map(letter).collect();
                letters.sort_unstable();
                letters
            })
            .collect();
        if reversed {
            instants.reverse();
        }
        instants
    }
}

/// A symmetry of a row of `count` masses: what is at `home` comes to 0, and perhaps the order is turned round.
#[derive(Debug, Clone, Copy)]
struct Move {
    count: usize,
    home: usize,
    mirrored: bool,
}

impl Move {
    fn of(self, site: usize) -> usize {
        let away = (site + self.count - self.home) % self.count;
        if self.mirrored { (self.count - away) % self.count } else { away }
    }
}

/// The symmetries of a row that may make a word with impacts at these sites smallest.
fn moves(count: usize, ends: Ends, homes: &[usize]) -> Vec<Move> {
    let shift = |home: usize| [false, true].map(|mirrored| Move { count, home, mirrored });
    match ends {
        Ends::Closed => homes.iter().flat_map(|&home| shift(home)).collect(),
        // The last mass comes to 0, turned round, or all stay.
        Ends::Free | Ends::Fixed => {
            vec![Move { count, home: 0, mirrored: false }, Move { count, home: count - 1, mirrored: true }]
        }
    }
}

#[cfg(test)]
mod tests {
    use vibrochain_lattice::Chain;

    use super::*;

    fn word(text: &str) -> Word {
        text.parse().unwrap()
    }

    #[test]
    fn words_that_say_the_same_have_one_canonical_form() {
        let model = |asymmetry: f64, amplitude: f64| {
            Model::forced(Chain::new(12, 0.2, 0.1).unwrap(), 1.5, asymmetry, amplitude, 1.0).unwrap()
        };
        let (free, forced, centred) = (model(0.2, 0.0), model(0.2, 0.1), model(0.0, 0.0));
        for (of, text, expected) in [
            (&free, "5-,5+", "0+,0-"),
            (&free, "7+", "0+"),
            (&centred, "7+", "0-"),
            (&free, "11+2+,2-11-", "0+3+,0-3-"),
            // A ring of twelve: nine apart is three apart.
            (&free, "0-9-,0+9+", "0+3+,0-3-"),
            (&free, "0+3-,0-3+", "0+3-,0-3+"),
            (&free, "3+,0+,5+", "0+,2+,5+"),
            (&forced, "3+,0+,5+", "0+,2+,5+"),
            // Reversal of time turns the order round.
            (&free, "0+,2+,0-,5+", "0+,2+,0-,5+"),
            (&free, "0+,5+,0-,2+", "0+,2+,0-,5+"),
            (&forced, "0+,5+,0-,2+", "0+,2+,9+,2-"),
        ] {
            let canonical = word(text).canonical(of);
            assert_eq!(canonical, canonical.canonical(of), "{text}");
            assert_eq!(canonical.to_string(), expected, "{text}");
        }
        // Every word that a symmetry makes of one has its form.
        let mut random = fastrand::Rng::with_seed(7);
        for _ in 0..200 {
            let count = 1 + random.usize(0..4);
            let instants = (0..count)
                .map(|_| {
                    let mut sites: Vec<usize> = (0..12).collect();
                    random.shuffle(&mut sites);
                    let barrier = |upper: bool| if upper { Barrier::Upper } else { Barrier::Lower };
                    sites.truncate(1 + random.usize(0..3));
                    sites.into_iter().map(|site| Letter::new(site, barrier(random.bool()))).collect()
                })
                .collect();
            let one = Word::new(instants).unwrap();
            let reversed = random.bool();
            let along = Move { count: 12, home: random.usize(0..12), mirrored: random.bool() };
            let mut other = one.moved([&along, &Move { count: 1, home: 0, mirrored: false }], reversed, false);
            other.rotate_left(random.usize(0..count));
            let other = Word { instants: other };
            assert_eq!(one.canonical(&free), other.canonical(&free));
            assert!(reversed || one.canonical(&forced) == other.canonical(&forced));
        }
    }

    #[test]
    fn lattices_have_the_symmetries_of_their_rows() {
        let ring = Chain::new(5, 0.2, 0.1).unwrap();
        let open = ring.with_ends(Ends::Free);
        let layered = |chain: Chain, layers, ends| chain.with_layers(layers, 0.1, ends).unwrap();
        for (chain, text, expected) in [
            (open, "4+,4-", "0+,0-"),
            (open, "3+,3-", "1+,1-"),
            (open, "2+4+,2-4-", "0+2+,0-2-"),
            (ring.with_ends(Ends::Fixed), "1+2-,1-2+", "1+2-,1-2+"),
            (layered(ring, 3, Ends::Free), "3:2+4:0+,3:2-4:0-", "0:0+1:2+,0:0-1:2-"),
            (layered(ring, 3, Ends::Free), "3:1+,3:1-", "0:1+,0:1-"),
            (layered(ring, 3, Ends::Closed), "3:2+4:0+,3:2-4:0-", "0:0+1:1+,0:0-1:1-"),
            (layered(open, 2, Ends::Free), "4:1+,4:1-", "0+,0-"),
        ] {
            let model = Model::conservative(chain, 1.5, 0.2).unwrap();
            assert_eq!(word(text).canonical(&model).to_string(), expected, "{chain} {text}");
            assert_eq!(word(expected).canonical(&model), word(expected), "{chain}");
        }
    }
}
