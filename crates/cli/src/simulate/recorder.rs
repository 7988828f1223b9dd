//! What a run hands to those who keep something of it.

use vibrochain_eventsim::{Event, Simulation};

use crate::common::error::CliError;

/// What is kept of a run.
pub(crate) trait Recorder {
    /// Takes note of an event.
    fn event(&mut self, _: &Event) {}

    /// Takes a sample.
    fn look(&mut self, _: &Simulation) -> Result<(), CliError> {
        Ok(())
    }

    /// The first row of an event that could not be written, once; the simulation cannot stop for it at once.
    fn failed(&mut self) -> Option<CliError> {
        None
    }
}

impl<R: Recorder> Recorder for Option<R> {
    fn event(&mut self, event: &Event) {
        self.iter_mut().for_each(|recorder| recorder.event(event));
    }

    fn look(&mut self, simulation: &Simulation) -> Result<(), CliError> {
        self.as_mut().map_or(Ok(()), |recorder| recorder.look(simulation))
    }

    fn failed(&mut self) -> Option<CliError> {
        self.as_mut().and_then(Recorder::failed)
    }
}
