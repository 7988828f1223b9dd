//! In which order Krein's signatures stand along the unit circle. From one orbit to the next the order changes only where multipliers of
//! opposite signatures have met, or one pair has met itself at ±1: between two stable orbits of different order there is a stripe, however
//! thin. Multipliers off the circle have their place in the order, too, so that a thin stable band between two stripes shows as well; their
//! place also changes where they drift past a pair on the circle, which is no event.
//!
//! Where reversal of time keeps the orbit, N = ½(M + M⁻¹) and the form G tell them (`reference::half_sum`).
//! Reflections of the lattice that keep the orbit split N and G into vectors that they leave as they are and vectors whose sign they
//! change: multipliers of different parts pass each other.

use std::hash::{DefaultHasher, Hash, Hasher};

use faer::MatRef;
use nalgebra::{DMatrix, DVector, Schur};
use vibrochain_breather::{Impact, Orbit};
use vibrochain_lattice::Ends;

use crate::error::FloquetError;
use crate::reference::half_sum::HalfSum;
use crate::reference::monodromy::full_monodromy;

/// Relative difference up to which two impulses are those of mirror images. Rounding stays far below it; orbits that lack the symmetry
/// come as near only within the square of it from where they branch off.
const ALIKE: f64 = 1e-9;

/// Part of an eigenvector's length up to which a mass that is hit does not move: rounding leaves 1e-13 of it.
const NODE: f64 = 1e-9;

/// QR sweeps per eigenvalue after which nalgebra is told to give up; a handful is usual.
const SWEEPS: usize = 60;

/// Distance from the unit circle up to which a multiplier of a matrix is on it: a double one is known to the root of rounding.
const ON_CIRCLE: f64 = 1e-6;

/// The order of the signatures of all multipliers along the upper half of the unit circle: a number that is the same for equal orders.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct SignatureOrder {
    all: u64,
    /// Of those on the circle alone, wherever others are.
    circle: u64,
}

impl SignatureOrder {
    /// Of the signs of each part, 0 off the circle.
    fn of(parts: &mut [Vec<i8>]) -> Self {
        let number = |parts: &[Vec<i8>]| {
            let mut hasher = DefaultHasher::new();
            parts.hash(&mut hasher);
            hasher.finish()
        };
        let all = number(parts);
        parts.iter_mut().for_each(|signs| signs.retain(|sign| *sign != 0));
        Self { all, circle: number(parts) }
    }

    /// Whether the signatures on the circle are in the same order. They stay so where a pair drifts past one that is off the circle.
    pub(crate) fn is_alike_on_circle(self, other: Self) -> bool {
        self.circle == other.circle
    }
}

/// Finds orders; keeps what the next orbit of the same lattice needs again.
#[derive(Debug, Clone, Default)]
pub struct OrderFinder {
    half_sum: HalfSum,
}

impl OrderFinder {
    /// The most masses: on larger lattices the matrix of one order takes more time than computing the cells that it saves.
    pub const MOST_MASSES: usize = 200;

    /// The order of an orbit without losses; `None` where nothing couples the masses, and their multipliers are equal. O(M³).
    ///
    /// # Errors
    /// [`FloquetError::TooLarge`] beyond [`Self::MOST_MASSES`], [`FloquetError::Grazing`], [`FloquetError::NotConverged`].
    ///
    /// ```
    /// use vibrochain_breather::{Finder, Found, Wanted};
    /// use vibrochain_floquet::OrderFinder;
    /// use vibrochain_lattice::{Chain, Model};
    /// let (mut finder, mut found, mut orders) = (Finder::new(6), Found::default(), OrderFinder::default());
    /// let mut order = |omega: f64| -> Result<_, Box<dyn std::error::Error>> {
    ///     let model = Model::conservative(Chain::new(6, 0.2, 0.1)?, omega, 0.2)?;
    ///     finder.find_word(&model, &"0+1+,0-1-".parse()?, Wanted::All, &mut found)?;
    ///     Ok(orders.of(&found.orbits[0])?)
    /// };
    /// // The breather is unstable between 1.36977 and 1.37226.
    /// assert_eq!(order(1.36)?, order(1.365)?);
    /// assert_ne!(order(1.365)?, order(1.38)?);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn of(&mut self, orbit: &Orbit) -> Result<Option<SignatureOrder>, FloquetError> {
        let chain = orbit.model().chain();
        if chain.sites() > Self::MOST_MASSES {
            return Err(FloquetError::TooLarge { dimension: chain.sites(), limit: Self::MOST_MASSES });
        }
        if chain.is_uncoupled() {
            return Ok(None);
        }
        if !orbit.is_reversible() {
            return Ok(Some(SignatureOrder::of(&mut [by_monodromy(orbit)?])));
        }
        self.half_sum.set(orbit)?;
        // The orbit itself swings in the first part: the trivial pair is there.
        let parts = self.half_sum.parts(&mirrors(orbit)).into_iter().enumerate().map(|(i, part)| part.signs(i == 0));
        Ok(Some(SignatureOrder::of(&mut parts.collect::<Result<Vec<_>, _>>()?)))
    }
}

/// N and G on sums or differences of masses that are mirror images.
#[derive(Debug)]
struct Part {
    matrix: DMatrix<f64>,
    form: DMatrix<f64>,
    /// Coordinates of masses that are hit.
    hit: Vec<usize>,
}

impl HalfSum {
    /// What impacts reach of it, by the signs that vectors take under the reflections: those that keep all signs first.
    fn parts(&self, mirrors: &[Vec<usize>]) -> Vec<Part> {
        let signs = 0..1_u32 << mirrors.len();
        signs.map(|signs| self.part(mirrors, signs)).filter(|part| !part.hit.is_empty()).collect()
    }

    /// The part of the vectors whose sign the reflections in `signs` change.
    fn part(&self, mirrors: &[Vec<usize>], signs: u32) -> Part {
        let sites = self.matrix.nrows();
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
        let basis: Vec<_> = firsts.filter_map(vector).collect();
        // What a vector of the part has at the first mass of another, it has of that as a whole.
        let of = |whole: &DMatrix<f64>| {
            DMatrix::from_fn(basis.len(), basis.len(), |i, j| {
                let (n, share) = basis[i][0];
                basis[j].iter().map(|(m, part)| whole[(n, *m)] * part).sum::<f64>() / share
            })
        };
        let is_hit = |vector: &[(usize, f64)]| vector.iter().any(|(n, _)| self.hit.contains(n));
        let hit = (0..basis.len()).filter(|i| is_hit(&basis[*i])).collect();
        Part { matrix: of(&self.matrix), form: of(&self.form), hit }
    }
}

impl Part {
    /// Signs of the form by falling Re ν, 0 off the circle: of multipliers that the impacts reach, the trivial pair left out if it is here.
    fn signs(self, trivial: bool) -> Result<Vec<i8>, FloquetError> {
        let size = self.matrix.nrows();
        let failed = FloquetError::NotConverged { dimension: size };
        // The iteration never ends on what is not finite.
        if !self.matrix.norm().is_finite() {
            return Err(failed);
        }
        let schur = Schur::try_new(self.matrix, f64::EPSILON, SWEEPS * size).ok_or(failed)?;
        let (base, triangle) = schur.unpack();
        let alone =
            |i: usize| (i == 0 || triangle[(i, i - 1)] == 0.0) && (i + 1 == size || triangle[(i + 1, i)] == 0.0);
        let nearest = |a: &usize, b: &usize| {
            let [a, b] = [a, b].map(|i| (triangle[(*i, *i)] - 1.0).abs());
            a.total_cmp(&b)
        };
        let trivial = if trivial { (0..size).filter(|i| alone(*i)).min_by(nearest) } else { None };
        let mut found = Vec::with_capacity(size);
        for i in (0..size).filter(|i| Some(*i) != trivial) {
            let nu = triangle[(i, i)];
            if !alone(i) || nu.abs() >= 1.0 {
                found.push((nu, 0));
                continue;
            }
            let shape = &base * eigenvector(&triangle, i);
            let most = NODE * shape.norm();
            if self.hit.iter().any(|n| shape[*n].abs() > most) {
                let form = shape.dot(&(&self.form * &shape));
                found.push((nu, if form > 0.0 { 1 } else { -1 }));
            }
        }
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        Ok(found.into_iter().map(|(_, sign)| sign).collect())
    }
}

/// Eigenvector i of an upper triangular matrix, of which some neighbours on the diagonal belong together; i is alone.
fn eigenvector(triangle: &DMatrix<f64>, i: usize) -> DVector<f64> {
    let value = triangle[(i, i)];
    // Equal eigenvalues are told apart by rounding.
    let least = f64::EPSILON * triangle.norm();
    let mut vector = DVector::zeros(triangle.nrows());
    vector[i] = 1.0;
    let mut row = i;
    while row > 0 {
        row -= 1;
        let sum = |row: usize, from: usize, vector: &DVector<f64>| -> f64 {
            (from..=i).map(|column| triangle[(row, column)] * vector[column]).sum()
        };
        let gap = value - triangle[(row, row)];
        if row == 0 || triangle[(row, row - 1)] == 0.0 {
            vector[row] = sum(row, row + 1, &vector) / if gap.abs() > least { gap } else { least };
            continue;
        }
        let above = row - 1;
        let (one, other) = (sum(above, row + 1, &vector), sum(row, row + 1, &vector));
        let (b, c) = (triangle[(above, row)], triangle[(row, above)]);
        let first = value - triangle[(above, above)];
        let determinant = first * gap - b * c;
        vector[above] = (gap * one + b * other) / determinant;
        vector[row] = (first * other + c * one) / determinant;
        row = above;
    }
    vector
}

/// The same order where no instants of time reversal are known: from the eigenvectors of the monodromy matrix.
fn by_monodromy(orbit: &Orbit) -> Result<Vec<i8>, FloquetError> {
    let matrix = full_monodromy(orbit)?;
    let (size, half) = (matrix.nrows(), matrix.nrows() / 2);
    let failed = || FloquetError::NotConverged { dimension: size };
    if !matrix.norm().is_finite() {
        return Err(failed());
    }
    let eigen = MatRef::from_column_major_slice(matrix.as_slice(), size, size).eigen().map_err(|_| failed())?;
    let (values, vectors) = (eigen.S().column_vector(), eigen.U());
    let mut order: Vec<usize> = (0..size).collect();
    if orbit.model().is_conservative() {
        // The trivial pair, which rounding splits.
        let from_one = |i: usize| (values[i].re - 1.0).hypot(values[i].im);
        order.sort_by(|&i, &j| from_one(i).total_cmp(&from_one(j)));
        order.drain(..2);
    }
    let hit = orbit.hit_sites();
    let excess = |i: usize| values[i].re.hypot(values[i].im) - 1.0;
    order.retain(|&i| {
        let (u, v) = (|n: usize| vectors[(n, i)], |n: usize| vectors[(n + half, i)]);
        let moves = |n: usize| u(n).re.hypot(u(n).im) + v(n).re.hypot(v(n).im) > NODE;
        values[i].im >= 0.0 && excess(i) >= -ON_CIRCLE && hit.iter().any(|&n| moves(n))
    });
    order.sort_by(|&i, &j| values[j].re.total_cmp(&values[i].re));
    let sign = |&i: &usize| {
        let of_mass = |n: usize| {
            let (u, v) = (vectors[(n, i)], vectors[(n + half, i)]);
            u.re * v.im - u.im * v.re
        };
        match (0..half).map(of_mass).sum::<f64>() {
            _ if excess(i) > ON_CIRCLE || values[i].im == 0.0 => 0,
            form if form > 0.0 => 1,
            _ => -1,
        }
    };
    Ok(order.iter().map(sign).collect())
}

/// Where reflections of the lattice that keep the orbit, instant by instant, take each mass: some that commute, none a product of others.
fn mirrors(orbit: &Orbit) -> Vec<Vec<usize>> {
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
    found
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
