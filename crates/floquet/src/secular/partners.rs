//! Both blocks of an orbit of two sites that a reflection exchanges, see [`super::foreign`].

use vibrochain_breather::{Impact, Orbit, Prepared};

use super::error::SecularError;
use super::foreign::Foreign;
use super::modes::Modes;
use super::verdict::Secular;

/// How far, relatively, impulses of the two sites may be from each other: rounding next to a resonance is below that.
const ALIKE: f64 = 1e-10;

/// Two sites that a reflection exchanges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pair {
    pub(crate) sites: [usize; 2],
    /// 1 if both are on the same barrier, −1 if they are on opposite ones.
    pub(crate) sign: f64,
    /// P₁/P₀ of two instants.
    pub(crate) ratio: Option<f64>,
    /// Centred barriers, and impacts on both: the ratio is −1, the orbit its own mirror image after half a period.
    pub(crate) is_symmetric: bool,
}

impl Pair {
    /// The two sites of an orbit that the reflection that exchanges them leaves as it is, or turns into its opposite.
    pub(crate) fn of(orbit: &Orbit) -> Option<Self> {
        let mut instants = orbit.instants();
        let first = instants.next().filter(|_| orbit.is_reversible() && orbit.model().chain().is_ring())?;
        let (sites, sign, impulse) = alike(first)?;
        let centred = orbit.model().asymmetry() == 0.0;
        if sign < 0.0 && !centred {
            return None;
        }
        let Some(second) = instants.next() else {
            return Some(Self { sites, sign, ratio: None, is_symmetric: false });
        };
        let (others, same, ratio) = alike(second).map(|(sites, sign, second)| (sites, sign, second / impulse))?;
        let is_symmetric = centred && (ratio + 1.0).abs() <= ALIKE;
        let ratio = if is_symmetric { -1.0 } else { ratio };
        let known = others == sites && same == sign && ratio.is_finite() && ratio != 0.0;
        known.then_some(Self { sites, sign, ratio: Some(ratio), is_symmetric })
    }
}

/// The two sites of an instant, whether they hit the same barrier, and the impulse of the first, if that of the second is as large.
fn alike(impacts: &[Impact]) -> Option<([usize; 2], f64, f64)> {
    let [one, other] = impacts else { return None };
    let sign = one.barrier.sign() * other.barrier.sign();
    let alike = (one.impulse - sign * other.impulse).abs() <= ALIKE * one.impulse.abs();
    alike.then_some(([one.site, other.site], sign, one.impulse))
}

/// The secular functions of both blocks; also the work space.
#[derive(Debug, Clone, Default)]
pub(crate) struct Partners {
    modes: Modes,
    /// ±C of all modes.
    signed: Vec<f64>,
    /// Of the block in which the orbit swings.
    pub(crate) own: Secular,
    pub(crate) other: Secular,
}

impl Partners {
    /// Takes over the orbit of a pair, the ratio of whose impulses is known up to the relative error `ratio_error`.
    pub(crate) fn replace(&mut self, prepared: Prepared<'_>, pair: Pair, ratio_error: f64) -> Result<(), SecularError> {
        let response = prepared.response();
        let [site, partner] = pair.sites;
        self.modes.set(response);
        self.signed.clear();
        self.signed.extend(response.shapes().evens(partner, site).take(self.modes.count()).map(|c| pair.sign * c));
        let (modes, signed) = (&self.modes, &self.signed);
        let ratio = pair.ratio.map(|ratio| (ratio, ratio_error));
        let Self { own: Secular { residues: own, .. }, other: Secular { residues: other, .. }, .. } = self;
        own.set_modes(|own| own.weigh(modes, |k| 1.0 + signed[k]));
        own.work_out(ratio, None)?;
        other.set_modes(|other| other.weigh(modes, |k| 1.0 - signed[k]));
        let foreign = Foreign::new(modes, signed, own.modes(), response.period());
        other.work_out(ratio, Some(&foreign))
    }

    /// Frequencies of the modes of doublets that have a node at both sites: no impact reaches them.
    pub(crate) fn spared(&self, doublets: usize) -> impl Iterator<Item = f64> + '_ {
        let parts = self.signed.iter().flat_map(|signed| [1.0 + signed, 1.0 - signed]);
        let modes = self.modes.list().iter().flat_map(|mode| [mode.frequency; 2]);
        let spared = modes.zip(parts).skip(2).take(2 * doublets).filter(|(_, part)| Modes::is_spared(*part));
        spared.map(|(frequency, _)| frequency)
    }
}
