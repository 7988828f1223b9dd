//! Computations: so many at a time, so many in wait, ended when nobody waits for them any more.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use tokio::sync::Semaphore;
use tokio::task::spawn_blocking;
use vibrochain_lattice::Stop;

use crate::refusal::Refusal;

/// A queue of computations of one kind.
#[derive(Debug, Clone)]
pub(crate) struct Work {
    running: Arc<Semaphore>,
    at_once: usize,
    waiting: Arc<AtomicUsize>,
    most: usize,
    /// Those that run, the oldest first, where the oldest makes room for a new one.
    giving_way: Option<Arc<Mutex<Vec<Running>>>>,
}

/// A computation that runs.
#[derive(Debug, Clone)]
struct Running {
    stop: Arc<AtomicBool>,
    superseded: Arc<AtomicBool>,
}

/// A place in the queue.
struct Place(Arc<AtomicUsize>);

impl Drop for Place {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::Relaxed);
    }
}

/// A place among those that run.
struct Listed(Work, Arc<AtomicBool>);

impl Drop for Listed {
    fn drop(&mut self) {
        self.0.list(|running| running.retain(|other| !Arc::ptr_eq(&other.stop, &self.1)));
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
    /// For `at_once` at a time, and `most` with those that wait.
    pub(crate) fn new(at_once: usize, most: usize) -> Self {
        Self { running: Arc::new(Semaphore::new(at_once)), at_once, waiting: Arc::default(), most, giving_way: None }
    }

    /// The same for computations that may take minutes: a new one waits for no other, the oldest is ended for it.
    pub(crate) fn newest_first(at_once: usize, most: usize) -> Self {
        Self { giving_way: Some(Arc::default()), ..Self::new(at_once, most) }
    }

    /// Computes on a thread of its own, with a flag that is raised once the returned future is dropped.
    ///
    /// # Errors
    /// [`Refusal`]: 503 where too many wait, 409 where a newer one took the place, 500 where a computation has ended without an answer.
    pub(crate) async fn run<T: Send + 'static>(
        &self,
        job: impl FnOnce(&Stop) -> Result<T, Refusal> + Send + 'static,
    ) -> Result<T, Refusal> {
        let place = Place(Arc::clone(&self.waiting));
        if self.waiting.fetch_add(1, Ordering::Relaxed) >= self.most {
            return Err(Refusal::new(503, "too many requests wait already: ask again later"));
        }
        let lost = || Refusal::new(500, "the computation has ended without an answer");
        self.make_room();
        let permit = Arc::clone(&self.running).acquire_owned().await.map_err(|_| lost())?;
        let own = Running { stop: Arc::default(), superseded: Arc::default() };
        self.list(|running| running.push(own.clone()));
        let raise = Raise(Arc::clone(&own.stop));
        let Running { stop, superseded } = own;
        let listed = Listed(self.clone(), Arc::clone(&stop));
        let done = spawn_blocking(move || {
            // Kept until the work has really ended: what was dropped still uses its thread until it has seen the flag.
            let _kept = (permit, place, listed);
            job(&Stop::from(&stop))
        });
        let result = done.await.map_err(|_| lost())?;
        drop(raise);
        if superseded.load(Ordering::Relaxed) {
            return Err(Refusal::new(409, "a newer request has taken its place: ask again if it is still wanted"));
        }
        result
    }

    fn list(&self, change: impl FnOnce(&mut Vec<Running>)) {
        if let Some(running) = &self.giving_way {
            change(&mut running.lock().unwrap_or_else(PoisonError::into_inner));
        }
    }

    /// Ends the oldest that is still wanted, if all places are taken by such.
    fn make_room(&self) {
        self.list(|running| {
            let mut wanted = running.iter().filter(|one| !one.stop.load(Ordering::Relaxed));
            if let Some(oldest) = wanted.next()
                && wanted.count() + 1 >= self.at_once
            {
                oldest.superseded.store(true, Ordering::Relaxed);
                oldest.stop.store(true, Ordering::Relaxed);
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    fn on_one_thread(work: impl Future<Output = ()>) {
        tokio::runtime::Builder::new_current_thread().enable_time().build().unwrap().block_on(work);
    }

    /// A job that ends when it is told to, and not before.
    fn until_stopped(stop: &Stop) -> Result<(), Refusal> {
        while !stop.is_raised() {
            std::thread::yield_now();
        }
        Ok(())
    }

    #[test]
    fn what_nobody_waits_for_is_stopped_and_frees_its_place() {
        on_one_thread(async {
            let work = Work::new(1, 1);
            let ended = Arc::new(AtomicBool::new(false));
            let seen = Arc::clone(&ended);
            let job = work.run(move |stop| {
                until_stopped(stop)?;
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
            let (mut first, mut second) = (Box::pin(work.run(until_stopped)), Box::pin(work.run(until_stopped)));
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

    #[test]
    fn the_oldest_makes_room_for_a_new_one_where_work_is_long() {
        on_one_thread(async {
            let work = Work::newest_first(2, 4);
            let (mut first, mut second) = (Box::pin(work.run(until_stopped)), Box::pin(work.run(until_stopped)));
            for job in [&mut first, &mut second] {
                assert!(tokio::time::timeout(Duration::from_millis(5), job).await.is_err());
            }
            assert_eq!(work.run(|_| Ok(9)).await, Ok(9));
            assert_eq!(first.await.unwrap_err().code, 409);
            // The second still runs: of two places it takes one, and there was one left.
            assert!(tokio::time::timeout(Duration::from_millis(5), &mut second).await.is_err());
            assert_eq!(work.run(|_| Ok(10)).await, Ok(10));
            assert!(tokio::time::timeout(Duration::from_millis(5), second).await.is_err());
        });
    }
}
