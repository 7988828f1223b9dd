//! Masses with their own orbits as one orbit of a word.

use vibrochain_lattice::Model;

use crate::error::BreatherError;
use crate::orbit::{Hit, Impact, Orbit, SIMULTANEOUS};
use crate::search::finder::Found;
use crate::search::words::ended::Ended;
use crate::search::words::isolated_mass::Beat;
use crate::word::{Letter, Word};

/// Orbits whose impulses and times differ by less are one.
const SAME: f64 = 1e-8;

/// The masses' hits as those of `word`, if they come in its order: times from its first instant on, in periods of the word, and when by
/// the masses' clock that is.
pub(crate) fn side_by_side(word: &Word, masses: &[(usize, Vec<Beat>)]) -> Option<(f64, Vec<Hit>)> {
    let mut beats: Vec<(f64, Letter, f64)> = (masses.iter())
        .flat_map(|(site, beats)| {
            let of = |beat: &Beat| (beat.turn.rem_euclid(1.0), Letter::new(*site, beat.barrier), beat.impulse);
            beats.iter().map(of)
        })
        .collect();
    beats.sort_by(|one, other| one.0.total_cmp(&other.0));
    let mut instants: Vec<Vec<(f64, Letter, f64)>> = Vec::new();
    for beat in beats {
        match instants.last_mut() {
            Some(last) if beat.0 - last[0].0 <= SIMULTANEOUS => last.push(beat),
            _ => instants.push(vec![beat]),
        }
    }
    // Just before the period is at its beginning.
    let wrapped = |instants: &[Vec<(f64, Letter, f64)>]| match instants {
        [first, .., last] => first[0].0 + 1.0 - last[0].0 <= SIMULTANEOUS,
        _ => false,
    };
    if wrapped(&instants) {
        let end = instants.pop().unwrap_or_default();
        instants[0].extend(end);
    }
    instants.iter_mut().for_each(|instant| instant.sort_by_key(|beat| beat.1));
    let n = instants.len();
    let fits = |shift: &usize| {
        let same =
            |i: usize| instants[(shift + i) % n].iter().map(|beat| beat.1).eq(word.instants()[i].iter().copied());
        n == word.instants().len() && (0..n).all(same)
    };
    let shift = (0..n).find(fits)?;
    let start = instants[shift][0].0;
    let hits = (0..n).flat_map(|i| {
        let instant = &instants[(shift + i) % n];
        let turn = (instant[0].0 - start).rem_euclid(1.0);
        instant.iter().map(move |&(_, letter, impulse)| Hit::new(letter.site, letter.barrier, turn, impulse))
    });
    Some((start, hits.collect()))
}

/// The orbit of these hits, times in periods of the orbit, if all impacts are from inside.
pub(crate) fn orbit_of(
    model: &Model,
    periods: u32,
    psi: f64,
    mut hits: Vec<Hit>,
) -> Result<Option<Orbit>, BreatherError> {
    let period = model.period() * f64::from(periods);
    hits.iter_mut().for_each(|hit| hit.time *= period);
    let orbit = Orbit::from_impulses(model, periods, psi.rem_euclid(model.period()), &hits)?;
    Ok(orbit.impacts().iter().all(Impact::is_right_signed).then_some(orbit))
}

/// Lists where a branch has come to, or why it has not.
pub(crate) fn list(there: Result<Orbit, Ended>, found: &mut Found) {
    match there {
        Ok(orbit) => {
            if !found.orbits.iter().any(|other| is_same(other, &orbit)) {
                found.orbits.push(orbit);
            }
        }
        Err(ended) => found.ended.push(ended),
    }
}

fn is_same(one: &Orbit, other: &Orbit) -> bool {
    let (period, clock) = (one.period(), one.model().period());
    let close = |x: f64, y: f64| (x - y).abs() <= SAME;
    let apart = |x: f64, y: f64, period: f64| (x - y).abs().min(period - (x - y).abs());
    apart(one.psi_or_zero(), other.psi_or_zero(), clock) <= SAME * clock
        && one.impacts().iter().zip(other.impacts()).all(|(one, other)| {
            one.site == other.site
                && close(one.impulse, other.impulse)
                && apart(one.time, other.time, period) <= SAME * period
        })
}
