//! The equations of a structure's orbits as a [`System`]: impulses, times, phase and offsets, and numbers of the structure that are free.

use std::fmt;
use std::sync::Arc;

use smallvec::SmallVec;
use vibrochain_lattice::{Barrier, LinearMode, ModalStructure, Stop};

use super::family::{MOVED, ModelFamily, check};
use super::images::is_own_image;
use super::reduction::Reduction;
use crate::branch_error::BranchError;
use crate::equations::linear::{USUAL, Vector, unit};
use crate::error::BreatherError;
use crate::orbit::symmetries::Symmetry;
use crate::structures::equations::{Equations, System as Rows};
use crate::structures::model::LoadedStructure;
use crate::structures::orbit::ContactOrbit;
use crate::structures::point::{Point, Strike};
use crate::tracer::solution_curve::{SolutionCurve, SolutionPoint, normed};
use crate::tracer::system::{Evaluation, System};

/// Impulses are measured by the strongest, and by this part of what a barrier as far as the contact's own would take.
const FAINT: f64 = 0.1;

/// Of a row, as a part of the sizes of its terms.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// What two contacts feel of each other at once, squared and relative, is rounding of the modes below this.
const APART: f64 = 1e-24;

/// A point of a structure's branch.
pub type BranchPoint = SolutionPoint<ContactOrbit>;

/// The orbits of one word of a structure as one number of it varies.
pub type Branch = SolutionCurve<Continuation>;

/// The equations of a word's orbits, with as many numbers of the structure free as units are given.
#[derive(Clone)]
pub struct Continuation {
    family: ModelFamily,
    contacts: Vec<(usize, Barrier)>,
    /// Impacts that cannot overtake each other.
    in_order: Vec<(usize, usize)>,
    force_periods: u32,
    /// Unknowns: impulses, times but the first, ψ if there is a load, the period if nothing gives it, offsets of rigid modes.
    size: usize,
    forced: bool,
    rigid: usize,
    self_excited: bool,
    /// The strongest impact where this begins.
    strongest: usize,
    /// A symmetry that is kept to.
    reduction: Option<Arc<Reduction>>,
    /// Of all unknowns, and of the coordinates with the numbers that are free.
    full_units: Vector,
    units: Vector,
    origin: Vector,
    /// After how long the load of the last equations repeats itself.
    load_period: f64,
    stop: Stop,
    evaluations: usize,
}

impl fmt::Debug for Continuation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Continuation").field("contacts", &self.contacts).field("origin", &self.origin).finish()
    }
}

impl Continuation {
    /// Through an orbit of the model at `values`; `units` are lengths along the numbers that count like a change of order 1 of the orbit.
    ///
    /// # Errors
    /// [`BranchError::Model`] where there is no such model.
    pub fn through(
        orbit: &ContactOrbit,
        family: ModelFamily,
        values: &[f64],
        units: &[f64],
        stop: &Stop,
    ) -> Result<Self, BranchError> {
        Self::among_all(orbit, family, values, units, stop)?.kept_to(orbit, values, Reduction::of)
    }

    /// The same, kept to the first of these symmetries of the orbit that are those of the structure, too.
    fn kept_to(
        mut self,
        orbit: &ContactOrbit,
        values: &[f64],
        symmetries: impl Fn(&ContactOrbit, &Equations<'_>) -> Vec<Reduction>,
    ) -> Result<Self, BranchError> {
        let mut equations = Equations::new(orbit.model(), self.force_periods, self.contacts.iter().map(|one| one.0))?;
        equations.left_out = self.strongest;
        for reduction in symmetries(orbit, &equations) {
            let reduced = |full: &[f64]| -> Vector {
                reduction.leading().map(|place| full[place]).chain(full[self.size..].iter().copied()).collect()
            };
            let origin = reduced(&self.origin);
            if self.keeps(&reduction, &origin, values)? {
                (self.units, self.origin) = (reduced(&self.full_units), origin);
                self.size = reduction.size();
                self.reduction = Some(Arc::new(reduction));
                break;
            }
        }
        Ok(self)
    }

    /// Whether a symmetry stays what it is where a number moves.
    fn keeps(&self, reduction: &Reduction, origin: &[f64], values: &[f64]) -> Result<bool, BranchError> {
        for k in 0..=values.len() {
            let mut moved = values.to_vec();
            if let Some(value) = moved.get_mut(k) {
                *value += MOVED * value.abs().max(MOVED);
            }
            let Ok(model) = (self.family)(&moved) else { continue };
            let mut there = Equations::new(&model, self.force_periods, self.contacts.iter().map(|one| one.0))?;
            there.left_out = self.strongest;
            let point = self.point(&reduction.expand(origin, there.period()), there.period())?;
            if !reduction.are_kept_by(&there.system(&point)?) {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// The same among orbits of any symmetry.
    ///
    /// # Errors
    /// As [`Continuation::through`].
    pub(super) fn among_all(
        orbit: &ContactOrbit,
        family: ModelFamily,
        values: &[f64],
        units: &[f64],
        stop: &Stop,
    ) -> Result<Self, BranchError> {
        let model = orbit.model();
        let family = model.like(&family, values);
        let hits = || orbit.impacts().iter().map(|impact| impact.site);
        let equations = Equations::new(model, orbit.force_periods(), hits())?;
        let felt = equations.felt_offsets(orbit.offsets());
        let contacts: Vec<(usize, Barrier)> =
            orbit.impacts().iter().map(|impact| (impact.site, impact.barrier)).collect();
        let in_order = bound_pairs(&contacts, model.structure());
        let size = |i: &usize| orbit.impacts()[*i].impulse.abs();
        let strongest = (0..orbit.impacts().len()).max_by(|i, j| size(i).total_cmp(&size(j))).unwrap_or(0);
        let most = size(&strongest);
        let impulse_unit = |contact: usize, barrier: Barrier| {
            let place = model.barrier(contact, barrier).unwrap_or(0.0);
            most.max(FAINT * model.omega() * place.abs() / equations.mobility(contact)).max(f64::MIN_POSITIVE)
        };
        let mut own: Vector = orbit.impacts().iter().map(|one| impulse_unit(one.site, one.barrier)).collect();
        let times = orbit.impacts().len() - 1 + usize::from(equations.has_time());
        own.extend(std::iter::repeat_n(1.0 / model.omega(), times));
        let reach = own[0] * equations.mobility(orbit.impacts()[0].site) / model.omega();
        own.extend(std::iter::repeat_n(reach, felt.len()));
        let size = own.len();
        own.extend(units.iter().map(|unit| unit.abs().max(f64::MIN_POSITIVE)));
        check(&family, values, &equations)?;
        let mut origin: Vector = orbit.impacts().iter().map(|impact| impact.impulse).collect();
        origin.extend(orbit.impacts().iter().skip(1).map(|impact| impact.time));
        origin.extend(orbit.psi());
        origin.extend(equations.self_excited.then(|| orbit.period()));
        origin.extend(felt);
        origin.extend_from_slice(values);
        let (force_periods, forced, rigid) = (orbit.force_periods(), equations.forced, equations.rigid.len());
        let self_excited = equations.self_excited;
        Ok(Self {
            family,
            contacts,
            in_order,
            force_periods,
            size,
            forced,
            rigid,
            self_excited,
            strongest,
            reduction: None,
            full_units: own.clone(),
            units: own,
            origin,
            load_period: load_period(&equations),
            stop: stop.clone(),
            evaluations: 0,
        })
    }

    /// Takes the orbit at the origin's values that Newton's method leads to from there, no farther away than `reach`.
    pub(crate) fn settle(&mut self, reach: f64) -> Result<(), BranchError> {
        let last = self.origin.len() - 1;
        let (z, fixed) = (self.origin.clone(), unit(last + 1, last));
        self.origin = self.newton(&z, Some(&fixed), reach, false)?;
        Ok(())
    }

    /// Measures impulses by so many times what they were measured by.
    fn rescale(&mut self, by: f64) {
        let impacts = self.contacts.len();
        self.full_units[..impacts].iter_mut().for_each(|unit| *unit *= by);
        let places: SmallVec<[usize; USUAL]> = match &self.reduction {
            Some(reduction) => reduction.leading().collect(),
            None => (0..self.size).collect(),
        };
        self.units.iter_mut().zip(places).for_each(|(unit, place)| *unit = self.full_units[place]);
    }

    /// What part of its place an impact adds to its law, if any.
    fn weight_of_places(&self) -> Option<f64> {
        // ω where this begins: a place times it is a velocity.
        self.self_excited.then(|| 1.0 / self.units[2 * self.contacts.len() - 1])
    }

    /// The model at a value of the one number that is free.
    pub(super) fn model_at(&self, value: f64) -> Option<LoadedStructure> {
        (self.family)(&[value]).ok()
    }

    /// The model at `z`.
    fn model(&mut self, z: &[f64]) -> Result<LoadedStructure, BranchError> {
        self.stop.heard().map_err(BreatherError::from)?;
        self.evaluations += 1;
        Ok((self.family)(&z[self.size..]).map_err(BranchError::Model)?.until(&self.stop))
    }

    /// The impacts in the order of the word, which that of time may leave: impacts of contacts that feel nothing of each other at once may overtake
    /// each other, and simultaneous ones always do, by rounding.
    fn point(&self, z: &[f64], period: f64) -> Result<Point, BranchError> {
        let n = self.contacts.len();
        let period = if self.self_excited { z[2 * n - 1] } else { period };
        let time = |i: usize| if i == 0 { 0.0 } else { z[n + i - 1] };
        // Also where two impacts are at one instant, as of two contacts they may be.
        if self.in_order.iter().any(|&(i, j)| !(0.0..period).contains(&(time(j) - time(i)))) {
            return Err(BranchError::NoConvergence);
        }
        let strike = |(i, &(contact, barrier)): (usize, &(usize, Barrier))| Strike {
            contact,
            barrier,
            time: time(i).rem_euclid(period),
            impulse: z[i],
        };
        let strikes = self.contacts.iter().enumerate().map(strike).collect();
        let psi = if self.forced { z[2 * n - 1] } else { 0.0 };
        let first = 2 * n - 1 + usize::from(self.forced || self.self_excited);
        let last = first + self.rigid;
        Ok(Point { strikes, psi, period, offsets: z[first..last].iter().copied().collect() })
    }

    fn assembled<T>(
        &mut self,
        z: &[f64],
        make: impl FnOnce(&Equations<'_>, Point, Rows) -> Result<T, BreatherError>,
    ) -> Result<T, BranchError> {
        let model = self.model(z)?;
        let mut equations = Equations::new(&model, self.force_periods, self.contacts.iter().map(|one| one.0))?;
        // Where a stiffness vanishes, or a load does, there is no such point.
        let kind = (equations.forced, equations.self_excited, equations.rigid.len());
        if kind != (self.forced, self.self_excited, self.rigid) {
            return Err(BreatherError::OtherUnknowns.into());
        }
        // Rounding hides the orbits this near to a resonance: the step fails, and a shorter one is tried.
        if !self.self_excited && equations.off_resonance(&equations.hit).is_err() {
            return Err(BranchError::NoConvergence);
        }
        equations.left_out = self.strongest;
        self.load_period = load_period(&equations);
        let point = match &self.reduction {
            Some(reduction) => self.point(&reduction.expand(z, equations.period()), equations.period())?,
            None => self.point(z, equations.period())?,
        };
        let rows = equations.system(&point)?;
        if rows.rows.iter().all(|row| row.is_finite()) {
            Ok(make(&equations, point, rows)?)
        } else {
            Err(BranchError::NoConvergence)
        }
    }
}

impl System for Continuation {
    type Orbit = ContactOrbit;
    /// Sizes of the rows' terms.
    type Kept = Vector;

    fn size(&self) -> usize {
        self.size
    }

    fn units(&self) -> &[f64] {
        &self.units
    }

    fn origin(&mut self) -> Result<Vector, BranchError> {
        Ok(self.origin.clone())
    }

    fn rows(&mut self, z: &[f64]) -> Result<Vector, BranchError> {
        let weight = self.weight_of_places();
        let rows = self.assembled(z, |_, _, rows| Ok(with_places(rows, weight).rows))?;
        Ok(match &self.reduction {
            Some(reduction) => reduction.rows(&rows),
            None => rows,
        })
    }

    fn evaluate(&mut self, z: &[f64]) -> Result<Evaluation<ContactOrbit, Vector>, BranchError> {
        let (units, periods, weight) = (self.full_units.clone(), self.force_periods, self.weight_of_places());
        let reduction = self.reduction.clone();
        self.assembled(z, |equations, point, here| {
            let Rows { rows, sizes: mut kept, jacobian: mut matrix, .. } = with_places(here.clone(), weight);
            // Next to a resonance rows are off by what its distance is, all of them together.
            for doubt in equations.resonant_doubts(&point) {
                kept.iter_mut().zip(&doubt.rows).for_each(|(size, row)| *size += row.abs() / ROUNDING);
            }
            for i in 0..matrix.size() {
                matrix.row_mut(i).iter_mut().zip(&units).for_each(|(entry, unit)| *entry *= unit);
            }
            let orbit = match point.in_time() {
                None => ContactOrbit::on_the_way(equations, periods, (&point, &here))?,
                Some(point) => ContactOrbit::on_the_way(equations, periods, (&point, &equations.system(&point)?))?,
            };
            Ok(match reduction {
                None => Evaluation { orbit, rows, matrix, full: None, kept },
                Some(reduction) => Evaluation {
                    orbit,
                    rows: reduction.rows(&rows),
                    kept: reduction.rows(&kept),
                    matrix: reduction.matrix(&matrix),
                    full: Some(matrix),
                },
            })
        })
    }

    fn row_errors(&self, here: &Evaluation<ContactOrbit, Vector>) -> Vector {
        here.kept.iter().map(|size| ROUNDING * size).collect()
    }

    fn evaluations(&self) -> usize {
        self.evaluations
    }

    /// Phases a period of the load apart are one: a branch that has come round is closed.
    fn chord(&self, from: &[f64], to: &[f64]) -> Vector {
        let apart = to.iter().zip(from).zip(&self.units);
        let mut chord: Vector = apart.map(|((to, from), unit)| (to - from) / unit).collect();
        if self.forced {
            let place = self.size - self.rigid - 1;
            let turn = self.load_period / self.units[place];
            chord[place] -= turn * (chord[place] / turn).round();
        }
        chord
    }

    /// At the resonance of a mode that nothing damps the equations have a pole; where an orbit is its own mirror image others branch off, and where
    /// these come to one they go on as their own mirror images.
    fn may_turn(&self, (from, _): (&ContactOrbit, f64), (to, _): (&ContactOrbit, f64)) -> bool {
        let turns = |orbit: &ContactOrbit| -> Vec<f64> {
            let period = orbit.period() / std::f64::consts::TAU;
            let undamped = orbit.model().structure().modes().iter().filter_map(LinearMode::resonant_frequency);
            undamped.map(|frequency| (frequency * period).floor()).collect()
        };
        turns(from) != turns(to) || is_own_image(from) && is_own_image(to) || from.is_across(to)
    }
}

impl Branch {
    /// The branch through an orbit, as the one number of `family` goes on from `value`; a length of `unit` along it counts like a change of
    /// order 1 of the orbit.
    ///
    /// # Errors
    /// [`BranchError::Model`] where there is no such model.
    pub fn through(
        orbit: &ContactOrbit,
        family: ModelFamily,
        value: f64,
        unit: f64,
        stop: &Stop,
    ) -> Result<Self, BranchError> {
        Ok(Self { equations: Continuation::through(orbit, family, &[value], &[unit], stop)? })
    }

    /// The same among orbits with these symmetries of the orbit: it passes the points where others branch off that lack one.
    pub(crate) fn among_symmetric(
        orbit: &ContactOrbit,
        symmetries: &[Symmetry],
        family: ModelFamily,
        (value, unit): (f64, f64),
        stop: &Stop,
    ) -> Result<Self, BranchError> {
        let among = |orbit: &ContactOrbit, equations: &Equations<'_>| {
            Reduction::among(orbit, equations, symmetries.iter().cloned()).into_iter().collect()
        };
        let whole = Continuation::among_all(orbit, family, &[value], &[unit], stop)?;
        Ok(Self { equations: whole.kept_to(orbit, &[value], among)? })
    }

    /// The same point, with impulses measured by so many times what they were from here on: of a branch along which they grow without bound,
    /// equal steps are then equal factors, where they would be equal differences for ever.
    pub(crate) fn rescaled(&mut self, point: BranchPoint, by: f64) -> BranchPoint {
        let before = self.equations.units.clone();
        self.equations.rescale(by);
        let own = before.iter().zip(&self.equations.units);
        let tangent = point.tangent.iter().zip(own).map(|(x, (before, now))| x * before / now);
        BranchPoint { tangent: normed(tangent.collect()), ..point }
    }
}

/// The same equations, each law with a part of its impact's place. Of one impact that nothing drives the law is the impulse times a function of the
/// period: at a fold all its derivatives vanish, and its row, scaled to length 1, would jump from one sign to the other.
fn with_places(mut here: Rows, weight: Option<f64>) -> Rows {
    let Some(weight) = weight else { return here };
    let impacts = here.arrivals.len();
    for i in 0..impacts {
        let law = impacts + i;
        here.rows[law] += weight * here.rows[i];
        here.sizes[law] += weight * here.sizes[i];
        for j in 0..here.jacobian.size() {
            let slope = here.jacobian[(i, j)];
            here.jacobian[(law, j)] += weight * slope;
        }
    }
    here
}

/// Pairs of impacts of which the second feels the first at once: of one contact, or of two that share inertia.
fn bound_pairs(contacts: &[(usize, Barrier)], structure: &ModalStructure) -> Vec<(usize, usize)> {
    let bound = |&(i, j): &(usize, usize)| {
        let (one, other) = (contacts[i].0, contacts[j].0);
        let own = structure.mobility(one, one) * structure.mobility(other, other);
        one == other || structure.mobility(one, other).powi(2) > APART * own
    };
    let count = contacts.len();
    (0..count).flat_map(|i| (i + 1..count).map(move |j| (i, j))).filter(bound).collect()
}

/// After how long the load repeats itself.
fn load_period(equations: &Equations<'_>) -> f64 {
    std::f64::consts::TAU / equations.single().map_or(equations.model.omega(), |(frequency, _)| frequency)
}
