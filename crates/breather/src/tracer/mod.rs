//! The one predictor–corrector: orbits over one free parameter, a branch, or over two, a surface.
//!
//! | module | holds |
//! |---|---|
//! | `corrector` | the equations of orbits with free parameters, and Newton's method |
//! | `manifold` | steps along tangents, and the points they lead to |
//! | `reduction` | orbits of a symmetry among themselves |

pub(crate) mod corrector;
pub(crate) mod manifold;
pub(crate) mod reduction;
