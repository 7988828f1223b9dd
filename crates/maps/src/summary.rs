//! What the cells of a sweep add up to.

use crate::absence::Absence;
use crate::cell::{Cell, Class, Status};
use crate::obstructions::Obstructions;

/// Excess of a period that a look at the breather does not show: under a force nearly all double-sided breathers radiate into the ring and
/// grow, most of them by less than this, which is what `--threshold` is for.
pub const SLOW: f64 = 0.01;

/// Counts of a finished sweep.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Summary {
    /// Cells per class, in the order of [`Class::ALL`].
    pub classes: [u64; Class::ALL.len()],
    /// Cells per status, in the order of [`Status::ALL`].
    pub statuses: [u64; Status::ALL.len()],
    /// Largest residual of any physical orbit.
    pub worst_residual: f64,
    /// Cells with an unstable breather that grows by less than [`SLOW`] a period.
    pub slow: u64,
    /// Cells without a physical orbit per reason, in the order of [`Absence::ALL`], where a scene tells it.
    pub absences: [u64; Absence::ALL.len()],
    /// And of those where a contact is in the way, which one and after which impact.
    pub obstructions: Obstructions,
    /// Cells that were computed.
    pub computed: u64,
}

impl Summary {
    /// Of these cells.
    pub fn of(cells: &[Cell]) -> Self {
        let mut summary = Self::default();
        cells.iter().for_each(|cell| summary.count(cell));
        summary
    }

    /// Counts one more.
    pub fn count(&mut self, cell: &Cell) {
        if let Some(class) = cell.class {
            self.classes[class as usize] += 1;
            let slow = |radius: f64| radius - 1.0 < SLOW;
            if matches!(class, Class::UnstableDouble | Class::UnstableSingle | Class::UnstableWord)
                && cell.spectral_radius.is_some_and(slow)
            {
                self.slow += 1;
            }
        }
        self.statuses[cell.status as usize] += 1;
        if let Some(absence) = cell.absence {
            self.absences[absence as usize] += 1;
            if let Some(first) = cell.obstruction {
                self.obstructions.count(absence, first);
            }
        }
        self.computed += 1;
        self.worst_residual = self.worst_residual.max(cell.residual);
    }

    /// Adds the counts of other cells.
    pub fn add(&mut self, other: &Self) {
        self.classes.iter_mut().zip(other.classes).for_each(|(count, more)| *count += more);
        self.statuses.iter_mut().zip(other.statuses).for_each(|(count, more)| *count += more);
        self.absences.iter_mut().zip(other.absences).for_each(|(count, more)| *count += more);
        self.obstructions.add(&other.obstructions);
        self.worst_residual = self.worst_residual.max(other.worst_residual);
        self.slow += other.slow;
        self.computed += other.computed;
    }

    /// Cells of each name of a class, in the order of [`Class::ALL`]: classes may share one.
    pub fn by_name(&self, name: fn(Class) -> &'static str) -> Vec<(&'static str, u64)> {
        let mut counts: Vec<(&'static str, u64)> = Vec::new();
        for (class, count) in Class::ALL.into_iter().zip(self.classes) {
            match counts.iter_mut().find(|(known, _)| *known == name(class)) {
                Some((_, sum)) => *sum += count,
                None => counts.push((name(class), count)),
            }
        }
        counts
    }

    /// Number of cells counted.
    pub fn cells(&self) -> u64 {
        self.statuses.iter().sum()
    }
}
