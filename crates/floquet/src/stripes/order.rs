//! In which order Krein's signatures stand along the unit circle. From one orbit to the next the order changes only where multipliers of
//! opposite signatures have met, or one pair has met itself at ±1: between two stable orbits of different order there is a stripe, however
//! thin. Multipliers off the circle have their place in the order, too, so that a thin stable band between two stripes shows as well; their
//! place also changes where they drift past a pair on the circle, which is no event.
//!
//! Where reversal of time keeps the orbit, N = ½(M + M⁻¹) and the form G tell them (`reference::half_sum`), in parts that reflections make.

use std::hash::{DefaultHasher, Hash, Hasher};

use faer::MatRef;
use nalgebra::{DMatrix, DVector, Schur};
use vibrochain_breather::Orbit;
use vibrochain_lattice::Spectrum;

use crate::error::FloquetError;
use crate::reference::half_sum::{HalfSum, Part};
use crate::reference::mirrors::Mirrors;
use crate::reference::monodromy::full_monodromy;

/// Part of an eigenvector's length up to which a mass that is hit does not move: rounding leaves 1e-13 of it.
const NODE: f64 = 1e-9;

/// QR sweeps per eigenvalue after which nalgebra is told to give up; a handful is usual.
const SWEEPS: usize = 60;

/// Distance from the unit circle up to which a multiplier of a matrix is on it: a double one is known to the root of rounding.
const ON_CIRCLE: f64 = 1e-6;

/// The order of the signatures of all multipliers along the upper half of the unit circle: a number that is the same for equal orders.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct SignatureOrder(u64);

impl SignatureOrder {
    /// Of the signs of each part, 0 off the circle.
    fn of(parts: &[Vec<i8>]) -> Self {
        let mut hasher = DefaultHasher::new();
        parts.hash(&mut hasher);
        Self(hasher.finish())
    }
}

/// Finds orders; keeps what the next orbit of the same lattice needs again.
#[derive(Debug, Clone, Default)]
pub struct OrderFinder {
    /// Of the last orbit's chain.
    spectrum: Option<Spectrum>,
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
    /// use vibrochain_breather::{Finder, OrbitList, Scope};
    /// use vibrochain_floquet::OrderFinder;
    /// use vibrochain_lattice::{Chain, Model};
    /// let (mut finder, mut found, mut orders) = (Finder::new(6), OrbitList::default(), OrderFinder::default());
    /// let mut order = |omega: f64| -> Result<_, Box<dyn std::error::Error>> {
    ///     let model = Model::conservative(Chain::new(6, 0.2, 0.1)?, omega, 0.2)?;
    ///     finder.find_word(&model, &"0+1+,0-1-".parse()?, Scope::All, &mut found)?;
    ///     Ok(orders.of(&found.orbits[0])?)
    /// };
    /// // The breather is unstable between 1.36977 and 1.37226.
    /// assert_eq!(order(1.36)?, order(1.365)?);
    /// assert_ne!(order(1.365)?, order(1.38)?);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn of(&mut self, orbit: &Orbit) -> Result<Option<SignatureOrder>, FloquetError> {
        let orbit = orbit.lattice()?;
        let chain = orbit.model().chain();
        if chain.sites() > Self::MOST_MASSES {
            return Err(FloquetError::TooLarge { dimension: chain.sites(), limit: Self::MOST_MASSES });
        }
        if chain.is_uncoupled() {
            return Ok(None);
        }
        if !orbit.is_reversible() {
            return Ok(Some(SignatureOrder::of(&[by_monodromy(&orbit)?])));
        }
        let half_sum = HalfSum::new(orbit, &mut self.spectrum)?;
        let mut parts = Vec::new();
        for (i, basis) in Mirrors::of(orbit).bases(chain.sites()).enumerate() {
            let hit = basis.hit(&orbit);
            if !hit.is_empty() {
                // The orbit itself swings in the first part: the trivial pair is there.
                parts.push(signs(half_sum.on(&basis), &hit, i == 0)?);
            }
        }
        Ok(Some(SignatureOrder::of(&parts)))
    }
}

/// Signs of the form by falling Re ν, 0 off the circle, of N and G in a part: of multipliers that the impacts reach, the trivial pair left
/// out if it is here. `hit` are the coordinates of masses that are hit.
fn signs(Part { matrix, form }: Part, hit: &[usize], trivial: bool) -> Result<Vec<i8>, FloquetError> {
    let size = matrix.nrows();
    let failed = FloquetError::NotConverged { dimension: size };
    // The iteration never ends on what is not finite.
    if !matrix.norm().is_finite() {
        return Err(failed);
    }
    let schur = Schur::try_new(matrix, f64::EPSILON, SWEEPS * size).ok_or(failed)?;
    let (base, triangle) = schur.unpack();
    let alone = |i: usize| (i == 0 || triangle[(i, i - 1)] == 0.0) && (i + 1 == size || triangle[(i + 1, i)] == 0.0);
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
        if hit.iter().any(|n| shape[*n].abs() > most) {
            found.push((nu, if shape.dot(&(&form * &shape)) > 0.0 { 1 } else { -1 }));
        }
    }
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    Ok(found.into_iter().map(|(_, sign)| sign).collect())
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
    if orbit.is_conservative() {
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

#[cfg(test)]
mod tests {
    use super::*;
    use vibrochain_testkit::Random;

    /// (T − t_ii) v = 0 beside pairs of conjugates on the diagonal, too.
    #[test]
    fn vectors_of_a_triangle_with_blocks_are_eigenvectors() {
        let mut random = Random(7);
        let mut blocks = 0;
        for _ in 0..200 {
            let size = 2 + random.below(7);
            let mut triangle =
                DMatrix::from_fn(size, size, |i, j| if j >= i { random.between(-2.0, 2.0) } else { 0.0 });
            let (mut alone, mut i) = (Vec::new(), 0);
            while i < size {
                if i + 1 < size && random.chance(0.4) {
                    let below = -random.between(0.5, 2.0) * triangle[(i, i + 1)].signum();
                    triangle[(i + 1, i)] = below;
                    triangle[(i + 1, i + 1)] = triangle[(i, i)];
                    (i, blocks) = (i + 2, blocks + 1);
                } else {
                    alone.push(i);
                    i += 1;
                }
            }
            for i in alone {
                let vector = eigenvector(&triangle, i);
                let off = (&triangle * &vector - triangle[(i, i)] * &vector).norm();
                assert!(off < 1e-11 * triangle.norm() * vector.norm(), "{off}: {triangle}{vector}");
            }
        }
        assert!(blocks > 100, "{blocks}");
    }
}
