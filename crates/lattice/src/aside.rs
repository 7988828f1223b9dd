//! Work that cannot look at a request to stop: eigenvectors in a library, all multipliers of a large lattice, a scene that is read.

use std::panic::resume_unwind;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::Builder;
use std::time::Duration;

use crate::stop::{Stop, Stopped};

/// Between two looks at the request: a user does not notice half of what is promised, and a look costs microseconds.
const LOOK: Duration = Duration::from_millis(50);

/// Does `work` on a thread of its own and waits for it. Whoever is stopped does not wait any longer: the thread ends by itself, unseen.
///
/// # Errors
/// [`Stopped`].
pub fn aside<T: Send + 'static>(stop: &Stop, work: impl FnOnce() -> T + Send + 'static) -> Result<T, Stopped> {
    stop.heard()?;
    // Shared, so that it is still here if no thread can be had.
    let work = Arc::new(Mutex::new(Some(work)));
    let take = |work: &Mutex<Option<_>>| work.lock().unwrap_or_else(PoisonError::into_inner).take();
    let (sender, receiver) = channel();
    let theirs = Arc::clone(&work);
    let begun = Builder::new().name("vibrochain-aside".to_owned()).spawn(move || {
        // Whoever has been stopped does not listen.
        take(&theirs).map(|work| drop(sender.send(work())))
    });
    let Ok(thread) = begun else {
        return take(&work).map(|work| work()).ok_or(Stopped);
    };
    loop {
        match receiver.recv_timeout(LOOK) {
            Ok(done) => return Ok(done),
            Err(RecvTimeoutError::Timeout) => stop.heard()?,
            Err(RecvTimeoutError::Disconnected) => match thread.join() {
                Err(panic) => resume_unwind(panic),
                Ok(_) => return Err(Stopped),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicBool, Ordering};

    use super::*;

    #[test]
    fn what_does_not_look_is_left_behind() {
        assert_eq!(aside(&Stop::default(), || 7), Ok(7));
        assert_eq!(aside(&Stop::when(|| true), || 7), Err(Stopped));
        let flag = Arc::new(AtomicBool::new(false));
        let (raised, ended) = (Arc::clone(&flag), Arc::new(AtomicBool::new(false)));
        let theirs = Arc::clone(&ended);
        // It ends only after whoever waited has gone.
        let work = move || {
            raised.store(true, Ordering::Relaxed);
            while !theirs.load(Ordering::Relaxed) {
                std::thread::sleep(Duration::from_millis(1));
            }
        };
        assert_eq!(aside(&Stop::from(&flag), work), Err(Stopped));
        ended.store(true, Ordering::Relaxed);
    }

    #[test]
    #[should_panic(expected = "their panic")]
    fn a_panic_is_handed_on() {
        let _ = aside(&Stop::default(), || panic!("their panic"));
    }
}
