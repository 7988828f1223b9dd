//! The paper's procedure, step by step as a reader of it would program it: Fourier series for the kernels, impulses from
//! them, and the multipliers from a general matrix exponential of the whole ring (with the misprints mended). A slow peer
//! for the closed forms; this crate's tests and `studies accuracy` set them side by side.
//!
//! Where there is a choice it is the one that favours the series: harmonics are evaluated with the root that does not
//! cancel ([`harmonic_response`]), and times that divide the period share their cosines.

use nalgebra::{Complex, DMatrix, Schur};
use vibrochain_breather::{Family, LatticeOrbit};
use vibrochain_lattice::{Chain, ImpulseResponse, Model, Spectrum, harmonic_response};

/// Samples a period at which masses are watched.
pub const SAMPLES: usize = 64;

/// Excess per period that the dense multipliers cannot tell from rounding: their trivial pair splits by 1e-7 … 1e-8, next
/// to grazing by more.
pub const BLUR: f64 = 1e-5;

/// QR sweeps per eigenvalue after which the iteration is given up; a handful is usual.
const SWEEPS: usize = 60;

/// K_n at the times sT/64, s = 0 … 32, for the sites n = 0 … ⌊M/2⌋; the rest follows by symmetry.
#[derive(Debug, Clone, PartialEq)]
pub struct Kernels {
    /// By site, then by time.
    values: Vec<[f64; SAMPLES / 2 + 1]>,
}

impl Kernels {
    /// By the paper's Fourier series of `terms` harmonics,
    ///
    /// ```text
    /// K_n(t) = (1/T) [g_n(0) + 2 Σ_{j=1}^{J} g_n(jω) cos jωt] .
    /// ```
    pub fn by_series(model: &Model, terms: u32) -> Self {
        let chain = model.chain();
        let sites = chain.even_modes();
        // Harmonics that agree at all 64 times are added before their common cosine is applied.
        let mut sums = vec![[0.0; SAMPLES]; sites];
        for j in 0..=terms {
            let w = f64::from(j) * model.omega();
            let weight = if j == 0 { 1.0 } else { 2.0 } / model.period();
            for (n, sums) in sums.iter_mut().enumerate() {
                sums[j as usize % SAMPLES] += weight * harmonic_response(chain, w, n);
            }
        }
        let cosines: Vec<f64> =
            (0..SAMPLES).map(|s| (std::f64::consts::TAU * s as f64 / SAMPLES as f64).cos()).collect();
        let at = |sums: &[f64; SAMPLES], s: usize| -> f64 {
            // The cosine of jωt depends on j·s modulo 64 alone.
            sums.iter().enumerate().map(|(j, sum)| sum * cosines[j * s % SAMPLES]).sum()
        };
        Self { values: sums.iter().map(|sums| std::array::from_fn(|s| at(sums, s))).collect() }
    }

    /// In closed form; `None` on a resonance.
    pub fn closed(model: &Model) -> Option<Self> {
        let response = ImpulseResponse::new(&Spectrum::new(*model.chain()), model.omega()).ok()?;
        let mut values = vec![[0.0; SAMPLES / 2 + 1]; response.modes()];
        let mut profile = vec![0.0; response.modes()];
        for s in 0..=SAMPLES / 2 {
            response.profile(model.period() * s as f64 / SAMPLES as f64, &mut profile);
            for (values, value) in values.iter_mut().zip(&profile) {
                values[s] = *value;
            }
        }
        Some(Self { values })
    }

    /// K_n(0) and K_n(T/2); K₁ = K₀ on a ring of one.
    fn ends(&self, site: usize) -> [f64; 2] {
        let values = self.values.get(site).or(self.values.first());
        values.map_or([f64::NAN; 2], |values| [values[0], values[SAMPLES / 2]])
    }

    /// Half impulses (p₁, p₂) of the double-sided breather, or (p, 0) of the single-sided one.
    fn impulses(&self, model: &Model, family: Family) -> (f64, f64) {
        let [at_impact, half_way] = self.ends(0);
        let (chi1, chi2, a) = (-2.0 * half_way, -2.0 * at_impact, model.asymmetry());
        if family == Family::DoubleSided {
            (1.0 / (chi2 - chi1) - a / (chi1 + chi2), 1.0 / (chi2 - chi1) + a / (chi1 + chi2))
        } else {
            ((1.0 - a) / chi2, 0.0)
        }
    }

    /// The conservative breather that exists, if any: right-signed impulses, and every mass inside the gap at every sample.
    pub fn family(&self, model: &Model) -> Option<Family> {
        [Family::DoubleSided, Family::SingleSided].into_iter().find(|&family| {
            let (p1, p2) = self.impulses(model, family);
            let signs = if family == Family::DoubleSided { p1 > 0.0 && p2 > 0.0 } else { p1 > 0.0 };
            signs && self.stays_inside(model, family, (p1, p2))
        })
    }

    fn stays_inside(&self, model: &Model, family: Family, (p1, p2): (f64, f64)) -> bool {
        let half = SAMPLES / 2;
        let double = family == Family::DoubleSided;
        self.values.iter().enumerate().all(|(n, kernel)| {
            (0..=half).all(|s| {
                // The impacting mass is on its barrier at the impacts themselves.
                let impact = n == 0 && (s == 0 || double && s == half);
                let displacement =
                    if double { 2.0 * (p1 * kernel[half - s] - p2 * kernel[s]) } else { 2.0 * p1 * kernel[s] };
                impact || (displacement - model.asymmetry()).abs() < 1.0
            })
        })
    }

    /// Largest modulus of the multipliers of the conservative breather of a family; `None` if the eigenvalues do not come
    /// out.
    pub fn spectral_radius(&self, model: &Model, family: Family) -> Option<f64> {
        let (chain, a) = (model.chain(), model.asymmetry());
        let (p1, p2) = self.impulses(model, family);
        let [k10, k1h] = self.ends(1);
        // v̈₀ = −γ₁v₀ − 2γ₂(v₀ − v₁) at an impact.
        let acceleration = |own: f64, next: f64| -chain.gamma1() * own - 2.0 * chain.gamma2() * (own - next);
        let kappa = |acceleration: f64, velocity: f64| 2.0 * acceleration / velocity;
        let monodromy = if family == Family::DoubleSided {
            let upper = kappa(acceleration(a + 1.0, 2.0 * (p1 * k1h - p2 * k10)), p2);
            let lower = kappa(acceleration(a - 1.0, 2.0 * (p1 * k10 - p2 * k1h)), -p1);
            general_monodromy(chain, model.period(), 1.0, &[(0.0, upper), (0.5 * model.period(), lower)])
        } else {
            let lower = kappa(acceleration(a - 1.0, 2.0 * p1 * k10), -p1);
            general_monodromy(chain, model.period(), 1.0, &[(0.0, lower)])
        };
        let multipliers = general_eigenvalues(monodromy)?;
        Some(multipliers.iter().map(|mu| mu.norm()).fold(0.0, f64::max))
    }
}

/// The 2M×2M matrix of the free motion, displacements first.
fn generator(chain: &Chain) -> DMatrix<f64> {
    let (m, g1, g2) = (chain.sites(), chain.gamma1(), chain.gamma2());
    let mut matrix = DMatrix::zeros(2 * m, 2 * m);
    for n in 0..m {
        matrix[(n, n + m)] = 1.0;
        // Entries add up where neighbours coincide, on rings of one and two.
        matrix[(n + m, n)] -= g1 + 2.0 * g2;
        matrix[(n + m, (n + 1) % m)] += g2;
        matrix[(n + m, (n + m - 1) % m)] += g2;
    }
    matrix
}

/// The monodromy matrix of the whole ring by general matrix exponentials, from impacts at site 0: (time, κ) in order of
/// time, the first at 0.
pub fn general_monodromy(chain: &Chain, period: f64, restitution: f64, impacts: &[(f64, f64)]) -> DMatrix<f64> {
    let m = chain.sites();
    let generator = generator(chain);
    let mut product = DMatrix::identity(2 * m, 2 * m);
    let mut flight: Option<(f64, DMatrix<f64>)> = None;
    for (i, &(time, kappa)) in impacts.iter().enumerate() {
        let until = impacts.get(i + 1).map_or(period, |next| next.0);
        let mut saltation = DMatrix::identity(2 * m, 2 * m);
        saltation[(0, 0)] = -restitution;
        saltation[(m, m)] = -restitution;
        saltation[(m, 0)] = kappa;
        // Equal flights share their exponential.
        let (_, flow) = match flight.take() {
            Some(known) if known.0 == until - time => flight.insert(known),
            _ => flight.insert((until - time, (&generator * (until - time)).exp())),
        };
        product = &*flow * saltation * product;
    }
    product
}

/// [`general_monodromy`] of an orbit whose impacts are at site 0, with the paper's saltations.
pub fn general_monodromy_of(orbit: LatticeOrbit<'_>) -> DMatrix<f64> {
    let e = orbit.model().restitution();
    let kappa = |acceleration: f64, velocity: f64| (1.0 + e) * acceleration / velocity;
    let impacts: Vec<(f64, f64)> = orbit
        .impacts()
        .iter()
        .map(|impact| (impact.time, kappa(impact.acceleration, impact.velocity_before)))
        .collect();
    general_monodromy(orbit.model().chain(), orbit.period(), e, &impacts)
}

/// All eigenvalues of a matrix by the general dense solver; `None` if they do not come out.
pub fn general_eigenvalues(matrix: DMatrix<f64>) -> Option<Vec<Complex<f64>>> {
    if matrix.iter().any(|entry| !entry.is_finite()) {
        return None;
    }
    let sweeps = SWEEPS * matrix.nrows();
    Schur::try_new(matrix, f64::EPSILON, sweeps).map(|schur| schur.complex_eigenvalues().iter().copied().collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    use vibrochain_breather::breathers;
    use vibrochain_floquet::full_monodromy;
    use vibrochain_lattice::Point;

    #[test]
    fn the_general_monodromy_is_that_of_the_exact_propagator() {
        for (sites, amplitude, e) in [(1, 0.0, 1.0), (2, 0.0, 1.0), (5, 0.1, 0.9)] {
            let ring = Point::ring(sites).gamma1(0.2).gamma2(0.1);
            let model = ring.omega(1.5).asymmetry(0.4).amplitude(amplitude).restitution(e).model().unwrap();
            let orbit = &breathers(&model, Family::DoubleSided).unwrap().orbits[0];
            let (general, exact) = (general_monodromy_of(orbit.lattice().unwrap()), full_monodromy(orbit).unwrap());
            for i in 0..2 * sites {
                for j in 0..2 * sites {
                    assert!((general[(i, j)] - exact[(i, j)]).abs() < 1e-12 * exact.norm(), "{sites} {i} {j}");
                }
            }
        }
    }

    #[test]
    fn the_series_comes_to_the_closed_form_like_its_tail() {
        let model = Model::conservative(Chain::new(21, 0.2, 0.1).unwrap(), 1.5, 0.4).unwrap();
        let closed = Kernels::closed(&model).unwrap();
        // What the series leaves out of K₀(0): (2/T) Σ_{j>J} 1/(jω)² = ω/(π ω² J) to leading order.
        for terms in [1000, 10_000] {
            let error = Kernels::by_series(&model, terms).ends(0)[0] - closed.ends(0)[0];
            let tail = 1.0 / (std::f64::consts::PI * 1.5 * f64::from(terms));
            assert!((error / tail - 1.0).abs() < 0.01, "{terms}: {error} {tail}");
        }
        assert_eq!(closed.family(&model), Some(Family::DoubleSided));
    }
}
