//! What is in the way at the points of a map that have no physical orbit, counted.

use std::collections::BTreeMap;

use crate::absence::Absence;
use crate::first_obstruction::FirstObstruction;

/// Contacts and impacts that are told apart: a line with their counts stays a few thousand bytes.
const MOST: usize = 32;

/// The cells in which one contact is in the way after one impact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Obstructed {
    /// Why they have no physical orbit.
    pub absence: Absence,
    /// Number of the contact.
    pub contact: u32,
    /// Number of the impact in the orbit's word, from 0.
    pub impact: u32,
    /// How many cells there are.
    pub cells: u64,
    /// The least and the largest time since that impact, as a part of the period.
    pub after: [f64; 2],
}

/// All of them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Obstructions {
    kinds: BTreeMap<(Absence, u32, u32), (u64, [f64; 2])>,
    /// Cells of further contacts and impacts.
    further: u64,
}

impl Obstructions {
    /// Counts a cell with one obstruction.
    pub fn count(&mut self, absence: Absence, first: FirstObstruction) {
        self.put((absence, first.contact, first.impact), (1, [first.after; 2]));
    }

    /// Adds the counts of other cells.
    pub fn add(&mut self, other: &Self) {
        other.kinds.iter().for_each(|(kind, counted)| self.put(*kind, *counted));
        self.further += other.further;
    }

    fn put(&mut self, kind: (Absence, u32, u32), (cells, after): (u64, [f64; 2])) {
        if self.kinds.len() == MOST && !self.kinds.contains_key(&kind) {
            self.further += cells;
            return;
        }
        let (count, range) = self.kinds.entry(kind).or_insert((0, after));
        *count += cells;
        *range = [range[0].min(after[0]), range[1].max(after[1])];
    }

    /// The commonest first.
    #[must_use]
    pub fn all(&self) -> Vec<Obstructed> {
        let of = |(&(absence, contact, impact), &(cells, after)): (&(Absence, u32, u32), &(u64, [f64; 2]))| {
            Obstructed { absence, contact, impact, cells, after }
        };
        let mut all: Vec<Obstructed> = self.kinds.iter().map(of).collect();
        all.sort_by_key(|one| std::cmp::Reverse(one.cells));
        all
    }

    /// As a line of a chunk has it: without spaces.
    pub(crate) fn text(&self) -> String {
        let kinds = self.all().into_iter().map(|Obstructed { absence, contact, impact, cells, after: [from, to] }| {
            format!("{}:{contact}:{impact}:{cells}:{from:e}:{to:e};", absence.name())
        });
        kinds.chain([self.further.to_string()]).collect()
    }

    /// What [`Obstructions::text`] has written.
    pub(crate) fn read(text: &str) -> Option<Self> {
        let mut read = Self::default();
        let mut parts: Vec<&str> = text.split(';').collect();
        read.further = parts.pop()?.parse().ok()?;
        for part in parts {
            let [absence, contact, impact, cells, from, to] = part.split(':').collect::<Vec<_>>()[..] else {
                return None;
            };
            let kind = (Absence::from_name(absence)?, contact.parse().ok()?, impact.parse().ok()?);
            let after = [from.parse().ok()?, to.parse().ok()?];
            if after.iter().any(|part: &f64| !part.is_finite()) {
                return None;
            }
            read.put(kind, (cells.parse().ok()?, after));
        }
        Some(read)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_add_up_and_come_back_from_text() {
        let (mut one, mut two, mut all) = (Obstructions::default(), Obstructions::default(), Obstructions::default());
        for number in 0..120 {
            let (contact, impact) = (number % 7, number % 3);
            let first = FirstObstruction { contact, impact, after: 0.01 + 0.001 * f64::from(number) };
            let absence = if number % 2 == 0 { Absence::CrossesAtOnce } else { Absence::Crosses };
            (if number < 50 { &mut one } else { &mut two }).count(absence, first);
            all.count(absence, first);
        }
        one.add(&two);
        let cells = |counts: &Obstructions| counts.all().iter().map(|one| one.cells).sum::<u64>() + counts.further;
        assert_eq!((cells(&one), cells(&all), all.all().len()), (120, 120, MOST));
        assert!(all.further > 0 && all.all()[0].cells >= all.all()[1].cells);
        for counts in [one, all, Obstructions::default()] {
            assert!(!counts.text().contains(' ') && counts.text().len() < 4000);
            assert_eq!(Obstructions::read(&counts.text()), Some(counts));
        }
        for wrong in ["", ";0", "crosses:0:0:1:0.1;0", "crosses:0:0:1:0.1:NaN;0", "crosses:0:0:1:0.1:0.2;"] {
            assert_eq!(Obstructions::read(wrong), None, "{wrong}");
        }
    }
}
