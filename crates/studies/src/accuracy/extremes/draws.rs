//! Random points on logarithmic ranges of all parameters, each answer against many digits.

use std::collections::BTreeMap;

use fastrand::Rng;
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use vibrochain_breather::Family;
use vibrochain_lattice::{Chain, Model, ParameterError};

use super::checks::{Depth, Row, Spectra, check_kernels, check_orbits};

/// Digits of the truth: enough to judge `f64` by, few enough for many draws.
const BITS: usize = 64;

/// One draw in so many has its kernels and its multipliers checked too: they take most of the time.
const KERNELS: u64 = 16;
const SPECTRA: u64 = 8;

/// 10^x, x uniform.
pub(crate) fn power(random: &mut Rng, from: f64, to: f64) -> f64 {
    10f64.powf(from + (to - from) * random.f64())
}

/// A random point and family: stiffnesses over 16 decades and none, frequencies from far below the band to far above,
/// forces from a thousandth of what moves the ring to a million times that, and the ends of every range.
///
/// # Errors
/// [`ParameterError`] if the point is not a valid one, which it should always be.
pub fn draw(random: &mut Rng) -> Result<(Model, Family), ParameterError> {
    let sites = if random.u8(..100) == 0 { 21 } else { random.usize(1..=6) };
    let gamma1 = if random.u8(..20) == 0 { 0.0 } else { power(random, -12.0, 4.0) };
    let gamma2 = match random.u8(..20) {
        // Something must hold the ring.
        0 if gamma1 > 0.0 => 0.0,
        _ => power(random, -12.0, 4.0),
    };
    let top = (gamma1 + 4.0 * gamma2).sqrt();
    let omega =
        if top > 0.0 && random.u8(..50) > 0 { top * power(random, -1.5, 3.0) } else { power(random, -3.0, 6.0) };
    let asymmetry = match random.u8(..5) {
        0 => 0.0,
        1 => 1.0 - power(random, -12.0, 0.0),
        _ => random.f64(),
    };
    let restitution = match random.u8(..4) {
        0 | 1 => 1.0 - power(random, -15.0, -0.01),
        2 => power(random, -6.0, 0.0),
        _ => 1.0,
    };
    let family = [Family::DoubleSided, Family::SingleSided, Family::PeriodDoubled][random.usize(..3)];
    let conservative = family != Family::PeriodDoubled && random.u8(..3) == 0;
    let chain = Chain::new(sites, gamma1, gamma2)?;
    let model = if conservative {
        Model::conservative(chain, omega, asymmetry)?
    } else {
        let amplitude = (gamma1 - omega * omega).abs().max(1e-12) * power(random, -3.0, 6.0);
        chain.point().omega(omega).asymmetry(asymmetry).amplitude(amplitude).restitution(restitution).model()?
    };
    Ok((model, family))
}

/// What many draws came to.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Tally {
    /// Number of draws.
    pub draws: u64,
    /// How often each kind of outcome was met, numbers taken out of their words.
    pub outcomes: BTreeMap<String, u64>,
    /// Comparisons of a number with the truth.
    pub compared: u64,
    /// Largest ratio of delivered to promised error.
    pub worst: f64,
    /// Rows that do not keep their promise.
    pub broken: Vec<Row>,
}

impl Tally {
    /// With one more row.
    pub(crate) fn count(mut self, row: Row) -> Self {
        let kind = match (row.promised, row.delivered) {
            (Some(promised), Some(delivered)) => {
                self.compared += 1;
                if delivered > row.floor {
                    self.worst = self.worst.max(delivered / promised);
                }
                let undecided = row.outcome.starts_with("undecided");
                if undecided { "undecided".to_owned() } else { "compared with the truth".to_owned() }
            }
            // The first words tell the kind; numbers differ from point to point.
            _ => {
                let words = row.outcome.split(' ').take(6);
                let plain = |word: &str| !word.contains(|c: char| c.is_ascii_digit());
                words.map(|word| if plain(word) { word } else { "…" }).collect::<Vec<_>>().join(" ")
            }
        };
        *self.outcomes.entry(kind).or_default() += 1;
        if !row.holds() {
            self.broken.push(row);
        }
        self
    }

    /// Both together.
    pub(crate) fn join(mut self, other: Self) -> Self {
        self.draws += other.draws;
        self.compared += other.compared;
        self.worst = self.worst.max(other.worst);
        for (kind, count) in other.outcomes {
            *self.outcomes.entry(kind).or_default() += count;
        }
        self.broken.extend(other.broken);
        self
    }
}

/// Checks `count` draws of the sequence that begins at `seed`, on all threads of the pool it is called in.
///
/// # Errors
/// As [`draw`].
pub fn check_draws(seed: u64, count: u64) -> Result<Tally, ParameterError> {
    let one = |number: u64| {
        let mut random = Rng::with_seed(seed.wrapping_add(number));
        let (model, family) = draw(&mut random)?;
        let case = format!("draw {}: {model:?}", seed.wrapping_add(number));
        let spectra = if number.is_multiple_of(SPECTRA) { Spectra::Compared } else { Spectra::Computed };
        let mut rows = check_orbits(&case, &model, family, Depth { orbits: 1, spectra, bits: BITS });
        if number.is_multiple_of(KERNELS) {
            match check_kernels(&case, model.chain(), model.omega(), BITS) {
                Ok(row) => rows.push(row),
                Err(error) => rows.push(Row::without_truth(&case, &error)),
            }
        }
        let tally = Tally { draws: 1, ..Tally::default() };
        Ok(rows.into_iter().fold(tally, Tally::count))
    };
    (0..count).into_par_iter().map(one).try_reduce(Tally::default, |a, b| Ok(a.join(b)))
}
