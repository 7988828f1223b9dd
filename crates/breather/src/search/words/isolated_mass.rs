//! Orbits of one mass without coupling, as each site of a word is where nothing couples it.
//!
//! Without a force a mass on a spring between two barriers hits one of them, always after the same time, or both in turns: what it
//! does in a period of the word it does there several times over, by the clock of its own. Under a force the families have all its
//! orbits of one period of the force, and of two; each may be repeated, and begin in whichever period.

use vibrochain_lattice::{Barrier, Chain, Model, Stop};

use crate::error::{BreatherError, NoBreather, Unsearched};
use crate::orbit::{Impact, Orbit};
use crate::search::at_point::Sought;
use crate::search::finder::{Finder, Scope};
use crate::search::orbit_list::OrbitList;
use crate::word::{Letter, Word};

/// A hit of a mass.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Beat {
    pub(crate) barrier: Barrier,
    /// The time, in periods of the word; while a mass is sought alone, of the force.
    pub(crate) turn: f64,
    pub(crate) impulse: f64,
}

/// One orbit of a mass alone.
#[derive(Debug, Clone)]
pub(crate) struct Alone {
    /// Its hits in one period of the word; by the clock of the force where there is one, from its first hit on where there is none.
    pub(crate) beats: Vec<Beat>,
    /// How often it does the same in a period of the word.
    pub(crate) repeats: u32,
    /// Of the periods of the force in which it might begin as well, the one it begins in.
    pub(crate) later: u32,
}

/// What was found, or why there is nothing.
type Orbits<T> = Result<Result<T, NoBreather>, BreatherError>;

/// Those of a mass without force and losses that hits these barriers, in turn, in a period of the word.
pub(crate) fn without_force(model: &Model, barriers: &[Barrier], stop: &Stop) -> Orbits<Vec<Alone>> {
    let n = barriers.len();
    let in_turns = n.is_multiple_of(2) && (0..n).all(|i| barriers[i] != barriers[(i + 1) % n]);
    let base: &[Barrier] = match barriers.first() {
        Some(first) if barriers.iter().all(|barrier| barrier == first) => &barriers[..1],
        Some(_) if in_turns => &[Barrier::Upper, Barrier::Lower],
        _ => return Ok(Err(NoBreather::NoStart)),
    };
    let repeats = n / base.len();
    let chain = Chain::new(1, model.chain().gamma1(), 0.0)?;
    let model = Model::conservative(chain, model.omega() * repeats as f64, model.asymmetry())?;
    let word = Word::new(base.iter().map(|&barrier| vec![Letter::new(0, barrier)]).collect())?;
    let mut found = OrbitList::default();
    Finder::new(1).until(stop).find_word(&model, &word, Scope::Symmetric, &mut found)?;
    let of = |orbit: &Orbit| Alone {
        beats: (0..repeats)
            .flat_map(|again| {
                let turn = move |impact: &Impact| (again as f64 + impact.time / orbit.period()) / repeats as f64;
                orbit.impacts().iter().map(move |impact| Beat {
                    barrier: impact.barrier,
                    turn: turn(impact),
                    impulse: impact.impulse,
                })
            })
            .collect(),
        repeats: repeats as u32,
        later: 0,
    };
    let inward = |orbit: &&Orbit| orbit.impacts().iter().all(Impact::is_right_signed);
    let list: Vec<Alone> = found.orbits.iter().filter(inward).map(of).collect();
    Ok(if list.is_empty() { Err(NoBreather::NoStart) } else { Ok(list) })
}

/// Those of a mass under the model's force that hits these barriers, in turn, in so many periods of it, and at how many places of the
/// search others may be missing; or why there are none.
pub(crate) fn under_force(
    model: &Model,
    barriers: &[Barrier],
    periods: u32,
    stop: &Stop,
) -> Orbits<(Vec<Alone>, usize)> {
    let model = model.point().on(&Chain::new(1, model.chain().gamma1(), 0.0)?).model()?;
    let n = barriers.len();
    let (mut list, mut open) = (Vec::new(), 0);
    let mut why = None;
    for repeats in (1..=periods).filter(|&part| periods.is_multiple_of(part) && n.is_multiple_of(part as usize)) {
        let (own, base) = (periods / repeats, n / repeats as usize);
        if (0..n).any(|i| barriers[i] != barriers[(i + base) % n]) {
            continue;
        }
        match in_periods(&model, &barriers[..base], own, stop)? {
            Ok((orbits, missing)) => {
                open += missing;
                for (beats, later) in orbits.iter().flat_map(|beats| (0..own).map(move |later| (beats, later))) {
                    let at = |clock: f64, again: u32| {
                        (clock + f64::from(later + again * own)).rem_euclid(f64::from(periods)) / f64::from(periods)
                    };
                    let all = (0..repeats)
                        .flat_map(|again| beats.iter().map(move |&beat| Beat { turn: at(beat.turn, again), ..beat }));
                    list.push(Alone { beats: all.collect(), repeats, later });
                }
            }
            // What could not be searched for is not shown not to be there.
            Err(reason) => why = why.filter(|why| matches!(why, NoBreather::NotSearched(_))).or(Some(reason)),
        }
    }
    // What was not searched to its end is not shown to be empty.
    Ok(if list.is_empty() && open == 0 { Err(why.unwrap_or(NoBreather::NoStart)) } else { Ok((list, open)) })
}

/// Those of a mass alone that do not repeat sooner than after `own` periods of the force: their hits by its clock, in its periods; and
/// at how many places others may be missing.
fn in_periods(model: &Model, barriers: &[Barrier], own: u32, stop: &Stop) -> Orbits<(Vec<Vec<Beat>>, usize)> {
    let Some(sought) = Sought::of(barriers, own) else {
        return Ok(Err(NoBreather::NotSearched(Unsearched::ManyImpacts)));
    };
    let mut finder = Finder::new(1).until(stop);
    let clock = |time: f64| (time / model.period()).rem_euclid(f64::from(own));
    let mut found = OrbitList::default();
    finder.search_at(model, sought, 0, Scope::All, &mut found)?;
    if let Some(none) = found.completeness.reason() {
        return Ok(Err(none));
    }
    let of = |orbit: &Orbit| -> Vec<Beat> {
        let beat = |impact: &Impact| Beat {
            barrier: impact.barrier,
            turn: clock(impact.time + orbit.psi_or_zero()),
            impulse: impact.impulse,
        };
        orbit.impacts().iter().map(beat).collect()
    };
    let (unresolved, exhausted) = found.completeness.open();
    Ok(Ok((found.orbits.iter().map(of).collect(), unresolved + exhausted)))
}
