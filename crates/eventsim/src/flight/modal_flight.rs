//! Exact flight in modes, from a base.

use crate::flight::loads::add;
use crate::flight::system::System;
use vibrochain_lattice::{Complex, LinearMode};

/// Coordinates of all modes at the base.
#[derive(Debug, Clone)]
pub(crate) struct ModalFlight {
    /// e^{iw(t+ψ)} of each load.
    pub(crate) turned: Vec<Complex<f64>>,
    /// ξ of each mode.
    pub(crate) xi: Vec<[f64; 2]>,
    /// ξ without what loads make steadily.
    pub(crate) free: Vec<[f64; 2]>,
}

impl ModalFlight {
    /// From ξ, at a time within a period.
    pub(crate) fn new(system: &System, xi: Vec<[f64; 2]>, offset: f64) -> Self {
        let turned = system.loads.turned(offset);
        let mut flight = Self { turned, free: Vec::with_capacity(xi.len()), xi };
        flight.refresh(system);
        flight
    }

    fn refresh(&mut self, system: &System) {
        self.free.clear();
        for (k, xi) in self.xi.iter().enumerate() {
            let steady = system.loads.steady(k, &self.turned);
            self.free.push([xi[0] - steady[0], xi[1] - steady[1]]);
        }
    }

    /// ξ of mode `k` at `s` since the base, where loads are `turned` on.
    pub(crate) fn at(&self, system: &System, k: usize, s: f64, turned: &[Complex<f64>]) -> [f64; 2] {
        let mode = &system.modes()[k];
        let free = mode.turn.act(mode.flight(s), self.free[k]);
        let (moved, _) = system.loads.since(mode, k, &self.turned, s);
        add(add(free, moved), system.loads.steady(k, turned))
    }

    /// ξ of all modes.
    pub(crate) fn all_at(&self, system: &System, s: f64) -> Vec<[f64; 2]> {
        if s == 0.0 {
            return self.xi.clone();
        }
        let turned = system.loads.later(&self.turned, s);
        (0..self.xi.len()).map(|k| self.at(system, k, s, &turned)).collect()
    }

    /// An impulse at a contact.
    pub(crate) fn strike(&mut self, system: &System, contact: usize, impulse: f64) {
        let states = self.xi.iter_mut().zip(&mut self.free);
        for ((xi, free), mode) in states.zip(system.modes()) {
            let given = if mode.is_real {
                // As the column, which is row/κ, but with its rounding anew: that of the column would come back with every impact.
                [0.0, mode.rows[contact][0] * impulse / mode.rate]
            } else {
                mode.columns[contact].map(|column| column * impulse)
            };
            (*xi, *free) = (add(*xi, given), add(*free, given));
        }
    }

    /// Moves contact `contact` without moving it on: M⁻¹w times `amount` is added to the coordinates. Velocities change with the
    /// dashpots; who holds the contact takes that off again.
    pub(crate) fn shift(&mut self, system: &System, contact: usize, amount: f64) {
        let states = self.xi.iter_mut().zip(&mut self.free);
        for ((xi, free), mode) in states.zip(system.modes()) {
            let given = mode.turn.act(mode.generator(), mode.columns[contact]).map(|column| column * amount);
            (*xi, *free) = (add(*xi, given), add(*free, given));
        }
    }

    /// Moves contact `contact` by `amount` as a slow force at it does: stiff modes, in which rounding would be energy, move next to nothing.
    pub(crate) fn lean(&mut self, system: &System, contact: usize, amount: f64) {
        let slow = Complex::new(system.omega, 0.0);
        let answer = |mode: &LinearMode| {
            let by = mode.generator().resolvent(mode.turn, slow);
            let [first, second] = mode.columns[contact];
            mode.turn.act(by, [Complex::new(first, 0.0), Complex::new(second, 0.0)]).map(|xi| xi.re)
        };
        let answers: Vec<[f64; 2]> = system.modes().iter().map(answer).collect();
        let moved: f64 =
            system.seen_by(contact).map(|(k, _, row)| row[0] * answers[k][0] + row[1] * answers[k][1]).sum();
        let factor = amount / moved;
        // (The frequency may be a real pole of a mode that feeds itself.)
        if !factor.is_finite() {
            return;
        }
        for ((xi, free), answer) in self.xi.iter_mut().zip(&mut self.free).zip(answers) {
            let given = answer.map(|answer| answer * factor);
            (*xi, *free) = (add(*xi, given), add(*free, given));
        }
    }

    /// g of a contact at the base.
    pub(crate) fn place(&self, system: &System, contact: usize) -> f64 {
        system.seen_by(contact).map(|(k, _, row)| row[0] * self.xi[k][0] + row[1] * self.xi[k][1]).sum()
    }

    /// How far its modes swing and its loads move it, whatever its g is now: in flight g has some units in the last place of that as its
    /// rounding. Of a rigid mode, which swings nowhere, its place.
    pub(crate) fn scale(&self, system: &System, contact: usize) -> f64 {
        let of_mode = |(k, mode, row): (usize, &LinearMode, [f64; 2])| {
            let (xi, free) = (self.xi[k], self.free[k]);
            let steady = (row[0] * (xi[0] - free[0])).abs() + (row[1] * (xi[1] - free[1])).abs();
            let own = if mode.is_rigid() {
                (row[0] * free[0]).abs() + (row[1] * free[1]).abs()
            } else {
                row[0].hypot(row[1]) * free[0].hypot(free[1])
            };
            steady + own
        };
        system.seen_by(contact).map(of_mode).sum()
    }

    /// The same of g′: the sizes of the velocities that it is a sum of.
    pub(crate) fn pace(&self, system: &System, contact: usize) -> f64 {
        let of_mode = |(k, mode, row): (usize, &LinearMode, [f64; 2])| {
            let rise = self.rise(system, k);
            let now = (row[0] * rise[0]).abs() + (row[1] * rise[1]).abs();
            let swing = row[0].hypot(row[1]) * self.free[k][0].hypot(self.free[k][1]);
            if mode.is_rigid() { now } else { now.max((mode.rate + mode.decay.abs()) * swing) }
        };
        system.seen_by(contact).map(of_mode).sum()
    }

    /// ξ′ of a mode at the base, without forces at contacts.
    pub(crate) fn rise(&self, system: &System, k: usize) -> [f64; 2] {
        let mode = &system.modes()[k];
        add(mode.turn.act(mode.generator(), self.xi[k]), system.loads.given(k, &self.turned))
    }

    /// g′ of a contact at the base.
    pub(crate) fn velocity(&self, system: &System, contact: usize) -> f64 {
        let of_mode = |(k, _, row): (usize, _, [f64; 2])| {
            let rise = self.rise(system, k);
            row[0] * rise[0] + row[1] * rise[1]
        };
        system.seen_by(contact).map(of_mode).sum()
    }
}
