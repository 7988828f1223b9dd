//! All orbits of three impacts, with proof: two functions of the times between them, enclosed on rectangles ([`planar`](crate::roots::planar)).
//!
//! With the impacts at 0, x and x + y, places and Newton's laws are W X = 0 for X = (P₁, P₂, P₃, c, s, h): h stands for 1, and multiplies the
//! stops less what is still. An orbit is where W is singular and its null vector has c² + s² = h². Where all stops are at the rest position there
//! is no h, and without a load neither c nor s nor the law that follows from the others: then two rows are left over.
//!
//! On each rectangle W is eliminated in enclosures (`elimination`), unless it loses two ranks: at single places of structures with symmetries
//! ([`ThreeImpacts::double`]), and all over where the conditions are singular.

use vibrochain_lattice::{Complex, Stop};

use super::at_times::Impacts;
use super::elimination::{Elimination, MOST, Reduced, Table};
use super::open_pieces::{OpenRows, OpenStrip};
use super::two_impacts::{RESOLUTION, told_apart};
use crate::roots::patch::{Patch, Piece};
use crate::roots::planar::{Planar, PlanarZeros};
use crate::structures::between::{Between, Pair};

type C = Complex<f64>;

/// Pairs of impacts, the earlier one first: x, y and x + y apart.
const PAIRS: [[usize; 2]; 3] = [[0, 1], [1, 2], [0, 2]];

/// Rectangles to begin with, each way.
const PIECES: [usize; 2] = [6, 48];

/// Of the period, next to a third of it: see [`ThreeImpacts::double`].
const ALIKE: f64 = 1e-6;

/// Without loads and losses two contacts may be hit at one instant: such a zero, which is no orbit of three instants, is on the border of the
/// times, where it would not be told from one inside. So these go on beyond it, by this part of the period.
const BEYOND: f64 = 1e-6;

/// A pivot below this part of the largest number is 0 but for rounding.
const DOUBLE: f64 = 1e-10;

/// The two functions.
pub(super) struct ThreeImpacts {
    period: f64,
    between: [Between; 3],
    /// ω, or 0 without a load, and ĝ of the contacts.
    rate: f64,
    swings: [C; 3],
    /// 1+e
    weights: [f64; 3],
    /// Of each contact with itself, a period later: K, and 1/m + (1+e)K′.
    own: [[f64; 2]; 3],
    /// Stops less what is still.
    places: [f64; 3],
    /// Which way impulses push.
    push: [f64; 3],
    /// From where on each pair of neighbours is told apart.
    least: [f64; 3],
    /// All of one barrier: of three orders in time the one whose first two impacts are closest does.
    alike: bool,
    /// A symmetry makes the impacts alike a third of the period apart: W has lost two ranks there.
    pub(super) double: bool,
    /// The modes whose states are unknowns, under a load.
    open: Vec<OpenRows>,
    /// Newton's laws are as large as 1/m at least: without a load both kernels in one of them may vanish at once.
    table: Elimination,
    budget: usize,
    stop: Stop,
}

/// The load at an impact, Re and Im of ĝe^{iωt}.
type Load = [Piece; 2];

impl ThreeImpacts {
    /// `None` of rigid modes, of modes that grow, of several harmonics, and where nothing has a size.
    pub(super) fn new(impacts: &Impacts<'_>, budget: usize) -> Option<Self> {
        let equations = impacts.equations;
        let letters: [_; 3] = impacts.letters.as_slice().try_into().ok()?;
        let contacts = letters.map(|(contact, _)| contact);
        let load = equations.single();
        if load.is_none() && equations.forced || equations.kernel().has_rigid() {
            return None;
        }
        let places = impacts.places()?;
        let homogeneous = places.iter().all(|place| *place == 0.0);
        if homogeneous && load.is_none() {
            return None;
        }
        let between = |[i, j]: [usize; 2]| Between::new(equations.kernel(), contacts[i], contacts[j]);
        let period = equations.period();
        let open = OpenRows::of(equations, &contacts);
        let laws = 5 + usize::from(load.is_some());
        let rows = laws + 2 * open.len();
        let columns = 3 + 2 * usize::from(load.is_some()) + 2 * open.len() + usize::from(!homogeneous);
        if rows > MOST {
            return None;
        }
        let mut least = [f64::MIN_POSITIVE; MOST];
        (3..laws).for_each(|row| least[row] = equations.mobility(contacts[row + 3 - laws]));
        (laws..rows).for_each(|row| least[row] = open[(row - laws) / 2].given());
        let mut functions = Self {
            period,
            between: [between(PAIRS[0])?, between(PAIRS[1])?, between(PAIRS[2])?],
            rate: load.map_or(0.0, |(rate, _)| rate),
            swings: contacts.map(|contact| load.map_or_else(C::default, |(_, swing)| swing[contact])),
            weights: contacts.map(|contact| 1.0 + equations.restitution(contact)),
            own: contacts.map(|contact| equations.own(contact)),
            places: [places[0], places[1], places[2]],
            push: letters.map(|(_, barrier)| -barrier.sign()),
            least: [[0, 1], [1, 2], [2, 0]].map(|[i, j]| {
                let of_one_contact = contacts[i] == contacts[j];
                period * if of_one_contact || load.is_some() { told_apart(of_one_contact) } else { -BEYOND }
            }),
            alike: letters.iter().all(|letter| *letter == letters[0]),
            table: Elimination { rows, columns, least },
            double: false,
            open,
            budget,
            stop: equations.model.stop().clone(),
        };
        functions.double = load.is_some() && functions.is_double();
        Some(functions)
    }

    /// All zeros whose impacts do not surely pull.
    pub(super) fn zeros(&self) -> PlanarZeros {
        let mut zeros = PlanarZeros { stop: self.stop.clone(), ..PlanarZeros::default() };
        let [first, second, third] = self.least;
        let shortest = if self.alike { self.period / 3.0 } else { self.period - second - third };
        let fastest = self.between.iter().map(|pair| pair.fastest);
        let fastest = fastest.chain(self.open.iter().map(|rows| rows.fastest()[0])).fold(self.rate, f64::max);
        let pieces = (0.25 * fastest * self.period) as usize;
        let pieces = [shortest / self.period, 1.0].map(|part| (part * pieces as f64) as usize);
        let [x, y] = [[first, shortest], [second, self.period - first - third]];
        zeros.find(self, x, y, pieces.map(|count| count.clamp(PIECES[0], PIECES[1])), RESOLUTION * self.period);
        let inside = |[x, y]: &[f64; 2], least: f64| {
            let rest = self.period - x - y;
            rest >= third && [*x, *y, rest].iter().all(|apart| *apart >= least * self.period)
        };
        zeros.simple.retain(|at| inside(at, RESOLUTION));
        zeros.unresolved.retain(|at| inside(at, -0.5 * BEYOND));
        zeros
    }

    /// Impulses and, of a load, c and s, for the times of a zero. `None` where they are not determined.
    pub(super) fn numbers(&self, [x, y]: [f64; 2]) -> Option<Vec<f64>> {
        let table = self.filled(&self.strip(x, 0.0), [x, y], [0.0; 2]);
        let Reduced { numbers, .. } = self.table.reduced(&table).ok()?;
        let numbers = numbers.map(|number| number.value());
        let [c, s] = [3, 4].map(|place| if self.rate > 0.0 { numbers[place] } else { 0.0 });
        let size = if self.has_h() {
            numbers[self.table.columns - 1]
        } else {
            // Either direction of (c, s): impulses tell.
            let pushed: f64 = numbers.iter().zip(&self.push).map(|(number, push)| number * push).sum();
            c.hypot(s).copysign(pushed)
        };
        let numbers: Vec<f64> =
            numbers[..self.table.columns - usize::from(self.has_h())].iter().map(|x| x / size).collect();
        numbers.iter().all(|x| x.is_finite()).then_some(numbers)
    }

    fn is_double(&self) -> bool {
        let third = self.period / 3.0;
        let table = self.filled(&self.strip(third, 0.0), [third; 2], [0.0; 2]);
        self.table.last_pivot(&table) < DOUBLE
    }

    /// Whether a rectangle is where impacts that a symmetry makes alike cannot be told from others.
    fn is_alike(&self, at: [f64; 2], radius: [f64; 2]) -> bool {
        let third = self.period / 3.0;
        self.double && (0..2).all(|i| (at[i] - third).abs() + radius[i] < ALIKE * self.period)
    }

    /// Whether an impulse surely pulls and another one pushes.
    fn pulls(&self, reduced: &Reduced) -> bool {
        let signs = [0, 1, 2].map(|i| reduced.numbers[i].sign() * self.push[i]);
        let h = if self.has_h() { reduced.numbers[self.table.columns - 1].sign() } else { 0.0 };
        let signs = [signs[0], signs[1], signs[2], h];
        signs.contains(&1.0) && signs.contains(&-1.0)
    }

    /// Whether, without a load, the first law is broken, which follows from the others unless its impulse is 0. As ΣP_i g′_i = 0 whatever the
    /// impulses, it is what the first one does in the two `laws` that are kept, times the impulses of these.
    fn breaks_a_law(&self, laws: &[Patch; 2], reduced: &Reduced) -> bool {
        self.rate == 0.0 && (laws[0] * reduced.numbers[1] + laws[1] * reduced.numbers[2]).excludes_zero()
    }

    fn has_h(&self) -> bool {
        self.table.columns.is_multiple_of(2)
    }

    /// The kernels of a pair of impacts that are so far apart.
    fn pair(&self, pair: usize, apart: f64, radius: f64) -> Pair {
        let [first, second] = PAIRS[pair].map(|impact| self.weights[impact]);
        let longest = self.period - if pair == 2 { self.least[2] } else { 0.0 };
        self.between[pair].pieces((apart, radius), [first, second], longest)
    }

    /// The load at an impact, at time t.
    fn load(&self, impact: usize, t: f64) -> Load {
        let (swing, rate) = (self.swings[impact], self.rate);
        let there = swing * C::from_polar(1.0, rate * t);
        let doubt = f64::EPSILON * (8.0 + rate * t) * swing.norm();
        [[there.re, there.im], [there.im, -there.re]]
            .map(|parts| Piece { doubt, ..Piece::wave(parts, rate, swing.norm()) })
    }

    /// W about these times.
    fn filled(&self, (first, load, open): &Strip, [x, y]: [f64; 2], radius: [f64; 2]) -> Table {
        let (both, width) = (x + y, radius[0] + radius[1]);
        let patch = |axis: usize, piece: Piece| match axis {
            2 => piece.of([true; 2], radius),
            _ => piece.along(axis, radius),
        };
        let constant = |value: f64| Patch::constant(value, radius).doubted(8.0 * f64::EPSILON * value.abs());
        let mut table = [[Patch::constant(0.0, radius); MOST]; MOST];
        let laws = self.table.rows - 3 - 2 * self.open.len();
        for i in 0..3 {
            table[i][i] = constant(self.own[i][0]);
            if self.has_h() {
                table[i][self.table.columns - 1] = constant(-self.places[i]);
            }
            // Without a load the first law follows from the others.
            if laws + i >= 3 {
                table[laws + i][i] = constant(self.own[i][1]);
            }
        }
        let pairs = [*first, self.pair(1, y, radius[1]), self.pair(2, both, width)];
        for (axis, pair) in pairs.iter().enumerate() {
            let [i, j] = PAIRS[axis];
            for ([place, law], [to, from]) in pair.iter().zip([[j, i], [i, j]]) {
                table[to][from] = patch(axis, *place);
                if laws + to >= 3 {
                    table[laws + to][from] = patch(axis, *law);
                }
            }
        }
        if self.rate > 0.0 {
            let loads = [self.load(0, 0.0), *load, self.load(2, both)];
            for (i, load) in loads.iter().enumerate() {
                let [re, im] = load.map(|piece| match i {
                    0 => constant(piece.jet[0]),
                    1 => patch(0, piece),
                    _ => patch(2, piece),
                });
                let fast = -self.weights[i] * self.rate;
                (table[i][3], table[i][4]) = (re, -im);
                (table[3 + i][3], table[3 + i][4]) = (im.scaled(fast), re.scaled(fast));
            }
        }
        for (k, (own, strip)) in self.open.iter().zip(open).enumerate() {
            self.fill_open(&mut table, k, (own, strip), y, (both, width), &|i, piece| match i {
                0 => piece.fixed(radius),
                i => patch([0, 0, 2, 1][i], piece),
            });
        }
        table
    }

    /// Adds to W, under a load, a mode whose state is unknown. `at` makes a function of the time of an impact; number 3 is the time between the last two.
    fn fill_open(
        &self,
        table: &mut Table,
        k: usize,
        (own, strip): (&OpenRows, &OpenStrip),
        y: f64,
        (both, width): (f64, f64),
        at: &dyn Fn(usize, Piece) -> Patch,
    ) {
        let (row, column) = (6 + 2 * k, 5 + 2 * k);
        let still = |value: f64| at(0, Piece { jet: [value, 0.0, 0.0], third: 0.0, doubt: 0.0 });
        let states = [own.state(0, 0.0), strip.state, own.state(2, both)];
        let left = [own.left(0, 0.0), strip.left, own.left(2, both)];
        let less = own.one_less();
        for i in 0..3 {
            for side in 0..2 {
                table[i][column + side] = at(i, states[i][side][0]);
                table[3 + i][column + side] = at(i, states[i][side][1]);
                table[row + side][i] = -at(i, left[i][side]);
            }
        }
        for side in 0..2 {
            (0..2).for_each(|other| table[row + side][column + other] = still(less[side][other]));
            for (_, state, error) in own.pushed() {
                let part = |value: f64| at(0, Piece { jet: [value, 0.0, 0.0], third: 0.0, doubt: error });
                table[row + side][3] = table[row + side][3] - part(state[side].re);
                table[row + side][4] = table[row + side][4] + part(state[side].im);
            }
        }
        let passed =
            [([1, 0], 1, strip.first), ([2, 1], 3, own.passed([2, 1], y)), ([2, 0], 2, own.passed([2, 0], both))];
        for ([to, from], time, seen) in passed {
            for (row, piece) in [to, 3 + to].into_iter().zip(seen) {
                table[row][from] = table[row][from] + at(time, piece);
            }
        }
        for (i, driven) in [(1, &strip.driven), (2, &own.driven(2, both, width))] {
            for (_, parts) in driven {
                for (row, [re, im]) in [i, 3 + i].into_iter().zip(*parts) {
                    table[row][3] = table[row][3] + at(i, re);
                    table[row][4] = table[row][4] - at(i, im);
                }
            }
        }
    }
}

/// The kernels of the first two impacts, the load at the second one, and what depends on its time of open modes.
type Strip = (Pair, Load, Vec<OpenStrip>);

impl Planar for ThreeImpacts {
    fn budget(&self) -> usize {
        self.budget
    }

    type Strip = Strip;

    fn strip(&self, x: f64, radius: f64) -> Self::Strip {
        let open = self.open.iter().map(|own| own.strip(x, radius)).collect();
        (self.pair(0, x, radius), self.load(1, x), open)
    }

    fn enclose(&self, strip: &Strip, [x, y]: [f64; 2], radius: [f64; 2], form: usize) -> Option<([Patch; 2], bool)> {
        if form > 0 {
            return None;
        }
        let none = Some(([Patch::constant(1.0, radius); 2], true));
        let rest = self.period - x - y + radius[0] + radius[1];
        let is_turned = self.alike && x - radius[0] > (y + radius[1]).min(rest);
        // At a single point, where Newton's method passes by, nothing is excluded: zeros may be on a border of what is.
        let excludes = radius != [0.0; 2];
        if excludes && (rest < self.least[2] || is_turned || self.is_alike([x, y], radius)) {
            return none;
        }
        let table = self.filled(strip, [x, y], radius);
        let laws = [table[3][0], table[4][0]];
        let mut reduced = match self.table.reduced(&table) {
            Ok(reduced) => reduced,
            Err(pivot) => return Some(([pivot.unknown(); 2], false)),
        };
        if excludes && (self.pulls(&reduced) || self.breaks_a_law(&laws, &reduced)) {
            return none;
        }
        if self.table.rows == self.table.columns {
            let [c, s, h] = [3, 4, self.table.columns - 1].map(|place| reduced.numbers[place]);
            reduced.left[1] = c * c + s * s - h * h;
        }
        Some((reduced.left, true))
    }
}

#[cfg(test)]
mod tests;
