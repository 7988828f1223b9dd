//! Numbers as people give them, what is wrong with those that are none, and numbers as files have them.

use std::fmt;

use crate::hints::meant;

/// Reads a number, `-.5` and `1e-3` among them. Its range is the business of who uses it.
///
/// # Errors
/// That it is none.
///
/// ```
/// use vibrochain_maps::numbers::real;
/// assert_eq!(real("-.5"), Ok(-0.5));
/// assert_eq!(real("0,5").unwrap_err(), "not a number: give one such as 0.2, -.5 or 1e-3");
/// ```
pub fn real(text: &str) -> Result<f64, String> {
    text.parse().map_err(|_| "not a number: give one such as 0.2, -.5 or 1e-3".to_owned())
}

/// Reads a whole number of a type.
///
/// # Errors
/// That it is none, is negative where that cannot be, or is too large.
///
/// ```
/// use vibrochain_maps::numbers::whole;
/// assert_eq!(whole::<u64>("20"), Ok(20));
/// assert_eq!(whole::<u64>("2.5").unwrap_err(), "not a whole number: give one such as 20");
/// assert_eq!(whole::<u64>("-1").unwrap_err(), "negative: give a whole number such as 20");
/// assert_eq!(whole::<u64>("1e3").unwrap_err(), "not a whole number: give one such as 20");
/// assert_eq!(whole::<i64>("18446744073709551615").unwrap_err(), "too large: give a smaller whole number");
/// ```
pub fn whole<T: TryFrom<i128>>(text: &str) -> Result<T, String> {
    use std::num::IntErrorKind::{NegOverflow, PosOverflow};
    let (large, negative) = ("too large: give a smaller whole number", "negative: give a whole number such as 20");
    match text.parse::<i128>() {
        Ok(value) => T::try_from(value).map_err(|_| if value < 0 { negative } else { large }.to_owned()),
        Err(error) if *error.kind() == PosOverflow => Err(large.to_owned()),
        Err(error) if *error.kind() == NegOverflow => Err(negative.to_owned()),
        Err(_) => Err("not a whole number: give one such as 20".to_owned()),
    }
}

/// What a reader of files says, in the words of who writes them: keys instead of fields, kinds of values without the names of Rust's
/// types, and of a key that is not known the one that was meant.
///
/// ```
/// use vibrochain_maps::numbers::plain;
/// let message = "invalid type: floating point `2.5`, expected i64";
/// assert_eq!(plain(message), "floating point `2.5` is not a whole number");
/// assert_eq!(plain("missing field `sites`"), "the key `sites` is missing");
/// assert_eq!(plain("invalid mantissa, expected digits"), "a number begins with a digit: give 0.2 for .2");
/// let message = "unknown field `gama1`, expected one of `sites`, `gamma1`, `gamma2`";
/// assert_eq!(plain(message), "unknown key `gama1`: did you mean `gamma1`? known here are `sites`, `gamma1`, `gamma2`");
/// ```
pub fn plain(message: &str) -> String {
    const WORDS: [(&str, &str); 9] = [
        ("i64", "a whole number"),
        ("u64", "a whole number from 0"),
        ("u32", "a whole number from 0"),
        ("usize", "a whole number from 0"),
        ("f64", "a number"),
        ("a boolean", "true or false"),
        ("a string", "a text in quotes"),
        ("a sequence", "a list"),
        ("a map", "a table"),
    ];
    if let Some(told) = of_keys(message) {
        return told;
    }
    if message.starts_with("invalid mantissa") {
        return "a number begins with a digit: give 0.2 for .2".to_owned();
    }
    let wrong = ["invalid type: ", "invalid value: "].iter().find_map(|start| message.strip_prefix(start));
    let Some((found, wanted)) = wrong.and_then(|rest| rest.rsplit_once(", expected ")) else {
        return message.to_owned();
    };
    // JSON's readers add the place.
    let (wanted, place) = wanted.find(" at line ").map_or((wanted, ""), |start| wanted.split_at(start));
    let known = WORDS.iter().find(|(name, _)| *name == wanted).map(|(_, words)| *words);
    let wanted = known.unwrap_or(if wanted.starts_with("struct ") { "a table" } else { wanted });
    format!("{found} is not {wanted}{place}")
}

/// The same of a message about a key.
fn of_keys(message: &str) -> Option<String> {
    let of = |start: &str| message.strip_prefix(start)?.strip_prefix(" field `")?.split_once('`');
    if let Some((key, place)) = of("missing") {
        return Some(format!("the key `{key}` is missing{place}"));
    }
    if let Some((key, place)) = of("duplicate") {
        return Some(format!("the key `{key}` is given twice{place}"));
    }
    let (key, rest) = of("unknown")?;
    let known = rest.strip_prefix(", expected ")?;
    let (known, place) = known.find(" at line ").map_or((known, ""), |start| known.split_at(start));
    let names: Vec<&str> = known.split('`').skip(1).step_by(2).collect();
    let meant = meant(key, names.iter().copied());
    Some(format!("unknown key `{key}`{place}: {meant}known here are {}", known.trim_start_matches("one of ")))
}

/// A number in the fewest digits that read back the same, with an exponent where it would be a row of zeros.
#[derive(Debug, Clone, Copy)]
pub struct Number(pub f64);

impl Number {
    /// The digits, in two parts that follow each other, in `buffer`.
    #[inline]
    fn parts(self, buffer: &mut zmij::Buffer) -> [&str; 2] {
        let text = buffer.format(self.0);
        // Large numbers have a sign in their exponent that they read back without.
        if self.0.abs() >= 1e16
            && let Some((digits, exponent)) = text.split_once('+')
        {
            return [digits, exponent];
        }
        // A whole number comes with a fraction of zero.
        [text.strip_suffix(".0").unwrap_or(text), ""]
    }

    /// Writes the digits behind those there are.
    #[inline]
    pub fn push(self, text: &mut Vec<u8>) {
        // What stable orbits have.
        if self.0 == 1.0 {
            return text.push(b'1');
        }
        self.parts(&mut zmij::Buffer::new()).iter().for_each(|part| text.extend_from_slice(part.as_bytes()));
    }

    /// The same without an exponent, however long the row of zeros is.
    pub fn push_in_full(self, text: &mut Vec<u8>) {
        let size = self.0.abs();
        if size == 0.0 || (1e-5..1e16).contains(&size) {
            return self.push(text);
        }
        text.extend_from_slice(self.0.to_string().as_bytes());
    }
}

/// Writes numbers as [`Number::push_in_full`] does, each with a comma behind it.
///
/// ```
/// let mut row = b"7,".to_vec();
/// vibrochain_maps::numbers::push_row(&[0.5, -3.0, 1e-7], &mut row);
/// assert_eq!(row, b"7,0.5,-3,0.0000001,");
/// ```
pub fn push_row(values: &[f64], row: &mut Vec<u8>) {
    for value in values {
        Number(*value).push_in_full(row);
        row.push(b',');
    }
}

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.parts(&mut zmij::Buffer::new()).iter().try_for_each(|part| f.write_str(part))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As many digits as the standard library's; half-way between two candidates for the last one either will do.
    fn assert_alike(own: &str, standard: &str, value: f64) {
        let same = own.len() == standard.len() && own.parse::<f64>().unwrap() == value;
        assert!(own == standard || same, "{own} {standard}");
    }

    #[test]
    fn numbers_read_back_and_stay_short() {
        for value in [0.0, -0.4, 1e-300, 1e100, 123_456.789, f64::MIN_POSITIVE, 0.1 + 0.2] {
            let text = Number(value).to_string();
            assert!(text.parse::<f64>().unwrap() == value && text.len() < 25);
        }
        // From 1e-5 to 1e16 without an exponent.
        let standard = |value: f64| match value.abs() {
            size if size == 0.0 || (1e-5..1e16).contains(&size) || !value.is_finite() => format!("{value}"),
            _ => format!("{value:e}"),
        };
        let mut random = fastrand::Rng::with_seed(1);
        let edges =
            [1e-5, 1e16, 1e15, 9.999_999_999_999_999e-6, 9_999_999_999_999_998.0, -0.0, 1.0, f64::NAN, -f64::INFINITY];
        let any = (0..20_000).map(|_| f64::from_bits(random.u64(..)));
        let usual = (0..20_000).map(|i| f64::from(i) / 3000.0 - 2.0);
        for value in edges.into_iter().chain(any.collect::<Vec<_>>()).chain(usual) {
            let own = Number(value).to_string();
            assert_alike(&own, &standard(value), value);
            let mut pushed = b"x = ".to_vec();
            Number(value).push(&mut pushed);
            assert_eq!(pushed, format!("x = {own}").as_bytes());
        }
    }

    #[test]
    fn numbers_in_full_are_the_standard_librarys() {
        let mut random = fastrand::Rng::with_seed(2);
        let edges =
            [1e-5, 1e16, 9.999_999_999_999_999e-6, 9_999_999_999_999_998.0, 1e-300, 5e-324, 0.0, -0.0, 1.0, -1.0];
        // Half-way between two candidates for the last digit, as a few powers of two beside a whole number are.
        let ties = (1..20).flat_map(|n| (1..40).map(move |k| f64::from(2 * k + 1) * 0.5_f64.powi(n)));
        let ties = ties.flat_map(|tie| [1.0, 3.0, 7.0].map(|whole| whole + tie));
        let turns: Vec<f64> = (0..20_000).map(|_| (7.0 * random.f64()).sin()).collect();
        let sizes: Vec<f64> = (0..20_000).map(|_| 10f64.powf(40.0 * random.f64() - 20.0)).collect();
        for value in edges.into_iter().chain([f64::NAN, -f64::INFINITY]).chain(ties).chain(turns).chain(sizes) {
            let mut pushed = b"x = ".to_vec();
            Number(value).push_in_full(&mut pushed);
            assert_alike(&String::from_utf8(pushed).unwrap()["x = ".len()..], &value.to_string(), value);
        }
    }
}
