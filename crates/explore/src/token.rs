//! The word in the address that nobody can guess.

use std::io;

/// Random bytes of a token: 2¹²⁸ of them.
const BYTES: usize = 16;

/// A token, as hexadecimal digits.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Token(String);

impl Token {
    /// One by the system's randomness.
    pub(crate) fn random() -> io::Result<Self> {
        let mut bytes = [0; BYTES];
        getrandom::fill(&mut bytes).map_err(|error| io::Error::other(error.to_string()))?;
        Ok(Self(bytes.iter().map(|byte| format!("{byte:02x}")).collect()))
    }

    pub(crate) fn text(&self) -> &str {
        &self.0
    }

    /// Whether `given` is it. Every byte is looked at, whatever those before it were: how long it takes tells nothing.
    pub(crate) fn is(&self, given: &str) -> bool {
        let pairs = self.0.bytes().zip(given.bytes());
        given.len() == self.0.len() && pairs.fold(0, |wrong, (own, other)| wrong | (own ^ other)) == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_whole_token_is_taken() {
        let token = Token::random().unwrap();
        let text = token.text().to_owned();
        assert!(text.len() == 2 * BYTES && token.is(&text));
        assert!(!token.is("") && !token.is(&text[1..]) && !token.is(&format!("{text}0")));
        assert_ne!(Token::random().unwrap(), token);
        let other = if text.starts_with('0') { "1" } else { "0" };
        assert!(!token.is(&format!("{other}{}", &text[1..])));
    }
}
