//! Where a simulation starts: on an orbit, perhaps perturbed, or from a state file.
//!
//! A run from an orbit begins in the middle of its last flight, at a time −s before the impact at t = 0: there every mass
//! has room for a perturbation, and times agree with those of `mapgen orbit`.

use std::path::Path;

use serde::Deserialize;
use vibrochain_breather::{Motion, Orbit};
use vibrochain_floquet::{Complex, FloquetError, leading_modes};
use vibrochain_lattice::{Model, Propagator, Spectrum};

use crate::error::CliError;
use crate::schemas::{self, SIMULATE, STATE, expect};
use vibrochain_maps::numbers::plain;

/// Displacements and velocities, and what is needed to place them in time.
#[derive(Debug, Clone, PartialEq)]
pub struct Start {
    /// u_n
    pub displacement: Vec<f64>,
    /// u̇_n
    pub velocity: Vec<f64>,
    /// Phase ψ of the force at the start.
    pub psi: f64,
    /// Time of the start, 0 or negative.
    pub time: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct StateFile {
    #[serde(default, deserialize_with = "schemas::text")]
    schema: Option<String>,
    displacement: Vec<f64>,
    velocity: Vec<f64>,
    psi: Option<f64>,
}

/// The answer of a run, of which the state at its end is taken.
#[derive(Deserialize)]
struct RunFile {
    #[serde(default, deserialize_with = "schemas::text")]
    schema: Option<String>,
    state: StateFile,
}

impl Start {
    /// On an orbit, before its first impact.
    ///
    /// # Errors
    /// [`CliError::IllPosed`] if the orbit's motion is not defined.
    pub fn on(orbit: &Orbit) -> Result<Self, CliError> {
        let mut motion = Motion::of(orbit)?;
        let time = orbit.time_in_last_flight();
        motion.at(0, time);
        let masses = (0..motion.sites()).map(|n| motion.site(n));
        let (displacement, velocity) = masses.map(|mass| (mass.displacement, mass.velocity)).unzip();
        Ok(Self { displacement, velocity, psi: orbit.psi().unwrap_or(0.0) + time, time })
    }

    /// From a JSON file `{"displacement":[…],"velocity":[…],"psi":0}`, or the answer of a run; `psi` goes before that of the file.
    ///
    /// # Errors
    /// [`CliError::Request`] for a file that cannot be read or is not such an object.
    pub fn read(path: &Path, psi: Option<f64>) -> Result<Self, CliError> {
        let text = std::fs::read_to_string(path).map_err(|error| CliError::file("cannot read state", path, &error))?;
        let (state, told, wanted) = match serde_json::from_str(&text) {
            Ok(RunFile { schema, state }) => (state, schema, SIMULATE),
            Err(_) => {
                let mut state: StateFile = serde_json::from_str(&text).map_err(|error| {
                    let form = r#"give {"displacement":[…],"velocity":[…]}, one number a mass in each"#;
                    CliError::Request(format!("{}: {}; {form}", path.display(), plain(&error.to_string())))
                })?;
                let told = state.schema.take();
                (state, told, STATE)
            }
        };
        expect(path, told.as_deref(), wanted)?;
        Ok(Self {
            displacement: state.displacement,
            velocity: state.velocity,
            psi: psi.or(state.psi).unwrap_or(0.0),
            time: 0.0,
        })
    }

    /// Adds a random perturbation whose largest entry (displacements, and velocities over ω) is `size`.
    pub fn perturb_at_random(&mut self, model: &Model, size: f64, seed: u64) {
        let mut random = fastrand::Rng::with_seed(seed);
        let mut entries: Vec<f64> = (0..2 * self.displacement.len()).map(|_| 2.0 * random.f64() - 1.0).collect();
        let largest = entries.iter().fold(f64::MIN_POSITIVE, |largest: f64, x| largest.max(x.abs()));
        entries.iter_mut().for_each(|x| *x *= size / largest);
        let (u, v) = entries.split_at(self.displacement.len());
        self.displacement.iter_mut().zip(u).for_each(|(x, d)| *x += d);
        self.velocity.iter_mut().zip(v).for_each(|(x, d)| *x += model.omega() * d);
    }

    /// Adds the real part of a Floquet mode, scaled like a random perturbation.
    pub fn perturb_along(&mut self, model: &Model, size: f64, mode: &[(Complex<f64>, Complex<f64>)]) {
        let largest =
            mode.iter().map(|(u, v)| u.re.abs().max(v.re.abs() / model.omega())).fold(f64::MIN_POSITIVE, f64::max);
        for ((x, v), (du, dv)) in self.displacement.iter_mut().zip(&mut self.velocity).zip(mode) {
            *x += size / largest * du.re;
            *v += size / largest * dv.re;
        }
    }
}

/// A Floquet mode: (displacement, velocity) of each mass.
pub type ModeShape = Vec<(Complex<f64>, Complex<f64>)>;

/// The leading Floquet mode of an orbit at the time `start` ≤ 0 of a run: carried back by free flight from just before the first impact.
///
/// # Errors
/// [`FloquetError`].
pub fn leading_mode_at(orbit: &Orbit, start: f64) -> Result<ModeShape, FloquetError> {
    let failed = FloquetError::NotConverged { dimension: 0 };
    let mode = leading_modes(orbit, 1)?.into_iter().next().ok_or(failed)?;
    let flow = Propagator::new(&Spectrum::new(*orbit.model().chain()), start);
    let carry = |part: fn(&Complex<f64>) -> f64| {
        let u: Vec<f64> = mode.displacement.iter().map(part).collect();
        let v: Vec<f64> = mode.velocity.iter().map(part).collect();
        let (mut u_start, mut v_start) = (vec![0.0; u.len()], vec![0.0; u.len()]);
        flow.apply(&u, &v, &mut u_start, &mut v_start);
        (u_start, v_start)
    };
    let ((u_re, v_re), (u_im, v_im)) = (carry(|z| z.re), carry(|z| z.im));
    let complex = |re: Vec<f64>, im: Vec<f64>| re.into_iter().zip(im).map(|(re, im)| Complex::new(re, im));
    Ok(complex(u_re, u_im).zip(complex(v_re, v_im)).collect())
}
