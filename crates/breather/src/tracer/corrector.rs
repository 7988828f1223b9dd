//! The equations of a chain's orbits as a [`System`]: in the orbit's unknowns and the parameters that are free.

use smallvec::SmallVec;
use vibrochain_lattice::{Model, Parameter};

use crate::branch_error::BranchError;
use crate::equations::Equations;
use crate::equations::linear::{Vector, zeros};
use crate::equations::unknowns::{Template, Unknowns};
use crate::error::BreatherError;
use crate::orbit::Orbit;
use crate::search::finder::Finder;
use crate::tracer::reduction::{Reduction, SYMMETRIC};
use crate::tracer::system::{Evaluation, System};

/// The equations of an orbit, in its unknowns and the parameters that are free.
#[derive(Debug, Clone)]
pub(crate) struct Continuation {
    pub(crate) finder: Finder,
    pub(crate) origin: Orbit,
    /// One along a branch, two along a curve of an event.
    pub(crate) free: SmallVec<[Parameter; 2]>,
    /// Another parameter, and its ratio to the first of these, which it keeps.
    pub(crate) tied: Option<(Parameter, f64)>,
    /// The origin's word, and its times in periods.
    template: Template,
    fractions: Vector,
    pub(crate) unknowns: Unknowns,
    pub(crate) reduction: Reduction,
    /// Natural sizes of all unknowns, and of the coordinates with the parameters.
    full_units: Vector,
    pub(crate) units: Vector,
    pub(crate) evaluations: usize,
}

/// What changes of impulses are compared to: an impact that grazes leaves the others, or what a mass of the ring's own speed would have.
fn impulse_unit(orbit: &Orbit) -> f64 {
    orbit.strength().max(0.1 * orbit.model().omega())
}

/// Which impact of the orbit each of the word's is.
type Places = SmallVec<[usize; 2]>;

impl Continuation {
    /// The equations of `orbit` with `free` parameters, each with its unit: the length along it that counts like a change of order 1 of
    /// the orbit.
    pub(crate) fn new(
        orbit: &Orbit,
        free: &[(Parameter, f64)],
        unknowns: Unknowns,
        reduction: Reduction,
    ) -> Result<Self, BranchError> {
        let model = orbit.model();
        let mut finder = Finder::new(model.chain().sites());
        finder.prepare(model, orbit.frequency())?;
        let mut full_units = unknowns.units(orbit, &finder.response, impulse_unit(orbit));
        for place in unknowns.times().chain(unknowns.psi()) {
            full_units[place] = model.period() / std::f64::consts::TAU;
        }
        let mut units: Vector = (0..reduction.size()).map(|i| full_units[reduction.leading(i)]).collect();
        units.extend(free.iter().map(|(_, unit)| unit.abs().max(f64::MIN_POSITIVE)));
        let fraction = |time: f64| {
            let fraction = time / orbit.period();
            if (fraction - 0.5).abs() <= SYMMETRIC { 0.5 } else { fraction }
        };
        let fractions = orbit.impacts().iter().map(|impact| fraction(impact.time)).collect();
        let (origin, template) = (orbit.clone(), Template::of(orbit));
        let free = free.iter().map(|(parameter, _)| *parameter).collect();
        let tied = None;
        Ok(Self {
            finder,
            origin,
            free,
            tied,
            template,
            fractions,
            unknowns,
            reduction,
            full_units,
            units,
            evaluations: 0,
        })
    }

    /// Measures impulses, and what they hold up, by those of `orbit` from here on.
    pub(crate) fn rescale(&mut self, orbit: &Orbit) {
        let own = self.unknowns.units(orbit, &self.finder.response, impulse_unit(orbit));
        let which = ..=self.unknowns.impacts;
        self.full_units[which].copy_from_slice(&own[which]);
        for i in 0..self.reduction.size() {
            self.units[i] = self.full_units[self.reduction.leading(i)];
        }
    }

    /// Where an orbit of the origin's word stands.
    pub(crate) fn coordinates(&mut self, orbit: &Orbit) -> Result<Vector, BranchError> {
        self.finder.prepare(orbit.model(), orbit.frequency())?;
        let full = self.unknowns.read(orbit, &self.finder.response);
        let mut z: Vector = (0..self.reduction.size()).map(|i| full[self.reduction.leading(i)]).collect();
        z.extend(self.free.iter().map(|&parameter| orbit.model().get(parameter)));
        Ok(z)
    }

    /// The model with these values of the free parameters.
    pub(crate) fn model(&self, values: &[f64]) -> Result<Model, BreatherError> {
        let tied = self.tied.map(|(parameter, ratio)| (parameter, ratio * values[0]));
        let all = self.free.iter().copied().zip(values.iter().copied()).chain(tied);
        let set = |model: Model, (parameter, value)| model.with(parameter, value);
        Ok(all.into_iter().try_fold(*self.origin.model(), set)?)
    }

    /// The orbit with these coordinates, whatever its residual, and its impulse response in the finder.
    fn assemble(&mut self, z: &[f64]) -> Result<(Orbit, Places), BranchError> {
        let model = self.model(&z[self.reduction.size()..])?;
        self.evaluations += 1;
        self.finder.prepare(&model, model.omega() / f64::from(self.template.force_periods()))?;
        let (response, motion) = (&self.finder.response, &mut self.finder.motion);
        // What no coordinate moves keeps its part of the period.
        let (period, fractions) = (response.period(), &self.fractions);
        let psi = self.reduction.psi.unwrap_or(0.0) * model.period();
        self.template.hold(|i| fractions[i] * period, psi);
        let mut full = zeros(self.unknowns.size());
        for (i, fraction) in fractions.iter().enumerate() {
            if let Some(place) = self.unknowns.time(i) {
                full[place] = fraction * period;
            }
        }
        if let Some(place) = self.unknowns.psi() {
            full[place] = psi;
        }
        self.reduction.expand(z, period, &mut full);
        let draft = self.template.draft(&self.unknowns, &full, &model, response);
        let (draft, places) = draft.ok_or(BranchError::NoConvergence)?;
        Ok((Orbit::assemble(&model, response, motion, draft)?, places))
    }

    fn equations<'a>(&'a self, orbit: &'a Orbit, places: &Places) -> Equations<'a> {
        Equations::ordered(orbit, &self.finder.response, self.unknowns, places.clone())
    }
}

impl System for Continuation {
    type Orbit = Orbit;
    type Kept = Places;

    fn size(&self) -> usize {
        self.reduction.size()
    }

    fn units(&self) -> &[f64] {
        &self.units
    }

    fn origin(&mut self) -> Result<Vector, BranchError> {
        let origin = self.origin.clone();
        self.coordinates(&origin)
    }

    fn rows(&mut self, z: &[f64]) -> Result<Vector, BranchError> {
        let (orbit, places) = self.assemble(z)?;
        Ok(self.reduction.rows(&self.equations(&orbit, &places).residuals()))
    }

    /// The finder is left with that orbit's impulse response.
    fn evaluate(&mut self, z: &[f64]) -> Result<Evaluation<Orbit, Places>, BranchError> {
        let (orbit, kept) = self.assemble(z)?;
        let equations = self.equations(&orbit, &kept);
        let rows = self.reduction.rows(&equations.residuals());
        let mut full = equations.jacobian();
        for i in 0..full.size() {
            full.row_mut(i).iter_mut().zip(&self.full_units).for_each(|(entry, unit)| *entry *= unit);
        }
        let matrix = self.reduction.matrix(&full);
        Ok(Evaluation { orbit, rows, matrix, full: Some(full), kept })
    }

    fn row_errors(&self, here: &Evaluation<Orbit, Places>) -> Vector {
        self.reduction.rows(&self.equations(&here.orbit, &here.kept).row_errors())
    }

    fn evaluations(&self) -> usize {
        self.evaluations
    }

    /// Asymmetric orbits pass the symmetric one, a branch point, on their way to their own mirror images; and a resonance is a pole.
    fn may_turn(&self, (from, start): (&Orbit, f64), (to, end): (&Orbit, f64)) -> bool {
        let side = |orbit: &Orbit| orbit.phi().map_or(0.0, |phi| phi - 0.5 * orbit.period());
        side(from) * side(to) < 0.0 || self.has_pole_between(start, end)
    }
}
