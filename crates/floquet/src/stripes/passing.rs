//! Which pairs of modes meet from one point of a line to the next.

/// Two modes whose sum, or difference, passes a whole multiple of ω from one point to the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Passing {
    /// k ≤ l, as in [`Collision`](crate::Collision).
    pub modes: (usize, usize),
    /// j
    pub harmonic: usize,
    /// Ω̃_k + Ω̃_l = jω; otherwise Ω̃_l − Ω̃_k = jω, which is no collision.
    pub sum: bool,
    /// At which part of the way, taken as straight.
    pub part: f64,
}

/// All of them between two lists of Ω̃/ω, those of [`DressedModes::frequencies`](crate::DressedModes::frequencies). Of orbits that are
/// [symmetric](crate::DressedModes::is_symmetric) modes that meet at odd harmonics do not collide: `even_only` leaves these out.
pub fn passings(from: &[Option<f64>], to: &[Option<f64>], even_only: bool, mut found: impl FnMut(Passing)) {
    let modes: Vec<_> = from.iter().zip(to).enumerate().filter_map(|(k, (a, b))| Some((k, (*a)?, (*b)?))).collect();
    for (i, &(k, k_from, k_to)) in modes.iter().enumerate() {
        for &(l, l_from, l_to) in &modes[i..] {
            for (sum, a, b) in [(true, k_from + l_from, k_to + l_to), (false, l_from - k_from, l_to - k_to)] {
                let harmonic = a.max(b).floor();
                // One and no jump of a mode; a mode against itself at an even harmonic is a resonance. (The internal mode
                // stays at ω/2 while it doubles the period: both ends are passed.)
                let passed = a.min(b) <= harmonic && a != b && harmonic >= 1.0 && (a - b).abs() < 0.5;
                let odd = harmonic % 2.0 != 0.0;
                if passed && !(k == l && !(sum && odd)) && !(even_only && odd) {
                    let part = (harmonic - a) / (b - a);
                    found(Passing { modes: (k, l), harmonic: harmonic as usize, sum, part });
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_numbers_are_passed_once_each_way() {
        let seen = |from: &[f64], to: &[f64], even| {
            let some = |values: &[f64]| values.iter().copied().map(Some).collect::<Vec<_>>();
            let mut all = Vec::new();
            passings(&some(from), &some(to), even, |Passing { modes: (k, l), harmonic, sum, part }| {
                all.push((k, l, harmonic, sum, (part * 100.0).round()));
            });
            all
        };
        // 0.6 + 0.5 → 0.55 + 0.35, and 2·0.5 = 1 is met by mode 1 at its start.
        assert_eq!(seen(&[0.6, 0.55], &[0.55, 0.35], false), [(0, 1, 1, true, 60.0), (1, 1, 1, true, 25.0)]);
        assert_eq!(seen(&[0.55, 0.35], &[0.6, 0.55], false).len(), 2);
        assert_eq!(seen(&[0.6, 0.55], &[0.55, 0.35], true), []);
        // A difference; and 2Ω = 2ω is none.
        assert_eq!(seen(&[0.3, 1.4], &[0.3, 1.2], false), [(0, 1, 1, false, 50.0)]);
        assert_eq!(seen(&[1.1], &[0.9], false), []);
    }
}
