//! Panels of a structure's orbit: contacts over a period between their barriers, and phase portraits.

use vibrochain_breather::{BreatherError, ContactMotion, ContactOrbit, Obstruction};
use vibrochain_lattice::{Barrier, Contact};

use crate::panels::curves::Pane;
use crate::panels::orbit::{Trace, portrait_pane, trace_pane};

/// Samples of one flight between impacts.
const FLIGHT: usize = 160;

/// Contacts that are drawn at most.
const MOST: usize = 6;

/// Contacts between the same barriers, with their traces.
struct Group {
    contact: Contact,
    traces: Vec<(usize, Trace)>,
}

impl Group {
    fn name(&self) -> String {
        match &self.traces[..] {
            [(contact, _)] => format!("g of contact {contact}"),
            _ => "g of the contacts".to_owned(),
        }
    }

    fn levels(&self) -> Vec<f64> {
        [self.contact.lower, self.contact.upper].into_iter().flatten().collect()
    }

    fn trace(&self) -> Pane {
        let traces: Vec<Trace> = self.traces.iter().map(|(_, trace)| trace.clone()).collect();
        Pane { levels: self.levels(), ..trace_pane(&self.name(), &traces) }
    }

    /// Of the first one.
    fn portrait(&self) -> Pane {
        let (contact, trace) = &self.traces[0];
        let pane = portrait_pane(&format!("g of contact {contact}"), "velocity g′", trace);
        Pane { uprights: self.levels(), ..pane }
    }
}

/// A trace and a phase portrait for all contacts between the same barriers that are hit or in the way.
///
/// # Errors
/// [`BreatherError`] at a resonance.
pub fn contact_panes(orbit: &ContactOrbit, obstruction: Option<&Obstruction>) -> Result<Vec<[Pane; 2]>, BreatherError> {
    Ok(groups(orbit, obstruction)?.iter().map(|group| [group.trace(), group.portrait()]).collect())
}

/// Those that are hit, and the one that is in the way.
fn groups(orbit: &ContactOrbit, obstruction: Option<&Obstruction>) -> Result<Vec<Group>, BreatherError> {
    let mut shown: Vec<usize> = orbit.impacts().iter().map(|impact| impact.site).collect();
    shown.extend(obstruction.map(Obstruction::site));
    let mut seen = Vec::new();
    shown.retain(|contact| {
        !seen.contains(contact) && seen.len() < MOST && {
            seen.push(*contact);
            true
        }
    });
    let motion = ContactMotion::new(orbit)?;
    let mut groups: Vec<Group> = Vec::new();
    for number in shown {
        let contact = orbit.model().structure().contacts()[number];
        let trace = trace(orbit, &motion, number, contact);
        let same = |group: &&mut Group| (group.contact.lower, group.contact.upper) == (contact.lower, contact.upper);
        match groups.iter_mut().find(same) {
            Some(group) => group.traces.push((number, trace)),
            None => groups.push(Group { contact, traces: vec![(number, trace)] }),
        }
    }
    Ok(groups)
}

fn trace(orbit: &ContactOrbit, motion: &ContactMotion<'_>, number: usize, contact: Contact) -> Trace {
    let (impacts, period) = (orbit.impacts(), orbit.period());
    let flight = |i: usize| {
        let length = motion.until_next(i);
        let point = |k: usize| {
            let s = length * k as f64 / FLIGHT as f64;
            let [place, velocity, _] = motion.contact(number, i, s);
            [(impacts[i].time + s) / period, place, velocity]
        };
        (0..=FLIGHT).map(point).collect()
    };
    // The one at t = 0 ends the period, too.
    let ends = |time: f64| [Some(time), (time == 0.0).then_some(1.0)].into_iter().flatten();
    let own = impacts.iter().filter(|impact| impact.site == number);
    let place = |barrier: Barrier| contact.barrier(barrier).unwrap_or(f64::NAN);
    Trace {
        name: format!("contact {number}"),
        flights: (0..impacts.len()).map(flight).collect(),
        impacts: own.flat_map(|impact| ends(impact.time / period).map(|time| (time, place(impact.barrier)))).collect(),
    }
}
