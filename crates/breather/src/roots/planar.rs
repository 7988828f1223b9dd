//! All zeros of two smooth functions of two variables on a rectangle, each one proved to exist and to be alone, or
//! reported as unresolved: `roots` in two dimensions.
//!
//! On a rectangle about c with radii r let v and A be values and slopes, e the excess of the enclosures and E the radii of
//! the slopes (`patch`), everything in units of r. Preconditioned by A⁻¹,
//!
//! ```text
//! a zero lies within −A⁻¹v ± |A⁻¹|e       outside [−1, 1]²: there is none
//!                                         inside: there is one (Brouwer)
//! |A⁻¹|E < 1 (rows summed)                the map is one-to-one: there is at most one
//! ```
//!
//! Where neither is decided the rectangle shrinks to that enclosure or is halved across its more curved direction. What
//! rounding blurs before it is decided is a double zero, or two closer than can be told apart: unresolved.

use vibrochain_lattice::Stop;

use crate::roots::patch::Patch;

/// Two functions with enclosures, which may be written down in several ways.
pub(crate) trait Planar {
    /// What depends on x alone on an interval; kept while a rectangle is cut across y.
    type Strip: Clone;

    /// Enclosures after which what is left is not looked at: more than any sound problem needs.
    fn budget(&self) -> usize {
        400_000
    }

    /// The parts that depend on x alone, on an interval with this centre and radius.
    fn strip(&self, centre: f64, radius: f64) -> Self::Strip;

    /// Encloses form number `form` of the functions on a rectangle, and tells whether its zeros there are exactly the
    /// solutions (it may have others elsewhere, but must have all). `None` beyond the last form.
    fn enclose(
        &self,
        strip: &Self::Strip,
        centre: [f64; 2],
        radius: [f64; 2],
        form: usize,
    ) -> Option<([Patch; 2], bool)>;
}

/// A rectangle by its edges, which neighbours share.
#[derive(Debug, Clone, Copy)]
struct Rectangle {
    low: [f64; 2],
    high: [f64; 2],
}

impl Rectangle {
    fn centre(&self) -> [f64; 2] {
        std::array::from_fn(|i| 0.5 * (self.low[i] + self.high[i]))
    }

    fn radius(&self) -> [f64; 2] {
        let centre = self.centre();
        std::array::from_fn(|i| (self.high[i] - centre[i]).max(centre[i] - self.low[i]))
    }
}

/// The zeros found.
#[derive(Debug, Clone, Default)]
pub(crate) struct PlanarZeros {
    /// Simple zeros.
    pub(crate) simple: Vec<[f64; 2]>,
    /// One point of each cluster of rectangles that rounding blurs.
    pub(crate) unresolved: Vec<[f64; 2]>,
    /// Rectangles not looked at because the budget was spent, or the search stopped.
    pub(crate) exhausted: usize,
    /// Rectangles examined.
    pub(crate) boxes: usize,
    /// Enclosures spent.
    pub(crate) evaluations: usize,
    /// Once raised, what is left is not looked at.
    pub(crate) stop: Stop,
}

/// Rectangles that rounding blurs, up to which they are joined to places.
const MOST_BLURRED: usize = 2048;

/// Rectangles are not halved below this, relative to their place (to the whole, in y).
const NARROW: f64 = 64.0 * f64::EPSILON;

/// A direction this much narrower than the other one waits for it: further down, where a zero at 0 has no rounding to stop at, the rectangle
/// would be no wider than what rounding blurs once the other direction is done.
const WAITS: f64 = 1e-6;

/// An unresolved rectangle this close to another one, in their sizes, is of the same cluster.
const CLUSTER: f64 = 16.0;

/// So is one this close in parts of the whole range. Two zeros that merge are the square root of their distance from that event
/// apart: where rounding blurs each of them alone, 1e-8 to 1e-6, they are still one place.
const PAIR: f64 = 1e-6;

/// What one form of the functions says of a rectangle.
enum Verdict {
    Empty,
    Linear(Linear),
    /// A cannot be inverted.
    Singular,
}

/// The linearised functions, in units of the radii.
#[derive(Debug, Clone, Copy)]
struct Linear {
    form: usize,
    /// −A⁻¹v
    middle: [f64; 2],
    /// |A⁻¹|e
    reach: [f64; 2],
    /// The part of `reach` that is rounding.
    blur: [f64; 2],
    /// There is at most one zero.
    alone: bool,
}

impl Linear {
    fn worst(&self) -> f64 {
        self.reach[0].max(self.reach[1])
    }
}

/// Widths of rounding that a rectangle must have to tell its zero from another's.
const SHARP: f64 = 64.0;

/// The search's constants.
struct Search<'a, P: Planar> {
    problem: &'a P,
    /// Narrowest radius of x that is looked at, and size of y's range.
    finest: f64,
    extent: f64,
}

impl PlanarZeros {
    /// Finds the zeros on `x` × `y`, cut into `pieces` to begin with. x is resolved relative to itself, down to `finest`;
    /// 0 is a boundary where it lies inside.
    pub(crate) fn find<P: Planar>(&mut self, problem: &P, x: [f64; 2], y: [f64; 2], pieces: [usize; 2], finest: f64) {
        let mut cuts = vec![x[0]];
        let cut = |cuts: &mut Vec<f64>, from: f64, to: f64, count: usize| {
            cuts.extend((1..count).map(|i| from + (to - from) * (i as f64 / count as f64)));
            cuts.push(to);
        };
        if x[0] < 0.0 && x[1] > 0.0 {
            cut(&mut cuts, x[0], 0.0, pieces[0].div_ceil(2));
            cut(&mut cuts, 0.0, x[1], pieces[0].div_ceil(2));
        } else {
            cut(&mut cuts, x[0], x[1], pieces[0]);
        }
        let mut rows = vec![y[0]];
        cut(&mut rows, y[0], y[1], pieces[1]);
        let search = Search { problem, finest, extent: (y[1] - y[0]).abs() };
        let mut blurred = Vec::new();
        let started = self.evaluations;
        let mut stack: Vec<(Rectangle, Option<P::Strip>)> = Vec::new();
        let columns = cuts.windows(2).map(|columns| Rectangle { low: [columns[0], y[0]], high: [columns[1], y[1]] });
        for column in columns {
            let strip = problem.strip(column.centre()[0], column.radius()[0]);
            for row in rows.windows(2) {
                let rectangle = Rectangle { low: [column.low[0], row[0]], high: [column.high[0], row[1]] };
                stack.push((rectangle, Some(strip.clone())));
                while let Some((rectangle, strip)) = stack.pop() {
                    if self.evaluations - started > problem.budget() || self.stop.is_raised() {
                        self.exhausted += 1;
                    } else {
                        self.examine(&search, rectangle, strip, &mut stack, &mut blurred);
                    }
                }
            }
        }
        self.cluster(blurred, [(x[1] - x[0]).abs(), search.extent]);
    }

    fn examine<P: Planar>(
        &mut self,
        search: &Search<'_, P>,
        rectangle: Rectangle,
        strip: Option<P::Strip>,
        stack: &mut Vec<(Rectangle, Option<P::Strip>)>,
        blurred: &mut Vec<Rectangle>,
    ) {
        self.boxes += 1;
        let (centre, radius) = (rectangle.centre(), rectangle.radius());
        let strip = strip.unwrap_or_else(|| search.problem.strip(centre[0], radius[0]));
        let mut best: Option<Linear> = None;
        let mut shares = [0.0_f64; 2];
        let mut is_blurred = true;
        let mut form = 0;
        while let Some((patches, sound)) = search.problem.enclose(&strip, centre, radius, form) {
            self.evaluations += 1;
            match judge(&patches, radius, form) {
                Verdict::Empty => return,
                Verdict::Linear(mut linear) => {
                    linear.alone &= sound;
                    if linear.alone || best.is_none_or(|best| linear.worst() < best.worst()) {
                        best = Some(linear);
                    }
                }
                Verdict::Singular => {}
            }
            for patch in &patches {
                let (part, size) = (patch.shares(), patch.bound().max(f64::MIN_POSITIVE));
                shares = [shares[0] + part[0] / size, shares[1] + part[1] / size];
            }
            is_blurred &= patches.iter().all(Patch::is_blurred);
            if best.is_some_and(|best| best.alone) {
                break;
            }
            form += 1;
        }
        if let Some(linear) = best
            && linear.alone
            && self.take(search, &rectangle, &strip, linear.form)
        {
            return;
        }
        let scale = [centre[0].abs().max(search.finest / NARROW), search.extent];
        let narrow: [bool; 2] = std::array::from_fn(|i| radius[i] <= NARROW * scale[i]);
        if is_blurred || narrow == [true; 2] {
            blurred.push(rectangle);
            return;
        }
        if let Some(linear) = best
            && let Some(shrunk) = shrunk(
                &rectangle,
                &linear,
                std::array::from_fn(|i| narrow[i] || radius[i] / scale[i] <= WAITS * radius[1 - i] / scale[1 - i]),
            )
        {
            let same_strip = shrunk.low[0] == rectangle.low[0] && shrunk.high[0] == rectangle.high[0];
            stack.push((shrunk, same_strip.then_some(strip)));
            return;
        }
        // Not across a direction that only rounding is left of, if the other one is still wide.
        let fine = |linear: Linear| -> [bool; 2] {
            std::array::from_fn(|i| linear.blur[i] * SHARP > linear.reach[i].max(1.0))
        };
        let fine = best.map_or([false; 2], fine);
        let done: [bool; 2] = std::array::from_fn(|i| narrow[i] || fine[i] && !fine[1 - i]);
        let axis = usize::from(done[0] || (!done[1] && shares[1] > shares[0]));
        let (mut first, mut second) = (rectangle, rectangle);
        (first.high[axis], second.low[axis]) = (centre[axis], centre[axis]);
        let kept = (axis == 1).then_some(strip);
        stack.push((second, kept.clone()));
        stack.push((first, kept));
    }

    /// Looks for the only zero that a rectangle can hold; true if it has been found inside and proved.
    fn take<P: Planar>(
        &mut self,
        search: &Search<'_, P>,
        rectangle: &Rectangle,
        strip: &P::Strip,
        form: usize,
    ) -> bool {
        let (centre, radius) = (rectangle.centre(), rectangle.radius());
        let mut z = centre;
        let mut blur = [0.0; 2];
        let mut previous = f64::INFINITY;
        for step in 0..30 {
            let at = if step == 0 { strip.clone() } else { search.problem.strip(z[0], 0.0) };
            let Some((patches, _)) = search.problem.enclose(&at, z, if step == 0 { radius } else { [0.0; 2] }, form)
            else {
                return false;
            };
            self.evaluations += 1;
            let Some(inverse) = inverse(&patches, [1.0; 2]) else { return false };
            let moved = apply(&inverse, patches.map(|patch| patch.value()));
            z = [z[0] - moved[0], z[1] - moved[1]];
            let outside = (0..2).any(|i| (z[i] - centre[i]).abs() > 2.0 * radius[i]);
            let size = (moved[0] / radius[0]).abs().max((moved[1] / radius[1]).abs());
            if outside || !size.is_finite() {
                return false;
            }
            blur = spread(&inverse, patches.map(|patch| patch.rounding));
            let settled = (0..2).all(|i| moved[i].abs() <= blur[i] || moved[i].abs() <= f64::EPSILON * z[i].abs());
            if step > 0 && (settled || size >= previous) {
                break;
            }
            previous = size;
        }
        // Existence, on a rectangle a little larger than what rounding blurs; with a width that numbers can tell of, too, where
        // a zero at 0 leaves nothing to round.
        let around: [f64; 2] =
            std::array::from_fn(|i| 8.0 * blur[i].max(f64::EPSILON * z[i].abs()).max(1e-30 * radius[i]));
        let strip = search.problem.strip(z[0], around[0]);
        let Some((patches, sound)) = search.problem.enclose(&strip, z, around, form) else { return false };
        self.evaluations += 1;
        let Verdict::Linear(Linear { middle, reach, .. }) = judge(&patches, around, form) else { return false };
        let proved = sound && (0..2).all(|i| middle[i].abs() + reach[i] <= 1.0);
        let inside = (0..2).all(|i| (z[i] - centre[i]).abs() <= radius[i] + around[i]);
        // A rectangle hardly wider than the blur cannot tell its zero from its neighbour's.
        let sharp = (0..2).all(|i| 8.0 * around[i] <= radius[i]);
        if !(proved && inside && sharp) {
            return false;
        }
        // Neighbours share their edges, and a zero there. What rounding tells of a zero at 0 differs from one to the other;
        // closer than the narrowest rectangle no two zeros are told apart.
        let narrowest = [NARROW * z[0].abs().max(search.finest / NARROW), NARROW * search.extent];
        let width: [f64; 2] = std::array::from_fn(|i| (4.0 * around[i]).max(narrowest[i]));
        let shared = (0..2).any(|i| (z[i] - centre[i]).abs() >= radius[i] - width[i]);
        let known = |other: &[f64; 2]| (0..2).all(|i| (z[i] - other[i]).abs() <= width[i]);
        if !(shared && self.simple.iter().any(known)) {
            self.simple.push(z);
        }
        true
    }

    /// Joins blurred rectangles that touch, or nearly, in a whole of this size.
    fn cluster(&mut self, rectangles: Vec<Rectangle>, whole: [f64; 2]) {
        if rectangles.len() > MOST_BLURRED {
            // Not places, but curves or all of the plane, lost in rounding.
            self.exhausted += rectangles.len();
            return;
        }
        let mut clusters: Vec<Vec<Rectangle>> = Vec::new();
        for rectangle in rectangles {
            let touches = |other: &Rectangle| {
                let ((c, r), (d, s)) = ((rectangle.centre(), rectangle.radius()), (other.centre(), other.radius()));
                (0..2).all(|i| (c[i] - d[i]).abs() <= (CLUSTER * (r[i] + s[i])).max(PAIR * whole[i]))
            };
            let (near, mut far): (Vec<_>, Vec<_>) =
                std::mem::take(&mut clusters).into_iter().partition(|cluster| cluster.iter().any(touches));
            let mut joined: Vec<Rectangle> = near.into_iter().flatten().collect();
            joined.push(rectangle);
            far.push(joined);
            clusters = far;
        }
        self.unresolved.extend(clusters.iter().filter_map(|cluster| cluster.first()).map(Rectangle::centre));
    }
}

/// A⁻¹ of the slopes in units of the radii; `None` where there is none.
fn inverse(patches: &[Patch; 2], radius: [f64; 2]) -> Option<[[f64; 2]; 2]> {
    let [[a, b], [c, d]] = patches.each_ref().map(|patch| [patch.slope()[0] * radius[0], patch.slope()[1] * radius[1]]);
    let (first, second) = (a.abs().max(b.abs()), c.abs().max(d.abs()));
    // Rows of very different sizes must not underflow the determinant.
    let ([a, b], [c, d]) = ([a / first, b / first], [c / second, d / second]);
    let determinant = a * d - b * c;
    let inverse =
        [[d / determinant / first, -b / determinant / second], [-c / determinant / first, a / determinant / second]];
    inverse.iter().flatten().all(|x| x.is_finite()).then_some(inverse)
}

fn apply(matrix: &[[f64; 2]; 2], x: [f64; 2]) -> [f64; 2] {
    matrix.map(|row| row[0] * x[0] + row[1] * x[1])
}

/// |matrix| x for x ≥ 0.
fn spread(matrix: &[[f64; 2]; 2], x: [f64; 2]) -> [f64; 2] {
    matrix.map(|row| row[0].abs() * x[0] + row[1].abs() * x[1])
}

/// Works the module's conditions out.
fn judge(patches: &[Patch; 2], radius: [f64; 2], form: usize) -> Verdict {
    if patches.iter().any(Patch::excludes_zero) {
        return Verdict::Empty;
    }
    let Some(inverse) = inverse(patches, radius) else { return Verdict::Singular };
    let middle = apply(&inverse, patches.map(|patch| -patch.value()));
    let reach = spread(&inverse, patches.map(|patch| patch.rest()));
    let blur = spread(&inverse, patches.map(|patch| patch.rounding));
    if (0..2).any(|i| middle[i].abs() > 1.0 + reach[i] + 1e-12) {
        return Verdict::Empty;
    }
    let [first, second] = patches.each_ref().map(|patch| {
        let [x, y] = patch.swing();
        [x * radius[0], y * radius[1]]
    });
    let rows = inverse.map(|row| {
        let column = |i: usize| row[0].abs() * first[i] + row[1].abs() * second[i];
        column(0) + column(1)
    });
    Verdict::Linear(Linear { form, middle, reach, blur, alone: rows.iter().all(|row| *row < 0.99) })
}

/// The part of a rectangle where its zeros can be, if that is much smaller. A direction that is narrow stays.
fn shrunk(rectangle: &Rectangle, linear: &Linear, narrow: [bool; 2]) -> Option<Rectangle> {
    let (centre, radius) = (rectangle.centre(), rectangle.radius());
    let mut next = *rectangle;
    let mut share = 1.0;
    for i in 0..2 {
        // Not so far that it could not be told from its neighbours any more.
        let reach = linear.reach[i].max(4.0 * SHARP * linear.blur[i]) * (1.0 + 1e-12) + 1e-12;
        let low = (centre[i] + (linear.middle[i] - reach) * radius[i]).max(rectangle.low[i]);
        let high = (centre[i] + (linear.middle[i] + reach) * radius[i]).min(rectangle.high[i]);
        let part = (high - low) / (rectangle.high[i] - rectangle.low[i]);
        // A little is not worth a new strip.
        if part < 0.7 && !narrow[i] {
            (next.low[i], next.high[i]) = (low, high);
            share *= part;
        }
    }
    (share < 0.5 && next.low[0] < next.high[0] && next.low[1] < next.high[1]).then_some(next)
}

#[cfg(test)]
mod tests;
