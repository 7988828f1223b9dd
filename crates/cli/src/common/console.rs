//! What a run has besides its files: where answers and remarks go, and how it learns that it is to stop.

use std::io::{self, Write};
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, OnceLock};

use crate::common::error::CliError;
use vibrochain_lattice::{Stop, Stopped, aside};
use vibrochain_maps::files::{distinct, halt_on};
use vibrochain_maps::text::printable;

/// The surroundings of a run. The program's are the terminal and its Ctrl-C; a test brings its own.
pub struct Console<'a> {
    /// Answers.
    pub out: &'a mut dyn Write,
    /// Summaries, remarks and errors.
    pub err: &'a mut dyn Write,
    /// Whether standard error is a terminal, where long work may draw a progress bar.
    pub progress: bool,
    /// Whether summaries, and answers in words, are to be left out.
    pub quiet: bool,
    /// Whether inner workings are to be told.
    pub verbose: bool,
    /// Threads to compute on, if their number was asked for.
    pub threads: Option<usize>,
    /// Hands out what tells long work to stop. Asked only by commands that look at it, before they begin a file.
    pub interrupt: &'a dyn Fn() -> Result<Stop, CliError>,
}

impl<'a> Console<'a> {
    /// Without a terminal, with summaries, and on as many threads as there are cores.
    pub fn new(
        out: &'a mut dyn Write,
        err: &'a mut dyn Write,
        interrupt: &'a dyn Fn() -> Result<Stop, CliError>,
    ) -> Self {
        Self { out, err, progress: false, quiet: false, verbose: false, threads: None, interrupt }
    }

    /// Prints the answer of a command.
    ///
    /// # Errors
    /// [`CliError::Computation`] if the answer cannot be written; a reader that has seen enough (`| head`) is no failure.
    pub fn print(&mut self, text: &str) -> Result<(), CliError> {
        printed(self.out.write_all(text.as_bytes()).and_then(|()| self.out.flush()))
    }

    /// Prints an answer: as JSON, or in words, of which quiet has none. Where a file of the command is standard output (`taken`)
    /// words do not belong into a table or a picture, they are then remarks.
    ///
    /// # Errors
    /// As [`Console::print`].
    pub fn answer(&mut self, text: &str, json: bool, taken: bool) -> Result<(), CliError> {
        if json || !taken && !self.quiet {
            return self.print(text);
        }
        self.summary(text.trim_end());
        Ok(())
    }

    /// A remark that says how something went well: nobody misses it who has asked for quiet.
    pub fn summary(&mut self, text: &str) {
        if !self.quiet {
            self.remark(text);
        }
    }

    /// A remark for people, who may be shown names and words from files of others. With nobody left to read it, it is no
    /// reason to fail.
    pub fn remark(&mut self, text: &str) {
        let _ = writeln!(self.err, "{}", printable(text));
    }
}

/// What became of an answer that was printed. A reader that has seen enough (`| head`) is no failure.
///
/// # Errors
/// [`CliError::Computation`] if it could not be written.
pub(crate) fn printed(written: io::Result<()>) -> Result<(), CliError> {
    match written {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(CliError::Computation(format!("cannot write to standard output: {error}")))
        }
        _ => Ok(()),
    }
}

/// [`distinct`], and JSON is not printed where a file goes already.
pub(crate) fn destinations(
    json: bool,
    inputs: &[(&'static str, Option<&Path>)],
    outputs: &[(&'static str, Option<&Path>)],
) -> Result<bool, CliError> {
    let taken = distinct(inputs, outputs)?;
    ensure!(!(json && taken), "--json prints to standard output, where another file goes: name a file for that one");
    Ok(taken)
}

/// Raised by signals; or why it cannot be.
static STOP: OnceLock<Result<Stop, String>> = OnceLock::new();

/// What Ctrl-C, SIGTERM and SIGHUP raise. A process has one handler of signals, so it has one such request to stop: the first
/// call installs it, later ones hand out the same. A signal that is ignored already, as SIGHUP under `nohup`, stays so.
///
/// # Errors
/// [`CliError::Computation`] if the handler cannot be installed.
pub fn ctrl_c() -> Result<Stop, CliError> {
    let stop = STOP.get_or_init(|| {
        let flag = Arc::new(AtomicBool::new(false));
        let installed = listen(&flag);
        let stop = Stop::from(&flag);
        halt_on(&stop);
        installed.map(|()| stop).map_err(|error| format!("cannot listen for Ctrl-C: {error}"))
    });
    stop.clone().map_err(CliError::Computation)
}

/// Does work that does not look at signals, as reading a scene with all its modes is, on a thread of its own.
///
/// # Errors
/// [`CliError::Interrupted`] by a signal, at once; [`CliError::Computation`] if none can be heard.
pub(crate) fn interruptible<T: Send + 'static>(work: impl FnOnce() -> T + Send + 'static) -> Result<T, CliError> {
    aside(&ctrl_c()?, work).map_err(|Stopped| CliError::Interrupted)
}

#[cfg(unix)]
fn listen(flag: &Arc<AtomicBool>) -> io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let ignored = std::fs::read_to_string("/proc/self/status").map_or(0, |status| ignored_signals(&status));
    for signal in [SIGHUP, SIGINT, SIGTERM] {
        if ignored >> (signal - 1) & 1 == 0 {
            signal_hook::flag::register(signal, Arc::clone(flag))?;
        }
    }
    Ok(())
}

/// The signals that a process ignores, as Linux tells them: the first in the lowest bit. Elsewhere nobody tells.
#[cfg(unix)]
fn ignored_signals(status: &str) -> u64 {
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0)
}

#[cfg(not(unix))]
fn listen(flag: &Arc<AtomicBool>) -> Result<(), ctrlc::Error> {
    let raised = Arc::clone(flag);
    ctrlc::set_handler(move || raised.store(true, std::sync::atomic::Ordering::Relaxed))
}

/// Makes a write beyond the limit on the size of files (`ulimit -f`) an error like that of a full disk; unasked, the system
/// would end the process.
pub fn survive_file_limit() {
    #[cfg(unix)]
    {
        // Where it cannot be done, such a write ends the process, and what it has finished is still there.
        let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::new(AtomicBool::new(false)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_process_may_run_many_commands() {
        let (first, second) = (ctrl_c().unwrap(), ctrl_c().unwrap());
        assert!(!first.is_raised() && !second.is_raised());
    }

    #[cfg(unix)]
    #[test]
    fn ignored_signals_are_read_bit_by_bit() {
        use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
        let set = |mask: &str| {
            let status = format!("Name:\tmapgen\nSigBlk:\t0000000000000001\nSigIgn:\t{mask}\nSigCgt:\t4002\n");
            let ignored = ignored_signals(&status);
            [SIGHUP, SIGINT, SIGTERM].map(|signal| ignored >> (signal - 1) & 1 == 1)
        };
        assert_eq!(set("0000000000001000"), [false; 3]);
        assert_eq!(set("0000000000001001"), [true, false, false]);
        assert_eq!(set("0000000000004002"), [false, true, true]);
        assert_eq!((ignored_signals(""), ignored_signals("SigIgn:\tx\n")), (0, 0));
    }

    #[test]
    fn a_closed_pipe_is_no_failure_and_a_full_disk_is() {
        struct Broken(io::ErrorKind);
        impl Write for Broken {
            fn write(&mut self, _: &[u8]) -> io::Result<usize> {
                Err(self.0.into())
            }
            fn flush(&mut self) -> io::Result<()> {
                Ok(())
            }
        }
        let print = |kind| {
            let (mut out, mut err) = (Broken(kind), Broken(kind));
            let mut console = Console::new(&mut out, &mut err, &ctrl_c);
            console.remark("nobody reads this");
            console.print("answer")
        };
        assert!(print(io::ErrorKind::BrokenPipe).is_ok());
        let message = print(io::ErrorKind::StorageFull).unwrap_err().to_string();
        assert!(message.starts_with("cannot write to standard output: "), "{message}");
    }
}
