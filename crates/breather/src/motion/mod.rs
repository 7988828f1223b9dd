//! The motion of every mass along an orbit, exact at any time.
//!
//! Between two impacts each mode is one sinusoid, or with dashpots a dying one. A [`Motion`] holds, for every interval between impacts, the
//! modes' displacement and velocity at its start (from the periodic impulse response, so that no error is carried
//! from one interval to the next) and swings them forward.

mod around;
mod dying;
mod load;
pub(crate) mod modal;
pub(crate) mod polynomial;
pub(crate) mod window;

use smallvec::SmallVec;
use vibrochain_lattice::simd::lanes::{LANES, Lane, combine, fill, groups};
use vibrochain_lattice::{
    Chain, Complex, ImpulseResponse, ModeFlow, Shapes, Spectrum, Steady, Turn, Wave, oscillator_flight,
};

use crate::admissible::grid::Flight;
use crate::error::BreatherError;
use crate::orbit::{Hit, Orbit};
use dying::DyingModes;

/// Modes added up before they go into the sum over a large ring.
const BLOCK: usize = 256;

/// What a motion was worked out from, beside what it keeps for itself; nothing to begin with.
#[derive(Debug, Clone, Default)]
struct Origin {
    uniform_offset: f64,
    dashpots: [f64; 2],
    /// Site, time, impulse.
    impacts: SmallVec<[Hit; 2]>,
    net_impulses: SmallVec<[f64; 1]>,
}

/// Displacement, velocity and acceleration of one mass.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Kinematics {
    /// v_n
    pub displacement: f64,
    /// v̇_n
    pub velocity: f64,
    /// v̈_n, force included
    pub acceleration: f64,
}

impl Kinematics {
    fn of(motion: &Wave, t: f64) -> Self {
        let [displacement, velocity, acceleration, _] = motion.jet(t);
        Self { displacement, velocity, acceleration }
    }
}

/// An orbit's motion, ready to be evaluated; reusable from orbit to orbit without allocation.
///
/// ```
/// use vibrochain_breather::{Family, Motion, breathers};
/// use vibrochain_lattice::{Chain, Model};
/// let model = Model::conservative(Chain::new(21, 0.2, 0.1)?, 1.5, 0.4)?;
/// let found = breathers(&model, Family::DoubleSided)?;
/// let mut motion = Motion::of(&found.orbits[0])?;
/// // At t = 0 the mass at site 0 is on the upper barrier, a + 1.
/// assert!((motion.at(0, 0.0).displacement - 1.4).abs() < 1e-14);
/// # Ok::<(), vibrochain_breather::BreatherError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Motion {
    shapes: Shapes,
    /// Shapes of a small lattice, [source][mode][place] in whole groups of places: of the masses that symmetry leaves from the one
    /// site of a ring that is hit, or of all.
    table: Vec<Lane>,
    /// The sources of the table, and its places; of a ring with one source any.
    table_of: (SmallVec<[usize; 4]>, usize),
    sums: Vec<Lane>,
    origin: Origin,
    frequencies: Vec<f64>,
    /// δ of each mode; without dashpots none.
    decays: Vec<f64>,
    /// The modes of the lattice with dashpots last asked for.
    dying: Option<Box<DyingModes>>,
    period: f64,
    psi: f64,
    steady: Steady,
    chain: Chain,
    force: Wave,
    sites: Vec<usize>,
    starts: Vec<f64>,
    /// Modal displacement and velocity (weights included) at the start of each interval: [interval][source][mode].
    states: Vec<(f64, f64)>,
    /// The modes at the time last asked for: [source][mode] displacement, velocity, acceleration.
    now: Vec<[f64; 3]>,
    /// t+ψ, and the motion under the force, where it is uniform.
    now_time: f64,
    now_force: Kinematics,
}

impl Motion {
    /// Room for the masses of a chain, with its shapes.
    pub(crate) fn vacant(chain: &Chain, shapes: Shapes) -> Self {
        Self {
            shapes,
            table: Vec::new(),
            table_of: (SmallVec::new(), 0),
            sums: Vec::new(),
            origin: Origin::default(),
            frequencies: Vec::new(),
            decays: Vec::new(),
            dying: None,
            period: 1.0,
            psi: 0.0,
            steady: Steady::default(),
            chain: *chain,
            force: Wave::default(),
            sites: Vec::new(),
            starts: Vec::new(),
            states: Vec::new(),
            now: Vec::new(),
            now_time: 0.0,
            now_force: Kinematics::default(),
        }
    }

    /// The motion of an orbit.
    ///
    /// # Errors
    /// [`BreatherError::NoLattice`]; [`BreatherError::Resonance`], which an orbit that exists has already passed.
    pub fn of(orbit: &Orbit) -> Result<Self, BreatherError> {
        let orbit = orbit.lattice()?;
        let (model, chain) = (orbit.model(), orbit.model().chain());
        let free = (!model.is_damped()).then(|| ImpulseResponse::new(&Spectrum::new(*chain), orbit.frequency()));
        let response = free.transpose()?;
        let shapes = response.as_ref().map_or_else(|| Shapes::new(chain), |response| response.shapes().clone());
        let mut motion = Self::vacant(chain, shapes);
        motion.load(orbit, response.as_ref());
        Ok(motion)
    }

    /// Gives back the room of all modes: the motion holds no orbit then.
    pub(crate) fn give_back(&mut self) {
        self.shapes.give_back();
        (self.frequencies, self.states, self.now) = Default::default();
        (self.decays, self.dying) = Default::default();
        self.period = f64::NAN;
    }

    /// Number of masses.
    pub fn sites(&self) -> usize {
        self.shapes.sites()
    }

    /// Whether all masses are asked for at once.
    pub(crate) fn is_large(&self) -> bool {
        self.shapes.is_large()
    }

    /// Number of intervals between impacts in one period.
    pub fn intervals(&self) -> usize {
        self.starts.len()
    }

    /// Start and length of interval `i`.
    pub fn interval(&self, i: usize) -> (f64, f64) {
        let start = self.starts.get(i).copied().unwrap_or_default();
        let end = match self.starts.get(i + 1) {
            Some(&next) => next,
            None => self.starts.first().copied().unwrap_or_default() + self.period,
        };
        (start, end - start)
    }

    /// Moves to the time `elapsed` after the start of interval `i`; [`Motion::site`] then reads any mass.
    pub fn seek(&mut self, i: usize, elapsed: f64) {
        let modes = self.frequencies.len().max(1);
        let states = self.states.get(i * self.now.len()..).unwrap_or_default();
        for (now, states) in self.now.chunks_exact_mut(modes).zip(states.chunks_exact(modes)) {
            let modes = now.iter_mut().zip(states).zip(&self.frequencies);
            if !self.decays.is_empty() {
                for (((now, &(q, p)), &frequency), &decay) in modes.zip(&self.decays) {
                    let [[a, b], [c, d]] = oscillator_flight(frequency, decay, elapsed);
                    let (q, p) = (a * q + b * p, c * q + d * p);
                    *now = [q, p, -frequency * frequency * q - 2.0 * decay * p];
                }
                continue;
            }
            if elapsed == 0.0 {
                modes.for_each(|((now, &(q, p)), frequency)| *now = [q, p, -frequency * frequency * q]);
                continue;
            }
            for ((now, &(q, p)), frequency) in modes {
                let phase = frequency * elapsed;
                let (sin, cos) = phase.sin_cos();
                // sin Ωt/Ω through its series where Ωt is too small to divide by.
                let sin_over = if phase.abs() > 1e-4 { sin / frequency } else { elapsed * (1.0 - phase * phase / 6.0) };
                let displacement = q * cos + p * sin_over;
                *now = [displacement, p * cos - q * frequency * sin, -frequency * frequency * displacement];
            }
        }
        self.seek_force(i, elapsed);
    }

    /// Moves the force alone.
    fn seek_force(&mut self, i: usize, elapsed: f64) {
        self.now_time = self.force_time(i, elapsed);
        self.now_force = self.steady.uniform().map(|motion| Kinematics::of(motion, self.now_time)).unwrap_or_default();
    }

    /// Displacements and velocities of several masses at the time last sought, as [`Motion::site`] has them; quick for the places
    /// of the table: the half ring that begins with the one site that is hit, or any masses.
    pub(crate) fn masses(&mut self, sites: &[usize], displacements: &mut [f64], velocities: &mut [f64]) {
        let centred = self.is_centred();
        let listed = !centred || self.sites.first() == sites.first() && sites.len() == self.table_of.1;
        if self.table.is_empty() || !listed {
            for ((site, displacement), velocity) in sites.iter().zip(displacements).zip(velocities) {
                let now = self.site(*site);
                (*displacement, *velocity) = (now.displacement, now.velocity);
            }
            return;
        }
        self.sums.resize(groups(self.table_of.1), [0.0; LANES]);
        for (i, out) in [displacements, velocities].into_iter().enumerate() {
            combine(&self.table, self.now.iter().map(|now| now[i]), &mut self.sums);
            let sums = self.sums.as_flattened();
            for (place, (out, &site)) in out.iter_mut().zip(sites).enumerate() {
                let force = self.driven(site);
                *out =
                    sums[if centred { place } else { site }] + if i == 0 { force.displacement } else { force.velocity };
            }
        }
    }

    /// The mass at `site` at the time last sought.
    pub fn site(&self, site: usize) -> Kinematics {
        let mut sum = [0.0; 3];
        if self.is_centre(site) {
            // All modes are 1 there.
            for now in &self.now {
                (0..3).for_each(|i| sum[i] += now[i]);
            }
            return self.forced(site, sum);
        }
        if !self.table.is_empty() && self.table_of.1 == self.shapes.sites() && !self.is_centred() {
            for (now, row) in self.now.iter().zip(self.table.chunks_exact(groups(self.table_of.1))) {
                (0..3).for_each(|i| sum[i] += row.as_flattened()[site] * now[i]);
            }
            return self.forced(site, sum);
        }
        for (modes, &source) in self.now.chunks_exact(self.frequencies.len().max(1)).zip(&self.sites) {
            let mut shapes = self.shapes.evens(site, source);
            // In blocks, so that rounding does not grow with the size of the ring.
            for block in modes.chunks(BLOCK) {
                let mut part = [0.0; 3];
                for (now, shape) in block.iter().zip(&mut shapes) {
                    (0..3).for_each(|i| part[i] += shape * now[i]);
                }
                (0..3).for_each(|i| sum[i] += part[i]);
            }
        }
        self.forced(site, sum)
    }

    /// One site of a ring takes all impacts.
    fn is_centred(&self) -> bool {
        self.sites.len() == 1 && self.chain.is_ring()
    }

    /// Whether all modes of a small ring are 1 at `site`: it takes all impacts.
    fn is_centre(&self, site: usize) -> bool {
        self.sites == [site] && self.chain.is_ring() && self.now.len() <= BLOCK
    }

    /// The motion of a mass under the force, at the time last sought.
    fn driven(&self, site: usize) -> Kinematics {
        match self.steady.uniform() {
            Some(_) => self.now_force,
            None => Kinematics::of(&self.steady.at(site), self.now_time),
        }
    }

    /// Adds it.
    fn forced(&self, site: usize, [displacement, velocity, acceleration]: [f64; 3]) -> Kinematics {
        let force = self.driven(site);
        Kinematics {
            displacement: displacement + force.displacement,
            velocity: velocity + force.velocity,
            acceleration: acceleration + force.acceleration,
        }
    }

    /// Displacement and velocity of all masses at the time last sought, as one complex number; in O(M log M) for a large ring.
    pub(crate) fn all_sites(&mut self) -> Vec<Complex<f64>> {
        let driven = |n: usize| {
            let force = self.driven(n);
            Complex::new(force.displacement, force.velocity)
        };
        let mut all: Vec<_> = (0..self.sites()).map(driven).collect();
        for (modes, &source) in self.now.chunks_exact(self.frequencies.len().max(1)).zip(&self.sites) {
            self.shapes.add_all(source, modes.iter().map(|now| Complex::new(now[0], now[1])), &mut all);
        }
        all
    }

    /// The mass at `site` at time `t` (any `t`; at an impact, just after it).
    pub fn at(&mut self, site: usize, t: f64) -> Kinematics {
        let t = if (0.0..self.period).contains(&t) { t } else { t.rem_euclid(self.period) };
        let i = match self.starts.iter().rposition(|&start| start <= t) {
            Some(i) => i,
            None => self.starts.len().saturating_sub(1),
        };
        let (start, _) = self.interval(i);
        let elapsed = if t >= start { t - start } else { t + self.period - start };
        self.seek(i, elapsed);
        self.site(site)
    }

    /// Displacements of all masses at time `t`.
    pub fn displacements(&mut self, t: f64) -> Vec<f64> {
        self.state(t).0
    }

    /// Displacements and velocities of all masses at time `t`; in O(M log M) for a large ring.
    pub fn state(&mut self, t: f64) -> (Vec<f64>, Vec<f64>) {
        self.at(0, t);
        self.all_sites().into_iter().map(|value| (value.re, value.im)).unzip()
    }

    /// t+ψ, the force's time, `elapsed` after the start of interval `i`.
    pub(crate) fn force_time(&self, i: usize, elapsed: f64) -> f64 {
        self.starts.get(i).copied().unwrap_or_default() + elapsed + self.psi
    }

    /// The highest frequency in the motion between impacts.
    pub(crate) fn top_frequency(&self) -> f64 {
        if !self.decays.is_empty() {
            let fastest = |(&frequency, &decay): (&f64, &f64)| {
                let ModeFlow { turn, rate, .. } = ModeFlow::oscillator(frequency, decay);
                if turn == Turn::Hyperbolic { decay.abs() + rate } else { frequency.max(decay.abs()) }
            };
            let modes = self.frequencies.iter().zip(&self.decays);
            return modes.map(fastest).fold(self.steady.top_rate(), f64::max);
        }
        self.frequencies.last().copied().unwrap_or_default().max(self.steady.top_rate())
    }

    /// Σ|q_k|: no mass is ever displaced by much more, unless the modes start fast.
    #[cfg(test)]
    pub(crate) fn states_bound(&self) -> f64 {
        self.states.iter().map(|(q, p)| q.abs() + p.abs()).sum()
    }

    /// The flight of interval `i`, whose first state goes into `start`; without shapes unless impacts are at one site of a small ring.
    pub(crate) fn flight<'a>(&'a self, i: usize, start: &'a mut [Vec<Lane>; 2]) -> Flight<'a> {
        let modes = self.frequencies.len();
        let states = self.states.get(i * modes..(i + 1) * modes).unwrap_or_default();
        let [displacements, velocities] = start;
        fill(displacements, states.iter().map(|(q, _)| *q), 0.0);
        fill(velocities, states.iter().map(|(_, p)| *p), 0.0);
        let shapes: &[Lane] = if self.is_centred() { &self.table } else { &[] };
        let flight = Flight::of_ring(&self.frequencies, shapes, [displacements, velocities]);
        match self.steady.uniform() {
            Some(wave) if wave.top_rate() > 0.0 => flight.driven(wave, self.force_time(i, 0.0)),
            _ => flight,
        }
    }

    /// Modal displacement, velocity and acceleration at the time last sought, for the first impacted site; weights
    /// b_k² included (they sum to the motion of that site, without the uniform forced part).
    pub fn modes(&self) -> &[[f64; 3]] {
        let modes = self.frequencies.len().min(self.now.len());
        &self.now[..modes]
    }
}
