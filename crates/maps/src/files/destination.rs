//! Where an output goes: what the name that was given leads to, what its ending promises, and that no two files of a command
//! are one.

use std::ffi::OsString;
use std::fs;
use std::io;
use std::path::{Component, Path, PathBuf};

use crate::error::MapError;

/// The name of standard output.
const STANDARD_OUTPUT: &str = "-";

/// Links on the way to a file that are followed at most, as many as the system follows itself.
const MOST_LINKS: usize = 40;

/// Endings that promise a file, where a folder is asked for.
const FILES: [&str; 13] =
    ["csv", "gz", "zst", "parquet", "png", "svg", "jpg", "jpeg", "gif", "pdf", "md", "json", "toml"];

/// What a name leads to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Destination {
    /// Standard output: `-`, or whatever leads to the same.
    StandardOutput,
    /// A plain file, there or yet to be made, at the end of all links. It is replaced as a whole.
    Plain(PathBuf),
    /// A pipe or a device, or a file that somebody has opened: no other can be put in its place, it is written to.
    Direct(PathBuf),
}

impl Destination {
    /// Of a name that was given.
    ///
    /// # Errors
    /// [`MapError::Request`] for a folder, and for what cannot be looked at.
    pub fn of(path: &Path) -> Result<Self, MapError> {
        let wrong = |why: &str| Err(MapError::Request(format!("cannot write {}: {why}", path.display())));
        if path.as_os_str() == STANDARD_OUTPUT {
            return Ok(Self::StandardOutput);
        }
        if path.file_name().is_none() {
            return wrong("it names no file");
        }
        if is_named_as_folder(path) {
            return wrong("its name is that of a folder; name a file");
        }
        let place = resolved(path);
        if is_own_standard_output(&place) {
            return Ok(Self::StandardOutput);
        }
        match fs::metadata(path) {
            Ok(found) if found.is_dir() => wrong("it is a folder; name a file"),
            Ok(found) if is_socket(&found) => wrong("it is a socket; name a file or a pipe"),
            Ok(found) if !found.is_file() || is_opened_file(&place) => Ok(Self::Direct(path.to_owned())),
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(MapError::file("cannot write", path, &error)),
            // Messages keep to the name that was given, as far as it is the file's own.
            Ok(_) | Err(_) => Ok(Self::Plain(if path.is_symlink() { place } else { path.to_owned() })),
        }
    }
}

/// Whether a name ends in a way that only names of folders do. (`Path` itself does not look at it.)
fn is_named_as_folder(path: &Path) -> bool {
    let name = path.as_os_str().to_string_lossy();
    let last = name.rsplit(std::path::is_separator).next().unwrap_or_default();
    last.is_empty() || last == "."
}

#[cfg(unix)]
fn is_socket(found: &fs::Metadata) -> bool {
    std::os::unix::fs::FileTypeExt::is_socket(&found.file_type())
}

#[cfg(not(unix))]
fn is_socket(_: &fs::Metadata) -> bool {
    false
}

#[cfg(unix)]
fn is_device(path: &Path) -> bool {
    use std::os::unix::fs::FileTypeExt;
    fs::metadata(path).is_ok_and(|found| found.file_type().is_char_device() || found.file_type().is_block_device())
}

#[cfg(not(unix))]
fn is_device(_: &Path) -> bool {
    false
}

/// Whether a place is a number under which a process has a file open, /proc/PID/fd/N. The system shows it as a link, but
/// what it leads to need not be the file of that name any more, nor have one.
fn is_opened_file(place: &Path) -> bool {
    place.starts_with("/proc") && place.parent().is_some_and(|folder| folder.ends_with("fd"))
}

fn is_own_standard_output(place: &Path) -> bool {
    is_opened_file(place) && fs::canonicalize("/proc/self").is_ok_and(|own| place == own.join("fd/1"))
}

/// Where a path leads: from the root, without links, `.` and `..`; also if what it names, or a folder on the way, is yet to
/// be made.
pub(super) fn resolved(path: &Path) -> PathBuf {
    let parts =
        |path: &Path| -> Vec<OsString> { path.components().rev().map(|part| part.as_os_str().to_owned()).collect() };
    let mut place = std::env::current_dir().unwrap_or_default();
    let mut rest = parts(path);
    let mut links = 0;
    while let Some(part) = rest.pop() {
        match Path::new(&part).components().next() {
            Some(Component::ParentDir) => drop(place.pop()),
            Some(Component::CurDir) | None => {}
            // From the root on it begins anew.
            Some(Component::RootDir | Component::Prefix(_)) => place.push(&part),
            Some(Component::Normal(name)) => {
                place.push(name);
                if links < MOST_LINKS
                    && !is_opened_file(&place)
                    && let Ok(target) = fs::read_link(&place)
                {
                    links += 1;
                    place.pop();
                    rest.extend(parts(&target));
                }
            }
        }
    }
    place
}

/// Files of a command, each with the flag that named it.
type Named<'a> = [(&'a str, Option<&'a Path>)];

/// Makes sure that no output is an input or another output, by whatever names. Tells whether one of the outputs is standard
/// output, which then has no room for words.
///
/// # Errors
/// [`MapError::Request`] naming both flags.
pub fn distinct(inputs: &Named<'_>, outputs: &Named<'_>) -> Result<bool, MapError> {
    let standard = PathBuf::from(STANDARD_OUTPUT);
    let mut seen: Vec<(&str, PathBuf)> = Vec::new();
    for (flag, path) in inputs {
        seen.extend(path.map(|path| (*flag, resolved(path))));
    }
    for (flag, path) in outputs {
        let Some(path) = path else { continue };
        let place = match Destination::of(path) {
            Ok(Destination::StandardOutput) => standard.clone(),
            // What is written to a device spoils nothing else there: /dev/null takes any number.
            Ok(Destination::Direct(_)) if is_device(path) => continue,
            // Folders, too, and what will be refused where it is opened.
            _ => resolved(path),
        };
        if let Some((other, _)) = seen.iter().find(|(_, earlier)| *earlier == place) {
            refuse!("{other} and {flag} are the same file, {}: name another", path.display());
        }
        seen.push((flag, place));
    }
    Ok(seen.iter().any(|(_, place)| *place == standard))
}

/// The name of a file that lies right in a folder.
pub fn name_within(folder: &Path, path: &Path) -> Option<OsString> {
    let place = resolved(path);
    let name = place.file_name().filter(|_| place.parent() == Some(&resolved(folder)))?;
    Some(name.to_owned())
}

/// What the end of a name says, without the dot and in small letters; nothing of a name without one.
pub fn ending(path: &Path) -> Option<String> {
    path.extension().map(|end| end.to_string_lossy().to_ascii_lowercase())
}

/// Makes sure that a name promises what the file will hold: that it ends in one of `known`, or in nothing.
///
/// # Errors
/// [`MapError::Request`].
pub fn promises(flag: &str, path: &Path, what: &str, known: &[&str]) -> Result<(), MapError> {
    match ending(path) {
        Some(end) if !known.contains(&end.as_str()) => {
            let name = path.display();
            Err(MapError::Request(format!(
                "{flag} {name}: {what} is written here; end the name in .{}",
                known.join(" or .")
            )))
        }
        _ => Ok(()),
    }
}

/// Makes sure that a folder can be meant by a name.
///
/// # Errors
/// [`MapError::Request`].
pub fn promises_folder(flag: &str, path: &Path) -> Result<(), MapError> {
    let name = path.display();
    let wrong = |why: &str| Err(MapError::Request(format!("{flag} {name} {why}: name a folder")));
    match ending(path) {
        _ if path.as_os_str() == STANDARD_OUTPUT => wrong("is standard output"),
        _ if path.is_dir() => Ok(()),
        _ if path.exists() => wrong("is a file"),
        Some(end) if FILES.contains(&end.as_str()) && !is_named_as_folder(path) => wrong("ends as a file does"),
        _ => Ok(()),
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    /// Against the system, for whatever is there; by hand for the rest.
    #[test]
    fn a_path_leads_where_the_system_finds_it_and_where_it_would_make_it() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path().canonicalize().unwrap();
        fs::create_dir_all(root.join("a/b")).unwrap();
        fs::write(root.join("a/b/file"), "").unwrap();
        for (target, link) in [("a/b", "short"), ("../file", "a/b/../up"), ("none/x", "dangling"), ("loop", "loop")] {
            std::os::unix::fs::symlink(target, root.join(link)).unwrap();
        }
        std::os::unix::fs::symlink(root.join("short/file"), root.join("whole")).unwrap();
        let mut there = 0;
        for path in
            ["a", "a/b/file", "short", "short/file", "short/../b/file", "whole", "./a/./b/", "short/..", "/", "/tmp/.."]
        {
            let path = root.join(path);
            assert_eq!(resolved(&path), path.canonicalize().unwrap());
            there += 1;
        }
        assert_eq!(there, 10);
        for (path, place) in [
            ("new/../a/b/file", "a/b/file"),
            ("new/deep/../../file", "file"),
            ("dangling", "none/x"),
            ("dangling/../y", "none/y"),
            ("short/new", "a/b/new"),
            ("a/up", "file"),
        ] {
            assert_eq!(resolved(&root.join(path)), root.join(place), "{path}");
        }
        // It ends.
        resolved(&root.join("loop"));
        let here = std::env::current_dir().unwrap().canonicalize().unwrap();
        assert_eq!((resolved(Path::new("new/x")), resolved(Path::new("."))), (here.join("new/x"), here));
    }

    #[test]
    fn names_of_folders_are_known_whether_or_not_they_are_there() {
        for name in ["new/", "new/.", "a/b/", "new//", "."] {
            assert!(is_named_as_folder(Path::new(name)), "{name}");
        }
        for name in ["new", "a/b", ".hidden", "a.", "a/.b", "..b"] {
            assert!(!is_named_as_folder(Path::new(name)), "{name}");
        }
    }
}
