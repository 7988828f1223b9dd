//! A run from its start to its end: what is the same for chains and structures.

use std::path::Path;
use std::time::Duration;

use vibrochain_eventsim::{Limits, Time};
use vibrochain_lattice::Stop;

use crate::args::SimulateArgs;
use crate::common::console::{Console, destinations};
use crate::common::error::CliError;
use crate::simulate::pace::Pace;
use crate::simulate::section::Section;
use crate::simulate::start;

/// Samples that may be asked for in all; more would be centuries of work.
const MAX_STEPS: u64 = 1 << 48;

impl SimulateArgs {
    /// The same with its length in periods.
    pub(crate) fn lasting(&self, period: f64) -> Result<Self, CliError> {
        let Some(time) = self.time else { return Ok(self.clone()) };
        ensure!((0.0..=f64::MAX).contains(&time), "--time {time} is out of range: give a number from 0");
        Ok(Self { periods: time / period, ..self.clone() })
    }

    /// The length of the run, as it was given.
    pub(crate) fn length(&self) -> String {
        self.time.map_or_else(|| format!("--periods {}", self.periods), |time| format!("--time {time}"))
    }

    /// The file of the state, if it is one.
    fn state_file(&self) -> Option<&Path> {
        self.state.as_deref().filter(|path| start::of_no_file(path).is_none())
    }
}

/// Checks how long the run is and what files it has; whether standard output is taken by one.
pub(crate) fn checked(args: &SimulateArgs) -> Result<bool, CliError> {
    let (samples, periods) = (args.samples, args.periods);
    let allowed = (1..=1_000_000).contains(&samples);
    ensure!(allowed, "--samples {samples} is out of range: give a whole number from 1 to 1000000");
    ensure!((0.0..=f64::MAX).contains(&periods), "{} is out of range: give a number from 0", args.length());
    ensure!(
        periods * samples as f64 <= MAX_STEPS as f64,
        "{} with {samples} samples a period is out of range: give at most {MAX_STEPS} samples in all",
        args.length()
    );
    destinations(
        args.json,
        &[
            ("--scene", args.model.scene.as_deref()),
            ("--near", args.which.near.as_deref()),
            ("--state", args.state_file()),
        ],
        &[
            ("--impacts", args.impacts.as_deref()),
            ("--trajectory", args.trajectory.as_deref()),
            ("--section", args.section.as_deref()),
            ("--plot", args.plot.as_deref()),
            ("--animate", args.animate.as_deref()),
        ],
    )
}

/// Between two looks at how far a long run is.
const PORTION: Duration = Duration::from_millis(100);

/// How far a simulation has come.
#[derive(PartialEq)]
pub(crate) enum Reached {
    /// The time that was asked for.
    Time,
    /// Where it was told to stop.
    Stopped,
    /// Its end.
    End,
}

/// A simulation with what is kept of it.
pub(crate) trait Run {
    /// `periods` periods of the force and the `part` of one more, as a limit.
    fn time_of(&self, periods: u64, part: f64) -> Time;
    /// Goes on to these limits, or until it is to stop, and takes note of all events.
    fn advance(&mut self, limits: &Limits, stop: &Stop) -> Result<Reached, CliError>;
    /// Present time, and the impacts up to it.
    fn now(&self) -> (Time, u64);
    /// Takes a sample.
    fn look(&mut self) -> Result<(), CliError>;
    fn section(&mut self) -> Option<&mut Section>;
    /// Places and velocities of all masses or contacts.
    fn state(&self) -> [Vec<f64>; 2];
}

/// Runs to the end, with so many samples a period (0: a look at the end alone), in portions of time, so that Ctrl-C is heard and people are told
/// however long a period takes. Whether it was.
pub(crate) fn follow(
    run: &mut impl Run,
    args: &SimulateArgs,
    samples: u64,
    stop: &Stop,
    console: &mut Console<'_>,
) -> Result<bool, CliError> {
    let periods = args.periods;
    let end = run.time_of(periods.trunc() as u64, periods.fract());
    // The last sample is at the end.
    let sampled = (periods * samples as f64) as u64;
    let total = sampled + u64::from(samples == 0 || sampled as f64 / (samples as f64) < periods);
    let mut pace = Pace::new(args, console);
    let mut reached = run.advance(&Limits::until(run.time_of(0, 0.0)), stop)?;
    let (mut step, mut stopped) = (0, stop.is_raised());
    loop {
        run.look()?;
        if stopped || reached != Reached::Time || step >= total {
            pace.finish();
            return Ok(stopped);
        }
        step += 1;
        let part = (step % samples.max(1)) as f64 / samples as f64;
        let time = if step > sampled { end } else { run.time_of(step / samples, part) };
        // With the looks of the section on the way.
        loop {
            let look = run.section().and_then(|section| section.due(time));
            let left = args.max_impacts.map_or(u64::MAX, |most| most.saturating_sub(run.now().1));
            let until = look.or(Some(time));
            reached = run.advance(&Limits { until, impacts: left, ..Limits::default() }, &stop.within(PORTION))?;
            stopped = stop.is_raised();
            let (now, impacts) = run.now();
            pace.see(now, impacts, console);
            if look.is_some() && reached == Reached::Time {
                let [places, velocities] = run.state();
                run.section().map_or(Ok(()), |section| section.look(now, &places, &velocities))?;
            } else if reached != Reached::Stopped {
                break;
            }
            if stopped {
                break;
            }
        }
    }
}
