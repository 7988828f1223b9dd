//! All zeros of smooth functions of one variable or two, each proved to exist and to be alone, or reported as unresolved; and the one zero
//! between two values that differ in sign (`bracket`).

pub mod bracket;
pub(crate) mod clearance;
pub(crate) mod dual;
pub(crate) mod interval;
pub(crate) mod patch;
pub(crate) mod planar;
pub(crate) mod taylor;
