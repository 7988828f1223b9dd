//! The linear lattice and its barriers, validated: values of these types are always in range, nothing downstream checks again.

use crate::error::{ParameterError, check};
use crate::model::parameter::Parameter;
use crate::modes::ring::KEPT;
use crate::modes::row::{Ends, Line};

/// The most masses a ring may have; beyond it the work arrays would not fit a usual machine.
pub const MAX_SITES: usize = 10_000_000;

/// A row without neighbouring rows.
const ONE_LAYER: Line = Line { masses: 1, ends: Ends::Closed };

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
