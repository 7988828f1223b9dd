//! Stable or not, from the signs of F; roots are sought only where the signs leave a question.
//!
//! - Σ R = 1 makes F positive far right, negative far left: the signs of F(±1) tell whether a real root lies beyond ±1.
//! - Neighbouring poles with residues R_k of one sign enclose a root, and so do ±1 and the outermost poles if the signs say so.
//!   (The signs are not Krein's signatures, see [`Residues`].)
//! - If that makes m−1 roots, all are real and accounted for; if all signs are equal it always does, and the orbit
//!   is stable however close its poles are.
//! - Otherwise each gap between residues of opposite signs may hide a pair: the least |F| in it decides. (A gap without roots means
//!   nothing by itself: a root may have crossed a pole.)
//! - If roots are still missing they are complex: Newton from the lowest points, then all roots, see `by_roots`.
//!
//! The count is the certificate: no search that fails can pass for an answer.

use nalgebra::Complex;
use vibrochain_breather::Prepared;

use crate::map_paths::fast_sums::evaluate::Jet;
use crate::map_paths::fast_sums::neighbourhood::Nearby;
use crate::map_paths::fast_sums::zero_search::ZeroSearch;
use crate::map_paths::reversible::complex_pairs::{Pair, Suspect, from_suspects};
use crate::map_paths::reversible::gap::{Lowest, beyond, lowest};
use crate::map_paths::reversible::residues::Residues;
use crate::map_paths::reversible::root::Roots;
use crate::zeros::SecularError;
use crate::zeros::{Nu, outside};

/// What the secular function says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Standing {
    /// All multipliers are on the unit circle, beyond rounding.
    Stable,
    /// Two multipliers are so close to meeting that rounding decides on which side they are.
    Undecided,
    /// A multiplier is outside the unit circle, beyond rounding.
    Unstable,
}

/// Why.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Reason {
    /// All residues have one sign: nothing can collide.
    EqualResidueSigns,
    /// As many real ν were counted in [−1, 1] as there are.
    AllRootsCounted,
    /// Losses: no multiplier was counted or found outside the circle.
    NoneOutside,
    /// A real ν beyond +1 or −1.
    RealRoot,
    /// A pair of complex ν.
    ComplexPair,
    /// F vanishes at ±1, or touches zero in a gap, to within its error; with losses, a multiplier is on the circle.
    Tangency,
}

/// The verdict of the secular function.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SecularVerdict {
    /// Stable, undecided or unstable.
    pub outcome: Standing,
    /// Why.
    pub reason: Reason,
    /// The leading multiplier: the one of largest modulus for an unstable orbit, the one next to leaving for an undecided
    /// one; `None` for a stable one without losses: all are on the circle.
    pub leading: Option<Complex<f64>>,
    /// |μ| − 1 of it, with its own relative accuracy (it may be far below 1e-16); 0 for a stable orbit, with losses
    /// whatever it is. For an undecided one the most that rounding leaves room for.
    pub excess: f64,
    /// Estimated error of the excess.
    pub excess_error: f64,
}

/// Work space of the secular function: residues, verdict, roots.
///
/// ```
/// use vibrochain_breather::{Family, Finder, OrbitList};
/// use vibrochain_floquet::{Standing, Reason, Secular};
/// use vibrochain_lattice::{Chain, Model};
/// let (mut finder, mut found, mut secular) = (Finder::new(21), OrbitList::default(), Secular::default());
/// let mut verdict = |gamma2: f64, omega: f64, family| -> Result<_, Box<dyn std::error::Error>> {
///     let model = Model::conservative(Chain::new(21, 0.2, gamma2)?, omega, 0.4)?;
///     finder.find(&model, family, &mut found)?;
///     secular.replace(finder.prepared(&found.orbits[0])?)?;
///     Ok(secular.verdict()?)
/// };
/// let unstable = verdict(0.1, 0.8, Family::SingleSided)?;
/// assert!(unstable.outcome == Standing::Unstable && (unstable.excess - 1.797574412183362).abs() < 1e-12);
/// // Hardly coupled masses: multipliers closer than rounding can tell apart, and yet none can leave.
/// let stable = verdict(1e-13, 1.5, Family::DoubleSided)?;
/// assert_eq!((stable.outcome, stable.reason), (Standing::Stable, Reason::EqualResidueSigns));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct Secular {
    pub(crate) residues: Residues,
    pub(crate) nearby: Nearby,
    pub(crate) suspects: Vec<Suspect>,
    pub(crate) pairs: Vec<Pair>,
    pub(crate) roots: Roots,
    pub(crate) search: ZeroSearch,
}

/// The most unstable multiplier so far.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LeadingRoot {
    pub(crate) nu: Nu,
    pub(crate) excess: f64,
    pub(crate) error: f64,
    pub(crate) reason: Reason,
}

impl Secular {
    /// Takes over a reversible orbit, see [`Residues::replace`].
    ///
    /// # Errors
    /// As [`Residues::replace`].
    pub fn replace(&mut self, prepared: Prepared<'_>) -> Result<(), SecularError> {
        self.residues.replace(prepared)
    }

    /// All non-trivial ν and their errors.
    pub(crate) fn all_nu(&mut self) -> Result<impl Iterator<Item = (Nu, f64)> + '_, SecularError> {
        self.solve()?;
        let Self { residues, roots, .. } = self;
        Ok(roots.list.iter().map(|root| (residues.nu(root.place, root.t), root.error)))
    }

    /// Poles and residues.
    pub fn residues(&self) -> &Residues {
        &self.residues
    }

    /// The verdict on the orbit taken over.
    ///
    /// # Errors
    /// [`SecularError::ResidueSign`], [`SecularError::Incomplete`], [`SecularError::Imprecise`].
    pub fn verdict(&mut self) -> Result<SecularVerdict, SecularError> {
        let Self { residues: form, nearby: scratch, suspects, pairs, .. } = self;
        scratch.forget();
        let count = form.count();
        let (signs, errors) = (form.residues(), form.errors());
        let large = !form.neighbourhoods.is_empty();
        let (mut positive, mut unknown) = (true, None);
        for (place, (residue, error)) in signs.iter().zip(errors).enumerate() {
            // Not a number is a doubt, too.
            let known = residue.abs() > *error;
            if !known
                && count > 1
                && let Some(mode) = form.mode(place)
            {
                if !large {
                    return Err(SecularError::ResidueSign { mode });
                }
                unknown = Some(mode);
            }
            positive &= known && *residue > 0.0;
        }
        let (Some(&first), Some(&last)) = (signs.first(), signs.last()) else {
            return Ok(stable(Reason::EqualResidueSigns));
        };
        if count == 1 {
            return Ok(stable(Reason::EqualResidueSigns));
        }
        let mut leading: Option<LeadingRoot> = None;
        let mut undecided: Option<LeadingRoot> = None;
        let mut counted = 0;
        if !positive {
            // Beyond ±1: the sum over 1/(|ν|−|d|…) is positive far away.
            for (end, distances, outermost) in [(1.0, &form.below_one, last), (-1.0, &form.above_minus_one, first)] {
                let local = form.about(distances);
                let Jet { value, slope, .. } = local.jet(0.0);
                let error = local.noise(Complex::default());
                // The sign next to the outermost pole is that of its residue.
                counted += usize::from((outermost > 0.0) != (value > 0.0)) + usize::from(value < 0.0);
                if value.abs() <= error {
                    let reach = (value.abs() + error) / slope.abs();
                    let (nu, excess) = (Nu::beyond(end, reach), outside(reach));
                    undecided = most(undecided, LeadingRoot { nu, excess, error: excess, reason: Reason::Tangency });
                } else if value < 0.0 {
                    let delta = beyond(local);
                    let error = local.root_error(delta);
                    let (nu, excess) = (Nu::beyond(end, delta), outside(delta));
                    // Of √(2δ) + … from that of δ.
                    let error = (outside(delta + error) - excess).max(4.0 * f64::EPSILON * excess);
                    leading = most(leading, LeadingRoot { nu, excess, error, reason: Reason::RealRoot });
                }
            }
            counted += signs.windows(2).filter(|pair| (pair[0] > 0.0) == (pair[1] > 0.0)).count();
        } else {
            return Ok(stable(Reason::EqualResidueSigns));
        }
        suspects.clear();
        let wanted = count - 1;
        if large && (counted < wanted || unknown.is_some()) {
            return self.judge_all_roots(unknown, undecided);
        }
        if counted < wanted {
            for gap in 0..wanted {
                let (left, right) = (signs[gap], signs[gap + 1]);
                if (left > 0.0) == (right > 0.0) {
                    continue;
                }
                let width = form.distance(gap + 1, gap);
                let low = lowest(form.window(gap, gap, scratch), left.signum(), width, (left, right));
                if !low.is_certain() {
                    let reach = tangency(&low);
                    let nu = form.nu(gap, Complex::new(low.t, reach));
                    let excess = nu.excess();
                    undecided = most(undecided, LeadingRoot { nu, excess, error: excess, reason: Reason::Tangency });
                    counted += 2;
                } else if low.value < 0.0 {
                    counted += 2;
                } else {
                    let height = low.half_distance();
                    suspects.push(Suspect { gap, t: low.t, height, closeness: height / width });
                }
                if counted >= wanted {
                    break;
                }
            }
        }
        if counted < wanted {
            from_suspects(form, suspects, (wanted - counted) / 2, &mut scratch.distances, pairs);
            counted += 2 * pairs.len();
            for pair in pairs.iter() {
                let nu = form.nu(pair.place, pair.t);
                let excess = nu.excess();
                let error = nu.excess_error(excess, pair.error);
                leading = most(leading, LeadingRoot { nu, excess, error, reason: Reason::ComplexPair });
            }
        }
        if counted != wanted {
            // All roots at once know nothing of signs that are lost in rounding.
            let lost = undecided.is_some();
            return match lost {
                true => Err(SecularError::Incomplete { found: counted, wanted }),
                false => self.judge_all_roots(None, None),
            };
        }
        assemble(leading, undecided, WORST)
    }
}

pub(crate) fn stable(reason: Reason) -> SecularVerdict {
    SecularVerdict { outcome: Standing::Stable, reason, leading: None, excess: 0.0, excess_error: 0.0 }
}

pub(crate) fn most(best: Option<LeadingRoot>, other: LeadingRoot) -> Option<LeadingRoot> {
    match best {
        Some(best) if best.excess >= other.excess => Some(best),
        _ => Some(other),
    }
}

pub(crate) fn assemble(
    leading: Option<LeadingRoot>,
    undecided: Option<LeadingRoot>,
    worst: f64,
) -> Result<SecularVerdict, SecularError> {
    let tell = |this: LeadingRoot| {
        let [large, _] = this.nu.multipliers();
        let (excess, excess_error) = (this.excess, this.error);
        let certain = this.reason != Reason::Tangency && excess_error < excess;
        let outcome = if certain { Standing::Unstable } else { Standing::Undecided };
        let precise = excess_error <= worst * (1.0 + excess);
        let verdict = SecularVerdict { outcome, reason: this.reason, leading: Some(large), excess, excess_error };
        if precise { Ok(verdict) } else { Err(SecularError::Imprecise { excess, excess_error }) }
    };
    match (leading, undecided) {
        // An instability beyond doubt stays one, but how large it is may be in question.
        (Some(leading), Some(undecided)) => {
            tell(LeadingRoot { error: leading.error.max(undecided.excess - leading.excess), ..leading })
        }
        (Some(leading), None) => tell(leading),
        (None, Some(undecided)) => tell(undecided),
        (None, None) => Ok(stable(Reason::AllRootsCounted)),
    }
}

/// The largest error of an excess, in units of the multiplier, that is worth an answer: a dense solver's.
pub(crate) const WORST: f64 = 1e-5;

/// How far off the real axis a pair could be whose least |F| is lost in its error.
pub(crate) fn tangency(low: &Lowest) -> f64 {
    if low.bend > 0.0 { (2.0 * (low.value.abs() + low.noise) / low.bend).sqrt() } else { low.t }
}
