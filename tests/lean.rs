//! A map pays only for what it asks: allocations of a cell in steady state. `cargo bench --bench lean` has the times.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

#[path = "support/lean.rs"]
mod lean;

use lean::KINDS;

#[test]
fn existence_allocates_nothing_and_stability_only_for_its_eigenvalues() {
    // Measured: 0, 3.362, 0 and 5.055. The eigenvalue solver, and the spectrum that a few cells ask, take their work space anew for each orbit.
    for (kind, most) in KINDS.into_iter().zip([0.0, 3.5, 0.0, 5.2]) {
        let allocations = kind.allocations();
        println!("{}: {allocations:.3} allocations a cell", kind.name());
        assert!(allocations <= most, "{}: {allocations} allocations a cell, at most {most}", kind.name());
    }
}
