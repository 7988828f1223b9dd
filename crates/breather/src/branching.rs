//! Where a branch of orbits of lower symmetry begins: at a pitchfork of double-sided orbits and, of doubled orbits, at the
//! period doubling of a single-sided one.
//!
//! Written with the unknowns of the orbits that branch off (both times and impulses free, for a doubled orbit twice the
//! period), ∂F/∂x of the orbit they leave is singular, ∂F/∂x n = 0, in a direction n that breaks its symmetry. Along n begins
//!
//! ```text
//! F(z) = 0,     n·(z − z₀) = σ,     λ = λ₀ + κσ² + …
//! ```
//!
//! while the orbit itself moves across n. So the curve of length along a tangent that every branch is followed by leads off
//! it, and the sign of κ is the side on which the orbits exist: nothing has to be searched for or told apart.

use smallvec::smallvec;
use vibrochain_lattice::Parameter;

use crate::bordered::{Vector, WIDTH, solve};
use crate::branch::{Branch, BranchError, BranchPoint};
use crate::equations::{Layout, Terms};
use crate::finder::Finder;
use crate::orbit::{Draft, Family, Hit, Orbit, Source};
use crate::reduction::Reduction;

/// A border that is not orthogonal to n in any symmetry.
const BORDER: Vector = [1.0, 0.618, 0.382, 0.729, 0.271, 0.553];

impl Branch {
    /// The branch that leaves `orbit` at a pitchfork (double-sided) or a period doubling (single-sided, under a force), and
    /// the point where it does, heading along it; steps the other way give the mirror image, of a doubled orbit the
    /// same one begun half its period later. Whether the orbit stands at such a point is the caller's to know.
    ///
    /// # Errors
    /// [`BranchError::Word`] for a family from which none is known to branch off; otherwise as [`Branch::step`].
    ///
    /// ```
    /// use vibrochain_breather::{Branch, Family, breathers};
    /// use vibrochain_lattice::{Chain, Model, Parameter};
    /// let model = Model::forced(Chain::new(21, 0.2, 0.1)?, 1.07, 0.8, 0.15890808620612, 0.25)?;
    /// let orbit = &breathers(&model, Family::SingleSided)?.orbits[0];
    /// let (mut branch, start) = Branch::leaving(orbit, Parameter::Amplitude, 0.1)?;
    /// let doubled = branch.step(&start, 0.01)?;
    /// assert!(doubled.orbit().family() == Family::PeriodDoubled && doubled.value() < start.value());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn leaving(orbit: &Orbit, free: Parameter, unit: f64) -> Result<(Self, BranchPoint), BranchError> {
        let model = orbit.model();
        let mut finder = Finder::new(model.chain().sites());
        let origin = match orbit.family() {
            Family::SingleSided if !model.is_conservative() => twice(orbit, &mut finder)?,
            Family::DoubleSided => orbit.clone(),
            _ => return Err(BranchError::Word),
        };
        finder.prepare(model, origin.frequency())?;
        let psi = (!model.is_conservative()).then_some(4);
        let layout = Layout { impacts: 2, time: Some(3), psi, size: 4 + usize::from(psi.is_some()) };
        let mut branch = Self::with(&origin, finder, (free, unit), layout, Reduction::none(layout));
        let coordinates = branch.origin_coordinates()?;
        let mut bordered = branch.jacobian(&coordinates)?;
        // (∂F/∂x b; cᵀ 0)(n; g) = (0; 1), regular where ∂F/∂x is singular.
        let size = layout.size;
        for i in 0..size {
            bordered[i][size] = BORDER[i];
        }
        bordered[size] = std::array::from_fn(|j| if j < size { BORDER[j] } else { 0.0 });
        let right: Vector = std::array::from_fn(|i| if i == size { 1.0 } else { 0.0 });
        let direction = solve(&bordered, &right, size + 1).ok_or(BranchError::NoConvergence)?;
        let norm = direction[..size].iter().map(|x| x * x).sum::<f64>().sqrt();
        let mut tangent = [0.0; WIDTH];
        for i in 0..size {
            tangent[i] = direction[i] / norm;
        }
        let point = branch.point(&coordinates, &tangent)?;
        Ok((branch, point))
    }
}

/// A single-sided orbit as one of two impacts in two periods of the force.
fn twice(orbit: &Orbit, finder: &mut Finder) -> Result<Orbit, BranchError> {
    let model = orbit.model();
    finder.prepare(model, orbit.frequency())?;
    let displacement = Terms::new(orbit, &finder.response).static_displacement();
    let first = orbit.impacts().first().ok_or(BranchError::Word)?;
    finder.prepare(model, 0.5 * model.omega())?;
    let (response, motion) = (&finder.response, &mut finder.motion);
    let impact = |time: f64| Hit { time, ..Hit::from(first) };
    let draft = Draft {
        family: Family::PeriodDoubled,
        force_periods: 2,
        psi: orbit.psi_or_zero(),
        impacts: smallvec![impact(0.0), impact(0.5 * response.period())],
        sources: smallvec![Source { site: first.site, net_impulse: displacement * response.static_stiffness() }],
        uniform_offset: displacement * response.uniform_share(),
    };
    Ok(Orbit::assemble(model, response, motion, draft)?)
}
