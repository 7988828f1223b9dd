//! One mode whose state is an unknown: how it goes on from there, and from rest under loads next to it.

use smallvec::SmallVec;
use vibrochain_lattice::{Complex, LinearMode, Turned};

use super::periodic_kernel::UNIT;

type C = Complex<f64>;

/// The two coordinates of a mode.
pub(super) type State = [f64; 2];

/// A mode whose state is unknown.
#[derive(Debug, Clone)]
pub(super) struct OpenMode {
    pub(super) mode: LinearMode,
    /// 1 − R
    pub(super) one_less: Turned,
    /// Its loads next to a resonance, by frequency, with bounds of their errors.
    pub(super) loads: SmallVec<[(f64, [C; 2], f64); 1]>,
}

/// A state, and its derivatives.
pub(super) type Jet = [State; 4];

impl OpenMode {
    pub(super) fn act(&self, by: Turned, state: State) -> State {
        self.mode.turn.act(by, state)
    }

    /// Derivatives of a state that nothing acts on.
    pub(super) fn jet(&self, state: State) -> Jet {
        let mut jet = [state; 4];
        for order in 1..4 {
            jet[order] = self.act(self.mode.generator(), jet[order - 1]);
        }
        jet
    }

    /// What the loads make of rest at 0 by the time `t`, and how that changes with ψ.
    pub(super) fn driven(&self, t: f64, psi: f64) -> [Jet; 2] {
        let (mut moved, mut slopes) = ([[0.0; 2]; 4], [[0.0; 2]; 4]);
        for &(w, load, _) in &self.loads {
            let phase = C::from_polar(1.0, w * psi);
            let motions = self.driven_jet(w, load.map(|entry| entry * phase), t);
            for (order, motion) in motions.into_iter().enumerate() {
                for side in 0..2 {
                    moved[order][side] += motion[side].re;
                    slopes[order][side] += (motion[side] * C::new(0.0, w)).re;
                }
            }
        }
        [moved, slopes]
    }

    /// What a load Le^{iwt} makes of rest at 0 by the time `t`, and its derivatives.
    pub(super) fn driven_jet(&self, w: f64, load: [C; 2], t: f64) -> [[C; 2]; 4] {
        let (turn, generator) = (self.mode.turn, self.mode.generator().complex());
        let mut motion = turn.act(from_rest(&self.mode, w, t), load);
        let mut push = load.map(|entry| entry * C::from_polar(1.0, w * t));
        [(); 4].map(|()| {
            let own = motion;
            let next = turn.act(generator, motion);
            motion = [0, 1].map(|side| next[side] + push[side]);
            push = push.map(|entry| entry * C::new(0.0, w));
            own
        })
    }

    /// How much larger than rounding of a number those of a flight of the time `t` are.
    pub(super) fn blur(&self, t: f64) -> f64 {
        1.0 + (self.mode.decay.abs() + self.mode.rate) * t
    }

    /// Sizes of the terms of the driven motion at `t`, with what rounding makes of them.
    pub(super) fn driven_size(&self, t: f64, psi: f64) -> f64 {
        let size = |(w, load, error): &(f64, [C; 2], f64)| {
            let load = load[0].norm() + load[1].norm();
            t * (load * (self.blur(t) + w * (t + psi.abs())) + error / UNIT)
        };
        self.loads.iter().map(size).sum()
    }
}

/// (e^{iwt} − e^{At})(iw−A)⁻¹, which is smooth where iw is a pole.
fn from_rest(mode: &LinearMode, w: f64, t: f64) -> Turned<C> {
    let of_pole = |pole: C| {
        // e^{at} sinh(bt)/b with the mean a of both and half their distance b.
        let (mean, half) = ((C::new(0.0, w) + pole) * 0.5, (C::new(0.0, w) - pole) * 0.5);
        let beat = if half.norm() * t < 1e-8 { C::new(t, 0.0) } else { (half * t).sinh() / half };
        (mean * t).exp() * beat
    };
    let [first, second] = mode.rates().map(of_pole);
    let root = mode.turn.root();
    Turned { even: (first + second) * 0.5, odd: (first - second) / (root * 2.0) }
}
