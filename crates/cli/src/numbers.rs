//! Numbers as people give them, and what is wrong with those that are none.

/// Reads a number, `-.5` and `1e-3` among them. Its range is the business of who uses it.
///
/// # Errors
/// That it is none.
///
/// ```
/// use vibrochain_cli::numbers::real;
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
/// use vibrochain_cli::numbers::whole;
/// assert_eq!(whole::<u64>("20"), Ok(20));
/// assert_eq!(whole::<u64>("2.5").unwrap_err(), "not a whole number: give one such as 20");
/// assert_eq!(whole::<u64>("-1").unwrap_err(), "negative: give a whole number from 0");
/// assert_eq!(whole::<u64>("1e3").unwrap_err(), "not a whole number: give one such as 20");
/// assert_eq!(whole::<i64>("18446744073709551615").unwrap_err(), "too large: give a smaller whole number");
/// ```
pub fn whole<T: TryFrom<i128>>(text: &str) -> Result<T, String> {
    use std::num::IntErrorKind::{NegOverflow, PosOverflow};
    let (large, negative) = ("too large: give a smaller whole number", "negative: give a whole number from 0");
    match text.parse::<i128>() {
        Ok(value) => T::try_from(value).map_err(|_| if value < 0 { negative } else { large }.to_owned()),
        Err(error) if *error.kind() == PosOverflow => Err(large.to_owned()),
        Err(error) if *error.kind() == NegOverflow => Err(negative.to_owned()),
        Err(_) => Err("not a whole number: give one such as 20".to_owned()),
    }
}

/// What a reader of files says of a value of the wrong kind, without the names of Rust's types; any other message as it is.
///
/// ```
/// use vibrochain_cli::numbers::plain;
/// let message = "invalid type: floating point `2.5`, expected i64";
/// assert_eq!(plain(message), "floating point `2.5` is not a whole number");
/// assert_eq!(plain("missing field `sites`"), "missing field `sites`");
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
