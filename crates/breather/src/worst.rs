//! The worst of several numbers.

/// The larger of two errors; one that is not a number is as bad as can be.
pub(crate) fn worse(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::INFINITY } else { a.max(b) }
}
