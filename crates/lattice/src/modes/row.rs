//! One direction of a lattice: how many masses in a row, and what stands at the two ends.
//!
//! Modes and kernels of all three kinds of ends are those of a ring, by images: a chain of M masses with free ends moves as a
//! ring of 2M does evenly about the middle between its last and its first mass; one with fixed ends as a ring of 2(M+1) does
//! oddly about the two walls.
//!
//! | ends | ring of images | λ_k/γ | normalised shape |
//! |---|---|---|---|
//! | closed | M | 4 sin²(πk/M), k = 0 … ⌊M/2⌋ | cos and sin of 2πkn/M |
//! | free | 2M | 4 sin²(πk/2M), k = 0 … M−1 | √(2/M) cos(πk(n+½)/M), 1/√M for k = 0 |
//! | fixed | 2(M+1) | 4 sin²(πk/2(M+1)), k = 1 … M | √(2/(M+1)) sin(πk(n+1)/(M+1)) |

use crate::modes::ring::RingCosines;

/// What stands at the two ends of a row of masses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "lowercase"))]
pub enum Ends {
    /// Each other: a ring.
    #[default]
    Closed,
    /// Nothing.
    Free,
    /// A wall, to which a spring goes as between neighbours.
    Fixed,
}

crate::names!(Ends { Closed "closed", Free "free", Fixed "fixed" });

/// What stands at the two ends of a row, alike or not.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum RowEnds {
    /// The same at both.
    Alike(Ends),
    /// A wall before the first mass, nothing behind the last one.
    FixedFree,
}

impl RowEnds {
    /// All of them.
    pub const ALL: [Self; 4] =
        [Self::Alike(Ends::Closed), Self::Alike(Ends::Free), Self::Alike(Ends::Fixed), Self::FixedFree];

    /// The name in files and on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Alike(ends) => ends.name(),
            Self::FixedFree => "fixed-free",
        }
    }

    /// The one of that name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|one| one.name() == name)
    }
}

/// A row of masses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct Line {
    pub(crate) masses: usize,
    pub(crate) ends: Ends,
}

impl Line {
    /// Number of frequencies; those of a ring's pairs of modes count once.
    pub(crate) fn modes(self) -> usize {
        if self.ends == Ends::Closed { self.masses / 2 + 1 } else { self.masses }
    }

    /// Masses of the ring of images.
    pub(crate) fn circle(self) -> usize {
        match self.ends {
            Ends::Closed => self.masses,
            Ends::Free => 2 * self.masses,
            Ends::Fixed => 2 * (self.masses + 1),
        }
    }

    /// The wavenumber on the ring of images of mode 0.
    pub(crate) fn lowest(self) -> usize {
        usize::from(self.ends == Ends::Fixed)
    }

    /// λ_k/γ of all modes, rising.
    pub(crate) fn stiffnesses(self) -> impl Iterator<Item = f64> {
        let circle = self.circle() as f64;
        (0..self.modes()).map(move |k| {
            let s = (std::f64::consts::PI * (k + self.lowest()) as f64 / circle).sin();
            4.0 * s * s
        })
    }

    /// Number of modes of frequency `k`.
    pub(crate) fn multiplicity(self, k: usize) -> usize {
        if self.ends == Ends::Closed && k != 0 && 2 * k != self.masses { 2 } else { 1 }
    }

    /// What the products of [`LineShapes::even`] lack to be those of normalised shapes.
    pub(crate) fn weight(self, k: usize) -> f64 {
        let (part, of) = self.share(k);
        part as f64 / of as f64
    }

    /// The same as a fraction.
    pub(crate) fn share(self, k: usize) -> (usize, usize) {
        let m = self.masses;
        match self.ends {
            Ends::Closed if k == 0 || 2 * k == m => (1, m),
            Ends::Free if k == 0 => (1, m),
            Ends::Closed | Ends::Free => (2, m),
            Ends::Fixed => (2, m + 1),
        }
    }

    /// Whose springs pull at mass `n` from both sides: its neighbours; itself beside a free end, which is no spring; `None` for
    /// a wall.
    pub(crate) fn neighbours(self, n: usize) -> [Option<usize>; 2] {
        let last = self.masses - 1;
        let beyond = |far: usize| match self.ends {
            Ends::Closed => Some(far),
            Ends::Free => Some(n),
            Ends::Fixed => None,
        };
        [if n == 0 { beyond(last) } else { Some(n - 1) }, if n == last { beyond(0) } else { Some(n + 1) }]
    }
}

/// The shapes of a row's modes.
#[derive(Debug, Clone)]
pub(crate) struct LineShapes {
    line: Line,
    pub(crate) cosines: RingCosines,
}

impl LineShapes {
    pub(crate) fn new(line: Line) -> Self {
        Self { line, cosines: RingCosines::new(line.circle()) }
    }

    pub(crate) fn line(&self) -> Line {
        self.line
    }

    /// Masses of the ring of images.
    pub(crate) fn circle(&self) -> usize {
        self.line.circle()
    }

    /// The wavenumber on the ring of images of mode 0.
    pub(crate) fn lowest(&self) -> usize {
        self.line.lowest()
    }

    /// cos of mode `k` at distance `n` on the ring of images.
    pub(crate) fn cosine(&self, k: usize, n: usize) -> f64 {
        self.cosines.shape(k + self.line.lowest(), n)
    }

    /// The distances on the ring of images whose cosines make up [`LineShapes::even`], with their shares.
    pub(crate) fn images(&self, site: usize, about: usize) -> [Option<(usize, f64)>; 2] {
        let own = site.abs_diff(about);
        match self.image(site, about) {
            None => [Some((own, 1.0)), None],
            Some(image) => [Some((own, 0.5)), Some((image % self.circle(), 0.5 * self.sign()))],
        }
    }

    /// How far the image of `site` is from `about`, if there is one: twice the distance to the mirror between.
    fn image(&self, site: usize, about: usize) -> Option<usize> {
        match self.line.ends {
            Ends::Closed => None,
            Ends::Free => Some(site + about + 1),
            Ends::Fixed => Some(site + about + 2),
        }
    }

    /// An image moves with the mass (free ends) or against it (fixed).
    fn sign(&self) -> f64 {
        if self.line.ends == Ends::Fixed { -1.0 } else { 1.0 }
    }

    /// The shape of mode `k` at `site` times that at `about`; summed over a pair of modes of a ring.
    pub(crate) fn even(&self, k: usize, site: usize, about: usize) -> f64 {
        let k = k + self.line.lowest();
        let own = self.cosines.shape(k, site.abs_diff(about));
        match self.image(site, about) {
            None => own,
            Some(image) => 0.5 * (own + self.sign() * self.cosines.shape(k, image)),
        }
    }

    /// even(k, home, home) − even(k, site, about), to its own last digits.
    pub(crate) fn drop(&self, k: usize, site: usize, about: usize, home: usize) -> f64 {
        let k = k + self.line.lowest();
        let own = self.cosines.defect(k, site.abs_diff(about));
        match (self.image(site, about), self.image(home, home)) {
            (Some(image), Some(home)) => {
                let further = self.cosines.defect_between(k, home, image);
                0.5 * (own + self.sign() * further)
            }
            _ => own,
        }
    }
}
