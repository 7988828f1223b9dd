//! Dense matrices: the reference that everything else is held against, what answers where a determinant's zeros cannot be certified, and
//! the quickest verdict on a small word.
//!
//! | module | holds |
//! |---|---|
//! | `monodromy`, `eigen` | the monodromy matrix and its eigenvalues |
//! | `half_sum` | a matrix of half the size for reversible orbits |
//! | `reflector` | known eigenvectors are taken out |
//! | `dense` | the smallest matrix that an orbit's structure leaves |
//! | `judge`, `certainty` | from eigenvalues to a verdict that knows its error |

pub(crate) mod certainty;
pub(crate) mod dense;
pub(crate) mod eigen;
pub(crate) mod half_sum;
pub(crate) mod judge;
pub(crate) mod monodromy;
pub(crate) mod reflector;
