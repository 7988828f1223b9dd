//! The masses that symmetry leaves distinct.

use crate::params::Chain;

/// The masses of a ring that need watching: one half of it, where its motion is symmetric about a site, or all of it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct DistinctMasses {
    of: Option<(usize, Option<usize>)>,
    sites: Vec<usize>,
    left: Vec<usize>,
    right: Vec<usize>,
}

impl DistinctMasses {
    /// Takes over the masses of `chain`, of which symmetry about `home` leaves half; allocates only if there are more of them.
    pub fn reset(&mut self, chain: &Chain, home: Option<usize>) {
        let ring = chain.sites();
        if self.of == Some((ring, home)) {
            return;
        }
        self.of = Some((ring, home));
        let count = if home.is_some() { ring / 2 + 1 } else { ring };
        // Symmetry folds a site beyond the half ring onto its mirror image.
        let fold = |n: usize| if home.is_some() { n.min(ring - n) } else { n };
        for list in [&mut self.sites, &mut self.left, &mut self.right] {
            list.clear();
        }
        self.sites.extend((0..count).map(|n| (home.unwrap_or(0) + n) % ring));
        self.left.extend((0..count).map(|n| fold((n + ring - 1) % ring)));
        self.right.extend((0..count).map(|n| fold((n + 1) % ring)));
    }

    /// Their sites, neighbour by neighbour; the first is the centre of symmetry.
    pub fn sites(&self) -> &[usize] {
        &self.sites
    }

    /// For each of them the place in [`DistinctMasses::sites`] of its left neighbour, or of that one's mirror image.
    pub fn left(&self) -> &[usize] {
        &self.left
    }

    /// The same of its right neighbour.
    pub fn right(&self) -> &[usize] {
        &self.right
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_rings_fold_onto_themselves() {
        let chain = |sites| Chain::new(sites, 0.2, 0.1).unwrap();
        let mut distinct = DistinctMasses::default();
        for (ring, left, right) in [
            (1, vec![0], vec![0]),
            (2, vec![1, 0], vec![1, 0]),
            (5, vec![1, 0, 1], vec![1, 2, 2]),
            (6, vec![1, 0, 1, 2], vec![1, 2, 3, 2]),
        ] {
            distinct.reset(&chain(ring), Some(0));
            assert_eq!((distinct.left(), distinct.right()), (&left[..], &right[..]), "{ring}");
        }
        // As many masses, other neighbours.
        distinct.reset(&chain(7), Some(0));
        assert_eq!(distinct.right(), [1, 2, 3, 3]);
        distinct.reset(&chain(5), Some(3));
        assert_eq!(distinct.sites(), [3, 4, 0]);
        distinct.reset(&chain(5), None);
        assert_eq!((distinct.sites().len(), distinct.left()[0], distinct.right()[4]), (5, 4, 0));
    }
}
