//! What a simulation reports: events, why it stopped, and how much it worked.

use crate::time::Time;
use vibrochain_lattice::Barrier;

/// What happened to a contact, which in a lattice is a mass.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum EventKind {
    /// It met a barrier and v⁺ = −e v⁻.
    Impact,
    /// It came to rest on a barrier that it is pressed against, at the limit of its impacts.
    Stick,
    /// The force that pressed it has changed sign, and it leaves the barrier from rest.
    Release,
}

vibrochain_lattice::names!(EventKind { Impact "impact", Stick "stick", Release "release" });

/// One thing that happened to one contact, which in a lattice is a mass. Contacts that hit together make one event each, at the same time, in
/// the order of their numbers, or in that in which the impacts were applied.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Event {
    /// When.
    pub time: Time,
    /// The contact; of a lattice the mass, numbered layer by layer.
    pub contact: usize,
    /// Its barrier.
    pub barrier: Barrier,
    /// Velocity just before, g′⁻ (signed; 0 for stick and release).
    pub velocity_before: f64,
    /// Velocity just after, g′⁺.
    pub velocity_after: f64,
    /// P, which adds M⁻¹w P to q′, negative at an upper barrier: of a unit mass the change of its velocity.
    pub impulse: f64,
    /// What happened.
    pub kind: EventKind,
}

/// How far one call of [`Simulation::run`](crate::Simulation::run) may go; whatever is met first ends it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[must_use]
pub struct Limits {
    /// Simulate up to and including this time. `None`: no limit on time.
    pub until: Option<Time>,
    /// Stop once this many impacts (events of kind impact) have been counted in this call. Simultaneous
    /// impacts are never cut in two, so the last of them may exceed it.
    pub impacts: u64,
    /// Give up on a contact that has met the same barrier this many times in succession, each within [`BOUNCE_TIME`] of the one before, or without a
    /// loss so soon that a period would hold more.
    pub bounces: u32,
    /// Stop after this many windows of flight and restarts, whatever happened.
    pub flights: u64,
}

/// Flights shorter than this, in units of 1/√(γ₁+4γ₂+4γ₃) (or 1/ω where the force is faster), count as bounces of one
/// cascade. A resolved cascade ends when 1e-8 of that unit is left of it, see [`crate::CHATTER_TIME`].
pub const BOUNCE_TIME: f64 = 1e-6;

/// Default of [`Limits::bounces`]. A cascade with e = 0.999 needs about 10⁴ of them.
pub const MAX_BOUNCES: u32 = 100_000;

/// Default of [`Limits::flights`]: hours of work, met only where a period is astronomically long.
pub const MAX_FLIGHTS: u64 = 10_000_000_000;

impl Default for Limits {
    fn default() -> Self {
        Self { until: None, impacts: u64::MAX, bounces: MAX_BOUNCES, flights: MAX_FLIGHTS }
    }
}

impl Limits {
    /// Up to and including `time`, with defaults for the rest.
    pub fn until(time: Time) -> Self {
        Self { until: Some(time), ..Self::default() }
    }

    /// This many impacts, with defaults for the rest. A chain that never hits again would run for
    /// [`MAX_FLIGHTS`]: set `until` as well.
    pub fn impacts(impacts: u64) -> Self {
        Self { impacts, ..Self::default() }
    }
}

/// Why a run ended.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum Outcome {
    /// The time asked for was reached.
    TimeReached,
    /// The number of impacts asked for was reached.
    ImpactsReached,
    /// Two contacts that share a coordinate meet their barriers at one instant, or one pushes another, which rests, into its barrier: what
    /// comes of it depends on the order. The run stands just before it.
    Simultaneous {
        /// One of them.
        first: usize,
        /// The other one.
        second: usize,
    },
    /// A cascade of impacts could not be resolved: [`Limits::bounces`] in a row. A contact that is pressed to its barrier with e = 1, or within
    /// 5e-5 of it, bounces for ever. Its impacts count as one cascade where each follows the last so soon that a period would hold more than
    /// these, and within 1e-3 of the fastest rate's unit.
    Cascade {
        /// The contact.
        contact: usize,
        /// Its barrier.
        barrier: Barrier,
        /// Impacts of the cascade so far.
        bounces: u32,
    },
    /// A mode that feeds itself has grown beyond any use: beyond 1e4 times what barriers, loads and the start make of the modes (by its
    /// own rate, where that is slower than the fastest one). A mode that does not feed itself: beyond 1e100.
    Diverged {
        /// The mode.
        mode: usize,
    },
    /// [`Limits::flights`] was reached.
    WorkLimit,
    /// The run was told to stop ([`Simulation::heed`](crate::Simulation::heed)); another one goes on with it.
    Stopped,
}

/// How much was done, since the simulation was created.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Work {
    /// Windows of flight of the whole lattice that were expanded.
    pub windows: u64,
    /// Restarts of a part of a row around an event, in the middle of a window.
    pub restarts: u64,
    /// Masses whose motion was bounded over a window.
    pub bounds: u64,
    /// Masses a bound could not clear, which were followed one by one.
    pub watched: u64,
    /// Certified steps towards a first contact.
    pub refinements: u64,
    /// Impacts, one a mass.
    pub impacts: u64,
    /// Masses that came to rest on a barrier.
    pub sticks: u64,
    /// Masses that left a barrier from rest.
    pub releases: u64,
}

/// The end of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Report {
    /// Why it ended.
    pub outcome: Outcome,
    /// When.
    pub time: Time,
    /// Work since the simulation was created.
    pub work: Work,
}
