//! The shapes of a chain's modes: what the layers above know of its geometry.

use rustfft::num_complex::Complex;

use crate::model::chain::Chain;
use crate::modes::row::{Ends, LineShapes};
use crate::modes::transform::{LARGE_RING, RingTransform};

/// The shapes of a lattice's modes, those of its two directions multiplied: number k along the chain and l across its layers is
/// mode k + l·(number of modes along the chain).
///
/// On a ring mode k swings evenly about any site one likes, with cos(2πkn/M) at the n-th site from there; its partner of the same
/// frequency, sin(2πkn/M), has a node there.
///
/// ```
/// use vibrochain_lattice::{Chain, Shapes};
/// let shapes = Shapes::new(&Chain::new(12, 0.2, 0.1)?);
/// assert_eq!((shapes.even(2, 8, 5), shapes.odd(3, 6, 5)), (-1.0, 1.0));
/// # Ok::<(), vibrochain_lattice::ParameterError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Shapes {
    along: LineShapes,
    /// Of a lattice of several layers.
    across: Option<LineShapes>,
    /// For large rings, once all masses have been asked for.
    transform: Option<RingTransform>,
}

impl Shapes {
    /// The shapes of a chain's modes, whatever its springs.
    pub fn new(chain: &Chain) -> Self {
        let [along, across] = chain.lines();
        let across = (across.masses > 1).then(|| LineShapes::new(across));
        Self { along: LineShapes::new(along), across, transform: None }
    }

    /// Whether they are those of `chain`.
    pub fn are_of(&self, chain: &Chain) -> bool {
        let [along, across] = chain.lines();
        self.along.line() == along && self.across.as_ref().map_or(across.masses == 1, |own| own.line() == across)
    }

    /// Number of masses.
    pub fn sites(&self) -> usize {
        self.along.line().masses * self.across.as_ref().map_or(1, |across| across.line().masses)
    }

    /// All masses of long rows at once ([`Shapes::add_all`]) cost less than half of them one by one.
    pub fn is_large(&self) -> bool {
        self.along.line().masses >= LARGE_RING
    }

    /// Gives back the work space of [`Shapes::add_all`], to be set up again when that is asked for.
    pub fn give_back(&mut self) {
        self.transform = None;
    }

    fn is_ring(&self) -> bool {
        self.across.is_none() && self.along.line().ends == Ends::Closed
    }

    /// The shape of mode `k` at `site` times that at `about`, which a kernel between the two has for a factor beside the mode's
    /// weight ([`crate::Spectrum::weights`]). On a ring the displacement of `site` in the mode even about `about`, which is
    /// displaced by 1.
    pub fn even(&self, k: usize, site: usize, about: usize) -> f64 {
        let Some(across) = &self.across else { return self.along.even(k, site, about) };
        let (length, modes) = (self.along.line().masses, self.along.line().modes());
        self.along.even(k % modes, site % length, about % length)
            * across.even(k / modes, site / length, about / length)
    }

    /// Displacement of `site` in the partner of mode `k` of a ring, odd about site `about`.
    pub fn odd(&self, k: usize, site: usize, about: usize) -> f64 {
        let sine = self.along.cosines.sine(k, site.abs_diff(about));
        if site < about { -sine } else { sine }
    }

    /// What [`Shapes::even`] of two sites lacks of that of site `home` with itself, to its own last digits.
    pub fn drop(&self, k: usize, site: usize, about: usize, home: usize) -> f64 {
        let Some(across) = &self.across else { return self.along.drop(k, site, about, home) };
        let (length, modes) = (self.along.line().masses, self.along.line().modes());
        let (k, l) = (k % modes, k / modes);
        // xy − x′y′ = x(y − y′) + (x − x′)y′
        let (below, above, level) = (site / length, about / length, home / length);
        self.along.even(k, home % length, home % length) * across.drop(l, below, above, level)
            + self.along.drop(k, site % length, about % length, home % length) * across.even(l, below, above)
    }

    /// [`Shapes::even`] of all modes, without a multiplication a step on a ring.
    pub fn evens(&self, site: usize, about: usize) -> impl Iterator<Item = f64> + '_ {
        let (ring, mut k) = (self.is_ring(), 0);
        let mut waves = self.along.cosines.shapes(site.abs_diff(about));
        (0..self.modes()).map(move |_| {
            let shape = if ring { waves.next().unwrap_or_default() } else { self.even(k, site, about) };
            k += 1;
            shape
        })
    }

    /// [`Shapes::drop`] of all modes.
    pub(crate) fn drops(&self, site: usize, about: usize, home: usize) -> impl Iterator<Item = f64> + '_ {
        let (ring, mut k) = (self.is_ring(), 0);
        let mut waves = self.along.cosines.defects(site.abs_diff(about));
        (0..self.modes()).map(move |_| {
            let drop = if ring { waves.next().unwrap_or_default() } else { self.drop(k, site, about, home) };
            k += 1;
            drop
        })
    }

    fn modes(&self) -> usize {
        self.along.line().modes() * self.across.as_ref().map_or(1, |across| across.line().modes())
    }

    /// Adds to every mass what the modes make of it, Σ_k amplitude_k · even(k, n, about) at each site n; in O(M log M) for long
    /// rows. Two real sums fit in one complex one.
    pub fn add_all(
        &mut self,
        about: usize,
        amplitudes: impl Iterator<Item = Complex<f64>> + Clone,
        out: &mut [Complex<f64>],
    ) {
        if !self.is_large() {
            for (n, out) in out.iter_mut().enumerate().take(self.sites()) {
                *out += amplitudes.clone().zip(self.evens(n, about)).map(|(x, shape)| x * shape).sum::<Complex<f64>>();
            }
            return;
        }
        let Self { along, across, transform } = self;
        let (length, modes) = (along.line().masses, along.line().modes());
        let transform = transform.get_or_insert_with(|| RingTransform::new(along.circle()));
        let home = about / length;
        for l in 0..across.as_ref().map_or(1, |across| across.line().modes()) {
            // The modes of a row on its ring of images, which has some before the first of them.
            let row = amplitudes.clone().skip(l * modes).take(modes);
            let waves = transform.sites(std::iter::repeat_n(Complex::default(), along.lowest()).chain(row));
            for (layer, out) in out.chunks_mut(length).enumerate() {
                let shape = across.as_ref().map_or(1.0, |across| across.even(l, layer, home));
                for (n, out) in out.iter_mut().enumerate() {
                    let images = along.images(n, about % length).into_iter().flatten();
                    *out += images.map(|(distance, share)| waves[distance] * (share * shape)).sum::<Complex<f64>>();
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(sites: usize) -> Chain {
        Chain::new(sites, 0.2, 0.1).unwrap()
    }

    #[test]
    fn all_masses_move_as_one_by_one_on_small_and_large_rings() {
        let rings = [1, 2, 7, 600, 601].map(ring);
        let rows = [Ends::Free, Ends::Fixed].map(|ends| ring(513).with_ends(ends));
        let layers = rows.map(|row| row.with_layers(3, 0.1, Ends::Closed).unwrap());
        for chain in rings.into_iter().chain(rows).chain(layers) {
            let (mut shapes, sites, modes) = (Shapes::new(&chain), chain.sites(), chain.even_modes());
            let amplitude = |k: usize| Complex::new((3.7 * k as f64).sin(), (k as f64).cos());
            let about = sites / 3;
            let mut all = vec![Complex::new(1.0, 0.0); sites];
            shapes.add_all(about, (0..modes).map(amplitude), &mut all);
            for (n, value) in all.iter().enumerate() {
                let plain: Complex<f64> = (0..modes).map(|k| amplitude(k) * shapes.even(k, n, about)).sum();
                assert!((value - 1.0 - plain).norm() < 1e-14 * sites as f64, "{chain} {n}");
            }
        }
    }

    #[test]
    fn even_and_odd_make_a_running_wave() {
        let shapes = Shapes::new(&ring(9));
        for (k, site, about) in [(1, 2, 7), (3, 8, 1), (4, 0, 0)] {
            let turn = std::f64::consts::TAU * k as f64 * (site as f64 - about as f64) / 9.0;
            assert!((shapes.even(k, site, about) - turn.cos()).abs() < 2e-15);
            assert!((shapes.odd(k, site, about) - turn.sin()).abs() < 2e-15);
            assert!((shapes.drop(k, site, about, 0) - (1.0 - turn.cos())).abs() < 2e-15);
        }
    }

    #[test]
    fn shapes_of_chains_with_ends_are_those_by_hand() {
        let pi = std::f64::consts::PI;
        for (length, layers, along, across) in [
            (5, 1, Ends::Free, Ends::Free),
            (5, 1, Ends::Fixed, Ends::Free),
            (1, 1, Ends::Fixed, Ends::Closed),
            (4, 3, Ends::Closed, Ends::Free),
            (3, 4, Ends::Fixed, Ends::Closed),
            (2, 2, Ends::Free, Ends::Fixed),
        ] {
            let chain =
                ring(length).with_ends(along).with_layers(layers, if layers > 1 { 0.03 } else { 0.0 }, across).unwrap();
            let shapes = Shapes::new(&chain);
            let one = |ends: Ends, m: usize, k: usize, n: usize, about: usize| {
                let (k, n, about, m) = (k as f64, n as f64, about as f64, m as f64);
                match ends {
                    Ends::Closed => (2.0 * pi * k * (n - about) / m).cos(),
                    Ends::Free => (pi * k * (n + 0.5) / m).cos() * (pi * k * (about + 0.5) / m).cos(),
                    Ends::Fixed => {
                        let k = k + 1.0;
                        (pi * k * (n + 1.0) / (m + 1.0)).sin() * (pi * k * (about + 1.0) / (m + 1.0)).sin()
                    }
                }
            };
            let modes = chain.lines()[0].modes();
            for (site, about) in [(0, 0), (length - 1, 0), (length * layers - 1, length / 2), (1 % length, length - 1)]
            {
                let all: Vec<f64> = shapes.evens(site, about).collect();
                assert_eq!(all.len(), modes * chain.lines()[1].modes());
                for (k, shape) in all.into_iter().enumerate() {
                    let plain = |site: usize, about: usize| {
                        one(along, length, k % modes, site % length, about % length)
                            * one(across, layers, k / modes, site / length, about / length)
                    };
                    assert_eq!(shape, shapes.even(k, site, about));
                    assert!((shape - plain(site, about)).abs() < 3e-15, "{chain:?} {k} {site} {about}");
                    for home in [0, length / 2, length * layers - 1] {
                        let drop = plain(home, home) - plain(site, about);
                        let told = shapes.drop(k, site, about, home);
                        assert_eq!(shapes.drops(site, about, home).nth(k), Some(told));
                        assert!((told - drop).abs() < 3e-15, "{chain:?} {k} {site} {about} {home}");
                    }
                }
            }
        }
    }
}
