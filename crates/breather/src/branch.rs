//! A branch: the curve that one orbit draws when one parameter is varied.
//!
//! With x the unknowns of the orbit's equations F (`equations`) and λ the parameter, the branch is the curve F(x, λ) = 0 in
//! z = (x, λ), each coordinate in its natural unit. From a point z₀ with unit tangent τ the curve is described by the
//! length σ along the tangent,
//!
//! ```text
//! F(z) = 0,     τ·(z − z₀) = σ ,
//! ```
//!
//! which stays regular where the branch turns back in λ (a fold: ∂F/∂x is singular, the bordered matrix is not). The
//! fold itself is F = 0 and det ∂F/∂x = 0.
//!
//! On a branch of symmetric orbits (double-sided, φ = T/2) asymmetric ones branch off where ∂F/∂x is singular in a direction
//! that breaks the symmetry. There the curve is followed among symmetric orbits alone ([`Reduction`]), so that it passes
//! through regularly, while the determinant of all equations tells of the pitchfork.

use smallvec::{SmallVec, smallvec};
use thiserror::Error;
use vibrochain_lattice::{Barrier, Model, Parameter, Resonance, Spectrum};

use crate::bordered::{Matrix, Vector, WIDTH, determinant, solve};
use crate::equations::{Layout, Terms};
use crate::error::BreatherError;
use crate::finder::Finder;
use crate::orbit::{Draft, Hit, Orbit, Source};
use crate::reduction::Reduction;

/// Newton steps at most for one point; five are usual.
const STEPS: usize = 12;

/// Newton steps from one smaller than this on that shrink no more are rounding, if the equations hold to this many times the
/// bound of their rounding. Where they do not, as next to a resonance, the orbit itself changes over so little.
const NOISE: f64 = 1e-7;
const ROUNDING: f64 = 8.0;

/// A point may be this part of the step away from where the tangent pointed; farther is another branch or too long a
/// step.
const BEND: f64 = 0.35;

/// A chord may differ from the mean of the tangents at its ends by this part of its length: that of an arc of a quarter of a
/// radian. One that leads to another branch does not fit the tangents.
const CHORD: f64 = 0.01;

/// Step of difference quotients in the parameter, relative: error and rounding balance. Newton's method needs no more
/// digits than that.
const DIFFERENCE: f64 = 1e-6;

/// Why a branch cannot be followed.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum BranchError {
    /// No orbit there: a parameter out of range, a resonance.
    #[error(transparent)]
    Breather(#[from] BreatherError),
    /// Newton's method found no orbit near enough.
    #[error("Newton's method found no orbit of the branch")]
    NoConvergence,
    /// An orbit that was given by its impacts has no equations to be followed.
    #[error("only orbits of a family can be followed, not words")]
    Word,
}

/// A point of a branch.
#[derive(Debug, Clone, PartialEq)]
pub struct BranchPoint {
    orbit: Orbit,
    /// The unknowns, then the parameter.
    coordinates: Vector,
    /// Unit tangent, in units of the coordinates.
    tangent: Vector,
    parameter: usize,
    full_determinant: f64,
    /// Sign of the determinant of ∂F/∂z bordered by the tangent: constant along a curve without branch points, and different
    /// on branches that are neighbours at one value of the parameter.
    orientation: f64,
    parameter_error: f64,
}

impl BranchPoint {
    /// The orbit.
    pub fn orbit(&self) -> &Orbit {
        &self.orbit
    }

    /// Value of the free parameter.
    pub fn value(&self) -> f64 {
        self.coordinates[self.parameter]
    }

    /// Component of the unit tangent along the parameter; it changes sign at a fold.
    pub fn heading(&self) -> f64 {
        self.tangent[self.parameter]
    }

    /// Determinant of the Jacobian of the orbit's equations, rows and columns scaled: 0 where an orbit under a force has a
    /// multiplier +1.
    pub fn determinant(&self) -> f64 {
        self.full_determinant
    }

    /// Estimated error of the parameter at a fold: what rounding of the equations does to the curve along the parameter.
    pub fn parameter_error(&self) -> f64 {
        self.parameter_error
    }

    /// The same point, with the curve to be followed the other way.
    pub fn reversed(&self) -> Self {
        Self { tangent: self.tangent.map(|x| -x), orientation: -self.orientation, ..self.clone() }
    }
}

/// One branch, to be followed step by step.
///
/// ```
/// use vibrochain_breather::{Branch, Family, breathers};
/// use vibrochain_lattice::{Chain, Model, Parameter};
/// let model = Model::forced(Chain::new(21, 0.2, 0.1)?, 1.07, 0.8, 0.165, 0.25)?;
/// let orbit = &breathers(&model, Family::SingleSided)?.orbits[0];
/// let mut branch = Branch::through(orbit, Parameter::Amplitude, 0.1)?;
/// // Downwards the branch turns back at a fold.
/// let mut point = branch.start()?.reversed();
/// while point.heading() < 0.0 {
///     point = branch.step(&point, 0.02)?;
/// }
/// let fold = branch.fold(&point)?;
/// assert!((fold.value() - 0.157927457266535).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Branch {
    finder: Finder,
    origin: Orbit,
    free: Parameter,
    word: SmallVec<[(usize, Barrier); 2]>,
    layout: Layout,
    reduction: Reduction,
    /// Number of unknowns.
    size: usize,
    /// Natural sizes of all unknowns, and of the coordinates with the parameter.
    full_units: Vector,
    units: Vector,
    evaluations: usize,
}

/// The equations and their derivatives at a point.
struct Evaluation {
    orbit: Orbit,
    rows: Vector,
    /// ∂F/∂x, columns in units.
    matrix: Matrix,
    full_determinant: f64,
}

impl Branch {
    /// The branch of `free` through an orbit. `unit` is the length along the parameter that counts like a change of
    /// order 1 of the orbit.
    ///
    /// # Errors
    /// [`BranchError::Word`].
    pub fn through(orbit: &Orbit, free: Parameter, unit: f64) -> Result<Self, BranchError> {
        let model = orbit.model();
        let mut finder = Finder::new(model.chain().sites());
        finder.prepare(model, orbit.frequency())?;
        let layout = Terms::new(orbit, &finder.response).layout().ok_or(BranchError::Word)?;
        Ok(Self::with(orbit, finder, (free, unit), layout, Reduction::of(orbit, free, layout)))
    }

    /// The branch of these unknowns; `finder` must be prepared for the orbit.
    pub(crate) fn with(
        orbit: &Orbit,
        finder: Finder,
        (free, unit): (Parameter, f64),
        layout: Layout,
        reduction: Reduction,
    ) -> Self {
        let model = orbit.model();
        let size = reduction.columns.len();
        let displacement = Terms::new(orbit, &finder.response).static_displacement();
        let largest = orbit.impacts().iter().map(|impact| impact.impulse.abs()).fold(0.0, f64::max);
        let mut full_units = [1.0; WIDTH];
        // An impact that grazes leaves the others, or what a mass of the ring's own speed would have.
        full_units[..layout.impacts].fill(largest.max(0.1 * model.omega()));
        full_units[layout.impacts] = displacement.abs().max(1.0);
        for place in [layout.time, layout.psi].into_iter().flatten() {
            full_units[place] = model.period() / std::f64::consts::TAU;
        }
        let mut units = [1.0; WIDTH];
        for i in 0..size {
            units[i] = full_units[reduction.leading(i)];
        }
        units[size] = unit.abs().max(f64::MIN_POSITIVE);
        let word = orbit.impacts().iter().map(|impact| (impact.site, impact.barrier)).collect();
        Self { finder, origin: orbit.clone(), free, word, layout, reduction, size, full_units, units, evaluations: 0 }
    }

    /// Orbits assembled so far: the cost.
    pub fn evaluations(&self) -> usize {
        self.evaluations
    }

    /// The free parameter.
    pub fn free(&self) -> Parameter {
        self.free
    }

    /// The orbit that the branch was started from, heading towards larger parameters.
    ///
    /// # Errors
    /// [`BranchError`].
    pub fn start(&mut self) -> Result<BranchPoint, BranchError> {
        let z = self.origin_coordinates()?;
        self.correct(&z, &self.along_parameter(), 0.0, true)
    }

    /// Where the orbit that the branch was started from stands.
    pub(crate) fn origin_coordinates(&mut self) -> Result<Vector, BranchError> {
        self.finder.prepare(self.origin.model(), self.origin.frequency())?;
        let terms = Terms::new(&self.origin, &self.finder.response);
        let (displacement, impacts) = (terms.static_displacement(), self.origin.impacts());
        let mut full = [0.0; WIDTH];
        for (place, impact) in full.iter_mut().zip(impacts) {
            *place = impact.impulse;
        }
        full[self.layout.impacts] = displacement;
        if let (Some(place), Some(second)) = (self.layout.time, impacts.get(1)) {
            full[place] = second.time;
        }
        if let Some(place) = self.layout.psi {
            full[place] = self.origin.psi_or_zero();
        }
        let mut z = [0.0; WIDTH];
        for i in 0..self.size {
            z[i] = full[self.reduction.leading(i)];
        }
        z[self.size] = self.origin.model().get(self.free);
        Ok(z)
    }

    /// The point `length` along the tangent at `from`; negative lengths go back.
    ///
    /// # Errors
    /// [`BranchError`]; a shorter step may succeed.
    pub fn step(&mut self, from: &BranchPoint, length: f64) -> Result<BranchPoint, BranchError> {
        let (z, tangent) = (from.coordinates, from.tangent);
        let next = self.correct(&z, &tangent, length, false)?;
        self.continued(from, next)
    }

    /// `next` if it is on the curve through `from`, as far as the two points can tell.
    fn continued(&self, from: &BranchPoint, next: BranchPoint) -> Result<BranchPoint, BranchError> {
        let chord: Vector = std::array::from_fn(|i| (next.coordinates[i] - from.coordinates[i]) / self.units[i]);
        let norm = chord.iter().map(|x| x * x).sum::<f64>().sqrt();
        let ahead = chord.iter().zip(&from.tangent).map(|(x, tangent)| x * tangent).sum::<f64>();
        let length = norm.copysign(ahead);
        let apart = (0..=self.size).map(|i| (chord[i] - 0.5 * length * (from.tangent[i] + next.tangent[i])).abs());
        let fits = apart.fold(0.0, f64::max) <= CHORD * norm + 1e-9;
        // Asymmetric orbits pass the symmetric one, a branch point, on their way to their own mirror images.
        let side = |point: &BranchPoint| point.orbit.phi().map_or(0.0, |phi| phi - 0.5 * point.orbit.period());
        let mirrored = side(from) * side(&next) < 0.0;
        if fits && (mirrored || from.orientation * next.orientation >= 0.0) {
            Ok(next)
        } else {
            Err(BranchError::NoConvergence)
        }
    }

    /// The point of the curve with the given parameter, near `from`, heading on as there.
    ///
    /// # Errors
    /// [`BranchError`].
    pub fn at(&mut self, from: &BranchPoint, value: f64) -> Result<BranchPoint, BranchError> {
        let heading = from.heading();
        if heading == 0.0 {
            return Err(BranchError::NoConvergence);
        }
        let length = (value - from.value()) / self.units[self.size];
        // Along the tangent to the parameter asked for, and from there at that parameter.
        let mut z = from.coordinates;
        for i in 0..self.size {
            z[i] += self.units[i] * from.tangent[i] * length / heading;
        }
        z[self.size] = value;
        let direction = self.along_parameter().map(|x| x * heading.signum());
        let next = self.correct(&z, &direction, 0.0, false)?;
        self.continued(from, next)
    }

    /// The fold near `near`: F = 0 and det ∂F/∂x = 0 by Newton's method.
    ///
    /// # Errors
    /// [`BranchError`].
    pub fn fold(&mut self, near: &BranchPoint) -> Result<BranchPoint, BranchError> {
        let (m, mut z) = (self.size, near.coordinates);
        let mut last = f64::INFINITY;
        for _ in 0..4 * STEPS {
            let here = self.evaluate(&z)?;
            let mut matrix = here.matrix;
            let column = self.parameter_column(&z, &here.rows)?;
            for i in 0..m {
                matrix[i][m] = column[i];
            }
            for j in 0..=m {
                let side = |branch: &mut Self, sign: f64| -> Result<f64, BranchError> {
                    let mut moved = z;
                    moved[j] += sign * DIFFERENCE * branch.units[j];
                    Ok(determinant(&branch.evaluate(&moved)?.matrix, m))
                };
                matrix[m][j] = (side(self, 1.0)? - side(self, -1.0)?) / (2.0 * DIFFERENCE);
            }
            let mut right = here.rows.map(|x| -x);
            right[m] = -determinant(&here.matrix, m);
            let change = solve(&matrix, &right, m + 1).ok_or(BranchError::NoConvergence)?;
            let size = change[..=m].iter().fold(0.0_f64, |size, x| size.max(x.abs()));
            // Damped while far away.
            let damping = (0.1 / size).min(1.0);
            for i in 0..=m {
                z[i] += damping * change[i] * self.units[i];
            }
            if size <= 4.0 * f64::EPSILON || size < 1e-10 && size >= 0.5 * last {
                return self.finish(&z, &near.tangent);
            }
            last = size;
        }
        Err(BranchError::NoConvergence)
    }

    /// The length at which `to` lies from `from`, along the tangent there.
    pub fn length_between(&self, from: &BranchPoint, to: &BranchPoint) -> f64 {
        let along = |i: usize| from.tangent[i] * (to.coordinates[i] - from.coordinates[i]) / self.units[i];
        (0..=self.size).map(along).sum()
    }

    /// The first resonance as the parameter goes from one value to another, and the value where it is: a harmonic of the
    /// orbit's frequency on a mode.
    pub fn resonance_within(&self, from: f64, to: f64) -> Option<(f64, Resonance)> {
        if !matches!(self.free, Parameter::Gamma1 | Parameter::Gamma2 | Parameter::Omega) {
            return None;
        }
        let periods = f64::from(self.origin.force_periods());
        let of = |model: &Model| (Spectrum::new(*model.chain()), model.omega() / periods);
        let model = |value: f64| self.origin.model().with(self.free, value).ok();
        let ((first, omega), (last, last_omega)) = (of(&model(from)?), of(&model(to)?));
        let mut nearest: Option<(f64, Resonance)> = None;
        for (mode, (start, end)) in first.frequencies().iter().zip(last.frequencies()).enumerate() {
            let (start, end) = ((start / omega).floor(), (end / last_omega).floor());
            if start == end {
                continue;
            }
            let harmonic = if end > start { start + 1.0 } else { start };
            if harmonic < 1.0 {
                continue;
            }
            let (mut low, mut high) = (from, to);
            let mut hit = None;
            for _ in 0..100 {
                let middle = 0.5 * (low + high);
                let Some(model) = model(middle) else { break };
                let (spectrum, omega) = of(&model);
                let frequency = spectrum.frequencies().get(mode).copied().unwrap_or_default();
                let distance = (-harmonic).mul_add(omega, frequency);
                hit = Some((middle, Resonance { harmonic: harmonic as u64, mode, frequency, omega, distance }));
                if ((frequency / omega).floor() - start).abs() < 0.5 { low = middle } else { high = middle }
            }
            let closer = |(value, _): &(f64, Resonance)| {
                nearest.as_ref().is_none_or(|(old, _)| (value - from).abs() < (old - from).abs())
            };
            if hit.as_ref().is_some_and(closer) {
                nearest = hit;
            }
        }
        nearest
    }

    fn along_parameter(&self) -> Vector {
        std::array::from_fn(|i| if i == self.size { 1.0 } else { 0.0 })
    }

    /// The orbit with these coordinates, whatever its residual, and its impulse response in the finder.
    fn assemble(&mut self, z: &Vector) -> Result<(Orbit, f64), BranchError> {
        let model = self.origin.model().with(self.free, z[self.size]).map_err(BreatherError::from)?;
        let periods = self.origin.force_periods();
        self.evaluations += 1;
        self.finder.prepare(&model, model.omega() / f64::from(periods))?;
        let (response, motion) = (&self.finder.response, &mut self.finder.motion);
        let half = 0.5 * response.period();
        let full = self.reduction.expand(z);
        let at = |place: Option<usize>, otherwise: f64| match place {
            Some(place) if self.reduction.is_free(place) => full[place],
            _ => otherwise,
        };
        let displacement = full[self.layout.impacts];
        let (second, psi) = (at(self.layout.time, half), at(self.layout.psi, self.reduction.psi * model.period()));
        if !(second > 0.0 && second < response.period()) {
            return Err(BranchError::NoConvergence);
        }
        let time = |i: usize| if i == 0 { 0.0 } else { second };
        let impacts = self.word.iter().enumerate();
        let site = self.word.first().map_or(0, |impact| impact.0);
        let draft = Draft {
            family: self.origin.family(),
            force_periods: periods,
            psi: psi.rem_euclid(model.period()),
            impacts: impacts.map(|(i, &(site, barrier))| Hit::new(site, barrier, time(i), full[i])).collect(),
            sources: smallvec![Source { site, net_impulse: displacement * response.static_stiffness() }],
            uniform_offset: displacement * response.uniform_share(),
        };
        let orbit = Orbit::assemble(&model, response, motion, draft)?;
        Ok((orbit, displacement))
    }

    /// F at `z`; the motion in the finder is left on that orbit.
    fn rows(&mut self, z: &Vector) -> Result<(Orbit, Vector), BranchError> {
        let (orbit, displacement) = self.assemble(z)?;
        let (n, mut rows) = (self.layout.impacts, [0.0; WIDTH]);
        let response = &self.finder.response;
        for i in 0..n {
            let [position, newton] = Terms::new(&orbit, response).violation(i);
            rows[i] = position;
            if Terms::has_newton_row(self.layout, i) {
                rows[n + 1 + i] = newton;
            }
        }
        let net: f64 = orbit.impacts().iter().map(|impact| impact.impulse).sum();
        rows[n] = net - response.static_stiffness() * displacement;
        Ok((orbit, self.reduction.rows(&rows)))
    }

    fn evaluate(&mut self, z: &Vector) -> Result<Evaluation, BranchError> {
        let (orbit, rows) = self.rows(z)?;
        let system = Terms::new(&orbit, &self.finder.response).system_of(self.layout);
        let mut full = [[0.0; WIDTH]; WIDTH];
        for i in 0..system.layout.size {
            for j in 0..system.layout.size {
                full[i][j] = system.matrix[i][j] * self.full_units[j];
            }
        }
        let matrix = self.reduction.matrix(&full);
        let full_determinant = determinant(&full, system.layout.size);
        Ok(Evaluation { orbit, rows, matrix, full_determinant })
    }

    /// ∂F/∂x at `z`, columns in units.
    pub(crate) fn jacobian(&mut self, z: &Vector) -> Result<Matrix, BranchError> {
        Ok(self.evaluate(z)?.matrix)
    }

    /// `z`, an orbit, with this unit tangent.
    pub(crate) fn point(&mut self, z: &Vector, tangent: &Vector) -> Result<BranchPoint, BranchError> {
        let here = self.evaluate(z)?;
        let (coordinates, parameter) = (*z, self.size);
        Ok(BranchPoint {
            orbit: here.orbit,
            coordinates,
            tangent: *tangent,
            parameter,
            full_determinant: here.full_determinant,
            orientation: 0.0,
            parameter_error: f64::INFINITY,
        })
    }

    /// ∂F/∂λ in units, by differences; one-sided at the end of the parameter's range.
    fn parameter_column(&mut self, z: &Vector, here: &Vector) -> Result<Vector, BranchError> {
        let m = self.size;
        let step = DIFFERENCE * z[m].abs().max(1e-2 * self.units[m]);
        let side = |branch: &mut Self, sign: f64| {
            let mut moved = *z;
            moved[m] += sign * step;
            branch.rows(&moved).ok().map(|(_, rows)| (rows, moved[m]))
        };
        let (high, low) = (side(self, 1.0), side(self, -1.0));
        let ((high, top), (low, bottom)) = match (high, low) {
            (None, None) => return Err(BranchError::NoConvergence),
            (high, low) => (high.unwrap_or((*here, z[m])), low.unwrap_or((*here, z[m]))),
        };
        let scale = self.units[m] / (top - bottom);
        Ok(std::array::from_fn(|i| (high[i] - low[i]) * scale))
    }

    /// Newton's method for F(z) = 0, τ·(z − z₀) = σ. `known` says that z₀ itself is an orbit.
    fn correct(
        &mut self,
        anchor: &Vector,
        tangent: &Vector,
        length: f64,
        known: bool,
    ) -> Result<BranchPoint, BranchError> {
        let (m, units) = (self.size, self.units);
        let mut z: Vector = std::array::from_fn(|i| anchor[i] + units[i] * tangent[i] * length);
        let predicted = z;
        let mut last = f64::INFINITY;
        for _ in 0..STEPS {
            let here = self.evaluate(&z)?;
            let exact = last < NOISE && self.holds(&here);
            let mut matrix = here.matrix;
            let column = self.parameter_column(&z, &here.rows)?;
            for i in 0..m {
                matrix[i][m] = column[i];
            }
            matrix[m] = *tangent;
            let mut right = here.rows.map(|x| -x);
            right[m] = length - (0..m + 1).map(|i| tangent[i] * (z[i] - anchor[i]) / units[i]).sum::<f64>();
            let change = solve(&matrix, &right, m + 1).ok_or(BranchError::NoConvergence)?;
            let size = change[..=m].iter().fold(0.0_f64, |size, x| size.max(x.abs()));
            for i in 0..=m {
                z[i] += change[i] * units[i];
            }
            let moved = (0..=m).map(|i| ((z[i] - predicted[i]) / units[i]).abs()).fold(0.0, f64::max);
            let leash = if length == 0.0 { 1e-2 } else { BEND * length.abs() + 1e-9 };
            if moved.is_nan() || moved > leash {
                return Err(BranchError::NoConvergence);
            }
            // Far from rounding a step is the square of the last one; next to a bifurcation rounding is as large as this.
            if size <= 4.0 * f64::EPSILON || size >= 0.25 * last && exact || known && size < 1e-9 {
                return self.finish(&z, tangent);
            }
            last = size;
        }
        Err(BranchError::NoConvergence)
    }

    /// Whether the equations hold but for rounding; right after they were worked out.
    fn holds(&self, here: &Evaluation) -> bool {
        let errors = self.row_errors(&here.orbit);
        (0..self.size).all(|i| here.rows[i].abs() <= ROUNDING * errors[i])
    }

    /// The point at `z`, with a tangent that goes the way `towards` does.
    fn finish(&mut self, z: &Vector, towards: &Vector) -> Result<BranchPoint, BranchError> {
        let m = self.size;
        let here = self.evaluate(z)?;
        let errors = self.row_errors(&here.orbit);
        let column = self.parameter_column(z, &here.rows)?;
        let mut matrix = here.matrix;
        for i in 0..m {
            matrix[i][m] = column[i];
        }
        matrix[m] = *towards;
        let right: Vector = std::array::from_fn(|i| if i == m { 1.0 } else { 0.0 });
        let tangent = solve(&matrix, &right, m + 1).ok_or(BranchError::NoConvergence)?;
        let norm = tangent[..=m].iter().map(|x| x * x).sum::<f64>().sqrt();
        let tangent: Vector = std::array::from_fn(|i| if i <= m { tangent[i] / norm } else { 0.0 });
        // The parameter's row of the inverse, bordered by the tangent itself.
        matrix[m] = tangent;
        let transposed: Matrix = std::array::from_fn(|i| std::array::from_fn(|j| matrix[j][i]));
        let parameter_error = solve(&transposed, &right, m + 1)
            .map_or(f64::INFINITY, |row| (0..m).map(|i| row[i].abs() * errors[i]).sum::<f64>() * self.units[m]);
        Ok(BranchPoint {
            orbit: here.orbit,
            coordinates: *z,
            tangent,
            parameter: m,
            full_determinant: here.full_determinant,
            orientation: determinant(&matrix, m + 1).signum(),
            parameter_error,
        })
    }

    /// Rounding of F, with the worst signs; the finder's response must be the orbit's.
    fn row_errors(&self, orbit: &Orbit) -> Vector {
        let (response, n) = (&self.finder.response, self.layout.impacts);
        let terms = Terms::new(orbit, response);
        let model = orbit.model();
        let unit = 2.0 * f64::EPSILON;
        let displacement = terms.static_displacement();
        let mut full = [0.0; WIDTH];
        for i in 0..n {
            let impact = &orbit.impacts()[i];
            let (force, t) = (terms.force(i), impact.time + orbit.psi_or_zero());
            let mut position = displacement.abs() + model.barrier(impact.barrier).abs();
            position += force[0].abs() + (t * force[1]).abs();
            let mut newton = (0.5 * model.loss() * impact.impulse).abs() + force[1].abs() + (t * force[2]).abs();
            for j in 0..n {
                let bound = response.sensitivity(terms.elapsed(i, j));
                position += terms.impulse(j).abs() * bound.value;
                newton += if j == i { 0.0 } else { terms.impulse(j).abs() * bound.slope };
            }
            full[i] = unit * position;
            if Terms::has_newton_row(self.layout, i) {
                full[n + 1 + i] = unit * newton;
            }
        }
        let impulses: f64 = (0..n).map(|i| terms.impulse(i).abs()).sum();
        full[n] = unit * (impulses + 2.0 * (response.static_stiffness() * displacement).abs());
        self.reduction.rows(&full)
    }
}
