//! A map pays only for what it asks: allocations of a cell in steady state. `cargo bench --bench lean` has the times.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

#[path = "support/lean.rs"]
mod lean;

use lean::KINDS;

#[test]
fn existence_allocates_nothing_and_stability_only_for_its_eigenvalues() {
    // Measured: 0, 4.195, 0 and 3.750. An eigenvalue solver has no work space to bring along.
    for (kind, most) in KINDS.into_iter().zip([0.0, 4.5, 0.0, 4.0]) {
        let allocations = kind.allocations();
        println!("{}: {allocations:.3} allocations a cell", kind.name());
        assert!(allocations <= most, "{}: {allocations} allocations a cell, at most {most}", kind.name());
    }
}
