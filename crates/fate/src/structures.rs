//! Ensembles over a structure's scene: many runs from the orbits of every point, or from rest.

use vibrochain_breather::{Finder, LoadedStructure};
use vibrochain_eventsim::State;
use vibrochain_floquet::stability;
use vibrochain_lattice::Stop;
use vibrochain_maps::cell::{Cell, Class, Status};
use vibrochain_maps::grid::Grid;
use vibrochain_maps::structure::map::RowOfModels;
use vibrochain_maps::structure::{Setting, StructureScene};

use crate::diagram::Sectioned;
use crate::ensemble::Ensemble;
use crate::fates::{Departure, Ensembled, Found, From};
use crate::origin::Origin;
use crate::run::Home;

/// An orbit as runs start from it, and whether it is stable where that is decided.
type Judged = (Departure, Option<bool>);

/// The physical orbits of all words that are asked for, and what a sweep says of their lists: where one is not complete, or something could not
/// be worked out, more may live here. `None` if stopped.
fn departures(scene: &StructureScene, model: &LoadedStructure, stop: &Stop) -> Option<(Vec<Judged>, Status)> {
    let (mut all, mut status, mut finder) = (Vec::new(), Status::Ok, Finder::default().until(stop));
    for (word, periods) in scene.asked() {
        let Ok(found) = model.candidates(&word, periods) else {
            status = Status::IllConditioned;
            continue;
        };
        status = status.max(Status::of_list(found.completeness));
        for orbit in &found.orbits {
            stop.heard().ok()?;
            let physical = finder.quick_admissibility(orbit).map(|answer| answer.is_physical());
            if matches!(physical, Ok(false)) {
                continue;
            }
            let known = stability(orbit, scene.tolerance);
            if physical.is_err() || known.is_err() {
                status = Status::IllConditioned;
            }
            let (Ok(_), Ok(home)) = (physical, Home::of(orbit)) else { continue };
            let home = home.in_sequence(scene.in_sequence);
            let known = known.ok();
            let verdict = known.as_ref().map(|known| known.verdict);
            let departure =
                Departure::of(all.len() as u32 + 1, orbit.full_name(), known.as_ref(), orbit.period(), home);
            all.push((departure, verdict.filter(|verdict| !verdict.undecided).map(|verdict| verdict.stable)));
        }
    }
    Some((all, status))
}

impl Ensembled for StructureScene {
    fn takes(&self, ensemble: &Ensemble, from: From) -> Result<(), String> {
        // A structure's lengths are its user's: any perturbation that leaves its contacts between their barriers is one.
        let checked = Ensemble { size: ensemble.size.min(1.0), ..*ensemble };
        checked.check(1).map_err(|error| error.to_string())?;
        if self.asked().is_empty() && from != From::Rest {
            let message =
                "from which orbits? give word = \"0+\" or [compute] with families in the scene, or --breathers rest";
            return Err(message.to_owned());
        }
        self.model().map(drop)
    }

    fn find(&self, number: u64, from: From, row: &mut RowOfModels, stop: &Stop) -> Option<Found> {
        if stop.is_raised() {
            return None;
        }
        let Ok(model) = row.model(self, number) else {
            let cell = Cell { class: None, status: Status::IllConditioned, ..Cell::EMPTY };
            return Some(Found { cell, departures: Vec::new() });
        };
        if from == From::Rest {
            let home = Home::at_rest(&model).in_sequence(self.in_sequence);
            let rest = Departure::of(1, From::Rest.name().to_owned(), None, 0.0, home);
            let rest = Departure { measured: false, ..rest };
            return Some(Found { cell: Cell::EMPTY, departures: vec![rest] });
        }
        let (mut all, status) = departures(self, &model, stop)?;
        let solutions = all.len() as u32;
        match from {
            From::Unstable => all.retain(|(_, stable)| *stable == Some(false)),
            From::Class => {
                let best = all.iter().position(|(_, stable)| *stable == Some(true)).unwrap_or(0);
                all = all.into_iter().skip(best).take(1).collect();
            }
            From::Every | From::Rest => {}
        }
        let class = match solutions {
            0 => (status < Status::NotConverged).then_some(Class::None),
            _ => Some(Class::Word),
        };
        let departures = all.into_iter().map(|(departure, _)| departure).collect();
        Some(Found { cell: Cell { class, solutions, status, ..Cell::EMPTY }, departures })
    }
}

impl Sectioned for StructureScene {
    /// The contacts of the scene's words; all where it names none.
    fn watched(&self) -> Vec<usize> {
        let asked = self.asked();
        let mut contacts: Vec<usize> =
            asked.iter().flat_map(|(word, _)| word.letters()).map(|letter| letter.site).collect();
        if contacts.is_empty() {
            contacts = (0..self.contacts().len()).collect();
        }
        contacts.sort_unstable();
        contacts.dedup();
        contacts
    }

    /// What is carried are the coordinates of its modes, which must mean the same in both.
    fn carries(&self) -> Result<(), String> {
        let changes = |parameter: Setting| match parameter {
            Setting::Omega | Setting::Load | Setting::Static | Setting::Asymmetry | Setting::RestitutionOfAll => false,
            Setting::Lower(_) | Setting::Upper(_) | Setting::Restitution(_) => false,
            Setting::LoadOf(_) | Setting::StaticOf(_) => false,
            Setting::Damping | Setting::CouplingDamping | Setting::Gamma1 | Setting::Gamma2 | Setting::Entry(..) => {
                true
            }
        };
        match self.axes.iter().find(|axis| changes(axis.parameter)) {
            Some(axis) => {
                let name = self.name_of(axis.parameter);
                Err(format!(
                    "--carry: the modes change with {name}, and a run goes on in the modes of the one before: leave it away"
                ))
            }
            None => Ok(()),
        }
    }

    fn origin(&self, cell: u64, state: Option<State>, row: &mut RowOfModels) -> Option<Origin> {
        let model = row.model(self, cell).ok()?;
        let modes = state.map_or_else(|| model.structure().still(), |state| state.modes);
        Some(Origin::at(&model, modes).in_sequence(self.in_sequence))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    use vibrochain_lattice::{Contact, LinearMode, ModalStructure, ModeShape};

    /// The size of a perturbation is the largest change of a contact's g, or of g′ over ω: of fast modes it is the velocity.
    #[test]
    fn a_perturbation_has_its_size_at_contacts() {
        let (mut places, mut velocities) = (0, 0);
        for omega in [0.05, 1.0, 40.0] {
            let stop = Contact { lower: None, upper: Some(10.0), restitution: 0.5 };
            let shapes = [[0.7, -0.2], [0.4, 0.9]];
            let mode = |k: usize| {
                let shape = ModeShape { contacts: shapes[k].to_vec(), coordinates: Vec::new(), still: 0.0 };
                LinearMode::oscillator(0.0, [1.0, 2.3][k], &shape, &[])
            };
            let structure = ModalStructure::new(vec![stop; 2], Vec::new(), vec![mode(0), mode(1)]).unwrap();
            let origin = Origin::at_rest(&LoadedStructure::new(Arc::new(structure), omega).unwrap());
            for seed in 0..20 {
                let size = 1e-3;
                let run = origin.run(Some((size, seed)), &Stop::default()).unwrap();
                let moved = run.contacts().iter().fold([0.0; 2], |most: [f64; 2], contact| {
                    [most[0].max(contact.place.abs()), most[1].max(contact.velocity.abs() / omega)]
                });
                assert!((moved[0].max(moved[1]) / size - 1.0).abs() < 1e-12, "{omega} {seed}: {moved:?}");
                places += usize::from(moved[0] > moved[1]);
                velocities += usize::from(moved[1] > moved[0]);
            }
        }
        assert!(places >= 20 && velocities >= 20, "{places} {velocities}");
    }
}
