//! Text that comes from outside: read no further than it may be long, shown without what a terminal would obey.

use std::borrow::Cow;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use crate::error::MapError;

/// Reads a file of text of at most `most` bytes; `what` it is, for messages.
///
/// # Errors
/// [`MapError::Request`] for a file that cannot be read, or is longer.
pub fn read_text(what: &str, path: &Path, most: u64) -> Result<String, MapError> {
    let failed = |error: &io::Error| {
        let meant = like(path).filter(|_| error.kind() == io::ErrorKind::NotFound);
        let meant = meant.map_or(String::new(), |meant| format!(": did you mean {}?", meant.display()));
        MapError::Request(format!("cannot read {what} {}: {error}{meant}", path.display()))
    };
    let mut bytes = Vec::new();
    File::open(path).and_then(|file| file.take(most + 1).read_to_end(&mut bytes)).map_err(|error| failed(&error))?;
    ensure!(bytes.len() as u64 <= most, "{what} {} has more than the {most} bytes that it may have", path.display());
    let text = String::from_utf8(bytes);
    let text = text.map_err(|error| failed(&io::Error::new(io::ErrorKind::InvalidData, error.utf8_error())))?;
    // Editors and spreadsheets of some systems begin a file with a byte order mark.
    Ok(match text.strip_prefix('\u{feff}') {
        Some(rest) => rest.to_owned(),
        None => text,
    })
}

/// Entries of a folder that are looked at for a name.
const MOST_ENTRIES: usize = 10_000;

/// What is there of nearly that name, or of that name in a folder beside it.
fn like(path: &Path) -> Option<PathBuf> {
    if path.as_os_str().is_empty() || path.exists() {
        return Some(path.to_owned());
    }
    let (folder, name) = (like(path.parent()?)?, path.file_name()?.to_str()?);
    let here = if folder.as_os_str().is_empty() { Path::new(".") } else { &folder };
    let entries = here.read_dir().ok()?.take(MOST_ENTRIES).flatten();
    let names: Vec<String> = entries.filter_map(|entry| entry.file_name().into_string().ok()).collect();
    let beside = || names.iter().map(|beside| folder.join(beside).join(name)).find(|path| path.exists());
    closest(name, names.iter().map(String::as_str)).map(|name| folder.join(name)).or_else(beside)
}

/// Opens a file to read, and nothing else: a FIFO would keep its reader waiting for ever.
///
/// # Errors
/// Those of the system; one in its words for a folder, a FIFO or a device.
pub fn open_plain(path: &Path) -> io::Result<File> {
    ensure!(path.metadata()?.is_file(), io::Error::other("it is no plain file"));
    File::open(path)
}

/// A text of more than `most` characters without its middle.
pub fn clipped(text: &str, most: usize) -> Cow<'_, str> {
    if text.chars().count() <= most {
        return text.into();
    }
    let half = most / 2;
    let end: Vec<char> = text.chars().rev().take(half).collect();
    text.chars().take(most - half).chain(['…']).chain(end.into_iter().rev()).collect::<String>().into()
}

/// The one of some names that a word was meant to be: a slip or two of the keyboard away from it, of a short word one.
///
/// ```
/// use vibrochain_maps::text::closest;
/// let names = ["png", "plot", "gamma1", "gamma2"];
/// assert_eq!(closest("pgn", names), Some("png"));
/// assert_eq!(closest("gama1", names), Some("gamma1"));
/// assert_eq!(closest("damping", names), None);
/// ```
pub fn closest<'a>(word: &str, names: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let most = match word.chars().count() {
        0..=2 => 0,
        3..=5 => 1,
        _ => 2,
    };
    // Two letters that have changed places are one slip.
    let slips = names.into_iter().map(|name| (strsim::osa_distance(word, name), name));
    slips.filter(|(slips, _)| *slips <= most).min_by_key(|(slips, _)| *slips).map(|(_, name)| name)
}

/// Whether a terminal would obey a character instead of showing it, or show others in another order because of it.
pub fn is_obeyed(c: char) -> bool {
    c.is_control() || matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// A text of several lines with all that a terminal would obey written out.
pub fn printable(text: &str) -> Cow<'_, str> {
    let harmless = |c: char| c == '\n' || !is_obeyed(c);
    if text.chars().all(harmless) {
        return text.into();
    }
    let mut shown = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        if harmless(c) { shown.push(c) } else { shown.extend(c.escape_unicode()) }
    }
    shown.into()
}

/// Up to `most` characters about the `place`-th of a line, each of the width of one, and where among them the place is.
pub fn excerpt(line: &str, place: usize, most: usize) -> (String, usize) {
    let first = place.saturating_sub(most / 2);
    let mut rest = line.chars().skip(first);
    let mut shown: String = rest.by_ref().take(most).map(|c| if is_obeyed(c) { '\u{fffd}' } else { c }).collect();
    if rest.next().is_some() {
        shown.push('…');
    }
    if first == 0 { (shown, place) } else { (format!("…{shown}"), place - first + 1) }
}

/// A time in a unit that people can grasp.
#[must_use]
pub fn duration(seconds: f64) -> String {
    let units = [(31_557_600.0, "years"), (86_400.0, "days"), (3600.0, "hours"), (60.0, "minutes")];
    match units.iter().find(|(unit, _)| seconds >= 2.0 * unit) {
        Some((unit, name)) if seconds / unit >= 1e6 => format!("{:.0e} {name}", seconds / unit),
        Some((unit, name)) => format!("{:.1} {name}", seconds / unit),
        None => format!("{seconds:.1} s"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_terminal_would_obey_is_written_out() {
        assert_eq!(printable("γ₁ = 1\n\"é\""), "γ₁ = 1\n\"é\"");
        assert_eq!(printable("a\u{1b}[2Jb\r\t\u{202e}c\u{9b}"), r"a\u{1b}[2Jb\u{d}\u{9}\u{202e}c\u{9b}");
    }

    #[test]
    fn the_place_is_in_the_excerpt_wherever_it_is_in_the_line() {
        let line: String = (0..1000_u32).filter_map(|i| char::from_u32(0x4e00 + i)).collect();
        for place in 0..=line.chars().count() {
            let (shown, at) = excerpt(&line, place, 80);
            assert_eq!(shown.chars().nth(at).filter(|&c| c != '…'), line.chars().nth(place), "{place}");
            assert!(shown.chars().count() <= 82 && at <= 41);
        }
        assert_eq!(excerpt("a\tb\u{1b}", 2, 80), ("a\u{fffd}b\u{fffd}".to_owned(), 2));
        assert_eq!((clipped("αβγ", 3), clipped("αβγδε", 3)), ("αβγ".into(), "αβ…ε".into()));
    }

    #[test]
    fn what_is_too_long_or_no_text_is_refused_and_what_just_fits_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("text");
        for (bytes, told) in
            [(&b"12345678"[..], None), (b"123456789", Some("more than the 8 bytes")), (b"\xff", Some("utf-8"))]
        {
            std::fs::write(&path, bytes).unwrap();
            match (read_text("scene", &path, 8), told) {
                (Ok(text), None) => assert_eq!(text.as_bytes(), bytes),
                (Err(error), Some(told)) => {
                    assert!(error.to_string().contains(told) && matches!(error, MapError::Request(_)), "{error}");
                }
                (read, _) => panic!("{read:?}"),
            }
        }
        assert_eq!(open_plain(folder.path()).unwrap_err().to_string(), "it is no plain file");
    }

    #[test]
    fn times_come_in_units_that_people_can_grasp() {
        assert_eq!([30.0, 150.0, 7300.0, 1e6].map(duration), ["30.0 s", "2.5 minutes", "2.0 hours", "11.6 days"]);
        assert_eq!([1e9, 1e99].map(duration), ["31.7 years", "3e91 years"]);
    }
}
