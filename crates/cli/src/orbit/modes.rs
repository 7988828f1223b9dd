//! The modes of the lattice about a conservative orbit: signatures, residues, the frequencies to which the breather shifts them,
//! and which of them have collided.

use std::fmt;

use serde::Serialize;
use serde_json::{Value, json};
use vibrochain_breather::{Finder, Orbit};
use vibrochain_floquet::{
    Collision, Complex, DressedModes, InternalMode, Secular, Signature, bare_signature, participating_modes,
};

/// The most modes of which signatures are told: each asks all others, all together half a second.
const MOST_SIGNED: usize = 1025;

/// One mode that feels the impacts, by rising frequency: on a ring one that is even about the site that is hit.
#[derive(Debug, Clone, Copy, Serialize)]
pub(super) struct ModeAnswer {
    mode: usize,
    frequency: f64,
    /// That of Ω_k.
    bare_signature: Option<Signature>,
    /// R_k; not known where the residues fail their certificates.
    residue: Option<f64>,
    /// Ω̃_k, above this mode and below the next one.
    dressed: Option<f64>,
    /// That of the multiplier of Ω̃_k.
    signature: Option<Signature>,
}

/// All of them.
#[derive(Debug, Clone)]
pub(crate) struct OrbitModes {
    /// How many there are.
    count: usize,
    /// Each of them, unless nothing is told of any.
    pub(super) modes: Vec<ModeAnswer>,
    internal: Option<InternalMode>,
    internal_signature: Option<Signature>,
    pub(super) collision: Option<Collision>,
    omega: f64,
}

impl OrbitModes {
    /// For a conservative orbit that is its own mirror image in time; `leading` is its multiplier off the circle, if it has
    /// one. Unless they are `listed` only the signatures of single modes are told, and nothing else of them is worked out.
    pub(crate) fn of(orbit: &Orbit, finder: &mut Finder, leading: Option<Complex<f64>>, listed: bool) -> Option<Self> {
        let site = orbit.impact_site().filter(|_| orbit.is_reversible())?;
        let felt = participating_modes(orbit.model()?.chain(), site);
        let stop = finder.stop().clone();
        let prepared = finder.prepared(orbit).ok()?;
        let response = prepared.response();
        let mut dressed = DressedModes::default();
        dressed.replace(prepared).ok()?;
        let mut secular = Secular::default();
        let signed = felt.len() <= MOST_SIGNED;
        let certain = (listed || signed) && secular.replace(prepared).is_ok();
        let mut residues = vec![None; if listed { response.modes() } else { 0 }];
        let form = secular.residues();
        for (place, residue) in form.residues().iter().enumerate().filter(|_| listed && certain) {
            if let Some(entry) = form.mode(place).and_then(|mode| residues.get_mut(mode)) {
                *entry = Some(*residue);
            }
        }
        let mut signatures = Vec::new();
        if certain
            && signed
            && let Ok((roots, _)) = secular.roots()
        {
            signatures = dressed.signatures(&*orbit.at_contacts(&stop).ok()?, roots);
        }
        let signature = |k: usize| signatures.get(k).copied().flatten();
        let internal = dressed.internal_mode().copied();
        let count = felt.len();
        let last = count.saturating_sub(1);
        let told = if listed || signed { felt } else { Vec::new() };
        let modes = told
            .iter()
            .enumerate()
            .map(|(k, &(mode, frequency))| ModeAnswer {
                mode: k,
                frequency,
                bare_signature: if listed { bare_signature(response, mode) } else { None },
                residue: residues.get(mode).copied().flatten(),
                dressed: if listed && k < last { dressed.frequency(k) } else { None },
                signature: if k == last { None } else { signature(k) },
            })
            .collect();
        let collision = leading.and_then(|leading| dressed.collision(leading));
        let omega = response.omega();
        // At −1 it is its own mirror image.
        let internal_signature = internal.and_then(|mode| mode.signature(omega)).and_then(|_| signature(last));
        Some(Self { count, modes, internal, internal_signature, collision, omega })
    }

    /// The mode that the breather has drawn out of the band. Above it there is no other: its number is that of the last mode.
    pub(super) fn internal(&self) -> Option<Value> {
        let InternalMode { frequency, loss } = self.internal?;
        let (mode, signature) = (self.count - 1, self.internal_signature);
        Some(json!({ "mode": mode, "frequency": frequency, "signature": signature, "loss": loss }))
    }
}

/// "signatures of modes: 0–6 +, 7–10 −", the internal mode, and the collision.
impl fmt::Display for OrbitModes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sign = |mode: &ModeAnswer| match mode.signature {
            Some(Signature::Positive) => "+",
            Some(Signature::Negative) => "−",
            None => "none",
        };
        let (mut runs, mut first) = (Vec::new(), 0);
        // Above the last mode there is none.
        let between = self.modes.split_last().map_or(&[][..], |(_, between)| between);
        for run in between.chunk_by(|a, b| a.signature == b.signature) {
            let last = first + run.len() - 1;
            let range = if first == last { first.to_string() } else { format!("{first}–{last}") };
            runs.push(format!("{range} {}", run.first().map_or("", sign)));
            first = last + 1;
        }
        if self.modes.is_empty() && self.count > 1 {
            runs.push(format!("0–{} none", self.count - 2));
        }
        match runs.as_slice() {
            [] => write!(f, "no mode beside the breather")?,
            runs => write!(f, "signatures of modes: {}", runs.join(", "))?,
        }
        if let Some(mode) = self.internal {
            let sign = match self.internal_signature {
                Some(Signature::Positive) => " +",
                Some(Signature::Negative) => " −",
                None => "",
            };
            write!(f, "; the internal mode at {}{sign}", mode.frequency)?;
        }
        let Some(collision) = self.collision else { return Ok(()) };
        let ((k, l), harmonic) = (collision.modes, collision.harmonic);
        let which = match (k, l) {
            _ if l + 1 < self.count && k < l => format!("modes {k} and {l}"),
            _ if l + 1 < self.count => format!("mode {k} with itself"),
            _ if k < l => format!("mode {k} and the internal mode"),
            _ => "the internal mode with itself".to_owned(),
        };
        let times = if harmonic == 1 { "ω".to_owned() } else { format!("{harmonic}ω") };
        write!(f, "; collided: {which}, their frequencies sum to {times} = {}", harmonic as f64 * self.omega)?;
        match collision.detuning {
            Some(detuning) => write!(f, " {} {:.1e}", if detuning < 0.0 { '−' } else { '+' }, detuning.abs()),
            None => Ok(()),
        }
    }
}
