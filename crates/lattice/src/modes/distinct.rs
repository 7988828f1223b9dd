//! The masses that symmetry leaves distinct.

use crate::model::chain::Chain;
use crate::modes::row::Line;

/// The masses of a lattice that need watching: one half of a ring, where its motion is symmetric about a site, or all of them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct DistinctMasses {
    of: Option<([Line; 2], Option<usize>)>,
    sites: Vec<usize>,
    left: Vec<usize>,
    right: Vec<usize>,
    across: Vec<[usize; 2]>,
}

/// In place of a neighbour's: a wall.
const WALL: usize = usize::MAX;

impl DistinctMasses {
    /// Takes over the masses of `chain`, of which half are left on a ring where sites n and `mirror` − n move alike; allocates
    /// only if there are more of them.
    pub fn reset(&mut self, chain: &Chain, mirror: Option<usize>) {
        let mirror = mirror.filter(|_| chain.is_ring());
        if self.of == Some((chain.lines(), mirror)) {
            return;
        }
        self.of = Some((chain.lines(), mirror));
        let all = chain.sites();
        // The axis goes through the first mass, or beside it.
        let (first, beside) = mirror.map_or((0, 0), |mirror| (mirror.div_ceil(2), mirror % 2));
        let count = if mirror.is_some() { (all - beside) / 2 + 1 } else { all };
        // Symmetry folds a site beyond the half ring onto its mirror image.
        let fold = |n: usize| if mirror.is_some() && n >= count { all - beside - n } else { n };
        let neighbour = |n: usize, side: usize| match chain.neighbours(n)[side] {
            Some(n) => fold(n),
            None => WALL,
        };
        self.across.clear();
        if chain.layers() > 1 {
            self.across.extend((0..count).map(|n| [neighbour(n, 2), neighbour(n, 3)]));
        }
        for list in [&mut self.sites, &mut self.left, &mut self.right] {
            list.clear();
        }
        self.sites.extend((0..count).map(|n| (first + n) % all));
        self.left.extend((0..count).map(|n| neighbour(n, 0)));
        self.right.extend((0..count).map(|n| neighbour(n, 1)));
    }

    /// Their sites, neighbour by neighbour and layer by layer; the first is at the centre of symmetry.
    pub fn sites(&self) -> &[usize] {
        &self.sites
    }

    /// For each of them the place in [`DistinctMasses::sites`] of its left neighbour, or of that one's mirror image;
    /// beyond all of them for a wall.
    pub fn left(&self) -> &[usize] {
        &self.left
    }

    /// The same of its right neighbour.
    pub fn right(&self) -> &[usize] {
        &self.right
    }

    /// The same of the masses below and above; empty for one layer.
    pub fn across(&self) -> &[[usize; 2]] {
        &self.across
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::modes::row::Ends;

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
        distinct.reset(&chain(5), Some(6));
        assert_eq!(distinct.sites(), [3, 4, 0]);
        distinct.reset(&chain(5), None);
        assert_eq!((distinct.sites().len(), distinct.left()[0], distinct.right()[4]), (5, 4, 0));
        distinct.reset(&chain(5).with_ends(Ends::Fixed), Some(6));
        assert_eq!((distinct.sites()[0], distinct.left()[0], distinct.right()), (0, WALL, &[1, 2, 3, 4, WALL][..]));
        distinct.reset(&chain(2).with_ends(Ends::Free).with_layers(3, 0.1, Ends::Closed).unwrap(), None);
        assert_eq!((distinct.left(), distinct.right()), (&[0, 0, 2, 2, 4, 4][..], &[1, 1, 3, 3, 5, 5][..]));
        assert_eq!(distinct.across(), [[4, 2], [5, 3], [0, 4], [1, 5], [2, 0], [3, 1]]);
    }

    #[test]
    fn half_rings_beside_an_axis_are_folded_as_their_mirror_images_stand() {
        let mut distinct = DistinctMasses::default();
        for all in 1..9 {
            for mirror in 0..2 * all - 1 {
                let chain = Chain::new(all, 0.2, 0.1).unwrap();
                distinct.reset(&chain, Some(mirror));
                let image = |n: usize| (mirror + all - n) % all;
                let sites = distinct.sites();
                // Every mass is listed or its image is, once.
                for n in 0..all {
                    let listed = sites.iter().filter(|&&site| site == n || site == image(n)).count();
                    assert_eq!(listed, 1, "{all} {mirror} {n} {sites:?}");
                }
                for (side, list) in [distinct.left(), distinct.right()].into_iter().enumerate() {
                    for (&site, &place) in sites.iter().zip(list) {
                        let neighbour = chain.neighbours(site)[side].unwrap();
                        assert!([neighbour, image(neighbour)].contains(&sites[place]), "{all} {mirror} {site}");
                    }
                }
            }
        }
    }
}
