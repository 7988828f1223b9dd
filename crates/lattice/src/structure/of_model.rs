//! The lattice of a model as a structure, with contacts at some of its masses.

use rustfft::num_complex::Complex;

use super::contact::Contact;
use super::damped_chain::DampedChain;
use super::error::StructureError;
use super::modal::ModalStructure;
use super::operator::SparseOperator;
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
        let stop = self.stop();
        let contact = |masses: &Vec<usize>| {
            let root = (masses.len() as f64).sqrt();
            let seen = masses.iter().map(|&mass| (mass, root.recip())).collect();
            let [lower, upper] = [stop.lower, stop.upper].map(|place| place.map(|place| root * place));
            (seen, Contact { lower, upper, ..stop })
        };
        self.damped_chain(contacts.iter().map(contact).collect()).modal()
    }

    /// How its masses pull at each other, with a contact at each of them and the force as the loads.
    ///
    /// ```
    /// use vibrochain_lattice::{Chain, Model};
    /// let operator = Model::conservative(Chain::new(1_000_000, 0.2, 0.1)?, 1.5, 0.4)?.operator();
    /// assert!((operator.pull(7, false, |n| f64::from(u8::from(n == 8))) + 0.1).abs() < 1e-15);
    /// # Ok::<(), vibrochain_lattice::ParameterError>(())
    /// ```
    pub fn operator(&self) -> SparseOperator {
        let stop = self.stop();
        self.damped_chain((0..self.chain().sites()).map(|mass| (vec![(mass, 1.0)], stop)).collect()).by_masses()
    }

    /// What stops each of its masses.
    pub fn stop(&self) -> Contact {
        let [lower, upper] = [Barrier::Lower, Barrier::Upper].map(|barrier| Some(self.barrier(barrier)));
        Contact { lower, upper, restitution: self.restitution() }
    }

    fn damped_chain(&self, contacts: Vec<(Vec<(usize, f64)>, Contact)>) -> DampedChain {
        let (chain, layout) = (self.chain(), self.chain().layout());
        let on_all = |amplitude: f64, phase: f64| vec![Complex::from_polar(amplitude, phase); chain.sites()];
        let harmonics = self.force().harmonics().iter().filter(|harmonic| harmonic.amplitude != 0.0);
        DampedChain {
            layers: layout.layers,
            layer_ends: layout.layer_ends,
            gamma1: chain.gamma1(),
            gamma2: chain.gamma2(),
            gamma3: chain.gamma3(),
            contacts,
            loads: harmonics.map(|one| (one.number, on_all(one.amplitude, one.phase))).collect(),
            all_masses: false,
            ..DampedChain::new(layout.length, RowEnds::Alike(layout.ends))
        }
    }
}
