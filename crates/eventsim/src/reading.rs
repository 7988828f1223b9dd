//! What a structure in flight tells at any time of its window.

use crate::flight::Flight;
use crate::flight::approach::Approach;
use crate::motion::Motion;
use vibrochain_lattice::EnergyForm;

impl Motion {
    /// ξ of all modes at `s` since the base, from their equilibrium.
    pub(crate) fn modes_at(&self, s: f64) -> Vec<[f64; 2]> {
        if self.system.modes().is_empty() {
            return Vec::new();
        }
        match (&self.flight, &self.series) {
            (Flight::Local(flight), _) => {
                let [place, velocity] = flight.at(s);
                flight.local.operator.project(self.system.modes(), &place, &velocity)
            }
            (Flight::Modes(flight), Some(series)) if !series.forces.is_empty() => {
                (0..flight.xi.len()).map(|k| series.mode(k, s / series.length)).collect()
            }
            (Flight::Modes(flight), _) => flight.all_at(&self.system, s),
        }
    }

    /// Coordinates that are known.
    pub(crate) fn coordinates(&self) -> usize {
        match &self.flight {
            Flight::Local(flight) => flight.local.operator.masses.len(),
            Flight::Modes(_) => self.system.modes().first().map_or(0, |mode| mode.coordinates.len()),
        }
    }

    /// q and q′ of the first coordinates at `s`.
    pub(crate) fn read(&self, s: f64, [place, velocity]: [&mut [f64]; 2]) {
        if let Flight::Local(flight) = &self.flight {
            flight.read(s, [&mut *place, velocity]);
            place.iter_mut().zip(&flight.local.equilibrium).for_each(|(place, held)| *place += held);
            return;
        }
        let measured = self.modes_at(s);
        let turned = self.system.loads.later(self.flight.turned(), s);
        place.fill(0.0);
        velocity.fill(0.0);
        for (k, (mode, xi)) in self.system.modes().iter().zip(self.system.absolute(&measured)).enumerate() {
            let given = self.system.loads.given(k, &turned);
            let rise = mode.turn.act(mode.generator(), measured[k]);
            for ((row, place), velocity) in mode.coordinates.iter().zip(&mut *place).zip(&mut *velocity) {
                *place += row[0] * xi[0] + row[1] * xi[1];
                *velocity += row[0] * (rise[0] + given[0]) + row[1] * (rise[1] + given[1]);
            }
        }
    }

    /// ½Σm q′² + ½qᵀKq at `s`; `None` of modes of complex shape.
    pub(crate) fn energy_at(&self, s: f64) -> Option<f64> {
        let Flight::Local(flight) = &self.flight else {
            let form = self.system.structure.as_ref()?.energy_form()?;
            return Some(form.energy(&self.system.absolute(&self.modes_at(s))));
        };
        let n = self.coordinates();
        let (mut place, mut velocity) = (vec![0.0; n], vec![0.0; n]);
        self.read(s, [&mut place, &mut velocity]);
        Some(flight.local.operator.energy(&place, &velocity))
    }

    /// The longest window there may be.
    pub(crate) fn longest_window(&self) -> f64 {
        match &self.flight {
            Flight::Local(flight) => flight.local.horizons.into_iter().fold(0.0, f64::max) / flight.local.scale,
            Flight::Modes(_) => self.system.longest,
        }
    }

    /// The force on a contact at rest at `s`, positive towards larger g.
    pub(crate) fn force_at(&self, contact: usize, s: f64) -> f64 {
        match (&self.flight, &self.series) {
            (Flight::Local(flight), _) => flight.force_at(&self.system, contact, s),
            (_, Some(series)) => series.force(contact, s / series.length),
            _ => 0.0,
        }
    }

    /// x, measured as at the base, and v of a contact at `s`.
    pub(crate) fn contact_at(&self, contact: usize, s: f64) -> (f64, f64) {
        let place = &self.places[contact];
        match (&self.flight, &self.series) {
            (Flight::Local(flight), _) => flight.contact_at(contact, place, s),
            (_, Some(series)) => series.contact(contact, s / series.length),
            (Flight::Modes(flight), None) => {
                let approach = Approach { system: &self.system, flight, contact, place };
                let view = approach.view(s, 0.0, &mut Vec::new());
                (view.x, view.v)
            }
        }
    }

    /// Work of the loads and what dashpots take, a unit of time, at `s`.
    pub(crate) fn powers_at(&self, form: Option<&EnergyForm>, s: f64) -> [f64; 2] {
        let turned = self.system.loads.later(self.flight.turned(), s);
        if let Flight::Local(flight) = &self.flight {
            return flight.local.powers(&flight.at(s)[1], &turned);
        }
        let Some(form) = form else { return [0.0; 2] };
        let xi = self.system.absolute(&self.modes_at(s));
        // The first of the loads is the static one.
        [form.power(&xi, &turned[1..]), form.dissipation(&xi)]
    }
}
