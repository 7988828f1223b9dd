//! Energies of a structure in the coordinates ξ of its modes.

use rustfft::num_complex::Complex;

use super::linear_mode::LinearMode;
use super::modal::ModalStructure;

type C = Complex<f64>;

/// What two modes have together: ξ_iᵀBξ_j.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Block {
    /// One mode.
    pub first: usize,
    /// The other one, or the same.
    pub second: usize,
    /// B
    pub form: [[f64; 2]; 2],
}

/// Energy and powers as forms of ξ: E = ½ Σ ξᵀBξ, what dashpots take Σ ξᵀDξ, what loads give (s + Re Σ f_j e^{ijω(t+ψ)})·ξ.
#[derive(Debug, Clone, PartialEq)]
pub struct EnergyForm {
    /// B
    pub energy: Vec<Block>,
    /// D
    pub dissipation: Vec<Block>,
    /// s of each mode.
    pub still: Vec<[f64; 2]>,
    /// f of each mode and harmonic.
    pub loads: Vec<Vec<[C; 2]>>,
}

/// a bᵀ times `factor`, added.
pub(super) fn add_product(form: &mut [[f64; 2]; 2], a: [f64; 2], b: [f64; 2], factor: f64) {
    (0..2).for_each(|i| (0..2).for_each(|j| form[i][j] += factor * a[i] * b[j]));
}

impl EnergyForm {
    /// E
    pub fn energy(&self, xi: &[[f64; 2]]) -> f64 {
        0.5 * sum(&self.energy, xi)
    }

    /// The power that dashpots take.
    pub fn dissipation(&self, xi: &[[f64; 2]]) -> f64 {
        sum(&self.dissipation, xi)
    }

    /// The power that loads give where harmonic number `place` of them is entry `place` of `turned` = e^{ijω(t+ψ)}.
    pub fn power(&self, xi: &[[f64; 2]], turned: &[C]) -> f64 {
        let of_mode = |(k, xi): (usize, &[f64; 2])| {
            let load = self.loads[k].iter().zip(turned).fold(self.still[k], |sum, (load, turned)| {
                [sum[0] + (load[0] * turned).re, sum[1] + (load[1] * turned).re]
            });
            load[0] * xi[0] + load[1] * xi[1]
        };
        xi.iter().enumerate().map(of_mode).sum()
    }
}

fn sum(blocks: &[Block], xi: &[[f64; 2]]) -> f64 {
    let of_block = |block: &Block| {
        let ([a, b], [c, d], form) = (xi[block.first], xi[block.second], block.form);
        a * (form[0][0] * c + form[0][1] * d) + b * (form[1][0] * c + form[1][1] * d)
    };
    blocks.iter().map(of_block).sum()
}

impl ModalStructure {
    /// Its energies, mode by mode: each of real shape has ½(q′² + Ω²q²). `None` where a mode has a complex shape: matrices know more,
    /// `Structure::energy_form`.
    pub fn energy_form(&self) -> Option<EnergyForm> {
        if self.modes().iter().any(|mode| !mode.is_real) {
            return None;
        }
        let row = |mode: &LinearMode| [-mode.decay, mode.rate];
        let block = |k: usize, damping: f64, stiffness: f64, velocity: [f64; 2]| {
            let mut form = [[stiffness, 0.0], [0.0, 0.0]];
            add_product(&mut form, velocity, velocity, damping);
            Block { first: k, second: k, form }
        };
        let (mut energy, mut dissipation) = (Vec::new(), Vec::new());
        for (k, mode) in self.modes().iter().enumerate() {
            let square = mode.decay * mode.decay + mode.turn.sign() * mode.rate * mode.rate;
            energy.push(block(k, 1.0, square, row(mode)));
            dissipation.push(block(k, 2.0 * mode.decay, 0.0, row(mode)));
        }
        // φᵀf acts on q′.
        let still = self.modes().iter().map(|mode| row(mode).map(|row| mode.rate * mode.still[1] * row)).collect();
        let of_mode =
            |mode: &LinearMode| mode.loads.iter().map(|load| row(mode).map(|row| load[1] * mode.rate * row)).collect();
        Some(EnergyForm { energy, dissipation, still, loads: self.modes().iter().map(of_mode).collect() })
    }
}
