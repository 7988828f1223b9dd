//! The lattice of a model as a structure, with contacts at some of its masses.

use rustfft::num_complex::Complex;

use super::contact::Contact;
use super::damped_chain::DampedChain;
use super::error::StructureError;
use super::modal::ModalStructure;
use crate::model::chain::Barrier;
use crate::model::params::Model;
use crate::modes::row::RowEnds;

impl Model {
    /// Its lattice as a structure with a contact at each of these lists of masses, in their order, between the model's barriers; the force is a load
    /// on all masses. Each mode keeps its shape at these masses alone. Of k masses in one list the contact sees √k times their mean, and gives each
    /// of them the same: as long as symmetry has them move alike these are its orbits.
    ///
    /// # Errors
    /// [`StructureError`] where there is no mass, or none of that number.
    ///
    /// ```
    /// use vibrochain_lattice::{Chain, Ends, Model};
    /// let chain = Chain::new(21, 0.2, 0.1)?.with_layers(2, 0.03, Ends::Free)?;
    /// let structure = Model::conservative(chain, 1.5, 0.4)?.structure(&[vec![0], vec![22]])?;
    /// assert_eq!((structure.modes().len(), structure.contacts().len()), (42, 2));
    /// assert!((structure.mobility(1, 1) - 1.0).abs() < 1e-14 && structure.mobility(0, 1).abs() < 1e-14);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn structure(&self, contacts: &[Vec<usize>]) -> Result<ModalStructure, StructureError> {
        let (chain, layout) = (self.chain(), self.chain().layout());
        let contact = |masses: &Vec<usize>| {
            let root = (masses.len() as f64).sqrt();
            let [lower, upper] = [Barrier::Lower, Barrier::Upper].map(|barrier| Some(root * self.barrier(barrier)));
            let seen = masses.iter().map(|&mass| (mass, root.recip())).collect();
            (seen, Contact { lower, upper, restitution: self.restitution() })
        };
        let on_all = |amplitude: f64, phase: f64| vec![Complex::from_polar(amplitude, phase); chain.sites()];
        let harmonics = self.force().harmonics().iter().filter(|harmonic| harmonic.amplitude != 0.0);
        let structure = DampedChain {
            layers: layout.layers,
            layer_ends: layout.layer_ends,
            gamma1: chain.gamma1(),
            gamma2: chain.gamma2(),
            gamma3: chain.gamma3(),
            contacts: contacts.iter().map(contact).collect(),
            loads: harmonics.map(|one| (one.number, on_all(one.amplitude, one.phase))).collect(),
            all_masses: false,
            ..DampedChain::new(layout.length, RowEnds::Alike(layout.ends))
        };
        structure.modal()
    }
}
