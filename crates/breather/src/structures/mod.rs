//! Periodic orbits of any linear structure with stops: [`ContactOrbit`].
//!
//! ```text
//! g_c(t) = Σ_j P_j K_c,j(t − t_j) + G_c(t+ψ) + g_c⁰ + Σ_ρ φ_ρ(c) y_ρ
//! ```
//!
//! with the periodic kernel K, the motion G under the loads, the static place g⁰ and, of each rigid mode ρ, its offset y. At every impact
//! g meets its barrier and Newton's law holds, P/m + (1+e)g′⁻ = 0; each rigid mode asks that impulses balance its static load.
//!
//! | module | holds |
//! |---|---|
//! | `model` | [`LoadedStructure`]: a structure and a frequency |
//! | `periodic_kernel` | K and its derivatives, regular modes and rigid ones |
//! | `between` | K from one contact to another and back as functions of one time, with bounds |
//! | `response` | what contacts do after impacts and under the loads, shared by all words of the same contacts |
//! | `point` | what they are solved for: impacts, phase, offsets |
//! | `equations` | rows and Jacobian of an orbit's impacts |
//! | `orbit` | [`ContactOrbit`], and how far it can be trusted |
//! | `linearised` | its linearised equations J(z) |
//! | `reversible` | [`ReversibleOrbit`]: what multipliers of an orbit that is its own mirror image in time depend on |
//! | `open_mode`, `open_modes` | modes next to a resonance, whose states are unknowns |
//! | `resonant_doubts` | what the error of a frequency does to them next to a resonance |
//! | `errors` | bounds of an orbit's errors |
//! | `condition` | [`crate::Condition`]: distances to where the equations lose their grip |
//! | `newton` | from impacts nearby to an orbit |
//! | `search` | all orbits of up to three impacts; of more, those that starts lead to |
//! | `flight` | [`ContactMotion`]: every contact at any time |
//! | `admissible` | physical or what is in the way |
//! | `map_orbit` | what a map asks of orbits in closed form |
//! | `branch` | [`Branch`]: orbits as a number of the structure varies |

pub(crate) mod admissible;
mod between;
pub(crate) mod branch;
pub(crate) mod condition;
pub(crate) mod equations;
pub(crate) mod errors;
pub(crate) mod flight;
mod linearised;
pub(crate) mod map_orbit;
mod masses;
pub(crate) mod model;
mod newton;
pub(crate) mod of_orbit;
mod open_mode;
mod open_modes;
pub(crate) mod orbit;
pub(crate) mod periodic_kernel;
mod point;
mod resonant_doubts;
pub(crate) mod response;
pub(crate) mod reversible;
pub(crate) mod search;
#[cfg(test)]
mod tests;
