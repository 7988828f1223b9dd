//! Entries of the queue of contacts: the earliest comes out first.

use std::cmp::Ordering;

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

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BinaryHeap;

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
