//! A flag that ends long searches.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::error::BreatherError;

/// A flag that somebody may raise; without one a search goes on to its end.
#[derive(Debug, Clone, Default)]
pub(crate) struct Stop(Option<Arc<AtomicBool>>);

impl Stop {
    pub(crate) fn at(flag: Arc<AtomicBool>) -> Self {
        Self(Some(flag))
    }

    pub(crate) fn is_raised(&self) -> bool {
        self.0.as_ref().is_some_and(|flag| flag.load(Ordering::Relaxed))
    }

    /// # Errors
    /// [`BreatherError::Stopped`] once it is raised.
    pub(crate) fn heard(&self) -> Result<(), BreatherError> {
        if self.is_raised() { Err(BreatherError::Stopped) } else { Ok(()) }
    }
}
