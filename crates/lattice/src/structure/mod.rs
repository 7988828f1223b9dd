//! Any linear structure with stops: M q″ + C q′ + K q = s + Σ_j f_j cos jω(t+ψ), contacts g = wᵀq between barriers.
//!
//! | module | holds |
//! |---|---|
//! | `contact` | [`Contact`]: where it is stopped, and what an impact leaves of its velocity |
//! | `linear_mode` | [`LinearMode`]: two coordinates that move together, what contacts see of them, what impulses and loads give to them |
//! | `contact_modes` | [`ContactMode`]: a mode without losses as impacts at one contact feel it |
//! | `modal` | [`ModalStructure`]: modes and contacts, from which kernels and steady motions are made |
//! | `damped_chain` | [`DampedChain`]: a chain with its dashpots, or rows of one side by side, whose modes are known in closed form; [`FeltShapes`]: what contacts feel of them, whatever the springs |
//! | `of_model` | the lattice of a model, with contacts where they are asked for |
//! | `matrices` | [`Structure`]: mass, damping and stiffness with contacts and loads (feature `matrices`) |
//! | `eigenmodes` | its modes, by `assembly` from a `basis` |
//! | `state_matrix` | poles and shapes of modes that dashpots couple |
//! | `basis` | modes without dashpots, refined in twice the digits, with bounds of their errors |
//! | `poles` | the same of poles that dashpots couple |
//! | `assembly` | modes from both |
//! | `oscillator` | modes of real shape with bounds of their errors, whatever they are made of |
//! | `operator` | [`SparseOperator`]: how coordinates pull at each other, beside the modes |
//! | `participating` | [`ParticipatingModes`]: modes as impacts at some contacts feel them |
//! | `steady` | motions under the loads alone |
//! | `energy` | [`EnergyForm`]: energy and powers in the coordinates of the modes |
//! | `error` | [`StructureError`] |

#[cfg(feature = "matrices")]
mod assembly;
#[cfg(feature = "matrices")]
mod basis;
pub(crate) mod contact;
pub(crate) mod contact_modes;
pub(crate) mod damped_chain;
#[cfg(feature = "matrices")]
mod eigenmodes;
pub(crate) mod energy;
pub(crate) mod error;
pub(crate) mod linear_mode;
#[cfg(feature = "matrices")]
pub(crate) mod matrices;
pub(crate) mod modal;
mod of_model;
pub(crate) mod operator;
mod oscillator;
pub(crate) mod participating;
#[cfg(feature = "matrices")]
mod poles;
#[cfg(feature = "matrices")]
mod state_matrix;
mod steady;
#[cfg(test)]
#[cfg(feature = "matrices")]
mod tests;
