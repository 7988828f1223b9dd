//! An impact of an orbit, of any structure.

/// One impact of an orbit, as its equations know it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearImpact {
    /// Number of the contact that is hit, among those of the kernel.
    pub contact: usize,
    /// Time within the period.
    pub time: f64,
    /// P, signed.
    pub impulse: f64,
    /// e
    pub restitution: f64,
    /// g″⁻, the acceleration of the contact just before, load and damping included.
    pub acceleration_before: f64,
}
