//! Why there is no answer.

use thiserror::Error;

/// A refused request: a code of HTTP, and what to do.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{message}")]
pub struct Refusal {
    /// The code.
    pub code: u16,
    /// For people: which value, what range.
    pub message: String,
}

impl Refusal {
    /// A refusal of any code.
    #[must_use]
    pub fn new(code: u16, message: impl Into<String>) -> Self {
        Self { code, message: message.into() }
    }

    /// 400: the request is wrong.
    #[must_use]
    pub fn wrong(message: impl Into<String>) -> Self {
        Self::new(400, message)
    }
}

/// A message alone is about what was asked.
impl From<String> for Refusal {
    fn from(message: String) -> Self {
        Self::wrong(message)
    }
}
