//! Modes and contacts: a structure as everything above sees it.

use std::sync::Arc;

use rustfft::num_complex::Complex;

use super::contact::Contact;
use super::error::StructureError;
use super::linear_mode::LinearMode;
use super::operator::SparseOperator;
use crate::kernel::turn::Turn;

type C = Complex<f64>;

/// The slower pole of an overdamped mode is a difference, δ − κ, about δ/2ζ²: of larger damping ratios ζ no four digits are left of it.
pub(super) const MOST_DAMPING: f64 = 7e5;

/// A linear structure by its modes, with contacts, static load and periodic loads.
///
/// ```
/// use vibrochain_lattice::{Complex, Contact, LinearMode, ModalStructure, ModeShape};
/// // q″ + 0.1 q′ + q = cos ωt, a stop at 0.1.
/// let shape = ModeShape { contacts: vec![1.0], coordinates: vec![1.0], still: 0.0 };
/// let mode = LinearMode::oscillator(0.05, 1.0 - 0.05 * 0.05, &shape, &[Complex::new(1.0, 0.0)]);
/// let stop = Contact { lower: None, upper: Some(0.1), restitution: 0.8 };
/// let structure = ModalStructure::new(vec![stop], vec![1], vec![mode])?;
/// let swing = structure.steady_at(0, 2.0)?[0];
/// let exact = Complex::new(1.0 - 4.0, 0.2).inv();
/// assert!((swing - exact).norm() < 1e-15 && (structure.mobility(0, 0) - 1.0).abs() < 1e-15);
/// # Ok::<(), vibrochain_lattice::StructureError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct ModalStructure {
    contacts: Vec<Contact>,
    harmonics: Vec<u32>,
    pub(super) modes: Arc<Vec<LinearMode>>,
    operator: Option<Arc<SparseOperator>>,
}

impl ModalStructure {
    /// A structure of contacts, harmonics of the loads and modes.
    ///
    /// # Errors
    /// [`StructureError`] where a mode does not have the shapes of all contacts or the loads of all harmonics, or is so
    /// overdamped that numbers do not hold its slow motion, where a contact has no barrier, or nothing can hit it.
    pub fn new(contacts: Vec<Contact>, harmonics: Vec<u32>, modes: Vec<LinearMode>) -> Result<Self, StructureError> {
        if contacts.is_empty() {
            return Err(StructureError::NoContact);
        }
        for (number, contact) in contacts.iter().enumerate() {
            contact.check(number)?;
        }
        for (k, mode) in modes.iter().enumerate() {
            // That of a rigid mode with a dashpot is 0.
            let slow = (mode.decay - mode.rate).abs();
            if mode.turn == Turn::Hyperbolic && slow > 0.0 && mode.decay > 2.0 * MOST_DAMPING * MOST_DAMPING * slow {
                return Err(StructureError::Overdamped { mode: k, ratio: (0.5 * mode.decay / slow).sqrt() });
            }
            let sizes = [
                ("the shape at contacts", mode.rows.len(), contacts.len()),
                ("the shape at contacts", mode.columns.len(), contacts.len()),
                ("the load", mode.loads.len(), harmonics.len()),
                ("the shape", mode.coordinates.len(), modes[0].coordinates.len()),
            ];
            for (what, given, wanted) in sizes {
                if given != wanted {
                    return Err(StructureError::Size { what: format!("{what} of mode {k}"), given, wanted });
                }
            }
            let own = [mode.still, [mode.decay, mode.rate]];
            let real = mode.rows.iter().chain(&mode.columns).chain(&own).flatten().copied();
            let complex = mode.loads.iter().flatten().flat_map(|load| [load.re, load.im]);
            if let Some(value) = real.chain(complex).find(|value| !value.is_finite()) {
                let what = format!("mode {k}");
                return Err(StructureError::Range { what, value, requirement: "finite numbers" });
            }
        }
        let structure = Self { contacts, harmonics, modes: Arc::new(modes), operator: None };
        for contact in 0..structure.contacts.len() {
            let mobility = structure.mobility(contact, contact);
            let sound = mobility > 0.0;
            if !sound {
                return Err(StructureError::NoWeight { contact });
            }
        }
        Ok(structure)
    }

    /// The same of the `kept` slowest modes, if not of all: a contact may move in none of these.
    pub(super) fn keeping(
        kept: Option<usize>,
        contacts: Vec<Contact>,
        harmonics: Vec<u32>,
        modes: Vec<LinearMode>,
    ) -> Result<Self, StructureError> {
        Self::new(contacts, harmonics, modes).map_err(|error| match (error, kept) {
            (StructureError::NoWeight { contact }, Some(modes)) => StructureError::Unmoved { contact, modes },
            (error, _) => error,
        })
    }

    pub(super) fn with_operator(self, operator: Option<SparseOperator>) -> Self {
        Self { operator: operator.map(Arc::new), ..self }
    }

    /// The equations of motion by coordinates, with what pulls at each. `None` where only modes are given, where some modes are left out, and where the
    /// mass matrix is not diagonal.
    pub fn operator(&self) -> Option<&Arc<SparseOperator>> {
        self.operator.as_ref()
    }

    /// The contacts.
    pub fn contacts(&self) -> &[Contact] {
        &self.contacts
    }

    /// The modes.
    pub fn modes(&self) -> &[LinearMode] {
        &self.modes
    }

    /// Numbers j of the harmonics of the loads.
    pub fn harmonics(&self) -> &[u32] {
        &self.harmonics
    }

    /// How many coordinates can be looked at.
    pub fn coordinates(&self) -> usize {
        self.modes.first().map_or(0, |mode| mode.coordinates.len())
    }

    /// Other barriers and restitutions of the same contacts.
    ///
    /// # Errors
    /// As [`ModalStructure::new`].
    pub fn with_contacts(self, contacts: Vec<Contact>) -> Result<Self, StructureError> {
        self.check_contacts(&contacts)?;
        Ok(Self { contacts, ..self })
    }

    /// Whether it can have these contacts instead of its own.
    ///
    /// # Errors
    /// As [`ModalStructure::with_contacts`].
    pub fn check_contacts(&self, contacts: &[Contact]) -> Result<(), StructureError> {
        let (given, wanted) = (contacts.len(), self.contacts.len());
        if given != wanted {
            return Err(StructureError::Size { what: "the list of contacts".to_owned(), given, wanted });
        }
        for (number, contact) in contacts.iter().enumerate() {
            contact.check(number)?;
        }
        Ok(())
    }

    /// All periodic loads times `factor`, the static one times `still`.
    pub fn with_loads_times(&self, factor: f64, still: f64) -> Self {
        self.clone().into_loads_times(factor, still)
    }

    /// The same of a structure that is not needed otherwise: its modes are not copied.
    #[must_use]
    pub fn into_loads_times(self, factor: f64, still: f64) -> Self {
        let mut structure = self;
        if (factor, still) == (1.0, 1.0) {
            return structure;
        }
        for mode in Arc::make_mut(&mut structure.modes) {
            mode.loads.iter_mut().flatten().for_each(|load| *load *= factor);
            mode.still.iter_mut().for_each(|load| *load *= still);
            mode.errors.loads.iter_mut().for_each(|error| *error *= factor.abs());
            mode.errors.still *= still.abs();
        }
        if let Some(operator) = structure.operator.as_mut().map(Arc::make_mut) {
            operator.loads.iter_mut().flatten().for_each(|load| *load *= factor);
        }
        structure
    }

    /// Whether a periodic load drives it.
    pub fn is_forced(&self) -> bool {
        self.modes.iter().any(|mode| mode.loads.iter().flatten().any(|load| *load != C::default()))
    }

    /// Whether neither dashpots nor impacts take energy, nor give any.
    pub fn is_lossless(&self) -> bool {
        self.modes.iter().all(|mode| mode.decay == 0.0)
            && self.contacts.iter().all(|contact| contact.restitution == 1.0)
    }

    /// Whether a periodic motion has a period of its own: no load gives it one, and losses leave no family of periods.
    pub fn has_own_period(&self) -> bool {
        !self.is_forced() && !self.is_lossless()
    }

    /// w_iᵀM⁻¹w_j: the velocity that a unit impulse at one contact gives to another.
    pub fn mobility(&self, to: usize, from: usize) -> f64 {
        self.modes.iter().map(|mode| mode.turn.pair(mode.rows[to], mode.generator(), mode.columns[from])).sum()
    }

    /// The mass that an impact of a contact feels, 1/(wᵀM⁻¹w): that of the modes there are.
    pub fn effective_mass(&self, contact: usize) -> f64 {
        1.0 / self.mobility(contact, contact)
    }

    /// A bound of the error of [`ModalStructure::mobility`] by those of the modes.
    pub fn mobility_error(&self, to: usize, from: usize) -> f64 {
        self.modes.iter().map(|mode| mode.errors_between(to, from) * mode.decay.hypot(mode.rate)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structure::linear_mode::ModeShape;

    /// Of ζ = 10⁶ the slow pole −1/2ζ is below rounding of δ; a mass on a dashpot alone has it at 0, exactly.
    #[test]
    fn overdamped_modes_without_digits_are_refused() {
        let stop = Contact { lower: None, upper: Some(1.0), restitution: 0.9 };
        let shape = ModeShape { contacts: vec![1.0], coordinates: Vec::new(), still: 0.0 };
        let with = |decay: f64, square: f64| {
            let mode = LinearMode::oscillator(decay, square - decay * decay, &shape, &[]);
            ModalStructure::new(vec![stop], Vec::new(), vec![mode])
        };
        for damping in [0.0, 0.5, 1.0, 30.0, 1e4, 1e5] {
            assert!(with(damping, 1.0).is_ok(), "{damping}");
        }
        let error = with(1e6, 1.0).unwrap_err();
        assert!(matches!(error, StructureError::Overdamped { mode: 0, .. }), "{error}");
        assert!(with(1e8, 0.0).is_ok());
    }
}
