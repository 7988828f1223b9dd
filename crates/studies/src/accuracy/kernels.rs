//! Suite `kernels`: χ₁, χ₂, χ₃ by the series, by the series without its tail, and in closed form.

use std::hint::black_box;

use vibrochain_lattice::{Chain, ImpulseResponse, Spectrum};
use vibrochain_truth::{DEFAULT_BITS, Kernel, Real};

use crate::accuracy::meter::Meter;
use crate::accuracy::series::{Chi, MOST_TAILS, Series};
use crate::accuracy::table::{Row, Table};
use crate::accuracy::{Suite, computation};
use vibrochain_cli::common::error::CliError;

pub(super) const SUITE: Suite = Suite {
    name: "kernels",
    title: "Kernels of the impulse response",
    prose: "The three numbers on which every breather depends, χ₁(φ), χ₂ and χ₃(φ), at φ = 0.3 T: at the paper's defaults (N \
            = 20, γ₁ = 0.2, γ₂ = 0.1, ω = 1.5), with stiff coupling (γ₂ = 20, ω = 1.3), and at a low frequency (ω = 0.11). \
            The truth is the same sum over modes in 57 digits.\n\n- *series*: the paper's Fourier series of J \
            harmonics;\n- *series, leading tail summed*: with Σ 1/j² in closed form;\n- *harmonics, four tails summed*: \
            with four powers of 1/j²;\n- *closed form*: one sine a mode, what the program uses.\n\nThe plain series errs \
            by 0.4/J in χ₂, 2e-4 with the paper's 2000 harmonics. Four powers of its tail correct that where the band lies \
            below ω. The closed form has all the digits that the parameters define, in \
            about the time of ten harmonics.",
    error: "absolute error of the kernel",
    run,
};

/// γ₁, γ₂ and ω; N = 20.
const CHAINS: [(&str, f64, f64, f64); 3] =
    [("defaults", 0.2, 0.1, 1.5), ("stiff coupling", 0.2, 20.0, 1.3), ("low frequency", 0.2, 0.1, 0.11)];

const SITES: usize = 21;

fn run(meter: &mut Meter<'_>) -> Result<Table, CliError> {
    let quick = meter.is_quick();
    let plain: &[u32] = if quick { &[10, 100, 2000] } else { &[10, 100, 1000, 2000, 10_000, 100_000, 1_000_000] };
    let leading: &[u32] = if quick { &[10, 100] } else { &[10, 30, 100, 300, 1000, 10_000, 100_000] };
    let four: &[u32] = if quick { &[10, 30] } else { &[10, 20, 40, 80, 160, 320] };
    let mut table = Table::default();
    for (name, gamma1, gamma2, omega) in CHAINS {
        let chain = Chain::new(SITES, gamma1, gamma2)?;
        let kernel = Kernel::new(&chain, omega, 1, DEFAULT_BITS).map_err(computation)?;
        let phi = 0.3 * std::f64::consts::TAU / omega;
        let exact_phi = Real::new(phi, DEFAULT_BITS);
        for chi in Chi::ALL {
            let case = format!("{}, {name}", chi.name());
            let truth = match chi {
                Chi::One => kernel.chi1(&exact_phi),
                Chi::Two => kernel.chi2(),
                Chi::Three => kernel.chi3(&exact_phi),
            };
            let mut measure = |method: &str, setting: String, value: &mut dyn FnMut() -> Result<f64, CliError>| {
                meter.tell(&case, method, &setting);
                let (value, seconds) = meter.time(value)?;
                let error = (&truth - &Real::new(value, DEFAULT_BITS)).abs().to_f64();
                let (case, method, note) = (case.clone(), method.to_owned(), String::new());
                table.rows.push(Row { case, method, setting, seconds, error, note });
                Ok::<(), CliError>(())
            };
            for (method, lengths, tails) in [
                ("series", plain, 0),
                ("series, leading tail summed", leading, 1),
                ("harmonics, four tails summed", four, MOST_TAILS),
            ] {
                for &terms in lengths {
                    measure(method, format!("J = {terms}"), &mut || {
                        Ok(Series::new(black_box(&chain), omega, terms, tails).chi(chi, phi))
                    })?;
                }
            }
            // As in a sweep: work space is kept, everything that depends on the parameters is made anew.
            let (mut spectrum, mut response) = (Spectrum::new(chain), ImpulseResponse::vacant(&chain));
            measure("closed form", "no term left out".to_owned(), &mut || {
                spectrum.reset(*black_box(&chain));
                response.reset(&spectrum, omega).map_err(computation)?;
                Ok(match chi {
                    Chi::One => -2.0 * response.value(0, phi),
                    Chi::Two => -2.0 * response.value(0, 0.0),
                    Chi::Three => 2.0 * response.derivative(0, phi),
                })
            })?;
        }
    }
    Ok(table)
}
