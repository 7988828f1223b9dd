//! Masses with their own orbits as one orbit of a word.

use vibrochain_lattice::Model;

use crate::error::BreatherError;
use crate::orbit::{Hit, Impact, Orbit, SIMULTANEOUS, time_between};
use crate::search::orbit_list::OrbitList;
use crate::search::words::ended::Ended;
use crate::search::words::isolated_mass::Beat;
use crate::word::{Letter, Word};

/// Orbits whose impulses and times differ by less are one.
const SAME: f64 = 1e-8;

/// The masses' hits as those of `word`, if they come in its order: times from its first instant on, in periods of the word, and when by
/// the masses' clock that is.
pub(crate) fn superpose(word: &Word, masses: &[(usize, Vec<Beat>)]) -> Option<(f64, Vec<Hit>)> {
    let mut hits: Vec<Hit> = (masses.iter())
        .flat_map(|(site, beats)| {
            let of = |beat: &Beat| Hit::new(*site, beat.barrier, beat.turn.rem_euclid(1.0), beat.impulse);
            beats.iter().map(of)
        })
        .collect();
    hits.sort_by(|one, other| one.time.total_cmp(&other.time));
    let mut instants: Vec<Vec<Hit>> = Vec::new();
    for hit in hits {
        match instants.last_mut() {
            Some(last) if hit.time - last[0].time <= SIMULTANEOUS => last.push(hit),
            _ => instants.push(vec![hit]),
        }
    }
    // Just before the period is at its beginning.
    let wrapped = |instants: &[Vec<Hit>]| match instants {
        [first, .., last] => first[0].time + 1.0 - last[0].time <= SIMULTANEOUS,
        _ => false,
    };
    if wrapped(&instants) {
        let end = instants.pop().unwrap_or_default();
        instants[0].extend(end);
    }
    let letter = |hit: &Hit| Letter::new(hit.site, hit.barrier);
    instants.iter_mut().for_each(|instant| instant.sort_by_key(letter));
    let n = instants.len();
    let fits = |shift: &usize| {
        let same = |i: usize| instants[(shift + i) % n].iter().map(letter).eq(word.instants()[i].iter().copied());
        n == word.instants().len() && (0..n).all(same)
    };
    let shift = (0..n).find(fits)?;
    let start = instants[shift][0].time;
    let hits = (0..n).flat_map(|i| {
        let instant = &instants[(shift + i) % n];
        let time = (instant[0].time - start).rem_euclid(1.0);
        instant.iter().map(move |hit| Hit { time, ..*hit })
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
pub(crate) fn list(there: Result<Orbit, Ended>, found: &mut OrbitList) {
    match there {
        Ok(orbit) => {
            if !found.orbits.iter().any(|other| is_same(other, &orbit)) {
                found.orbits.push(orbit);
            }
        }
        Err(ended) => found.ended.push(ended),
    }
}

/// Whether two orbits of one word differ by hardly more than rounding, whichever of its impacts each begins with.
fn is_same(one: &Orbit, other: &Orbit) -> bool {
    (0..other.impacts().len()).any(|turn| is_same_from(one, other, turn))
}

/// Whether it is an orbit of a shorter period, gone through several times.
pub(crate) fn repeats_sooner(orbit: &Orbit) -> bool {
    (0..orbit.impacts().len()).any(|turn| orbit.impacts()[turn].time > 0.0 && is_same_from(orbit, orbit, turn))
}

/// The same with the other orbit begun at its impact number `turn`.
fn is_same_from(one: &Orbit, other: &Orbit, turn: usize) -> bool {
    let (period, clock) = (one.period(), one.force_period());
    let close = |x: f64, y: f64| (x - y).abs() <= SAME;
    let (impacts, start) = (other.impacts(), other.impacts()[turn].time);
    let in_phase = one.psi().is_none_or(|psi| time_between(psi, other.psi_or_zero() + start, clock) <= SAME * clock);
    in_phase
        && one.impacts().iter().zip(impacts.iter().cycle().skip(turn)).all(|(one, other)| {
            (one.site, one.barrier) == (other.site, other.barrier)
                && close(one.impulse, other.impulse)
                && time_between(one.time, other.time - start, period) <= SAME * period
        })
}
