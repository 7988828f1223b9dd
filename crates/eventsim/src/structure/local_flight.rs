//! Coordinates in flight by local series, from a base.

use std::sync::Arc;

use super::approach::Place;
use super::local::{Held, Local, LocalSeries};
use super::near::Tendencies;
use super::series::LOW;
use super::system::System;
use crate::bound::{self, Group, TAIL};
use crate::part::Pace;
use crate::ring::Contact;
use crate::series::{LANES, Rows};
use crate::units::{MAX_ORDER, REMAINDER, spread};
use crate::watch::{self, Watch};
use crate::weights::Weights;
use vibrochain_lattice::{Barrier, Complex};

/// Coordinates at the base, and their series from there.
#[derive(Debug, Clone)]
pub(crate) struct LocalFlight {
    pub(crate) local: Arc<Local>,
    /// e^{iw(t+ψ)} of each load at the base, and where series have begun last.
    pub(crate) turned: Vec<Complex<f64>>,
    pub(super) now: Vec<Complex<f64>>,
    /// q, from where the static load holds it, and q′, in internal time: each at the origin of its series.
    pub(super) place: Vec<f64>,
    pub(super) velocity: Vec<f64>,
    pub(crate) series: LocalSeries,
    /// Origins since the base, internal; `moved` lists those that are not 0.
    pub(super) origin: Vec<f64>,
    pub(super) moved: Vec<usize>,
    pub(super) part_rows: Rows,
    /// Length of the window, internal, since the base.
    pub(super) horizon: f64,
    pub(super) pace: Pace,
    next: [Vec<f64>; 2],
    /// Bounds of eight coordinates each over the window.
    groups: Vec<Group>,
    /// Barriers of all contacts, from where the static load holds them; infinite where there is none.
    limits: Vec<[f64; 2]>,
    /// Contact n sees coordinate n as it is, and there is one of each.
    pub(super) is_direct: bool,
    /// A part may be restarted in this window.
    pub(super) is_partible: bool,
}

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

impl Held {
    pub(crate) fn new(system: &System, local: &Local, places: &[Place]) -> Self {
        let resting = places.iter().enumerate().filter_map(|(contact, place)| match place.touch {
            Contact::Resting(barrier) => Some((contact, barrier)),
            _ => None,
        });
        let contacts: Vec<(usize, Barrier)> = resting.collect();
        let numbers: Vec<usize> = contacts.iter().map(|(contact, _)| *contact).collect();
        let is_apart = |i: &usize| numbers.iter().all(|j| i == j || system.mobility(*i, *j) == 0.0);
        let inverse: Vec<Vec<f64>> = if numbers.iter().all(is_apart) {
            numbers.iter().map(|&contact| vec![1.0 / system.mobility(contact, contact)]).collect()
        } else {
            let unit = |i: usize| (0..numbers.len()).map(|j| f64::from(u8::from(i == j))).collect::<Vec<_>>();
            (0..numbers.len()).map(|i| system.impulses(&numbers, &unit(i))).collect()
        };
        let is_plain = inverse.iter().all(|row| row.len() == 1)
            && numbers.iter().all(|&contact| local.operator.contacts[contact].len() == 1);
        Self { contacts, inverse, is_plain }
    }
}

impl LocalFlight {
    /// From ξ, at a time within a period.
    pub(crate) fn new(system: &System, local: Arc<Local>, xi: &[[f64; 2]], offset: f64) -> Self {
        let turned = system.loads.turned(offset);
        let n = local.operator.masses.len();
        let (mut place, mut velocity) = (vec![0.0; n], vec![0.0; n]);
        for (k, (mode, xi)) in system.structure.modes().iter().zip(xi).enumerate() {
            let (rise, given) = (mode.turn.act(mode.generator(), *xi), system.loads.given(k, &turned));
            for (i, row) in mode.coordinates.iter().enumerate() {
                place[i] += row[0] * xi[0] + row[1] * xi[1];
                velocity[i] += (row[0] * (rise[0] + given[0]) + row[1] * (rise[1] + given[1])) / local.scale;
            }
        }
        let mut series = LocalSeries::default();
        series.rows.reset(n);
        let limit = |contact: usize| {
            let of = |barrier: Barrier| system.barrier(contact, barrier).unwrap_or(barrier.sign() * f64::INFINITY);
            [Barrier::Lower, Barrier::Upper].map(of)
        };
        let contacts = &local.operator.contacts;
        let is_alone = contacts.iter().enumerate().all(|(n, weights)| weights[..] == [(n, 1.0)]);
        let is_direct = is_alone && contacts.len() == n;
        Self {
            limits: (0..system.contacts()).map(limit).collect(),
            is_direct,
            is_partible: false,
            local,
            now: turned.clone(),
            turned,
            place,
            velocity,
            series,
            origin: vec![0.0; n],
            moved: Vec::new(),
            part_rows: Rows::default(),
            horizon: 0.0,
            pace: Pace::default(),
            next: [vec![0.0; n], vec![0.0; n]],
            groups: Vec::new(),
        }
    }

    fn weights(&self, contact: usize) -> &[(usize, f64)] {
        &self.local.operator.contacts[contact]
    }

    fn seen(&self, contact: usize, list: &[f64]) -> f64 {
        self.weights(contact).iter().map(|(place, weight)| weight * list[*place]).sum()
    }

    /// g of a contact at the base.
    pub(crate) fn place(&self, contact: usize) -> f64 {
        self.seen(contact, &self.place)
    }

    /// g′ of a contact at the base.
    pub(crate) fn velocity(&self, contact: usize) -> f64 {
        self.seen(contact, &self.velocity) * self.local.scale
    }

    /// How far its coordinates are and go in a unit of internal time.
    pub(crate) fn scale(&self, contact: usize) -> f64 {
        let size = |place: usize| self.place[place].abs() + self.velocity[place].abs();
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
        let Self { local, place: q, .. } = self;
        for (place, weight) in &local.operator.contacts[contact] {
            q[*place] += weight / local.operator.masses[*place] * amount;
        }
    }

    fn expanded(&self, series: &mut LocalSeries, system: &System, places: &[Place], order: usize) {
        series.held = Held::new(system, &self.local, places);
        let (n, stride) = (self.place.len(), series.rows.stride);
        series.rows.data[1..=n].copy_from_slice(&self.place);
        series.rows.data[stride + 1..][..n].copy_from_slice(&self.velocity);
        self.local.expand(series, &self.turned, order);
    }

    /// Where contacts tend to.
    pub(crate) fn tendencies(&self, system: &System, places: &[Place]) -> Tendencies {
        let mut series = LocalSeries::default();
        series.rows.reset_to(self.place.len(), LOW);
        self.expanded(&mut series, system, places, LOW);
        Tendencies::Local(Box::new(series), self.local.clone())
    }

    /// Starts a window: its length. A contact that leaves a barrier with a derivative of high order needs a series that has it: `least` orders.
    pub(crate) fn begin(&mut self, system: &System, places: &[Place], least: u8, seed: &mut u64) -> f64 {
        let local = self.local.clone();
        let mut pace = std::mem::take(&mut self.pace);
        let (order, longest) = pace.choose(least, &local.horizons, |horizon| self.touched(horizon));
        self.pace = pace;
        let mut series = std::mem::take(&mut self.series);
        self.expanded(&mut series, system, places, order);
        let row = |k: usize| local.largest(series.rows.row(k, 0));
        // What moves at all, by the first derivatives in units of the fastest rate.
        let fastest = system.fastest / local.scale;
        let size = (0..4).map(|k| row(k) / fastest.powi(k as i32)).fold(0.0, f64::max);
        let short = |k: usize| {
            let most = row(k) * local.inverse_factorial[k];
            // The last two terms are below rounding, and those behind them fall.
            let longest = (REMAINDER * size / most).powf(1.0 / k as f64);
            if most > 0.0 && longest.is_finite() { longest } else { f64::INFINITY }
        };
        let longest = longest.min(short(order)).min(short(order - 1));
        // Windows of varying length, so that the rounding errors of their weights do not add up.
        self.horizon = longest * (1.0 - spread(seed).abs() / 64.0);
        let fractions = bound::fractions(self.horizon);
        let n = self.place.len();
        // What holds contacts of several coordinates may enlarge derivatives.
        let is_bounded =
            series.held.is_plain && TAIL + 1 < order && local.growth.rate * self.horizon < 0.9 * (TAIL + 1) as f64;
        let (from, tail) = if is_bounded {
            (TAIL, bound::tail(&series.rows, n, local.growth, self.horizon))
        } else {
            (order + 1, 0.0)
        };
        self.groups.clear();
        let bases = (0..n).step_by(LANES);
        self.groups.extend(bases.map(|base| bound::group(&series.rows, base, from, tail, &fractions)));
        self.is_partible = self.is_direct && least == 0 && series.held.contacts.is_empty();
        self.series = series;
        self.horizon / local.scale
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

    pub(super) fn is_clear(&self, contact: usize, x: f64, [rise, fall]: [f64; 2]) -> bool {
        let ([low, high], margin) = (self.limits[contact], CLEARANCE * (x.abs() + rise - fall));
        x + rise + margin < high && x + fall - margin > low
    }

    /// Contacts that bounds do not clear of barriers.
    pub(crate) fn unclear(&self, mut found: impl FnMut(&Self, usize, Sweep)) {
        if self.is_direct {
            let n = self.place.len();
            let groups = self.groups.iter().zip((0..n).step_by(LANES));
            groups.for_each(|(group, base)| self.sift(group, base, LANES.min(n - base), &mut found));
            return;
        }
        for contact in 0..self.limits.len() {
            let sweep = self.sweep(contact);
            if !self.is_clear(contact, self.place(contact), [sweep.rise, sweep.fall]) {
                found(self, contact, sweep);
            }
        }
    }

    /// The origin of a contact's series.
    pub(super) fn origin(&self, contact: usize) -> f64 {
        if self.is_direct { self.origin[contact] } else { 0.0 }
    }

    /// g″ and g‴ of a contact at the origin of its series, where no contact rests.
    pub(crate) fn bends(&self, contact: usize) -> [f64; 2] {
        let Local { operator, scale, .. } = &*self.local;
        let given = |n: usize, k: u32| {
            let loads = operator.loads.iter().zip(&self.local.rates).zip(&self.now[1..]);
            let driven = loads.map(|((load, rate), now)| (load[n] * now * Complex::new(0.0, *rate).powu(k)).re);
            driven.sum::<f64>() + if k == 0 { self.local.remaining(n) } else { 0.0 }
        };
        let velocity = |n: usize| self.velocity[n] * scale;
        let acceleration =
            |n: usize| given(n, 0) - operator.pull(n, false, |m| self.place[m]) - operator.pull(n, true, velocity);
        let jerk = |n: usize| given(n, 1) - operator.pull(n, false, velocity) - operator.pull(n, true, acceleration);
        let seen = |of: &dyn Fn(usize) -> f64| self.weights(contact).iter().map(|(n, weight)| weight * of(*n)).sum();
        [seen(&acceleration), seen(&jerk)]
    }

    /// A contact's own derivative: beside a barrier what is carried for it.
    pub(crate) fn own(&self, contact: usize, place: &Place, k: usize) -> f64 {
        match (place.touch, k) {
            (_, 0) => place.reference.map_or_else(|| self.place(contact), |_| place.x),
            (Contact::Leaving(_, m), _) if k < usize::from(m) => 0.0,
            (_, 1) => place.v.map_or_else(|| self.seen(contact, &self.velocity), |v| v / self.local.scale),
            _ => self.series.derivative(&self.local, contact, k),
        }
    }

    /// Follows a contact towards its barriers, in internal time.
    pub(crate) fn watch(&self, contact: usize, place: &Place, [lower, upper]: [Option<f64>; 2]) -> Watch {
        let (local, order, horizon) = (&self.local, self.series.rows.order, self.horizon - self.origin(contact));
        let mut c = [0.0; MAX_ORDER + 1];
        let mut bend = bound::Enclosure::default();
        let (mut far, mut power) = (f64::MIN_POSITIVE, 1.0);
        for (k, c) in c.iter_mut().enumerate().take(order + 1) {
            *c = self.own(contact, place, k) * local.inverse_factorial[k];
            far += 2.0 * c.abs() * power;
            power *= horizon;
        }
        (2..=order).rev().for_each(|k| bend.add((k * (k - 1)) as f64 * c[k], horizon));
        // A barrier that is not there is beyond reach.
        let (lower, upper) = (lower.unwrap_or(-far), upper.unwrap_or(far));
        Watch::flight(contact, &watch::Flight { c, order, horizon, lower, upper, bend, contact: place.touch })
    }

    /// Follows the force on a contact at rest, which is the i-th.
    pub(crate) fn watch_rest(&self, system: &System, i: usize) -> Watch {
        let (contact, barrier): (usize, Barrier) = self.series.held.contacts[i];
        let doubt = 8.0 * self.series.acceleration_doubt(&self.local, contact) / system.mobility(contact, contact);
        let order = self.series.rows.order;
        let mut watch = Watch::rest(contact, barrier, order, self.horizon, doubt);
        for k in 0..order - 1 {
            watch.c[k] = -barrier.sign() * self.series.forces[i][k] * self.local.inverse_factorial[k];
        }
        watch
    }

    /// Weights at `s` since the base. They are held in two words: of a periodic motion the same ones come again and again.
    fn weights_at(&self, s: f64) -> Weights {
        let mut weights = Weights::zero();
        weights.precise(s * self.local.scale, self.series.rows.order, &self.local.inverse_factorial);
        weights
    }

    /// q and q′ at `s` since the base, in the structure's time, from where the static load holds them.
    pub(crate) fn at(&self, s: f64) -> [Vec<f64>; 2] {
        if s == 0.0 {
            let velocity = self.velocity.iter().map(|v| v * self.local.scale).collect();
            return [self.place.clone(), velocity];
        }
        let (mut place, mut velocity) = (self.place.clone(), self.velocity.clone());
        self.fly(s, [&mut place, &mut velocity]);
        velocity.iter_mut().for_each(|v| *v *= self.local.scale);
        [place, velocity]
    }

    /// The same in internal time.
    fn fly(&self, s: f64, [place, velocity]: [&mut [f64]; 2]) {
        let (weights, inverse) = (self.weights_at(s), &self.local.inverse);
        if self.moved.is_empty() {
            self.series.rows.at_all(&self.place, &weights, place, velocity);
            return;
        }
        let s = s * self.local.scale;
        self.series.rows.all_at((s, &self.origin), &self.place, (&weights, inverse), [&mut *place, &mut *velocity]);
        // Those that have been carried there, and have no series from there yet.
        for &n in self.moved.iter().filter(|n| self.origin[**n] >= s) {
            (place[n], velocity[n]) = (self.place[n], self.velocity[n]);
        }
    }

    /// x and v of a contact at `s`.
    pub(crate) fn contact_at(&self, contact: usize, place: &Place, s: f64) -> (f64, f64) {
        let weights = self.weights_at((s - self.origin(contact) / self.local.scale).max(0.0));
        let (mut x, mut v) = (0.0, 0.0);
        for k in (1..=self.series.rows.order).rev() {
            let d = self.own(contact, place, k);
            x += weights.high[k] * d;
            v += weights.high[k - 1] * d;
        }
        (self.own(contact, place, 0) + x, v * self.local.scale)
    }

    /// The force on a contact at rest at `s`, positive towards larger g.
    pub(crate) fn force_at(&self, contact: usize, s: f64) -> f64 {
        let Some(i) = self.series.held_as(contact) else { return 0.0 };
        let weights = self.weights_at(s);
        let terms = (0..self.series.rows.order - 1).map(|k| weights.high[k] * self.series.forces[i][k]);
        terms.sum::<f64>() * self.local.scale * self.local.scale
    }

    /// Moves the base to `s`, where loads are `turned`.
    pub(crate) fn advance(&mut self, s: f64, turned: Vec<Complex<f64>>) {
        let [mut place, mut velocity] = std::mem::take(&mut self.next);
        self.fly(s, [&mut place, &mut velocity]);
        std::mem::swap(&mut self.place, &mut place);
        std::mem::swap(&mut self.velocity, &mut velocity);
        self.next = [place, velocity];
        self.moved.drain(..).for_each(|n| self.origin[n] = 0.0);
        self.now.clone_from(&turned);
        self.turned = turned;
        self.pace.pass(s * self.local.scale);
    }
}
