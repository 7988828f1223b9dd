//! The cells of the paper's maps that lie nearest to coincident poles, against 57 digits: there the secular form leaves the
//! answer to a dense matrix, or knows what its own is worth.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use vibrochain_breather::{Family, Finder, Orbit, OrbitList};
use vibrochain_floquet::{Analyser, Method, Tolerance, Verdict};
use vibrochain_lattice::{Chain, Model};
use vibrochain_truth::{DEFAULT_BITS, TrueOrbit, TrueSpectrum};

/// Error of a verdict's spectral radius.
fn error(orbit: &Orbit, verdict: &Verdict) -> f64 {
    let spectrum = TrueSpectrum::new(&TrueOrbit::refine(orbit, DEFAULT_BITS).unwrap()).unwrap();
    let (root, moved) = spectrum.refine((verdict.leading.re, verdict.leading.im)).unwrap();
    assert!(moved < 1e-4 * verdict.spectral_radius, "{verdict:?}: another root, off by {moved}");
    (root.abs() - verdict.spectral_radius).abs().to_f64()
}

/// The double-sided breather of the cell of this row and column of the map of N = n, and its name.
fn breather((n, row, column): (usize, u32, u32)) -> (Finder, Orbit, String) {
    let (g2, omega) = (0.3 * f64::from(row) / 299.0, 0.4 + 2.6 * f64::from(column) / 399.0);
    let model = Model::conservative(Chain::new(n + 1, 0.2, g2).unwrap(), omega, 0.4).unwrap();
    let (mut finder, mut found) = (Finder::new(n + 1), OrbitList::default());
    finder.find_symmetric(&model, Family::DoubleSided, &mut found).unwrap();
    (finder, found.orbits.swap_remove(0), format!("N = {n}, γ₂ = {g2}, ω = {omega}"))
}

/// Where a matrix and the secular function differ most, among the cells whose leading multiplier residues leave imprecise.
#[test]
fn the_secular_function_itself_settles_what_its_residues_do_not_know() {
    let mut worst = [0.0_f64; 2];
    for cell in [(20, 12, 80), (20, 15, 81), (20, 18, 82), (20, 21, 83), (20, 188, 132), (20, 248, 149)] {
        let (mut finder, orbit, name) = breather(cell);
        let [own, dense] = [Analyser::default(), Analyser::dense()].map(|mut analyser| {
            let verdict = analyser.verdict(&orbit, &mut finder, Tolerance::Rounding).unwrap();
            (error(&orbit, &verdict), verdict)
        });
        println!("{name}: {:.1e}, a matrix {:.1e}", own.0, dense.0);
        assert!(own.1.method == Method::Secular && own.0 < 1e-11, "{name}: {own:?} {dense:?}");
        assert!(own.0 <= own.1.resolution, "{name}: {own:?}");
        worst = [worst[0].max(own.0), worst[1].max(dense.0)];
    }
    assert!(worst[0] < 0.5 * worst[1], "{worst:?}");
}

#[test]
fn next_to_coincident_poles_the_better_form_answers() {
    // Column of 400 (ω from 0.4 to 3) and row of 300 (γ₂ from 0 to 0.3) of scenes/conservative-n*.toml.
    let cells = [
        (5, 134, 96),
        (5, 213, 148),
        (10, 104, 127),
        (10, 251, 187),
        (10, 258, 165),
        (10, 264, 130),
        (10, 273, 194),
        (10, 299, 202),
        (20, 56, 80),
        (20, 106, 138),
        (20, 171, 116),
        (20, 246, 225),
        (40, 80, 79),
        (40, 192, 129),
        (40, 264, 130),
        (40, 266, 141),
        (40, 270, 131),
        (40, 276, 191),
        (40, 290, 141),
    ];
    for cell in cells {
        let (mut finder, orbit, name) = breather(cell);
        let orbit = &orbit;
        for dense in [false, true] {
            let mut analyser = if dense { Analyser::dense() } else { Analyser::default() };
            let sweep = analyser.verdict(orbit, &mut finder, Tolerance::Rounding).unwrap();
            let thorough = analyser.stability(orbit, &mut finder, Tolerance::Rounding).unwrap().verdict;
            // A matrix promises 4e-11 in one of these cells.
            let granted = if dense { 1e-11 } else { 1e-12 };
            for (verdict, granted, promised) in [(sweep, 1e-9, f64::INFINITY), (thorough, granted, thorough.resolution)]
            {
                let error = error(orbit, &verdict);
                let name = format!("{name}: error {error:.1e}, {verdict:?}");
                println!("{name}");
                assert!(error < granted * verdict.spectral_radius, "{name}");
                assert!(error <= 10.0 * promised, "{name}");
            }
        }
    }
}
