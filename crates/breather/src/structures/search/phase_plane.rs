//! Orbits of one impact and of two under any loads, with proof: of one as zeros of a function of the loads' phase ψ, of two as zeros of two functions
//! of φ and ψ, which are enclosed on rectangles ([`planar`](crate::roots::planar)).
//!
//! Places, balances and Newton's laws of two impacts are W X = 0 for X = (P₁, P₂, offsets, h): h stands for 1, and multiplies the loads and
//! the stops. W has two rows more than the null vector needs.
//!
//! With one harmonic F does with φ alone (`two_impacts`). Its double zeros, whose orbits have one φ and different ψ, are simple zeros here.

use smallvec::{SmallVec, smallvec};
use vibrochain_lattice::simd::lanes::{LANES, Lane};
use vibrochain_lattice::{Complex, Stop};

use super::at_times::{Impacts, Start, all_places};
use super::elimination::{Elimination, MOST, Table};
use super::open_pieces::{OpenRows, OpenStrip, at_phase};
use super::orbits::{Starts, boxes};
use super::two_impacts::{RESOLUTION, told_apart};
use crate::roots::dual::{Algebra, Dual};
use crate::roots::interval::{Clearance, Enclosed, Zeros, one_by_one};
use crate::roots::patch::{Patch, Piece};
use crate::roots::planar::{Planar, PlanarZeros};
use crate::search::completeness::Searched;
use crate::search::finder::Scope;
use crate::structures::between::{Between, Pair};
use crate::structures::point::{Point, Strike};

type C = Complex<f64>;

/// Rectangles to begin with, each way.
const PIECES: [usize; 2] = [6, 64];

/// Intervals of ψ to begin with, of one impact.
const LEAST_PIECES: usize = 8;

/// Where ψ begins, as a part of the loads' repetition: no symmetry puts a zero there.
const START: f64 = -0.1234;

/// Zeros of ψ at both ends of the loads' repetition are one.
const SEAM: f64 = 1e-9;

/// Of two impacts alike the shorter time between them is sought, and this part of half the period more, where both are as long.
const BEYOND: f64 = 1e-6;

/// The frequencies of the loads and ĝ of a contact.
type Swings = SmallVec<[(f64, C); 4]>;

/// W of two impacts.
struct PhasePlane {
    period: f64,
    /// After which time the loads are the same again.
    repeat: f64,
    between: Between,
    swings: [Swings; 2],
    /// The fastest load.
    fastest: f64,
    /// 1+e
    weights: [f64; 2],
    /// Of each contact with itself, a period later: K, and 1/m + (1+e)K′.
    own: [[f64; 2]; 2],
    /// Stops less what is still.
    places: [f64; 2],
    /// Which way impulses push; 0 where those that pull are asked for, too.
    push: [f64; 2],
    /// Of each rigid motion what both contacts have of it, and the push of the static load in a period.
    rigid: SmallVec<[([f64; 2], f64); 1]>,
    /// The modes whose states are unknowns.
    open: Vec<OpenRows>,
    /// The least and the largest φ.
    range: [f64; 2],
    table: Elimination,
    budget: usize,
    stop: Stop,
}

impl PhasePlane {
    /// `None` of modes that grow, of rigid ones with a dashpot, and of more rigid ones than there is room for.
    fn new(impacts: &Impacts<'_>, is_pushed: bool, budget: usize) -> Option<Self> {
        let equations = impacts.equations;
        let letters: [_; 2] = impacts.letters.as_slice().try_into().ok()?;
        let contacts = letters.map(|(contact, _)| contact);
        let places = impacts.places()?;
        let period = equations.period();
        let drifts = equations.rigid.len();
        let more = drifts + 2 * equations.open.len();
        if 4 + more > MOST {
            return None;
        }
        let swings = contacts.map(|contact| equations.swings(contact).collect::<Swings>());
        let weights = contacts.map(|contact| 1.0 + equations.restitution(contact));
        let open = OpenRows::of(equations, &contacts);
        let least = |row: usize| match row {
            2 | 3 => equations.mobility(contacts[row - 2]),
            _ if row >= 4 + drifts => open.get((row - 4 - drifts) / 2).map_or(f64::MIN_POSITIVE, OpenRows::given),
            _ => f64::MIN_POSITIVE,
        };
        let table = Elimination { rows: 4 + more, columns: 3 + more, least: std::array::from_fn(least) };
        let loads = swings.iter().flatten().map(|(rate, _)| *rate);
        let loads = loads.chain(open.iter().map(|rows| rows.fastest()[1]));
        let shortest = period * told_apart(contacts[0] == contacts[1] && places[0] == places[1]);
        let longest = if letters[0] == letters[1] { 0.5 * period * (1.0 + BEYOND) } else { period - shortest };
        Some(Self {
            period,
            repeat: equations.model.loads_repeat(),
            between: Between::new(equations.kernel(), contacts[0], contacts[1])?,
            fastest: loads.fold(0.0, f64::max),
            swings,
            weights,
            own: contacts.map(|contact| equations.own(contact)),
            places: [places[0], places[1]],
            push: letters.map(|(_, barrier)| if is_pushed { -barrier.sign() } else { 0.0 }),
            rigid: equations
                .rigid
                .iter()
                .map(|drift| (contacts.map(|contact| drift.shapes[contact]), drift.push * period))
                .collect(),
            open,
            range: [shortest, longest],
            table,
            budget,
            stop: equations.model.stop().clone(),
        })
    }

    /// All zeros.
    fn zeros(&self) -> PlanarZeros {
        let mut zeros = PlanarZeros { stop: self.stop.clone(), ..PlanarZeros::default() };
        let [from, to] = self.range;
        let start = START * self.repeat;
        let fastest =
            self.open.iter().map(|rows| rows.fastest()[0]).fold(self.between.fastest.max(self.fastest), f64::max);
        let waves = [fastest * (to - from), self.fastest * self.repeat];
        let pieces = waves.map(|turned| ((0.5 * turned) as usize).clamp(PIECES[0], PIECES[1]));
        zeros.find(self, [from, to], [start, start + self.repeat], pieces, RESOLUTION * self.period);
        let known = std::mem::take(&mut zeros.simple);
        for at in known {
            let is_seam = |other: &[f64; 2]| {
                (at[0] - other[0]).abs() <= SEAM * self.period
                    && ((at[1] - other[1]).abs() - self.repeat).abs() <= SEAM * self.repeat
            };
            if !zeros.simple.iter().any(is_seam) {
                zeros.simple.push(at);
            }
        }
        zeros
    }

    /// Impulses and offsets at a zero. `None` where they are not determined.
    fn numbers(&self, [phi, psi]: [f64; 2]) -> Option<Vec<f64>> {
        let table = self.filled(&self.strip(phi, 0.0), [phi, psi], [0.0; 2]);
        let numbers = self.table.reduced(&table).ok()?.numbers.map(|number| number.value());
        let (h, numbers) = (numbers[self.table.columns - 1], &numbers[..self.table.columns - 1]);
        let numbers: Vec<f64> = numbers.iter().map(|x| x / h).collect();
        numbers.iter().all(|x| x.is_finite()).then_some(numbers)
    }

    /// The loads at an impact at t + ψ: G less the stop, and (1+e)G′.
    fn loads(&self, impact: usize, t: f64, axes: [bool; 2], radius: [f64; 2]) -> [Patch; 2] {
        let mut sums = [Patch::constant(0.0, radius); 2];
        for (rate, swing) in &self.swings[impact] {
            let (size, there) = (swing.norm(), swing * C::from_polar(1.0, rate * t));
            let doubt = f64::EPSILON * (8.0 + rate * t.abs()) * size;
            let wave = |parts: [f64; 2]| Piece { doubt, ..Piece::wave(parts, *rate, size) }.of(axes, radius);
            sums[0] = sums[0] + wave([there.re, there.im]);
            sums[1] = sums[1] + wave([there.im, -there.re]).scaled(-self.weights[impact] * rate);
        }
        [sums[0].shifted(-self.places[impact]), sums[1]]
    }

    /// W about these φ and ψ.
    fn filled(&self, (pair, open): &Strip, [phi, psi]: [f64; 2], radius: [f64; 2]) -> Table {
        let constant = |value: f64| Patch::constant(value, radius).doubted(8.0 * f64::EPSILON * value.abs());
        let mut table = [[Patch::constant(0.0, radius); MOST]; MOST];
        let last = self.table.columns - 1;
        for i in 0..2 {
            (table[i][i], table[2 + i][i]) = (constant(self.own[i][0]), constant(self.own[i][1]));
        }
        for ([place, law], [to, from]) in pair.iter().zip([[1, 0], [0, 1]]) {
            (table[to][from], table[2 + to][from]) = (place.along(0, radius), law.along(0, radius));
        }
        [table[0][last], table[2][last]] = self.loads(0, psi, [false, true], radius);
        [table[1][last], table[3][last]] = self.loads(1, phi + psi, [true; 2], radius);
        for (k, (shapes, push)) in self.rigid.iter().enumerate() {
            for (i, shape) in shapes.iter().enumerate() {
                (table[i][2 + k], table[4 + k][i]) = (constant(*shape), constant(*shape));
            }
            table[4 + k][last] = constant(*push);
        }
        let drifts = self.rigid.len();
        for (k, (own, strip)) in self.open.iter().zip(open).enumerate() {
            let (row, column) = (4 + drifts + 2 * k, 2 + drifts + 2 * k);
            let driven = at_phase(&strip.driven, psi, radius);
            for (of, whole) in driven.into_iter().enumerate() {
                let entry = &mut table[1 + 2 * of];
                entry[0] = entry[0] + strip.first[of].along(0, radius);
                entry[last] = entry[last] + whole;
            }
            let (less, first, left) = (own.one_less(), own.state(0, 0.0), own.left(0, 0.0));
            for side in 0..2 {
                for of in 0..2 {
                    table[2 * of][column + side] = first[side][of].fixed(radius);
                    table[1 + 2 * of][column + side] = strip.state[side][of].along(0, radius);
                }
                let entry = &mut table[row + side];
                (entry[0], entry[1]) = (-left[side].fixed(radius), -strip.left[side].along(0, radius));
                (entry[column], entry[column + 1]) = (constant(less[side][0]), constant(less[side][1]));
                for (w, state, error) in own.pushed() {
                    let there = state[side] * C::from_polar(1.0, w * psi);
                    let doubt = error + 8.0 * f64::EPSILON * w * psi.abs() * there.norm();
                    let wave = Piece { doubt, ..Piece::wave([there.re, there.im], w, there.norm()) };
                    entry[last] = entry[last] - wave.along(1, radius);
                }
            }
        }
        table
    }
}

/// The kernels between the impacts, and what depends on φ of the open modes.
type Strip = (Pair, Vec<OpenStrip>);

impl Planar for PhasePlane {
    type Strip = Strip;

    fn budget(&self) -> usize {
        self.budget
    }

    fn strip(&self, phi: f64, radius: f64) -> Strip {
        let open = self.open.iter().map(|own| own.strip(phi, radius)).collect();
        (self.between.pieces((phi, radius), self.weights, self.period), open)
    }

    fn enclose(&self, strip: &Strip, at: [f64; 2], radius: [f64; 2], form: usize) -> Option<([Patch; 2], bool)> {
        if form > 0 {
            return None;
        }
        let reduced = match self.table.reduced(&self.filled(strip, at, radius)) {
            Ok(reduced) => reduced,
            Err(pivot) => return Some(([pivot.unknown(); 2], false)),
        };
        let h = reduced.numbers[self.table.columns - 1].sign();
        let pulls = (0..2).any(|i| reduced.numbers[i].sign() * self.push[i] * h < 0.0);
        // At a single point, where Newton's method passes by, nothing is excluded.
        if pulls && radius != [0.0; 2] {
            return Some(([Patch::constant(1.0, radius); 2], true));
        }
        Some((reduced.left, true))
    }
}

/// The condition that is left of one impact once its place gives the impulse: K(1+e)G′ − (1/m + (1+e)K′)(G − stop), as a function of ψ. Where nothing
/// holds the structure the static load gives the impulse, and Newton's law is left.
struct OneImpact {
    swings: Swings,
    of_velocity: f64,
    of_place: f64,
    constant: f64,
}

impl OneImpact {
    fn enclose(&self, psi: f64, radius: f64) -> Dual {
        let mut sum = Dual::wave(0.0, 0.0, 0.0, 0.0, radius).shifted(self.constant);
        for (rate, swing) in &self.swings {
            // d/dψ of Re ĝe^{iωψ} is Re iωĝe^{iωψ}.
            let all = swing * C::new(self.of_place, self.of_velocity * rate) * C::from_polar(1.0, rate * psi);
            sum = sum + Dual::wave(all.re, all.im, *rate, all.norm(), radius);
        }
        sum
    }
}

impl Enclosed for OneImpact {
    fn clearances(&self, phases: Lane, radii: Lane) -> [Clearance; LANES] {
        one_by_one(phases, radii, |psi, radius| self.enclose(psi, radius))
    }

    fn at(&self, psi: f64) -> (f64, f64) {
        self.enclose(psi, 0.0).at_centre()
    }
}

impl Impacts<'_> {
    /// All orbits of one impact under loads of several harmonics; `None` where that takes too long.
    pub(super) fn proved_of_one(&self) -> Option<Starts> {
        let equations = self.equations;
        let (contact, _) = *self.letters.first()?;
        let place = *self.places()?.first()?;
        let ([of_place, of_law], weight) = (equations.own(contact), 1.0 + equations.restitution(contact));
        let (repeat, swings) = (equations.model.loads_repeat(), equations.swings(contact).collect::<Swings>());
        let fastest = swings.iter().map(|(rate, _)| *rate).fold(0.0, f64::max);
        let drift = equations.rigid.first();
        let balance = drift.map(|drift| -drift.push * equations.period() / drift.shapes[contact]);
        if balance == Some(0.0) {
            // All that could balance the impulse is the static load.
            return Some(Ok((Vec::new(), Searched::default())));
        }
        // Places and velocities on one footing.
        let size = (fastest * of_place).hypot(of_law);
        let condition = match balance {
            Some(impulse) => {
                let size = weight.hypot(of_law);
                OneImpact { swings, of_velocity: weight / size, of_place: 0.0, constant: of_law * impulse / size }
            }
            None => OneImpact {
                swings,
                of_velocity: of_place * weight / size,
                of_place: -of_law / size,
                constant: of_law * place / size,
            },
        };
        let mut zeros = Zeros::default();
        zeros.stop = equations.model.stop().clone();
        let start = START * repeat;
        let pieces = LEAST_PIECES + (repeat * fastest) as usize;
        zeros.find(&condition, start, start + repeat, pieces, |_| 64.0 * f64::EPSILON * repeat);
        if let [first, .., last] = zeros.simple[..]
            && last - first >= repeat * (1.0 - SEAM)
        {
            zeros.simple.pop();
        }
        if zeros.exhausted > 0 {
            return None;
        }
        let numbers = |psi: f64| -> SmallVec<[f64; 2]> {
            let [load, speed, ..] = equations.load(contact, psi);
            if let (Some(drift), Some(impulse)) = (drift, balance) {
                return smallvec![impulse, (place - load - of_place * impulse) / drift.shapes[contact]];
            }
            let (a, b) = (fastest * of_place / size, of_law / size);
            smallvec![(a * fastest * (place - load) - b * weight * speed) / size]
        };
        let start = |(psi, is_zero): (f64, bool)| Start::new(self.at_phase(&[0.0], &numbers(psi), psi), is_zero);
        let starts = all_places(&zeros.simple, &zeros.unresolved).map(start).collect();
        let (intervals, unresolved) = (zeros.intervals, zeros.unresolved.len());
        Some(Ok((starts, Searched { intervals, unresolved, ..Searched::default() })))
    }

    /// All orbits of two impacts under any loads, or of those only that push; `None` where they cannot be enclosed, or that takes too long.
    pub(super) fn proved_in_the_phase_plane(&self, scope: Scope) -> Option<Starts> {
        let functions = PhasePlane::new(self, scope.candidates(), boxes(scope))?;
        let zeros = functions.zeros();
        if zeros.exhausted > 0 {
            return None;
        }
        let (mut starts, mut unresolved): (Vec<Start>, usize) = (Vec::new(), zeros.unresolved.len());
        for (at, is_zero) in all_places(&zeros.simple, &zeros.unresolved) {
            match functions.numbers(at) {
                Some(numbers) => starts.push(Start::new(self.at_phase(&[0.0, at[0]], &numbers, at[1]), is_zero)),
                None => unresolved += usize::from(is_zero),
            }
        }
        Some(Ok((starts, Searched { boxes: zeros.boxes, unresolved, ..Searched::default() })))
    }

    /// The point of impulses and offsets at given times and phase.
    fn at_phase(&self, times: &[f64], numbers: &[f64], psi: f64) -> Point {
        let strikes = self
            .letters
            .iter()
            .zip(times)
            .zip(numbers)
            .map(|((&(contact, barrier), &time), &impulse)| Strike { contact, barrier, time, impulse });
        let offsets = numbers[times.len()..].iter().copied().collect();
        Point { strikes: strikes.collect(), psi, period: self.equations.period(), offsets }
    }
}

#[cfg(test)]
mod tests;
