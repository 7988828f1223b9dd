//! Poles and residues of F, sorted, with their certificates.

use nalgebra::Complex;
use vibrochain_breather::{Prepared, ReversibleOrbit};
use vibrochain_lattice::ImpulseResponse;
use vibrochain_lattice::simd::lanes::{Lane, room};

use super::{double_sided, sign_screen, single_sided};
use crate::map_paths::fast_sums::evaluate::Local;
use crate::map_paths::fast_sums::large_reversible;
use crate::map_paths::fast_sums::neighbourhood::{ChargedPole, NearPoles, Nearby, Neighbourhood, divide};
use crate::map_paths::modes::Modes;
use crate::map_paths::reversible::pole::{Angle, Pole};
use crate::sizes::LARGE;
use crate::zeros::Nu;
use crate::zeros::SecularError;

/// Pole that pads the last group of four: so far away that its residue, 0, is never heard of.
const FAR: f64 = 1e100;
/// Errors of ΣR = 1 from which on it proves nothing: those of signs next to it have become as large. For [`LARGE`] poles;
/// of more, errors that have nothing to do with each other add up to more, in the bound that is.
const MOST_DOUBT: f64 = 1e-3;

/// The secular function F(ν) = Σ R_k/(ν−d_k) of a reversible orbit, ν = ½(μ + 1/μ), d_k = cos Ω_kT: its m−1 zeros are the
/// non-trivial multiplier pairs of the m modes that feel the impacts, on a ring those even about the site that is hit. Neighbours with R of one sign enclose a real
/// root; with all signs equal that are all of them, and none is off the unit circle. (The signs are not Krein signatures:
/// a root that passes the pole of a mode turns the sign of its R and keeps its signature, see [`crate::signature()`].)
///
/// Also the work space for it: nothing is allocated from the second orbit of a chain on, up to 256 modes. Above, Cauchy
/// sums take O(m) time and memory.
///
/// ```
/// use vibrochain_breather::{Family, Finder, OrbitList};
/// use vibrochain_floquet::Residues;
/// use vibrochain_lattice::{Chain, Model};
/// let model = Model::conservative(Chain::new(21, 0.2, 0.02)?, 1.1, 0.4)?;
/// let (mut finder, mut found) = (Finder::new(21), OrbitList::default());
/// finder.find(&model, Family::DoubleSided, &mut found)?;
/// let mut residues = Residues::default();
/// residues.replace(finder.prepared(&found.orbits[0])?)?;
/// // All signs alike: nothing can collide, the orbit is stable.
/// assert!(residues.residues().len() == 11 && residues.residues().iter().all(|r| *r > 0.0));
/// assert!((residues.residues().iter().sum::<f64>() - 1.0).abs() < 1e-13);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct Residues {
    modes: Modes,
    /// Of two instants whose modes are kept.
    saltations: Option<double_sided::Saltations>,
    masked: Vec<Lane>,
    /// Poles before they stand in the lists below: work space, which large rings give back.
    table: Vec<Pole>,
    /// The mode of each pole.
    owners: Vec<u32>,
    pub(crate) poles: Vec<Lane>,
    /// All poles one by one.
    pub(crate) whole: NearPoles,
    pub(crate) below_one: Vec<Lane>,
    pub(crate) above_minus_one: Vec<Lane>,
    /// The neighbourhoods of large rings.
    pub(crate) neighbourhoods: Vec<Neighbourhood>,
    sum: f64,
    trace: f64,
    expected_trace: f64,
    /// Counts the orbits taken over.
    pub(crate) edition: u64,
}

/// Where the middle of a neighbourhood is.
pub(crate) struct Middle {
    /// A gap between poles there.
    pub(crate) gap: usize,
    /// From the gap's left pole.
    pub(crate) offset: f64,
    /// Half the width of the neighbourhood.
    pub(crate) half_width: f64,
}

impl Residues {
    /// Takes over a reversible orbit. After an error there is nothing of it, nor of the one before.
    ///
    /// # Errors
    /// [`SecularError::NotReversible`]; [`SecularError::Certificate`] if ΣR = 1 or the trace is violated by more than the errors of the
    /// residues explain: then they are worth nothing.
    pub fn replace(&mut self, prepared: Prepared<'_>) -> Result<(), SecularError> {
        self.replace_within(prepared, 0.0)
    }

    /// The same, for an orbit the ratio of whose two impulses is known up to the relative error `ratio_error`.
    pub(crate) fn replace_within(&mut self, prepared: Prepared<'_>, ratio_error: f64) -> Result<(), SecularError> {
        let ratio = self.take_over(prepared, ratio_error).ok_or(SecularError::NotReversible)?;
        self.complete(ratio)
    }

    /// Poles and residues of an orbit whose modes have been taken over.
    ///
    /// # Errors
    /// As [`Residues::replace`].
    pub(crate) fn complete(&mut self, ratio: Option<(f64, f64)>) -> Result<(), SecularError> {
        self.modes.make_list();
        let done = self.work_out(ratio);
        if self.count() > LARGE {
            self.modes.give_back();
        }
        done
    }

    /// Takes over the modes alone; the ratio of the impulses of two instants, and its error, is left to tell
    /// [`Residues::all_positive`] or [`Residues::complete`]. `None` of an orbit that is not its own mirror image in time, or has impacts at
    /// several sites.
    pub(crate) fn take_over(&mut self, prepared: Prepared<'_>, ratio_error: f64) -> Option<Option<(f64, f64)>> {
        if !prepared.orbit().is_reversible() || prepared.orbit().impact_site().is_none() {
            return None;
        }
        let ratio = match prepared.orbit().impacts() {
            [_] => None,
            [first, second] if first.impulse != 0.0 && second.impulse != 0.0 => {
                Some((second.impulse / first.impulse, ratio_error))
            }
            _ => return None,
        };
        self.modes.set_felt(prepared);
        Some(ratio)
    }

    /// Takes over the modes of a ring, as [`Residues::take_over`] does.
    pub(crate) fn take_over_ring(&mut self, response: &ImpulseResponse) {
        self.modes.set_in_fours(response);
    }

    /// Takes over the modes of a structure's orbit, as [`Residues::take_over`] does; `None` of more than [`LARGE`] modes: sums over far ones
    /// know nothing of errors of their weights.
    pub(crate) fn take_over_structure(&mut self, orbit: &ReversibleOrbit<'_>) -> Option<Option<(f64, f64)>> {
        if orbit.modes.len() > LARGE {
            return None;
        }
        self.modes.set_of_contact(orbit.modes, orbit.period);
        Some(orbit.ratio)
    }

    /// Whether all residues of the modes taken over are surely positive, so that nothing can collide. No is no answer.
    pub(crate) fn all_positive(&self, ratio: Option<(f64, f64)>) -> bool {
        self.modes.count() <= LARGE && sign_screen::all_positive(&self.modes, ratio)
    }

    pub(crate) fn modes(&self) -> &Modes {
        &self.modes
    }

    /// K and Λ, if there are two instants, of up to [`LARGE`] modes.
    pub(crate) fn saltations(&self) -> Option<&double_sided::Saltations> {
        self.saltations.as_ref()
    }

    /// Poles and residues of the modes taken over, for one instant or two with this ratio of impulses and its error.
    fn work_out(&mut self, ratio: Option<(f64, f64)>) -> Result<(), SecularError> {
        let large = self.modes.count() > LARGE;
        self.saltations = None;
        match ratio {
            None => {
                if large {
                    large_reversible::single_sided(&self.modes, &mut self.table);
                } else {
                    single_sided::residues(&self.modes, &mut self.table);
                }
                self.expected_trace = single_sided::trace(self.modes.list().iter().copied());
            }
            Some((ratio, ratio_error)) => {
                let saltations = double_sided::Saltations::new(&self.modes, ratio, ratio_error);
                if large {
                    large_reversible::double_sided(&self.modes, &saltations, &mut self.table);
                } else {
                    double_sided::residues(&self.modes, &saltations, &mut self.masked, &mut self.table);
                }
                self.saltations = Some(saltations).filter(|_| !large);
                self.expected_trace = double_sided::trace(self.modes.list().iter().copied(), &saltations);
            }
        }
        self.edition += 1;
        if let [only] = self.table.as_mut_slice() {
            // One mode: the trivial pair is all there is.
            (only.residue, only.error) = (1.0, 0.0);
            self.expected_trace = only.at.d;
        }
        self.mend();
        // Frequencies rise, so that poles often come in falling order.
        if let [first, .., last] = self.table.as_slice()
            && first.at.d > last.at.d
        {
            self.table.reverse();
        }
        self.table.sort_unstable_by(|a, b| a.at.order(&b.at));
        self.neighbourhoods.clear();
        let table = &self.table;
        self.owners.clear();
        self.owners.extend(table.iter().map(|pole| pole.mode));
        let sources = table.iter().map(|pole| ChargedPole {
            at: pole.at,
            shift: pole.shift,
            charges: [pole.residue, pole.error],
        });
        self.whole.fill(sources);
        let [poles, below_one, above_minus_one] =
            [&mut self.poles, &mut self.below_one, &mut self.above_minus_one].map(|list| room(list, table.len(), FAR));
        for (i, pole) in table.iter().enumerate() {
            (poles[i], below_one[i], above_minus_one[i]) = (pole.at.d, pole.below_one, pole.above_minus_one);
        }
        self.certify()?;
        if large {
            self.table = Vec::new();
            let (residues, errors) = (self.residues(), self.errors());
            self.neighbourhoods = divide(self.poles(), |place| [residues[place], errors[place]]);
        }
        Ok(())
    }

    /// F about an origin.
    pub(crate) fn about<'a>(&'a self, distances: &'a [Lane]) -> Local<'a> {
        Local { near_poles: &self.whole, distances, origin: None }
    }

    /// F about the pole at `place`, for use in the gap right of the pole at `gap`. `nearby` is scratch space.
    pub(crate) fn window<'a>(&'a self, gap: usize, place: usize, nearby: &'a mut Nearby) -> Local<'a> {
        let neighbourhood = self.neighbourhoods.partition_point(|neighbourhood| neighbourhood.gaps.end <= gap);
        let Some(neighbourhood) = self.neighbourhoods.get(neighbourhood) else {
            self.distances(place, &mut nearby.distances);
            return self.about(&nearby.distances);
        };
        let (near_poles, distances) = nearby.look(&self.whole, neighbourhood, &self.at(place));
        Local { near_poles, distances, origin: Some((self.poles()[place] - near_poles.middle) * near_poles.scale) }
    }

    /// Where the middle of a neighbourhood is.
    pub(crate) fn middle(&self, neighbourhood: usize) -> Middle {
        let Neighbourhood { gaps, middle, scale, .. } = &self.neighbourhoods[neighbourhood];
        let gap = (gaps.start + gaps.len() / 2).min(self.count().saturating_sub(2));
        let half_width = if *scale > 0.0 { 1.0 / scale } else { 0.0 };
        Middle { gap, offset: middle - self.poles()[gap], half_width }
    }

    /// Distances of all poles from that at `place`.
    pub(crate) fn distances(&self, place: usize, out: &mut Vec<Lane>) {
        if place < self.count() {
            self.whole.distances(&self.at(place), out);
        }
    }

    /// Where the pole at `place` is.
    fn at(&self, place: usize) -> Angle {
        self.whole.at(place, self.poles()[place])
    }

    /// The pole at one place less that at another.
    pub(crate) fn distance(&self, place: usize, other: usize) -> f64 {
        if place.max(other) < self.count() { self.at(place).distance(&self.at(other)) } else { 0.0 }
    }

    /// ν at an offset from a pole.
    pub(crate) fn nu(&self, place: usize, t: Complex<f64>) -> Nu {
        if place >= self.count() {
            return Nu::default();
        }
        let [below, above] = [&self.below_one, &self.above_minus_one].map(|list| self.flat(list)[place]);
        Nu { below: t.re - below, above: t.re + above, im: t.im }
    }

    /// The residue known worst, from ΣR = 1.
    fn mend(&mut self) {
        let Some(worst) = (0..self.table.len()).max_by(|&i, &j| self.table[i].error.total_cmp(&self.table[j].error))
        else {
            return;
        };
        let others = [&self.table[..worst], &self.table[worst + 1..]];
        let [mut sum, mut error, mut size] = [0.0; 3];
        for pole in others.into_iter().flatten() {
            (sum, error, size) = (sum + pole.residue, error + pole.error, size + pole.residue.abs());
        }
        let error = error + f64::EPSILON * (1.0 + size);
        // A rigid mode's own formula gives no number at all.
        let unknown = !self.table[worst].residue.is_finite() || self.table[worst].error.is_nan();
        if unknown || error < 0.25 * self.table[worst].error {
            self.table[worst].residue = 1.0 - sum;
            self.table[worst].error = error;
        }
    }

    fn certify(&mut self) -> Result<(), SecularError> {
        (self.sum, self.trace) = (0.0, 0.0);
        let [mut size, mut total_error] = [0.0; 2];
        for pole in &self.table {
            self.sum += pole.residue;
            self.trace += pole.residue * pole.at.d;
            total_error += pole.error;
            size += pole.residue.abs();
        }
        let allowed = 16.0 * (total_error + f64::EPSILON * (1.0 + size + self.expected_trace.abs()));
        let defect = self.sum_defect().abs().max(self.trace_defect().abs());
        // Not a number is a doubt, too. And errors that could hide the 1 itself leave nothing to certify, however small they are
        // against residues that cancel.
        let most = MOST_DOUBT * (self.count() as f64 / LARGE as f64).clamp(1.0, 500.0);
        if defect <= allowed && allowed < size.min(most) {
            Ok(())
        } else {
            Err(SecularError::Certificate { defect, allowed })
        }
    }

    /// Poles d_k = cos Ω_kT, rising.
    pub fn poles(&self) -> &[f64] {
        self.flat(&self.poles)
    }

    /// Residues R_k in the order of the poles.
    pub fn residues(&self) -> &[f64] {
        self.flat(&self.whole.charges[0])
    }

    /// Estimates of the rounding errors of the residues.
    pub fn errors(&self) -> &[f64] {
        self.flat(&self.whole.charges[1])
    }

    /// The mode k to which a pole belongs, by the pole's place.
    pub fn mode(&self, place: usize) -> Option<usize> {
        self.owners.get(place).map(|&mode| self.modes.number(mode as usize))
    }

    /// ΣR_k − 1, a certificate.
    pub fn sum_defect(&self) -> f64 {
        self.sum - 1.0
    }

    /// ΣR_kd_k less the same from the trace of the monodromy matrix, a certificate.
    pub fn trace_defect(&self) -> f64 {
        self.trace - self.expected_trace
    }

    /// Σν over the non-trivial pairs.
    pub(crate) fn sum_of_roots(&self) -> f64 {
        self.poles().iter().zip(self.residues()).map(|(d, residue)| d * (1.0 - residue)).sum()
    }

    pub(crate) fn count(&self) -> usize {
        self.owners.len()
    }

    fn flat<'a>(&self, lanes: &'a [Lane]) -> &'a [f64] {
        &lanes.as_flattened()[..self.count()]
    }
}
