//! A small simulator for tests. It shares nothing with the crates: modes from a dense symmetric eigensolver, impacts by
//! Newton's method next to their nominal times.

use nalgebra::{DMatrix, DVector, SymmetricEigen};
use vibrochain_breather::{Impact, Motion, Orbit};
use vibrochain_lattice::{Chain, Ends, Harmonic, Model};

/// The stiffness matrix of a lattice, spring by spring.
#[must_use]
pub fn stiffness(chain: &Chain) -> DMatrix<f64> {
    let (length, layers) = (chain.length(), chain.layers());
    let mut matrix = DMatrix::from_diagonal_element(length * layers, length * layers, chain.gamma1());
    let mut spring = |gamma: f64, one: usize, other: Option<usize>| {
        matrix[(one, one)] += gamma;
        if let Some(other) = other {
            matrix[(other, other)] += gamma;
            matrix[(one, other)] -= gamma;
            matrix[(other, one)] -= gamma;
        }
    };
    // A row of masses, each so far from the one before it.
    let mut row = |gamma: f64, ends: Ends, first: usize, step: usize, count: usize| {
        let last = first + step * (count - 1);
        (1..count).for_each(|n| spring(gamma, first + step * (n - 1), Some(first + step * n)));
        match ends {
            Ends::Closed => spring(gamma, last, Some(first)),
            Ends::Free => {}
            Ends::Fixed => [first, last].into_iter().for_each(|n| spring(gamma, n, None)),
        }
    };
    (0..layers).for_each(|layer| row(chain.gamma2(), chain.ends(), layer * length, 1, length));
    (0..length).for_each(|n| row(chain.gamma3(), chain.layer_ends(), n, length, layers));
    matrix
}

/// Free flight of a lattice under its force.
#[derive(Debug)]
pub struct Ring {
    frequencies: DVector<f64>,
    shapes: DMatrix<f64>,
    /// (rate, amplitudes of the response, phase) of each harmonic of the force.
    response: Vec<(f64, DVector<f64>, f64)>,
}

impl Ring {
    /// The lattice of a model.
    #[must_use]
    pub fn new(model: &Model) -> Self {
        let (chain, sites) = (model.chain(), model.chain().sites());
        let eigen = SymmetricEigen::new(stiffness(chain));
        let response = |harmonic: &Harmonic| {
            let rate = f64::from(harmonic.number) * model.omega();
            let push = DVector::from_element(sites, harmonic.amplitude);
            let amplitudes = if chain.has_walls() {
                let mut modes = eigen.eigenvectors.tr_mul(&push);
                modes.iter_mut().zip(&eigen.eigenvalues).for_each(|(mode, square)| *mode /= square - rate * rate);
                &eigen.eigenvectors * modes
            } else {
                // All masses move alike: no other mode is touched, be it as near as it may.
                push / (chain.gamma1() - rate * rate)
            };
            (rate, amplitudes, harmonic.phase)
        };
        let response = model.force().harmonics().iter().map(response).collect();
        Self { frequencies: eigen.eigenvalues.map(|x| x.max(0.0).sqrt()), shapes: eigen.eigenvectors, response }
    }

    /// State (u, v) after `time`; `phase` is the time t + ψ of the force at its start.
    #[must_use]
    pub fn fly(&self, u: &DVector<f64>, v: &DVector<f64>, phase: f64, time: f64) -> (DVector<f64>, DVector<f64>) {
        let force = |t: f64| {
            let rest = DVector::zeros(u.len());
            self.response.iter().fold((rest.clone(), rest), |sum, (rate, amplitudes, phase)| {
                let (sin, cos) = (rate * t + phase).sin_cos();
                (sum.0 + amplitudes * cos, sum.1 - amplitudes * (rate * sin))
            })
        };
        let (g0, h0) = force(phase);
        let (q, p) = (self.shapes.tr_mul(&(u - g0)), self.shapes.tr_mul(&(v - h0)));
        let (mut q1, mut p1) = (q.clone(), p.clone());
        for k in 0..q.len() {
            let f = self.frequencies[k];
            let (sin, cos) = (f * time).sin_cos();
            let sin_over = if f > 1e-9 { sin / f } else { time };
            q1[k] = q[k] * cos + p[k] * sin_over;
            p1[k] = p[k] * cos - q[k] * f * sin;
        }
        let (g1, h1) = force(phase + time);
        (&self.shapes * q1 + g1, &self.shapes * p1 + h1)
    }

    /// The matrix of free flight without force.
    #[must_use]
    pub fn flow(&self, time: f64) -> DMatrix<f64> {
        let m = self.frequencies.len();
        let mut flow = DMatrix::zeros(2 * m, 2 * m);
        for j in 0..2 * m {
            let mut unit = DVector::zeros(2 * m);
            unit[j] = 1.0;
            let quiet =
                Self { response: Vec::new(), shapes: self.shapes.clone(), frequencies: self.frequencies.clone() };
            let (u, v) = quiet.fly(&unit.rows(0, m).into(), &unit.rows(m, m).into(), 0.0, time);
            flow.view_mut((0, j), (m, 1)).copy_from(&u);
            flow.view_mut((m, j), (m, 1)).copy_from(&v);
        }
        flow
    }
}

/// The return map of an orbit's impacts over one period, from the middle of its last interval.
#[derive(Debug)]
pub struct ReturnMap<'a> {
    orbit: &'a Orbit,
    /// Free flight.
    pub ring: Ring,
    /// Start, before the first impact (negative).
    pub start: f64,
}

impl<'a> ReturnMap<'a> {
    /// The map of this orbit.
    #[must_use]
    pub fn new(orbit: &'a Orbit) -> Self {
        let last = orbit.impacts().last().unwrap().time;
        Self { orbit, ring: Ring::new(orbit.model().unwrap()), start: 0.5 * (last - orbit.period()) }
    }

    /// The orbit's own state at the start.
    #[must_use]
    pub fn fixed_point(&self) -> DVector<f64> {
        let mut motion = Motion::of(self.orbit).unwrap();
        let m = motion.sites();
        motion.at(0, self.start);
        DVector::from_iterator(
            2 * m,
            (0..m).map(|n| motion.site(n).displacement).chain((0..m).map(|n| motion.site(n).velocity)),
        )
    }

    /// One period.
    #[must_use]
    pub fn apply(&self, state: &DVector<f64>) -> DVector<f64> {
        self.run(state, self.orbit.impacts(), self.start + self.orbit.period())
    }

    /// The mirror image of the state after half a period with the first impact. It takes a symmetric orbit to itself.
    #[must_use]
    pub fn mirrored_half(&self, state: &DVector<f64>) -> DVector<f64> {
        -self.run(state, &self.orbit.impacts()[..1], self.start + 0.5 * self.orbit.period())
    }

    /// From the start through some impacts to a time. Each impact is found from the state of the moment; those of one instant
    /// in the order in which they come.
    fn run(&self, state: &DVector<f64>, impacts: &[Impact], end: f64) -> DVector<f64> {
        let m = state.len() / 2;
        let psi = self.orbit.psi().unwrap_or(0.0);
        let e = self.orbit.model().unwrap().restitution();
        let (mut u, mut v): (DVector<f64>, DVector<f64>) = (state.rows(0, m).into(), state.rows(m, m).into());
        let mut now = self.start;
        let mut left = impacts.to_vec();
        while !left.is_empty() {
            let first = left[0].time;
            let simultaneous = left.iter().take_while(|impact| impact.time == first).count();
            let time_of = |impact: &Impact| {
                let barrier = self.orbit.model().unwrap().barrier(impact.barrier);
                let mut t = impact.time;
                for _ in 0..50 {
                    let (u, v) = self.ring.fly(&u, &v, now + psi, t - now);
                    let step = (u[impact.site] - barrier) / v[impact.site];
                    t -= step;
                    if step.abs() < 1e-15 {
                        break;
                    }
                }
                t
            };
            let (index, t) =
                (0..simultaneous).map(|i| (i, time_of(&left[i]))).min_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
            (u, v) = self.ring.fly(&u, &v, now + psi, t - now);
            v[left[index].site] *= -e;
            now = t;
            left.remove(index);
        }
        (u, v) = self.ring.fly(&u, &v, now + psi, end - now);
        DVector::from_iterator(2 * m, u.iter().chain(v.iter()).copied())
    }

    /// Speed of the slowest impact, at most 1.
    #[must_use]
    pub fn slowest_impact(&self) -> f64 {
        self.orbit.impacts().iter().map(|impact| impact.velocity_before.abs()).fold(1.0, f64::min)
    }

    /// Central differences of the return map at two steps, extrapolated. The steps are small against the slowest impact:
    /// near grazing the map bends on the scale of its velocity squared. Where impacts of several masses coincide it has
    /// kinks at the point itself: the error is of order h, not h², and another extrapolation removes it.
    #[must_use]
    pub fn jacobian(&self) -> DMatrix<f64> {
        self.jacobian_of(|state| self.apply(state))
    }

    /// The same for another map of the orbit's states.
    #[must_use]
    pub fn jacobian_of(&self, map: impl Fn(&DVector<f64>) -> DVector<f64>) -> DMatrix<f64> {
        let point = self.fixed_point();
        let kinked = self.orbit.impacts().windows(2).any(|pair| pair[0].time == pair[1].time);
        let h = if kinked { 1e-5 } else { 1e-4 } * self.slowest_impact().powi(2);
        let order = if kinked { 2.0 } else { 4.0 };
        let mut jacobian = DMatrix::zeros(point.len(), point.len());
        for j in 0..point.len() {
            let slope = |h: f64| {
                let (mut plus, mut minus) = (point.clone(), point.clone());
                plus[j] += h;
                minus[j] -= h;
                (map(&plus) - map(&minus)) / (2.0 * h)
            };
            jacobian.set_column(j, &((order * slope(0.5 * h) - slope(h)) / (order - 1.0)));
        }
        jacobian
    }
}
