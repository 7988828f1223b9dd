//! Computations: so many at a time, so many in wait, ended when nobody waits for them any more.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use tokio::sync::Semaphore;
use tokio::task::spawn_blocking;

use crate::refusal::Refusal;

/// A queue of computations of one kind.
#[derive(Debug, Clone)]
pub(crate) struct Work {
    running: Arc<Semaphore>,
    waiting: Arc<AtomicUsize>,
    most: usize,
}

/// A place in the queue.
struct Place(Arc<AtomicUsize>);

impl Drop for Place {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::Relaxed);
    }
}

/// Raises a flag when the request that asked is dropped: its connection has gone, or it has its answer.
struct Raise(Arc<AtomicBool>);

impl Drop for Raise {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

impl Work {
    /// For `running` at a time, and `most` with those that wait.
    pub(crate) fn new(running: usize, most: usize) -> Self {
        Self { running: Arc::new(Semaphore::new(running)), waiting: Arc::default(), most }
    }

    /// Computes on a thread of its own, with a flag that is raised once the returned future is dropped.
    ///
    /// # Errors
    /// [`Refusal`]: 503 where too many wait, 500 where a computation has ended without an answer.
    pub(crate) async fn run<T: Send + 'static>(
        &self,
        job: impl FnOnce(&Arc<AtomicBool>) -> Result<T, Refusal> + Send + 'static,
    ) -> Result<T, Refusal> {
        let place = Place(Arc::clone(&self.waiting));
        if self.waiting.fetch_add(1, Ordering::Relaxed) >= self.most {
            return Err(Refusal::new(503, "too many requests wait already: ask again later"));
        }
        let lost = || Refusal::new(500, "the computation has ended without an answer");
        let permit = Arc::clone(&self.running).acquire_owned().await.map_err(|_| lost())?;
        let stop = Arc::new(AtomicBool::new(false));
        let raise = Raise(Arc::clone(&stop));
        let done = spawn_blocking(move || {
            // Kept until the work has really ended: what was dropped still uses its thread until it has seen the flag.
            let _kept = (permit, place);
            job(&stop)
        });
        let result = done.await.map_err(|_| lost())?;
        drop(raise);
        result
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    fn on_one_thread(work: impl Future<Output = ()>) {
        tokio::runtime::Builder::new_current_thread().enable_time().build().unwrap().block_on(work);
    }

    #[test]
    fn what_nobody_waits_for_is_stopped_and_frees_its_place() {
        on_one_thread(async {
            let work = Work::new(1, 1);
            let ended = Arc::new(AtomicBool::new(false));
            let seen = Arc::clone(&ended);
            let job = work.run(move |stop| {
                while !stop.load(Ordering::Relaxed) {
                    std::thread::yield_now();
                }
                seen.store(true, Ordering::Relaxed);
                Ok(())
            });
            // The one place is taken, and then left.
            assert!(tokio::time::timeout(Duration::from_millis(20), job).await.is_err());
            while work.waiting.load(Ordering::Relaxed) > 0 {
                tokio::time::sleep(Duration::from_millis(1)).await;
            }
            assert!(ended.load(Ordering::Relaxed));
            assert_eq!(work.run(|_| Ok(7)).await, Ok(7));
        });
    }

    #[test]
    fn too_many_are_refused_and_a_panic_is_no_end_of_the_queue() {
        on_one_thread(async {
            let work = Work::new(1, 2);
            let slow = || {
                work.run(|stop| {
                    while !stop.load(Ordering::Relaxed) {
                        std::thread::yield_now();
                    }
                    Ok(())
                })
            };
            let (mut first, mut second) = (Box::pin(slow()), Box::pin(slow()));
            for job in [&mut first, &mut second] {
                assert!(tokio::time::timeout(Duration::from_millis(5), job).await.is_err());
            }
            assert_eq!(work.run(|_| Ok(())).await.unwrap_err().code, 503);
            drop((first, second));
            while work.waiting.load(Ordering::Relaxed) > 0 {
                tokio::time::sleep(Duration::from_millis(1)).await;
            }
            let broken = work.run(|_| -> Result<(), Refusal> { std::panic::resume_unwind(Box::new("broken")) }).await;
            assert_eq!(broken.unwrap_err().code, 500);
            assert_eq!(work.run(|_| Ok(8)).await, Ok(8));
        });
    }
}
