//! Modes of a lattice with dashpots after impulses that repeat every period: as those of any structure, each on its own.

use vibrochain_lattice::{LinearMode, ModeFlow, ModeShape, Model, Shapes, Spectrum, Turned};

use crate::structures::periodic_kernel::{rigid_jet, sum_over_periods};

/// The modes of a lattice, as impulses of one period move them.
#[derive(Debug, Clone)]
pub(crate) struct DyingModes {
    model: Model,
    period: f64,
    pub(super) shapes: Shapes,
    pub(super) frequencies: Vec<f64>,
    pub(super) decays: Vec<f64>,
    pub(super) weights: Vec<f64>,
    /// Each mode with (1−R)⁻¹; without it a rigid one.
    modes: Vec<(LinearMode, Option<Turned>)>,
}

impl DyingModes {
    /// Of the lattice of a model, after impulses of a period.
    pub(crate) fn new(model: &Model, period: f64) -> Self {
        let spectrum = Spectrum::new(*model.chain());
        let decays: Vec<f64> = spectrum.decays(model.dashpots()).collect();
        let shape = ModeShape { contacts: vec![1.0], ..ModeShape::default() };
        let mode = |(&frequency, &decay): (&f64, &f64)| {
            let ModeFlow { turn, rate, .. } = ModeFlow::oscillator(frequency, decay);
            let square = turn.sign() * rate * rate;
            // Of a rigid mode both factors are exact, and the square of neither.
            let square = if frequency == 0.0 { -decay * decay } else { square };
            let mode = LinearMode::oscillator(decay, square, &shape, &[]);
            let sum = sum_over_periods(&mode, period);
            (mode, sum)
        };
        Self {
            model: *model,
            period,
            shapes: Shapes::new(model.chain()),
            modes: spectrum.frequencies().iter().zip(&decays).map(mode).collect(),
            frequencies: spectrum.frequencies().to_vec(),
            weights: spectrum.weights().to_vec(),
            decays,
        }
    }

    /// Whether they are those of a model's lattice and of this period.
    pub(crate) fn are_of(&self, model: &Model, period: f64) -> bool {
        (self.model.chain(), self.model.dashpots(), self.period) == (model.chain(), model.dashpots(), period)
    }

    /// Adds what an impulse of every period does to all modes, weights apart, some time after it.
    pub(super) fn add_response(&self, states: &mut [(f64, f64)], impulse: f64, elapsed: f64) {
        for ((q, p), (mode, sum)) in states.iter_mut().zip(&self.modes) {
            let Some(sum) = sum else {
                let [place, velocity, ..] = rigid_jet(mode, self.period, elapsed);
                (*q, *p) = (*q + impulse * place, *p + impulse * velocity);
                continue;
            };
            let Turned { even, odd } = mode.turn.product(mode.flight(elapsed), *sum);
            let place = odd / mode.rate;
            *q += impulse * place;
            // x′ = −δx + κy
            *p += impulse * (even - mode.decay * place);
        }
    }
}
