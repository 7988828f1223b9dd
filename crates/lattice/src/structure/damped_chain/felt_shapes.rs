//! What contacts feel of the shapes of a lattice's modes, which no spring changes: modes of other springs are made of them.

use super::DampedChain;
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
/// assert_eq!(shapes.structure([0.2, 0.3, 0.0])?, other.felt_structure(&[vec![5]])?);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct FeltShapes {
    chain: DampedChain,
    shapes: Vec<FeltShape>,
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
        let shapes = row.all().filter(|&mode| chain.is_felt(&row, mode)).map(shape).collect();
        let reaches = chain.reaches();
        Ok(Self { chain, shapes, reaches })
    }

    /// The structure of the same lattice with springs γ₁, γ₂ and γ₃.
    ///
    /// # Errors
    /// As [`Model::structure`].
    pub fn structure(&self, [gamma1, gamma2, gamma3]: [f64; 3]) -> Result<ModalStructure, StructureError> {
        let chain = DampedChain { gamma1, gamma2, gamma3, ..self.chain.clone() };
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
}
