//! A structure under its loads: what stays the same during a run.

use std::sync::{Arc, OnceLock};

use crate::flight::loads::{Answer, Loads, add};
use crate::flight::local::{FlightChoice, Local};
use crate::time::two_sum;
use vibrochain_lattice::{Barrier, Complex, Contact, LinearMode, ModalStructure, Model, SparseOperator};

type C = Complex<f64>;

/// Mobility of two contacts below this part of its terms is rounding: they share no coordinate.
const ROUNDING: f64 = 1e-13;

/// Units of the fastest rate in a window: so many certified steps at most pass between two looks at limits, some milliseconds.
const LONGEST: f64 = 1e5;

/// A mode that feeds itself has diverged once it is so often as large as barriers, loads and start make it: no picture shows the stops any
/// more, and between two of them there would be ever more impacts a period. What impacts bound stays far below that: v/2d impacts in unit
/// time take 1 − e² of the energy each, so v/d settles at the order of growth over 1 − e².
const BEYOND_USE: f64 = 1e4;

/// One damped sine or one sine that contacts are made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Term {
    /// A mode, with the loads that it answers from rest.
    Mode(usize),
    /// The steady motion under a load.
    Load(usize),
}

/// The structure and what follows from it.
#[derive(Debug, Clone)]
pub(crate) struct System {
    /// Its modes; none of coordinates that are known by what pulls at them alone.
    pub(crate) structure: Option<Arc<ModalStructure>>,
    pub(crate) omega: f64,
    pub(crate) loads: Loads,
    /// The structure by its coordinates, where it flies by these.
    pub(crate) local: Option<Arc<Local>>,
    /// All terms, slow ones first.
    pub(crate) terms: Vec<Term>,
    /// Steady motion of each contact under each load.
    pub(crate) swings: Vec<Vec<C>>,
    /// g of each contact where the static load holds its modes, from which places are measured.
    pub(crate) origins: Vec<f64>,
    /// The contacts' barriers as they are measured from there.
    stops: Vec<Contact>,
    /// Of each contact those that share a coordinate with it, rising, once it is asked for: of a thousand contacts all of it takes seconds.
    mobility: Vec<OnceLock<Vec<(usize, f64)>>>,
    /// Itself and wᵀM⁻¹w of each contact, where contact n sees coordinate n as it is and by local series: none shares one.
    apart: Vec<(usize, f64)>,
    /// What rounding took from each contact's own, relative to it: the same at every impact, it would add up.
    lost: Vec<f64>,
    /// Largest rate of a mode or of a load.
    pub(crate) fastest: f64,
    /// Longest flight between two bases: a period, the time in which a self-excited mode grows by e, or [`LONGEST`].
    pub(crate) longest: f64,
}

impl System {
    pub(crate) fn new(structure: Arc<ModalStructure>, omega: f64, psi: f64) -> Self {
        let loads = Loads::new(&structure, omega, psi);
        let (modes, contacts) = (structure.modes(), structure.contacts().len());
        let rate = |mode: &LinearMode| mode.rates().map(|rate| rate.norm()).into_iter().fold(0.0, f64::max);
        let rate_of = |term: &Term| match *term {
            Term::Mode(k) => rate(&modes[k]),
            Term::Load(j) => loads.rates[j],
        };
        let mut terms: Vec<Term> = (0..modes.len()).map(Term::Mode).collect();
        terms.extend((1..loads.rates.len()).map(Term::Load));
        terms.sort_by(|a, b| rate_of(a).total_cmp(&rate_of(b)));
        let fastest = terms.iter().map(rate_of).fold(0.25 * omega, f64::max);
        let growth = modes.iter().flat_map(|mode| mode.rates().map(|rate| rate.re)).fold(0.0, f64::max);
        let swing = |contact: usize, j: usize| {
            let of_mode = |(mode, answers): (&LinearMode, &Vec<Answer>)| match answers[j] {
                Answer::Steady(xi) => xi[0] * mode.rows[contact][0] + xi[1] * mode.rows[contact][1],
                _ => C::default(),
            };
            modes.iter().zip(&loads.answers).map(of_mode).sum::<C>()
        };
        let swings = (0..contacts).map(|i| (0..loads.rates.len()).map(|j| swing(i, j)).collect()).collect();
        let held = |contact: usize| {
            let terms = modes.iter().zip(&loads.equilibrium);
            terms.map(|(mode, xi)| mode.rows[contact][0] * xi[0] + mode.rows[contact][1] * xi[1]).sum::<f64>()
        };
        let origins: Vec<f64> = (0..contacts).map(held).collect();
        let moved = |(contact, by): (&Contact, &f64)| {
            let [lower, upper] = [contact.lower, contact.upper].map(|place| place.map(|place| place - by));
            Contact { lower, upper, ..*contact }
        };
        let stops = structure.contacts().iter().zip(&origins).map(moved).collect();
        let mobility = vec![OnceLock::new(); contacts];
        let lost = (0..contacts).map(|contact| lost(&structure, contact)).collect();
        let longest = (std::f64::consts::TAU / omega).min(1.0 / growth).min(LONGEST / fastest);
        let (apart, local, structure) = (Vec::new(), None, Some(structure));
        Self { terms, swings, origins, stops, mobility, apart, lost, fastest, longest, omega, loads, local, structure }
    }

    /// The masses of a chain, under its force at a phase.
    pub(crate) fn of_chain(model: &Model, psi: f64) -> Self {
        let harmonics = model.force().harmonics().iter().filter(|harmonic| harmonic.amplitude != 0.0);
        let numbers: Vec<u32> = harmonics.map(|harmonic| harmonic.number).collect();
        Self::of_operator(model.operator(), model.stop(), &numbers, (model.omega(), psi))
    }

    /// The system of coordinates given by their operator, without modes: the same stops at each, under loads of these harmonics.
    fn of_operator(operator: SparseOperator, stop: Contact, harmonics: &[u32], (omega, psi): (f64, f64)) -> Self {
        let loads = Loads::of_harmonics(harmonics, omega, psi);
        let driven = loads.rates.iter().copied().fold(0.0, f64::max);
        let fastest = Local::rate(&operator).max(driven).max(0.25 * omega);
        let stops = vec![stop; operator.contacts.len()];
        let (origins, lost) = (vec![0.0; stops.len()], Vec::new());
        let longest = (std::f64::consts::TAU / omega).min(LONGEST / fastest);
        let system = Self {
            structure: None,
            omega,
            loads,
            local: None,
            terms: Vec::new(),
            swings: Vec::new(),
            origins,
            stops,
            mobility: Vec::new(),
            apart: Vec::new(),
            lost,
            fastest,
            longest,
        };
        system.by_coordinates(Arc::new(operator))
    }

    /// The same by local series, if these are faster.
    pub(crate) fn local_if_faster(self) -> Self {
        let known = self.structure.as_ref().filter(|_| self.choice().is_local());
        match known.and_then(|structure| structure.operator().cloned()) {
            Some(operator) => self.by_coordinates(operator),
            None => self,
        }
    }

    /// How it flies.
    pub(crate) fn choice(&self) -> FlightChoice {
        match (&self.structure, &self.local) {
            (None, Some(local)) => FlightChoice::of_operator(&local.operator, self.fastest),
            (Some(structure), _) => FlightChoice::new(structure, (self.omega, self.fastest)),
            (None, None) => FlightChoice { local: None, modal: None },
        }
    }

    fn by_coordinates(mut self, operator: Arc<SparseOperator>) -> Self {
        let is_own = |(n, weights): (usize, &Vec<(usize, f64)>)| weights[..] == [(n, 1.0)];
        if operator.contacts.len() == operator.masses.len() && operator.contacts.iter().enumerate().all(is_own) {
            self.apart = operator.masses.iter().enumerate().map(|(n, mass)| (n, 1.0 / mass)).collect();
        }
        self.local = Some(Arc::new(Local::new(operator, self.modes(), &self.loads, self.fastest)));
        // Mobility of coordinates is no sum of modes.
        self.lost.clear();
        self
    }

    /// Whether contact n sees coordinate n as it is, and there is one of each.
    pub(crate) fn is_direct(&self) -> bool {
        !self.apart.is_empty()
    }

    pub(crate) fn modes(&self) -> &[LinearMode] {
        self.structure.as_ref().map_or(&[], |structure| structure.modes())
    }

    /// Modes, or coordinates where no modes are known: what a step is over, and how many pairs of numbers a state has.
    pub(crate) fn size(&self) -> usize {
        self.structure.as_ref().map_or(self.stops.len(), |structure| structure.modes().len())
    }

    /// The barriers of a contact where they are.
    pub(crate) fn limits(&self, contact: usize) -> Contact {
        self.structure.as_ref().map_or(self.stops[contact], |structure| structure.contacts()[contact])
    }

    /// Whether small perturbations of a run of one are perturbations of one of the other: all is alike but loads.
    pub(crate) fn is_alike(&self, other: &Self) -> bool {
        let is_alike = |(a, b): (&LinearMode, &LinearMode)| {
            (a.decay, a.rate, a.turn) == (b.decay, b.rate, b.turn) && a.rows == b.rows
        };
        match (&self.structure, &other.structure, &self.local, &other.local) {
            (Some(own), Some(other), ..) => {
                own.contacts() == other.contacts()
                    && own.modes().len() == other.modes().len()
                    && own.modes().iter().zip(other.modes()).all(is_alike)
            }
            (None, None, Some(own), Some(other_local)) => {
                let (own, of_other) = (&own.operator, &other_local.operator);
                self.stops == other.stops && own.masses == of_other.masses && own.pulls == of_other.pulls
            }
            _ => false,
        }
    }

    pub(crate) fn restitution(&self, contact: usize) -> f64 {
        self.stops[contact].restitution
    }

    /// Of each mode the largest coordinate that is of use in a run from ξ, as it is measured here; infinite where it does not feed itself.
    pub(crate) fn reach(&self, start: &[[f64; 2]]) -> Vec<f64> {
        let (modes, largest) = (self.modes(), |xi: &[f64; 2]| xi[0].abs().max(xi[1].abs()));
        let barriers: Vec<(usize, f64)> = (self.stops.iter().enumerate())
            .flat_map(|(i, contact)| [contact.lower, contact.upper].into_iter().flatten().map(move |at| (i, at.abs())))
            .collect();
        let seen = |mode: &LinearMode, contact: usize| mode.rows[contact][0].hypot(mode.rows[contact][1]);
        let all = |contact: usize| modes.iter().map(|mode| seen(mode, contact)).fold(0.0, f64::hypot);
        let responses = modes.iter().enumerate().map(|(k, mode)| self.loads.response(mode, k, self.omega));
        let usual = (start.iter().chain(&self.loads.equilibrium).map(largest).chain(responses))
            .chain(barriers.iter().map(|&(i, at)| at / all(i)).filter(|reach| reach.is_finite()))
            .fold(0.0, f64::max);
        let of_mode = |mode: &LinearMode| {
            if mode.rates().iter().all(|rate| rate.re <= 0.0) || usual == 0.0 {
                return f64::INFINITY;
            }
            // How large the mode must be to reach a stop without the others. A slow mode takes a larger coordinate for the same velocity.
            let alone = barriers.iter().filter(|(i, _)| seen(mode, *i) > 0.0).map(|&(i, at)| at / seen(mode, i));
            BEYOND_USE * alone.reduce(f64::min).unwrap_or(0.0).max(usual) * (self.fastest / mode.rate).max(1.0)
        };
        modes.iter().map(of_mode).collect()
    }

    pub(crate) fn period(&self) -> f64 {
        std::f64::consts::TAU / self.omega
    }

    pub(crate) fn contacts(&self) -> usize {
        self.stops.len()
    }

    /// A barrier as places are measured.
    pub(crate) fn barrier(&self, contact: usize, barrier: Barrier) -> Option<f64> {
        self.stops[contact].barrier(barrier)
    }

    /// ξ of all modes of the structure, from where the static load holds them.
    pub(crate) fn about_equilibrium(&self, xi: &[[f64; 2]]) -> Vec<[f64; 2]> {
        xi.iter().zip(&self.loads.equilibrium).map(|(xi, held)| [xi[0] - held[0], xi[1] - held[1]]).collect()
    }

    /// ξ of all modes of the structure again.
    pub(crate) fn absolute(&self, xi: &[[f64; 2]]) -> Vec<[f64; 2]> {
        xi.iter().zip(&self.loads.equilibrium).map(|(xi, held)| add(*xi, *held)).collect()
    }

    /// w_iᵀM⁻¹w_j; 0 where they share no coordinate.
    pub(crate) fn mobility(&self, to: usize, from: usize) -> f64 {
        let sharing = self.sharing(from);
        sharing.binary_search_by_key(&to, |(other, _)| *other).map_or(0.0, |i| sharing[i].1)
    }

    /// The contacts j that share a coordinate with contact `from`, itself among them, and wᵀM⁻¹w_j of each.
    pub(crate) fn sharing(&self, from: usize) -> &[(usize, f64)] {
        if let Some(alone) = self.apart.get(from) {
            return std::slice::from_ref(alone);
        }
        self.mobility[from].get_or_init(|| self.mobility_from(from))
    }

    fn mobility_from(&self, from: usize) -> Vec<(usize, f64)> {
        let to = |to: usize| {
            if let Some(local) = &self.local {
                return local.operator.mobility(to, from);
            }
            let mobility = self.structure.as_ref().map_or(0.0, |structure| structure.mobility(to, from));
            // Of complex shapes that nearly meet the terms are larger than the sum.
            let size = self.modes().iter().map(|mode| {
                let given = mode.turn.act(mode.generator(), mode.columns[from]);
                (mode.rows[to][0] * given[0]).abs() + (mode.rows[to][1] * given[1]).abs()
            });
            if mobility.abs() <= ROUNDING * size.sum::<f64>() { 0.0 } else { mobility }
        };
        (0..self.contacts()).map(|other| (other, to(other))).filter(|(_, mobility)| *mobility != 0.0).collect()
    }

    /// The impulse that changes the velocity of a contact.
    pub(crate) fn impulse(&self, contact: usize, change: f64) -> f64 {
        let mobility = self.mobility(contact, contact);
        let impulse = change / mobility;
        // Both corrections at once: each alone is below half a unit in the last place.
        let lost = self.lost.get(contact).copied().unwrap_or(0.0);
        impulse + (impulse.mul_add(-mobility, change) / mobility - impulse * lost)
    }

    /// Modes and what each sees of contact `contact`.
    pub(crate) fn seen_by(&self, contact: usize) -> impl Iterator<Item = (usize, &LinearMode, [f64; 2])> {
        self.modes().iter().enumerate().map(move |(k, mode)| (k, mode, mode.rows[contact]))
    }

    /// Impulses at contacts that change their velocities by `changes`, all together. Contacts of which one follows from others get 0.
    pub(crate) fn impulses(&self, contacts: &[usize], changes: &[f64]) -> Vec<f64> {
        let r = contacts.len();
        let is_apart = |i: &usize| contacts.iter().all(|j| i == j || self.mobility(*i, *j) == 0.0);
        if self.is_direct() || contacts.iter().all(is_apart) {
            let alone = contacts.iter().zip(changes).map(|(&contact, change)| change / self.mobility(contact, contact));
            return alone.collect();
        }
        let mut rows: Vec<Vec<f64>> = (0..r)
            .map(|i| (0..r).map(|j| self.mobility(contacts[i], contacts[j])).chain([changes[i]]).collect())
            .collect();
        let mut is_used = vec![false; r];
        let mut pivots = Vec::with_capacity(r);
        for _ in 0..r {
            // Mobility is symmetric and not negative: the largest diagonal entry is the pivot.
            let best = (0..r).filter(|&i| !is_used[i]).max_by(|&i, &j| rows[i][i].total_cmp(&rows[j][j]));
            let Some(p) = best else { break };
            is_used[p] = true;
            if rows[p][p] <= ROUNDING * self.mobility(contacts[p], contacts[p]) {
                continue;
            }
            pivots.push(p);
            let pivot = rows[p].clone();
            for i in (0..r).filter(|&i| i != p) {
                let factor = rows[i][p] / pivot[p];
                rows[i].iter_mut().zip(&pivot).for_each(|(entry, above)| *entry -= factor * above);
            }
        }
        let mut impulses = vec![0.0; r];
        pivots.iter().for_each(|&p| impulses[p] = rows[p][r] / rows[p][p]);
        impulses
    }
}

/// wᵀM⁻¹w of a contact in two words: what the first is short of, relative to it.
fn lost(structure: &ModalStructure, contact: usize) -> f64 {
    let mobility = structure.mobility(contact, contact);
    let (mut high, mut low) = (-mobility, 0.0);
    for mode in structure.modes() {
        let ([r, s], [a, b], by) = (mode.rows[contact], mode.columns[contact], mode.generator());
        // row·(even + odd J)·column; of real shape, and as impulses are given, row².
        let terms = [(by.even, r, a), (by.odd, r, b), (by.even, s, b), (-mode.turn.sign() * by.odd, s, a)];
        let terms = if mode.is_real { [(1.0, r, r), (0.0, r, a), (0.0, s, b), (0.0, s, a)] } else { terms };
        for (x, y, z) in terms {
            let product = x * z;
            let whole = y * product;
            let rest = y.mul_add(product, -whole) + y * x.mul_add(z, -product);
            let (sum, error) = two_sum(high, whole);
            (high, low) = (sum, low + error + rest);
        }
    }
    (high + low) / mobility
}
