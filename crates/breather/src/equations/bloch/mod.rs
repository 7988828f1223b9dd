//! J(z): the linearised equations of an orbit's impacts with Bloch factor z, on any linear structure.
//!
//! Perturb the impulses and times of an orbit, those of period n by zⁿ(δP_i, δt_i). With the state just before each impact, g its gap's
//! coordinate, m its effective mass, K^z of t_i−t_j for past impacts alone ([`BlochKernel::jet`]):
//!
//! ```text
//! position   Σ_j [ K^z_ij δP_j − P_j K^z′_ij δt_j ] + g′_i⁻ δt_i
//! Newton     δP_i/m_i + (1+e_i) { Σ_j [ K^z′_ij δP_j − P_j K^z″_ij δt_j ] + g″_i⁻ δt_i }
//! ```
//!
//! J(1) is the Jacobian of the orbit's own equations. Where J(z) is singular z is a multiplier:
//! det(z−M)/det(z−R) = Π_i(−m_i/g′_i⁻)·det J(z), R the free flight of a period. All rows and columns here are in units that make J even:
//! rows ω·position and Newton/(1+e), unknowns δP and ωPδt. Then det(z−M)/det(z−R) = Π_i(m_i(1+e_i))²·det J(z), J is Hermitian on the
//! unit circle where neither impacts nor modes lose energy, and every mode adds a product of two real vectors in two coordinates,
//! J(z) = J₀ + Σ_k A_k R_k(z−R_k)⁻¹ C_k.

//!
//! | module | holds |
//! |---|---|
//! | `linear_impact` | [`LinearImpact`]: an impact as the equations know it |
//! | `setup` | the equations of impacts, of an orbit, of one that may begin at any time |
//! | `shift` | the equations of such an orbit without its own derivative |
//! | `dying` | modes that die within a period |
//! | `matrix` | J(z) itself |

mod dying;
mod linear_impact;
mod matrix;
mod setup;
mod shift;

pub use linear_impact::LinearImpact;
pub use shift::Shift;

use std::sync::Arc;

use smallvec::SmallVec;
use vibrochain_lattice::BlochKernel;

/// Errors of one mode's A_k and C_k, a pair of numbers for each row and for each column of J: what [`BlochEquations::shape_errors`] works out.
pub type ShapeErrors = [SmallVec<[[f64; 2]; 8]>; 2];

/// J(z) of one orbit.
///
/// ```
/// use vibrochain_breather::{Finder, OrbitList, Scope};
/// use vibrochain_lattice::{Chain, Complex, Model};
/// let model = Model::conservative(Chain::new(9, 0.2, 0.05)?, 1.5, 0.2)?;
/// let (mut finder, mut found) = (Finder::new(9), OrbitList::default());
/// finder.find_word(&model, &"0+2+4+,0-2-4-".parse()?, Scope::All, &mut found)?;
/// let (equations, spared) = finder.at_contacts(&found.orbits[0])?.bloch_equations();
/// assert_eq!((equations.size(), spared.len()), (12, 0));
/// // A conservative orbit may begin at any time: its own derivative is a null vector of J(1).
/// let z = Complex::new(1.0, 0.0);
/// let impulses: Vec<_> = found.orbits[0].impacts().iter().map(|impact| impact.impulse).collect();
/// let matrix = equations.matrix(z);
/// for row in matrix.chunks(12) {
///     let shifted: Complex<f64> = row[1..].iter().step_by(2).zip(&impulses).map(|(entry, p)| entry * p).sum();
///     assert!(shifted.norm() < 1e-12);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct BlochEquations {
    kernel: Arc<BlochKernel>,
    impacts: Vec<LinearImpact>,
    /// ω = 2π/T
    omega: f64,
    /// Times since the impact that the period is cut before.
    since: Vec<f64>,
    /// The largest part that is left of what is taken for dead when the next period begins.
    left_out: f64,
    /// What J₀ outside changes by with the time of its row's impact by way of that; empty where all is in A_k and C_k.
    sliding: Vec<f64>,
    /// A_k and C_k: [mode][row] and [mode][column].
    rows: Vec<[f64; 2]>,
    columns: Vec<[f64; 2]>,
    /// What the errors of modes make of what dies before the next period; empty where nothing does.
    sent_errors: Vec<f64>,
    /// J₀ for R(z−R)⁻¹, of use outside the poles, and for z(z−R)⁻¹, of use inside.
    outside: Vec<f64>,
    inside: Vec<f64>,
    /// The least |p|² of a pole: inside of half of |p| the second form is taken.
    innermost: f64,
    /// Errors of g″⁻/(ωP) as they stand in J₀, where these are sums over modes.
    slide_errors: Option<Vec<f64>>,
}

impl BlochEquations {
    /// Rows and columns of J: two for each impact.
    #[inline]
    pub fn size(&self) -> usize {
        2 * self.impacts.len()
    }

    /// The impacts.
    #[inline]
    pub fn impacts(&self) -> &[LinearImpact] {
        &self.impacts
    }

    /// Times of the impacts since the one at which the period is taken to begin. It is the first impact, or, where modes die within a
    /// period, the impact after the longest flight.
    pub fn since_cut(&self) -> &[f64] {
        &self.since
    }

    /// The largest part that is left of what J takes for dead when the next period begins.
    pub fn left_out(&self) -> f64 {
        self.left_out
    }

    /// What J₀ outside changes by with the time of its row's impact by way of what dies before the next period; empty where nothing does.
    pub fn sliding(&self) -> &[f64] {
        &self.sliding
    }

    /// The kernel.
    pub fn kernel(&self) -> &BlochKernel {
        &self.kernel
    }

    /// Errors of the accelerations over ωP that J₀ holds, where they are sums over modes; `None` where they are as given.
    pub fn slide_errors(&self) -> Option<&[f64]> {
        self.slide_errors.as_deref()
    }

    /// ω = 2π/T, the unit of frequency.
    pub fn omega(&self) -> f64 {
        self.omega
    }

    /// A_k: what the equations see of the two coordinates of mode `k`.
    #[inline]
    pub fn rows(&self, k: usize) -> &[[f64; 2]] {
        &self.rows[k * self.size()..(k + 1) * self.size()]
    }

    /// C_k: what the unknowns give to them.
    #[inline]
    pub fn columns(&self, k: usize) -> &[[f64; 2]] {
        &self.columns[k * self.size()..(k + 1) * self.size()]
    }

    /// What the errors of shapes and rates make of J₀ outside by way of what dies before the next period; empty where nothing does.
    pub fn sent_errors(&self) -> &[f64] {
        &self.sent_errors
    }

    /// Error of m(1+e)⁻¹, which J₀ holds at the impact itself, by the shapes.
    pub fn hit_error(&self, impact: usize) -> f64 {
        let LinearImpact { contact, restitution, .. } = self.impacts[impact];
        self.kernel.mobility_error(contact, contact) / (1.0 + restitution)
    }

    /// Π_i(m_i(1+e_i))², by which det J(z) is det(z−M)/det(z−R).
    pub fn scale(&self) -> f64 {
        let root =
            |impact: &LinearImpact| (1.0 + impact.restitution) / self.kernel.mobility(impact.contact, impact.contact);
        self.impacts.iter().map(|impact| root(impact).powi(2)).product()
    }

    /// What rows and columns of J are to be multiplied by to have the equations and unknowns as they stand: position and Newton's law;
    /// δP and δt.
    pub fn units(&self) -> [SmallVec<[f64; 8]>; 2] {
        let rows = self.impacts.iter().flat_map(|impact| [1.0 / self.omega, 1.0 + impact.restitution]);
        let columns = self.impacts.iter().flat_map(|impact| [1.0, self.omega * impact.impulse]);
        [rows.collect(), columns.collect()]
    }
}

#[cfg(test)]
mod tests {
    use vibrochain_lattice::{Complex, ImpulseResponse, Model, Spectrum, Stop};
    use vibrochain_testkit::{Random, Ranges, Values};

    use super::*;
    use crate::motion::Motion;
    use crate::orbit::{Hit, Orbit};
    use crate::search::finder::{Finder, Scope};
    use crate::search::orbit_list::OrbitList;

    type C = Complex<f64>;

    /// Orbits of random words on random lattices, begun a little before their first impact.
    fn orbits(rounds: usize, mut check: impl FnMut(&Orbit, &mut Random)) -> usize {
        let mut random = Random(57);
        let gamma2 = Values::Log(1e-3, 0.2);
        let conservative = Ranges { sites: [1, 7], gamma2, ..Ranges::CONSERVATIVE };
        let forced = Ranges { sites: [1, 5], gamma2: Values::Log(1e-3, 0.02), ..Ranges::FORCED };
        let mut count = 0;
        for round in 0..rounds {
            let ranges = if round % 2 == 0 { &conservative } else { &forced };
            let (chain, model) = (random.lattice(ranges), random.model(ranges));
            let model = model.point().on(&chain).model().unwrap();
            let word = match round % 2 {
                // Through its text: the crate under test is another one than testkit's.
                0 => random.word(&chain).and_then(|word| word.to_string().parse().ok()),
                _ => random.of(&["0+,0-", "0-", "0-,0-", "0-1-"]).parse().ok(),
            };
            let (Some(word), mut finder, mut found) = (word, Finder::new(chain.sites()), OrbitList::default()) else {
                continue;
            };
            if finder.find_word(&model, &word, Scope::All, &mut found).is_err() {
                continue;
            }
            for orbit in found.orbits.iter().take(2) {
                let condition = finder.condition(orbit).unwrap();
                if condition.resonance < 1e-3 || condition.grazing < 1e-3 {
                    continue;
                }
                let later = 0.01 * orbit.period();
                let Ok(orbit) = repeated(orbit, 1, later) else { continue };
                check(&orbit, &mut random);
                count += 1;
            }
        }
        count
    }

    /// An orbit for so many of its periods, begun earlier.
    fn repeated(orbit: &Orbit, times: usize, earlier: f64) -> Result<Orbit, crate::BreatherError> {
        let mut hits: Vec<Hit> = (0..times)
            .flat_map(|n| {
                let shift = earlier + orbit.period() * n as f64;
                orbit.impacts().iter().map(move |impact| {
                    let time = impact.time + shift;
                    Hit { time, ..Hit::from(impact) }
                })
            })
            .collect();
        hits.sort_by(|a, b| a.time.total_cmp(&b.time));
        let psi = (orbit.psi_or_zero() - earlier).rem_euclid(orbit.model().unwrap().period());
        Orbit::from_impulses(orbit.model().unwrap(), times as u32 * orbit.force_periods(), psi, &hits)
    }

    fn equations_of(orbit: &Orbit) -> (BlochEquations, Vec<[C; 2]>) {
        orbit.at_contacts(&Stop::default()).unwrap().bloch_equations()
    }

    fn response(orbit: &Orbit) -> ImpulseResponse {
        ImpulseResponse::new(&Spectrum::new(*orbit.model().unwrap().chain()), orbit.frequency()).unwrap()
    }

    /// Position and Newton's law at all impacts.
    fn residuals(model: &Model, orbit: &Orbit, hits: &[Hit]) -> Vec<f64> {
        let moved = Orbit::from_impulses(model, orbit.force_periods(), orbit.psi_or_zero(), hits).unwrap();
        let mut motion = Motion::of(&moved).unwrap();
        let left = |(i, hit): (usize, &Hit)| {
            let (after, _) = motion.just_after(i, hit.site);
            let mean = after.velocity - 0.5 * hit.impulse;
            [after.displacement - model.barrier(hit.barrier), mean + 0.5 * model.loss() * hit.impulse]
        };
        hits.iter().enumerate().flat_map(left).collect()
    }

    #[test]
    fn at_one_it_is_the_jacobian_of_the_orbits_own_equations() {
        let (mut checked, mut crowded) = (0, 0);
        let count = orbits(160, |orbit, _| {
            let (equations, _) = equations_of(orbit);
            let (matrix, size) = (equations.matrix(C::new(1.0, 0.0)), equations.size());
            let [rows, columns] = equations.units();
            let hits: Vec<Hit> = orbit.impacts().iter().map(Hit::from).collect();
            let largest = matrix.iter().map(|entry| entry.norm()).fold(1.0, f64::max);
            for column in 0..size {
                let moved = |by: f64| {
                    let mut hits = hits.clone();
                    let hit = &mut hits[column / 2];
                    *(if column % 2 == 0 { &mut hit.impulse } else { &mut hit.time }) += by;
                    // Impacts of one instant part: their order is that of time.
                    let mut order: Vec<usize> = (0..hits.len()).collect();
                    order.sort_by(|&i, &j| hits[i].time.total_cmp(&hits[j].time));
                    let sorted: Vec<Hit> = order.iter().map(|&i| hits[i]).collect();
                    let left = residuals(orbit.model().unwrap(), orbit, &sorted);
                    let place = |i: usize| order.iter().position(|&k| k == i).unwrap();
                    (0..size).map(|row| left[2 * place(row / 2) + row % 2]).collect::<Vec<_>>()
                };
                // Where neighbours hit at one instant the equations have a kink of third order.
                let h = 1e-6;
                let (plus, minus) = (moved(h), moved(-h));
                for row in 0..size {
                    // Newton's law is q P/2 + mean velocity there: the same, over 1 + e.
                    let unit = if row % 2 == 0 { rows[row] } else { 1.0 };
                    let entry = matrix[row * size + column] * unit * columns[column];
                    let difference = (plus[row] - minus[row]) / (2.0 * h);
                    let scale = largest * (1.0 + columns[column].abs());
                    assert!(
                        (entry - difference).norm() < 1e-6 * scale,
                        "{orbit:?} {row} {column}: {entry} {difference}"
                    );
                    checked += 1;
                }
            }
            crowded += usize::from(orbit.impacts().len() > 3);
        });
        assert!(count > 60 && checked > 1500 && crowded > 10, "{count} {checked} {crowded}");
    }

    /// A perturbation that comes back times z after a period is one of three periods, for z³ = 1.
    #[test]
    fn at_roots_of_one_it_is_part_of_the_jacobian_of_several_periods() {
        let mut checked = 0;
        let count = orbits(60, |orbit, random| {
            let Ok(threefold) = repeated(orbit, 3, 0.0) else { return };
            if response(&threefold).condition() > 1e3 {
                return;
            }
            let z = C::from_polar(1.0, std::f64::consts::TAU / 3.0);
            let [(one, _), (three, _)] = [orbit, &threefold].map(equations_of);
            let (small, large) = (one.matrix(z), three.matrix(C::new(1.0, 0.0)));
            let n = one.size();
            let y: Vec<C> = (0..n).map(|_| C::new(random.unit(), random.unit())).collect();
            // Units: ω is a third.
            let scaled = |k: usize| if k.is_multiple_of(2) { 1.0 } else { 1.0 / 3.0 };
            for row in 0..n {
                let left: C = (0..n).map(|j| small[row * n + j] * y[j]).sum();
                for m in 0..3 {
                    let right: C = (0..3 * n)
                        .map(|j| large[(m * n + row) * 3 * n + j] * y[j % n] * scaled(j % n) * z.powi((j / n) as i32))
                        .sum();
                    let right = if row % 2 == 0 { right * 3.0 } else { right };
                    let scale = one.matrix(z).iter().map(|entry| entry.norm()).fold(1.0, f64::max);
                    let off = (left * z.powi(m as i32) - right).norm();
                    assert!(off < 1e-11 * scale, "{orbit:?} {row} {m}: {left} {right}");
                    checked += 1;
                }
            }
        });
        assert!(count > 20 && checked > 200, "{count} {checked}");
    }

    #[test]
    fn both_sums_agree_and_the_derivative_is_one() {
        let mut checked = 0;
        orbits(60, |orbit, random| {
            let (mut equations, _) = equations_of(orbit);
            let z = C::from_polar(random.between(0.3, 1.5), random.between(0.0, 6.3));
            let (mut here, mut slope, mut plus, mut minus) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
            equations.fill(z, &mut here, Some(&mut slope));
            let h = 1e-5;
            equations.fill(z + h, &mut plus, None);
            equations.fill(z - h, &mut minus, None);
            let size = here.iter().map(|entry| entry.norm()).fold(1.0, f64::max);
            let nearest = equations.kernel().modes().iter().flat_map(|mode| mode.poles()).map(|p| (z - p).norm());
            if nearest.fold(1.0, f64::min) < 0.05 {
                return;
            }
            for at in 0..here.len() {
                let difference = (plus[at] - minus[at]) / (2.0 * h);
                assert!((slope[at] - difference).norm() < 1e-5 * size, "{} {difference}", slope[at]);
            }
            equations.innermost = if equations.is_inside(z) { 0.0 } else { f64::INFINITY };
            equations.fill(z, &mut plus, None);
            let off = here.iter().zip(&plus).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
            assert!(off < 1e-12 * size, "{off:e} {size:e}");
            checked += 1;
        });
        assert!(checked > 20, "{checked}");
    }

    /// Next to z = 0, what an impact does to a later one of the same period vanishes like z: with damped modes, whose flights back are large,
    /// far below the rounding of its terms.
    #[test]
    fn next_to_zero_nothing_is_left_of_large_terms() {
        let mut kernel = BlochKernel::new(3.0, 2);
        kernel.push_oscillator(2.0, 0.9, &[1.0, 0.4]);
        kernel.push_oscillator(9.0, 0.3, &[0.7, -0.8]);
        let poles: Vec<f64> = kernel.modes().iter().flat_map(|mode| mode.poles()).map(|pole| pole.norm()).collect();
        let impact = |contact: usize, time: f64| LinearImpact {
            contact,
            time,
            impulse: 1.3,
            restitution: 0.8,
            acceleration_before: 0.4,
        };
        let equations = BlochEquations::new(kernel, vec![impact(0, 0.0), impact(1, 1.1)]);
        let z = C::new(1e-13, 2e-13) * poles.iter().copied().fold(1.0, f64::min);
        let [once, twice] = [1.0, 2.0].map(|by| equations.matrix(z * by));
        for entry in [2, 3].into_iter().flat_map(|row| [0, 1].map(|column| 4 * row + column)) {
            let (once, twice) = (once[entry], twice[entry]);
            assert!((twice - once * 2.0).norm() < 1e-9 * twice.norm() && twice.norm() > 0.0, "{entry}: {once} {twice}");
        }
        // Far out the sum over the past is left, alike in either form.
        let far = equations.matrix(C::new(1e12, 0.0));
        let off = far.iter().zip(equations.constant(false)).map(|(entry, constant)| (entry - constant).norm());
        assert!(off.fold(0.0, f64::max) < 1e-9);
    }

    /// Without its own derivative s: a column is J(z)s/(z−1), a row sᵀJ(z)/(z−1), their corner sᵀJ(z)s/(z−1)², all else is as it was.
    #[test]
    fn an_orbits_own_derivative_is_divided_out() {
        let mut checked = 0;
        orbits(120, |orbit, random| {
            let (equations, _) = equations_of(orbit);
            let mut without = equations.clone();
            let Some(shift) = without.leave_out_shift().filter(|_| orbit.model().unwrap().is_conservative()) else {
                return;
            };
            let (size, at) = (equations.size(), shift.place);
            for k in 0..equations.kernel().modes().len() {
                let (rows, columns) = (without.rows(k), without.columns(k));
                let before = (0..size).map(|r| (shift.row_before(rows, k, r), shift.column_before(columns, k, r)));
                assert!(shift.constant_before() == equations.constant(false));
                assert!(before.eq(equations.rows(k).iter().copied().zip(equations.columns(k).iter().copied())));
            }
            let own = |r: usize| if r % 2 == 1 { shift.weights[r / 2] } else { 0.0 };
            for radius in [0.2, 0.45, 0.9, 3.0] {
                let z = C::from_polar(radius, random.between(0.0, 6.3));
                let poles = equations.kernel().modes().iter().flat_map(|mode| mode.poles()).map(|p| (z - p).norm());
                let nearest = poles.fold((z - 1.0).norm(), f64::min);
                if nearest < 0.05 {
                    continue;
                }
                let (whole, left) = (equations.matrix(z), without.matrix(z));
                let column: Vec<C> =
                    (0..size).map(|r| (0..size).map(|j| whole[r * size + j] * own(j)).sum::<C>() / (z - 1.0)).collect();
                let row: Vec<C> =
                    (0..size).map(|j| (0..size).map(|r| whole[r * size + j] * own(r)).sum::<C>() / (z - 1.0)).collect();
                let corner = (0..size).map(|r| column[r] * own(r)).sum::<C>() / (z - 1.0);
                let scale = whole.iter().chain([&corner]).map(|entry| entry.norm()).fold(1.0, f64::max) / nearest;
                for (r, j) in (0..size).flat_map(|r| (0..size).map(move |j| (r, j))) {
                    let right = match (r == at, j == at) {
                        (true, true) => corner,
                        (true, false) => row[j],
                        (false, true) => column[r],
                        (false, false) => whole[r * size + j],
                    };
                    let off = (left[r * size + j] - right).norm();
                    assert!(off < 1e-10 * scale, "{r} {j} {z}: {} {right}", left[r * size + j]);
                    checked += 1;
                }
            }
        });
        assert!(checked > 2000, "{checked}");
    }
}
