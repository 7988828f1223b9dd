//! The equations of a structure's orbits as a [`System`]: impulses, times, phase and offsets, and numbers of the structure that are free.

use std::fmt;
use std::sync::Arc;

use vibrochain_lattice::{Barrier, ModalStructure, Stop, Turn};

use super::twins::{IMAGE, Twins};
use crate::equations::linear::{Vector, dot};
use crate::error::{BranchError, BreatherError};
use crate::orbit::time_between;
use crate::structures::equations::{Equations, System as Rows};
use crate::structures::error::StructureOrbitError;
use crate::structures::model::StructureModel;
use crate::structures::orbit::{StructureImpact, StructureOrbit};
use crate::structures::point::{Point, Strike};
use crate::tracer::solution_curve::{SolutionCurve, SolutionPoint};
use crate::tracer::system::{Evaluation, System};

/// Impulses are measured by the strongest, and by this part of what a barrier as far as the contact's own would take.
const FAINT: f64 = 0.1;

/// Of a row, as a part of the sizes of its terms.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// What two contacts feel of each other at once, squared and relative, is rounding of the modes below this.
const APART: f64 = 1e-24;

/// How far a number is moved, relative, to see whether it brings losses.
const MOVED: f64 = 1e-3;

/// Models by the values of the numbers that are free; what is wrong with values that have none.
pub type StructureFamily = Arc<dyn Fn(&[f64]) -> Result<StructureModel, String> + Send + Sync>;

/// A point of a structure's branch.
pub type StructureBranchPoint = SolutionPoint<StructureOrbit>;

/// The orbits of one word of a structure as one number of it varies.
pub type StructureBranch = SolutionCurve<StructureContinuation>;

/// The equations of a word's orbits, with as many numbers of the structure free as units are given.
#[derive(Clone)]
pub struct StructureContinuation {
    family: StructureFamily,
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
    /// Mirror images of impacts, which are followed with them.
    twins: Option<Arc<Twins>>,
    /// Of all unknowns, and of the coordinates with the numbers that are free.
    full_units: Vector,
    units: Vector,
    origin: Vector,
    /// After how long the load of the last equations repeats itself.
    load_period: f64,
    stop: Stop,
    evaluations: usize,
}

impl fmt::Debug for StructureContinuation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("StructureContinuation").field("contacts", &self.contacts).field("origin", &self.origin).finish()
    }
}

impl StructureContinuation {
    /// Through an orbit of the model at `values`; `units` are lengths along the numbers that count like a change of order 1 of the orbit.
    ///
    /// # Errors
    /// [`BranchError::Model`] where there is no such model.
    pub fn through(
        orbit: &StructureOrbit,
        family: StructureFamily,
        values: &[f64],
        units: &[f64],
        stop: &Stop,
    ) -> Result<Self, BranchError> {
        let mut whole = Self::among_all(orbit, family, values, units, stop)?;
        let hit = || whole.contacts.iter().map(|one| one.0);
        let mut equations = Equations::new(orbit.model(), whole.force_periods, hit())?;
        equations.left_out = whole.strongest;
        let Some(twins) = Twins::of(orbit, &equations) else { return Ok(whole) };
        let reduced = |full: &[f64]| -> Vector {
            twins.leading().map(|place| full[place]).chain(full[whole.size..].iter().copied()).collect()
        };
        let origin = reduced(&whole.origin);
        // Also where a number moves they must stay what they are.
        for k in 0..=values.len() {
            let mut moved = values.to_vec();
            if let Some(value) = moved.get_mut(k) {
                *value += MOVED * value.abs().max(MOVED);
            }
            let Ok(model) = (whole.family)(&moved) else { continue };
            let there = Equations::new(&model, whole.force_periods, hit())?;
            let point = whole.point(&twins.expand(&origin, there.period()), there.period())?;
            if !twins.are_kept_by(&there.system(&point)?) {
                return Ok(whole);
            }
        }
        (whole.units, whole.origin) = (reduced(&whole.full_units), origin);
        whole.size = twins.size();
        whole.twins = Some(Arc::new(twins));
        Ok(whole)
    }

    /// The same among orbits of any symmetry.
    ///
    /// # Errors
    /// As [`StructureContinuation::through`].
    pub(super) fn among_all(
        orbit: &StructureOrbit,
        family: StructureFamily,
        values: &[f64],
        units: &[f64],
        stop: &Stop,
    ) -> Result<Self, BranchError> {
        let model = orbit.model();
        let hits = || orbit.impacts().iter().map(|impact| impact.contact);
        let equations = Equations::new(model, orbit.force_periods(), hits())?;
        let felt = equations.felt_offsets(orbit.offsets());
        let contacts: Vec<(usize, Barrier)> =
            orbit.impacts().iter().map(|impact| (impact.contact, impact.barrier)).collect();
        let in_order = bound_pairs(&contacts, model.structure());
        let size = |i: &usize| orbit.impacts()[*i].impulse.abs();
        let strongest = (0..orbit.impacts().len()).max_by(|i, j| size(i).total_cmp(&size(j))).unwrap_or(0);
        let most = size(&strongest);
        let impulse_unit = |contact: usize, barrier: Barrier| {
            let place = model.barrier(contact, barrier).unwrap_or(0.0);
            most.max(FAINT * model.omega() * place.abs() / equations.mobility(contact)).max(f64::MIN_POSITIVE)
        };
        let mut own: Vector = orbit.impacts().iter().map(|one| impulse_unit(one.contact, one.barrier)).collect();
        let times = orbit.impacts().len() - 1 + usize::from(equations.has_time());
        own.extend(std::iter::repeat_n(1.0 / model.omega(), times));
        let reach = own[0] * equations.mobility(orbit.impacts()[0].contact) / model.omega();
        own.extend(std::iter::repeat_n(reach, felt.len()));
        let size = own.len();
        own.extend(units.iter().map(|unit| unit.abs().max(f64::MIN_POSITIVE)));
        if !equations.has_time() && (0..values.len()).any(|k| loses_energy(&family, values, k)) {
            return Err(StructureOrbitError::LossWithoutLoad.into());
        }
        if equations.self_excited && (0..values.len()).any(|k| is_idle(&family, values, k)) {
            return Err(StructureOrbitError::NoEffect.into());
        }
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
            twins: None,
            full_units: own.clone(),
            units: own,
            origin,
            load_period: load_period(&equations),
            stop: stop.clone(),
            evaluations: 0,
        })
    }

    /// What part of its place an impact adds to its law, if any.
    fn weight_of_places(&self) -> Option<f64> {
        // ω where this begins: a place times it is a velocity.
        self.self_excited.then(|| 1.0 / self.units[2 * self.contacts.len() - 1])
    }

    /// The model at a value of the one number that is free.
    pub(super) fn model_at(&self, value: f64) -> Option<StructureModel> {
        (self.family)(&[value]).ok()
    }

    /// The model at `z`.
    fn model(&mut self, z: &[f64]) -> Result<StructureModel, BranchError> {
        self.stop.heard().map_err(|stopped| BranchError::Breather(BreatherError::from(stopped)))?;
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
        make: impl FnOnce(&Equations<'_>, Point, Rows) -> Result<T, StructureOrbitError>,
    ) -> Result<T, BranchError> {
        let model = self.model(z)?;
        let mut equations = Equations::new(&model, self.force_periods, self.contacts.iter().map(|one| one.0))?;
        // Where a stiffness vanishes, or a load does, there is no such point.
        let kind = (equations.forced, equations.self_excited, equations.rigid.len());
        if kind != (self.forced, self.self_excited, self.rigid) {
            return Err(StructureOrbitError::OtherUnknowns.into());
        }
        equations.left_out = self.strongest;
        self.load_period = load_period(&equations);
        let point = match &self.twins {
            Some(twins) => self.point(&twins.expand(z, equations.period()), equations.period())?,
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

impl System for StructureContinuation {
    type Orbit = StructureOrbit;
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
        Ok(match &self.twins {
            Some(twins) => twins.rows(&rows),
            None => rows,
        })
    }

    fn evaluate(&mut self, z: &[f64]) -> Result<Evaluation<StructureOrbit, Vector>, BranchError> {
        let (units, periods, weight) = (self.full_units.clone(), self.force_periods, self.weight_of_places());
        let twins = self.twins.clone();
        self.assembled(z, |equations, point, here| {
            let Rows { rows, sizes: mut kept, jacobian: mut matrix, .. } = with_places(here.clone(), weight);
            // Next to a resonance rows are off by what its distance is, all together.
            for doubt in equations.resonant_doubts(&point) {
                kept.iter_mut().zip(&doubt.rows).for_each(|(size, row)| *size += row.abs() / ROUNDING);
            }
            for i in 0..matrix.size() {
                matrix.row_mut(i).iter_mut().zip(&units).for_each(|(entry, unit)| *entry *= unit);
            }
            let orbit = match point.in_time() {
                None => StructureOrbit::as_it_is(equations, periods, (&point, &here))?,
                Some(point) => StructureOrbit::as_it_is(equations, periods, (&point, &equations.system(&point)?))?,
            };
            Ok(match twins {
                None => Evaluation { orbit, rows, matrix, full: None, kept },
                Some(twins) => Evaluation {
                    orbit,
                    rows: twins.rows(&rows),
                    kept: twins.rows(&kept),
                    matrix: twins.matrix(&matrix),
                    full: Some(matrix),
                },
            })
        })
    }

    fn row_errors(&self, here: &Evaluation<StructureOrbit, Vector>) -> Vector {
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
            let place = 2 * self.contacts.len() - 1;
            let turn = self.load_period / self.units[place];
            chord[place] -= turn * (chord[place] / turn).round();
        }
        chord
    }

    /// At the resonance of a mode that nothing damps the equations have a pole; where an orbit is its own mirror image others branch off, and where
    /// these come to one they go on as their own mirror images.
    fn may_turn(&self, (from, _): (&StructureOrbit, f64), (to, _): (&StructureOrbit, f64)) -> bool {
        let turns = |orbit: &StructureOrbit| -> Vec<f64> {
            let period = orbit.period() / std::f64::consts::TAU;
            let free = orbit.model().structure().modes().iter();
            let free = free.filter(|mode| mode.decay == 0.0 && mode.turn == Turn::Circular);
            free.map(|mode| (mode.rate * period).floor()).collect()
        };
        turns(from) != turns(to) || is_own_image(from) && is_own_image(to) || from.is_across(to)
    }
}

impl StructureBranch {
    /// The branch through an orbit, as the one number of `family` goes on from `value`; a length of `unit` along it counts like a change of
    /// order 1 of the orbit.
    ///
    /// # Errors
    /// [`BranchError::Model`] where there is no such model.
    pub fn of_structure(
        orbit: &StructureOrbit,
        family: StructureFamily,
        value: f64,
        unit: f64,
        stop: &Stop,
    ) -> Result<Self, BranchError> {
        Ok(Self { equations: StructureContinuation::through(orbit, family, &[value], &[unit], stop)? })
    }
}

impl StructureOrbit {
    /// Whether what happens half a period later differs from what happens now the other way round than along `other`: between the two is an orbit
    /// that repeats or mirrors itself, if they are neighbours on one branch.
    pub fn is_across(&self, other: &Self) -> bool {
        dot(&self.unevenness(), &other.unevenness()) < 0.0
    }

    /// Whether what an impact does at one barrier its image may do at the other: all of them are as far from 0.
    pub fn is_centred(&self) -> bool {
        self.model().structure().contacts().iter().all(|contact| contact.lower == contact.upper.map(|upper| -upper))
    }

    /// Impulses and flights half the impacts later, less those now, as parts of the strongest and of the period: 0 of an orbit that repeats or
    /// mirrors itself. Where the second half hits the other barriers, and these are not as far away, time alone can mirror it: then of flights
    /// alone. None of an odd number of impacts.
    pub fn unevenness(&self) -> Vec<f64> {
        let (impacts, half) = (self.impacts(), self.impacts().len() / 2);
        if impacts.len() % 2 == 1 {
            return Vec::new();
        }
        let strongest = impacts.iter().map(|impact| impact.impulse.abs()).fold(f64::MIN_POSITIVE, f64::max);
        let end = |i: usize| impacts.get(i + 1).map_or(self.period(), |next| next.time);
        let flight = |i: usize| (end(i) - impacts[i].time) / self.period();
        let (one, other) = impacts.split_at(half);
        let alike = self.is_centred() || one.iter().zip(other).all(|(a, b)| a.barrier == b.barrier);
        let pairs = if alike { half } else { 0 };
        let impulses = (0..pairs).map(|i| (impacts[i + half].impulse.abs() - impacts[i].impulse.abs()) / strongest);
        impulses.chain((0..half).map(|i| flight(i + half) - flight(i))).collect()
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

/// Whether one of the numbers brings losses where it moves.
fn loses_energy(family: &StructureFamily, values: &[f64], which: usize) -> bool {
    [1.0, -1.0].into_iter().any(|sign| {
        let mut moved = values.to_vec();
        moved[which] += sign * MOVED * values[which].abs().max(1.0);
        family(&moved).is_ok_and(|model| !model.structure().is_lossless())
    })
}

/// Whether a self-excited structure is the same wherever one of the numbers moves: ω, which no load has.
fn is_idle(family: &StructureFamily, values: &[f64], which: usize) -> bool {
    let moved = |sign: f64| {
        let mut moved = values.to_vec();
        moved[which] += sign * MOVED * values[which].abs().max(1.0);
        family(&moved)
    };
    matches!([moved(1.0), moved(-1.0)], [Ok(one), Ok(other)] if one.structure() == other.structure())
}

/// Whether half a period later an orbit does the same at the other barriers; or, where time may run backwards, the same.
fn is_own_image(orbit: &StructureOrbit) -> bool {
    let (impacts, period) = (orbit.impacts(), orbit.period());
    let alike = |one: &StructureImpact, other: &StructureImpact, sign: f64, time: f64| {
        one.contact == other.contact
            && (one.barrier == other.barrier) == (sign > 0.0)
            && time_between(other.time, time, period) <= IMAGE * period
            && (one.impulse - sign * other.impulse).abs() <= IMAGE * one.impulse.abs()
    };
    let holds = |sign: f64, of: &dyn Fn(f64) -> f64| {
        impacts.iter().all(|one| impacts.iter().any(|other| alike(one, other, sign, of(one.time))))
    };
    holds(-1.0, &|time| time + 0.5 * period)
        || orbit.is_conservative() && impacts.iter().any(|about| holds(1.0, &|time| about.time - time))
}
