//! How the motion of a contact at an impact changes with the unknowns of an orbit: of a chain, and of any structure with stops.
//!
//! The k-th derivative of the contact's coordinate is g⁽ᵏ⁾ = Σ_j P_j K⁽ᵏ⁾(t_i−t_j) + G⁽ᵏ⁾(t_i+ψ) but for constants. So it moves by K⁽ᵏ⁾ with
//! an impulse, by −P_j K⁽ᵏ⁺¹⁾ with another impact's time, by all of g⁽ᵏ⁺¹⁾ but what the impact itself sends with its own, by G⁽ᵏ⁺¹⁾ with ψ.

/// Derivatives of a contact's coordinate at an impact of an orbit.
pub(crate) struct Slopes<'a> {
    /// Number of the impact.
    pub(crate) impact: usize,
    /// The impulses of all impacts.
    pub(crate) impulses: &'a [f64],
    /// The kernel from each of them to this impact, with its first three derivatives.
    pub(crate) jets: &'a [[f64; 4]],
    /// What the loads do to the contact here, with the first three derivatives.
    pub(crate) load: &'a [f64; 4],
}

impl Slopes<'_> {
    /// Those of g⁽ᵏ⁾ with k = `order`, 0 to 2, added to a row of unknowns that begins with the impulses. Times and phase that are no unknowns
    /// have no place in it.
    pub(crate) fn add(&self, order: usize, time: impl Fn(usize) -> Option<usize>, psi: Option<usize>, row: &mut [f64]) {
        let mut own = self.load[order + 1];
        for (j, (impulse, jet)) in self.impulses.iter().zip(self.jets).enumerate() {
            row[j] += jet[order];
            if j == self.impact {
                continue;
            }
            let moved = impulse * jet[order + 1];
            own += moved;
            if let Some(place) = time(j) {
                row[place] -= moved;
            }
        }
        if let Some(place) = time(self.impact) {
            row[place] += own;
        }
        if let Some(place) = psi {
            row[place] += self.load[order + 1];
        }
    }
}
