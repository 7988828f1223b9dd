//! How long one evaluation takes.

use std::hint::black_box;
use std::time::{Duration, Instant};

use indicatif::ProgressBar;

use vibrochain_cli::common::error::CliError;
use vibrochain_lattice::Stop;

/// Batches whose least mean is the answer.
const BATCHES: u32 = 5;

/// All batches together take at least this long.
const TOTAL: Duration = Duration::from_millis(20);

/// An evaluation longer than this is not repeated.
const LONG: Duration = Duration::from_millis(300);

/// Takes times, tells of progress and hears Ctrl-C.
pub(super) struct Meter<'a> {
    stop: &'a Stop,
    bar: &'a ProgressBar,
    quick: bool,
    suite: &'static str,
}

impl<'a> Meter<'a> {
    pub(super) fn new(stop: &'a Stop, bar: &'a ProgressBar, quick: bool) -> Self {
        Self { stop, bar, quick, suite: "" }
    }

    /// Begins a suite.
    pub(super) fn enter(&mut self, suite: &'static str) {
        self.suite = suite;
        self.bar.set_message(suite);
    }

    /// Says what is under way.
    pub(super) fn tell(&self, case: &str, method: &str, setting: &str) {
        self.bar.set_message(format!("{}: {case}: {method}, {setting}", self.suite));
    }

    /// Says what is under way, in one phrase.
    pub(super) fn say(&self, what: &str) {
        self.bar.set_message(format!("{}: {what}", self.suite));
    }

    /// A look is wanted, not a measurement.
    pub(super) fn is_quick(&self) -> bool {
        self.quick
    }

    /// Ends the run if Ctrl-C was pressed.
    ///
    /// # Errors
    /// [`CliError::Interrupted`].
    pub(super) fn go_on(&self) -> Result<(), CliError> {
        if self.stop.is_raised() { Err(CliError::Interrupted) } else { Ok(()) }
    }

    /// The value of `evaluate` and the seconds one call takes.
    ///
    /// # Errors
    /// Those of `evaluate`, [`CliError::Interrupted`].
    pub(super) fn time<R>(&self, mut evaluate: impl FnMut() -> Result<R, CliError>) -> Result<(R, f64), CliError> {
        let mut batch = |calls: u32| -> Result<(R, Duration), CliError> {
            self.go_on()?;
            let start = Instant::now();
            let mut value = black_box(evaluate()?);
            for _ in 1..calls {
                value = black_box(evaluate()?);
            }
            Ok((value, start.elapsed()))
        };
        let share = if self.quick { TOTAL / 100 } else { TOTAL } / BATCHES;
        let mut calls = 1_u32;
        let (mut value, mut spent) = batch(calls)?;
        if spent > LONG {
            return Ok((value, spent.as_secs_f64()));
        }
        // The first calls are slow ones, memory being cold: batches grow until one fills its share.
        while spent < share {
            let growth = (share.as_secs_f64() / spent.as_secs_f64().max(1e-9)).clamp(1.3, 10.0);
            calls = (f64::from(calls) * growth).ceil() as u32;
            (value, spent) = batch(calls)?;
        }
        let mut least = spent;
        for _ in 1..BATCHES {
            let (again, spent) = batch(calls)?;
            (value, least) = (again, least.min(spent));
        }
        Ok((value, least.as_secs_f64() / f64::from(calls)))
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, Ordering};

    use super::*;

    #[test]
    fn every_call_counts_and_ctrl_c_ends_it() {
        let (flag, bar) = (Arc::new(AtomicBool::new(false)), ProgressBar::hidden());
        let stop = Stop::from(&flag);
        let meter = Meter::new(&stop, &bar, true);
        let mut calls = 0;
        let ((), seconds) = meter
            .time(|| {
                calls += 1;
                Ok(())
            })
            .unwrap();
        assert!(calls >= BATCHES as usize && seconds > 0.0 && seconds < 1.0, "{calls} {seconds}");
        let wrong = meter.time::<()>(|| Err(CliError::Computation("no".to_owned()))).unwrap_err();
        assert_eq!(wrong.exit_code(), 1);
        flag.store(true, Ordering::Relaxed);
        assert!(matches!(meter.time(|| Ok(())), Err(CliError::Interrupted)));
    }
}
