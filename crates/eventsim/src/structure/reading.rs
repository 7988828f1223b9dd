//! What a structure in flight tells at any time of its window.

use super::approach::Approach;
use super::flight::Flight;
use super::motion::Motion;
use vibrochain_lattice::EnergyForm;

impl Motion {
    /// ξ of all modes at `s` since the base, from their equilibrium.
    pub(crate) fn modes_at(&self, s: f64) -> Vec<[f64; 2]> {
        match (&self.flight, &self.series) {
            (Flight::Local(flight), _) => {
                let [place, velocity] = flight.at(s);
                flight.local.operator.project(self.system.structure.modes(), &place, &velocity)
            }
            (Flight::Modes(flight), Some(series)) if !series.forces.is_empty() => {
                (0..flight.xi.len()).map(|k| series.mode(k, s / series.length)).collect()
            }
            (Flight::Modes(flight), _) => flight.all_at(&self.system, s),
        }
    }

    /// q and q′ at `s`, as far as the structure knows its coordinates; ξ of all modes.
    pub(crate) fn coordinates_at(&self, s: f64) -> ([Vec<f64>; 2], Vec<[f64; 2]>) {
        let measured = self.modes_at(s);
        let modes = self.system.absolute(&measured);
        if let Flight::Local(flight) = &self.flight {
            let [mut place, velocity] = flight.at(s);
            place.iter_mut().zip(&flight.local.equilibrium).for_each(|(place, held)| *place += held);
            return ([place, velocity], modes);
        }
        let turned = self.system.loads.later(self.flight.turned(), s);
        let coordinates = self.system.structure.coordinates();
        let (mut place, mut velocity) = (vec![0.0; coordinates], vec![0.0; coordinates]);
        for (k, (mode, xi)) in self.system.structure.modes().iter().zip(&modes).enumerate() {
            let given = self.system.loads.given(k, &turned);
            let rise = mode.turn.act(mode.generator(), measured[k]);
            for (i, row) in mode.coordinates.iter().enumerate() {
                place[i] += row[0] * xi[0] + row[1] * xi[1];
                velocity[i] += row[0] * (rise[0] + given[0]) + row[1] * (rise[1] + given[1]);
            }
        }
        ([place, velocity], modes)
    }

    /// The force on a contact at rest at `s`, positive towards larger g.
    pub(crate) fn force_at(&self, contact: usize, s: f64) -> f64 {
        match (&self.flight, &self.series) {
            (Flight::Local(flight), _) => flight.force_at(contact, s),
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
    pub(super) fn powers_at(&self, form: &EnergyForm, s: f64) -> [f64; 2] {
        let turned = self.system.loads.later(self.flight.turned(), s);
        if let Flight::Local(flight) = &self.flight {
            return flight.local.powers(&flight.at(s)[1], &turned);
        }
        let xi = self.system.absolute(&self.modes_at(s));
        // The first of the loads is the static one.
        [form.power(&xi, &turned[1..]), form.dissipation(&xi)]
    }
}
