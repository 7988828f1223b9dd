//! The multipliers of an orbit from J(z), and how well they are known, given what its own errors do.

use std::cell::OnceCell;

use nalgebra::Complex;
use vibrochain_breather::{BlochEquations, ContactOrbit};

use crate::error::FloquetError;
use crate::spectrum::{BEYOND, Origin, is_surely_beyond, origins, told, told_of_cycle, verdict};
use crate::verdict::{Tolerance, Verdict};
use crate::zeros::{SecularError, excess};

/// An error of the spectral radius above this part of it is held against multipliers of orbits that far away: squares count from the root of
/// rounding on.
const FIRST_ORDER: f64 = 1e-9;

/// The spectral radius may move with the orbit's data up to this many times as far as first order says; beyond that its error is no bound.
const STRAIGHT: f64 = 1.5;

/// An orbit with its equations J(z), which are set up once they are asked for.
#[derive(Debug)]
pub struct BlochProblem<'a> {
    pub(super) orbit: &'a ContactOrbit,
    /// With the rates of the modes that they leave out.
    equations: OnceCell<(BlochEquations, Vec<[Complex<f64>; 2]>)>,
}

impl<'a> BlochProblem<'a> {
    /// Of an orbit.
    #[must_use]
    pub fn of(orbit: &'a ContactOrbit) -> Self {
        Self { orbit, equations: OnceCell::new() }
    }

    fn all_equations(&self) -> &(BlochEquations, Vec<[Complex<f64>; 2]>) {
        self.equations.get_or_init(|| self.orbit.bloch_equations())
    }

    fn equations(&self) -> &BlochEquations {
        &self.all_equations().0
    }

    pub(super) fn spared(&self) -> &[[Complex<f64>; 2]] {
        &self.all_equations().1
    }

    /// Whether the spectral radius is surely beyond `reach`: a real multiplier is, by 5 %. No says nothing; an orbit whose own errors could matter
    /// is not asked. A map asks so: of two orbits that are born in a fold one has such a multiplier, and a sign takes a small part of what a verdict
    /// takes.
    #[must_use]
    pub fn surely_exceeds(&self, reach: f64) -> bool {
        !self.orbit.is_conservative() && is_surely_beyond(self.equations(), BEYOND * reach) && !self.orbit.is_delicate()
    }

    /// The verdict from the zeros of the determinant; `quick` with the errors of the orbit's data only where they could show.
    pub(crate) fn worked_out(&self, tolerance: Tolerance, quick: bool) -> Result<Verdict, FloquetError> {
        let ask = |equations: &BlochEquations, data: &[Origin]| {
            if self.orbit.is_self_excited() {
                self.told(equations, data, tolerance).map(|(verdict, _)| (verdict, ()))
            } else {
                verdict(equations, self.orbit.is_conservative(), data, tolerance).map(|verdict| (verdict, ()))
            }
        };
        if quick
            && !self.orbit.is_self_excited()
            && !self.orbit.is_delicate()
            && let Ok((felt, ())) = ask(self.equations(), &[])
            && !felt.hangs_on_rounding(self.orbit.is_lossless(), tolerance)
        {
            return Ok(self.with_spared(felt, tolerance));
        }
        self.as_well_as_known(ask, tolerance).map(|(felt, ())| self.with_spared(felt, tolerance))
    }

    /// The verdict on the modes that the impacts feel, and their multipliers without what is the orbit's own derivative.
    fn told(
        &self,
        equations: &BlochEquations,
        data: &[Origin],
        tolerance: Tolerance,
    ) -> Result<(Verdict, Vec<Complex<f64>>), SecularError> {
        if !self.orbit.is_self_excited() {
            return told(equations, self.orbit.is_conservative(), data, tolerance);
        }
        let rates = equations.kernel().modes().iter().flat_map(|mode| mode.rates());
        let fastest = rates.map(|rate| rate.norm()).fold(0.0, f64::max);
        told_of_cycle(equations, data, fastest * self.orbit.period_error(), tolerance)
    }

    /// The same with the multipliers.
    pub(crate) fn all_worked_out(&self, tolerance: Tolerance) -> Result<(Verdict, Vec<Complex<f64>>), FloquetError> {
        let ask = |equations: &BlochEquations, data: &[Origin]| self.told(equations, data, tolerance);
        let (felt, multipliers) = self.as_well_as_known(ask, tolerance)?;
        Ok((self.with_spared(felt, tolerance), multipliers))
    }

    /// The answer of the equations, with the errors of the orbit's data. Where these have no bound, or are so large that multipliers do not move in a
    /// straight line with them, it is that of the orbit as it stands, and undecided.
    fn as_well_as_known<T>(
        &self,
        ask: impl Fn(&BlochEquations, &[Origin]) -> Result<(Verdict, T), SecularError>,
        tolerance: Tolerance,
    ) -> Result<(Verdict, T), FloquetError> {
        if self.orbit.has_bounds() {
            let answer = ask(self.equations(), &origins(self.equations(), self.orbit.error_origins()));
            if let Ok((verdict, rest)) = answer
                && self.moves_straight(&verdict, &ask)
            {
                return Ok((verdict, rest));
            }
        }
        let (verdict, rest) = ask(self.equations(), &[]).map_err(FloquetError::Uncounted)?;
        let none = Verdict::unsettled(verdict.leading, verdict.excess(), f64::INFINITY, tolerance);
        Ok((none, rest))
    }

    /// Whether the spectral radius of orbits as far away as this one may be off is as far away as its error says, each origin on its own.
    fn moves_straight<T>(
        &self,
        verdict: &Verdict,
        ask: &impl Fn(&BlochEquations, &[Origin]) -> Result<(Verdict, T), SecularError>,
    ) -> bool {
        if verdict.resolution <= FIRST_ORDER * (1.0 + verdict.spectral_radius) {
            return true;
        }
        let mut sum = 0.0;
        for origin in self.orbit.error_origins() {
            let Some(aside) = self.orbit.bloch_equations_aside(origin) else { return false };
            let Ok((there, _)) = ask(&aside, &[]) else { return false };
            sum += (there.excess() - verdict.excess()).abs();
        }
        sum <= STRAIGHT * verdict.resolution
    }

    /// Frequencies of the modes that the impacts feel.
    pub(crate) fn frequencies(&self) -> impl Iterator<Item = f64> + '_ {
        self.equations().kernel().modes().iter().map(|mode| mode.rate)
    }

    pub(super) fn multiplier(&self, rate: Complex<f64>) -> Complex<f64> {
        (rate * self.orbit.period()).exp()
    }

    /// Of a mode without a dashpot that is spared, the multipliers are on the circle, and decide nothing; nor does the 1 of a motion of the whole
    /// that nothing brings back, which is neutral by symmetry: of its pair the other decides.
    fn with_spared(&self, verdict: Verdict, tolerance: Tolerance) -> Verdict {
        self.spared().iter().fold(verdict, |verdict, pair| {
            let deciding = pair.iter().filter(|rate| rate.re != 0.0).map(|rate| self.multiplier(*rate));
            let Some(leading) = deciding.max_by(|a, b| a.norm().total_cmp(&b.norm())) else { return verdict };
            let error = 8.0 * f64::EPSILON * leading.norm();
            verdict.or_worse(Verdict::of_excess(leading, excess(leading), error, tolerance))
        })
    }
}
