//! What contacts feel of the shapes of a lattice's modes, which no spring changes: modes of other springs are made of them.

use rustfft::num_complex::Complex;

use super::DampedChain;
use crate::kernel::turn::{ModeFlow, Turned};
use crate::model::params::Model;
use crate::modes::row_modes::LayeredMode;
use crate::simd::twofold::Twofold;
use crate::structure::error::StructureError;
use crate::structure::modal::ModalStructure;
use crate::structure::oscillator::SeenShape;

/// A mode without its frequency.
#[derive(Debug, Clone)]
struct FeltShape {
    mode: LayeredMode,
    /// κ and κ′.
    stiffnesses: [Twofold; 2],
    seen: SeenShape,
}

/// The shapes of [`Model::felt_structure`], to make structures of other γ₁, γ₂ and γ₃ of.
///
/// ```
/// use vibrochain_lattice::{Chain, FeltShapes, Model};
/// let [model, other] = [0.1, 0.3].map(|gamma2| Model::conservative(Chain::new(21, 0.2, gamma2).unwrap(), 1.5, 0.4).unwrap());
/// let shapes = FeltShapes::of(&model, &[vec![5]])?;
/// assert_eq!(shapes.structure([0.2, 0.3, 0.0], [0.0; 2])?, other.felt_structure(&[vec![5]])?);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct FeltShapes {
    chain: DampedChain,
    shapes: Vec<FeltShape>,
    /// κ and κ′ of the modes that move none of the contacts.
    unfelt: Vec<[Twofold; 2]>,
    /// What each contact may see of a mode at most.
    reaches: Vec<f64>,
}

impl FeltShapes {
    /// Those of a model's lattice as contacts at these lists of masses feel them.
    ///
    /// # Errors
    /// As [`Model::structure`].
    pub fn of(model: &Model, contacts: &[Vec<usize>]) -> Result<Self, StructureError> {
        let chain = model.at_first_mass(contacts);
        chain.check()?;
        let (row, is_uniform) = (chain.row(), chain.are_uniform());
        let shape =
            |mode| FeltShape { mode, stiffnesses: row.stiffnesses(mode), seen: chain.seen(&row, mode, &is_uniform) };
        let (felt, unfelt): (Vec<_>, Vec<_>) = row.all().partition(|&mode| chain.is_felt(&row, mode));
        let unfelt = unfelt.into_iter().map(|mode| row.stiffnesses(mode)).collect();
        let shapes = felt.into_iter().map(shape).collect();
        let reaches = chain.reaches();
        Ok(Self { chain, shapes, unfelt, reaches })
    }

    /// The structure of the same lattice with springs γ₁, γ₂ and γ₃, and dashpots c and c₂.
    ///
    /// # Errors
    /// As [`Model::structure`].
    pub fn structure(
        &self,
        [gamma1, gamma2, gamma3]: [f64; 3],
        [damping, coupling_damping]: [f64; 2],
    ) -> Result<ModalStructure, StructureError> {
        let chain = DampedChain { gamma1, gamma2, gamma3, damping, coupling_damping, ..self.chain.clone() };
        let frequency = |shape: &FeltShape| chain.frequency(shape.mode, shape.stiffnesses);
        let mut all: Vec<_> = self.shapes.iter().map(|shape| (frequency(shape), shape)).collect();
        all.sort_by(|one, other| one.0.order(&other.0));
        let mut modes = Vec::with_capacity(all.len());
        for (k, (frequency, shape)) in all.iter().enumerate() {
            frequency.check()?;
            modes.push(chain.linear_mode(k, frequency, shape.seen.clone(), &self.reaches)?);
        }
        chain.of_modes(modes)
    }

    /// The poles of the modes that no contact feels, with such springs and dashpots.
    pub fn unfelt_poles(
        &self,
        [gamma1, gamma2, gamma3]: [f64; 3],
        [damping, coupling_damping]: [f64; 2],
    ) -> impl Iterator<Item = [Complex<f64>; 2]> + '_ {
        self.unfelt.iter().map(move |[along, across]| {
            let (along, across) = (along.value(), across.value());
            let square = gamma3.mul_add(across, gamma2.mul_add(along, gamma1));
            let flow = ModeFlow::oscillator(square.sqrt(), 0.5 * coupling_damping.mul_add(along, damping));
            Turned { even: -flow.decay, odd: flow.rate }.eigenvalues(flow.turn)
        })
    }
}
