//! All orbits of three impacts, with proof: two functions of the times between them, enclosed on rectangles ([`planar`](crate::roots::planar)).
//!
//! With the impacts at 0, x and x + y, places and Newton's laws are W X = 0 for X = (P₁, P₂, P₃, c, s, h): h stands for 1, and multiplies the
//! stops less what is still. An orbit is where W is singular and its null vector has c² + s² = h². Where all stops are at the rest position there
//! is no h, and without a load neither c nor s nor the law that follows from the others: then two rows are left over.
//!
//! On each rectangle W is multiplied by what makes it the unit matrix at the middle but for one column, the number of X that is largest there; what
//! is left is eliminated in enclosures. So no determinant that vanishes somewhere divides anything, unless W loses two ranks: at single places of
//! structures with symmetries ([`ThreeImpacts::double`]), and all over where the conditions are singular.

use vibrochain_lattice::simd::lanes::LANES;
use vibrochain_lattice::{Complex, Stop};

use super::at_times::Impacts;
use super::two_impacts::{RESOLUTION, told_apart};
use crate::roots::patch::{Patch, Piece};
use crate::roots::planar::{Planar, PlanarZeros};
use crate::structures::between::Between;

type C = Complex<f64>;

/// Rows, and columns, at most.
const MOST: usize = 6;

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
    /// 1/m of each contact: the size of Newton's laws. Without a load both kernels in one of them may vanish at once.
    mobilities: [f64; 3],
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
    rows: usize,
    columns: usize,
    budget: usize,
    stop: Stop,
}

/// Of a pair of impacts: K and (1+e)K′ at the later one, and at the earlier one.
type Pair = [[Piece; 2]; 2];

/// The load at an impact, Re and Im of ĝe^{iωt}.
type Load = [Piece; 2];

/// W, or what is left of it.
type Table = [[Patch; MOST]; MOST];

/// A null vector, and what is left over.
struct Reduced {
    numbers: [Patch; MOST],
    left: [Patch; 2],
}

impl ThreeImpacts {
    /// `None` of rigid modes, of modes that grow, of several harmonics, and where nothing has a size.
    pub(super) fn new(impacts: &Impacts<'_>, budget: usize) -> Option<Self> {
        let equations = impacts.equations;
        let letters: [_; 3] = impacts.letters.as_slice().try_into().ok()?;
        let contacts = letters.map(|(contact, _)| contact);
        let load = equations.single();
        if load.is_none() && equations.forced {
            return None;
        }
        let places = impacts.places()?;
        let homogeneous = places.iter().all(|place| *place == 0.0);
        if homogeneous && load.is_none() {
            return None;
        }
        let between = |[i, j]: [usize; 2]| Between::new(equations.kernel(), contacts[i], contacts[j]);
        let period = equations.period();
        let mut functions = Self {
            period,
            between: [between(PAIRS[0])?, between(PAIRS[1])?, between(PAIRS[2])?],
            rate: load.map_or(0.0, |(rate, _)| rate),
            swings: contacts.map(|contact| load.map_or_else(C::default, |(_, swing)| swing[contact])),
            weights: contacts.map(|contact| 1.0 + equations.restitution(contact)),
            own: contacts.map(|contact| equations.own(contact)),
            mobilities: contacts.map(|contact| equations.mobility(contact)),
            places: [places[0], places[1], places[2]],
            push: letters.map(|(_, barrier)| -barrier.sign()),
            least: [[0, 1], [1, 2], [2, 0]].map(|[i, j]| {
                let of_one_contact = contacts[i] == contacts[j];
                period * if of_one_contact || load.is_some() { told_apart(of_one_contact) } else { -BEYOND }
            }),
            alike: letters.iter().all(|letter| *letter == letters[0]),
            rows: 5 + usize::from(load.is_some()),
            columns: 3 + 2 * usize::from(load.is_some()) + usize::from(!homogeneous),
            double: false,
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
        let fastest = self.between.iter().map(|pair| pair.fastest).fold(self.rate, f64::max);
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
        let table = self.table(&self.pair(0, x, 0.0), &self.load(1, x), [x, y], [0.0; 2]);
        let Reduced { numbers, .. } = self.reduced(table).ok()?;
        let numbers = numbers.map(|number| number.value());
        let [c, s] = [3, 4].map(|place| if self.rate > 0.0 { numbers[place] } else { 0.0 });
        let size = if self.has_h() {
            numbers[self.columns - 1]
        } else {
            // Either direction of (c, s): impulses tell.
            let pushed: f64 = numbers.iter().zip(&self.push).map(|(number, push)| number * push).sum();
            c.hypot(s).copysign(pushed)
        };
        let numbers: Vec<f64> = numbers[..self.columns - usize::from(self.has_h())].iter().map(|x| x / size).collect();
        numbers.iter().all(|x| x.is_finite()).then_some(numbers)
    }

    fn is_double(&self) -> bool {
        let third = self.period / 3.0;
        let table = self.table(&self.pair(0, third, 0.0), &self.load(1, third), [third; 2], [0.0; 2]);
        self.prepared(&table).last < DOUBLE
    }

    /// Whether a rectangle is where impacts that a symmetry makes alike cannot be told from others.
    fn is_alike(&self, at: [f64; 2], radius: [f64; 2]) -> bool {
        let third = self.period / 3.0;
        self.double && (0..2).all(|i| (at[i] - third).abs() + radius[i] < ALIKE * self.period)
    }

    /// Whether an impulse surely pulls and another one pushes.
    fn pulls(&self, reduced: &Reduced) -> bool {
        let signs = [0, 1, 2].map(|i| reduced.numbers[i].sign() * self.push[i]);
        let h = if self.has_h() { reduced.numbers[self.columns - 1].sign() } else { 0.0 };
        let signs = [signs[0], signs[1], signs[2], h];
        signs.contains(&1.0) && signs.contains(&-1.0)
    }

    /// Whether, without a load, the first law is broken, which follows from the others unless its impulse is 0. As ΣP_i g′_i = 0 whatever the
    /// impulses, it is what the first one does in the two `laws` that are kept, times the impulses of these.
    fn breaks_a_law(&self, laws: &[Patch; 2], reduced: &Reduced) -> bool {
        self.rate == 0.0 && (laws[0] * reduced.numbers[1] + laws[1] * reduced.numbers[2]).excludes_zero()
    }

    fn has_h(&self) -> bool {
        self.columns.is_multiple_of(2)
    }

    /// The kernels of a pair of impacts that are so far apart. Beyond the period they go on as parabolas do: what is found there is none.
    fn pair(&self, pair: usize, apart: f64, radius: f64) -> Pair {
        let place = apart.min(self.period - if pair == 2 { self.least[2] } else { 0.0 });
        let (beyond, reach) = (apart - place, (radius - (apart - place)).max(0.0));
        let (jets, fourths) = self.between[pair].jets([place; LANES], [reach; LANES]);
        [0, 1].map(|way| {
            let [value, slope, bend, third] = jets[way].map(|lanes| lanes.to_array()[0]);
            let [of_value, of_slope, _] = self.between[pair].doubts[way];
            let fourth = fourths[way].to_array()[0];
            let third_bound = third.abs() + reach * fourth;
            // Back, the slope in time is the opposite of that in the time apart.
            let by = self.weights[PAIRS[pair][1 - way]] * [1.0, -1.0][way];
            let moved = |[value, slope, bend]: [f64; 3]| {
                [value + beyond * (slope + 0.5 * beyond * bend), slope + beyond * bend, bend]
            };
            let (place, law) = (moved([value, slope, bend]), moved([slope, bend, third]).map(|x| by * x));
            [
                Piece { jet: place, third: third_bound, doubt: of_value },
                Piece { jet: law, third: by.abs() * fourth, doubt: by.abs() * of_slope },
            ]
        })
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
    fn table(&self, first: &Pair, load: &Load, [x, y]: [f64; 2], radius: [f64; 2]) -> Table {
        let (both, width) = (x + y, radius[0] + radius[1]);
        let patch = |axis: usize, piece: Piece| match axis {
            2 => piece.of([true; 2], radius),
            _ => piece.along(axis, radius),
        };
        let constant = |value: f64| Patch::constant(value, radius).doubted(8.0 * f64::EPSILON * value.abs());
        let mut table = [[Patch::constant(0.0, radius); MOST]; MOST];
        let laws = self.rows - 3;
        for i in 0..3 {
            table[i][i] = constant(self.own[i][0]);
            if self.has_h() {
                table[i][self.columns - 1] = constant(-self.places[i]);
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
        table
    }

    /// What makes W nearly the unit matrix.
    fn prepared(&self, table: &Table) -> Prepared {
        let (rows, columns) = (self.rows, self.columns);
        let mut values = [[0.0; 2 * MOST]; MOST];
        for i in 0..rows {
            let least = if i < 3 { f64::MIN_POSITIVE } else { self.mobilities[i + 3 - rows] };
            let largest = table[i][..columns].iter().map(|x| x.value().abs()).fold(least, f64::max);
            for j in 0..columns {
                values[i][j] = table[i][j].value() / largest;
            }
            values[i][columns + i] = largest.recip();
        }
        let mut sizes = [1.0; MOST];
        for j in 0..columns {
            let largest = values.iter().map(|row| row[j].abs()).fold(f64::MIN_POSITIVE, f64::max);
            sizes[j] = largest.recip();
            values.iter_mut().for_each(|row| row[j] /= largest);
        }
        let mut order = std::array::from_fn(|j| j);
        let mut last = 1.0;
        for k in 0..columns - 1 {
            let places = (k..rows).flat_map(|i| (k..columns).map(move |j| (i, j)));
            let size = |(i, j): (usize, usize)| values[i][j].abs();
            let Some((row, column)) = places.max_by(|a, b| size(*a).total_cmp(&size(*b))) else { break };
            values.swap(k, row);
            order.swap(k, column);
            values.iter_mut().for_each(|row| row.swap(k, column));
            last = values[k][k].abs();
            let pivot = if last < f64::EPSILON { f64::EPSILON } else { values[k][k] };
            values[k].iter_mut().for_each(|x| *x /= pivot);
            let own = values[k];
            for (i, row) in values.iter_mut().enumerate().take(rows) {
                let by = row[k];
                if i != k && by != 0.0 {
                    row.iter_mut().zip(&own).for_each(|(x, own)| *x -= by * own);
                }
            }
        }
        let factors = values.map(|row| std::array::from_fn(|i| row[(columns + i).min(2 * MOST - 1)]));
        Prepared { factors, order, sizes, last }
    }

    /// The null vector of W and what is left over; the pivot that may vanish, where that is not known.
    fn reduced(&self, table: Table) -> Result<Reduced, Patch> {
        let (rows, unknowns) = (self.rows, self.columns - 1);
        let Prepared { factors, order, sizes, .. } = self.prepared(&table);
        let mut left = table;
        for i in 0..rows {
            for (j, &column) in order.iter().enumerate().take(self.columns) {
                let terms = (0..rows).map(|l| table[l][column].scaled(factors[i][l] * sizes[column]));
                left[i][j] = terms.reduce(|a, b| a + b).unwrap_or(left[i][j]);
            }
        }
        let mut inverses = [left[0][0]; MOST];
        for k in 0..unknowns {
            inverses[k] = left[k][k].reciprocal().ok_or(left[k][k])?;
            for i in k + 1..rows {
                let by = left[i][k] * inverses[k];
                for j in k + 1..=unknowns {
                    left[i][j] = left[i][j] - by * left[k][j];
                }
            }
        }
        let mut found = [Patch::constant(1.0, inverses[0].radius()); MOST];
        for k in (0..unknowns).rev() {
            let sum = (k + 1..unknowns).fold(left[k][unknowns], |sum, j| sum + left[k][j] * found[j]);
            found[k] = -(sum * inverses[k]);
        }
        let mut numbers = found;
        for (number, &column) in found.iter().zip(&order).take(self.columns) {
            numbers[column] = number.scaled(sizes[column]);
        }
        let last = if rows > self.columns {
            left[rows - 1][unknowns]
        } else {
            let [c, s, h] = [numbers[3], numbers[4], numbers[5]];
            c * c + s * s - h * h
        };
        Ok(Reduced { numbers, left: [left[unknowns][unknowns], last] })
    }
}

/// W's rows are multiplied by `factors`, its columns by `sizes`, and these come in another order.
struct Prepared {
    factors: [[f64; MOST]; MOST],
    order: [usize; MOST],
    sizes: [f64; MOST],
    /// The size of the last pivot.
    last: f64,
}

impl Planar for ThreeImpacts {
    fn budget(&self) -> usize {
        self.budget
    }

    type Strip = (Pair, Load);

    fn strip(&self, x: f64, radius: f64) -> Self::Strip {
        (self.pair(0, x, radius), self.load(1, x))
    }

    fn enclose(
        &self,
        (first, load): &Self::Strip,
        [x, y]: [f64; 2],
        radius: [f64; 2],
        form: usize,
    ) -> Option<([Patch; 2], bool)> {
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
        let table = self.table(first, load, [x, y], radius);
        let laws = [table[3][0], table[4][0]];
        let reduced = match self.reduced(table) {
            Ok(reduced) => reduced,
            Err(pivot) => return Some(([pivot.unknown(); 2], false)),
        };
        if excludes && (self.pulls(&reduced) || self.breaks_a_law(&laws, &reduced)) {
            return none;
        }
        Some((reduced.left, true))
    }
}

#[cfg(test)]
mod tests;
