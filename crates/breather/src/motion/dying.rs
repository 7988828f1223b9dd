//! Modes of a lattice with dashpots after impulses that repeat every period: as those of any structure, each on its own.

use vibrochain_lattice::{ModeFlow, Model, Spectrum, Turn, Turned};

use crate::structures::periodic_kernel::{inverse, rigid_jet};

/// The modes of a lattice, as impulses of one period move them.
#[derive(Debug, Clone)]
pub(crate) struct DyingModes {
    model: Model,
    period: f64,
    spectrum: Spectrum,
    pub(super) decays: Vec<f64>,
    /// Each mode with (1−R)⁻¹; without it a rigid one.
    modes: Vec<(ModeFlow, Option<Turned>)>,
}

impl DyingModes {
    /// Of the lattice of a model, after impulses of a period.
    pub(crate) fn new(model: &Model, period: f64) -> Self {
        let spectrum = Spectrum::new(*model.chain());
        let mut modes = Self { model: *model, period, spectrum, decays: Vec::new(), modes: Vec::new() };
        modes.work_out();
        modes
    }

    /// The same of another model, or of another period, in the same room.
    pub(super) fn reset(&mut self, model: &Model, period: f64) {
        let is_known = |known: &Model| (known.chain(), known.dashpots()) == (model.chain(), model.dashpots());
        if is_known(&self.model) && self.period == period {
            return;
        }
        if self.model.chain() != model.chain() {
            self.spectrum.reset(*model.chain());
        }
        (self.model, self.period) = (*model, period);
        self.work_out();
    }

    fn work_out(&mut self) {
        let Self { model, period, spectrum, decays, modes } = self;
        decays.clear();
        decays.extend(spectrum.decays(model.dashpots()));
        let mode = |(&frequency, &decay): (&f64, &f64)| {
            let flow = ModeFlow::oscillator(frequency, decay);
            (flow, (frequency > 0.0).then(|| inverse(flow, *period).0))
        };
        modes.clear();
        modes.extend(spectrum.frequencies().iter().zip(&*decays).map(mode));
    }

    /// Ω of each.
    pub(super) fn frequencies(&self) -> &[f64] {
        self.spectrum.frequencies()
    }

    /// What their shapes lack to be those of a kernel.
    pub(super) fn weights(&self) -> &[f64] {
        self.spectrum.weights()
    }

    /// Adds what an impulse of every period does to all modes, weights apart, some time after it.
    pub(super) fn add_response(&self, states: &mut [(f64, f64)], impulse: f64, elapsed: f64) {
        let flights = Turn::flights(self.modes.iter().map(|(flow, _)| *flow), elapsed);
        for (((q, p), (flow, sum)), flight) in states.iter_mut().zip(&self.modes).zip(flights) {
            let Some(sum) = sum else {
                let [place, velocity, ..] = rigid_jet(flow.decay, self.period, elapsed);
                (*q, *p) = (*q + impulse * place, *p + impulse * velocity);
                continue;
            };
            let Turned { even, odd } = flow.turn.product(flight, *sum);
            let place = odd / flow.rate;
            *q += impulse * place;
            // x′ = −δx + κy
            *p += impulse * (even - flow.decay * place);
        }
    }
}
