//! What figures of orbits, branches and curves hold.

pub(crate) mod contact_panes;
pub(crate) mod diagram;
pub(crate) mod event_curves;
pub(crate) mod orbit_panes;
