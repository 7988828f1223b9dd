//! Calls that may take long: other Python threads go on, Ctrl-C is heard, and a panic is an exception like any other.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use pyo3::prelude::*;
use vibrochain_lattice::{Model, Stop};

use crate::failure::Failure;

/// Between two looks for Ctrl-C: sooner than a person notices.
const LOOK: Duration = Duration::from_millis(50);

/// Does `work` on a thread of its own and waits for it without holding the interpreter; `look` is called now and then. On Ctrl-C
/// the flag that `work` is given is raised and nobody waits any longer: what does not look at the flag ends by itself, unseen.
pub(crate) fn long<T, E>(
    py: Python<'_>,
    mut look: impl FnMut(Python<'_>) -> PyResult<()>,
    work: impl FnOnce(&Stop) -> Result<T, E> + Send + 'static,
) -> PyResult<T>
where
    T: Send + 'static,
    E: Into<Failure>,
{
    let stop = Arc::new(AtomicBool::new(false));
    let (sender, mut receiver) = channel();
    let flag = Stop::from(&stop);
    // Who has been interrupted does not listen.
    let job = move || drop(sender.send(caught(|| work(&flag))));
    std::thread::Builder::new()
        .name("vibrochain".to_owned())
        .spawn(job)
        .map_err(|error| Failure::Other(format!("cannot start a thread: {error}")))?;
    loop {
        let listener = &mut receiver;
        match py.detach(move || listener.recv_timeout(LOOK)) {
            Ok(done) => return Ok(done?),
            Err(RecvTimeoutError::Timeout) => py.check_signals().and_then(|()| look(py)).inspect_err(|_| {
                stop.store(true, Ordering::Relaxed);
            })?,
            Err(RecvTimeoutError::Disconnected) => {
                return Err(Failure::Other("the thread that computes has vanished".to_owned()).into());
            }
        }
    }
}

/// [`long`]; `progress` is told now and then how many of how many steps are done, of which `work` keeps count.
pub(crate) fn counted<T, E>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    steps: u64,
    work: impl FnOnce(&Stop, &[AtomicU64; 2]) -> Result<T, E> + Send + 'static,
) -> PyResult<T>
where
    T: Send + 'static,
    E: Into<Failure>,
{
    let told = Arc::new([AtomicU64::new(0), AtomicU64::new(steps)]);
    let counts = told.clone();
    let look = |_: Python<'_>| match progress {
        Some(progress) => {
            let [done, all] = [0, 1].map(|i| told[i].load(Ordering::Relaxed));
            progress.call1((done.min(all), all.max(1))).map(drop)
        }
        None => Ok(()),
    };
    long(py, look, move |stop| work(stop, &counts))
}

/// [`long`] with nothing to do while waiting and no use for the flag. What is a matter of milliseconds on a chain such as `model`'s
/// is done at once: to wake a thread and be woken by it costs more than most orbits.
pub(crate) fn call<'m, T, E>(
    py: Python<'_>,
    model: impl Into<Option<&'m Model>>,
    work: impl FnOnce() -> Result<T, E> + Send + 'static,
) -> PyResult<T>
where
    T: Send + 'static,
    E: Into<Failure>,
{
    if model.into().is_some_and(is_quick) {
        return Ok(py.detach(move || caught(work))?);
    }
    long(py, |_| Ok(()), move |_| work())
}

/// A hundred masses, whose fastest mode swings a hundred times in a period: whatever is asked of an orbit takes some milliseconds.
fn is_quick(model: &Model) -> bool {
    let chain = model.chain();
    let fastest = chain.gamma1() + 4.0 * (chain.gamma2() + chain.gamma3());
    chain.sites() <= 100 && fastest.sqrt() <= 100.0 * model.omega()
}

/// A panic is a failure like any other.
fn caught<T, E: Into<Failure>>(work: impl FnOnce() -> Result<T, E>) -> Result<T, Failure> {
    catch_unwind(AssertUnwindSafe(|| work().map_err(Into::into))).unwrap_or_else(|panic| {
        let said = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied());
        let said = said.unwrap_or("no message");
        Err(Failure::Other(format!("a fault of vibrochain itself, please report it: {said}")))
    })
}
