//! Roots of F.

use nalgebra::Complex;

/// A gap whose two roots may as well be a pair, or the other way round.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Touching {
    pub(crate) gap: usize,
    pub(crate) t: f64,
    pub(crate) reach: f64,
}

/// A root by its offset from the pole at `place`, and its error.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Root {
    pub(crate) place: usize,
    pub(crate) t: Complex<f64>,
    pub(crate) error: f64,
}

/// Roots and estimates of their errors.
#[derive(Debug, Clone, Default)]
pub(crate) struct Roots {
    pub(crate) list: Vec<Root>,
    /// The first root in each gap and behind the last one.
    pub(crate) gaps: Vec<u32>,
    /// Where errors of residues decide between two real roots and a pair.
    pub(crate) touching: Vec<Touching>,
    /// All ν and their errors, once they have been asked for.
    pub(crate) values: Vec<Complex<f64>>,
    pub(crate) errors: Vec<f64>,
    /// Which edition of the residues these are all roots of.
    pub(crate) edition: Option<u64>,
}

impl Roots {
    pub(crate) fn real(&mut self, place: usize, t: f64, error: f64) {
        self.list.push(Root { place, t: Complex::new(t, 0.0), error });
    }
}
