//! Errors that point into a scene file.

use std::ops::Range;
use std::path::Path;

use crate::error::MapError;
use crate::numbers::plain;
use crate::text::{clipped, excerpt};

/// Characters shown of a line: a terminal's width.
pub(super) const SHOWN: usize = 80;

/// The most characters of a message, which may quote a word of the file.
const MOST_TOLD: usize = 400;

/// A scene's text, for errors that point into it.
pub struct Source<'a> {
    /// Its file, for messages.
    pub path: &'a Path,
    /// The text; empty of a scene that is data, which has no places to point at.
    pub text: &'a str,
}

/// Whether a text is JSON: no TOML begins so.
pub(crate) fn is_json(text: &str) -> bool {
    text.trim_start().starts_with('{')
}

impl Source<'_> {
    /// An error that points at a place of the text, with the line about it.
    pub fn error(&self, span: Range<usize>, message: impl std::fmt::Display) -> MapError {
        let (path, message) = (self.path.display(), message.to_string());
        let message = clipped(&message, MOST_TOLD);
        if self.text.is_empty() {
            return MapError::Request(format!("{path}: {message}"));
        }
        let start = span.start.min(self.text.len());
        let before = self.text.get(..start).unwrap_or_default();
        let line = before.matches('\n').count() + 1;
        let column = before.chars().rev().take_while(|&c| c != '\n').count() + 1;
        let (shown, indent) = excerpt(self.text.lines().nth(line - 1).unwrap_or_default(), column - 1, SHOWN);
        let width = line.to_string().len();
        MapError::Request(format!(
            "{path}:{line}:{column}: {message}\n{line} | {shown}\n{:width$} | {:indent$}^",
            "", "",
        ))
    }

    /// What the reader of TOML says, at the place it says it of.
    pub fn unreadable(&self, error: &toml::de::Error) -> MapError {
        // Of integers beyond 64 bits serde_json says "JSON number out of range".
        self.error(error.span().unwrap_or(0..0), plain(error.message().trim().trim_start_matches("JSON ")))
    }
}
