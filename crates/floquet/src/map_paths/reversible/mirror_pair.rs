//! Orbits of two sites that a reflection exchanges at once: both blocks, see [`crate::map_paths::reversible::other_block`]. The fast path of maps of pairs (9 µs a cell
//! of 21 masses, of which all zeros of the determinant take 1100), and that of pairs on large rings; a test holds it against `spectrum`.

use nalgebra::Complex;
use vibrochain_breather::{Impact, Orbit, Prepared};
use vibrochain_lattice::Chain;

use crate::map_paths::modes::Modes;
use crate::map_paths::reversible::double_sided::Saltations;
use crate::map_paths::reversible::other_block::Foreign;
use crate::map_paths::reversible::product_form::settled;
use crate::map_paths::reversible::verdict::{Secular, SecularVerdict};
use crate::zeros::SecularError;

/// How far, relatively, impulses of the two sites may be from each other: rounding next to a resonance is below that.
const ALIKE: f64 = 1e-10;

/// Errors of a growth, in units of the multiplier, that nobody would want to have smaller.
const PRECISE: f64 = 1e-11;

/// Two sites that a reflection exchanges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pair {
    pub(crate) sites: [usize; 2],
    /// Both are hit on the same barrier (1), or on opposite ones (−1).
    pub(crate) sign: f64,
    /// P₁/P₀ of two instants, or of the two sites.
    pub(crate) ratio: Option<f64>,
    /// Centred barriers, and impacts on both: the ratio is −1, the orbit its own mirror image after half a period.
    pub(crate) is_symmetric: bool,
}

impl Pair {
    /// The two sites of an orbit that the reflection that exchanges them leaves as it is or turns into its opposite.
    pub(crate) fn of(orbit: &Orbit) -> Option<Self> {
        let mut instants = orbit.instants();
        // What one site takes has a secular function of its own.
        let first = instants.next().filter(|_| orbit.is_reversible() && orbit.impact_site().is_none())?;
        let second = instants.next();
        let pair = Self::at_once(orbit, first, second)?;
        orbit.model().chain().exchanges(pair.sites[0], pair.sites[1]).then_some(pair)
    }

    fn at_once(orbit: &Orbit, first: &[Impact], second: Option<&[Impact]>) -> Option<Self> {
        let sites = |impacts: &[Impact]| match impacts {
            [one, other] => Some(([one.site, other.site], one.barrier.sign() * other.barrier.sign())),
            _ => None,
        };
        let (places, sign) = sites(first)?;
        let centred = orbit.model().asymmetry() == 0.0;
        let alike = |impacts: &[Impact]| is_alike(impacts[0].impulse, sign * impacts[1].impulse);
        if sign < 0.0 && !centred || !alike(first) {
            return None;
        }
        let Some(second) = second else {
            return Some(Self { sites: places, sign, ratio: None, is_symmetric: false });
        };
        if sites(second)? != (places, sign) || !alike(second) {
            return None;
        }
        Self { sites: places, sign, ratio: None, is_symmetric: false }
            .with(second[0].impulse / first[0].impulse, centred)
    }

    fn with(self, ratio: f64, centred: bool) -> Option<Self> {
        let is_symmetric = centred && (ratio + 1.0).abs() <= ALIKE;
        let ratio = if is_symmetric { -1.0 } else { ratio };
        (ratio.is_finite() && ratio != 0.0).then_some(Self { ratio: Some(ratio), is_symmetric, ..self })
    }
}

fn is_alike(one: f64, other: f64) -> bool {
    (one - other).abs() <= ALIKE * one.abs()
}

/// The secular functions of both blocks, or of half a period; also the work space.
#[derive(Debug, Clone, Default)]
pub(crate) struct Partners {
    modes: Modes,
    /// ±φ_k(i)φ_k(j) of all modes, and φ_k(i)², which is φ_k(j)²; both over b², on a ring ±C and 1.
    signed: Vec<f64>,
    squares: Vec<f64>,
    period: f64,
    /// Of two instants.
    saltations: Option<Saltations>,
    /// Of the block in which the orbit swings, and of the other one.
    own: Secular,
    other: Secular,
}

impl Partners {
    /// Takes over the orbit of a pair, the ratio of whose impulses is known up to the relative error `ratio_error`.
    pub(crate) fn replace(&mut self, prepared: Prepared<'_>, pair: Pair, ratio_error: f64) -> Result<(), SecularError> {
        let (response, period) = (prepared.response(), prepared.response().period());
        let ([site, partner], sign) = (pair.sites, pair.sign);
        (self.period, self.saltations) = (period, None);
        self.modes.set(response);
        self.signed.clear();
        self.signed.extend(response.shapes().evens(partner, site).take(self.modes.count()).map(|c| sign * c));
        self.squares.clear();
        self.squares.extend(response.shapes().evens(site, site).take(self.modes.count()));
        let (modes, signed, squares) = (&self.modes, &self.signed, &self.squares);
        let Self { own: Secular { residues: own, .. }, other: Secular { residues: other, .. }, .. } = self;
        let ratio = pair.ratio.map(|ratio| (ratio, ratio_error));
        own.set_modes(|own| own.weigh(modes, |k| squares[k] + signed[k]));
        own.work_out(ratio, None)?;
        other.set_modes(|other| other.weigh(modes, |k| squares[k] - signed[k]));
        let foreign = Foreign::new(modes, signed, own.modes(), period);
        self.saltations = ratio.map(|(ratio, error)| Saltations::new(own.modes(), ratio, error));
        other.work_out(ratio, Some(&foreign))
    }

    /// The verdicts on both blocks.
    pub(crate) fn verdicts(&mut self) -> Result<[SecularVerdict; 2], SecularError> {
        let verdicts = [self.own.verdict()?, self.other.verdict()?];
        let [own, other] = [&self.own, &self.other].map(|block| block.residues.modes());
        Ok([self.settled(&verdicts[0], own), self.settled(&verdicts[1], other)])
    }

    /// A verdict of two instants whose multiplier close poles leave imprecise, from f itself.
    fn settled(&self, verdict: &SecularVerdict, modes: &Modes) -> SecularVerdict {
        let precise = verdict.growth_error <= PRECISE * (1.0 + verdict.growth);
        match &self.saltations {
            Some(saltations) if !precise => settled(verdict, saltations, modes, self.period),
            _ => *verdict,
        }
    }

    /// All multipliers of the modes that the impacts feel, without the trivial pair.
    pub(crate) fn multipliers(&mut self) -> Result<Vec<Complex<f64>>, SecularError> {
        let of = |block: &mut Secular| -> Result<Vec<_>, SecularError> {
            Ok(block.all_nu()?.flat_map(|(nu, _)| nu.multipliers()).collect())
        };
        Ok([of(&mut self.own)?, of(&mut self.other)?].concat())
    }

    /// Frequencies of the modes that have a node at all sites that are hit: no impact reaches them.
    pub(crate) fn spared<'a>(&'a self, chain: &'a Chain) -> impl Iterator<Item = f64> + 'a {
        let parts = self.squares.iter().zip(&self.signed);
        self.modes.list().iter().zip(parts).enumerate().flat_map(move |(k, (mode, (square, signed)))| {
            let reached = [1.0, -1.0].iter().filter(|sign| !Modes::is_spared(square + **sign * signed)).count();
            std::iter::repeat_n(mode.frequency, chain.multiplicity(k).saturating_sub(reached))
        })
    }
}
