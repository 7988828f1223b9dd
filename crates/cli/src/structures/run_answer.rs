//! What a run of a structure came to: what its last impacts repeat, as text and as JSON.

use std::fmt::Write as _;

use serde_json::{Value, json};
use vibrochain_breather::StructureModel;
use vibrochain_eventsim::{ContactEvent, EnergyBalance, EventKind, StructureOutcome, StructureReport, Time};
use vibrochain_lattice::{Barrier, Short};
use vibrochain_maps::numbers::Number;
use vibrochain_maps::structure::StructureScene;
use vibrochain_maps::structure::answer::structure;

/// What the answer names in its first key.
const SCHEMA: &str = "urn:vibrochain:structure-run:1";

/// Periods of the load that one of what a run repeats may have.
pub(super) const MOST_PERIODS: u64 = 32;

/// By how much impacts that repeat may differ: times in periods of the load, impulses as a part of themselves.
const ALIKE: f64 = 1e-6;

/// What the impacts at the end of a run repeat.
pub(super) struct Settled {
    force_periods: u64,
    psi: f64,
    impacts: Vec<(usize, Barrier, f64, f64)>,
}

impl Settled {
    fn word(&self) -> String {
        let letter = |(contact, barrier, ..): &(usize, Barrier, f64, f64)| {
            format!("{contact}{}", if *barrier == Barrier::Upper { '+' } else { '-' })
        };
        self.impacts.iter().map(letter).collect::<Vec<_>>().join(",")
    }
}

/// The shortest pattern that the last impacts repeat three times; `None` of rests, and of what does not repeat.
pub(super) fn settled(model: &StructureModel, psi: f64, events: &[ContactEvent], end: Time) -> Option<Settled> {
    let period = model.period();
    let since = |event: &ContactEvent| {
        (end.periods() as f64 - event.time.periods() as f64) + (end.offset() - event.time.offset()) / period
    };
    for count in 1..=MOST_PERIODS {
        let window = |number: u64| -> Vec<(&ContactEvent, f64)> {
            let (from, to) = ((number + 1) as f64 * count as f64, number as f64 * count as f64);
            let inside = |event: &&ContactEvent| (to..from).contains(&since(event));
            events.iter().filter(inside).map(|event| (event, since(event) - to)).collect()
        };
        let (last, before, first) = (window(0), window(1), window(2));
        if last.is_empty() || events.first().is_none_or(|event| since(event) < 3.0 * count as f64) {
            continue;
        }
        let same = |a: &[(&ContactEvent, f64)], b: &[(&ContactEvent, f64)]| {
            a.len() == b.len()
                && a.iter().zip(b).all(|((a, from), (b, to))| {
                    a.kind == EventKind::Impact
                        && b.kind == EventKind::Impact
                        && (a.contact, a.barrier) == (b.contact, b.barrier)
                        && (from - to).abs() < ALIKE
                        && (a.impulse - b.impulse).abs() < ALIKE * a.impulse.abs()
                })
        };
        if same(&last, &before) && same(&before, &first) {
            let begin = last[0].0.time;
            let impacts = last.iter().map(|(event, _)| {
                let lapse = (event.time.periods() as f64 - begin.periods() as f64) * period
                    + (event.time.offset() - begin.offset());
                (event.contact, event.barrier, lapse, event.impulse)
            });
            return Some(Settled {
                force_periods: count,
                psi: (psi + begin.offset()).rem_euclid(period),
                impacts: impacts.collect(),
            });
        }
    }
    None
}

fn outcome(outcome: &StructureOutcome) -> String {
    match outcome {
        StructureOutcome::TimeReached => "the time asked for was reached".to_owned(),
        StructureOutcome::ImpactsReached => "the impacts asked for were reached".to_owned(),
        StructureOutcome::Simultaneous { first, second } => {
            format!(
                "contacts {first} and {second} share a coordinate and hit at one instant: what comes of it depends on their order"
            )
        }
        StructureOutcome::Cascade { contact, barrier, bounces } => {
            format!(
                "contact {contact} has hit its {barrier} barrier {bounces} times in a cascade that could not be resolved"
            )
        }
        StructureOutcome::Diverged { mode } => format!("mode {mode} grows without bound"),
        StructureOutcome::WorkLimit => "the limit of work was reached".to_owned(),
    }
}

fn name(outcome: &StructureOutcome) -> &'static str {
    match outcome {
        StructureOutcome::TimeReached => "time-reached",
        StructureOutcome::ImpactsReached => "impacts-reached",
        StructureOutcome::Simultaneous { .. } => "simultaneous",
        StructureOutcome::Cascade { .. } => "cascade",
        StructureOutcome::Diverged { .. } => "diverged",
        StructureOutcome::WorkLimit => "work-limit",
    }
}

pub(super) fn text(
    model: &StructureModel,
    from: &str,
    report: &StructureReport,
    [impacts, sticks, releases]: [usize; 3],
    settled: Option<&Settled>,
) -> String {
    let mut out = String::new();
    // Writing to a String cannot fail.
    let _ = writeln!(out, "from {from}, omega = {}", Short(model.omega()));
    let _ = writeln!(
        out,
        "{impacts} impacts, {sticks} sticks, {releases} releases up to t = {}",
        Number(report.time.to_f64())
    );
    if report.outcome != StructureOutcome::TimeReached {
        let _ = writeln!(out, "ended: {}", outcome(&report.outcome));
    }
    match settled {
        Some(settled) => {
            let plural = if settled.force_periods == 1 { "" } else { "s" };
            let _ = writeln!(
                out,
                "it repeats {} every {} period{plural} of the load",
                settled.word(),
                settled.force_periods
            );
        }
        None if impacts > 0 => {
            let _ = writeln!(out, "its last impacts do not repeat three times within {MOST_PERIODS} periods each");
        }
        None => {}
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
    model: &StructureModel,
    psi: f64,
    report: &StructureReport,
    [impacts, sticks, releases]: [usize; 3],
    settled: Option<&Settled>,
) -> Value {
    let repeated = settled.map(|settled| {
        let impacts = settled.impacts.iter().map(|(contact, barrier, time, impulse)| {
            json!({ "contact": contact, "barrier": barrier.name(), "time": time, "impulse": impulse })
        });
        json!({
            "word": settled.word(),
            "period": settled.force_periods as f64 * model.period(),
            "psi": settled.psi,
            "impacts": impacts.collect::<Vec<_>>(),
        })
    });
    json!({
        "schema": SCHEMA,
        "structure": structure(scene, model),
        "psi": psi,
        "outcome": name(&report.outcome),
        "time": report.time.to_f64(),
        "impacts": impacts,
        "sticks": sticks,
        "releases": releases,
        "repeats": repeated,
    })
}
