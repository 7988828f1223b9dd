//! The families of the paper.

/// The families of the paper.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum Family {
    /// One impact on each barrier a period.
    DoubleSided,
    /// One impact a period, on the nearer (lower) barrier.
    SingleSided,
    /// Two different impacts on the nearer barrier in two periods of the force.
    PeriodDoubled,
    /// An orbit given by its impacts, see [`crate::Orbit::from_impulses`].
    Word,
}

vibrochain_lattice::names!(Family {
    DoubleSided "double-sided", SingleSided "single-sided", PeriodDoubled "period-doubled", Word "word",
});
