//! The file of one chunk: a line that says what it is, rows of the table, a line with their counts, a checksum.
//!
//! ```text
//! vibrochain-chunk 1 IDENTITY chunk 12 cells 98304..106496
//! 0.1,1.5,stable-double,…
//! summary classes 0,8192,… statuses 8192,0,… worst_residual 8.9e-16
//! checksum XXH3-128 OF ALL ABOVE
//! ```

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::Path;

use xxhash_rust::xxh3::Xxh3;

use crate::error::CliError;
use crate::output::Output;
use crate::sweep::plan::FORMAT;
use crate::sweep::{Plan, Summary};

/// Enough for the last two lines.
const TAIL: u64 = 1024;

/// `checksum `, 32 digits, end of line.
const CHECKSUM: u64 = 42;

/// What is wrong with a chunk.
#[derive(Debug)]
pub(crate) enum Fault {
    /// It is not there.
    Missing,
    /// It cannot be read.
    Unreadable(io::Error),
    /// Its bytes are not those that were written.
    Damaged(&'static str),
    /// It is sound, but of another sweep.
    Foreign,
}

impl std::fmt::Display for Fault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Missing => f.write_str("it is missing"),
            Self::Unreadable(error) => write!(f, "it cannot be read: {error}"),
            Self::Damaged(how) => write!(f, "it is damaged: {how}"),
            Self::Foreign => f.write_str("it belongs to another sweep"),
        }
    }
}

impl From<io::Error> for Fault {
    fn from(error: io::Error) -> Self {
        if error.kind() == io::ErrorKind::NotFound { Self::Missing } else { Self::Unreadable(error) }
    }
}

fn first_line(plan: &Plan, chunk: u64) -> String {
    let Range { start, end } = plan.range(chunk);
    format!("vibrochain-chunk {FORMAT} {:032x} chunk {chunk} cells {start}..{end}\n", plan.identity)
}

fn listed(counts: &[u64]) -> String {
    counts.iter().map(u64::to_string).collect::<Vec<_>>().join(",")
}

fn summary_line(summary: &Summary) -> String {
    let (classes, statuses) = (listed(&summary.classes), listed(&summary.statuses));
    format!("summary classes {classes} statuses {statuses} worst_residual {:e}\n", summary.worst_residual)
}

fn read_summary(line: &str) -> Option<Summary> {
    let mut summary = Summary::default();
    let words: Vec<&str> = line.strip_suffix('\n')?.split(' ').collect();
    let ["summary", "classes", classes, "statuses", statuses, "worst_residual", residual] = words.as_slice() else {
        return None;
    };
    let read = |text: &str, counts: &mut [u64]| {
        let given: Vec<u64> = text.split(',').map(str::parse).collect::<Result<_, _>>().ok()?;
        (given.len() == counts.len()).then(|| counts.copy_from_slice(&given))
    };
    read(classes, &mut summary.classes)?;
    read(statuses, &mut summary.statuses)?;
    summary.worst_residual = residual.parse().ok()?;
    Some(summary)
}

/// A chunk under way. Dropped before [`Writer::place`], it leaves nothing behind.
pub(crate) struct Writer {
    output: Output,
    hash: Box<Xxh3>,
    summary: Summary,
}

impl Writer {
    /// Opens the temporary file.
    pub(crate) fn new(path: &Path, plan: &Plan, chunk: u64) -> Result<Self, CliError> {
        let mut writer = Self { output: Output::beside(path)?, hash: Box::default(), summary: Summary::default() };
        writer.write(first_line(plan, chunk).as_bytes())?;
        Ok(writer)
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), CliError> {
        self.hash.update(bytes);
        self.output.write_all(bytes).map_err(|error| self.output.unwritten(&error))
    }

    /// Writes rows and counts them.
    pub(crate) fn rows(&mut self, rows: &[u8], summary: &Summary) -> Result<(), CliError> {
        self.summary.add(summary);
        self.write(rows)
    }

    /// Writes the last two lines.
    pub(crate) fn close(&mut self) -> Result<(), CliError> {
        let line = summary_line(&self.summary);
        self.hash.update(line.as_bytes());
        // At once: after a failure both are held.
        let tail = format!("{line}checksum {:032x}\n", self.hash.digest128());
        self.output.write_all(tail.as_bytes()).map_err(|error| self.output.unwritten(&error))?;
        self.flush()
    }

    /// Hands to the system what it has not got yet. After a failure nothing is lost: it may be tried again.
    pub(crate) fn flush(&mut self) -> Result<(), CliError> {
        self.output.flush().map_err(|error| self.output.unwritten(&error))
    }

    /// Sees to it that the disk has all of a chunk that is closed, and puts the file in its place.
    pub(crate) fn place(self) -> Result<(), CliError> {
        self.output.commit()
    }

    /// Closes and places.
    #[cfg(test)]
    pub(crate) fn finish(mut self) -> Result<(), CliError> {
        self.close()?;
        self.place()
    }
}

/// Takes what passes into the checksum.
struct Hashed<R> {
    inner: R,
    hash: Box<Xxh3>,
}

impl<R: Read> Read for Hashed<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.inner.read(buffer)?;
        self.hash.update(&buffer[..count]);
        Ok(count)
    }
}

/// Hands the rows of a chunk to `take`, some bytes at a time, and then tells whether they can be trusted. What `take` has
/// got must be thrown away if not.
pub(crate) fn read<E: From<Fault>>(
    path: &Path,
    plan: &Plan,
    chunk: u64,
    mut take: impl FnMut(&[u8]) -> Result<(), E>,
) -> Result<Summary, E> {
    let (mut file, tail) = open(path)?;
    let length = tail.length;
    let mut reader = Hashed { inner: BufReader::new((&mut file).take(length - CHECKSUM)), hash: Box::default() };
    let first = first_line(plan, chunk);
    let mut found = vec![0; first.len().min((length - CHECKSUM) as usize)];
    reader.read_exact(&mut found).map_err(Fault::from)?;
    // An honest chunk of another sweep has another first line, a damaged one may have anything.
    let foreign = found != first.as_bytes();
    let summary = read_summary(&tail.summary);
    let rows = (length - CHECKSUM - found.len() as u64).checked_sub(tail.summary.len() as u64);
    let mut left = if foreign { 0 } else { rows.unwrap_or(0) };
    let mut buffer = vec![0; 1 << 16];
    while left > 0 {
        let some = reader.by_ref().take(left).read(&mut buffer).map_err(Fault::from)?;
        if some == 0 {
            return Err(Fault::Damaged("it is cut short").into());
        }
        take(&buffer[..some])?;
        left -= some as u64;
    }
    io::copy(&mut reader, &mut io::sink()).map_err(Fault::from)?;
    if tail.checksum != format!("checksum {:032x}\n", reader.hash.digest128()) {
        return Err(Fault::Damaged("its checksum is wrong").into());
    }
    if foreign {
        return Err(Fault::Foreign.into());
    }
    let range = plan.range(chunk);
    match summary {
        Some(summary) if summary.cells() == range.end - range.start => Ok(summary),
        _ => Err(Fault::Damaged("its counts are wrong").into()),
    }
}

/// Tells whether a chunk can be trusted.
pub(crate) fn check(path: &Path, plan: &Plan, chunk: u64) -> Result<Summary, Fault> {
    read(path, plan, chunk, |_| Ok(()))
}

/// The end of a chunk's file.
struct Tail {
    length: u64,
    /// The line with the counts, or what stands in its place.
    summary: String,
    checksum: String,
}

fn open(path: &Path) -> Result<(File, Tail), Fault> {
    let mut file = File::open(path)?;
    let length = file.metadata()?.len();
    if length == 0 {
        return Err(Fault::Damaged("it is empty"));
    }
    if length <= CHECKSUM {
        return Err(Fault::Damaged("it is cut short"));
    }
    file.seek(SeekFrom::Start(length.saturating_sub(TAIL)))?;
    let mut end = Vec::new();
    (&mut file).take(TAIL).read_to_end(&mut end)?;
    file.seek(SeekFrom::Start(0))?;
    let split = end.len().saturating_sub(CHECKSUM as usize);
    let checksum = String::from_utf8_lossy(&end[split..]).into_owned();
    if !checksum.starts_with("checksum ") {
        return Err(Fault::Damaged("it does not end as it should"));
    }
    let before = &end[..split];
    let line = before.strip_suffix(b"\n").unwrap_or(before);
    let start = line.iter().rposition(|&byte| byte == b'\n').map_or(0, |at| at + 1);
    let summary = String::from_utf8_lossy(&before[start..]).into_owned();
    Ok((file, Tail { length, summary, checksum }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan() -> Plan {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.toml");
        let text = "[model]\nsites = 3\ngamma1 = 0.2\nasymmetry = 0.4\n[sweep]\n\
            x = { parameter = \"omega\", values = [0.5, 0.7, 1.1] }\ny = { parameter = \"gamma2\", values = [0.1] }\n\
            [compute]\nfamilies = [\"double-sided\"]\n";
        std::fs::write(&path, text).unwrap();
        Plan::read(&path, None).unwrap()
    }

    fn summary(cells: u64) -> Summary {
        let mut summary = Summary { worst_residual: 0.1 + 0.2, ..Summary::default() };
        (summary.classes[1], summary.statuses[0]) = (cells, cells);
        summary
    }

    #[test]
    fn rows_and_counts_come_back() {
        let folder = tempfile::tempdir().unwrap();
        let (plan, path) = (plan(), folder.path().join("chunk"));
        let mut writer = Writer::new(&path, &plan, 0).unwrap();
        writer.rows(b"one\ntwo\n", &summary(2)).unwrap();
        writer.rows(b"three\n", &summary(1)).unwrap();
        writer.finish().unwrap();
        let mut rows = Vec::new();
        let read = read(&path, &plan, 0, |some| {
            rows.extend_from_slice(some);
            Ok::<_, Fault>(())
        });
        assert_eq!((read.unwrap(), rows.as_slice()), (summary(3), b"one\ntwo\nthree\n".as_slice()));
    }

    #[test]
    fn no_change_of_a_single_bit_and_no_cut_goes_unseen() {
        let folder = tempfile::tempdir().unwrap();
        let (plan, path) = (plan(), folder.path().join("chunk"));
        let mut writer = Writer::new(&path, &plan, 0).unwrap();
        writer.rows(b"one\ntwo\nthree\n", &summary(3)).unwrap();
        writer.finish().unwrap();
        let whole = std::fs::read(&path).unwrap();
        for bit in 0..8 * whole.len() {
            let mut flipped = whole.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            std::fs::write(&path, flipped).unwrap();
            assert!(matches!(check(&path, &plan, 0), Err(Fault::Damaged(_))), "{bit}");
        }
        for length in 0..whole.len() {
            std::fs::write(&path, &whole[..length]).unwrap();
            assert!(matches!(check(&path, &plan, 0), Err(Fault::Damaged(_))), "{length}");
        }
        std::fs::write(&path, [&whole[..], b"\n"].concat()).unwrap();
        assert!(matches!(check(&path, &plan, 0), Err(Fault::Damaged(_))));
        std::fs::write(&path, &whole).unwrap();
        assert!(check(&path, &plan, 0).is_ok());
        assert!(matches!(check(&folder.path().join("none"), &plan, 0), Err(Fault::Missing)));
    }

    #[test]
    fn a_sound_chunk_of_another_sweep_is_told_from_a_damaged_one() {
        let folder = tempfile::tempdir().unwrap();
        let (mut plan, path) = (plan(), folder.path().join("chunk"));
        let mut writer = Writer::new(&path, &plan, 0).unwrap();
        writer.rows(b"one\n", &summary(3)).unwrap();
        writer.finish().unwrap();
        plan.identity ^= 1;
        assert!(matches!(check(&path, &plan, 0), Err(Fault::Foreign)));
    }
}
