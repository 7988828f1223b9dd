//! Zeros where poles nearly coincide: what lies between two of them is below rounding, so that they are sought with each cluster of modes as
//! one. The contacts feel as many combinations of a cluster as they can; the multipliers of all others lie within it.

use vibrochain_breather::BlochEquations;
use vibrochain_lattice::ModeCluster;

use super::refine::Origin;
use super::solve::{Zeros, zeros_apart};
use super::zero::Zero;

/// Ways between neighbours of a cluster, as parts of their rates, one after the other until all is told apart.
const GAPS: [f64; 4] = [1e-13, 1e-11, 1e-9, 1e-7];

/// Two this many errors apart do not meet.
const ROOM: f64 = 4.0;

/// All multipliers of the modes that feel the impacts, but the trivial pair of a conservative orbit.
pub(crate) fn zeros(equations: &BlochEquations, conservative: bool, data: &[Origin]) -> Zeros {
    let apart = zeros_apart(equations, conservative, data);
    let merged = if apart.certified { None } else { of_clusters(equations, conservative, data) };
    merged.unwrap_or(apart)
}

/// All zeros with clusters as modes; `None` where they are not told apart either.
fn of_clusters(equations: &BlochEquations, conservative: bool, data: &[Origin]) -> Option<Zeros> {
    let mut before = 0;
    GAPS.into_iter().find_map(|gap| {
        let (kernel, clusters) = equations.kernel().clustered(gap)?;
        let left = clusters.iter().map(|cluster| cluster.count).sum();
        if std::mem::replace(&mut before, left) == left {
            return None;
        }
        let impacts = equations.impacts().to_vec();
        let merged = if conservative {
            BlochEquations::conservative(kernel, impacts)
        } else {
            BlochEquations::new(kernel, impacts)
        };
        let mut all = zeros_apart(&merged, conservative, data);
        if !all.certified {
            return None;
        }
        let within: Vec<Zero> = clusters.iter().flat_map(|cluster| left_of(cluster, &all)).collect();
        all.list.extend(within);
        Some(all)
    })
}

/// The zeros that a cluster's combinations have which no contact feels.
fn left_of(cluster: &ModeCluster, felt: &Zeros) -> Vec<Zero> {
    let ModeCluster { poles, width, count } = *cluster;
    if !felt.reciprocal {
        return poles.map(|pole| vec![Zero { error: width, ..Zero::new(pole, true) }; count]).concat();
    }
    // All have one signature: none leaves the circle without one that has the other.
    let zero = Zero::of_pair(poles[0], [width; 2], true);
    let meets = |other: &Zero| (other.nu.complex() - zero.nu.complex()).norm() <= ROOM * (other.error + zero.error);
    let inside = zero.nu.below.max(-zero.nu.above) < -ROOM * zero.error;
    let held = inside && !felt.list.iter().any(meets);
    vec![Zero { held, settled: held, ..zero }; count]
}

#[cfg(test)]
mod tests {
    use vibrochain_breather::{Finder, LinearImpact, OrbitList, Scope, Word};
    use vibrochain_lattice::{BlochKernel, Chain, Ends};

    use super::*;
    use crate::analyser::Analyser;
    use crate::verdict::{Method, Tolerance};

    /// Masses that hardly feel each other, and the slowest modes of a long row: against the eigenvalues of a matrix.
    #[test]
    fn multipliers_next_to_a_cluster_are_told_with_its_width() {
        let (mut checked, mut clustered, mut lossless, mut several) = (0, 0, 0, 0);
        let ring = |sites: usize, gamma2: f64| Chain::new(sites, 0.2, gamma2).unwrap();
        for chain in [ring(21, 8e-13), ring(21, 1e-11), ring(40, 3e-12), ring(9, 1e-12).with_ends(Ends::Free)] {
            for (word, omega, amplitude, e) in [
                ("2-", 0.8, 0.0, 1.0),
                ("2+,2-", 1.5, 0.0, 1.0),
                ("2-", 0.92, 0.1, 0.9),
                ("2+,2-", 1.5, 0.1, 0.9),
                ("2-,2-", 1.5, 0.3, 0.9),
                ("2-3-", 0.92, 0.1, 0.9),
                ("2+3-,2-3+", 1.5, 0.1, 0.9),
                ("2-3-", 0.8, 0.0, 1.0),
            ] {
                let point = chain.point().omega(omega).asymmetry(0.4);
                let model = point.amplitude(amplitude).restitution(e).model().unwrap();
                let (mut finder, mut found) = (Finder::new(chain.sites()), OrbitList::default());
                let word: Word = word.parse().unwrap();
                if finder.find_word(&model, &word, Scope::All, &mut found).is_err() {
                    continue;
                }
                for orbit in found.orbits.iter().take(2) {
                    let conservative = orbit.model().unwrap().is_conservative();
                    let (equations, _) = finder.at_contacts(orbit).unwrap().bloch_equations();
                    let all = zeros_apart(&equations, conservative, &[]);
                    let merged = if all.certified { None } else { of_clusters(&equations, conservative, &[]) };
                    let name = format!("{word} {model}");
                    let told = Analyser::default().stability(orbit, &mut finder, Tolerance::Rounding).unwrap();
                    let expected = Analyser::dense().stability(orbit, &mut finder, Tolerance::Rounding).unwrap();
                    // What is left open between two free phases a matrix may decide.
                    let method = told.verdict.method;
                    let by_matrix = orbit.impact_site().is_none() && conservative && method == Method::Dense;
                    assert!(method == Method::Secular || by_matrix, "{name}: {method:?}");
                    assert_eq!(told.multipliers.len(), expected.multipliers.len(), "{name}");
                    let room = 4.0 * (told.verdict.resolution + expected.verdict.resolution) + 1e-14;
                    let off = (told.verdict.excess() - expected.verdict.excess()).abs();
                    assert!(off <= room, "{name}: {:?} {:?}", told.verdict, expected.verdict);
                    if !told.verdict.undecided && !expected.verdict.undecided {
                        assert_eq!(told.verdict.stable, expected.verdict.stable, "{name}");
                    }
                    for zero in merged.iter().flat_map(|merged| &merged.list) {
                        let (both, error) = if all.reciprocal {
                            // In the plane of μ, where those next to ±1 are told by roots.
                            let error = zero.nu.excess_error(zero.nu.excess(), 10.0 * zero.error);
                            (zero.nu.multipliers().to_vec(), error)
                        } else {
                            (vec![zero.z], 10.0 * zero.error)
                        };
                        for z in both {
                            let off =
                                expected.multipliers.iter().map(|mu| (mu - z).norm()).fold(f64::INFINITY, f64::min);
                            assert!(off <= error + 1e-13 * z.norm(), "{name}: {z} {off:e} {zero:?}");
                        }
                    }
                    checked += 1;
                    clustered += usize::from(merged.is_some());
                    lossless += usize::from(merged.is_some() && all.reciprocal);
                    several += usize::from(merged.is_some() && orbit.impact_site().is_none());
                }
            }
        }
        assert!(clustered > 15 && lossless > 4 && several > 2, "{checked} {clustered} {lossless} {several}");
    }

    /// The slowest 50 modes of a row of 40 000 masses, of which an impact in its middle feels each second one.
    #[test]
    fn the_slowest_modes_of_a_long_row_are_told_apart() {
        let (masses, mut certified) = (40_000_u32, 0);
        for (gamma2, damping, period) in [(0.1, 0.0, 4.2), (0.1, 1e-3, 4.2), (0.01, 0.0, 6.8), (0.01, 0.02, 9.1)] {
            let mut kernel = BlochKernel::new(period, 1);
            for k in (1..=50_u32).step_by(2) {
                let turn = std::f64::consts::FRAC_PI_2 * f64::from(k) / f64::from(masses + 1);
                let frequency = (0.2 + 4.0 * gamma2 * turn.sin().powi(2)).sqrt();
                let shape = (2.0 / f64::from(masses + 1)).sqrt() * (turn * f64::from(masses)).sin();
                kernel.push_oscillator(frequency, damping / frequency, &[shape]);
            }
            let impact =
                LinearImpact { contact: 0, time: 0.0, impulse: -700.0, restitution: 0.9, acceleration_before: 0.3 };
            let equations = BlochEquations::new(kernel, vec![impact]);
            let all = zeros(&equations, false, &[]);
            certified += usize::from(all.certified && all.list.len() == 50);
        }
        assert_eq!(certified, 4);
    }
}
