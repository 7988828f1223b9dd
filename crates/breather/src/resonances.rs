//! Where a branch meets a resonance.

use vibrochain_lattice::{Model, Parameter, Resonance, Spectrum};

use crate::branch::Branch;

impl Branch {
    /// The first resonance as the parameter goes from one value to another, and the value where it is: a harmonic of the
    /// orbit's frequency on a mode.
    pub fn resonance_within(&self, from: f64, to: f64) -> Option<(f64, Resonance)> {
        if !matches!(self.free, Parameter::Gamma1 | Parameter::Gamma2 | Parameter::Gamma3 | Parameter::Omega) {
            return None;
        }
        let periods = f64::from(self.origin.force_periods());
        let of = |model: &Model| (Spectrum::new(*model.chain()), model.omega() / periods);
        let model = |value: f64| self.origin.model().with(self.free, value).ok();
        let ((first, omega), (last, last_omega)) = (of(&model(from)?), of(&model(to)?));
        let mut nearest: Option<(f64, Resonance)> = None;
        for (mode, (start, end)) in first.frequencies().iter().zip(last.frequencies()).enumerate() {
            let (start, end) = ((start / omega).floor(), (end / last_omega).floor());
            if start == end {
                continue;
            }
            let harmonic = if end > start { start + 1.0 } else { start };
            if harmonic < 1.0 {
                continue;
            }
            let (mut low, mut high) = (from, to);
            let mut hit = None;
            for _ in 0..100 {
                let middle = 0.5 * (low + high);
                let Some(model) = model(middle) else { break };
                let (spectrum, omega) = of(&model);
                let frequency = spectrum.frequencies().get(mode).copied().unwrap_or_default();
                let distance = (-harmonic).mul_add(omega, frequency);
                hit = Some((middle, Resonance { harmonic: harmonic as u64, mode, frequency, omega, distance }));
                if ((frequency / omega).floor() - start).abs() < 0.5 { low = middle } else { high = middle }
            }
            let closer = |(value, _): &(f64, Resonance)| {
                nearest.as_ref().is_none_or(|(old, _)| (value - from).abs() < (old - from).abs())
            };
            if hit.as_ref().is_some_and(closer) {
                nearest = hit;
            }
        }
        nearest
    }
}
