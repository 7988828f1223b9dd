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
        self.with_contacts(contacts).modal()
    }

    /// The same structure without the modes that move none of these masses: no impact feels them. On a ring, where all masses are alike, the first
    /// one stands for mass 0: of one mass alone it leaves out about half of the modes.
    ///
    /// # Errors
    /// As [`Model::structure`].
    ///
    /// ```
    /// use vibrochain_lattice::{Chain, Model};
    /// let model = Model::conservative(Chain::new(21, 0.2, 0.1)?, 1.5, 0.4)?;
    /// assert_eq!(model.felt_structure(&[vec![5]])?.modes().len(), 11);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn felt_structure(&self, contacts: &[Vec<usize>]) -> Result<ModalStructure, StructureError> {
        self.at_first_mass(contacts).felt()
    }

    /// With contacts, of a ring those that many places on that the first one is mass 0.
    pub(super) fn at_first_mass(&self, contacts: &[Vec<usize>]) -> DampedChain {
        let sites = self.chain().sites();
        let first = contacts.first().and_then(|masses| masses.first()).copied().unwrap_or_default();
        if !self.chain().is_ring() || contacts.iter().flatten().any(|&mass| mass >= sites) {
            return self.with_contacts(contacts);
        }
        let turned = |mass: &usize| (mass + sites - first) % sites;
        let contacts: Vec<Vec<usize>> = contacts.iter().map(|masses| masses.iter().map(turned).collect()).collect();
        self.with_contacts(&contacts)
    }

    fn with_contacts(&self, contacts: &[Vec<usize>]) -> DampedChain {
        let stop = self.stop();
        let contact = |masses: &Vec<usize>| {
            let root = (masses.len() as f64).sqrt();
            let seen = masses.iter().map(|&mass| (mass, root.recip())).collect();
            let [lower, upper] = [stop.lower, stop.upper].map(|place| place.map(|place| root * place));
            (seen, Contact { lower, upper, ..stop })
        };
        self.damped_chain(contacts.iter().map(contact).collect())
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
        let [damping, coupling_damping] = self.dashpots();
        let harmonics = self.force().harmonics().iter().filter(|harmonic| harmonic.amplitude != 0.0);
        DampedChain {
            layers: layout.layers,
            layer_ends: layout.layer_ends,
            gamma1: chain.gamma1(),
            gamma2: chain.gamma2(),
            gamma3: chain.gamma3(),
            damping,
            coupling_damping,
            contacts,
            loads: harmonics.map(|one| (one.number, on_all(one.amplitude, one.phase))).collect(),
            all_masses: false,
            ..DampedChain::new(layout.length, RowEnds::Alike(layout.ends))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::chain::Chain;
    use crate::modes::row::Ends;

    /// What is left out is felt by nobody: mobilities, answers to impulses and steady motions are those of all modes, at whichever masses contacts are.
    #[test]
    fn contacts_feel_no_other_modes() {
        let ring = Chain::new(21, 0.2, 0.1).unwrap();
        let even = Chain::new(12, 0.2, 0.1).unwrap();
        let walled = ring.with_ends(Ends::Fixed);
        let layered = even.with_layers(3, 0.03, Ends::Free).unwrap();
        let cases: [(Chain, &[usize], usize); 7] = [
            (ring, &[0], 11),
            (ring, &[5], 11),
            (ring, &[3, 7], 21),
            (even, &[11, 5], 7),
            (walled, &[10], 11),
            (walled, &[3], 20),
            (layered, &[12], 14),
        ];
        for (chain, masses, count) in cases {
            let model = chain.point().omega(1.1).asymmetry(0.2).amplitude(0.4).restitution(0.7).model().unwrap();
            let contacts: Vec<Vec<usize>> = masses.iter().map(|mass| vec![*mass]).collect();
            let [all, felt] = [model.structure(&contacts).unwrap(), model.felt_structure(&contacts).unwrap()];
            assert_eq!((all.modes().len(), felt.modes().len()), (chain.sites(), count), "{masses:?}");
            let answer = |of: &ModalStructure, to: usize, from: usize, t: f64| -> f64 {
                of.modes().iter().map(|mode| mode.turn.pair(mode.rows[to], mode.flight(t), mode.columns[from])).sum()
            };
            for (to, from) in (0..masses.len()).flat_map(|to| (0..masses.len()).map(move |from| (to, from))) {
                assert!((all.mobility(to, from) - felt.mobility(to, from)).abs() < 1e-14);
                for t in [0.3, 2.0, 17.0] {
                    let off = answer(&all, to, from, t) - answer(&felt, to, from, t);
                    assert!(off.abs() < 1e-13, "{masses:?} {to} {from} {t}: {off:e}");
                }
            }
            let swings = [&all, &felt].map(|of| of.steady_at(0, 1.1).unwrap());
            assert!(swings[0].iter().zip(&swings[1]).all(|(a, b)| (a - b).norm() < 1e-13));
        }
        let model = Model::conservative(ring, 1.5, 0.4).unwrap();
        assert!(matches!(model.felt_structure(&[vec![0], vec![21]]), Err(StructureError::Range { .. })));
    }
}
