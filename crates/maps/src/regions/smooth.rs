//! Between the points of a curve: a cubic through four neighbours, where the curve is smooth.

/// A point, in parts of the window.
pub(crate) type Place = [f64; 2];

pub(crate) fn minus(a: Place, b: Place) -> Place {
    [a[0] - b[0], a[1] - b[1]]
}

/// `a + t b`.
pub(crate) fn along(a: Place, t: f64, b: Place) -> Place {
    [a[0] + t * b[0], a[1] + t * b[1]]
}

pub(crate) fn dot(a: Place, b: Place) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

pub(crate) fn length(a: Place) -> f64 {
    a[0].hypot(a[1])
}

/// A neighbour counts as one from this part of the chord on: nearer, its own error turns the curve.
const NEIGHBOUR: f64 = 0.1;

/// Beyond this part of the chord a curve bends too fast for four points to tell its way: a right angle seems to bend by a
/// sixteenth to an eighth.
const SHARPEST: f64 = 0.06;

/// The parabolas through the points before and behind a chord leave it alike where the curve is smooth: to this part of what
/// they leave it by (one part in three where the distances of the points differ as much), or to this part of the chord, where the
/// curve bends to the other side.
const ALIKE: (f64, f64) = (0.35, 0.002);

/// A curve between two neighbouring points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Arc {
    from: Place,
    chord: Place,
    /// The curve leaves its chord by u(u − 1)(a + b u).
    a: Place,
    b: Place,
}

impl Arc {
    fn straight(from: Place, to: Place) -> Self {
        Self { from, chord: minus(to, from), a: [0.0; 2], b: [0.0; 2] }
    }

    /// Between points `i` and `i + 1` of a curve; of a closed one the first point is the last.
    pub(crate) fn new(points: &[Place], i: usize, closed: bool) -> Self {
        let straight = Self::straight(points[i], points[i + 1]);
        let chord = length(straight.chord);
        let last = points.len() - 1;
        // The first point behind, or ahead, that is far enough.
        let neighbour = |from: Place, step: &dyn Fn(usize) -> Option<usize>| {
            (1..=last).map_while(step).map(|k| points[k]).find(|&point| length(minus(point, from)) >= NEIGHBOUR * chord)
        };
        let behind = neighbour(points[i], &|k| if closed { Some((i + last - k) % last) } else { i.checked_sub(k) });
        let ahead = neighbour(points[i + 1], &|k| {
            if closed { Some((i + 1 + k) % last) } else { Some(i + 1 + k).filter(|&k| k <= last) }
        });
        // Points by length along the curve, the chord's being 0 and 1, and how far they lie off its line.
        let off = |point: Place, u: f64| minus(point, along(straight.from, u, straight.chord));
        let behind = behind.map(|point| -length(minus(point, points[i])) / chord).zip(behind);
        let ahead = ahead.map(|point| 1.0 + length(minus(point, points[i + 1])) / chord).zip(ahead);
        // The coefficient of u(u − 1) in the parabola through a third point.
        let parabola = |(u, point): (f64, Place)| off(point, u).map(|part| part / (u * (u - 1.0)));
        let bent = match (behind, ahead) {
            (Some(one), None) | (None, Some(one)) => Self { a: parabola(one), ..straight },
            (Some(one), Some(two)) => {
                let (p, q) = (parabola(one), parabola(two));
                let (apart, most) = (length(minus(p, q)), length(p).max(length(q)));
                if apart > (ALIKE.0 * most).max(ALIKE.1 * chord) {
                    return straight;
                }
                let b = minus(q, p).map(|part| part / (two.0 - one.0));
                Self { a: along(p, -one.0, b), b, ..straight }
            }
            (None, None) => straight,
        };
        if bent.sagitta() <= SHARPEST * chord { bent } else { straight }
    }

    /// The curve at `u` between 0 and 1.
    pub(crate) fn at(&self, u: f64) -> Place {
        if u >= 1.0 {
            return along(self.from, 1.0, self.chord);
        }
        let bend = along(self.a, u, self.b);
        along(along(self.from, u, self.chord), u * (u - 1.0), bend)
    }

    /// Its derivative there.
    pub(crate) fn direction(&self, u: f64) -> Place {
        let turn = along(self.chord, 2.0 * u - 1.0, along(self.a, u, self.b));
        along(turn, u * (u - 1.0), self.b)
    }

    /// About how far the curve goes from its chord.
    pub(crate) fn sagitta(&self) -> f64 {
        0.25 * length(self.a).max(length(along(self.a, 1.0, self.b)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn worst(points: &[Place], closed: bool, miss: impl Fn(Place) -> f64) -> f64 {
        let arcs = (0..points.len() - 1).map(|i| Arc::new(points, i, closed));
        arcs.flat_map(|arc| (0..=10).map(move |k| arc.at(f64::from(k) / 10.0))).map(miss).fold(0.0, f64::max)
    }

    #[test]
    fn the_cubic_keeps_to_a_smooth_curve_however_its_points_are_spaced() {
        let mut random = fastrand::Rng::with_seed(3);
        for count in [100, 200, 400] {
            // A circle, closed, with distances that vary by a factor of three.
            let mut angles: Vec<f64> = (0..count).map(|i| f64::from(i) + 0.5 * random.f64()).collect();
            angles.push(angles[0] + f64::from(count));
            let turn = std::f64::consts::TAU / f64::from(count);
            let mut circle: Vec<Place> = angles.iter().map(|a| [(a * turn).cos(), (a * turn).sin()]).collect();
            circle[count as usize] = circle[0];
            let error = worst(&circle, true, |[x, y]| (x.hypot(y) - 1.0).abs());
            // The chord errs by h²/8, the cubic by the fourth power of the distance.
            let h = 1.5 * turn;
            assert!(error < 0.1 * h.powi(4), "{count} {error:e} {:e}", h.powi(4));
            assert!(error > 1e-6 * h.powi(4));
            // An inflection, open.
            let wave: Vec<Place> = angles.iter().map(|a| [a * turn, (a * turn).sin()]).collect();
            let error = worst(&wave[1..], false, |[x, y]| (x.sin() - y).abs());
            assert!(error < h.powi(3), "{count} {error:e}");
        }
    }

    #[test]
    fn corners_stay_corners() {
        for angle in [30.0_f64, 60.0, 90.0, 120.0, 170.0] {
            let (sin, cos) = angle.to_radians().sin_cos();
            let corner: Vec<Place> =
                (-5..=5).map(f64::from).map(|i| if i < 0.0 { [i, 0.0] } else { [i * cos, i * sin] }).collect();
            // On one of the two lines.
            let miss = |[x, y]: Place| y.abs().min((cos * y - sin * x).abs());
            let error = worst(&corner, false, miss);
            assert!(error < 1e-12, "{angle}: {error}");
        }
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]];
        for i in 0..4 {
            assert_eq!(Arc::new(&square, i, true).sagitta(), 0.0);
        }
    }
}
