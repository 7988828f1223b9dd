//! All zeros of smooth functions of one variable or two, each proved to exist and to be alone, or reported as unresolved.

pub(crate) mod dual;
pub(crate) mod interval;
pub(crate) mod patch;
pub(crate) mod planar;
pub(crate) mod taylor;
