//! The periodic kernel: what contacts do after an impulse that repeats every period.
//!
//! A regular mode has ξ(t) = e^{At}(1−R)⁻¹c, R = e^{AT}. A rigid one has none: its kernel here is that of the impulse together with a
//! constant pull −1/T that balances it, and the condition that all impulses balance the static load makes the pulls cancel against it.
//!
//! ```text
//! rigid:                k = t/2 − t²/2T
//! with a dashpot c:     k = [ h(ct)/h(cT) − 1 ] t/cT,    h(x) = (1−e^{−x})/x
//! ```

mod rigid;
mod sum;
mod turning_modes;

use std::sync::Arc;

use vibrochain_lattice::{LinearMode, ParticipatingModes, Turn, Turned};

use rigid::rigid_by_period;
pub(crate) use rigid::rigid_jet;
pub(super) use sum::{Jet, Sum, UNIT, one_less};
pub(crate) use sum::{inverse, length};
use turning_modes::TurningModes;

/// From here on 1 − R is rounding: the period is a whole number of the mode's own.
const RESONANT: f64 = 1e14;

/// A part of a contact's mobility that is rounding: a contact at a node of the mode.
const UNSEEN: f64 = 1e-12;

/// The kernel and its derivatives, from contacts that are hit to all.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct PeriodicKernel {
    pub(super) period: f64,
    /// The modes as the impacts feel them, and the sums of the regular ones.
    pub(super) felt: Arc<ParticipatingModes>,
    sums: Vec<Option<Sum>>,
    /// Those of the modes that turn, between contacts that are hit.
    turning: TurningModes,
    /// The rigid modes of the structure, as they are: each has an offset.
    rigid: Vec<LinearMode>,
    /// From each contact that is hit to itself, a period later; and where one alone is hit without losses, half a period later.
    own: Vec<(usize, Jet)>,
    half: Option<Jet>,
}

/// What changes a number in size, and what turns it.
pub(super) const EITHER_WAY: [Turned; 2] = [Turned { even: 1.0, odd: 0.0 }, Turned { even: 0.0, odd: 1.0 }];

impl PeriodicKernel {
    pub(super) fn new(modes: &[LinearMode], felt: Arc<ParticipatingModes>, hit: &[usize], period: f64) -> Self {
        let sums = felt.modes.iter().map(|mode| Sum::of(mode, period)).collect();
        let rigid = modes.iter().filter(|mode| mode.is_rigid()).cloned().collect();
        let mut kernel =
            Self { period, felt, sums, turning: TurningModes::default(), rigid, own: Vec::new(), half: None };
        kernel.know(hit);
        kernel
    }

    /// Works out what all orbits of impacts at these contacts ask for.
    fn know(&mut self, hit: &[usize]) {
        self.turning = TurningModes::of(self.sums_of(), hit);
        self.own = hit.iter().map(|&contact| (contact, self.jet(contact, contact, self.period))).collect();
        if let [contact] = *hit
            && self.felt.of_one.is_some()
        {
            self.half = Some(self.jet(contact, contact, 0.5 * self.period));
        }
    }

    /// The kernel without some of the regular modes, by their places among these.
    pub(super) fn without(&self, places: &[usize]) -> Self {
        let mut kernel = self.clone();
        let regular = kernel.sums.iter_mut().filter(|sum| sum.is_some()).enumerate();
        regular.filter(|(place, _)| places.contains(place)).for_each(|(_, sum)| *sum = None);
        let hit: Vec<usize> = std::mem::take(&mut kernel.own).into_iter().map(|(contact, _)| contact).collect();
        kernel.half = None;
        kernel.know(&hit);
        kernel
    }

    /// Whether none of the modes that are felt is left out.
    pub(super) fn is_whole(&self) -> bool {
        self.felt.modes.iter().zip(&self.sums).all(|(mode, sum)| sum.is_some() || mode.is_rigid())
    }

    /// Whether nothing holds the structure somewhere.
    pub(super) fn has_rigid(&self) -> bool {
        !self.rigid.is_empty()
    }

    /// The rigid modes, in the order of the structure's.
    pub(super) fn rigid(&self) -> &[LinearMode] {
        &self.rigid
    }

    /// The regular modes that are felt, with (1−R)⁻¹.
    pub(super) fn regular(&self) -> impl Iterator<Item = (&LinearMode, Turned)> + Clone {
        self.sums_of().map(|(mode, sum)| (mode, sum.sum))
    }

    pub(super) fn sums_of(&self) -> impl Iterator<Item = (&LinearMode, &Sum)> + Clone {
        self.felt.modes.iter().zip(&self.sums).filter_map(|(mode, sum)| Some((mode, sum.as_ref()?)))
    }

    /// The largest rate |λ| of a mode that is felt.
    pub(super) fn fastest(&self) -> f64 {
        self.sums_of().map(|(_, sum)| sum.fast).fold(0.0, f64::max)
    }

    /// The number of the first mode that impacts of these contacts would drive without bound.
    pub(super) fn resonant(&self, contacts: &[usize]) -> Option<usize> {
        let seen =
            |mode: &LinearMode, contact: usize| mode.rate * length(mode.rows[contact]) * length(mode.columns[contact]);
        let drives = |mode: &LinearMode, contact: usize| {
            let all: f64 = self.felt.modes.iter().map(|other| seen(other, contact)).sum();
            seen(mode, contact) > UNSEEN * all
        };
        let place = self.felt.modes.iter().zip(&self.sums).position(|(mode, sum)| {
            sum.is_some_and(|sum| sum.steep >= RESONANT) && contacts.iter().any(|contact| drives(mode, *contact))
        });
        place.map(|place| self.felt.numbers[place])
    }

    /// The kernel at −T < t ≤ T, for t ≤ 0 the past impulses alone: K(t+T).
    pub(super) fn jet(&self, to: usize, from: usize, t: f64) -> Jet {
        if t == 0.0
            && to == from
            && let Some((_, jet)) = self.own.iter().find(|(contact, _)| *contact == to)
        {
            return *jet;
        }
        if let Some(jet) = self.half
            && t.abs() == 0.5 * self.period
            && to == from
            && self.own.iter().any(|(contact, _)| *contact == to)
        {
            return jet;
        }
        let t = if t > 0.0 { t } else { t + self.period };
        let turned = self.turning.jet((to, from), t);
        // Those that turn are in it, if there is one.
        let left = self.sums_of().filter(|(mode, _)| turned.is_none() || !TurningModes::holds(mode));
        let (mut jet, mut sizes) = turned.unwrap_or_default();
        let flights = Turn::flights(left.clone().map(|(mode, _)| mode.flow()), t);
        for ((mode, sum), flight) in left.zip(flights) {
            let (row, column, turn) = (mode.rows[to], mode.columns[from], mode.turn);
            let (reach, doubt) = (length(row) * length(column), mode.errors_between(to, from));
            if reach == 0.0 && doubt == 0.0 {
                continue;
            }
            let mut motion = turn.product(flight, sum.sum);
            let mut size = (reach * (1.0 + sum.blur) + doubt / UNIT) * length([motion.even, motion.odd]);
            for (order, entry) in jet.iter_mut().enumerate() {
                *entry += turn.pair(row, motion, column);
                motion = turn.product(motion, mode.generator());
                sizes[order] += size;
                size *= sum.fast;
            }
        }
        for mode in &self.rigid {
            let shapes = mode.rows[to][0] * mode.columns[from][1] * mode.rate;
            let size = shapes.abs() + mode.errors_between(to, from) * mode.rate / UNIT;
            for (order, own) in rigid_jet(mode.decay, self.period, t).into_iter().enumerate() {
                jet[order] += shapes * own;
                sizes[order] += size * own.abs();
            }
        }
        (jet, sizes)
    }

    /// Modes next to a resonance, by their place among the regular ones, and the relative error of their (1−R)⁻¹.
    pub(super) fn nearly_resonant(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        let near =
            |(place, (_, sum)): (usize, (&LinearMode, &Sum))| (sum.blur < sum.steep).then_some((place, sum.steep));
        self.sums_of().enumerate().filter_map(near).map(|(place, steep)| (place, f64::EPSILON * steep))
    }

    /// Modes that oscillate and do not grow with |1 − R| below this, by their place among the regular ones, and its inverse.
    pub(super) fn within(&self, distance: f64) -> impl Iterator<Item = (usize, f64)> + '_ {
        let swings = |mode: &LinearMode| mode.turn == Turn::Circular && mode.decay >= 0.0;
        let away = |mode: &LinearMode| {
            let less = one_less(mode.flow(), self.period);
            length([less.even, less.odd])
        };
        let modes = self.regular().map(|(mode, _)| mode).enumerate();
        let near = move |(place, mode): (usize, &LinearMode)| {
            (swings(mode) && away(mode) < distance).then(|| (place, away(mode).recip()))
        };
        modes.filter_map(near)
    }

    /// What one regular mode has of the kernel and its first three derivatives at −T < t ≤ T, (1−R)⁻¹ times a number.
    pub(super) fn jet_of_mode(&self, place: usize, by: Turned, (to, from): (usize, usize), t: f64) -> [f64; 4] {
        let mut jet = [0.0; 4];
        let t = if t > 0.0 { t } else { t + self.period };
        for (mode, sum) in self.sums_of().skip(place).take(1) {
            let mut motion = mode.turn.product(mode.turn.flight(mode.decay, mode.rate, t), sum.sum);
            motion = mode.turn.product(motion, by);
            for entry in &mut jet {
                *entry = mode.turn.pair(mode.rows[to], motion, mode.columns[from]);
                motion = mode.turn.product(motion, mode.generator());
            }
        }
        jet
    }

    /// Derivatives by the period of the kernel and its first two derivatives, at −T < t < T as [`Self::jet`] takes it: the impulses of n periods
    /// ago are n times as much later.
    ///
    /// ```text
    /// Σ nA e^{A(t+nT)} = e^{A(t+T)}A(1−R)⁻²
    /// ```
    pub(super) fn by_period(&self, to: usize, from: usize, t: f64) -> [f64; 3] {
        let mut slopes = [0.0; 3];
        let flights = Turn::flights(self.sums_of().map(|(mode, _)| mode.flow()), t + self.period);
        for ((mode, sum), flight) in self.sums_of().zip(flights) {
            let (row, column, turn) = (mode.rows[to], mode.columns[from], mode.turn);
            let mut motion = turn.product(turn.product(flight, sum.sum), sum.sum);
            for entry in &mut slopes {
                motion = turn.product(motion, mode.generator());
                *entry += turn.pair(row, motion, column);
            }
        }
        for mode in &self.rigid {
            let shapes = mode.rows[to][0] * mode.columns[from][1] * mode.rate;
            let own = rigid_by_period(mode.decay, self.period, t);
            slopes.iter_mut().zip(own).for_each(|(entry, own)| *entry += shapes * own);
        }
        slopes
    }
}
