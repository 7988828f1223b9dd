//! The printed monodromy matrix against differences of the simulated return map, on a ring of five masses.

use vibrochain_breather::{Family, LatticeOrbit, breathers};
use vibrochain_floquet::{DMatrix, eigenvalues, saltations};
use vibrochain_lattice::{Chain, Propagator, Spectrum};

use crate::errata::{Correction, computation};
use crate::validate::ReturnMap;
use vibrochain_cli::common::error::CliError;

/// One factor of a monodromy matrix.
enum Factor<'a> {
    Flight(&'a Propagator),
    /// κ and e of an impact of site 0.
    Impact(f64, f64),
}

/// The matrix that applies the factors in order of time, row by row; displacements first.
fn product(sites: usize, factors: &[Factor<'_>]) -> Vec<f64> {
    let size = 2 * sites;
    let mut matrix = vec![0.0; size * size];
    for column in 0..size {
        let mut state = vec![0.0; size];
        state[column] = 1.0;
        for factor in factors {
            match factor {
                Factor::Flight(flow) => {
                    let (u, v) = state.split_at(sites);
                    let (mut u_after, mut v_after) = (vec![0.0; sites], vec![0.0; sites]);
                    flow.apply(u, v, &mut u_after, &mut v_after);
                    u_after.extend(v_after);
                    state = u_after;
                }
                Factor::Impact(kappa, e) => {
                    (state[0], state[sites]) = (-e * state[0], kappa * state[0] - e * state[sites]);
                }
            }
        }
        for (row, value) in state.iter().enumerate() {
            matrix[row * size + column] = *value;
        }
    }
    matrix
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// All corrections of matrices.
pub(super) fn corrections() -> Result<Vec<Correction>, CliError> {
    let chain = Chain::new(5, 0.2, 0.1)?;
    let model = chain.point().omega(1.5).asymmetry(0.4).amplitude(0.1).restitution(0.9).model()?;
    let found = breathers(&model, Family::DoubleSided).map_err(computation)?.orbits;
    let orbit = found.first().ok_or_else(|| computation("no forced orbit"))?;
    let map = ReturnMap::new(orbit)?;
    let truth = map.jacobian()?;

    let spectrum = Spectrum::new(chain);
    let (phi, lead) = (orbit.phi().unwrap_or(0.0), map.lead());
    let flight = |time: f64| Propagator::new(&spectrum, time);
    let (to_first, first, second, back) = (flight(lead), flight(phi), flight(orbit.period() - phi), flight(-lead));
    let kappas: Vec<f64> = saltations(orbit).map_err(computation)?.map(|saltation| saltation.kappa).collect();
    let e = model.restitution();
    let &[at_upper, at_lower] = kappas.as_slice() else {
        return Err(computation("a forced orbit without two impacts"));
    };
    let matrix = |kappas: [f64; 2], flights: [&Propagator; 2]| {
        let factors = [
            Factor::Flight(&to_first),
            Factor::Impact(kappas[0], e),
            Factor::Flight(flights[0]),
            Factor::Impact(kappas[1], e),
            Factor::Flight(flights[1]),
            Factor::Flight(&back),
        ];
        distance(&product(chain.sites(), &factors), &truth)
    };
    let kappas = [at_upper, at_lower];
    let mended = matrix(kappas, [&first, &second]);
    let reduced = reduced_kappas(orbit.lattice()?, kappas);

    // With +K the free flight has multipliers e^{±ΩT}.
    let (top, whole) = (spectrum.band().1, flight(model.period()));
    Ok(vec![
        Correction {
            place: "matrix Ã of the equations of motion",
            printed: "+K",
            holds: "−K",
            measure: "modulus 1 of the multipliers of free flight over T",
            errors: (
                (top * model.period()).exp() - 1.0,
                modulus_error(&product(chain.sites(), &[Factor::Flight(&whole)]))?,
            ),
        },
        Correction {
            place: "monodromy matrix",
            printed: "L₁S₁L₂S₂",
            holds: "L₂S₁L₁S₂ in order of time (same eigenvalues, other eigenvectors)",
            measure: "entries, against differences of the simulated map",
            errors: (matrix(kappas, [&second, &first]), mended),
        },
        Correction {
            place: "saltation, forced: Δ",
            printed: "ü₀ of the reduced system",
            holds: "v̈₀ of the whole, force included",
            measure: "entries, against differences of the simulated map",
            errors: (matrix(reduced, [&first, &second]), mended),
        },
    ])
}

/// How far eigenvalues are from the unit circle at most.
fn modulus_error(matrix: &[f64]) -> Result<f64, CliError> {
    let size = matrix.len().isqrt();
    let mut values = Vec::new();
    eigenvalues(&DMatrix::from_row_slice(size, size, matrix), &mut values).map_err(computation)?;
    Ok(values.iter().map(|value| (value.norm() - 1.0).abs()).fold(0.0, f64::max))
}

/// κ with the acceleration of the system without force, u = v − G.
fn reduced_kappas(orbit: LatticeOrbit<'_>, mut kappas: [f64; 2]) -> [f64; 2] {
    let (w, e, psi) = (orbit.model().omega(), orbit.model().restitution(), orbit.psi().unwrap_or(0.0));
    let uniform = |t: f64| -orbit.force_response() * w * w * (w * (t + psi)).cos();
    for (kappa, impact) in kappas.iter_mut().zip(orbit.impacts()) {
        *kappa -= (1.0 + e) * uniform(impact.time) / impact.velocity_before;
    }
    kappas
}
