//! The equations of impacts, and of an orbit that may begin at any time.

use std::sync::Arc;

use vibrochain_lattice::{BlochKernel, Complex};

use super::dying::{Cut, Sent, died, largest, only, send_on, since_cut};
use super::{BlochEquations, LinearImpact, ShapeErrors};

type C = Complex<f64>;

impl BlochEquations {
    /// The equations of impacts in order of time between contacts of any kernel.
    pub fn new(kernel: BlochKernel, impacts: Vec<LinearImpact>) -> Self {
        let omega = std::f64::consts::TAU / kernel.period();
        let size = 2 * impacts.len();
        let since = since_cut(&kernel, &impacts);
        let spread = since.iter().copied().fold(0.0, f64::max);
        let (mut left_out, mut sliding) = (0.0f64, Vec::new());
        let all = size * kernel.modes().len();
        let (mut rows, mut columns) = (Vec::with_capacity(all), Vec::with_capacity(all));
        let (mut outside, mut inside) = (vec![0.0; size * size], vec![0.0; size * size]);
        let mut sent_errors = Vec::new();
        for (k, mode) in kernel.modes().iter().enumerate() {
            let (coordinates, generator) = (mode.coordinates, mode.generator());
            let died = died(mode, spread, kernel.period());
            if died != [false; 2] {
                left_out = left_out.max(largest(only(died, mode.flight(kernel.period() - spread))));
                sliding.resize(size * size, 0.0);
                sent_errors.resize(size * size, 0.0);
                let cut = Cut { kernel: &kernel, impacts: &impacts, since: &since };
                send_on(&cut, k, died, Sent { now: &mut outside, slide: &mut sliding, errors: &mut sent_errors });
            }
            // At the cut itself nothing has moved.
            let alive = |t: f64| {
                let flights = if t == 0.0 { [coordinates.unit(); 2] } else { mode.flights(t) };
                flights.map(|flight| only(died.map(|died| !died), flight))
            };
            let from = rows.len();
            for (impact, t) in impacts.iter().zip(&since) {
                let [forth, back] = alive(*t);
                let place = coordinates.seen(kernel.row(k, impact.contact), forth);
                let speed = coordinates.seen(place, generator);
                rows.extend([place.map(|x| omega * x), speed]);
                let given_now = coordinates.given(back, kernel.column(k, impact.contact));
                let slid = coordinates.given(generator, given_now);
                columns.extend([given_now, slid.map(|x| -x / omega)]);
            }
            for (i, row) in rows[from..].iter().enumerate() {
                for (j, column) in columns[from..].iter().enumerate() {
                    let product = row[0] * column[0] + row[1] * column[1];
                    // What an earlier impact of this period sends straight on; or what a later one and the impact itself do not.
                    if since[i / 2] > since[j / 2] {
                        outside[i * size + j] += product;
                    } else {
                        inside[i * size + j] -= product;
                    }
                }
            }
        }
        for (i, impact) in impacts.iter().enumerate() {
            let mobility = kernel.mobility(impact.contact, impact.contact);
            // g′⁻ = −P/(m(1+e))
            let hit = mobility / (1.0 + impact.restitution);
            let slide = impact.acceleration_before / (omega * impact.impulse);
            let at = 2 * i * size + 2 * i;
            for (matrix, own) in [(&mut outside, 0.0), (&mut inside, mobility)] {
                // At the impact itself the sums are K = 0 and K′ = 1/m exactly.
                (matrix[at], matrix[at + 1], matrix[at + size]) = (0.0, own - hit, hit - own);
                matrix[at + size + 1] += slide;
            }
        }
        let poles = kernel.modes().iter().flat_map(|mode| mode.poles()).map(|pole| pole.norm_sqr());
        let innermost = poles.fold(f64::INFINITY, f64::min);
        Self {
            kernel: Arc::new(kernel),
            impacts,
            omega,
            since,
            left_out,
            sliding,
            rows,
            columns,
            sent_errors,
            outside,
            inside,
            innermost,
            slide_errors: None,
        }
    }

    /// Replaces both lists by the errors of A_k and of C_k that come from the shape of mode `k`. Each pair is in the form of
    /// [`vibrochain_lattice::Coordinates::carried`].
    pub fn shape_errors(&self, k: usize, [rows, columns]: &mut ShapeErrors) {
        rows.clear();
        columns.clear();
        let (mode, spread) = (&self.kernel.modes()[k], self.since.iter().copied().fold(0.0, f64::max));
        let (coordinates, generator) = (mode.coordinates, mode.generator());
        let alive = died(mode, spread, self.kernel.period()).map(|died| !died);
        // The rates of both coordinates, or of both together.
        let [first, second] = coordinates.carried([1.0; 2], generator);
        let faster = |[x, y]: [f64; 2]| [first * x, second * y];
        for (impact, t) in self.impacts.iter().zip(&self.since) {
            let [forth, back] = mode.flight_sizes(*t).map(|flight| only(alive, flight));
            let [seen, given] = self.kernel.shape_errors(k, impact.contact);
            let [seen, given] = [coordinates.carried(seen, forth), coordinates.carried(given, back)];
            rows.extend([seen.map(|x| self.omega * x), faster(seen)]);
            columns.extend([given, faster(given).map(|x| x / self.omega)]);
        }
    }

    /// The equations of an orbit without force or losses, which may begin at any time: J(1) has its own derivative as a null vector. So the
    /// accelerations are not asked for, but what the past impacts make of them; of a rigid mode these say nothing, and it stays as given.
    pub fn conservative(kernel: BlochKernel, impacts: Vec<LinearImpact>) -> Self {
        let mut equations = Self::new(kernel, impacts);
        let one = C::new(1.0, 0.0);
        if equations.kernel.modes().iter().flat_map(|mode| mode.poles()).any(|pole| pole == one) {
            return equations;
        }
        let size = equations.size();
        let sums = equations.matrix(one);
        let impulse = |j: usize| equations.impacts[j].impulse;
        let count = equations.impacts.len();
        let (mut errors, mut doubts) = (vec![0.0; count], ShapeErrors::default());
        for (k, mode) in equations.kernel.modes().iter().enumerate() {
            equations.shape_errors(k, &mut doubts);
            let (rows, columns, [row_errors, column_errors]) = (equations.rows(k), equations.columns(k), &doubts);
            let [near, _] = mode.poles().map(|pole| (one - pole).norm().recip());
            for (i, error) in errors.iter_mut().enumerate() {
                let reach = |j: usize| {
                    let (row, column) = (rows[2 * i + 1], columns[2 * j + 1]);
                    let shapes = [[row, row_errors[2 * i + 1]], [column, column_errors[2 * j + 1]]];
                    let shapes = mode.coordinates.reach_error(shapes[0], shapes[1]);
                    (mode.coordinates.reach(row, column) * mode.pole_error * near + shapes) * impulse(j).abs()
                };
                *error += near * (0..count).map(reach).sum::<f64>();
            }
        }
        let slide = |i: usize| {
            let row = &sums[(2 * i + 1) * size..(2 * i + 2) * size];
            (0..count).map(|j| row[2 * j + 1].re * impulse(j)).sum::<f64>() / impulse(i)
        };
        let slides: Vec<f64> = (0..count).map(slide).collect();
        errors.iter_mut().enumerate().for_each(|(i, error)| *error /= impulse(i).abs());
        for (i, slide) in slides.into_iter().enumerate() {
            let at = (2 * i + 1) * (size + 1);
            equations.outside[at] -= slide;
            equations.inside[at] -= slide;
        }
        equations.slide_errors = Some(errors);
        equations
    }
}
