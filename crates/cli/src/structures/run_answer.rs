//! What a run of a structure came to: what its last impacts repeat, as text and as JSON.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use crate::common::schemas::STRUCTURE_RUN;
use crate::simulate::name_of;
use serde_json::{Value, json};
use vibrochain_breather::{Hit, LoadedStructure};
use vibrochain_eventsim::{EnergyBalance, Event, EventKind, Outcome, Report, State, Time};
use vibrochain_floquet::{Tolerance, Verdict, stability};
use vibrochain_lattice::{Barrier, Short, Stop, Stopped};
use vibrochain_maps::numbers::Number;
use vibrochain_maps::structure::StructureScene;
use vibrochain_maps::structure::answer::structure;

/// Periods of the load that one of what a run repeats may have.
pub(super) const MOST_PERIODS: u64 = 32;

/// Impacts that one of what a run without a load repeats may have.
const MOST_IMPACTS: usize = 8;

/// So often a pattern must be seen.
pub(super) const REPETITIONS: u64 = 4;

/// How far impacts that repeat may be from an orbit that holds them: times in periods of the load, impulses as a part of themselves.
const ALIKE: f64 = 1e-6;

/// Differences below this are as good as rounding: no orbit need hold the impacts.
const EQUAL: f64 = 1e-10;

/// What differs by more is another impact.
const FAR: f64 = 1e-2;

/// What the impacts at the end of a run repeat.
pub(super) struct Settled {
    /// Whether the orbit that holds them is, if that is known.
    stable: Option<bool>,
    /// Periods of the load; 0 without one.
    force_periods: u64,
    period: f64,
    psi: f64,
    impacts: Vec<Hit>,
}

/// What a run has come to.
pub(super) enum End {
    /// An orbit.
    Repeats(Settled),
    /// Nearly: its impacts change by so much a period.
    Moves(f64),
    /// A contact rests on its barrier: no word says that.
    Rests,
    /// None of these.
    Other,
    /// Where nothing has a period: a contact rests on its barrier.
    AtRest,
    /// The same: what repeats is not looked for.
    Untold,
}

impl Settled {
    fn word(&self) -> String {
        let letter = |hit: &Hit| format!("{}{}", hit.site, if hit.barrier == Barrier::Upper { '+' } else { '-' });
        self.impacts.iter().map(letter).collect::<Vec<_>>().join(",")
    }
}

/// By how much two patterns differ; `None`: they are not of the same impacts.
fn apart(a: &[(&Event, f64)], b: &[(&Event, f64)]) -> Option<f64> {
    let same = |((a, _), (b, _)): (&(&Event, f64), &(&Event, f64))| {
        [a.kind, b.kind] == [EventKind::Impact; 2] && (a.contact, a.barrier) == (b.contact, b.barrier)
    };
    let differ = |((a, from), (b, to)): (&(&Event, f64), &(&Event, f64))| {
        let impulse = (a.impulse - b.impulse).abs();
        (from - to).abs().max(if impulse == 0.0 { 0.0 } else { impulse / a.impulse.abs() })
    };
    let pairs = || a.iter().zip(b);
    (a.len() == b.len() && pairs().all(same)).then(|| pairs().map(differ).fold(0.0, f64::max))
}

/// The part of a period that is farthest from all `times`, in periods: an impact at the border of a pattern would now be in, now out.
fn quiet(times: impl Iterator<Item = f64>) -> f64 {
    let mut parts: Vec<f64> = times.map(|time| time.rem_euclid(1.0)).collect();
    parts.sort_by(f64::total_cmp);
    let Some(first) = parts.first().copied() else { return 0.0 };
    let next = parts.iter().skip(1).copied().chain([first + 1.0]);
    let gaps: Vec<(f64, f64)> = parts.iter().zip(next).map(|(part, next)| (next - part, 0.5 * (part + next))).collect();
    let widest = gaps.iter().fold(0.0, |most: f64, (gap, _)| most.max(*gap));
    // Of gaps that are alike the first, whatever rounding makes of them.
    gaps.iter().find(|(gap, _)| *gap >= widest - ALIKE).map_or(0.0, |(_, middle)| middle.rem_euclid(1.0))
}

impl Settled {
    /// The verdict on the orbit that holds these impacts: Newton's method finds it from here. Differences from one repetition to the next
    /// tell less: rounding makes them shrink or grow, and on a torus they may shrink for long.
    fn verdict(&self, model: &LoadedStructure) -> Option<Verdict> {
        let forced = self.force_periods > 0;
        let own = if forced { model.clone() } else { model.at(TAU / self.period).ok()? };
        let count = self.force_periods.max(1) as u32;
        let orbit = own.orbit_near(count, self.psi, &self.impacts).ok()?;
        let period = own.period();
        let late = orbit.psi().map_or(0.0, |psi| (psi - self.psi + 0.5 * period).rem_euclid(period) - 0.5 * period);
        let off = self.impacts.iter().zip(orbit.impacts()).map(|(hit, own)| {
            let impulse = (own.impulse - hit.impulse).abs() / own.impulse.abs();
            ((own.time - hit.time + late).abs() / period).max(impulse)
        });
        let is_near = off.fold(0.0, f64::max) <= ALIKE;
        is_near.then(|| stability(&orbit, Tolerance::Rounding).ok()).flatten().map(|known| known.verdict)
    }
}

/// The shortest pattern that the last impacts of a run repeat: next to an orbit that is stable or not, or, where that is neutral or unknown, to
/// rounding. `rests`: whether a contact rests in the end.
///
/// # Errors
/// [`Stopped`].
pub(super) fn settled(
    model: &LoadedStructure,
    psi: f64,
    events: &[Event],
    (end, rests): (Time, bool),
    stop: &Stop,
) -> Result<End, Stopped> {
    let period = model.period();
    let since = |event: &Event| {
        (end.periods() as f64 - event.time.periods() as f64) + (end.offset() - event.time.offset()) / period
    };
    let is_lately = |event: &Event| event.kind != EventKind::Impact && since(event) < REPETITIONS as f64;
    if rests || events.iter().any(is_lately) {
        return Ok(End::Rests);
    }
    if !model.structure().is_forced() {
        return Ok(of_own_period(model, events));
    }
    let late = quiet(events.iter().map(since).filter(|since| *since < MOST_PERIODS as f64));
    let since = |event: &Event| since(event) - late;
    let seen = events.first().map_or(0.0, since);
    // Of periods that do not repeat well enough, their differences.
    let mut missed: Vec<(u64, f64)> = Vec::new();
    for count in (1..=MOST_PERIODS).take_while(|count| (REPETITIONS * count) as f64 <= seen) {
        stop.heard()?;
        let windows = [0, 1, 2, 3].map(|number: u64| -> Vec<(&Event, f64)> {
            let (from, to) = (((number + 1) * count) as f64, (number * count) as f64);
            let inside = |event: &&Event| (to..from).contains(&since(event));
            events.iter().filter(inside).map(|event| (event, since(event) - to)).collect()
        });
        let [last, before, second, first] = &windows;
        let differences = [apart(last, before), apart(before, second), apart(second, first)];
        let ([Some(now), Some(then), Some(once)], false) = (differences, last.is_empty()) else { continue };
        let begin = last[0].0.time;
        let impacts = last.iter().map(|(event, _)| {
            let lapse = (event.time.periods() as f64 - begin.periods() as f64) * period
                + (event.time.offset() - begin.offset());
            Hit::new(event.contact, event.barrier, lapse, event.impulse)
        });
        let mut settled = Settled {
            stable: None,
            force_periods: count,
            period: count as f64 * period,
            psi: (psi + begin.offset()).rem_euclid(period),
            impacts: impacts.collect(),
        };
        let is_shorter = |(shorter, by): &(u64, f64)| count % shorter == 0 && *by <= ALIKE;
        let is_equal = now.max(then).max(once) <= EQUAL && !missed.iter().any(is_shorter);
        let verdict = if now <= FAR { settled.verdict(model) } else { None };
        let verdict = verdict.filter(|verdict| !verdict.undecided);
        // About a neutral orbit there may be tori.
        if is_equal || verdict.is_some_and(|verdict| verdict.excess() != 0.0) {
            settled.stable = verdict.map(|verdict| verdict.stable);
            return Ok(End::Repeats(settled));
        }
        missed.push((count, now));
    }
    let nearly = missed.iter().filter(|(_, by)| *by < FAR).map(|(count, by)| by / *count as f64);
    Ok(nearly.reduce(f64::min).map_or(End::Other, End::Moves))
}

/// The same without a load, which gives no period: by the order of the impacts.
fn of_own_period(model: &LoadedStructure, events: &[Event]) -> End {
    let after = |event: &Event, begin: &Event| {
        let periods = event.time.periods() as f64 - begin.time.periods() as f64;
        periods * model.period() + (event.time.offset() - begin.time.offset())
    };
    let (mut missed, whole) = (Vec::new(), REPETITIONS as usize);
    for count in 1..=MOST_IMPACTS {
        let Some(from) = events.len().checked_sub(whole * count + 1) else { break };
        let latest = &events[from..];
        let lasted = |n: usize| after(&latest[(n + 1) * count], &latest[n * count]);
        let windows = [0, 1, 2, 3].map(|n: usize| -> Vec<(&Event, f64)> {
            let begin = &latest[n * count];
            latest[n * count..(n + 1) * count].iter().map(|event| (event, after(event, begin) / lasted(n))).collect()
        });
        let [first, second, before, last] = &windows;
        let differences = [apart(last, before), apart(before, second), apart(second, first)];
        let [Some(now), Some(then), Some(once)] = differences else { continue };
        let period = lasted(3);
        let slip = (lasted(2) - period).abs() / period;
        let begin = &latest[3 * count];
        let hit = |event: &Event| Hit::new(event.contact, event.barrier, after(event, begin), event.impulse);
        let impacts = latest[3 * count..4 * count].iter().map(hit).collect();
        let mut settled = Settled { stable: None, force_periods: 0, period, psi: 0.0, impacts };
        let now = now.max(slip);
        let verdict = if now <= FAR { settled.verdict(model) } else { None };
        let verdict = verdict.filter(|verdict| !verdict.undecided);
        if now.max(then).max(once) <= EQUAL || verdict.is_some_and(|verdict| verdict.excess() != 0.0) {
            settled.stable = verdict.map(|verdict| verdict.stable);
            return End::Repeats(settled);
        }
        missed.push(now);
    }
    missed.into_iter().filter(|by| *by < FAR).reduce(f64::min).map_or(End::Other, End::Moves)
}

fn outcome(outcome: &Outcome) -> String {
    match outcome {
        Outcome::TimeReached => "the time asked for was reached".to_owned(),
        Outcome::ImpactsReached => "the impacts asked for were reached".to_owned(),
        Outcome::Simultaneous { first, second } => {
            format!(
                "contacts {first} and {second} share a coordinate and hit at one instant: what comes of it depends on their order; --in-sequence lets them hit in that of their numbers"
            )
        }
        Outcome::Cascade { contact, barrier, bounces: 0 } => {
            format!(
                "impacts of contact {contact} on its {barrier} barrier follow each other at one instant without an end"
            )
        }
        Outcome::Cascade { contact, barrier, bounces } => {
            format!(
                "contact {contact} has hit its {barrier} barrier {bounces} times in a cascade that could not be resolved: pressed without a loss it bounces for ever; give it a restitution below 1, as 0.999"
            )
        }
        Outcome::Diverged { mode } => format!(
            "mode {mode} grows without bound: it is beyond 1e4 times what barriers, loads and the start make of the modes, or 1e100"
        ),
        Outcome::WorkLimit => "the limit of work was reached".to_owned(),
        Outcome::Stopped => "it was told to stop".to_owned(),
    }
}

pub(super) fn text(
    (model, has_period): (&LoadedStructure, bool),
    from: &str,
    report: &Report,
    [impacts, sticks, releases]: [usize; 3],
    settled: &End,
) -> String {
    let mut out = String::new();
    // Writing to a String cannot fail.
    let is_driven = has_period && !model.structure().has_own_period();
    let driven = if is_driven { format!("omega = {}", Short(model.omega())) } else { "no load".to_owned() };
    let _ = writeln!(out, "from {from}, {driven}");
    let _ = writeln!(
        out,
        "{impacts} impacts, {sticks} sticks, {releases} releases up to t = {}",
        Number(report.time.to_f64())
    );
    if report.outcome != Outcome::TimeReached {
        let _ = writeln!(out, "ended: {}", outcome(&report.outcome));
    }
    let is_short = report.time.in_periods() < REPETITIONS as f64;
    match settled {
        End::Repeats(settled) if settled.force_periods == 0 => {
            let held = if settled.stable == Some(false) { ": an unstable orbit, which it will leave" } else { "" };
            let _ = writeln!(out, "it repeats {}, with a period of {}{held}", settled.word(), Number(settled.period));
        }
        End::Repeats(settled) => {
            let plural = if settled.force_periods == 1 { "" } else { "s" };
            let held = if settled.stable == Some(false) { ": an unstable orbit, which it will leave" } else { "" };
            let _ = writeln!(
                out,
                "it repeats {} every {} period{plural} of the load{held}",
                settled.word(),
                settled.force_periods
            );
        }
        End::Moves(by) => {
            let _ = writeln!(out, "it has not settled yet: its impacts are still moving by {by:.1e} a period");
        }
        End::Rests => {
            let when = if is_short { String::new() } else { format!(" in the last {REPETITIONS} periods") };
            let _ = writeln!(out, "a contact rests on its barrier{when}: no word says that");
        }
        End::Other if impacts > 0 && is_short => {
            let _ =
                writeln!(out, "it is too short to tell what its impacts repeat: give {REPETITIONS} periods or more");
        }
        End::Other if impacts > 0 => {
            let _ =
                writeln!(out, "its last impacts do not repeat {REPETITIONS} times within {MOST_PERIODS} periods each");
        }
        End::AtRest => {
            let _ = writeln!(out, "a contact rests on its barrier at the end");
        }
        End::Other | End::Untold => {}
    }
    out
}

/// Where the energy has gone: work done less what is lost is what there is more of, to rounding.
pub(super) fn energy_text([before, after]: [f64; 2], balance: &EnergyBalance) -> String {
    let EnergyBalance { work, dashpots, impacts } = *balance;
    let missing = (after - before) - (work - dashpots - impacts);
    format!(
        "energy {} -> {}: work of the loads {}, lost in dashpots {}, lost at impacts {}; unaccounted for {missing:.1e}\n",
        Number(before),
        Number(after),
        Number(work),
        Number(dashpots),
        Number(impacts)
    )
}

pub(super) fn answer(
    scene: &StructureScene,
    (model, has_period): (&LoadedStructure, bool),
    psi: f64,
    report: &Report,
    state: &State,
    [impacts, sticks, releases]: [usize; 3],
    settled: &End,
) -> Value {
    let psi_there = if has_period { (psi + state.time.offset()).rem_euclid(model.period()) } else { psi };
    let settled = if let End::Repeats(settled) = settled { Some(settled) } else { None };
    let repeated = settled.map(|settled| {
        let impacts = settled.impacts.iter().map(|Hit { site, barrier, time, impulse }| {
            json!({ "contact": site, "barrier": barrier.name(), "time": time, "impulse": impulse })
        });
        json!({
            "word": settled.word(),
            "stable": settled.stable,
            "period": settled.period,
            "psi": settled.psi,
            "impacts": impacts.collect::<Vec<_>>(),
        })
    });
    let mut structure = structure(scene, model);
    if !has_period {
        structure["omega"] = Value::Null;
    }
    json!({
        "schema": STRUCTURE_RUN,
        "structure": structure,
        "psi": psi,
        "outcome": name_of(&report.outcome),
        "time": report.time.to_f64(),
        "impacts": impacts,
        "sticks": sticks,
        "releases": releases,
        "repeats": repeated,
        "state": { "displacement": state.displacement, "velocity": state.velocity, "psi": psi_there },
    })
}
