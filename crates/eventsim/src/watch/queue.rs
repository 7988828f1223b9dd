//! Contacts on their way to an event, the earliest first.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use crate::watch::Watch;
use vibrochain_lattice::Barrier;

/// A time before which a mass has no contact.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Entry {
    /// That time, never negative.
    pub(crate) key: f64,
    pub(crate) site: u32,
    /// Of what was known of the mass then: an entry of another version is of no account.
    pub(crate) version: u32,
}

impl Entry {
    /// By time, then by site. The bits of numbers that are not negative are in the order of the numbers.
    fn rank(&self) -> i128 {
        i128::from(self.key.to_bits() as i64) << 64 | i128::from(self.site)
    }
}

impl Ord for Entry {
    /// The queue is a max-heap.
    fn cmp(&self, other: &Self) -> Ordering {
        other.rank().cmp(&self.rank())
    }
}
impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl PartialEq for Entry {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Entry {}

const NONE: u32 = u32::MAX;

/// A contact on its way to its barrier, or at rest and on its way to be released.
#[derive(Debug, Clone)]
pub(crate) struct Candidate {
    pub(crate) contact: usize,
    pub(crate) hit: Option<Barrier>,
    /// In a window of series, its polynomial, once it is followed.
    pub(crate) watch: Option<Watch>,
}

/// One a contact at most, by the time since the base before which it has no event.
#[derive(Debug, Clone)]
pub(crate) struct Candidates {
    queue: BinaryHeap<Entry>,
    all: Vec<Candidate>,
    /// The number of each contact's; an entry of another number is of no account.
    slot: Vec<u32>,
}

impl Candidates {
    pub(crate) fn new(contacts: usize) -> Self {
        Self { queue: BinaryHeap::new(), all: Vec::new(), slot: vec![NONE; contacts] }
    }

    pub(crate) fn clear(&mut self) {
        self.queue.clear();
        self.all.drain(..).for_each(|candidate| self.slot[candidate.contact] = NONE);
    }

    pub(crate) fn push(&mut self, contact: usize, key: f64, hit: Option<Barrier>, watch: Option<Watch>) {
        let number = self.all.len() as u32;
        self.slot[contact] = number;
        self.all.push(Candidate { contact, hit, watch });
        self.queue.push(Entry { key, site: contact as u32, version: number });
    }

    /// What is known of a contact is of no account any more.
    pub(crate) fn forget(&mut self, contact: usize) {
        self.slot[contact] = NONE;
    }

    /// The earliest.
    pub(crate) fn first(&mut self) -> Option<(f64, &mut Candidate)> {
        loop {
            let &Entry { key, site, version } = self.queue.peek()?;
            if self.slot[site as usize] == version {
                return Some((key, &mut self.all[version as usize]));
            }
            self.queue.pop();
        }
    }

    /// The earliest has no event before `key`.
    pub(crate) fn put_off(&mut self, key: f64) {
        if let Some(mut top) = self.queue.peek_mut() {
            // It finds its new place from here: mostly it stays the earliest.
            top.key = key;
        }
    }

    /// Takes the earliest out.
    pub(crate) fn take(&mut self) -> Option<Entry> {
        self.queue.pop()
    }

    /// Puts back what was taken out.
    pub(crate) fn put_back(&mut self, taken: &mut Vec<Entry>) {
        self.queue.extend(taken.drain(..));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_come_out_by_time_and_then_by_site() {
        let tiny = f64::from_bits(1);
        let mut expected = Vec::new();
        for key in [0.0, tiny, f64::MIN_POSITIVE, 1e-200, 1.0 - 0.5 * f64::EPSILON, 1.0, 1.0 + f64::EPSILON, 1e3] {
            // The last site has the highest bit of its word.
            expected.extend([0, 3, 70_000, u32::MAX - 1].map(|site| (key, site)));
        }
        // 7 and the number of entries have no divisor in common: a permutation.
        let count = expected.len();
        let pushed = (0..count).map(|i| expected[i * 7 % count]);
        let mut queue: BinaryHeap<_> = pushed.map(|(key, site)| Entry { key, site, version: 0 }).collect();
        let popped: Vec<_> = std::iter::from_fn(|| queue.pop()).map(|entry| (entry.key, entry.site)).collect();
        assert_eq!(popped, expected);
    }
}
