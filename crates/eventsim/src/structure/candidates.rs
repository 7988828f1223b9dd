//! Contacts on their way to an event, the earliest first.

use std::collections::BinaryHeap;

use crate::queue::Entry;
use crate::watch::Watch;
use vibrochain_lattice::Barrier;

const NONE: u32 = u32::MAX;

/// A contact on its way to its barrier, or at rest and on its way to be released.
#[derive(Debug, Clone)]
pub(super) struct Candidate {
    pub(super) contact: usize,
    pub(super) hit: Option<Barrier>,
    /// In a window of series, its polynomial, once it is followed.
    pub(super) watch: Option<Watch>,
}

/// One a contact at most, by the time since the base before which it has no event.
#[derive(Debug, Clone)]
pub(super) struct Candidates {
    queue: BinaryHeap<Entry>,
    all: Vec<Candidate>,
    /// The number of each contact's; an entry of another number is of no account.
    slot: Vec<u32>,
}

impl Candidates {
    pub(super) fn new(contacts: usize) -> Self {
        Self { queue: BinaryHeap::new(), all: Vec::new(), slot: vec![NONE; contacts] }
    }

    pub(super) fn clear(&mut self) {
        self.queue.clear();
        self.all.drain(..).for_each(|candidate| self.slot[candidate.contact] = NONE);
    }

    pub(super) fn push(&mut self, contact: usize, key: f64, hit: Option<Barrier>, watch: Option<Watch>) {
        let number = self.all.len() as u32;
        self.slot[contact] = number;
        self.all.push(Candidate { contact, hit, watch });
        self.queue.push(Entry { key, site: contact as u32, version: number });
    }

    /// What is known of a contact is of no account any more.
    pub(super) fn forget(&mut self, contact: usize) {
        self.slot[contact] = NONE;
    }

    /// The earliest.
    pub(super) fn first(&mut self) -> Option<(f64, &mut Candidate)> {
        loop {
            let &Entry { key, site, version } = self.queue.peek()?;
            if self.slot[site as usize] == version {
                return Some((key, &mut self.all[version as usize]));
            }
            self.queue.pop();
        }
    }

    /// The earliest has no event before `key`.
    pub(super) fn put_off(&mut self, key: f64) {
        if let Some(mut top) = self.queue.peek_mut() {
            // It finds its new place from here: mostly it stays the earliest.
            top.key = key;
        }
    }

    /// Takes the earliest out.
    pub(super) fn take(&mut self) -> Option<Entry> {
        self.queue.pop()
    }

    /// Puts back what was taken out.
    pub(super) fn put_back(&mut self, taken: Vec<Entry>) {
        self.queue.extend(taken);
    }
}
