//! The scenes of the paper's figures: built in, or from a folder.

use std::path::{Path, PathBuf};

use vibrochain_cli::common::error::CliError;
use vibrochain_maps::files::entries;
use vibrochain_maps::scene::MAX_BYTES;
use vibrochain_maps::text::read_text;

macro_rules! built_in {
    ($($id:literal),* $(,)?) => {
        /// Names and texts, in the paper's order.
        const BUILT_IN: &[(&str, &str)] =
            &[$(($id, include_str!(concat!("../../../../scenes/figures/figure-", $id, ".toml")))),*];
    };
}

built_in!("1", "2", "3", "4", "5", "6", "7", "8", "9", "10", "10-strict", "11", "12", "13", "15a", "15b", "15c", "15d",);

/// One figure's scene, not yet read.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Entry {
    /// The paper's number, with a letter or word for panels and variants.
    pub(super) id: String,
    /// Where the text comes from, for messages.
    pub(super) path: PathBuf,
    pub(super) text: String,
}

/// All scenes built in.
pub(super) fn built_in() -> Vec<Entry> {
    let entry = |(id, text): &(&str, &str)| Entry {
        id: (*id).to_owned(),
        path: PathBuf::from(format!("scenes/figures/figure-{id}.toml")),
        text: (*text).to_owned(),
    };
    BUILT_IN.iter().map(entry).collect()
}

/// The number an id begins with, and the rest.
fn order(id: &str) -> (u64, &str) {
    let digits = id.find(|c: char| !c.is_ascii_digit()).unwrap_or(id.len());
    (id[..digits].parse().unwrap_or(u64::MAX), &id[digits..])
}

/// All scenes `figure-ID.toml` of a folder.
///
/// # Errors
/// [`CliError::Request`] if it cannot be read or has none.
pub(super) fn folder(folder: &Path) -> Result<Vec<Entry>, CliError> {
    let failed = |error: &std::io::Error| CliError::file("cannot read scenes in", folder, error);
    let mut found = Vec::new();
    for item in entries(folder).map_err(|error| failed(&error))? {
        let item = item.map_err(|error| failed(&error))?;
        let (path, name) = (item.path().to_owned(), item.name().to_string_lossy().into_owned());
        let Some(id) = name.strip_prefix("figure-").and_then(|name| name.strip_suffix(".toml")) else { continue };
        let text = read_text("scene", &path, MAX_BYTES)?;
        found.push(Entry { id: id.to_owned(), path, text });
    }
    if found.is_empty() {
        let name = folder.display();
        return Err(CliError::Request(format!("--scenes {name}: the folder has no file figure-NUMBER.toml")));
    }
    found.sort_by(|a, b| order(&a.id).cmp(&order(&b.id)));
    Ok(found)
}

/// The entries that `only` names, by id or by number: `15` is all panels of figure 15.
///
/// # Errors
/// [`CliError::Request`] for a name that fits none.
pub(super) fn chosen(entries: Vec<Entry>, only: &[String]) -> Result<Vec<Entry>, CliError> {
    let fits = |entry: &Entry, name: &str| {
        let number = !name.is_empty() && name.chars().all(|c| c.is_ascii_digit());
        entry.id == name || number && order(&entry.id).0 == order(name).0
    };
    if let Some(name) = only.iter().find(|name| !entries.iter().any(|entry| fits(entry, name))) {
        let known: Vec<_> = entries.iter().map(|entry| entry.id.as_str()).collect();
        return Err(CliError::Request(format!("--only {name}: no such figure; give some of {}", known.join(", "))));
    }
    let wanted = |entry: &Entry| only.is_empty() || only.iter().any(|name| fits(entry, name));
    Ok(entries.into_iter().filter(wanted).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ids(only: &[&str]) -> Vec<String> {
        let only: Vec<_> = only.iter().map(|&name| name.to_owned()).collect();
        chosen(built_in(), &only).unwrap().into_iter().map(|entry| entry.id).collect()
    }

    #[test]
    fn figures_are_chosen_by_name_and_by_number() {
        assert_eq!(ids(&[]).len(), 18);
        assert_eq!(ids(&["9", "3"]), ["3", "9"]);
        assert_eq!(ids(&["10-strict"]), ["10-strict"]);
        assert_eq!(ids(&["10"]), ["10", "10-strict"]);
        assert_eq!(ids(&["15"]), ["15a", "15b", "15c", "15d"]);
        for wrong in ["14", "", "15e", "x", "-1"] {
            let message = chosen(built_in(), &[wrong.to_owned()]).unwrap_err().to_string();
            assert!(message.contains("no such figure") && message.contains("15d"), "{message}");
        }
    }

    #[test]
    fn the_folder_holds_what_is_built_in() {
        let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/figures"));
        let found = folder(path).unwrap();
        let pairs = |entries: &[Entry]| -> Vec<(String, String)> {
            entries.iter().map(|entry| (entry.id.clone(), entry.text.clone())).collect()
        };
        assert_eq!(pairs(&found), pairs(&built_in()));
        assert!(folder(Path::new(env!("CARGO_MANIFEST_DIR"))).is_err() && folder(Path::new("/no/such")).is_err());
    }
}
