//! A connection, as seen by those that want its place: since when it has been silent.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// A connection.
#[derive(Debug)]
pub(crate) struct Connection {
    opened: Instant,
    /// Whether anything has been asked.
    asked: AtomicBool,
    /// Milliseconds from then until something was last heard or told; [`AT_WORK`] while an answer is computed.
    last: AtomicU64,
}

/// Stands for a connection whose answer is computed.
const AT_WORK: u64 = u64::MAX;

/// How long a connection keeps its place while others want it: until whoever has opened it has asked, also on a machine that is busy, where
/// all who wait behind a thousand silent ones wait as long; and until an answer is surely on its way.
const OPENED: Duration = Duration::from_millis(250);
const ANSWERED: Duration = Duration::from_millis(100);

/// While it lives, the connection is at work.
pub(crate) struct AtWork<'a>(&'a Connection);

impl Drop for AtWork<'_> {
    fn drop(&mut self) {
        self.0.heard();
    }
}

impl Connection {
    pub(crate) fn new() -> Self {
        Self { opened: Instant::now(), asked: AtomicBool::new(false), last: AtomicU64::new(0) }
    }

    /// A request has arrived, or an answer is there.
    pub(crate) fn heard(&self) {
        self.asked.store(true, Ordering::Relaxed);
        let now = self.opened.elapsed().as_millis();
        self.last.store(u64::try_from(now).unwrap_or(AT_WORK - 1), Ordering::Relaxed);
    }

    pub(crate) fn at_work(&self) -> AtWork<'_> {
        self.last.store(AT_WORK, Ordering::Relaxed);
        AtWork(self)
    }

    /// How long there has been nothing to do here: no request, or nobody who reads the answer. `None` while one is computed.
    pub(crate) fn silent(&self) -> Option<Duration> {
        let last = self.last.load(Ordering::Relaxed);
        (last != AT_WORK).then(|| self.opened.elapsed().saturating_sub(Duration::from_millis(last)))
    }

    /// Whether others may take its place.
    pub(crate) fn is_idle(&self) -> bool {
        let grace = if self.asked.load(Ordering::Relaxed) { ANSWERED } else { OPENED };
        self.silent() >= Some(grace)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_connection_at_work_is_not_silent_and_one_that_has_just_opened_keeps_its_place() {
        let since = |time| Instant::now().checked_sub(time).unwrap();
        let connection = Connection { opened: since(OPENED / 2), ..Connection::new() };
        assert!(connection.silent() >= Some(OPENED / 2) && !connection.is_idle());
        let connection = Connection { opened: since(2 * OPENED), ..Connection::new() };
        assert!(connection.is_idle());
        let work = connection.at_work();
        assert_eq!((connection.silent(), connection.is_idle()), (None, false));
        drop(work);
        assert!(connection.silent() < Some(OPENED));
    }
}
