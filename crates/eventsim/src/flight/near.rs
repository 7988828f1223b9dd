//! What contacts do at an instant: derivatives of low order and forces at rest, whichever way the structure flies.

use std::sync::Arc;

use crate::flight::local::{Local, LocalSeries};
use crate::flight::places::Place;
use crate::flight::rest_series::{LOW, Series};
use crate::flight::system::System;
use crate::watch::Contact;
use vibrochain_lattice::Barrier;

/// Derivatives of contacts, and the forces on those at rest.
pub(crate) enum Tendencies {
    Modes(Series),
    Local(Box<LocalSeries>, Arc<Local>),
}

impl LocalSeries {
    /// The k-th derivative of a contact, in internal time, whatever it does.
    pub(crate) fn derivative(&self, local: &Local, contact: usize, k: usize) -> f64 {
        local.operator.contacts[contact].iter().map(|(place, weight)| weight * self.rows.get(k, *place)).sum()
    }

    /// The number of a contact at rest among those that are held.
    pub(crate) fn held_as(&self, contact: usize) -> Option<usize> {
        self.held.contacts.iter().position(|(other, _)| *other == contact)
    }

    /// Rounding of the derivatives of a contact, of low orders.
    fn doubts(&self, local: &Local, contact: usize) -> [f64; LOW + 1] {
        let [stiffness, damping] = local.operator.entries(None);
        let n = local.operator.masses.len();
        let row = |k: usize| (0..n).map(|place| self.rows.get(k, place).abs()).collect::<Vec<_>>();
        let rows: Vec<Vec<f64>> = (0..=LOW).map(row).collect();
        let mut doubts: Vec<Vec<f64>> =
            rows[..2].iter().map(|row| row.iter().map(|d| f64::EPSILON * d).collect()).collect();
        let (scale, square) = (local.scale, local.scale * local.scale);
        for k in 0..LOW - 1 {
            // What it is short of its own, and what its terms are rounded by.
            let mut next: Vec<f64> = rows[k + 2].iter().map(|d| f64::EPSILON * d).collect();
            for (entries, from, unit) in [(&stiffness, k, square), (&damping, k + 1, scale)] {
                for (place, other, entry) in entries {
                    next[*place] += (entry / unit).abs() * (doubts[from][*other] + f64::EPSILON * rows[from][*other]);
                }
            }
            doubts.push(next);
        }
        let of = |k: usize| local.operator.contacts[contact].iter().map(|(place, w)| w.abs() * doubts[k][*place]).sum();
        std::array::from_fn(of)
    }
}

impl Tendencies {
    /// g″ and g‴ of a contact that moves.
    pub(crate) fn bends(&self, contact: usize) -> [f64; 2] {
        match self {
            Self::Local(series, local) => {
                let [second, third] = [2, 3].map(|k| series.derivative(local, contact, k));
                [second * local.scale.powi(2), third * local.scale.powi(3)]
            }
            Self::Modes(series) => {
                let (c, h) = (series.contacts[contact], series.length);
                [2.0 * c[2] / (h * h), 6.0 * c[3] / (h * h * h)]
            }
        }
    }

    /// The force on a contact at rest at the base, positive towards larger g.
    pub(crate) fn force(&self, contact: usize) -> f64 {
        match self {
            Self::Local(series, local) => {
                series.held_as(contact).map_or(0.0, |i| series.forces[i][0] * local.scale.powi(2))
            }
            Self::Modes(series) => series.force(contact, 0.0),
        }
    }

    /// Of all contacts at rest the force with which the barrier pushes, below 0 where it would have to pull, over its rounding.
    pub(crate) fn pushes(&self, system: &System) -> Vec<(usize, Barrier, f64, f64)> {
        match self {
            Self::Local(series, local) => {
                let of = |(i, (contact, barrier)): (usize, &(usize, Barrier))| {
                    let doubt = 8.0 * series.doubts(local, *contact)[2] / system.mobility(*contact, *contact);
                    (*contact, *barrier, -barrier.sign() * series.forces[i][0], doubt)
                };
                series.held.contacts.iter().enumerate().map(of).collect()
            }
            Self::Modes(series) => {
                let forces = series.forces.iter();
                forces.map(|f| (f.contact, f.barrier, f.push[0], series.force_doubt(system, f.contact))).collect()
            }
        }
    }

    /// The order, from `from` on, of the first derivative that takes a contact off its barrier or presses it against it, and whether it
    /// presses. `None`: no force that rounding could tell.
    pub(crate) fn tendency(
        &self,
        (contact, place): (usize, &Place),
        barrier: Barrier,
        from: usize,
    ) -> Option<(u8, bool)> {
        match self {
            Self::Local(series, local) => {
                let doubts = series.doubts(local, contact);
                let first = match place.touch {
                    Contact::Leaving(_, m) => usize::from(m),
                    Contact::Resting(_) => return None,
                    Contact::Free => 0,
                };
                (from.max(first)..=LOW).find_map(|k| {
                    let outward = barrier.sign() * series.derivative(local, contact, k);
                    (outward.abs() > 4.0 * doubts[k]).then_some((k as u8, outward > 0.0))
                })
            }
            Self::Modes(series) => series.tendency(contact, barrier, from),
        }
    }
}
