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

    /// The classes of impacts that symmetries of the word turn into each other, one after the other in the order of the impacts: those of the
    /// lattice, with the barriers exchanged where they are centred and no force drives the masses, and, of a word of one or two instants, with the
    /// instants exchanged by reversal of time if `by_reversal`. Their impulses are alike then, but for signs: those of the barriers.
    pub(crate) fn classes(&self, model: &Model, by_reversal: bool) -> Vec<usize> {
        let layout = model.chain().layout();
        let centred = model.asymmetry() == 0.0 && model.is_conservative();
        let all: Vec<(usize, Letter)> =
            self.instants.iter().enumerate().flat_map(|(i, letters)| letters.iter().map(move |&l| (i, l))).collect();
        let turns = |&(instant, one): &(usize, Letter), &(image, other): &(usize, Letter)| {
            let (reversed, exchanged) = (instant != image, one.barrier != other.barrier);
            let along = moves_between(layout.length, layout.ends, one.site, other.site);
            let across = moves_between(layout.layers, layout.layer_ends, one.layer, other.layer);
            let mut moves = along.iter().flat_map(|along| across.iter().map(move |across| [along, across]));
            (by_reversal || !reversed)
                && (centred || !exchanged)
                && moves.any(|step| self.moved(step, reversed, exchanged) == self.instants)
        };
        let mut classes: Vec<usize> = Vec::with_capacity(all.len());
        for (i, impact) in all.iter().enumerate() {
            let known = (0..i).find(|&j| turns(&all[j], impact)).map(|j| classes[j]);
            classes.push(known.unwrap_or_else(|| classes.iter().max().map_or(0, |last| last + 1)));
        }
        classes
    }

    /// Whether the impacts of each instant are of one class: to Newton's law they are one impact.
    pub(crate) fn is_alike(&self, model: &Model) -> bool {
        let classes = self.classes(model, false);
        let mut from = 0;
        self.instants.iter().all(|letters| {
            let own = &classes[from..from + letters.len()];
            from += letters.len();
            own.iter().all(|class| *class == own[0])
        })
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

/// A symmetry of a row of `count` masses: what is at `home` comes to `to`, and perhaps the order is turned round.
#[derive(Debug, Clone, Copy)]
struct Move {
    count: usize,
    home: usize,
    to: usize,
    mirrored: bool,
}

impl Move {
    fn of(self, site: usize) -> usize {
        let away = (site + self.count - self.home) % self.count;
        (self.to + if self.mirrored { self.count - away } else { away }) % self.count
    }
}

/// The symmetries of a row that bring one site to another.
fn moves_between(count: usize, ends: Ends, home: usize, to: usize) -> Vec<Move> {
    let both = [false, true].map(|mirrored| Move { count, home, to, mirrored });
    match ends {
        Ends::Closed => both.to_vec(),
        Ends::Free | Ends::Fixed => {
            both.into_iter().filter(|step| if step.mirrored { home + to + 1 == count } else { home == to }).collect()
        }
    }
}

/// The symmetries of a row that may make a word with impacts at these sites smallest.
fn moves(count: usize, ends: Ends, homes: &[usize]) -> Vec<Move> {
    let shift = |home: usize| [false, true].map(|mirrored| Move { count, home, to: 0, mirrored });
    match ends {
        Ends::Closed => homes.iter().flat_map(|&home| shift(home)).collect(),
        // The last mass comes to 0, turned round, or all stay.
        Ends::Free | Ends::Fixed => {
            vec![
                Move { count, home: 0, to: 0, mirrored: false },
                Move { count, home: count - 1, to: 0, mirrored: true },
            ]
        }
    }
}

#[cfg(test)]
mod tests {
    use vibrochain_lattice::{Chain, Point};

    use super::*;

    fn word(text: &str) -> Word {
        text.parse().unwrap()
    }

    #[test]
    fn words_that_say_the_same_have_one_canonical_form() {
        let model = |asymmetry: f64, amplitude: f64| {
            let ring = Point::ring(12).gamma1(0.2).gamma2(0.1);
            ring.omega(1.5).asymmetry(asymmetry).amplitude(amplitude).model().unwrap()
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
            let along = Move { count: 12, home: random.usize(0..12), to: 0, mirrored: random.bool() };
            let mut other = one.moved([&along, &Move { count: 1, home: 0, to: 0, mirrored: false }], reversed, false);
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
