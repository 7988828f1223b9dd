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
