//! One impact a period with losses: how many multipliers are outside the unit circle, exactly, without computing one.
//!
//! K̂ of one impact (see [`super::impact_matrix`]) is ½[[q + ζσ, g], [2κ' − h, q + ζσ]], ζ = ½(z − 1/z), so that the quotient
//! det(z−M)/det(z−R) of the characteristic polynomials with and without impact is
//!
//! ```text
//! f(z) = ¼(1+e)² { [q + ζσ]² + g(h − 2κ') },   q = (1−e)/(1+e),
//! σ = Σ b²/(ν−d),   g = Σ 2b²xc/(ν−d),   h = Σ 2b²yc/(ν−d),   ν = ½(z + 1/z).
//! ```
//!
//! On the circle, z = e^{iθ}: ζ = i sin θ and Im f ∝ 2q sin θ·σ(cos θ). On the upper half σ falls from pole to pole as ν
//! rises, so that Im f passes each zero of σ from − to + as θ rises, and each pole from + to − on the far side, clockwise:
//! the poles are simple, f ≈ ρ/(z−p). Hence f turns clockwise once for every zero of σ where Re f < 0 and not at all where
//! Re f > 0; the same on the lower half; and likewise at z = ±1, where σ(1) > 0 > σ(−1) makes Im f rise, too. f(∞) = 1 and
//! f has no pole outside, so clockwise turns are zeros outside:
//!
//! ```text
//! N = 2·#{σ(ν) = 0 : q² + g(h − 2κ') < 0} + [f(1) < 0] + [f(−1) < 0].
//! ```
//!
//! q² + g(h − 2κ') < 0 at a zero of σ means a complex pair, f(±1) < 0 a real multiplier beyond ±1.

use nalgebra::Complex;
use vibrochain_breather::Prepared;

use super::error::SecularError;
use super::evaluate::Local;
use super::gap::root;
use super::leaf::Leaf;
use super::modes::{Mode, Modes};
use crate::saltation::Saltation;
use vibrochain_breather::lanes::{Lane, fill};

/// How many multipliers are outside the unit circle, and where they left it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct OutsideCount {
    /// Complex pairs.
    pub pairs: usize,
    /// A real multiplier beyond +1 (an odd number of them; pairs of real ones count among the pairs).
    pub beyond_plus_one: bool,
    /// A real multiplier beyond −1.
    pub beyond_minus_one: bool,
}

impl OutsideCount {
    /// The number of multipliers.
    pub fn total(&self) -> usize {
        2 * self.pairs + usize::from(self.beyond_plus_one) + usize::from(self.beyond_minus_one)
    }
}

/// Work space for counting.
///
/// ```
/// use vibrochain_breather::{Family, Finder, Found};
/// use vibrochain_floquet::OutsideCounter;
/// use vibrochain_lattice::{Chain, Model};
/// let model = Model::forced(Chain::new(21, 0.2, 0.1)?, 0.92, 0.4, 0.1, 0.9)?;
/// let (mut finder, mut found) = (Finder::new(21), Found::default());
/// finder.find(&model, Family::SingleSided, &mut found)?;
/// let mut counter = OutsideCounter::default();
/// let mut counts = Vec::new();
/// for orbit in &found.orbits {
///     counts.extend(counter.count(finder.prepared(orbit)?));
/// }
/// // One branch has a multiplier beyond +1, the other complex pairs.
/// assert!(counts.iter().any(|count| count.beyond_plus_one));
/// assert!(counts.iter().any(|count| count.pairs > 0 && !count.beyond_plus_one));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct OutsideCounter {
    modes: Modes,
    /// d, b², 2b²xc, 2b²yc, error of d, relative error of b²
    table: Vec<[f64; 6]>,
    poles: Vec<Lane>,
    /// σ
    sigma: Leaf<2>,
    distances: Vec<Lane>,
}

impl OutsideCounter {
    /// Counts.
    ///
    /// # Errors
    /// [`SecularError::NotReversible`] unless the orbit has one impact a period and e < 1; [`SecularError::Tangency`] if rounding decides:
    /// a multiplier is on the circle to within it.
    pub fn count(&mut self, prepared: Prepared<'_>) -> Result<OutsideCount, SecularError> {
        let orbit = prepared.orbit();
        let q = orbit.model().loss();
        let [impact] = orbit.impacts() else { return Err(SecularError::NotReversible) };
        if q <= 0.0 {
            return Err(SecularError::NotReversible);
        }
        let twice_kappa = 2.0 * Saltation::reduced(impact, orbit.model().restitution());
        self.modes.set_felt(prepared);
        let count = self.modes.count();
        self.table.clear();
        let (mut plus, mut minus): ([f64; 4], [f64; 4]) = Default::default();
        for (k, mode) in self.modes.list().iter().enumerate() {
            let &Mode { weight: w, cos: c, sin: s, sin_over: x, sin_times: y, shift, .. } = mode;
            let blur = self.modes.blur(k);
            let (g, h) = (2.0 * w * x * c, 2.0 * w * y * c);
            self.table.push([(c - s) * (c + s), w, g, h, f64::EPSILON * shift, blur]);
            // 1 − d = 2s², −1 − d = −2c².
            for (sums, distance) in [(&mut plus, 2.0 * s * s), (&mut minus, -2.0 * c * c)] {
                let slack = f64::EPSILON * (8.0 + 2.0 * shift / distance.abs()) + blur;
                sums[0] += g / distance;
                sums[1] += h / distance;
                sums[2] += (g / distance).abs() * slack;
                sums[3] += (h / distance).abs() * slack;
            }
        }
        let negative = |[g, h, g_error, h_error]: [f64; 4]| {
            let value = q * q + g * (h - twice_kappa);
            let size = h.abs() + twice_kappa.abs();
            let error = g_error * size + g.abs() * (h_error + 8.0 * f64::EPSILON * size) + f64::EPSILON * q * q;
            // Not a number is a doubt, too.
            if value.abs() > error { Ok(value < 0.0) } else { Err(SecularError::Tangency) }
        };
        let mut result =
            OutsideCount { pairs: 0, beyond_plus_one: negative(plus)?, beyond_minus_one: negative(minus)? };
        if let [first, .., last] = self.table.as_slice()
            && first[0] > last[0]
        {
            self.table.reverse();
        }
        self.table.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
        fill(&mut self.poles, self.table.iter().map(|row| row[0]), 1e100);
        let [weights, errors] = &mut self.sigma.charges;
        fill(weights, self.table.iter().map(|row| row[1]), 0.0);
        fill(errors, self.table.iter().map(|row| row[1] * row[5]), 0.0);
        fill(&mut self.sigma.shifts, self.table.iter().map(|row| row[4]), 0.0);
        for gap in 0..count.saturating_sub(1) {
            let (left, right) = (self.table[gap][0], self.table[gap + 1][0]);
            let width = right - left;
            if width <= 0.0 {
                // Coincident modes: one combination of them never feels the impact, its multiplier is on the circle.
                continue;
            }
            // From the nearer pole, whose side the sign in the middle tells: σ falls.
            from(&self.poles, left, &mut self.distances);
            let middle = local(&self.sigma, &self.distances).value(0.5 * width);
            let (low, high, other) = if middle < 0.0 { (0.0, 0.5 * width, width) } else { (-0.5 * width, 0.0, -width) };
            if middle >= 0.0 {
                from(&self.poles, right, &mut self.distances);
            }
            let sums = local(&self.sigma, &self.distances);
            let t = root(sums, (low, high), false, |t| 1.0 / t - 1.0 / (other - t));
            let moved = sums.noise(Complex::new(t, 0.0)) / sums.jet(t).slope.abs();
            let origin = if middle < 0.0 { left } else { right };
            let mut at = [0.0; 4];
            for row in &self.table {
                let distance = (origin - row[0]) + t;
                let slack = f64::EPSILON * 8.0 + row[5] + (moved + row[4]) / distance.abs();
                at[0] += row[2] / distance;
                at[1] += row[3] / distance;
                at[2] += (row[2] / distance).abs() * slack;
                at[3] += (row[3] / distance).abs() * slack;
            }
            result.pairs += usize::from(negative(at)?);
        }
        Ok(result)
    }
}

fn local<'a>(leaf: &'a Leaf<2>, distances: &'a [Lane]) -> Local<'a> {
    Local { leaf, distances, origin: None }
}

/// Distances of all poles from an origin.
fn from(poles: &[Lane], origin: f64, out: &mut Vec<Lane>) {
    out.clear();
    out.extend(poles.iter().map(|pole| pole.map(|d| origin - d)));
}
