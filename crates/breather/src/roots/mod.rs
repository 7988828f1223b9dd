//! All zeros of smooth functions of one variable or two, each proved to exist and to be alone, or reported as unresolved; and the one zero
//! between two values that differ in sign (`bracket`).

#[cfg(test)]
pub(crate) mod assert_enclosed;
pub mod bracket;
pub(crate) mod clearance;
pub(crate) mod dual;
pub(crate) mod interval;
pub(crate) mod patch;
pub(crate) mod planar;
pub(crate) mod taylor;
