//! The first contact of one mass, certified by steps that no contact can hide in ([`crate::watch::safe_step`]).
//!
//! **Rounding.** f is computed to μ = 4 ε (|c₀| + |c₁|τ + |c₂|τ²) or better, ε = 2⁻⁵²: an approach to within μ is a
//! contact. Where displacements are measured from the barrier itself, μ shrinks with the distance.
//!
//! **A mass at rest** is released where its force has a root and then turns by more than its rounding before it presses again. A force that
//! touches 0 and rises turns nothing, whatever rounding makes of the touch.

pub(crate) mod queue;
pub(crate) mod safe_step;

use crate::series::bound;
use crate::units::MAX_ORDER;
use crate::watch::safe_step::{ROUNDING, Side, departure, safe_step, side};
use vibrochain_lattice::Barrier;

/// Steps after which the bound of the second derivative is taken over twice the time gone by instead of the whole window, and
/// no step is longer than that time: a mass that leaves its barrier with next to no acceleration and is pressed back at
/// once returns in 1e-15 of a window, and is not reached in the steps that the window's bound allows. Others take two or three steps.
const PATIENCE: u32 = 64;

/// How a contact touches a barrier at the origin of its series.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Contact {
    /// It does not.
    Free,
    /// It is on the barrier and leaves it: the first derivative of its displacement that does not vanish has this
    /// order (1 after an impact, 3 after a release) and points inward. Those before it vanish exactly.
    Leaving(Barrier, u8),
    /// It rests on the barrier, which pushes it back.
    Resting(Barrier),
}

/// What is watched.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Kind {
    /// A flight between two barriers.
    Flight,
    /// The force that holds a mass on a barrier.
    Rest(Barrier),
}

/// What a step found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Step {
    /// No contact within the window.
    Clear,
    /// None before `tau`.
    Later,
    /// A contact, at `tau`.
    Hit,
}

/// What a force does after its root.
enum Turned {
    /// It pulls, by more than its rounding.
    Away,
    /// It presses again from here on, and has pulled by no more than that.
    Back(f64),
    /// Neither within the window.
    NotYet,
}

/// The flight of a mass as a series.
pub(crate) struct Flight {
    /// Taylor coefficients of the displacement relative to its reference.
    pub(crate) c: [f64; MAX_ORDER + 1],
    pub(crate) order: usize,
    /// How long it is followed.
    pub(crate) horizon: f64,
    /// The barriers relative to the reference.
    pub(crate) lower: f64,
    pub(crate) upper: f64,
    /// Its second derivative.
    pub(crate) bend: bound::Enclosure,
    pub(crate) contact: Contact,
}

/// A mass followed towards its first contact.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Watch {
    pub(crate) site: usize,
    pub(crate) kind: Kind,
    /// No contact before this time, counted from the origin of the series.
    pub(crate) tau: f64,
    /// Set once the contact is found, at `tau`.
    pub(crate) hit: Option<Barrier>,
    horizon: f64,
    order: usize,
    /// Taylor coefficients of the displacement relative to its reference, or of the force.
    pub(crate) c: [f64; MAX_ORDER + 1],
    lower: f64,
    upper: f64,
    /// Bounds: second derivative ≤ `bend_up`, −(second derivative) ≤ `bend_down`.
    bend_up: f64,
    bend_down: f64,
    /// Rounding of the force on a mass at rest.
    margin: f64,
    /// Steps so far.
    steps: u32,
}

impl Watch {
    /// A flight.
    pub(crate) fn flight(site: usize, flight: &Flight) -> Self {
        let &Flight { ref c, order, horizon, lower, upper, ref bend, contact } = flight;
        let (bend_up, least) = bend.bounds();
        let mut watch = Self {
            site,
            kind: Kind::Flight,
            tau: 0.0,
            hit: None,
            horizon,
            order,
            c: *c,
            lower,
            upper,
            bend_up,
            bend_down: -least,
            margin: 0.0,
            steps: 0,
        };
        if let Contact::Leaving(barrier, m) = contact
            && m > 1
        {
            let inward = -barrier.sign();
            let m = usize::from(m);
            let mut g = [0.0; MAX_ORDER + 1];
            for (g, c) in g.iter_mut().zip(&c[m..=order]) {
                *g = inward * c;
            }
            let leaving = departure(&g[..=order - m], horizon);
            let across = match barrier {
                Barrier::Lower => safe_step(upper - c[0], -c[1], watch.bend_up),
                Barrier::Upper => safe_step(c[0] - lower, c[1], watch.bend_down),
            };
            watch.tau = leaving.min(across).max(0.0);
        }
        watch
    }

    /// A mass at rest; its force, positive while it presses, is filled in by the expansion before [`Watch::prepare`].
    pub(crate) fn rest(site: usize, barrier: Barrier, order: usize, horizon: f64, margin: f64) -> Self {
        Self {
            site,
            kind: Kind::Rest(barrier),
            tau: 0.0,
            hit: None,
            horizon,
            order: order - 2,
            c: [0.0; MAX_ORDER + 1],
            lower: 0.0,
            upper: f64::INFINITY,
            bend_up: 0.0,
            bend_down: 0.0,
            margin,
            steps: 0,
        }
    }

    /// Bounds the force of a mass at rest; the first time before which it does not leave, infinite if it stays for
    /// the whole window.
    pub(crate) fn prepare(&mut self) -> f64 {
        let c = &mut self.c[..=self.order];
        if c[0] > self.margin && bound::polynomial(c, self.horizon).1 > self.margin {
            return f64::INFINITY;
        }
        self.bend();
        let start = self.c[0];
        if start <= self.margin {
            // The force starts at zero, to rounding: what it does next is in its first term that does not vanish.
            let term = (1..=self.order).find(|&k| self.c[k] != 0.0);
            let turned = match term {
                Some(m) if self.c[m] < 0.0 && start > -self.margin => self.turned(0.0),
                _ => Turned::Away,
            };
            match (term, turned) {
                (None, _) | (_, Turned::NotYet) => return f64::INFINITY,
                (Some(_), Turned::Back(tau)) => self.tau = tau,
                (Some(m), Turned::Away) => {
                    self.c[0] = 0.0;
                    if self.c[m] > 0.0 {
                        self.tau = departure(&self.c[m..=self.order], self.horizon);
                    }
                }
            }
        }
        if self.tau == 0.0 && self.c[0] > 0.0 {
            return safe_step(self.c[0], self.c[1], self.bend_down);
        }
        self.tau
    }

    fn bend(&mut self) {
        (self.bend_up, self.bend_down) = self.bends(self.horizon);
    }

    /// Bounds of the second derivative and of its negative from 0 to `end`.
    fn bends(&self, end: f64) -> (f64, f64) {
        let mut second = [0.0; MAX_ORDER + 1];
        for k in 2..=self.order {
            second[k - 2] = (k * (k - 1)) as f64 * self.c[k];
        }
        let (up, down) = bound::polynomial(&second[..=self.order - 2], end);
        (up, -down)
    }

    /// If the contact at the very start of the series is the end of a rest, the order of the first derivative of the
    /// displacement that pulls the mass off; those before it vanish.
    pub(crate) fn first_pull(&self) -> Option<u8> {
        let m = self.c[..=self.order].iter().position(|&c| c != 0.0)?;
        let released = matches!(self.kind, Kind::Rest(_)) && self.tau == 0.0 && self.c[m] < 0.0;
        released.then_some(m as u8 + 2)
    }

    /// What a force does whose root is at `from`, or there to rounding: certified steps look for where it is below that.
    fn turned(&self, from: f64) -> Turned {
        let mut ahead = Self { tau: from, ..*self };
        for steps in 0..PATIENCE {
            let (x, slope) = ahead.value();
            if x <= -self.margin {
                return Turned::Away;
            }
            if x > self.margin && slope > 0.0 {
                return Turned::Back(ahead.tau);
            }
            // Far from a turn the steps are Newton's and come no further than its rounding.
            let step = safe_step(x + self.margin, slope, self.bend_down).max(f64::EPSILON * ahead.tau);
            if slope < 0.0 && steps > 2 && step <= ROUNDING * ahead.tau {
                return Turned::Away;
            }
            ahead.tau += step;
            if ahead.tau > self.horizon {
                return Turned::NotYet;
            }
        }
        Turned::Away
    }

    /// Value and slope at `tau`.
    fn value(&self) -> (f64, f64) {
        // With T = t⁴, Σ_{k≥1} c_k t^{k−1} = p_0(T) + t p_1(T) + t² p_2(T) + t³ p_3(T): four short chains side by side instead of a
        // long one. Coefficients beyond the order are 0.
        let t = self.tau;
        let (square, fourth) = (t * t, (t * t) * (t * t));
        let (mut value, mut slope) = ([0.0; 4], [0.0; 4]);
        for four in self.c[1..].as_chunks::<4>().0[..self.order.div_ceil(4)].iter().rev() {
            for i in 0..4 {
                slope[i] = slope[i] * fourth + value[i];
                value[i] = value[i] * fourth + four[i];
            }
        }
        let [a, b, c, d] = value;
        // d/dt (t · t^i p_i) = (i+1) t^i p_i + 4 T t^i p_i′
        let [e, f, g, h] = slope.map(|slope| 4.0 * fourth * slope);
        let value = (a + b * t) + square * (c + d * t);
        let slope = ((a + e) + (2.0 * b + f) * t) + square * ((3.0 * c + g) + (4.0 * d + h) * t);
        // The constant is added last, to the smaller sum.
        (self.c[0] + value * t, slope)
    }

    /// One certified step.
    pub(crate) fn step(&mut self) -> Step {
        if self.tau > self.horizon {
            return Step::Clear;
        }
        let (x, slope) = self.value();
        let t = self.tau;
        self.steps = self.steps.saturating_add(1);
        let (mut bend_up, mut bend_down, mut reach) = (self.bend_up, self.bend_down, f64::INFINITY);
        if self.steps > PATIENCE && t > 0.0 {
            (bend_up, bend_down) = self.bends(2.0 * t);
            reach = t;
        }
        let (step, barrier) = match self.kind {
            Kind::Rest(barrier) => {
                if t == 0.0 && x <= 0.0 {
                    self.hit = Some(barrier);
                    return Step::Hit;
                }
                (side(x, slope, bend_down, self.margin, t), barrier)
            }
            Kind::Flight => {
                let margin = ROUNDING * (self.c[0].abs() + (self.c[1].abs() + self.c[2].abs() * t) * t);
                let up = side(self.upper - x, -slope, bend_up, margin, t);
                let down = side(x - self.lower, slope, bend_down, margin, t);
                match (up, down) {
                    (Side::Contact(d), _) => (Side::Contact(d), Barrier::Upper),
                    (_, Side::Contact(d)) => (Side::Contact(d), Barrier::Lower),
                    (Side::Ahead(up), Side::Ahead(down)) => (Side::Ahead(up.min(down)), Barrier::Upper),
                }
            }
        };
        match step {
            Side::Contact(d) => {
                let tau = t + d;
                if let Kind::Rest(_) = self.kind
                    && self.margin > 0.0
                {
                    match self.turned(t) {
                        Turned::Away => {}
                        Turned::Back(later) => {
                            self.tau = later;
                            return Step::Later;
                        }
                        Turned::NotYet => return Step::Clear,
                    }
                }
                self.tau = if tau > 0.0 { tau } else { 0.0 };
                self.hit = Some(barrier);
                Step::Hit
            }
            Side::Ahead(d) => {
                self.tau = t + d.min(reach);
                if self.tau > self.horizon { Step::Clear } else { Step::Later }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flight(c: &[f64], horizon: f64, contact: Contact, barriers: (f64, f64)) -> (Option<(Barrier, f64)>, u32) {
        let mut coefficients = [0.0; MAX_ORDER + 1];
        coefficients[..c.len()].copy_from_slice(c);
        let mut bend = bound::Enclosure::default();
        (2..=10).rev().for_each(|k| bend.add((k * (k - 1)) as f64 * coefficients[k], horizon));
        let (lower, upper) = barriers;
        let mut watch = Watch::flight(0, &Flight { c: coefficients, order: 10, horizon, lower, upper, bend, contact });
        for steps in 0..200 {
            match watch.step() {
                Step::Clear => return (None, steps),
                Step::Hit => return (watch.hit.map(|b| (b, watch.tau)), steps),
                Step::Later => {}
            }
        }
        panic!("no end: {watch:?}");
    }

    #[test]
    fn a_peak_just_beyond_a_barrier_is_found_and_one_just_before_is_not() {
        // x = 1 + h − (s−1)²: between the barriers −1 and 1 it touches at 1 − √h.
        for (h, hit) in [(1e-6, true), (1e-13, true), (-1e-13, false), (-1e-6, false)] {
            let (found, steps) = flight(&[h, 2.0, -1.0], 1.9, Contact::Free, (-1.0, 1.0));
            assert_eq!(found.is_some(), hit, "{h}");
            if let Some((barrier, time)) = found {
                assert_eq!(barrier, Barrier::Upper);
                // Rounding of 4 ε in x moves a root of slope 2√h by 2ε/√h.
                assert!((time - (1.0 - h.sqrt())).abs() < 8.0 * f64::EPSILON / h.sqrt(), "{h} {time}");
            }
            assert!(steps < 80, "{steps}");
        }
    }

    #[test]
    fn known_zeros_are_not_found_again() {
        // Off the upper barrier (at 0) with v = −1e-13 and curvature ½: back at 4e-13 to full relative accuracy.
        let (found, _) = flight(&[0.0, -1e-13, 0.25], 1.0, Contact::Leaving(Barrier::Upper, 1), (-2.0, 0.0));
        assert!((found.unwrap().1 / 4e-13 - 1.0).abs() < 1e-14);
        // After a release: −s³ + s⁴/2 comes back at s = 2.
        let release = Contact::Leaving(Barrier::Upper, 3);
        let (found, _) = flight(&[0.0, 0.0, 0.0, -1.0, 0.5], 2.5, release, (-2.0, 0.0));
        assert!((found.unwrap().1 - 2.0).abs() < 1e-14);
        let (found, _) = flight(&[0.0, 0.0, 0.0, -1.0, 0.5], 1.9, release, (-2.0, 0.0));
        assert_eq!(found, None);
    }

    #[test]
    fn convergence_is_quadratic() {
        let (found, steps) = flight(&[0.0, 0.9, 0.4, -0.3, 0.05, 0.01], 1.5, Contact::Free, (-1.0, 1.0));
        assert!(found.is_some() && steps <= 8, "{steps}");
    }

    /// A force that presses with these coefficients, known to 1e-12, for a time of 1: what is told before it is followed, and where it then
    /// changes sign.
    fn rest(c: &[f64]) -> (f64, Option<f64>) {
        let mut watch = Watch::rest(0, Barrier::Upper, 10, 1.0, 1e-12);
        watch.c[..c.len()].copy_from_slice(c);
        let told = watch.prepare();
        if told.is_infinite() {
            return (told, None);
        }
        for _ in 0..200 {
            match watch.step() {
                Step::Clear => return (told, None),
                Step::Hit => return (told, Some(watch.tau)),
                Step::Later => {}
            }
        }
        panic!("no end: {watch:?}");
    }

    #[test]
    fn a_contact_is_let_go_where_its_force_changes_sign_by_more_than_rounding() {
        // One that falls to 0.1 holds, as does one that falls by less than its rounding, from 0 or close to it.
        for c in [&[1.0, -0.9][..], &[0.0, -1e-14], &[1e-13, -2e-13], &[0.0, 0.0, -1e-13], &[0.0]] {
            assert_eq!(rest(c), (f64::INFINITY, None), "{c:?}");
        }
        let (told, end) = rest(&[1.0, -2.0]);
        assert!((0.0..=0.5).contains(&told) && (end.unwrap() - 0.5).abs() < 1e-15, "{told} {end:?}");
        // (t − ½)² − 1e-8
        let (told, end) = rest(&[0.25 - 1e-8, -1.0, 1.0]);
        assert!(told <= 0.4999 && (end.unwrap() - 0.4999).abs() < 1e-11, "{told} {end:?}");
        // It begins to pull, by nothing, and presses again: for good, or until t² = 5t⁴.
        assert_eq!(rest(&[0.0, -1e-14, 1.0]), (f64::INFINITY, None));
        let (told, end) = rest(&[0.0, -1e-14, 1.0, 0.0, -5.0]);
        assert!(told < 0.447 && (end.unwrap() - 0.2f64.sqrt()).abs() < 1e-12, "{told} {end:?}");
    }
}
