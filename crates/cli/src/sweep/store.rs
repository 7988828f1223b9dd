//! The folder of chunks: a plan, and a file for each chunk that is finished.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

use crate::error::CliError;
use crate::output::{Output, TEMPORARY};
use crate::sweep::chunk::{Fault, Writer, check};
use crate::sweep::{Plan, Summary};

const PLAN: &str = "plan.json";

const CHUNK: &str = "chunk";

/// What a process means to do in the folder.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Claim {
    /// Start afresh, alone.
    Fresh,
    /// Take up what is there, alone.
    Resume,
    /// Work beside other processes.
    Share,
}

/// A folder of chunks.
#[derive(Debug)]
pub(crate) struct Store {
    folder: PathBuf,
    /// The plan, locked while this lives.
    plan: Option<File>,
}

impl Store {
    /// Makes the folder, or takes it up if it is that of `plan`.
    ///
    /// # Errors
    /// [`CliError::Request`]: the folder cannot be made, is that of another sweep, holds chunks and the claim is
    /// [`Claim::Fresh`], or another process has it. [`CliError::Computation`] if the plan cannot be written.
    pub(crate) fn open(folder: &Path, plan: &Plan, claim: Claim) -> Result<Self, CliError> {
        if folder.exists() && !folder.is_dir() {
            let message = format!("{} is a file, where a folder of chunks would be: remove it", folder.display());
            return Err(CliError::Request(message));
        }
        let new = !folder.exists();
        fs::create_dir_all(folder).map_err(|error| CliError::file("cannot make the folder", folder, &error))?;
        let mut store = Self { folder: folder.to_owned(), plan: None };
        let opened = store.take(plan, claim);
        if new && opened.is_err() {
            // Only if empty: whoever else has written there in the meantime keeps it.
            let _ = fs::remove_dir(folder);
        }
        opened.map(|lock| {
            store.plan = lock;
            store
        })
    }

    fn take(&self, plan: &Plan, claim: Claim) -> Result<Option<File>, CliError> {
        let place = self.folder.display();
        let chunks = self.present()?.len();
        if claim == Claim::Fresh && chunks > 0 {
            let message = format!(
                "{place} holds {chunks} chunks of an unfinished sweep: go on with it by --resume, or remove the folder to start afresh"
            );
            return Err(CliError::Request(message));
        }
        let mut lock = self.lock(claim)?;
        if claim != Claim::Share && chunks == 0 && lock.is_some() {
            // Nobody's work: the plan of a sweep that got nowhere binds nobody.
            match Self::plan(&self.folder) {
                Ok(other) if plan.differences(&other).is_none() => return Ok(lock),
                _ => Output::beside(&self.folder.join(PLAN))?.finish_with(plan.to_json().as_bytes())?,
            }
            return self.lock(claim);
        }
        if lock.is_none() {
            let mut file = Output::beside(&self.folder.join(PLAN))?;
            io::Write::write_all(&mut file, plan.to_json().as_bytes()).map_err(|error| file.unwritten(&error))?;
            // Another process may have been faster; what counts is what is there now. Whoever is alone need not wait for the
            // disk before there is a chunk.
            if claim == Claim::Share {
                file.commit_new()?
            } else {
                file.place_new()?
            };
            lock = self.lock(claim)?;
        }
        match plan.differences(&Self::plan(&self.folder)?) {
            None => Ok(lock),
            Some(told) => {
                let message = format!("{place} belongs to {told}; name another --out, or remove the folder");
                Err(CliError::Request(message))
            }
        }
    }

    /// Locks the plan, if it is there and the file system can; ends with the process, however that ends.
    fn lock(&self, claim: Claim) -> Result<Option<File>, CliError> {
        let Ok(file) = File::open(self.folder.join(PLAN)) else { return Ok(None) };
        let locked = if claim == Claim::Share { file.try_lock_shared() } else { file.try_lock() };
        match locked {
            Err(TryLockError::WouldBlock) => {
                let place = self.folder.display();
                Err(CliError::Request(format!("another mapgen is at work in {place}: wait for it, or stop it first")))
            }
            // A file system without locks: two processes there only do the work twice.
            Ok(()) | Err(TryLockError::Error(_)) => Ok(Some(file)),
        }
    }

    /// The plan in a folder of chunks.
    pub(crate) fn plan(folder: &Path) -> Result<Plan, CliError> {
        let path = folder.join(PLAN);
        let text = fs::read_to_string(&path).map_err(|error| {
            let message = format!("{} is no folder of chunks: cannot read {PLAN}: {error}", folder.display());
            CliError::Request(message)
        })?;
        Plan::from_json(&text).map_err(|why| {
            let place = path.display();
            let advice = "if only this file is bad, remove it and `mapgen sweep … --resume`; else remove the folder";
            CliError::Request(format!("{place} cannot be used: {why}; {advice}"))
        })
    }

    /// Sees to it that the disk has the plan, where the system can do so: before it has the first chunk. One that is lost
    /// all the same is made again.
    pub(crate) fn settle_plan(&self) {
        if let Some(plan) = &self.plan {
            let _ = plan.sync_all();
        }
    }

    /// The folder.
    pub(crate) fn folder(&self) -> &Path {
        &self.folder
    }

    /// Where a chunk is, or will be.
    pub(crate) fn path(folder: &Path, chunk: u64) -> PathBuf {
        folder.join(file_name(chunk))
    }

    /// Whether such a folder keeps files of this name.
    pub(crate) fn owns(name: &OsStr) -> bool {
        name == PLAN || number(name).is_some()
    }

    /// Starts a chunk.
    pub(crate) fn writer(&self, plan: &Plan, chunk: u64) -> Result<Writer, CliError> {
        Writer::new(&Self::path(&self.folder, chunk), plan, chunk)
    }

    /// The chunks that there are files for, sound or not.
    ///
    /// # Errors
    /// [`CliError::Request`] if the folder cannot be read.
    pub(crate) fn present(&self) -> Result<BTreeSet<u64>, CliError> {
        let unreadable = |error: io::Error| CliError::file("cannot read", &self.folder, &error);
        let mut chunks = BTreeSet::new();
        // One list for all: on the file systems of clusters each name takes a message.
        for entry in fs::read_dir(&self.folder).map_err(unreadable)? {
            let name = entry.map_err(unreadable)?.file_name();
            chunks.extend(number(&name));
        }
        Ok(chunks)
    }

    /// Reads a chunk through and tells whether it can be trusted.
    pub(crate) fn check(folder: &Path, plan: &Plan, chunk: u64) -> Result<Summary, Fault> {
        check(&Self::path(folder, chunk), plan, chunk)
    }

    /// Removes what was written there, also by processes that were killed, and the folder unless it holds anything else.
    /// Tells whether it is gone.
    pub(crate) fn remove(self) -> bool {
        for entry in fs::read_dir(&self.folder).into_iter().flatten().flatten() {
            let name = entry.file_name();
            let temporary = name.to_string_lossy().starts_with('.') && name.to_string_lossy().ends_with(TEMPORARY);
            if Self::owns(&name) || temporary {
                // What cannot be removed keeps the folder, which is told.
                let _ = fs::remove_file(entry.path());
            }
        }
        fs::remove_dir(&self.folder).is_ok()
    }
}

fn file_name(chunk: u64) -> String {
    format!("{chunk:06}.{CHUNK}")
}

/// The number of the chunk that has this name. What is called otherwise, a copy aside for one, is not ours.
fn number(name: &OsStr) -> Option<u64> {
    let name = name.to_str()?;
    let chunk = name.strip_suffix(CHUNK)?.strip_suffix('.')?.parse().ok()?;
    (file_name(chunk) == name).then_some(chunk)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "[model]\nsites = 3\ngamma1 = 0.2\nasymmetry = 0.4\n[sweep]\n\
        x = { parameter = \"omega\", values = [0.5, 0.7, 1.1] }\ny = { parameter = \"gamma2\", values = [0.1] }\n\
        [compute]\nfamilies = [\"double-sided\"]\n";

    #[test]
    fn chunks_of_another_version_are_refused_by_name() {
        let desk = tempfile::tempdir().unwrap();
        let (scene, folder) = (desk.path().join("scene.toml"), desk.path().join("parts"));
        fs::write(&scene, TEXT).unwrap();
        let here = Plan::read(&scene, None).unwrap();
        let there = Plan::by_version(&scene, TEXT, "0.0.9");
        drop(Store::open(&folder, &there, Claim::Share).unwrap());
        fs::write(Store::path(&folder, 0), "").unwrap();
        for claim in [Claim::Resume, Claim::Share] {
            let error = Store::open(&folder, &here, claim).unwrap_err();
            let told = error.to_string();
            assert!(told.contains("belongs to another version of mapgen: 0.0.9 (") && error.exit_code() == 2, "{told}");
            assert!(told.contains(&format!(") there, {} (", crate::manifest::VERSION)), "{told}");
        }
        // Chunks that are sound, but of that version: without their plan they are refused one by one.
        Store::open(&folder, &there, Claim::Share).unwrap().writer(&there, 0).unwrap().finish().unwrap();
        assert!(matches!(Store::check(&folder, &here, 0), Err(Fault::Foreign)));
    }

    #[test]
    fn a_folder_with_other_things_in_it_is_left() {
        let desk = tempfile::tempdir().unwrap();
        let (scene, folder) = (desk.path().join("scene.toml"), desk.path().join("parts"));
        fs::write(&scene, TEXT).unwrap();
        let plan = Plan::read(&scene, None).unwrap();
        fs::create_dir(&folder).unwrap();
        let others = ["+00001.chunk", "0000001.chunk", "notes.txt", "old.chunk"];
        others.iter().for_each(|name| fs::write(folder.join(name), "mine").unwrap());
        let store = Store::open(&folder, &plan, Claim::Fresh).unwrap();
        fs::write(Store::path(&folder, 1), "a chunk").unwrap();
        assert_eq!(store.present().unwrap(), BTreeSet::from([1]));
        assert!(!store.remove());
        let mut left: Vec<_> = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        left.sort_unstable();
        assert_eq!(left, others);
        others.iter().for_each(|name| fs::remove_file(folder.join(name)).unwrap());
        assert!(Store::open(&folder, &plan, Claim::Resume).unwrap().remove() && !folder.exists());
    }
}
