//! How far a long simulation is and how long it will take, for people: a bar on a terminal, elsewhere a line now and then.

use std::time::{Duration, Instant};

use indicatif::ProgressBar;
use vibrochain_eventsim::Time;

use crate::args::SimulateArgs;
use crate::common::console::Console;
use crate::common::error::CliError;
use crate::common::progress::bar;
use vibrochain_maps::text::duration;

/// Where no terminal shows a bar, the first line comes after this time, each further one when the time has doubled: a short
/// run says nothing, a log of days holds some twenty lines.
const PATIENCE: Duration = Duration::from_secs(2);

/// Steps of the bar.
const STEPS: u64 = 1_000_000;

/// A time in periods, in digits that tell it from zero.
pub(crate) fn periods(time: Time) -> String {
    let periods = time.in_periods();
    if periods == 0.0 || periods >= 1e-3 { format!("{periods:.6}") } else { format!("{periods:.3e}") }
}

/// The pace of a run.
pub(crate) struct Pace {
    bar: ProgressBar,
    begun: Instant,
    next: Duration,
    periods: f64,
    /// The same in units of time, where it was given so.
    time: Option<f64>,
    impacts: Option<u64>,
}

impl Pace {
    /// Of a run that ends after so many periods, or impacts if they come first.
    pub(crate) fn new(args: &SimulateArgs, console: &Console<'_>) -> Self {
        let bar = bar(STEPS, "{bar:32} {percent:>3}%  {msg}", console.progress);
        let SimulateArgs { periods, time, max_impacts: impacts, .. } = *args;
        Self { bar, begun: Instant::now(), next: PATIENCE, periods, time, impacts }
    }

    /// Tells, if it is time to.
    pub(crate) fn see(&mut self, time: Time, impacts: u64, console: &mut Console<'_>) {
        let elapsed = self.begun.elapsed();
        // The bar draws itself less often than it is told.
        let due = if console.progress { Duration::from_millis(100) } else { elapsed };
        if elapsed < self.next {
            return;
        }
        self.next = elapsed + due;
        let part = self.part(time, impacts);
        let text = self.text(time, impacts, part, elapsed);
        if console.progress {
            self.bar.set_position((part * STEPS as f64) as u64);
            self.bar.set_message(text);
        } else {
            let advice = "Ctrl-C ends it here and keeps its files";
            console.summary(&format!("after {}: {text}; {advice}", duration(elapsed.as_secs_f64())));
        }
    }

    pub(crate) fn finish(self) {
        self.bar.finish_and_clear();
    }

    /// The part of the run that is done.
    fn part(&self, time: Time, impacts: u64) -> f64 {
        let time = time.in_periods() / self.periods.max(f64::MIN_POSITIVE);
        let impacts = self.impacts.map_or(0.0, |most| impacts as f64 / most.max(1) as f64);
        time.max(impacts).min(1.0)
    }

    fn text(&self, time: Time, impacts: u64, part: f64, elapsed: Duration) -> String {
        let left = elapsed.as_secs_f64() * (1.0 - part) / part;
        let left =
            if left.is_finite() { format!("about {} left", duration(left)) } else { "no end in sight".to_owned() };
        format!("{}, {impacts} impacts, {left}", so_far(time, self.periods, self.time))
    }
}

/// How far a run has come of so many periods, which are as long as `length`, if that was given.
fn so_far(time: Time, all: f64, length: Option<f64>) -> String {
    match length {
        Some(length) => format!("t = {:.6} of {length}", time.in_periods() * (length / all)),
        None => format!("{} of {all} periods", periods(time)),
    }
}

/// What is told of a run that was stopped at `time`.
pub(crate) fn interrupted(args: &SimulateArgs, time: Time) -> CliError {
    let files = [&args.impacts, &args.trajectory, &args.section, &args.plot, &args.animate].into_iter().flatten();
    let files: Vec<String> = files.map(|path| path.display().to_string()).collect();
    let kept = match files.as_slice() {
        [] => "no file was asked for".to_owned(),
        [one] => format!("{one} holds the run up to there"),
        several => format!("{} hold the run up to there", several.join(", ")),
    };
    CliError::Paused(format!("the run ends after {}; {kept}", so_far(time, args.periods, args.time)))
}

#[cfg(test)]
mod tests {
    use vibrochain_lattice::{Chain, Model};

    use super::*;

    #[test]
    fn what_is_left_follows_from_time_or_impacts_whichever_end_is_nearer() {
        let model = Model::conservative(Chain::new(1, 1.0, 0.0).unwrap(), 2.0, 0.0).unwrap();
        let quiet = |pace: &Pace, part: f64, impacts: u64, seconds: u64| {
            let time = Time::new(&model, 0, part);
            pace.text(time, impacts, pace.part(time, impacts), Duration::from_secs(seconds))
        };
        let of = |periods: f64, time: Option<f64>, impacts: Option<u64>| Pace {
            bar: ProgressBar::hidden(),
            begun: Instant::now(),
            next: PATIENCE,
            periods,
            time,
            impacts,
        };
        let pace = of(20.0, None, None);
        assert_eq!(quiet(&pace, 5.0, 10, 10), "5.000000 of 20 periods, 10 impacts, about 30.0 s left");
        assert_eq!(quiet(&pace, 2e-9, 7, 10), "2.000e-9 of 20 periods, 7 impacts, about 3168.8 years left");
        assert_eq!(quiet(&pace, 0.0, 0, 10), "0.000000 of 20 periods, 0 impacts, no end in sight");
        let pace = of(20.0, None, Some(100));
        assert_eq!(quiet(&pace, 2.0, 50, 10), "2.000000 of 20 periods, 50 impacts, about 10.0 s left");
        let short = of(0.25, None, None);
        assert_eq!(quiet(&short, 0.125, 0, 4), "0.125000 of 0.25 periods, 0 impacts, about 4.0 s left");
        let timed = of(8.0, Some(12.0), None);
        assert_eq!(quiet(&timed, 2.0, 3, 10), "t = 3.000000 of 12, 3 impacts, about 30.0 s left");
    }
}
