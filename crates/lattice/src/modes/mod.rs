//! Normal modes of rings, rows and layers: frequencies, shapes, transforms.

pub(crate) mod distinct;
pub(crate) mod quarter_wave;
pub(crate) mod ring;
pub(crate) mod row;
pub(crate) mod row_modes;
pub(crate) mod shapes;
pub(crate) mod spectrum;
pub(crate) mod transform;
