//! What is written as it comes: standard output, pipes, devices.

use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
#[cfg(unix)]
use std::sync::OnceLock;

use vibrochain_lattice::Stop;

/// A place to write to where nothing can be put in its stead.
#[derive(Debug)]
pub(super) struct Stream {
    /// Standard output if there is none.
    path: Option<PathBuf>,
    /// Opened with the first byte: whoever only wants to know whether it can be written must not end what its reader reads.
    open: Option<Open>,
}

#[derive(Debug)]
struct Open {
    file: File,
    /// Its reader may keep us waiting.
    waits: bool,
}

/// Raised by signals.
static STOP: OnceLock<Stop> = OnceLock::new();

/// Names what ends a wait for whoever reads a pipe. A process has one such request: later calls change nothing.
pub fn halt_on(stop: &Stop) {
    STOP.get_or_init(|| stop.clone());
}

#[cfg(unix)]
fn is_stopped() -> bool {
    STOP.get().is_some_and(Stop::is_raised)
}

/// Why a write ended: the user has asked for it, while nobody was reading.
#[derive(Debug, thiserror::Error)]
#[error("interrupted")]
pub(super) struct Halted;

/// How long to wait for a reader before looking at the stop flag again.
#[cfg(unix)]
const LOOK: std::time::Duration = std::time::Duration::from_millis(50);

/// What a pipe takes at once whenever it takes anything: a page, on every system that has them.
#[cfg(unix)]
const PAGE: usize = 4096;

impl Stream {
    /// To standard output.
    ///
    /// # Errors
    /// If it takes nothing.
    pub(super) fn to_standard_output() -> io::Result<Self> {
        system::takes_bytes(&system::standard_output()?)?;
        Ok(Self { path: None, open: None })
    }

    /// To what is at `path`.
    ///
    /// # Errors
    /// If it may not be written.
    pub(super) fn to(path: &Path) -> io::Result<Self> {
        system::may_write(path)?;
        Ok(Self { path: Some(path.to_owned()), open: None })
    }

    /// Whether it is standard output.
    pub(super) fn is_standard_output(&self) -> bool {
        self.path.is_none()
    }

    fn opened(&mut self) -> io::Result<&mut Open> {
        let open = match (self.open.take(), &self.path) {
            (Some(open), _) => open,
            (None, Some(path)) => system::open(path)?,
            (None, None) => {
                let file = system::standard_output()?;
                let waits = !file.metadata().is_ok_and(|found| found.is_file());
                Open { file, waits }
            }
        };
        Ok(self.open.insert(open))
    }
}

impl Write for Stream {
    /// All of it, unless something goes wrong on the way.
    fn write(&mut self, buffer: &[u8]) -> io::Result<usize> {
        let open = self.opened()?;
        let mut done = 0;
        while let Some(rest) = buffer.get(done..).filter(|rest| !rest.is_empty()) {
            match open.some(rest) {
                Ok(0) => break,
                Ok(count) => done += count,
                Err(error) if done == 0 => return Err(error),
                // The next call meets it again.
                Err(_) => break,
            }
        }
        Ok(done)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.opened()?.file.flush()
    }
}

#[cfg(unix)]
mod system {
    use std::fs::{self, File};
    use std::io::{self, Write};
    use std::os::fd::AsFd;
    use std::os::unix::fs::FileTypeExt;
    use std::path::Path;

    use rustix::event::{PollFd, PollFlags, Timespec, poll};
    use rustix::fs::{Access, Mode, OFlags, access, fcntl_setfl, open as open_file};
    use rustix::io::Errno;

    use super::is_stopped;
    use super::{Halted, LOOK, Open, PAGE};

    fn halt_if_stopped() -> io::Result<()> {
        if is_stopped() { Err(io::Error::other(Halted)) } else { Ok(()) }
    }

    /// Standard output without the standard library's own buffer of lines.
    pub(super) fn standard_output() -> io::Result<File> {
        io::stdout().as_fd().try_clone_to_owned().map(File::from)
    }

    pub(super) fn may_write(path: &Path) -> io::Result<()> {
        access(path, Access::WRITE_OK)?;
        // A device has no reader who would be told that it is opened.
        if fs::metadata(path)?.file_type().is_char_device() { takes_bytes(&open(path)?.file) } else { Ok(()) }
    }

    /// Whether a device takes anything: one that is full (`/dev/full`) refuses no bytes, too. Nobody else is asked, as a pipe may be closed
    /// without a fault, and a disk tells only with the bytes.
    pub(super) fn takes_bytes(mut file: &File) -> io::Result<()> {
        if file.metadata()?.file_type().is_char_device() { file.write(&[]).map(drop) } else { Ok(()) }
    }

    /// What is no plain file, or one that somebody has opened: then what is in it is theirs, and stays.
    pub(super) fn open(path: &Path) -> io::Result<Open> {
        let found = fs::metadata(path)?;
        let mode = if found.is_file() { OFlags::APPEND } else { OFlags::empty() };
        let flags = OFlags::WRONLY | OFlags::CLOEXEC | OFlags::NOCTTY | mode;
        loop {
            match open_file(path, flags | OFlags::NONBLOCK, Mode::empty()) {
                Ok(descriptor) => {
                    fcntl_setfl(&descriptor, mode)?;
                    return Ok(Open { file: descriptor.into(), waits: !found.is_file() });
                }
                // Nobody reads yet.
                Err(Errno::NXIO) if found.file_type().is_fifo() => {
                    halt_if_stopped()?;
                    std::thread::sleep(LOOK);
                }
                Err(Errno::INTR) => {}
                Err(error) => return Err(error.into()),
            }
        }
    }

    impl Open {
        /// Writes what can be written at once, if need be after a wait that ends with the stop flag.
        pub(super) fn some(&mut self, buffer: &[u8]) -> io::Result<usize> {
            if !self.waits {
                return self.file.write(buffer);
            }
            let wait = Timespec { tv_sec: 0, tv_nsec: LOOK.subsec_nanos().into() };
            loop {
                match poll(&mut [PollFd::new(&self.file, PollFlags::OUT)], Some(&wait)) {
                    Ok(0) | Err(Errno::INTR) => halt_if_stopped()?,
                    // Also where it cannot be known, or nobody reads any more: the write tells.
                    Ok(_) | Err(_) => return self.file.write(&buffer[..buffer.len().min(PAGE)]),
                }
            }
        }
    }
}

#[cfg(not(unix))]
mod system {
    use std::fs::{File, OpenOptions};
    use std::io::{self, Write};
    use std::path::Path;

    use super::Open;

    pub(super) fn standard_output() -> io::Result<File> {
        #[cfg(windows)]
        return std::os::windows::io::AsHandle::as_handle(&io::stdout()).try_clone_to_owned().map(File::from);
        #[cfg(not(windows))]
        Err(io::ErrorKind::Unsupported.into())
    }

    pub(super) fn may_write(_: &Path) -> io::Result<()> {
        Ok(())
    }

    pub(super) fn takes_bytes(_: &File) -> io::Result<()> {
        Ok(())
    }

    pub(super) fn open(path: &Path) -> io::Result<Open> {
        Ok(Open { file: OpenOptions::new().append(true).open(path)?, waits: true })
    }

    impl Open {
        pub(super) fn some(&mut self, buffer: &[u8]) -> io::Result<usize> {
            self.file.write(buffer)
        }
    }
}
