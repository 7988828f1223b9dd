//! Forces of several harmonics on the command line and in files.

use vibrochain_lattice::{Force, Harmonic, Model};

/// Reads a force as `--force` gives it, `number:amplitude[:phase]` for each harmonic, with commas between.
///
/// # Errors
/// What is wrong with it, and with which harmonic.
///
/// ```
/// use vibrochain_maps::force::parse;
/// let force = parse("1:0.1:0,3:-0.03").unwrap();
/// assert_eq!(force.to_string(), "1:0.1:0,3:-0.03:0");
/// assert!(parse("1:0.1:0,2:0.03").unwrap_err().contains("harmonic = 2"));
/// ```
pub fn parse(text: &str) -> Result<Force, String> {
    let harmonics = text.split(',').map(harmonic).collect::<Result<Vec<_>, _>>()?;
    Force::new(&harmonics).map_err(|error| error.to_string())
}

fn harmonic(text: &str) -> Result<Harmonic, String> {
    let wrong = |what: &str| format!("`{text}` has {what}: give number:amplitude:phase, as in 1:0.1:0,3:0.03:1.57");
    let parts: Vec<&str> = text.split(':').map(str::trim).collect();
    let (number, amplitude, phase) = match parts[..] {
        [number, amplitude] => (number, amplitude, "0"),
        [number, amplitude, phase] => (number, amplitude, phase),
        _ => return Err(wrong("not two or three parts")),
    };
    Ok(Harmonic {
        number: number.parse().map_err(|_| wrong("no whole number in front"))?,
        amplitude: amplitude.parse().map_err(|_| wrong("an amplitude that is no number"))?,
        phase: phase.parse().map_err(|_| wrong("a phase that is no number"))?,
    })
}

/// Force and restitution for captions; nothing for a conservative model.
pub fn caption(model: &Model) -> Vec<String> {
    let force = match model.force().cosine_amplitude() {
        _ if model.is_conservative() => return Vec::new(),
        Some(_) => format!("A = {}", model.amplitude()),
        None => format!("force {}", model.force()),
    };
    vec![force, format!("e = {}", model.restitution())]
}
