//! Eigenvectors from the impacts' equations: what a perturbation of known multiplier z looks like, at the cost of a few passes over the
//! modes.
//!
//! With J(z)y = 0 mode k is, just before the first impact, what all past impacts made of it, R_k(z−R_k)⁻¹C_k y. Next to a pole that is the
//! border's own unknown.

use nalgebra::Complex;
use vibrochain_breather::ContactOrbit;
use vibrochain_lattice::{BlochMode, Chain, Shapes};

use super::function::SpectralFunction;
use super::null::Null;
use crate::zeros::SecularError;

type C = Complex<f64>;

/// What a multiplier may leave of J, as a part of its largest entry.
pub(super) const MOST_DEFECT: f64 = 1e-4;

/// The perturbation of a multiplier in normalised even modes (u_site = Σ b_k x_k), just before the first impact.
#[derive(Debug, Clone, PartialEq)]
pub struct ModalShape {
    /// μ
    pub multiplier: Complex<f64>,
    /// x_k, k = 0 … ⌊M/2⌋, scaled so that Σ|x_k|² + |ẋ_k|²/ω² = 1.
    pub displacement: Vec<Complex<f64>>,
    /// ẋ_k
    pub velocity: Vec<Complex<f64>>,
}

impl ModalShape {
    /// The shape of multiplier `multiplier` (an eigenvalue on the even subspace, to rounding) of an orbit whose impacts are
    /// all of one contact, where nothing damps the modes.
    ///
    /// # Errors
    /// [`SecularError::NotReversible`] for impacts of several contacts; [`SecularError::Certificate`] if the number is no multiplier: what
    /// it leaves of the impacts' equations is told.
    ///
    /// ```
    /// use vibrochain_breather::{Family, Finder, OrbitList};
    /// use vibrochain_floquet::{Complex, ModalShape, Secular};
    /// use vibrochain_lattice::{Chain, Model};
    /// let model = Model::conservative(Chain::new(21, 0.2, 0.1)?, 0.8, 0.4)?;
    /// let (mut finder, mut found, mut secular) = (Finder::new(21), OrbitList::default(), Secular::default());
    /// finder.find(&model, Family::SingleSided, &mut found)?;
    /// secular.replace(finder.prepared(&found.orbits[0])?)?;
    /// let leading = secular.verdict()?.leading.unwrap();
    /// let shape = ModalShape::new(&*finder.at_contacts(&found.orbits[0])?, leading)?;
    /// // The instability sits on the breather.
    /// let (displacement, _) = shape.at_sites(21, 0);
    /// assert!(displacement[0].norm() > 2.0 * displacement[10].norm());
    /// assert!(ModalShape::new(&*finder.at_contacts(&found.orbits[0])?, Complex::new(2.0, 0.0)).is_err());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(orbit: &ContactOrbit, multiplier: C) -> Result<Self, SecularError> {
        let (equations, _) = orbit.bloch_equations();
        if equations.kernel().contacts() > 1 {
            return Err(SecularError::NotReversible);
        }
        let function = SpectralFunction::new(&equations, false);
        let null = function.null(multiplier, 1).ok_or(SecularError::Incomplete { found: 0, wanted: 1 })?;
        // Not a number is no multiplier, either.
        if null.defect.is_nan() || null.defect > MOST_DEFECT {
            return Err(SecularError::Certificate { defect: null.defect, allowed: MOST_DEFECT });
        }
        let modes = equations.kernel().modes();
        // The contact moves with its modes, whatever the sign of their shapes.
        let state = |(k, mode): (usize, &BlochMode)| {
            let [x, y] = function.state(multiplier, &null, 0, k);
            let sign = 1f64.copysign(equations.kernel().row(k, 0)[0]);
            (x * sign, y * sign * mode.rate)
        };
        let (mut displacement, mut velocity): (Vec<C>, Vec<C>) = modes.iter().enumerate().map(state).unzip();
        let omega = equations.omega();
        let squares = |list: &[C]| list.iter().map(|z| z.norm_sqr()).sum::<f64>();
        let norm = squares(&displacement) + squares(&velocity) / (omega * omega);
        let scale = if norm > 0.0 { norm.sqrt().recip() } else { 1.0 };
        displacement.iter_mut().chain(&mut velocity).for_each(|z| *z *= scale);
        Ok(Self { multiplier, displacement, velocity })
    }

    /// Displacements and velocities of the M masses of a ring whose site `home` is hit, in O(M log M).
    pub fn at_sites(&self, sites: usize, home: usize) -> (Vec<Complex<f64>>, Vec<Complex<f64>>) {
        let m = sites as f64;
        let amplitude = |k: usize| (if k == 0 || 2 * k == sites { 1.0 / m } else { 2.0 / m }).sqrt();
        let mut shapes = Shapes::new(&Chain::alone(sites));
        let mut at = |modes: &[C]| {
            let mut values = vec![C::default(); sites.max(1)];
            shapes.add_all(home, modes.iter().enumerate().map(|(k, x)| x * amplitude(k)), &mut values);
            values
        };
        (at(&self.displacement), at(&self.velocity))
    }
}

impl SpectralFunction<'_> {
    /// Both coordinates of mode `k` just before the first impact, of the perturbation whose null vector is this column.
    pub(super) fn state(&self, z: C, null: &Null, column: usize, k: usize) -> [C; 2] {
        let (mode, size) = (&self.equations.kernel().modes()[k], self.equations.size());
        let coordinates = mode.coordinates;
        let y = null.right.column(column);
        let sum = |of: &dyn Fn([f64; 2]) -> [C; 2]| {
            let terms = self.equations.columns(k).iter().zip(y.iter()).map(|(column, y)| of(*column).map(|x| x * y));
            terms.fold([C::default(); 2], |[p, q], [u, v]| [p + u, q + v])
        };
        let border = |which: usize| {
            let place = null.near.iter().position(|pole| pole.mode == k && pole.which == which);
            place.map(|place| y[size + place])
        };
        let own = [border(0), border(1)];
        if own == [None; 2] {
            let past = coordinates.product(mode.period.complex(), coordinates.resolvent(mode.period, z));
            return sum(&|column| coordinates.given(past, column));
        }
        if coordinates.are_parabolic() {
            return own.map(Option::unwrap_or_default);
        }
        let given = sum(&|column| column.map(|x| C::new(x, 0.0)));
        let (zero, one) = (C::default(), C::new(1.0, 0.0));
        [0, 1].into_iter().zip(mode.poles()).fold([zero; 2], |[p, q], (which, pole)| {
            let far = || pole * coordinates.given_to_pole(which, given) / (z - pole);
            let amplitude = own[which].unwrap_or_else(far);
            let along = |unit: [C; 2]| coordinates.seen_of_pole(which, unit) * amplitude;
            [p + along([one, zero]), q + along([zero, one])]
        })
    }
}
