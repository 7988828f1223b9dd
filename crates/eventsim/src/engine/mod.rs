//! Flight of the lattice in windows, and what interrupts it.
//!
//! A window starts with all masses at one instant, the base, and expands their series over a horizon H. One bound
//! clears the masses that cannot reach a barrier; the others enter a queue, keyed by the time before which they have
//! certainly no contact. What happens in between is a restart of the masses that can feel it before the window ends:
//! all of them on a small lattice or in several layers, a few neighbours in a long row (`restart`).
//!
//! | module | holds |
//! |---|---|
//! | `window` | order and length of a window, the masses that may have a contact in it |
//! | `contacts` | the next contacts |
//! | `states` | where the masses are at any time of the window |
//! | `restart` | new series in the middle of a window |
//! | `collision` | what contacts do |

mod collision;
mod contacts;
mod restart;
mod states;
mod window;

pub use collision::CHATTER_TIME;

use std::collections::BinaryHeap;

use vibrochain_lattice::Barrier;

use crate::event::Work;
use crate::part::Pace;
use crate::queue::Entry;
use crate::ring::Ring;
use crate::series::{CORRECTED, Rows};
use crate::stencil::links;
use crate::time::Clock;
use crate::units::{MAX_ORDER, ORDERS, Units};
use crate::watch::Watch;
use crate::weights::Weights;

const NONE: u32 = u32::MAX;

/// A contact that is due.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Due {
    pub(crate) site: usize,
    pub(crate) barrier: Barrier,
    /// It is the release of a mass at rest.
    pub(crate) release: bool,
    /// Of a release right at the start of a series, the order of the derivative that pulls the mass off.
    pub(crate) pull: Option<u8>,
}

/// The ring in flight.
#[derive(Debug, Clone)]
pub(crate) struct Engine {
    pub(crate) units: Units,
    /// Phase of the force at time zero, internal time.
    pub(crate) psi: f64,
    pub(crate) clock: Clock,
    pub(crate) ring: Ring,
    pub(crate) rows: Rows,
    /// Origin of each mass's series, since the base; `moved` lists those that are not 0.
    pub(crate) origin: Vec<f64>,
    pub(crate) moved: Vec<usize>,
    /// Certified length of the window, since the base.
    pub(crate) horizon: f64,
    /// Fastest velocity met so far, for the remainder of the series.
    pub(crate) fastest: f64,
    pub(crate) work: Work,
    pub(crate) due: Vec<Due>,
    pub(crate) force: [f64; MAX_ORDER + 1],
    pub(crate) weights: Weights,
    pub(crate) pace: Pace,
    /// State of the generator ([`spread`]) of the instants of restarts.
    pub(crate) seed: u64,
    /// Masses that leave a barrier, and what rounding took from their series.
    departures: Vec<usize>,
    lost: Vec<(usize, [f64; CORRECTED])>,
    /// Horizons of all orders, for velocities up to `horizons_for`.
    horizons: [f64; ORDERS.len()],
    horizons_for: f64,
    fractions: [f64; MAX_ORDER + 1],
    version: Vec<u32>,
    slot: Vec<u32>,
    pub(crate) watches: Vec<Watch>,
    queue: BinaryHeap<Entry>,
    /// Work space of an expansion, of a part of the ring, and of the parts themselves.
    pub(crate) soft: Vec<(usize, u8)>,
    links: Vec<[u32; 4]>,
    pub(crate) resting_columns: Vec<usize>,
    pub(crate) part_rows: Rows,
    pub(crate) parts: Vec<(usize, usize)>,
    x_next: Vec<f64>,
    v_next: Vec<f64>,
}

impl Engine {
    pub(crate) fn new(units: Units, psi: f64, ring: Ring) -> Self {
        let sites = ring.sites();
        let fastest = ring.v.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        let horizons = units.horizons(fastest);
        Self {
            clock: Clock::new(units.omega),
            psi,
            rows: Rows::new(sites),
            origin: vec![0.0; sites],
            moved: Vec::new(),
            horizon: 0.0,
            fastest,
            work: Work::default(),
            due: Vec::new(),
            force: [0.0; MAX_ORDER + 1],
            weights: Weights::zero(),
            pace: Pace::default(),
            seed: 1,
            departures: Vec::new(),
            lost: Vec::new(),
            horizons,
            horizons_for: fastest,
            fractions: [0.0; MAX_ORDER + 1],
            version: vec![0; sites],
            slot: vec![NONE; sites],
            watches: Vec::new(),
            queue: BinaryHeap::new(),
            soft: Vec::new(),
            links: links(&units.chain),
            resting_columns: Vec::new(),
            part_rows: Rows::default(),
            parts: Vec::new(),
            x_next: vec![0.0; sites],
            v_next: vec![0.0; sites],
            units,
            ring,
        }
    }

    /// The force and its derivatives `after` the base.
    pub(crate) fn set_force(&mut self, after: f64) {
        self.units.force(self.clock.offset() + after + self.psi, &mut self.force);
    }

    /// The longest window of any order.
    pub(crate) fn longest_window(&self) -> f64 {
        self.horizons.into_iter().fold(0.0, f64::max)
    }
}
