//! Coordinates in flight by local series, from a base.

use std::ops::Range;
use std::sync::Arc;

use crate::flight::loads::Loads;
use crate::flight::local::{Held, Local, LocalSeries};
use crate::flight::near::Tendencies;
use crate::flight::places::{FORGET, Place, Places};
use crate::flight::rest_series::LOW;
use crate::flight::system::System;
use crate::series::bound::{self, Group, TAIL};
use crate::series::part::{Pace, Part};
use crate::series::weights::Weights;
use crate::series::{CORRECTED, LANES, Rows, eight};
use crate::units::{MAX_ORDER, ORDERS, spread};
use crate::watch::{self, Contact, Watch};
use vibrochain_lattice::{Barrier, Complex};
use wide::f64x8;

/// Coordinates at the base, and their series from there.
#[derive(Debug, Clone)]
pub(crate) struct LocalFlight {
    pub(crate) local: Arc<Local>,
    /// e^{iw(t+ψ)} of each load at the base, and where series have begun last.
    pub(crate) turned: Vec<Complex<f64>>,
    pub(crate) now: Vec<Complex<f64>>,
    /// Of each coordinate, at the origin of its series: q = `reference` + x, from where the static load holds it, and q′, in internal time.
    ///
    /// Near a barrier that stops the coordinate itself the reference is that barrier: x is then the distance to it, and a mass that leaves at 1e-13
    /// and comes back at once has its flight to full RELATIVE accuracy, which q could not hold.
    pub(crate) x: Vec<f64>,
    pub(crate) velocity: Vec<f64>,
    pub(crate) reference: Vec<f64>,
    pub(crate) series: LocalSeries,
    /// Origins since the base, internal; `moved` lists those that are not 0.
    pub(crate) origin: Vec<f64>,
    pub(crate) moved: Vec<usize>,
    /// Coordinates that leave a barrier, and what rounding took from their series; of few, all.
    pub(crate) lost: Vec<(usize, [f64; CORRECTED])>,
    pub(crate) part_rows: Rows,
    /// Parts that restart.
    pub(crate) parts: Vec<Part>,
    /// Length of the window, internal, since the base.
    pub(crate) horizon: f64,
    pub(crate) pace: Pace,
    /// The share of all masses that an event restarts, of each order, if these are few.
    touched: [Option<f64>; ORDERS.len()],
    next: [Vec<f64>; 2],
    /// Bounds of eight coordinates each over the window.
    groups: Vec<Group>,
    /// Lower and upper barriers of all contacts, from where the static load holds them; infinite where there is none.
    pub(crate) limits: [Vec<f64>; 2],
    /// Contact n sees coordinate n as it is, and there is one of each.
    pub(crate) is_direct: bool,
}

/// From so many coordinates on weights are not held in two words: an event restarts a part, as a rule, at instants that do not repeat.
const LARGE: usize = 64;

/// Of so few coordinates the rounding errors of all repeat with every impact, not only those of the one that leaves a barrier.
const FEW: usize = 4;

/// A contact is cleared if its bounds stay this part of its way from the barriers: the rounding of sums, many times.
const CLEARANCE: f64 = 64.0 * f64::EPSILON;

/// What a contact does over a window at most: it rises, falls, and bends.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Sweep {
    pub(crate) rise: f64,
    pub(crate) fall: f64,
    pub(crate) bend_up: f64,
    pub(crate) bend_down: f64,
}

/// Sets d_0 and d_1 of columns from `first` on to what coordinates have.
pub(crate) fn begin_rows([x, reference, velocity]: [&[f64]; 3], rows: &mut Rows, first: usize, range: Range<usize>) {
    let (places, velocities) = rows.data[first + 1..].split_at_mut(rows.stride);
    let whole = x[range.clone()].iter().zip(&reference[range.clone()]);
    places.iter_mut().zip(whole).for_each(|(to, (x, reference))| *to = x + reference);
    velocities[..range.len()].copy_from_slice(&velocity[range]);
}

impl Held {
    fn new(system: &System, local: &Local, places: &Places) -> Self {
        let barrier = |contact: &usize| match places[*contact].touch {
            Contact::Resting(barrier) => Some((*contact, barrier)),
            _ => None,
        };
        let contacts: Vec<(usize, Barrier)> = places.resting().iter().filter_map(barrier).collect();
        if system.is_direct() || contacts.is_empty() {
            return Self { contacts, inverse: Vec::new(), is_plain: true };
        }
        let numbers = places.resting();
        let is_apart = |i: &usize| numbers.iter().all(|j| i == j || system.mobility(*i, *j) == 0.0);
        let inverse: Vec<Vec<f64>> = if numbers.iter().all(is_apart) {
            numbers.iter().map(|&contact| vec![1.0 / system.mobility(contact, contact)]).collect()
        } else {
            let unit = |i: usize| (0..numbers.len()).map(|j| f64::from(u8::from(i == j))).collect::<Vec<_>>();
            (0..numbers.len()).map(|i| system.impulses(numbers, &unit(i))).collect()
        };
        let is_plain = inverse.iter().all(|row| row.len() == 1)
            && numbers.iter().all(|&contact| local.operator.contacts[contact].len() == 1);
        Self { contacts, inverse, is_plain }
    }
}

impl LocalFlight {
    /// From ξ, at a time within a period.
    pub(crate) fn of_modes(system: &System, local: Arc<Local>, xi: &[[f64; 2]], offset: f64) -> Self {
        let turned = system.loads.turned(offset);
        let n = local.operator.masses.len();
        let (mut place, mut velocity) = (vec![0.0; n], vec![0.0; n]);
        for (k, (mode, xi)) in system.modes().iter().zip(xi).enumerate() {
            let (rise, given) = (mode.turn.act(mode.generator(), *xi), system.loads.given(k, &turned));
            for (i, row) in mode.coordinates.iter().enumerate() {
                place[i] += row[0] * xi[0] + row[1] * xi[1];
                velocity[i] += row[0] * (rise[0] + given[0]) + row[1] * (rise[1] + given[1]);
            }
        }
        Self::new(system, local, [place, velocity], turned)
    }

    /// From q, where the static load holds it, and q′.
    pub(crate) fn new(
        system: &System,
        local: Arc<Local>,
        [x, mut velocity]: [Vec<f64>; 2],
        turned: Vec<Complex<f64>>,
    ) -> Self {
        let n = x.len();
        velocity.iter_mut().for_each(|v| *v /= local.scale);
        let mut series = LocalSeries::default();
        series.rows.reset(n);
        let limit = |contact: usize, barrier: Barrier| {
            system.barrier(contact, barrier).unwrap_or(barrier.sign() * f64::INFINITY)
        };
        let limits = |barrier: Barrier| (0..system.contacts()).map(|contact| limit(contact, barrier)).collect();
        Self {
            limits: [Barrier::Lower, Barrier::Upper].map(limits),
            is_direct: system.is_direct(),
            touched: Self::touched(&local, system.is_direct()),
            local,
            now: turned.clone(),
            turned,
            x,
            velocity,
            reference: vec![0.0; n],
            series,
            origin: vec![0.0; n],
            moved: Vec::new(),
            lost: Vec::new(),
            part_rows: Rows::default(),
            parts: Vec::new(),
            horizon: 0.0,
            pace: Pace::default(),
            next: [vec![0.0; n], vec![0.0; n]],
            groups: Vec::new(),
        }
    }

    pub(crate) fn weights(&self, contact: usize) -> &[(usize, f64)] {
        &self.local.operator.contacts[contact]
    }

    /// q of a coordinate, from where the static load holds it.
    pub(crate) fn position(&self, n: usize) -> f64 {
        self.reference[n] + self.x[n]
    }

    fn seen(&self, contact: usize, of: impl Fn(usize) -> f64) -> f64 {
        if self.is_direct {
            return of(contact);
        }
        self.weights(contact).iter().map(|(n, weight)| weight * of(*n)).sum()
    }

    /// g of a contact at the base.
    pub(crate) fn place(&self, contact: usize) -> f64 {
        self.seen(contact, |n| self.position(n))
    }

    /// g′ of a contact at the base.
    pub(crate) fn velocity(&self, contact: usize) -> f64 {
        self.seen(contact, |n| self.velocity[n]) * self.local.scale
    }

    /// How far its coordinates are and go in a unit of internal time.
    pub(crate) fn scale(&self, contact: usize) -> f64 {
        let size = |n: usize| self.position(n).abs() + self.velocity[n].abs();
        self.weights(contact).iter().map(|(place, weight)| weight.abs() * size(*place)).sum()
    }

    /// An impulse at a contact.
    pub(crate) fn strike(&mut self, contact: usize, impulse: f64) {
        let Self { local, velocity, .. } = self;
        for (place, weight) in &local.operator.contacts[contact] {
            velocity[*place] += weight / local.operator.masses[*place] * (impulse / local.scale);
        }
    }

    /// M⁻¹w times `amount` is added to the coordinates.
    pub(crate) fn shift(&mut self, contact: usize, amount: f64) {
        let Self { local, x: q, .. } = self;
        for (place, weight) in &local.operator.contacts[contact] {
            q[*place] += weight / local.operator.masses[*place] * amount;
        }
    }

    /// What series begin from.
    pub(crate) fn state(&self) -> [&[f64]; 3] {
        [&self.x, &self.reference, &self.velocity]
    }

    /// Where contacts tend to.
    pub(crate) fn tendencies(&self, system: &System, places: &Places) -> Tendencies {
        let mut series = LocalSeries::default();
        series.rows.reset_to(self.x.len(), LOW);
        series.held = Held::new(system, &self.local, places);
        begin_rows(self.state(), &mut series.rows, 0, 0..self.x.len());
        self.local.expand(&mut series, self.is_direct, &self.turned, LOW);
        Tendencies::Local(Box::new(series), self.local.clone())
    }

    /// Starts a window: its length. A contact that leaves a barrier with a derivative of high order needs a series that has it: `least` orders.
    /// `found` is told of contacts that bounds do not clear of barriers.
    pub(crate) fn begin(
        &mut self,
        system: &System,
        places: &Places,
        seed: &mut u64,
        mut found: impl FnMut(&Self, usize, Sweep),
    ) -> f64 {
        let least = places.soft().map(|(_, order)| order).max().unwrap_or(0);
        let (order, longest) = self.pace.choose(least, &self.local.horizons, &self.touched);
        let Self { local, turned, x, velocity, reference, series, is_direct, lost, .. } = self;
        let n = x.len();
        series.held = Held::new(system, local, places);
        series.soft.clear();
        if *is_direct {
            series.soft.extend(places.soft());
        }
        begin_rows([x, reference, velocity], &mut series.rows, 0, 0..n);
        local.expand(series, *is_direct, turned, order);
        // Windows of varying length, so that the rounding errors of their weights do not add up.
        let horizon = local.certified(&series.rows, longest, system.fastest) * (1.0 - spread(seed).abs() / 64.0);
        lost.clear();
        if *is_direct {
            let leaves = |contact: &usize| matches!(places[*contact].touch, Contact::Leaving(..));
            let all = 0..if n <= FEW { n } else { 0 };
            let leaving = places.near().filter(leaves).filter(|_| n > FEW);
            lost.extend(all.chain(leaving).filter_map(|n| Some((n, local.lost(n, &series.rows)?))));
        }
        let fractions = bound::fractions(horizon);
        // What holds contacts of several coordinates may enlarge derivatives.
        let is_bounded =
            series.held.is_plain && TAIL + 1 < order && local.growth.rate * horizon < 0.9 * (TAIL + 1) as f64;
        let (from, tail) =
            if is_bounded { (TAIL, bound::tail(&series.rows, n, local.growth, horizon)) } else { (order + 1, 0.0) };
        self.horizon = horizon;
        let bases = (0..n).step_by(LANES);
        if self.is_direct {
            for base in bases {
                let bounds = bound::group(&self.series.rows, base, from, tail, &fractions);
                self.sift(&bounds, base, LANES.min(n - base), &mut found);
            }
        } else {
            let rows = &self.series.rows;
            self.groups.clear();
            self.groups.extend(bases.map(|base| bound::group(rows, base, from, tail, &fractions)));
            for contact in 0..system.contacts() {
                let sweep = self.sweep(contact);
                if !self.is_clear(contact, [sweep.rise, sweep.fall]) {
                    found(self, contact, sweep);
                }
            }
        }
        self.horizon / self.local.scale
    }

    /// Bounds of a contact over the window.
    fn sweep(&self, contact: usize) -> Sweep {
        let mut sum = Sweep::default();
        for &(place, weight) in self.weights(contact) {
            let Group { rise, fall, bend_up, bend_down } = &self.groups[place / LANES];
            let of = |eight: &wide::f64x8| weight * eight.as_array()[place % LANES];
            let ordered = |up: f64, down: f64| if weight > 0.0 { (up, down) } else { (down, up) };
            let ((rise, fall), (up, down)) = (ordered(of(rise), of(fall)), ordered(of(bend_up), of(bend_down)));
            sum = Sweep {
                rise: sum.rise + rise,
                fall: sum.fall + fall,
                bend_up: sum.bend_up + up,
                bend_down: sum.bend_down + down,
            };
        }
        sum
    }

    /// Barriers of a contact, from where its place is measured; infinite where there is none.
    pub(crate) fn limits(&self, system: &System, contact: usize, place: &Place) -> [f64; 2] {
        let reference = if self.is_direct {
            self.reference[contact]
        } else {
            place.reference.and_then(|barrier| system.barrier(contact, barrier)).unwrap_or(0.0)
        };
        [self.limits[0][contact] - reference, self.limits[1][contact] - reference]
    }

    fn is_clear(&self, contact: usize, [rise, fall]: [f64; 2]) -> bool {
        let x = self.place(contact);
        let margin = CLEARANCE * (x.abs() + rise - fall);
        x + rise + margin < self.limits[1][contact] && x + fall - margin > self.limits[0][contact]
    }

    /// Those of `count` ≤ 8 contacts from `base` on, each a coordinate, that their bounds do not clear.
    pub(crate) fn sift(&self, bounds: &Group, base: usize, count: usize, found: &mut impl FnMut(&Self, usize, Sweep)) {
        let &Group { rise, fall, bend_up, bend_down } = bounds;
        let reference = f64x8::from(eight(&self.reference, base));
        let [lower, upper] = [0, 1].map(|side: usize| f64x8::from(eight(&self.limits[side], base)) - reference);
        let x = f64x8::from(eight(&self.x, base));
        let margin = f64x8::splat(CLEARANCE) * (x.abs() + rise - fall);
        let is_clear = (x + rise + margin).simd_lt(upper) & (x + fall - margin).simd_gt(lower);
        let mut unclear = !is_clear.to_bitmask() & ((1 << count) - 1);
        while unclear != 0 {
            let lane = unclear.trailing_zeros() as usize;
            unclear &= unclear - 1;
            let [rise, fall, bend_up, bend_down] = [rise, fall, bend_up, bend_down].map(|eight| eight.as_array()[lane]);
            found(self, base + lane, Sweep { rise, fall, bend_up, bend_down });
        }
    }

    /// The origin of a contact's series.
    pub(crate) fn origin(&self, contact: usize) -> f64 {
        if self.is_direct { self.origin[contact] } else { 0.0 }
    }

    /// A contact's own derivative: beside a barrier what is carried for it.
    pub(crate) fn own(&self, contact: usize, place: &Place, k: usize) -> f64 {
        match (place.touch, k) {
            (_, 0) if self.is_direct => self.x[contact],
            (_, 0) => place.reference.map_or_else(|| self.place(contact), |_| place.x),
            (Contact::Leaving(_, m), _) if k < usize::from(m) => 0.0,
            (_, 1) => place.v.map_or_else(|| self.seen(contact, |n| self.velocity[n]), |v| v / self.local.scale),
            _ if self.is_direct => self.series.rows.get(k, contact),
            _ => self.series.derivative(&self.local, contact, k),
        }
    }

    /// Follows a contact towards its barriers, in internal time.
    pub(crate) fn watch(&self, contact: usize, place: &Place, [lower, upper]: [Option<f64>; 2]) -> Watch {
        let (local, order, horizon) = (&self.local, self.series.rows.order, self.horizon - self.origin(contact));
        let mut c = [0.0; MAX_ORDER + 1];
        // The second derivative is d_2 + d_3 s + …: bounded on the way.
        let mut bend = bound::Enclosure::default();
        for k in (2..=order).rev() {
            // (Of one that leaves its barrier softly rows know which derivatives vanish.)
            let derivative =
                if self.is_direct { self.series.rows.get(k, contact) } else { self.own(contact, place, k) };
            c[k] = derivative * local.inverse_factorial[k];
            bend.add(derivative, horizon * local.inverse[k - 1]);
        }
        [c[0], c[1]] = [0, 1].map(|k| self.own(contact, place, k));
        let far = || f64::MIN_POSITIVE + 2.0 * c.iter().rev().fold(0.0, |sum, c| c.abs() + sum * horizon);
        // A barrier that is not there is beyond reach.
        let (lower, upper) = (lower.unwrap_or_else(|| -far()), upper.unwrap_or_else(far));
        Watch::flight(contact, &watch::Flight { c, order, horizon, lower, upper, bend, contact: place.touch })
    }

    /// Weights at `s` since the base, for coordinates whose series begin there. Of few coordinates they are held in two words: of a periodic
    /// motion the same ones come again and again.
    pub(crate) fn weights_at(&self, s: f64) -> Weights {
        let mut weights = Weights::zero();
        let (s, order, inverse) = (s * self.local.scale, self.series.rows.order, &self.local.inverse_factorial);
        if self.x.len() < LARGE {
            weights.precise(s, order, inverse);
        } else {
            weights.plain(s, order, inverse);
        }
        weights
    }

    /// Moves the base to `s`, with the weights of that time, where loads are at `offset` in their period.
    pub(crate) fn advance(&mut self, s: f64, weights: &Weights, loads: &Loads, offset: f64) {
        let [mut place, mut velocity] = std::mem::take(&mut self.next);
        self.fly(s, weights, [&mut place, &mut velocity]);
        std::mem::swap(&mut self.x, &mut place);
        std::mem::swap(&mut self.velocity, &mut velocity);
        self.next = [place, velocity];
        self.moved.drain(..).for_each(|n| self.origin[n] = 0.0);
        loads.turn(offset, &mut self.turned);
        self.now.clone_from(&self.turned);
        self.pace.pass(s * self.local.scale);
    }

    /// Where a contact beside a barrier is at `s`, with the weights of that time.
    pub(crate) fn moved(&self, contact: usize, place: &Place, s: f64, weights: &Weights) -> Place {
        let (x, v) = self.near_at(contact, place, s, weights);
        // A flight so short that even the distance underflows has not left.
        let touch = if x == 0.0 { place.touch } else { Contact::Free };
        Place { x, v: Some(v), touch, ..*place }
    }

    /// Where it is now that the base has moved. Far from its barrier it forgets that: g is known as well; but a contact that is a coordinate not at the
    /// other one, which it is about to strike, and which the change would round.
    pub(crate) fn settled(&mut self, contact: usize, place: &Place) -> Place {
        let scale = FORGET * self.scale(contact);
        if !self.is_direct {
            return if place.x.abs() > scale { Place::free(self.place(contact)) } else { *place };
        }
        let (x, own) = (self.x[contact], self.reference[contact]);
        if self.limits.iter().all(|side| (x - (side[contact] - own)).abs() > scale) {
            (self.x[contact], self.reference[contact]) = (own + x, 0.0);
            return Place::free(own + x);
        }
        // A flight so short that even the distance underflows has not left.
        Place { x, v: None, touch: if x == 0.0 { place.touch } else { Contact::Free }, ..*place }
    }

    /// Puts a coordinate to the distance `x` from a barrier that is at `reference`, with a velocity.
    pub(crate) fn put(&mut self, n: usize, [reference, x]: [f64; 2], velocity: f64) {
        (self.reference[n], self.x[n], self.velocity[n]) = (reference, x, velocity / self.local.scale);
    }

    /// A perturbation of coordinates flies for a time of the structure, some of them at rest, without loads and barriers.
    pub(crate) fn drift(&mut self, [place, velocity]: [&mut Vec<f64>; 2], time: f64, resting: &[usize]) {
        let local = self.local.clone();
        let mut left = time * local.scale;
        let mut weights = Weights::zero();
        let still = vec![Complex::default(); self.turned.len()];
        while left > 0.0 {
            let last = ORDERS.len() - 1;
            let enough = local.horizons.iter().position(|&horizon| horizon >= left).unwrap_or(last);
            let (order, step) = (ORDERS[enough], left.min(local.horizons[enough]));
            weights.plain(step, order, &local.inverse_factorial);
            let rows = &mut self.series.rows;
            let (n, stride) = (place.len(), rows.stride);
            rows.data[1..=n].copy_from_slice(place);
            rows.data[stride + 1..][..n].copy_from_slice(velocity);
            local.fill(rows, &[(0..n, 0)], local.beyond(), &still, order, |_, to| {
                resting.iter().for_each(|n| to[n + 1] = 0.0);
            });
            let [next, next_velocity] = &mut self.next;
            rows.at_all(place, &weights, next, next_velocity);
            std::mem::swap(place, next);
            std::mem::swap(velocity, next_velocity);
            left -= step;
        }
    }
}
