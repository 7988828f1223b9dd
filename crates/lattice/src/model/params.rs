//! Validated parameters. A value of these types is always in range; nothing downstream checks again.

use crate::error::{ParameterError, RESONANCE_TOLERANCE, Resonance, check};
use crate::model::force::{Force, Wave};
use crate::model::parameter::Parameter;
use crate::modes::ring::KEPT;
use crate::modes::row::{Ends, Line};

/// The most masses a ring may have; beyond it the work arrays would not fit a usual machine.
pub const MAX_SITES: usize = 10_000_000;

/// One of the two rigid barriers of a mass, at a − 1 and a + 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "lowercase"))]
pub enum Barrier {
    /// The barrier at a − 1, the nearer one for a > 0.
    Lower,
    /// The barrier at a + 1.
    Upper,
}

impl Barrier {
    /// Outward direction: −1 at the lower barrier, +1 at the upper one.
    pub fn sign(self) -> f64 {
        match self {
            Self::Lower => -1.0,
            Self::Upper => 1.0,
        }
    }

    /// Position of the barrier for a gap centred on `asymmetry`.
    pub fn position(self, asymmetry: f64) -> f64 {
        asymmetry + self.sign()
    }
}

crate::names!(Barrier { Lower "lower", Upper "upper" });

/// The linear lattice: unit masses in a row, or in several layers of equal rows, and the stiffnesses of the equations of motion
///
/// ```text
/// ü = −γ₁u − γ₂(2u − u_left − u_right) − γ₃(2u − u_below − u_above) ,
/// ```
///
/// where beside a free end stands the mass itself once more, and a wall (fixed end) does not move. Sites are numbered along the
/// rows, layer by layer: site n of layer l is n + l·[`Chain::length`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chain {
    along: Line,
    across: Line,
    gamma1: f64,
    gamma2: f64,
    gamma3: f64,
}

/// Where the masses of a lattice stand; checked when springs join them ([`Chain::on`]).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Layout {
    /// Masses of one layer.
    pub length: usize,
    /// What stands at the ends of the rows.
    pub ends: Ends,
    /// Number of layers.
    pub layers: usize,
    /// What stands below the first and above the last layer; of one layer nothing is said.
    pub layer_ends: Ends,
}

impl Layout {
    /// One row as long as it may be: its sites are its masses.
    pub const ONE_ROW: Self = Self { length: MAX_SITES, ends: Ends::Closed, layers: 1, layer_ends: Ends::Free };

    /// One closed row.
    pub fn ring(sites: usize) -> Self {
        Self { length: sites, ends: Ends::Closed, layers: 1, layer_ends: Ends::Closed }
    }

    /// One layer, closed.
    pub fn is_ring(&self) -> bool {
        self.layers == 1 && self.ends == Ends::Closed
    }

    /// Number of mass `site` of layer `layer`; `None` where there is none.
    pub fn index(&self, site: usize, layer: usize) -> Option<usize> {
        (site < self.length && layer < self.layers).then(|| site + layer * self.length)
    }

    /// What impact words call mass `index`: its site, with its layer where there are several, as in `3:1`.
    ///
    /// ```
    /// use vibrochain_lattice::{Chain, Ends};
    /// let chain = Chain::new(6, 0.2, 0.1)?;
    /// assert_eq!(chain.layout().name(5), "5");
    /// assert_eq!(chain.with_layers(2, 0.05, Ends::Free)?.layout().name(7), "1:1");
    /// # Ok::<(), vibrochain_lattice::ParameterError>(())
    /// ```
    pub fn name(&self, index: usize) -> String {
        let (site, layer) = self.place(index);
        if self.layers > 1 { format!("{site}:{layer}") } else { site.to_string() }
    }

    /// The site and layer of mass `index`.
    pub fn place(&self, index: usize) -> (usize, usize) {
        (index % self.length.max(1), index / self.length.max(1))
    }

    /// The same as answers tell it: the layer only where there are several.
    pub fn site_and_layer(&self, index: usize) -> (usize, Option<usize>) {
        let (site, layer) = self.place(index);
        (site, (self.layers > 1).then_some(layer))
    }
}

impl Chain {
    /// A ring of `sites` unit masses with on-site stiffness `gamma1` and coupling stiffness `gamma2`.
    ///
    /// On a ring of two masses both springs join the same pair; on a ring of one the coupling does nothing.
    ///
    /// # Errors
    /// A [`ParameterError`] unless 1 ≤ `sites` ≤ [`MAX_SITES`], 0 ≤ γ₁, γ₂ ≤ 1e100, of several masses not both zero.
    ///
    /// ```
    /// use vibrochain_lattice::Chain;
    /// assert!(Chain::new(21, 0.2, 0.1).is_ok());
    /// assert!(Chain::new(21, -0.2, 0.1).is_err());
    /// ```
    pub fn new(sites: usize, gamma1: f64, gamma2: f64) -> Result<Self, ParameterError> {
        check((1..=MAX_SITES).contains(&sites), "sites", sites as f64, "a whole number from 1 to 10000000")?;
        Parameter::Gamma1.check(gamma1)?;
        Parameter::Gamma2.check(gamma2)?;
        let both = "a positive gamma1 or gamma2: with both zero no mass is held by any spring";
        // A mass alone flies from barrier to barrier, whatever is beside it.
        check(sites == 1 || gamma1 > 0.0 || gamma2 > 0.0, "gamma1", gamma1, both)?;
        // A minus zero would survive the range check and change signs downstream.
        let along = Line { masses: sites, ends: Ends::Closed };
        Ok(Self { along, across: ONE_LAYER, gamma1: gamma1 + 0.0, gamma2: gamma2 + 0.0, gamma3: 0.0 })
    }

    /// The same with other ends of its rows.
    #[must_use]
    pub fn with_ends(mut self, ends: Ends) -> Self {
        self.along.ends = ends;
        self
    }

    /// The same in `layers` rows, between neighbours of which springs of stiffness `gamma3` go; `ends` tells whether the first
    /// row is the last one's neighbour, too.
    ///
    /// # Errors
    /// A [`ParameterError`] unless there is at least one layer, all masses together are at most [`MAX_SITES`] and 0 ≤ γ₃ ≤
    /// 1e100.
    ///
    /// ```
    /// use vibrochain_lattice::{Chain, Ends, Spectrum};
    /// // Two masses joined by one spring.
    /// let pair = Chain::new(1, 0.2, 0.0)?.with_layers(2, 0.03, Ends::Free)?;
    /// assert!((Spectrum::new(pair).band().1.powi(2) - 0.26).abs() < 1e-15);
    /// # Ok::<(), vibrochain_lattice::ParameterError>(())
    /// ```
    pub fn with_layers(mut self, layers: usize, gamma3: f64, ends: Ends) -> Result<Self, ParameterError> {
        let fits = layers >= 1 && layers.checked_mul(self.along.masses).is_some_and(|sites| sites <= MAX_SITES);
        check(fits, "layers", layers as f64, "at least 1, and at most 10000000 masses in all")?;
        Parameter::Gamma3.check(gamma3)?;
        let held = layers == 1 || self.gamma1 > 0.0 || gamma3 > 0.0 || self.along.ends == Ends::Fixed;
        check(
            held,
            "gamma3",
            gamma3,
            "positive where gamma1 is 0 and rows have no walls: nothing holds the layers together",
        )?;
        check(
            layers > 1 || gamma3 == 0.0,
            "gamma3",
            gamma3,
            "0 with one layer, which has no neighbour; or more layers",
        )?;
        // One row has no neighbours whatever its ends.
        self.across = if layers == 1 { ONE_LAYER } else { Line { masses: layers, ends } };
        self.gamma3 = gamma3 + 0.0;
        Ok(self)
    }

    /// The lattice of a layout with its stiffnesses γ₁, γ₂ and γ₃.
    ///
    /// # Errors
    /// As [`Chain::new`] and [`Chain::with_layers`].
    pub fn on(layout: Layout, gamma1: f64, gamma2: f64, gamma3: f64) -> Result<Self, ParameterError> {
        let Layout { length, ends, layers, layer_ends } = layout;
        Self::new(length, gamma1, gamma2)?.with_ends(ends).with_layers(layers, gamma3, layer_ends)
    }

    /// Where its masses stand.
    pub fn layout(&self) -> Layout {
        let (Line { masses: length, ends }, Line { masses: layers, ends: layer_ends }) = (self.along, self.across);
        Layout { length, ends, layers, layer_ends }
    }

    /// Number of masses, of all layers together.
    pub fn sites(&self) -> usize {
        self.along.masses * self.across.masses
    }

    /// Few enough masses for sweeps: work spaces keep what could be worked out again. Large lattices have better use of memory.
    pub fn is_kept(&self) -> bool {
        self.sites() <= KEPT
    }

    /// Masses of one layer.
    pub fn length(&self) -> usize {
        self.along.masses
    }

    /// Number of layers.
    pub fn layers(&self) -> usize {
        self.across.masses
    }

    /// What stands at the ends of the rows.
    pub fn ends(&self) -> Ends {
        self.along.ends
    }

    /// What stands below the first and above the last layer.
    pub fn layer_ends(&self) -> Ends {
        self.across.ends
    }

    /// One layer, closed: the lattice of the paper, on which all sites are alike.
    pub fn is_ring(&self) -> bool {
        self.along.ends == Ends::Closed && self.across.masses == 1
    }

    /// A wall somewhere: there is no mode in which all masses move alike.
    pub fn has_walls(&self) -> bool {
        self.along.ends == Ends::Fixed || self.across.ends == Ends::Fixed
    }

    /// Nothing holds the lattice as a whole: a periodic motion needs a net impulse of zero.
    pub fn is_adrift(&self) -> bool {
        self.gamma1 == 0.0 && !self.has_walls()
    }

    pub(crate) fn lines(&self) -> [Line; 2] {
        [self.along, self.across]
    }

    /// On-site stiffness γ₁.
    pub fn gamma1(&self) -> f64 {
        self.gamma1
    }

    /// Coupling stiffness γ₂ along the rows.
    pub fn gamma2(&self) -> f64 {
        self.gamma2
    }

    /// Coupling stiffness γ₃ between layers.
    pub fn gamma3(&self) -> f64 {
        self.gamma3
    }

    /// No coupling that a number could hold, or none to couple to: each mass swings alone.
    pub fn is_uncoupled(&self) -> bool {
        // Modes are one frequency to a few units in the last place then.
        let negligible = |gamma: f64| 4.0 * gamma <= 32.0 * f64::EPSILON * self.gamma1;
        let alone = self.along.masses == 1 && self.along.ends != Ends::Fixed;
        (alone || negligible(self.gamma2)) && (self.across.masses == 1 || negligible(self.gamma3))
    }

    /// Number of frequencies of modes: of a ring ⌊M/2⌋ + 1, those even about a site.
    pub fn even_modes(&self) -> usize {
        self.along.modes() * self.across.modes()
    }

    /// Number of modes that are not among [`Chain::even_modes`]: of a ring ⌊(M−1)/2⌋, those odd about a site; each shares its
    /// frequency with the even mode k = 1, 2, ….
    pub fn odd_modes(&self) -> usize {
        self.sites() - self.even_modes()
    }

    /// Number of modes of frequency `k` of [`crate::Spectrum::frequencies`].
    pub fn multiplicity(&self, k: usize) -> usize {
        let modes = self.along.modes();
        self.along.multiplicity(k % modes) * self.across.multiplicity(k / modes)
    }

    /// Whether a reflection of the lattice exchanges two sites.
    ///
    /// ```
    /// use vibrochain_lattice::{Chain, Ends};
    /// let ring = Chain::new(7, 0.2, 0.1)?;
    /// assert!(ring.exchanges(0, 3));
    /// let open = ring.with_ends(Ends::Free);
    /// assert!(open.exchanges(2, 4) && !open.exchanges(2, 5));
    /// # Ok::<(), vibrochain_lattice::ParameterError>(())
    /// ```
    pub fn exchanges(&self, one: usize, other: usize) -> bool {
        let [(n, below), (m, above)] = [one, other].map(|site| self.layout().place(site));
        self.along.exchanges(n, m) && self.across.exchanges(below, above)
    }

    /// Masses on unit springs without coupling, at least one: a chain to begin with.
    pub fn alone(sites: usize) -> Self {
        let along = Line { masses: sites.max(1), ends: Ends::Closed };
        Self { along, across: ONE_LAYER, gamma1: 1.0, gamma2: 0.0, gamma3: 0.0 }
    }

    /// One layer of another chain, on its own.
    pub(crate) fn alone_with(chain: &Self) -> Self {
        Self { across: ONE_LAYER, gamma3: 0.0, ..*chain }
    }

    /// The masses to the left and right, below and above, to which a mass is coupled: itself beside a free end and in rows of
    /// one; `None` for a wall.
    #[inline]
    pub fn neighbours(&self, site: usize) -> [Option<usize>; 4] {
        if self.across.masses == 1 {
            let [left, right] = self.along.neighbours(site);
            return [left, right, Some(site), Some(site)];
        }
        let length = self.along.masses;
        let (n, layer) = (site % length, site / length);
        let [left, right] = self.along.neighbours(n).map(|n| n.map(|n| n + layer * length));
        let [below, above] = self.across.neighbours(layer).map(|layer| layer.map(|layer| n + layer * length));
        [left, right, below, above]
    }

    /// What the springs do to a mass displaced by `own`, its neighbours by `sides` (in the order of [`Chain::neighbours`], a wall
    /// by 0): −γ₁u − γ₂(2u − u_left − u_right) − γ₃(2u − u_below − u_above).
    pub fn spring_force(&self, own: f64, [left, right, below, above]: [f64; 4]) -> f64 {
        let row = -self.gamma1 * own - self.gamma2 * (2.0 * own - (left + right));
        if self.across.masses == 1 { row } else { row - self.gamma3 * (2.0 * own - (below + above)) }
    }

    /// The largest that [`Chain::spring_force`] can be for displacements up to these moduli.
    pub fn spring_force_bound(&self, own: f64, [left, right, below, above]: [f64; 4]) -> f64 {
        let row = self.gamma1 * own + self.gamma2 * (2.0 * own + right + left);
        if self.across.masses == 1 { row } else { row + self.gamma3 * (2.0 * own + below + above) }
    }

    /// Distance on a ring between two sites, at most ⌊M/2⌋.
    pub fn distance(&self, from: usize, to: usize) -> usize {
        let d = from.abs_diff(to) % self.along.masses;
        d.min(self.along.masses - d)
    }
}

/// A row without neighbouring rows.
const ONE_LAYER: Line = Line { masses: 1, ends: Ends::Closed };

/// A chain with its barriers, its force and its law of impact: one point of the parameter space.
///
/// Without force (`amplitude` = 0) and with elastic impacts (`restitution` = 1) it is conservative; `omega`
/// is then the frequency of the orbit that is asked for. The force is a cosine ([`Model::forced`]) or any sum of its odd
/// harmonics ([`Model::with_force`]).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Model {
    chain: Chain,
    omega: f64,
    asymmetry: f64,
    force: Force,
    restitution: f64,
}

impl Model {
    /// A conservative model: no force, elastic impacts, orbits of frequency `omega`.
    ///
    /// # Errors
    /// A [`ParameterError`] unless 1e-100 ≤ ω ≤ 1e100 and 0 ≤ a < 1.
    pub fn conservative(chain: Chain, omega: f64, asymmetry: f64) -> Result<Self, ParameterError> {
        Self::forced(chain, omega, asymmetry, 0.0, 1.0)
    }

    /// A model under the uniform force A cos ω(t+ψ) with restitution coefficient e.
    ///
    /// # Errors
    /// As [`Model::conservative`], and unless 0 ≤ A ≤ 1e100 and 0 < e ≤ 1.
    ///
    /// ```
    /// use vibrochain_lattice::{Chain, Model};
    /// let model = Model::forced(Chain::new(21, 0.2, 0.1)?, 1.5, 0.4, 0.1, 0.9)?;
    /// assert!(!model.is_conservative());
    /// assert!((model.loss() - 0.1 / 1.9).abs() < 1e-16);
    /// # Ok::<(), vibrochain_lattice::ParameterError>(())
    /// ```
    pub fn forced(
        chain: Chain,
        omega: f64,
        asymmetry: f64,
        amplitude: f64,
        restitution: f64,
    ) -> Result<Self, ParameterError> {
        check_place(omega, asymmetry)?;
        let force = Force::cosine(amplitude)?;
        Self::with_force(chain, omega, asymmetry, &force, restitution)
    }

    /// A model under the uniform force Σ A_j cos(jω(t+ψ) + θ_j) with restitution coefficient e.
    ///
    /// # Errors
    /// As [`Model::conservative`], and unless 0 < e ≤ 1.
    ///
    /// ```
    /// use vibrochain_lattice::{Chain, Force, Harmonic, Model};
    /// let terms = [(1, 0.1), (3, -0.03)].map(|(number, amplitude)| Harmonic { number, amplitude, phase: 0.0 });
    /// let model = Model::with_force(Chain::new(21, 0.2, 0.1)?, 1.5, 0.4, &Force::new(&terms)?, 0.9)?;
    /// assert!((model.force_wave().value(0.0) - 0.07).abs() < 1e-16);
    /// # Ok::<(), vibrochain_lattice::ParameterError>(())
    /// ```
    pub fn with_force(
        chain: Chain,
        omega: f64,
        asymmetry: f64,
        force: &Force,
        restitution: f64,
    ) -> Result<Self, ParameterError> {
        check_place(omega, asymmetry)?;
        let alike = chain.layer_ends() != Ends::Fixed || force.amplitude() == 0.0;
        check(
            alike,
            "amplitude",
            force.amplitude(),
            "0 with walls beside layers: give walls to the ends of rows only",
        )?;
        Parameter::Restitution.check(restitution)?;
        Ok(Self { chain, omega, asymmetry: asymmetry + 0.0, force: *force, restitution })
    }

    /// The linear lattice.
    pub fn chain(&self) -> &Chain {
        &self.chain
    }

    /// Frequency ω of the force (and of a map).
    pub fn omega(&self) -> f64 {
        self.omega
    }

    /// Changes the frequency alone, as along a row of a map; see [`Model::with`] for any parameter.
    ///
    /// # Errors
    /// A [`ParameterError`] unless 1e-100 ≤ ω ≤ 1e100; the model stays as it was.
    pub fn set_omega(&mut self, omega: f64) -> Result<(), ParameterError> {
        check_place(omega, self.asymmetry)?;
        self.omega = omega;
        Ok(())
    }

    /// Period T = 2π/ω of the force.
    pub fn period(&self) -> f64 {
        std::f64::consts::TAU / self.omega
    }

    /// Centre a of the gap.
    pub fn asymmetry(&self) -> f64 {
        self.asymmetry
    }

    /// Amplitude A of the force; of a force of several harmonics Σ|A_j|, which it never exceeds.
    pub fn amplitude(&self) -> f64 {
        self.force.amplitude()
    }

    /// The force.
    pub fn force(&self) -> &Force {
        &self.force
    }

    /// The force as a function of the time t + ψ.
    #[inline]
    pub fn force_wave(&self) -> Wave {
        Wave::new(&self.force, self.omega, |_, _| Ok::<_, std::convert::Infallible>(1.0)).unwrap_or_default()
    }

    /// Coefficient e of restitution.
    pub fn restitution(&self) -> f64 {
        self.restitution
    }

    /// q = (1−e)/(1+e): the part of an impact's momentum that Newton's law loses.
    pub fn loss(&self) -> f64 {
        (1.0 - self.restitution) / (1.0 + self.restitution)
    }

    /// No force and elastic impacts.
    #[inline]
    pub fn is_conservative(&self) -> bool {
        self.amplitude() == 0.0 && self.restitution == 1.0
    }

    /// Position of a barrier.
    pub fn barrier(&self, barrier: Barrier) -> f64 {
        barrier.position(self.asymmetry)
    }

    /// Σ A_j/(γ₁ − j²ω²) cos(jω(t+ψ) + θ_j): the uniform motion that the force drives without impacts and walls, as a function of the
    /// time t + ψ (paper, sec. II B; of the plain cosine Ã cos ω(t+ψ)).
    ///
    /// # Errors
    /// [`Resonance`] when a harmonic meets the uniform mode, Ω₀ = √γ₁.
    pub fn steady_response(&self) -> Result<Wave, Resonance> {
        let (gamma1, omega) = (self.chain.gamma1, self.omega);
        if self.amplitude() == 0.0 {
            return Ok(self.force_wave());
        }
        Wave::new(&self.force, omega, |harmonic, rate| {
            // One rounding only: the difference is what resonance hangs on.
            let stiffness = (-rate).mul_add(rate, gamma1);
            if stiffness.abs() <= 2.0 * RESONANCE_TOLERANCE * rate * rate {
                let frequency = gamma1.sqrt();
                let harmonic = u64::from(harmonic);
                return Err(Resonance { harmonic, mode: 0, frequency, omega, distance: frequency - rate });
            }
            Ok(stiffness)
        })
    }

    /// Ã = A/(γ₁ − ω²), the amplitude of [`Model::steady_response`] to a plain cosine; of any other force
    /// Σ|A_j/(γ₁ − j²ω²)|, which that motion never exceeds.
    ///
    /// # Errors
    /// As [`Model::steady_response`].
    pub fn force_response(&self) -> Result<f64, Resonance> {
        Ok(self.steady_response()?.reach())
    }
}

fn check_place(omega: f64, asymmetry: f64) -> Result<(), ParameterError> {
    Parameter::Omega.check(omega)?;
    Parameter::Asymmetry.check(asymmetry)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_closed_where_they_should_be() {
        assert!(Chain::new(1, 0.0, 1e-300).is_ok());
        for (sites, g1, g2) in
            [(0, 1., 1.), (1, -1., 1.), (1, 1., -1.), (2, 0., 0.), (2, f64::NAN, 1.), (2, 1., f64::INFINITY)]
        {
            assert!(Chain::new(sites, g1, g2).is_err(), "{sites} {g1} {g2}");
        }
        let chain = Chain::new(3, 1.0, 0.0).unwrap();
        for (w, a, f, e) in [
            (0., 0., 0., 1.),
            (1., 1., 0., 1.),
            (1., -0.1, 0., 1.),
            (1., 0., -1., 1.),
            (1., 0., 0., 0.),
            (1., 0., 0., 1.1),
        ] {
            assert!(Model::forced(chain, w, a, f, e).is_err(), "{w} {a} {f} {e}");
        }
        let mut model = Model::forced(chain, 2.0, 0.0, 1.0, 1.0).unwrap();
        assert!(model.set_omega(0.0).is_err() && model.omega() == 2.0);
        assert!(model.set_omega(1.5).is_ok() && model == Model::forced(chain, 1.5, 0.0, 1.0, 1.0).unwrap());
    }

    #[test]
    fn force_on_the_uniform_mode_is_a_resonance() {
        let model = Model::forced(Chain::new(5, 0.25, 0.1).unwrap(), 0.5, 0.0, 1.0, 0.5).unwrap();
        let error = model.steady_response().unwrap_err();
        assert_eq!((error.harmonic, error.mode), (1, 0));
    }
}
