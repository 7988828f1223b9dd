//! The one way to end long work early.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use thiserror::Error;

/// A request to end long work, which anyone may make at any time. All that computes takes one and looks at it at least every 0.2 s of
/// work; the default is never raised. Clones are the same request.
///
/// ```
/// use std::sync::{Arc, atomic::{AtomicBool, Ordering}};
/// use vibrochain_lattice::{Stop, Stopped};
/// let flag = Arc::new(AtomicBool::new(false));
/// let stop = Stop::from(&flag);
/// assert_eq!(stop.heard(), Ok(()));
/// flag.store(true, Ordering::Relaxed);
/// assert_eq!(stop.heard(), Err(Stopped));
/// assert!(!Stop::default().is_raised());
/// ```
#[derive(Clone, Default)]
pub struct Stop(Option<Arc<dyn Fn() -> bool + Send + Sync>>);

/// The work was ended by its [`Stop`]: there is no result.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("stopped before it was done")]
pub struct Stopped;

impl Stop {
    /// Raised as soon as `raised` says so. It is asked from any thread, at every look; once it has said so, it must keep to it.
    pub fn when(raised: impl Fn() -> bool + Send + Sync + 'static) -> Self {
        Self(Some(Arc::new(raised)))
    }

    /// Raised with this one, and once so much time has passed from now.
    pub fn within(&self, time: Duration) -> Self {
        let (stop, begun) = (self.clone(), Instant::now());
        Self::when(move || stop.is_raised() || begun.elapsed() >= time)
    }

    /// Whether both are clones of one request.
    pub fn is_same(&self, other: &Self) -> bool {
        match (&self.0, &other.0) {
            (Some(one), Some(two)) => Arc::ptr_eq(one, two),
            (one, two) => one.is_none() && two.is_none(),
        }
    }

    /// Whether the work is to end.
    pub fn is_raised(&self) -> bool {
        self.0.as_ref().is_some_and(|raised| raised())
    }

    /// For work that ends with an error.
    ///
    /// # Errors
    /// [`Stopped`] once it is raised.
    pub fn heard(&self) -> Result<(), Stopped> {
        if self.is_raised() { Err(Stopped) } else { Ok(()) }
    }
}

impl From<&Arc<AtomicBool>> for Stop {
    /// Raised with the flag.
    fn from(flag: &Arc<AtomicBool>) -> Self {
        let flag = Arc::clone(flag);
        Self::when(move || flag.load(Ordering::Relaxed))
    }
}

impl fmt::Debug for Stop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Stop").field(&self.0.as_ref().map(|raised| raised())).finish()
    }
}
