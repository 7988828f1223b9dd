//! Where a simulation starts: on an orbit, perhaps perturbed ([`Start`]), or from a state file.

use std::io::Read;
use std::path::Path;

use serde::Deserialize;
use vibrochain_breather::Orbit;
pub use vibrochain_fate::{ModeShape, Start};
use vibrochain_floquet::{Complex, FloquetError, leading_modes_until};
use vibrochain_lattice::{Propagator, Spectrum, Stop};

use crate::common::error::CliError;
use crate::common::schemas::{self, STATE, expect};
use vibrochain_maps::numbers::plain;
use vibrochain_maps::text::read_text;

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

/// The most bytes of a state.
const MOST_BYTES: u64 = 64 << 20;

/// A state that is in no file.
pub(crate) enum NoFile<'a> {
    Inline(&'a str),
    StandardInput,
}

/// Where the state is that --state names, if not in a file: no name of one begins with a brace.
pub(crate) fn of_no_file(path: &Path) -> Option<NoFile<'_>> {
    match path.to_str()? {
        "-" => Some(NoFile::StandardInput),
        text => text.trim_start().starts_with('{').then_some(NoFile::Inline(text)),
    }
}

/// A state from a JSON file `{"displacement":[…],"velocity":[…],"psi":0}`, or the answer of a `run`, by what that names in its first
/// key; `psi` goes before that of the file.
///
/// # Errors
/// [`CliError::Request`] for a file that cannot be read or is not such an object.
pub fn read(path: &Path, run: &str, psi: Option<f64>) -> Result<Start, CliError> {
    let (text, path) = match of_no_file(path) {
        Some(NoFile::Inline(text)) => (text.to_owned(), Path::new("--state")),
        Some(NoFile::StandardInput) => {
            let mut text = String::new();
            let read = std::io::stdin().lock().take(MOST_BYTES + 1).read_to_string(&mut text);
            read.map_err(|error| CliError::file("cannot read state", path, &error))?;
            ensure!(text.len() as u64 <= MOST_BYTES, "the state has more than the {MOST_BYTES} bytes that it may have");
            (text, Path::new("standard input"))
        }
        None => (read_text("state", path, MOST_BYTES)?, path),
    };
    let (state, told, wanted) = match serde_json::from_str(&text) {
        Ok(RunFile { schema, state }) => (state, schema, run),
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
    Ok(Start {
        displacement: state.displacement,
        velocity: state.velocity,
        psi: psi.or(state.psi).unwrap_or(0.0),
        time: 0.0,
    })
}

/// The leading Floquet mode of an orbit at the time `start` ≤ 0 of a run: carried back by free flight from just before the first impact.
/// Not waited for once `stop` is raised.
///
/// # Errors
/// [`FloquetError`].
pub fn leading_mode_at(orbit: &Orbit, start: f64, stop: &Stop) -> Result<ModeShape, FloquetError> {
    let failed = FloquetError::NotConverged { dimension: 0 };
    let mode = leading_modes_until(orbit, 1, stop)?.into_iter().next().ok_or(failed)?;
    let model = orbit.lattice()?.model();
    let flow = Propagator::with_dashpots(&Spectrum::new(*model.chain()), model.dashpots(), start);
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
