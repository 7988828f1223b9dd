//! Checksums of many answers, kept in a file.

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;

use crate::Digest;

/// Set to make the file anew, where an answer has changed on purpose; the change log names it.
const WRITE: &str = "NET_WRITE";

/// What is held against a file of checksums.
#[derive(Debug)]
pub struct Net {
    file: PathBuf,
    kept: BTreeMap<String, Digest>,
    found: BTreeMap<String, Digest>,
    others: BTreeMap<String, Digest>,
}

impl Net {
    /// The checksums of this file.
    #[must_use]
    pub fn open(file: impl Into<PathBuf>) -> Self {
        let file = file.into();
        let text = fs::read_to_string(&file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        Self { file, kept: serde_json::from_str(&text).unwrap(), found: BTreeMap::new(), others: BTreeMap::new() }
    }

    /// Those of some answers alone; others are left as they are.
    #[must_use]
    pub fn only(mut self, wanted: impl Fn(&str) -> bool) -> Self {
        let others = self.kept.keys().filter(|name| !wanted(name)).cloned().collect::<Vec<_>>();
        self.others = others.into_iter().filter_map(|name| self.kept.remove_entry(&name)).collect();
        self
    }

    /// Takes an answer up.
    pub fn take(&mut self, name: &str, text: &str) {
        let twice = self.found.insert(name.to_owned(), Digest::of(text));
        assert!(twice.is_none(), "{name} comes twice");
    }

    /// Demands that all answers are those of the file, and that there are no others; or writes the file.
    pub fn finish(self) {
        if std::env::var_os(WRITE).is_some() {
            let all: BTreeMap<_, _> = self.others.iter().chain(&self.found).collect();
            fs::write(&self.file, serde_json::to_string_pretty(&all).unwrap() + "\n").unwrap();
            return;
        }
        let mut complaints: Vec<String> = Vec::new();
        for (name, digest) in &self.found {
            match self.kept.get(name).map(|kept| digest.difference(kept)) {
                None => complaints.push(format!("{name} is new")),
                Some(Some(difference)) => complaints.push(format!("{name}: {difference}")),
                Some(None) => {}
            }
        }
        let gone = self.kept.keys().filter(|name| !self.found.contains_key(*name));
        complaints.extend(gone.map(|name| format!("{name} is gone")));
        assert!(
            complaints.is_empty(),
            "{} of {} answers differ from {} (if on purpose: {WRITE}=1, and a line in the change log):\n{}",
            complaints.len(),
            self.kept.len(),
            self.file.display(),
            complaints.join("\n")
        );
    }
}
