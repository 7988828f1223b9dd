//! Where the energy goes.
//!
//! Work and what dashpots take are integrals of forms of ξ ([`EnergyForm`]): sums of ten Gaussian points over pieces of two units of the
//! fastest rate. The integrands are entire, and what the rule misses, (2·2)^{2n} n!⁴/((2n+1)(2n)!³), is 6e-19 of them.

use crate::time::two_sum;
use vibrochain_lattice::EnergyForm;

/// Points of the rule of order ten in (0, 1), and half their weights.
const POINTS: [(f64, f64); 5] = [
    (0.148_874_338_981_631_2, 0.295_524_224_714_752_9),
    (0.433_395_394_129_247_2, 0.269_266_719_309_996_36),
    (0.679_409_568_299_024_4, 0.219_086_362_515_982_04),
    (0.865_063_366_688_984_5, 0.149_451_349_150_580_6),
    (0.973_906_528_517_171_7, 0.066_671_344_308_688_14),
];

/// Units of the fastest rate in a piece.
const PIECE: f64 = 2.0;

/// Energy gained and lost since the balance was asked for.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct EnergyBalance {
    /// Work of the loads, the static one included.
    pub work: f64,
    /// What dashpots have taken.
    pub dashpots: f64,
    /// What impacts have taken.
    pub impacts: f64,
}

/// Three sums, each in two words.
#[derive(Debug, Clone)]
pub(crate) struct Ledger {
    /// Of modes; coordinates need none.
    pub(crate) form: Option<EnergyForm>,
    work: (f64, f64),
    dashpots: (f64, f64),
    impacts: (f64, f64),
}

fn grow(sum: &mut (f64, f64), by: f64) {
    let (high, low) = two_sum(sum.0, by);
    *sum = (high, sum.1 + low);
}

impl Ledger {
    pub(crate) fn new(form: Option<EnergyForm>) -> Self {
        Self { form, work: (0.0, 0.0), dashpots: (0.0, 0.0), impacts: (0.0, 0.0) }
    }

    pub(crate) fn balance(&self) -> EnergyBalance {
        let total = |(high, low): (f64, f64)| high + low;
        EnergyBalance { work: total(self.work), dashpots: total(self.dashpots), impacts: total(self.impacts) }
    }

    pub(crate) fn impact(&mut self, loss: f64) {
        grow(&mut self.impacts, loss);
    }

    /// A flight over `s`; `powers` tells what loads give and dashpots take at an instant.
    pub(crate) fn flight(&mut self, fastest: f64, s: f64, powers: impl Fn(f64) -> [f64; 2]) {
        let pieces = (s * fastest / PIECE).ceil().max(1.0);
        let half = 0.5 * s / pieces;
        for piece in 0..pieces as u64 {
            let middle = (2 * piece + 1) as f64 * half;
            for (point, weight) in POINTS.iter().flat_map(|(x, w)| [(-x, w), (*x, w)]) {
                let time = middle + point * half;
                let [work, taken] = powers(time);
                grow(&mut self.work, weight * half * work);
                grow(&mut self.dashpots, weight * half * taken);
            }
        }
    }
}
