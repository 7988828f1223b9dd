//! Scenes that tests of several crates sweep.

/// Twelve cells of a forced ring of five masses, some without a breather.
pub const FATE: &str = include_str!("../../../tests/data/scenes/fate.toml");

/// One mass over the amplitude of its force: periodic, doubled, chaotic.
pub const ONE_MASS: &str = include_str!("../../../tests/data/scenes/one-mass.toml");
