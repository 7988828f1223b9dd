//! Axes, their ticks, frames and legends.

pub(crate) mod axis;
pub(crate) mod frame;
pub(crate) mod legend;
