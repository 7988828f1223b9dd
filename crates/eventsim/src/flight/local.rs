//! Flight of a structure's coordinates by local series: what stays the same during a run.
//!
//! d_{k+2} = −M⁻¹(K d_k + C d_{k+1}) + F_k ([`crate::series`]), in a unit of time that is a power of two. Places are measured from where the
//! static load holds the modes; what is left of that load, of those that it holds nowhere, pulls on.

use std::fmt;
use std::ops::Range;
use std::sync::Arc;

use crate::flight::loads::{Answer, Loads};
use crate::series::bound;
use crate::series::stencil::{Links, Stencil, lost_of_springs};
use crate::series::{CORRECTED, Rows};
use crate::units::{Growth, MAX_ORDER, ORDERS, REMAINDER, inverse_factorials};
use vibrochain_lattice::{Bands, Barrier, Complex, Ends, LinearMode, ModalStructure, Pulls, SparseOperator};

type C = Complex<f64>;

/// What the sum of an exponential and a sine costs, in multiplications, and how often in the unit of the loads' rate a contact is looked at:
/// measured.
const TERM: f64 = 100.0;

/// Derivatives are at most so often the size of the motion, times powers of the fastest rate: displacements and velocities together, with room for
/// the growth of what follows an impact in a window, and of perturbations.
const SIZE: f64 = 8.0;

/// What a contact costs a derivative of local series beside the sum over its coordinates: bounds, and where it is.
const CONTACT: usize = 8;

/// What pulls at coordinates, in internal time.
#[derive(Debug, Clone)]
enum Scaled {
    Row([Ends; 2], Stencil),
    Layers(Links),
    Bands([Bands; 2]),
}

/// M⁻¹f of one harmonic, in internal time.
#[derive(Debug, Clone)]
enum Load {
    /// The same at all coordinates.
    Alike(C),
    /// Real and imaginary parts.
    Each([Vec<f64>; 2]),
}

/// The structure by its coordinates.
#[derive(Debug, Clone)]
pub(crate) struct Local {
    pub(crate) operator: Arc<SparseOperator>,
    /// Internal time is time × `scale`, a power of two.
    pub(crate) scale: f64,
    pulls: Scaled,
    loads: Vec<(f64, Load)>,
    /// Rates of the loads, in the structure's time.
    pub(crate) rates: Vec<f64>,
    /// What is left of M⁻¹s, in internal time; empty where nothing is.
    still: Vec<f64>,
    /// Where the static load holds the coordinates.
    pub(crate) equilibrium: Vec<f64>,
    /// M⁻¹s
    pub(crate) gravity: Vec<f64>,
    pub(crate) growth: Growth,
    /// Longest windows of each order, internal.
    pub(crate) horizons: [f64; ORDERS.len()],
    pub(crate) inverse_factorial: [f64; MAX_ORDER + 1],
    /// 1/k from k = 1 on.
    pub(crate) inverse: [f64; MAX_ORDER + 1],
    /// √m, where masses differ.
    pub(crate) roots: Vec<f64>,
}

/// Contacts at rest, and what holds them: impulses that change their velocities by given ones.
#[derive(Debug, Clone, Default)]
pub(crate) struct Held {
    pub(crate) contacts: Vec<(usize, Barrier)>,
    /// One row a contact; a single entry where no two share a coordinate.
    pub(crate) inverse: Vec<Vec<f64>>,
    /// No two share a coordinate and each sees one alone: what is held is 0 there.
    pub(crate) is_plain: bool,
}

impl Held {
    /// The impulse at the i-th that changes all velocities by `changes`.
    fn impulse(&self, i: usize, changes: &[f64]) -> f64 {
        match &self.inverse[i][..] {
            [alone] => alone * changes[i],
            row => row.iter().zip(changes).map(|(entry, change)| entry * change).sum(),
        }
    }
}

/// Derivatives of all coordinates at an instant, and of the forces at contacts at rest, in internal time.
#[derive(Debug, Clone, Default)]
pub(crate) struct LocalSeries {
    pub(crate) rows: Rows,
    pub(crate) held: Held,
    /// λ of each that is held.
    pub(crate) forces: Vec<[f64; MAX_ORDER + 1]>,
    /// Coordinates that leave a barrier with a derivative of an order above 1, those below it being 0.
    pub(crate) soft: Vec<(usize, u8)>,
}

impl Local {
    /// A bound of the fastest rate of its motion without loads: the larger root of r² = |M⁻¹K| + |M⁻¹C| r.
    pub(crate) fn rate(operator: &SparseOperator) -> f64 {
        let [stiff, damped] = operator.largest_rows();
        0.5 * (damped + (damped * damped + 4.0 * stiff).sqrt())
    }

    /// Of coordinates whose modes are known, or none of them, with the fastest rate of a mode or of a load.
    pub(crate) fn new(operator: Arc<SparseOperator>, modes: &[LinearMode], loads: &Loads, fastest: f64) -> Self {
        // The power of two below: the exponent alone.
        let scale = f64::from_bits(fastest.to_bits() & 0x7ff0_0000_0000_0000);
        let square = scale * scale;
        let of_mode = |(mode, xi): (&LinearMode, &[f64; 2]), n: usize| {
            mode.coordinates[n][0] * xi[0] + mode.coordinates[n][1] * xi[1]
        };
        let size = operator.masses.len();
        let held = || modes.iter().zip(&loads.equilibrium);
        let equilibrium: Vec<f64> = (0..size).map(|n| held().map(|pair| of_mode(pair, n)).sum()).collect();
        // What modes answer from rest.
        let left: Vec<(&LinearMode, [f64; 2])> = (modes.iter().zip(&loads.answers))
            .filter(|(_, answers)| answers[0] == Answer::FromRest)
            .map(|(mode, _)| (mode, mode.turn.act(mode.generator(), mode.still)))
            .collect();
        let pulled = |n: usize| left.iter().map(|(mode, rise)| of_mode((mode, rise), n)).sum::<f64>();
        let still: Vec<f64> = if left.is_empty() { Vec::new() } else { (0..size).map(pulled).collect() };
        let weight = |n: usize| still.get(n).copied().unwrap_or(0.0) + operator.pull(n, false, |m| equilibrium[m]);
        let gravity = (0..size).map(weight).collect();
        let damped = operator.largest_rows()[1] / scale;
        let rates: Vec<f64> = loads.rates[1..].iter().map(|rate| rate / scale).collect();
        let own = Self::rate(&operator) / scale;
        let rate = rates.iter().copied().fold(own, f64::max).max(f64::MIN_POSITIVE);
        let load_at = |n: usize| operator.loads.iter().map(|load| load[n].norm()).sum::<f64>();
        let forced = (0..size).map(|n| load_at(n) + still.get(n).map_or(0.0, |a| a.abs())).fold(0.0, f64::max);
        let forced = forced / square * if damped == 0.0 { 0.5 } else { 1.0 };
        let still = still.iter().map(|a| a / square).collect();
        let inverse_factorial = inverse_factorials();
        let horizon =
            |order: usize| (REMAINDER / SIZE / inverse_factorial[order]).powf(1.0 / order as f64) * scale / fastest;
        let load = |(load, rate): (&Vec<C>, f64)| {
            let alike = load.windows(2).all(|pair| pair[0] == pair[1]);
            let scaled = load.iter().map(|f| f / square);
            let load = if alike {
                Load::Alike(scaled.take(1).sum())
            } else {
                Load::Each([scaled.clone().map(|f| f.re).collect(), scaled.map(|f| f.im).collect()])
            };
            (rate, load)
        };
        let pulls = match &operator.pulls {
            Pulls::Alike { ends, stiffness, damping, layering } => {
                let stencil =
                    Stencil { stiffness: stiffness.map(|gamma| gamma / square), damping: damping.map(|c| c / scale) };
                if layering.layers == 1 {
                    Scaled::Row(*ends, stencil)
                } else {
                    Scaled::Layers(Links::new(stencil, layering.stiffness / square, size, |n| operator.neighbours(n)))
                }
            }
            Pulls::Bands { stiffness, damping } => {
                Scaled::Bands([stiffness.times(1.0 / square), damping.times(1.0 / scale)])
            }
        };
        let differ = operator.masses.windows(2).any(|pair| pair[0] != pair[1]);
        let roots = if differ { operator.masses.iter().map(|mass| mass.sqrt()).collect() } else { Vec::new() };
        Self {
            scale,
            pulls,
            rates: rates.iter().map(|rate| rate * scale).collect(),
            loads: operator.loads.iter().zip(rates).map(load).collect(),
            still,
            equilibrium,
            gravity,
            growth: Growth { rate, forced },
            // The bound of all masses uses nothing but the rates of rows: the window is no longer than it allows.
            horizons: ORDERS.map(horizon).map(|horizon| horizon.min(4.0 / rate)),
            inverse_factorial,
            inverse: std::array::from_fn(|k| 1.0 / k.max(1) as f64),
            roots,
            operator,
        }
    }

    /// Derivatives up to `order`, and the forces that hold contacts at rest; rows 0 and 1 are there. `turned` are e^{iw(t+ψ)}, the static load's
    /// first. `is_direct`: contact n sees coordinate n as it is.
    pub(crate) fn expand(&self, series: &mut LocalSeries, is_direct: bool, turned: &[C], order: usize) {
        let LocalSeries { rows, held, forces, soft } = series;
        forces.clear();
        forces.resize(held.contacts.len(), [0.0; MAX_ORDER + 1]);
        let whole = [(0..self.operator.masses.len(), 0)];
        if is_direct && held.contacts.is_empty() && soft.is_empty() {
            return self.fill(rows, &whole, self.beyond(), turned, order, |_, _| {});
        }
        if is_direct {
            return self.fill(rows, &whole, self.beyond(), turned, order, |k, to| {
                for ((n, _), own) in held.contacts.iter().zip(forces.iter_mut()) {
                    own[k] = -to[n + 1] * self.operator.masses[*n];
                    to[n + 1] = 0.0;
                }
                let is_none = |first: &u8| k + 2 < usize::from(*first);
                soft.iter().filter(|(_, first)| is_none(first)).for_each(|(n, _)| to[n + 1] = 0.0);
            });
        }
        let mut changes = vec![0.0; held.contacts.len()];
        self.fill(rows, &whole, self.beyond(), turned, order, |k, to| {
            let all = &self.operator.contacts;
            for ((contact, _), change) in held.contacts.iter().zip(&mut changes) {
                *change = -all[*contact].iter().map(|(place, weight)| weight * to[place + 1]).sum::<f64>();
            }
            for (i, ((contact, _), own)) in held.contacts.iter().zip(forces.iter_mut()).enumerate() {
                own[k] = held.impulse(i, &changes);
                for (place, weight) in &all[*contact] {
                    if held.is_plain {
                        to[place + 1] = 0.0;
                    } else {
                        to[place + 1] += weight / self.operator.masses[*place] * own[k];
                    }
                }
            }
        });
    }

    /// The longest part of a window for which what its series leaves out is below rounding, in velocities, too: derivatives beyond the last two grow
    /// as these do, by the fastest rate.
    pub(crate) fn certified(&self, rows: &Rows, longest: f64, fastest: f64) -> f64 {
        let (order, fastest) = (rows.order, fastest / self.scale);
        let row = |k: usize| self.largest(rows.row(k, 0));
        let last = row(order).max(row(order - 1) * self.growth.rate) * self.inverse_factorial[order];
        // What moves at all, by the first derivatives in units of the fastest rate.
        let mut size = row(0).max(row(1) / fastest);
        if last * longest.powi(order as i32) <= REMAINDER * size {
            return longest;
        }
        size = size.max(row(2) / fastest.powi(2)).max(row(3) / fastest.powi(3));
        let certain = (REMAINDER * size / last).powf(1.0 / order as f64);
        if last > 0.0 && certain.is_finite() { longest.min(certain) } else { longest }
    }

    /// The k-th derivative of the loads on a coordinate, over its mass, in the structure's time.
    pub(crate) fn load(&self, turned: &[C], n: usize, k: u32) -> f64 {
        let loads = self.operator.loads.iter().zip(&self.rates).zip(&turned[1..]);
        let driven = loads.map(|((load, rate), now)| (load[n] * now * C::new(0.0, *rate).powu(k)).re);
        driven.sum::<f64>() + if k == 0 { self.remaining(n) } else { 0.0 }
    }

    /// What stands at the ends of the coordinates; where neighbours are looked up, the wall.
    pub(crate) fn beyond(&self) -> [Option<Ends>; 2] {
        match &self.pulls {
            Scaled::Row(ends, _) => ends.map(Some),
            _ => [Some(Ends::Fixed); 2],
        }
    }

    /// What rounding took from the derivatives of coordinate `n`, to first order and with the neighbours exact, where masses are alike and
    /// nothing damps them.
    ///
    /// A mass that leaves a barrier is at the same place at every impact, to the bit, and its rounding errors with it.
    /// Alone among all they do not average out: they would change the energy by up to ε/2 an impact.
    pub(crate) fn lost(&self, n: usize, rows: &Rows) -> Option<[f64; CORRECTED]> {
        let (stencil, across, [left, right, below, above]) = match &self.pulls {
            Scaled::Row(_, stencil) => (stencil, 0.0, [n, n + 2, n + 1, n + 1]),
            Scaled::Layers(links) => links.of(n),
            Scaled::Bands(_) => return None,
        };
        let ([ground, between], own) = (stencil.stiffness, n + 1);
        if stencil.damping != [0.0; 2] {
            return None;
        }
        // The mass beside a free end is the same one, and errs with it: no spring.
        let [a, b, c, d] = self.operator.neighbours(n).map(|side| f64::from(u8::from(side != Some(n))));
        let held = ground + (a + b) * between + (c + d) * across;
        let mut lost = [0.0; CORRECTED];
        for k in 2..CORRECTED {
            let row = &rows.data[(k - 2) * rows.stride..];
            let pairs = [(between, [row[left], row[right]]), (across, [row[below], row[above]])];
            lost[k] = lost_of_springs(row[own], ground, pairs) - held * lost[k - 2];
        }
        Some(lost)
    }

    /// What is left of M⁻¹s of a coordinate, in the structure's time.
    fn remaining(&self, n: usize) -> f64 {
        self.still.get(n).map_or(0.0, |still| still * self.scale * self.scale)
    }

    /// The row that the coordinates are, of masses alike: what stands at its ends, and γ₂ and c₂.
    pub(crate) fn row(&self) -> Option<([Ends; 2], [f64; 2])> {
        match &self.pulls {
            Scaled::Row(ends, Stencil { stiffness, damping }) => Some((*ends, [stiffness[1], damping[1]])),
            _ => None,
        }
    }

    /// Derivatives up to `order` of ranges of coordinates, each with its first column; rows 0 and 1 are there. `hold` may change each order
    /// before the next follows from it.
    #[inline(always)]
    pub(crate) fn fill(
        &self,
        rows: &mut Rows,
        ranges: &[(Range<usize>, usize)],
        beyond: [Option<Ends>; 2],
        turned: &[C],
        order: usize,
        mut hold: impl FnMut(usize, &mut [f64]),
    ) {
        let n = ranges.iter().map(|(range, _)| range.len()).sum();
        // (Where there is nothing else, to ask for it costs as much as the springs of a short row.)
        if let (Scaled::Row(_, stencil), true) = (&self.pulls, self.loads.is_empty() && self.still.is_empty())
            && stencil.damping == [0.0; 2]
        {
            return rows.expand(n, beyond, order, |k, from, to| {
                stencil.advance::<false>(from, to, n, 0.0);
                hold(k, to);
            });
        }
        let mut now: Vec<C> = turned[1..].to_vec();
        rows.expand(n, beyond, order, |k, from, to| {
            let mut force = 0.0;
            for ((_, load), now) in self.loads.iter().zip(&now) {
                if let Load::Alike(load) = load {
                    force += (load * now).re;
                }
            }
            match &self.pulls {
                Scaled::Row(_, stencil) if stencil.damping == [0.0; 2] => {
                    stencil.advance::<false>(from, to, n, force);
                }
                Scaled::Row(_, stencil) => stencil.advance::<true>(from, to, n, force),
                Scaled::Layers(links) => links.advance(from, to, force),
                Scaled::Bands(both) => {
                    to[1..=n].fill(force);
                    both.iter().zip(from).for_each(|(bands, from)| subtract(bands, &from[1..=n], &mut to[1..=n]));
                }
            }
            for ((rate, load), now) in self.loads.iter().zip(&mut now) {
                if let Load::Each([real, imaginary]) = load {
                    for (range, first) in ranges {
                        let parts = real[range.clone()].iter().zip(&imaginary[range.clone()]);
                        let to = &mut to[first + 1..];
                        to.iter_mut().zip(parts).for_each(|(to, (re, im))| *to += re * now.re - im * now.im);
                    }
                }
                *now *= C::new(0.0, *rate);
            }
            if k == 0 && !self.still.is_empty() {
                for (range, first) in ranges {
                    let still = &self.still[range.clone()];
                    to[first + 1..].iter_mut().zip(still).for_each(|(to, still)| *to += still);
                }
            }
            hold(k, to);
        });
    }

    /// The largest of a row, by the roots of the masses.
    pub(crate) fn largest(&self, row: &[f64]) -> f64 {
        if self.roots.is_empty() {
            return bound::largest(&row[..self.operator.masses.len()]);
        }
        row.iter().zip(&self.roots).map(|(d, root)| (d * root).abs()).fold(0.0, f64::max)
    }

    /// Work of the loads and what dashpots take, a unit of time, at velocities and where loads are `turned`.
    pub(crate) fn powers(&self, velocity: &[f64], turned: &[C]) -> [f64; 2] {
        let operator = &self.operator;
        let driven =
            |n: usize| operator.loads.iter().zip(&turned[1..]).map(move |(load, turned)| (load[n] * turned).re);
        let given = |n: usize| self.gravity[n] + driven(n).sum::<f64>();
        let masses = operator.masses.iter().zip(velocity).enumerate();
        let work = masses.map(|(n, (mass, v))| mass * v * given(n)).sum();
        let [_, damping] = operator.entries(None);
        let taken =
            damping.iter().map(|(row, column, c)| operator.masses[*row] * velocity[*row] * c * velocity[*column]);
        [work, taken.sum()]
    }
}

/// How a structure flies between impacts, and by what that is decided.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlightChoice {
    /// Multiplications in a unit of time by local series of the coordinates; `None`: the structure is its modes alone, or one of them grows by
    /// itself.
    pub local: Option<f64>,
    /// By modes; `None` of a chain, whose modes are not asked for.
    pub modal: Option<f64>,
}

impl FlightChoice {
    /// By modes each contact is a sum of exponentials, looked at once in about the unit of the loads' rate.
    pub(crate) fn new(structure: &ModalStructure, (omega, fastest): (f64, f64)) -> Self {
        // Modes that grow are asked for one by one how far they have come.
        let grows = |mode: &LinearMode| mode.rates().iter().any(|rate| rate.re > 0.0);
        let operator = structure.operator().filter(|_| !structure.modes().iter().any(grows));
        let local = operator.map(|operator| Self::operations(operator, fastest));
        let modal = (structure.contacts().len() * structure.modes().len()) as f64 * TERM * omega;
        Self { local, modal: Some(modal) }
    }

    /// Of coordinates alone.
    pub(crate) fn of_operator(operator: &SparseOperator, fastest: f64) -> Self {
        Self { local: Some(Self::operations(operator, fastest)), modal: None }
    }

    /// Local series take all orders of all coordinates in a window of about two units of the fastest rate.
    fn operations(operator: &SparseOperator, fastest: f64) -> f64 {
        let contacts: usize = operator.contacts.iter().map(|contact| contact.len() + CONTACT).sum();
        (operator.operations() + contacts) as f64 * MAX_ORDER as f64 * 0.5 * fastest
    }

    /// Whether it flies by local series: they take no more multiplications.
    pub fn is_local(&self) -> bool {
        self.local.is_some_and(|local| self.modal.is_none_or(|modal| local <= modal))
    }
}

impl fmt::Display for FlightChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (names, known) = (["by local series", "by modes"], [self.local, self.modal]);
        let own = usize::from(!self.is_local());
        write!(f, "flight {}: {:.1e} multiplications in a unit of time", names[own], known[own].unwrap_or(0.0))?;
        known[1 - own].map_or(Ok(()), |other| write!(f, ", {} {other:.1e}", names[1 - own]))
    }
}

/// `to` −= bands · `from`
fn subtract(bands: &Bands, from: &[f64], to: &mut [f64]) {
    for (off, diagonal) in &bands.diagonals {
        let (rows, columns) = (off.min(&0).unsigned_abs(), off.max(&0).unsigned_abs());
        let inside = to[rows..].iter_mut().zip(&diagonal[rows..]).zip(&from[columns..]);
        inside.for_each(|((to, entry), from)| *to -= entry * from);
    }
    for (row, column, entry) in &bands.entries {
        to[*row] -= entry * from[*column];
    }
}

#[cfg(test)]
mod tests;
