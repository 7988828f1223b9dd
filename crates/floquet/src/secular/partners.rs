//! Orbits of two sites that a reflection exchanges: both blocks, see [`super::foreign`], or half a period, see [`super::in_turns`].

use nalgebra::Complex;
use smallvec::{SmallVec, smallvec};
use vibrochain_breather::{Impact, Orbit, Prepared};
use vibrochain_lattice::Chain;

use super::double_sided::Saltations;
use super::error::SecularError;
use super::foreign::Foreign;
use super::in_turns;
use super::modes::{Mode, Modes};
use super::settled::{BY_ROOT, settled};
use super::verdict::{Secular, SecularVerdict};

/// How far, relatively, impulses of the two sites may be from each other: rounding next to a resonance is below that.
const ALIKE: f64 = 1e-10;

/// Rings on which residues of pairs in turns are worked out mode by mode.
const MOST_MODES: usize = 500;

type C = Complex<f64>;

/// Errors of a growth, in units of the multiplier, that nobody would want to have smaller.
const PRECISE: f64 = 1e-11;

/// Two sites that a reflection exchanges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pair {
    pub(crate) sites: [usize; 2],
    pub(crate) exchange: Exchange,
    /// P₁/P₀ of two instants, or of the two sites.
    pub(crate) ratio: Option<f64>,
    /// Centred barriers, and impacts on both: the ratio is −1, the orbit its own mirror image after half a period.
    pub(crate) is_symmetric: bool,
}

/// How the reflection leaves the orbit as it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Exchange {
    /// At once, both on the same barrier (1), or up to the sign (−1).
    AtOnce(f64),
    /// Half a period later.
    InTurns,
}

impl Pair {
    /// The two sites of an orbit that the reflection that exchanges them leaves as it is, turns into its opposite, or delays.
    pub(crate) fn of(orbit: &Orbit) -> Option<Self> {
        let mut instants = orbit.instants();
        // What one site takes has a secular function of its own.
        let first = instants.next().filter(|_| orbit.is_reversible() && orbit.impact_site().is_none())?;
        let second = instants.next();
        let pair = Self::at_once(orbit, first, second).or_else(|| Self::in_turns(orbit, first, second?))?;
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
        let exchange = Exchange::AtOnce(sign);
        let Some(second) = second else {
            return Some(Self { sites: places, exchange, ratio: None, is_symmetric: false });
        };
        if sites(second)? != (places, sign) || !alike(second) {
            return None;
        }
        Self { sites: places, exchange, ratio: None, is_symmetric: false }
            .with(second[0].impulse / first[0].impulse, centred)
    }

    fn in_turns(orbit: &Orbit, first: &[Impact], second: &[Impact]) -> Option<Self> {
        let follows =
            |one: &Impact, other: &Impact| one.barrier == other.barrier && is_alike(one.impulse, other.impulse);
        let pair = |sites| Self { sites, exchange: Exchange::InTurns, ratio: None, is_symmetric: false };
        match (first, second) {
            ([one], [other]) if one.site != other.site && follows(one, other) => Some(pair([one.site, other.site])),
            ([one, two], [later, latest])
                if (one.site, two.site) == (later.site, latest.site)
                    && follows(one, latest)
                    && follows(two, later)
                    && orbit.model().chain().even_modes() <= MOST_MODES =>
            {
                pair([one.site, two.site]).with(two.impulse / one.impulse, false)
            }
            _ => None,
        }
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
    parities: [Modes; 2],
    exchange: Option<Exchange>,
    period: f64,
    /// Of two instants.
    saltations: Option<Saltations>,
    /// Of the block in which the orbit swings, or of half a period; the other one only of sites that are exchanged at once.
    own: Secular,
    other: Secular,
}

impl Partners {
    /// Takes over the orbit of a pair, the ratio of whose impulses is known up to the relative error `ratio_error`.
    pub(crate) fn replace(&mut self, prepared: Prepared<'_>, pair: Pair, ratio_error: f64) -> Result<(), SecularError> {
        let (response, period) = (prepared.response(), prepared.response().period());
        let [site, partner] = pair.sites;
        let sign = match pair.exchange {
            Exchange::AtOnce(sign) => sign,
            Exchange::InTurns => 1.0,
        };
        (self.exchange, self.period, self.saltations) = (Some(pair.exchange), period, None);
        self.modes.set(response);
        self.signed.clear();
        self.signed.extend(response.shapes().evens(partner, site).take(self.modes.count()).map(|c| sign * c));
        self.squares.clear();
        self.squares.extend(response.shapes().evens(site, site).take(self.modes.count()));
        let (modes, signed, squares) = (&self.modes, &self.signed, &self.squares);
        let Self { own: Secular { residues: own, .. }, other: Secular { residues: other, .. }, .. } = self;
        let ratio = pair.ratio.map(|ratio| (ratio, ratio_error));
        match (pair.exchange, ratio) {
            (Exchange::AtOnce(_), _) => {
                own.set_modes(|own| own.weigh(modes, |k| squares[k] + signed[k]));
                own.work_out(ratio, None)?;
                other.set_modes(|other| other.weigh(modes, |k| squares[k] - signed[k]));
                let foreign = Foreign::new(modes, signed, own.modes(), period);
                self.saltations = ratio.map(|(ratio, error)| Saltations::new(own.modes(), ratio, error));
                other.work_out(ratio, Some(&foreign))
            }
            (Exchange::InTurns, None) => {
                own.set_modes(|own| in_turns::modes(modes, [squares, signed], period, own));
                own.work_out(None, None)
            }
            (Exchange::InTurns, Some((ratio, error))) => {
                let terms = modes.list().iter().zip(squares.iter().zip(signed));
                let terms =
                    terms.map(|(mode, (square, shape))| (*mode, mode.cos * square + shape, square + shape * mode.cos));
                let saltations = Saltations::of(terms, ratio, error);
                for (modes_of, eta) in self.parities.iter_mut().zip([1.0, -1.0]) {
                    let part = |k: usize| Some(squares[k] + eta * signed[k]).filter(|part| !Modes::is_spared(*part));
                    let weighed = |(k, mode): (usize, &Mode)| {
                        (k, Mode { weight: part(k).unwrap_or_default() * mode.weight, ..*mode })
                    };
                    modes_of.collect(modes.list().iter().enumerate().map(weighed));
                }
                self.saltations = Some(saltations);
                let [even, odd] = &self.parities;
                own.work_out_in_turns([even, odd], &saltations, period)
            }
        }
    }

    /// The verdicts on all blocks.
    pub(crate) fn verdicts(&mut self) -> Result<SmallVec<[SecularVerdict; 2]>, SecularError> {
        match self.exchange {
            Some(Exchange::InTurns) => {}
            Some(Exchange::AtOnce(_)) => {
                let verdicts = [self.own.verdict()?, self.other.verdict()?];
                let blocks = [&self.own, &self.other].map(|block| block.residues.modes());
                return Ok((verdicts.iter().zip(blocks))
                    .map(|(verdict, modes)| self.settled(verdict, [modes; 2], BY_ROOT))
                    .collect());
            }
            None => return Ok(smallvec![self.own.verdict()?]),
        }
        let [even, odd] = &self.parities;
        let half = self.own.verdict()?;
        let half = self.settled(&half, [even, odd], [|rho| rho; 2]);
        let leading = half.leading.map(|multiplier| multiplier * multiplier);
        let (growth, growth_error) =
            (half.growth * (2.0 + half.growth), half.growth_error * (2.0 + 2.0 * half.growth + half.growth_error));
        Ok(smallvec![SecularVerdict { leading, growth, growth_error, ..half }])
    }

    /// A verdict of two instants whose multiplier close poles leave imprecise, from f itself; `ways` lead from ν to ρ and back.
    fn settled(&self, verdict: &SecularVerdict, parities: [&Modes; 2], ways: [fn(C) -> C; 2]) -> SecularVerdict {
        let precise = verdict.growth_error <= PRECISE * (1.0 + verdict.growth);
        match &self.saltations {
            Some(saltations) if !precise => settled(verdict, saltations, parities, self.period, ways),
            _ => *verdict,
        }
    }

    /// All multipliers of the modes that the impacts feel, without the trivial pair.
    pub(crate) fn multipliers(&mut self) -> Result<Vec<Complex<f64>>, SecularError> {
        let of = |block: &mut Secular| -> Result<Vec<_>, SecularError> {
            Ok(block.all_nu()?.flat_map(|(nu, _)| nu.multipliers()).collect())
        };
        let own = of(&mut self.own)?;
        Ok(match self.exchange {
            Some(Exchange::InTurns) => own.into_iter().map(|multiplier| multiplier * multiplier).collect(),
            Some(Exchange::AtOnce(_)) => [own, of(&mut self.other)?].concat(),
            None => own,
        })
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
