//! The file of one chunk: a line that says what it is, rows of the table, a line with their counts, a checksum.
//!
//! ```text
//! vibrochain-chunk 3 IDENTITY chunk 12 cells 98304..106496
//! 0.1,1.5,stable-double,…
//! summary classes 0,8192,… statuses 8192,0,… absences 0,… obstructions 0 worst_residual 8.9e-16 slow 0 computed 8192
//! checksum XXH3-128 OF ALL ABOVE
//! ```

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::Path;

use vibrochain_lattice::Stop;
use xxhash_rust::xxh3::Xxh3;

use super::content::{Content, ReadRows};
use super::plan::FORMAT;
use super::plan::Plan;
use crate::error::MapError;
use crate::files::Output;
use crate::grid::Grid;
use crate::obstructions::Obstructions;
use crate::summary::Summary;
use crate::text::open_plain;

/// Enough for the first line.
const HEAD: u64 = 256;

/// Enough for the last two lines.
const TAIL: u64 = 8192;

/// `checksum `, 32 digits, end of line.
const CHECKSUM: u64 = 42;

/// What is wrong with a chunk.
#[derive(Debug)]
pub enum Fault {
    /// It is not there.
    Missing,
    /// It cannot be read.
    Unreadable(io::Error),
    /// Its bytes are not those that were written.
    Damaged(String),
    /// It is sound, but of another sweep.
    Foreign,
    /// It is sound and of this sweep, but another chunk.
    Misplaced(u64),
    /// Nothing is known: the stop flag was raised.
    Stopped,
}

impl std::fmt::Display for Fault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Missing => f.write_str("it is missing"),
            Self::Unreadable(error) => write!(f, "it cannot be read: {error}"),
            Self::Damaged(how) => write!(f, "it is damaged: {how}"),
            Self::Foreign => f.write_str("it belongs to another sweep"),
            Self::Misplaced(chunk) => write!(f, "it is chunk {chunk} of this sweep under another's name"),
            Self::Stopped => f.write_str("it was not read"),
        }
    }
}

impl From<io::Error> for Fault {
    fn from(error: io::Error) -> Self {
        if error.kind() == io::ErrorKind::NotFound { Self::Missing } else { Self::Unreadable(error) }
    }
}

fn damaged(how: &str) -> Fault {
    Fault::Damaged(how.to_owned())
}

fn first_line<S: Grid>(plan: &Plan<S>, chunk: u64) -> String {
    let Range { start, end } = plan.range(chunk);
    format!("vibrochain-chunk {FORMAT} {:032x} chunk {chunk} cells {start}..{end}\n", plan.identity)
}

/// The chunk of this sweep that begins with this line.
fn chunk_of<S: Grid>(plan: &Plan<S>, first: &[u8]) -> Option<u64> {
    let words = std::str::from_utf8(first).ok()?.split(' ').collect::<Vec<_>>();
    let chunk = words.get(4)?.parse().ok().filter(|chunk| (0..plan.chunks()).contains(chunk))?;
    (first_line(plan, chunk).as_bytes() == first).then_some(chunk)
}

fn listed(counts: &[u64]) -> String {
    counts.iter().map(u64::to_string).collect::<Vec<_>>().join(",")
}

fn summary_line(summary: &Summary) -> String {
    let [classes, statuses, absences] = [&summary.classes[..], &summary.statuses, &summary.absences].map(listed);
    let Summary { worst_residual, slow, computed, .. } = summary;
    let obstructions = summary.obstructions.text();
    format!(
        "summary classes {classes} statuses {statuses} absences {absences} obstructions {obstructions} worst_residual {worst_residual:e} slow {slow} computed {computed}\n"
    )
}

fn read_summary(line: &str) -> Option<Summary> {
    let mut summary = Summary::default();
    let words: Vec<&str> = line.strip_suffix('\n')?.split(' ').collect();
    let [
        "summary",
        "classes",
        classes,
        "statuses",
        statuses,
        "absences",
        absences,
        "obstructions",
        obstructions,
        "worst_residual",
        residual,
        "slow",
        slow,
        "computed",
        computed,
    ] = words.as_slice()
    else {
        return None;
    };
    let read = |text: &str, counts: &mut [u64]| {
        let given: Vec<u64> = text.split(',').map(str::parse).collect::<Result<_, _>>().ok()?;
        (given.len() == counts.len()).then(|| counts.copy_from_slice(&given))
    };
    read(classes, &mut summary.classes)?;
    read(statuses, &mut summary.statuses)?;
    read(absences, &mut summary.absences)?;
    summary.obstructions = Obstructions::read(obstructions)?;
    summary.worst_residual = residual.parse().ok().filter(|residual: &f64| residual.is_finite())?;
    summary.slow = slow.parse().ok()?;
    summary.computed = computed.parse().ok()?;
    Some(summary)
}

/// A chunk under way. Dropped before [`Writer::place`], it leaves nothing behind.
pub struct Writer {
    output: Output,
    hash: Box<Xxh3>,
    summary: Summary,
}

impl Writer {
    /// Opens the temporary file.
    pub fn new<S: Grid>(path: &Path, plan: &Plan<S>, chunk: u64) -> Result<Self, MapError> {
        let mut writer = Self { output: Output::beside(path)?, hash: Box::default(), summary: Summary::default() };
        writer.write(first_line(plan, chunk).as_bytes())?;
        Ok(writer)
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), MapError> {
        self.hash.update(bytes);
        self.output.write_all(bytes).map_err(|error| self.output.unwritten(&error))
    }

    /// Writes rows and counts them.
    pub fn rows(&mut self, rows: &[u8], summary: &Summary) -> Result<(), MapError> {
        self.summary.add(summary);
        self.write(rows)
    }

    /// Writes the last two lines.
    pub fn close(&mut self) -> Result<(), MapError> {
        let line = summary_line(&self.summary);
        self.hash.update(line.as_bytes());
        // At once: after a failure both are held.
        let tail = format!("{line}checksum {:032x}\n", self.hash.digest128());
        self.output.write_all(tail.as_bytes()).map_err(|error| self.output.unwritten(&error))?;
        self.flush()
    }

    /// Hands to the system what it has not got yet. After a failure nothing is lost: it may be tried again.
    pub fn flush(&mut self) -> Result<(), MapError> {
        self.output.flush().map_err(|error| self.output.unwritten(&error))
    }

    /// Sees to it that the disk has all of a chunk that is closed, and puts the file in its place.
    pub fn place(self) -> Result<(), MapError> {
        self.output.commit()
    }

    /// Closes and places.
    #[cfg(test)]
    pub fn finish(mut self) -> Result<(), MapError> {
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

/// Hands the rows of a chunk to `take`, some bytes at a time, and then tells whether they are those that were written. What
/// `take` has got must be thrown away if not.
pub(super) fn read<S: Grid, E: From<Fault>>(
    path: &Path,
    plan: &Plan<S>,
    chunk: u64,
    stop: &Stop,
    mut take: impl FnMut(&[u8]) -> Result<(), E>,
) -> Result<Summary, E> {
    // Opening reads both ends of the file: many thousand times, on a slow disk, after the signal.
    ensure!(!stop.is_raised(), Fault::Stopped.into());
    let Opened { file, first, tail } = open(path)?;
    let mut reader = Hashed { inner: BufReader::new(file), hash: Box::default() };
    let found = chunk_of(plan, &first);
    let ours = found == Some(chunk);
    // An honest chunk of another sweep has another first line, a damaged one may have anything: its rows are read for the
    // checksum alone.
    let before = tail.start.checked_sub(first.len() as u64).ok_or_else(|| damaged("it is cut short"))?;
    for (mut left, rows) in [(first.len() as u64, false), (before, ours), (tail.summary.len() as u64, false)] {
        let mut buffer = vec![0; (1 << 16).min(left as usize)];
        while left > 0 {
            ensure!(!stop.is_raised(), Fault::Stopped.into());
            let some = reader.by_ref().take(left).read(&mut buffer).map_err(Fault::from)?;
            ensure!(some != 0, damaged("it is cut short").into());
            if rows {
                take(&buffer[..some])?;
            }
            left -= some as u64;
        }
    }
    if tail.checksum != format!("checksum {:032x}\n", reader.hash.digest128()) {
        return Err(damaged("its checksum is wrong").into());
    }
    let range = plan.range(chunk);
    match (found, read_summary(&tail.summary)) {
        (Some(other), _) if other != chunk => Err(Fault::Misplaced(other).into()),
        (None, _) => Err(Fault::Foreign.into()),
        (_, Some(summary)) if summary.cells() == range.end - range.start => Ok(summary),
        _ => Err(damaged("its counts are wrong").into()),
    }
}

/// Reads a chunk through, row by row, and tells whether it can be trusted.
pub(super) fn check<S: Grid, C: Content<S>>(
    content: &C,
    path: &Path,
    plan: &Plan<S>,
    chunk: u64,
    stop: &Stop,
) -> Result<Summary, Fault> {
    let mut rows = content.reader(&plan.scene, plan.range(chunk));
    // A checksum that is wrong says more than the row that it was wrong in.
    let mut wrong = Ok(());
    let summary = read(path, plan, chunk, stop, |some| {
        if wrong.is_ok() {
            wrong = rows.take(some, &mut |_, _| {});
        }
        Ok::<_, Fault>(())
    })?;
    wrong.and_then(|()| rows.finish(&summary, &mut |_, _| {})).map_err(Fault::Damaged)?;
    Ok(summary)
}

/// A chunk's file, and what stands at its two ends.
struct Opened {
    file: File,
    /// The line that says what it is, or what stands in its place.
    first: Vec<u8>,
    tail: Tail,
}

/// The end of a chunk's file.
struct Tail {
    /// Where it begins.
    start: u64,
    /// The line with the counts, or what stands in its place.
    summary: String,
    checksum: String,
}

fn open(path: &Path) -> Result<Opened, Fault> {
    let mut file = open_plain(path)?;
    let length = file.metadata()?.len();
    ensure!(length != 0, damaged("it is empty"));
    ensure!(length > CHECKSUM, damaged("it is cut short"));
    let mut first = Vec::new();
    BufReader::new((&mut file).take(HEAD.min(length - CHECKSUM))).read_until(b'\n', &mut first)?;
    file.seek(SeekFrom::Start(length.saturating_sub(TAIL)))?;
    let mut end = Vec::new();
    (&mut file).take(TAIL).read_to_end(&mut end)?;
    file.seek(SeekFrom::Start(0))?;
    let split = end.len().saturating_sub(CHECKSUM as usize);
    let checksum = String::from_utf8_lossy(&end[split..]).into_owned();
    ensure!(checksum.starts_with("checksum "), damaged("it does not end as it should"));
    let before = &end[..split];
    let line = before.strip_suffix(b"\n").unwrap_or(before);
    let at = line.iter().rposition(|&byte| byte == b'\n').map_or(0, |at| at + 1);
    // Nothing but text is ever written: what is none has another checksum, whatever it is read as.
    let summary = String::from_utf8(before[at..].to_vec()).map_err(|_| damaged("its counts are no text"))?;
    let start = length - CHECKSUM - summary.len() as u64;
    Ok(Opened { file, first, tail: Tail { start, summary, checksum } })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sweep::content::Cells;

    #[test]
    fn another_chunk_of_the_same_sweep_is_called_what_it_is() {
        let folder = tempfile::tempdir().unwrap();
        let (plan, path) = (plan_of("from = 0.4, to = 3.0, points = 100000"), folder.path().join("chunk"));
        assert_eq!(plan.chunks(), 4);
        Writer::new(&path, &plan, 3).unwrap().finish().unwrap();
        assert!(matches!(check(&path, &plan, 1), Err(Fault::Misplaced(3))));
    }

    fn plan() -> Plan {
        plan_of("values = [0.5, 0.7, 1.1]")
    }

    fn plan_of(axis: &str) -> Plan {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.toml");
        let text = "[model]\nsites = 3\ngamma1 = 0.2\nasymmetry = 0.4\n[sweep]\n\
            x = { parameter = \"omega\", values = [0.5, 0.7, 1.1] }\ny = { parameter = \"gamma2\", values = [0.1] }\n\
            [compute]\nfamilies = [\"double-sided\"]\n";
        std::fs::write(&path, text.replace("values = [0.5, 0.7, 1.1]", axis)).unwrap();
        Plan::read(&path, None).unwrap()
    }

    const ROWS: [&str; 3] =
        ["0.1,0.5,double,,,0.25,1,ok\n", "0.1,0.7,double,,,,1,ok\n", "0.1,1.1,double,,,1e-7,1,ok\n"];

    fn summary(cells: u64) -> Summary {
        let mut summary = Summary { worst_residual: 0.1 + 0.2, computed: cells, ..Summary::default() };
        (summary.classes[5], summary.statuses[0]) = (cells, cells);
        summary
    }

    fn check(path: &Path, plan: &Plan, chunk: u64) -> Result<Summary, Fault> {
        super::check(&Cells, path, plan, chunk, &Stop::default())
    }

    /// Writes a chunk of these rows.
    fn write(path: &Path, plan: &Plan, rows: &str, summary: &Summary) {
        let mut writer = Writer::new(path, plan, 0).unwrap();
        writer.rows(rows.as_bytes(), summary).unwrap();
        writer.finish().unwrap();
    }

    #[test]
    fn rows_and_counts_come_back() {
        let folder = tempfile::tempdir().unwrap();
        let (plan, path) = (plan(), folder.path().join("chunk"));
        let mut writer = Writer::new(&path, &plan, 0).unwrap();
        writer.rows(ROWS[..2].concat().as_bytes(), &summary(2)).unwrap();
        writer.rows(ROWS[2].as_bytes(), &summary(1)).unwrap();
        writer.finish().unwrap();
        let mut rows = Vec::new();
        let read = read(&path, &plan, 0, &Stop::default(), |some| {
            rows.extend_from_slice(some);
            Ok::<_, Fault>(())
        });
        assert_eq!((read.unwrap(), rows.as_slice()), (summary(3), ROWS.concat().as_bytes()));
        assert_eq!(check(&path, &plan, 0).unwrap(), summary(3));
        assert!(matches!(super::check(&Cells, &path, &plan, 0, &Stop::when(|| true)), Err(Fault::Stopped)));
    }

    #[test]
    fn rows_that_are_none_are_seen_whatever_the_checksum_says() {
        let folder = tempfile::tempdir().unwrap();
        let (plan, path) = (plan(), folder.path().join("chunk"));
        for (rows, counted, told) in [
            (ROWS.concat().replace("0.25", "NaN"), 3, "it is damaged: row 1: its margin is `NaN`"),
            (ROWS[..2].concat(), 3, "it is damaged: it has 2 rows for 3 cells"),
            (ROWS.concat() + ROWS[2], 3, "it is damaged: it has more rows than its 3 cells"),
            ([ROWS[1], ROWS[0], ROWS[2]].concat(), 3, "row 1: it is of the cell at 0.7 and not at 0.5"),
            (ROWS.concat().replace("double", "single"), 3, "its counts are not those of its rows"),
            (ROWS.concat(), 2, "its counts are wrong"),
        ] {
            write(&path, &plan, &rows, &summary(counted));
            let fault = check(&path, &plan, 0).unwrap_err().to_string();
            assert!(fault.contains(told), "{fault}");
        }
    }

    #[test]
    fn no_change_of_a_single_bit_and_no_cut_goes_unseen() {
        let folder = tempfile::tempdir().unwrap();
        let (plan, path) = (plan(), folder.path().join("chunk"));
        write(&path, &plan, &ROWS.concat(), &summary(3));
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
        write(&path, &plan, &ROWS.concat(), &summary(3));
        plan.identity ^= 1;
        assert!(matches!(check(&path, &plan, 0), Err(Fault::Foreign)));
    }
}
