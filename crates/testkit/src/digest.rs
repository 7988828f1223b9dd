//! A checksum of a text that forgives rounding: its words must be the same, its numbers nearly so.

use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::xxh3_64;

/// Most sums of one text.
const SUMS: usize = 200;
/// Fewest numbers in a sum: more sums would make long files.
const FEWEST: usize = 64;
/// What a number may change by, relatively: forty times what a rewritten kernel changed radii by on the paper's maps.
const TOLERANCE: f64 = 2e-9;

/// What is kept of a text.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Digest {
    /// Checksum of all between the numbers.
    words: String,
    /// How many numbers there are.
    numbers: usize,
    /// Weighted sums of arsinh of them, so that large and small ones count by their relative change and none is lost beside
    /// others.
    sums: Vec<f64>,
}

/// The weight of the i-th number, between 1 and 2, so that an exchange of two shows.
fn weight(i: usize) -> f64 {
    1.0 + (i as f64 * 0.618_033_988_749_894_9).fract()
}

impl Digest {
    /// What is kept of this text.
    #[must_use]
    pub fn of(text: &str) -> Self {
        let (mut words, mut numbers) = (Vec::new(), Vec::new());
        // A number begins a word: `n20` is none.
        let boundary = |c: char| !(c.is_ascii_alphanumeric() || matches!(c, '.' | '-' | '+' | '_'));
        for part in text.split_inclusive(boundary) {
            let word = part.trim_end_matches(boundary);
            match word.parse::<f64>() {
                Ok(number) if number.is_finite() => {
                    numbers.push(number);
                    words.push(b'#');
                    words.extend_from_slice(&part.as_bytes()[word.len()..]);
                }
                _ => words.extend_from_slice(part.as_bytes()),
            }
        }
        let size = numbers.len().div_ceil(SUMS).max(FEWEST);
        let sum = |some: &[f64]| some.iter().enumerate().map(|(i, x)| weight(i) * x.asinh()).sum();
        Self {
            words: format!("{:016x}", xxh3_64(&words)),
            numbers: numbers.len(),
            sums: numbers.chunks(size).map(sum).collect(),
        }
    }

    /// How this differs from what was kept, if it does.
    #[must_use]
    pub fn difference(&self, kept: &Self) -> Option<String> {
        if self.numbers != kept.numbers {
            return Some(format!("{} numbers instead of {}", self.numbers, kept.numbers));
        }
        if self.words != kept.words {
            return Some("other words between the numbers".to_owned());
        }
        // Rounding adds up like a random walk.
        let size = self.numbers.div_ceil(SUMS).max(FEWEST);
        let allowed = TOLERANCE * (size as f64).sqrt();
        let far = |(now, then): (&f64, &f64)| (now - then).abs() > allowed;
        let place = self.sums.iter().zip(&kept.sums).position(far)?;
        let (now, then) = (self.sums[place], kept.sums[place]);
        Some(format!("numbers {} to {}: a sum of {now} instead of {then}", place * size, (place + 1) * size))
    }
}

#[cfg(test)]
mod tests {
    use super::Digest;

    fn table(change: impl Fn(usize, f64) -> f64) -> String {
        let row = |i: usize| {
            let x = change(i, (0.37 * i as f64).sin() * 10f64.powi(i as i32 % 9 - 4));
            format!("{i},stable-double,{x:.15e}\n")
        };
        (0..5000).map(row).collect()
    }

    #[test]
    fn rounding_is_forgiven_and_nothing_else() {
        let kept = Digest::of(&table(|_, x| x));
        let same = |text: &str| Digest::of(text).difference(&kept).is_none();
        assert!(same(&table(|_, x| x)));
        assert!(same(&table(|i, x| x * (1.0 + 1e-11 * (i as f64).cos()))));
        assert!(!same(&table(|i, x| if i == 1234 { x * (1.0 + 1e-5) } else { x })));
        assert!(!same(&table(|_, x| x * (1.0 + 1e-8))));
        let text = table(|_, x| x);
        assert!(!same(&text.replacen("stable-double", "stable-single", 1)));
        assert!(!same(&text.replacen("77,", "78,", 1)));
        assert!(!same(&text[..text.len() - 40]));
    }
}
