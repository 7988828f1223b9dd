//! Numbers of a scene by name, and the model at their values.

use std::sync::Arc;

use vibrochain_breather::LoadedStructure;
use vibrochain_lattice::{Contact, DampedChain, EnergyForm, ModalStructure};

use super::StructureScene;
use crate::structure::setting::Setting;

impl StructureScene {
    /// The value of a number of it.
    #[must_use]
    pub fn get(&self, setting: Setting) -> Option<f64> {
        match setting {
            Setting::Omega => self.omega,
            Setting::Load => Some(self.load),
            Setting::Static => Some(self.still),
            Setting::Damping => Some(self.definition.chain().map_or(self.damping, |chain| chain.damping)),
            Setting::CouplingDamping => Some(self.definition.chain()?.coupling_damping),
            Setting::Gamma1 => Some(self.definition.chain()?.gamma1),
            Setting::Gamma2 => Some(self.definition.chain()?.gamma2),
            Setting::Asymmetry => {
                self.contacts.iter().find_map(|contact| Some(0.5 * (contact.lower? + contact.upper?)))
            }
            Setting::RestitutionOfAll => self.contacts.first().map(|contact| contact.restitution),
            Setting::Lower(contact) => self.contacts.get(contact)?.lower,
            Setting::Upper(contact) => self.contacts.get(contact)?.upper,
            Setting::Restitution(contact) => Some(self.contacts.get(contact)?.restitution),
            Setting::Entry(..) | Setting::LoadOf(_) | Setting::StaticOf(_) => self.definition.entry(setting),
        }
    }

    /// Another value of a number.
    ///
    /// # Errors
    /// A contact that is not there, a value out of its range.
    pub fn set(&mut self, setting: Setting, value: f64) -> Result<(), String> {
        if !value.is_finite() {
            return Err(format!("{setting} = {value} is out of range: give a finite number"));
        }
        let count = self.contacts.len();
        let contacts = &mut self.contacts;
        let mut contact = |number: usize, change: fn(&mut Contact, f64)| {
            let place = contacts.get_mut(number);
            let place = place.ok_or_else(|| format!("{setting}: the structure has the contacts 0 to {}", count - 1))?;
            change(place, value);
            Ok::<(), String>(())
        };
        match setting {
            Setting::Omega if value <= 0.0 => {
                return Err(format!("omega = {value} is out of range: give a positive number"));
            }
            Setting::Omega => self.omega = Some(value),
            Setting::Load => self.load = value,
            Setting::Static => self.still = value,
            Setting::Damping if self.definition.chain().is_none() => {
                self.with_modes(value)?;
                self.damping = value;
            }
            Setting::Damping | Setting::CouplingDamping | Setting::Gamma1 | Setting::Gamma2 => {
                let change = |chain: &mut DampedChain| {
                    let place = match setting {
                        Setting::Damping => &mut chain.damping,
                        Setting::CouplingDamping => &mut chain.coupling_damping,
                        Setting::Gamma1 => &mut chain.gamma1,
                        _ => &mut chain.gamma2,
                    };
                    *place = value;
                };
                let changed = self.definition.with_chain(change);
                let changed =
                    changed.ok_or_else(|| format!("{setting} is of chains: this structure has matrices or modes"))?;
                self.definition = Arc::new(changed);
                self.with_modes(1.0)?;
            }
            Setting::Entry(..) | Setting::LoadOf(_) | Setting::StaticOf(_) => {
                self.definition = Arc::new(self.definition.with_entry(setting, value)?);
                self.with_modes(self.damping)?;
            }
            Setting::Asymmetry => self.contacts.iter_mut().for_each(|contact| {
                if let (Some(lower), Some(upper)) = (contact.lower, contact.upper) {
                    let half = 0.5 * (upper - lower);
                    (contact.lower, contact.upper) = (Some(value - half), Some(value + half));
                }
            }),
            Setting::RestitutionOfAll => self.contacts.iter_mut().for_each(|contact| contact.restitution = value),
            Setting::Lower(number) => contact(number, |contact, value| contact.lower = Some(value))?,
            Setting::Upper(number) => contact(number, |contact, value| contact.upper = Some(value))?,
            Setting::Restitution(number) => contact(number, |contact, value| contact.restitution = value)?,
        }
        self.modal.check_contacts(&self.contacts).map_err(|error| error.to_string())
    }

    /// The structure with its values as they are now.
    ///
    /// # Errors
    /// Barriers out of order, a restitution out of range.
    pub fn structure(&self) -> Result<Arc<ModalStructure>, String> {
        if self.load == 1.0 && self.still == 1.0 && self.modal.contacts() == self.contacts {
            return Ok(self.modal.clone());
        }
        let structure = self.modal.with_loads_times(self.load, self.still).with_contacts(self.contacts.clone());
        structure.map(Arc::new).map_err(|error| error.to_string())
    }

    /// The model of a scene of which nothing else is asked: its modes are not copied.
    ///
    /// # Errors
    /// As [`StructureScene::model`].
    pub(crate) fn into_model(mut self) -> Result<LoadedStructure, String> {
        self.modal = Arc::new(Arc::unwrap_or_clone(self.modal).into_loads_times(self.load, self.still));
        (self.load, self.still) = (1.0, 1.0);
        self.model()
    }

    /// The model with its values as they are now.
    ///
    /// # Errors
    /// As [`StructureScene::structure`]; a frequency that is missing.
    pub fn model(&self) -> Result<LoadedStructure, String> {
        let structure = self.structure()?;
        // Any frequency serves where nothing has it.
        let omega = self.omega.or(structure.has_own_period().then_some(1.0));
        let omega = omega.ok_or("omega is missing: give omega = … in the scene, or --omega")?;
        let model = LoadedStructure::new(structure, omega).map_err(|error| error.to_string())?;
        Ok(model.until(&self.stop))
    }

    /// Coordinates ξ of all modes of displacements and velocities of the coordinates.
    ///
    /// # Errors
    /// Lists that are too long or too short; a modal model, which has no coordinates.
    pub fn modes_of(&self, displacement: &[f64], velocity: &[f64]) -> Result<Vec<[f64; 2]>, String> {
        self.definition.project(&self.modal, displacement, velocity, self.damping)
    }

    /// Energies and powers in the coordinates of the modes; `None` of modes of complex shape without matrices.
    ///
    /// # Errors
    /// As [`StructureScene::structure`].
    pub fn energy_form(&self) -> Result<Option<EnergyForm>, String> {
        Ok(self.definition.energy_form(self.structure()?.as_ref(), [self.load, self.still, self.damping]))
    }
}
