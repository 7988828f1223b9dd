//! Letters and the lines that they stand in.

pub(crate) mod font;
pub(crate) mod headings;
pub(crate) mod typeset;
