//! Reflections of a lattice that keep an orbit: they split perturbations into vectors that they leave as they are and vectors whose sign
//! they change, and multipliers of different parts pass each other.

use vibrochain_breather::{Impact, LatticeOrbit, Orbit};
use vibrochain_lattice::Ends;

/// Relative difference up to which two impulses are those of mirror images. Rounding stays far below it; orbits that lack the symmetry
/// come as near only within the square of it from where they branch off.
const ALIKE: f64 = 1e-9;

/// Where reflections that keep an orbit, instant by instant, take each mass: some that commute, none a product of others.
#[derive(Debug, Default)]
pub(crate) struct Mirrors(Vec<Vec<usize>>);

/// Masses that move together, mirror images with their shares, for each vector of an orthonormal basis.
#[derive(Debug)]
pub(crate) struct Basis {
    pub(crate) vectors: Vec<Vec<(usize, f64)>>,
}

impl Mirrors {
    /// Those of an orbit.
    pub(crate) fn of(orbit: LatticeOrbit<'_>) -> Self {
        let (chain, impacts) = (orbit.model().chain(), orbit.impacts());
        let layout = chain.layout();
        let near = |a: f64, b: f64| (a - b).abs() <= ALIKE * a.abs().max(b.abs());
        let mut found: Vec<Vec<usize>> = Vec::new();
        for across in reflections(chain.layers(), chain.layer_ends()) {
            for along in reflections(chain.length(), chain.ends()) {
                let image = |index: usize| {
                    let (site, layer) = layout.place(index);
                    turned(site, along, chain.length()) + turned(layer, across, chain.layers()) * chain.length()
                };
                let keeps = impacts.iter().all(|one| {
                    let same = |other: &Impact| {
                        other.site == image(one.site)
                            && other.barrier == one.barrier
                            && other.time == one.time
                            && near(other.impulse, one.impulse)
                    };
                    impacts.iter().any(same)
                });
                if !keeps {
                    continue;
                }
                let new: Vec<usize> = (0..chain.sites()).map(image).collect();
                let commutes = |known: &Vec<usize>| (0..new.len()).all(|n| known[new[n]] == new[known[n]]);
                let is_product = |product: u32| {
                    let known = found.iter().enumerate().filter(|(i, _)| product >> i & 1 == 1);
                    let turned = |n: usize| known.clone().fold(n, |n, (_, mirror)| mirror[n]);
                    (0..new.len()).all(|n| turned(n) == new[n])
                };
                if found.iter().all(commutes) && !(0..1_u32 << found.len()).any(is_product) {
                    found.push(new);
                }
            }
        }
        Self(found)
    }

    /// Bases of all parts of a lattice of so many masses, by the signs that vectors take: those that keep all signs, among them the orbit
    /// itself, first.
    pub(crate) fn bases(&self, sites: usize) -> impl Iterator<Item = Basis> + '_ {
        (0..1_u32 << self.0.len()).map(move |signs| self.basis(sites, signs))
    }

    /// Basis of the vectors whose sign the reflections in `signs`, bit by bit, change and no others.
    pub(crate) fn basis(&self, sites: usize, signs: u32) -> Basis {
        let mirrors = &self.0;
        // Of each mass its images, all products of reflections, with their signs.
        let images = |n: usize| {
            (0..1_u32 << mirrors.len()).map(move |product| {
                let turns = (0..mirrors.len()).filter(move |mirror| product >> mirror & 1 == 1);
                let sign = if (product & signs).count_ones().is_multiple_of(2) { 1.0 } else { -1.0 };
                (turns.fold(n, |n, mirror| mirrors[mirror][n]), sign)
            })
        };
        let vector = |n: usize| {
            let mut vector: Vec<(usize, f64)> = Vec::with_capacity(1 << mirrors.len());
            for (image, sign) in images(n) {
                match vector.iter_mut().find(|(known, _)| *known == image) {
                    Some((_, part)) => *part += sign,
                    None => vector.push((image, sign)),
                }
            }
            let norm = vector.iter().map(|(_, part)| part * part).sum::<f64>().sqrt();
            vector.iter_mut().for_each(|(_, part)| *part /= norm);
            (norm > 0.0).then_some(vector)
        };
        let firsts = (0..sites).filter(|&n| images(n).all(|(image, _)| image >= n));
        Basis { vectors: firsts.filter_map(vector).collect() }
    }
}

impl Basis {
    /// The coordinates in which masses take part that an orbit hits.
    pub(crate) fn hit(&self, orbit: &Orbit) -> Vec<usize> {
        let hit = orbit.hit_sites();
        (0..self.vectors.len()).filter(|i| self.vectors[*i].iter().any(|(n, _)| hit.contains(n))).collect()
    }
}

fn turned(n: usize, centre: Option<usize>, count: usize) -> usize {
    centre.map_or(n, |centre| (centre + count - n) % count)
}

/// Reflections n → c − n of a row by c, and none.
fn reflections(count: usize, ends: Ends) -> impl Iterator<Item = Option<usize>> {
    let centres = match ends {
        Ends::Closed => 0..count,
        Ends::Free | Ends::Fixed => count - 1..count,
    };
    std::iter::once(None).chain(centres.filter(move |_| count > 1).map(Some))
}
