//! The orbit that a run has settled on, by the table of its impacts that `simulate --impacts` has written.

use serde::Deserialize;
use vibrochain_lattice::Barrier;
use vibrochain_maps::numbers::Number;

/// The most periods of the force of an orbit that is looked for.
const MOST_PERIODS: u32 = 16;

/// Impacts of one period and of the next are the same to this part of the period, and of the largest change of velocity.
const ALIKE: f64 = 1e-2;

/// Phases of the force from which the orbit is sought: the table has none.
const PHASES: u32 = 24;

#[derive(Deserialize)]
struct Row {
    time: f64,
    #[serde(alias = "contact")]
    site: usize,
    #[serde(default)]
    layer: usize,
    barrier: String,
    velocity_before: f64,
    velocity_after: f64,
    impulse: Option<f64>,
    kind: String,
}

/// An impact of the table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Struck {
    /// Of a structure the contact.
    pub(crate) site: usize,
    pub(crate) layer: usize,
    pub(crate) barrier: Barrier,
    /// Since the first one.
    pub(crate) time: f64,
    pub(crate) impulse: f64,
}

/// Whether a text is a table of impacts.
pub(crate) fn is_one(text: &str) -> bool {
    text.trim_start().starts_with("time,")
}

/// The last impacts of a table, and the periods in which they repeat themselves.
///
/// # Errors
/// The column that is missing, or that nothing repeats itself.
pub(crate) fn settled(text: &str, period: f64) -> Result<(u32, Vec<Struck>), String> {
    let mut all: Vec<Struck> = Vec::new();
    for row in csv::Reader::from_reader(text.as_bytes()).deserialize() {
        let Row { time, site, layer, barrier, velocity_before, velocity_after, impulse, kind } =
            row.map_err(|error| error.to_string())?;
        if kind != "impact" {
            continue;
        }
        let barrier =
            Barrier::from_name(&barrier).ok_or_else(|| format!("`{barrier}` is no barrier, lower and upper are"))?;
        // The masses of a chain are 1.
        let impulse = impulse.unwrap_or(velocity_after - velocity_before);
        if !(time.is_finite() && impulse.is_finite()) {
            refuse!("the impact at t = {time} with the impulse {impulse} is none: give finite numbers");
        }
        all.push(Struck { site, layer, barrier, time, impulse });
    }
    all.sort_by(|one, other| one.time.total_cmp(&other.time));
    let Some(end) = all.last().map(|last| last.time) else { refuse!("the table has no impacts") };
    let largest = all.iter().map(|one| one.impulse.abs()).fold(0.0, f64::max);
    let of_last = |lapse: f64| all.partition_point(|one| one.time <= end - lapse + ALIKE * period);
    for periods in 1..=MOST_PERIODS {
        let lapse = f64::from(periods) * period;
        let (from, before) = (of_last(lapse), of_last(2.0 * lapse));
        let (last, earlier) = (&all[from..], &all[before..from]);
        let same = last.len() == earlier.len()
            && last.iter().zip(earlier).all(|(one, other)| {
                (one.site, one.layer, one.barrier) == (other.site, other.layer, other.barrier)
                    && (one.time - other.time - lapse).abs() <= ALIKE * period
                    && (one.impulse - other.impulse).abs() <= ALIKE * largest
            });
        if same {
            let first = last[0].time;
            return Ok((periods, last.iter().map(|one| Struck { time: one.time - first, ..*one }).collect()));
        }
    }
    Err(format!(
        "its last impacts, up to t = {}, do not repeat themselves within {MOST_PERIODS} periods of {}: let the run settle, or give the \
         impacts of one period as JSON",
        Number(end),
        Number(period)
    ))
}

/// The orbit that Newton's method leads to whose impulses are nearest, of all phases of the force that it may begin at.
///
/// # Errors
/// That of the first phase, where none leads to an orbit.
pub(crate) fn nearest<O, E>(
    struck: &[Struck],
    period: f64,
    mut lead: impl FnMut(f64) -> Result<O, E>,
    impulses: impl Fn(&O) -> Vec<f64>,
) -> Result<O, E> {
    let off = |orbit: &O| -> f64 { impulses(orbit).iter().zip(struck).map(|(p, one)| (p - one.impulse).abs()).sum() };
    let mut best = lead(0.0);
    for phase in 1..PHASES {
        let Ok(orbit) = lead(period * f64::from(phase) / f64::from(PHASES)) else { continue };
        if best.as_ref().map_or(true, |known| off(&orbit) < off(known)) {
            best = Ok(orbit);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Impacts at 0.5 and 1.7 of every second period of 2, which differ at first.
    fn table(last: usize) -> String {
        let rows = (0..last).map(|n| {
            let (time, off) = (4.0 * n as f64, 0.3f64.powi(n as i32));
            let row = |t: f64, barrier, p: f64| format!("{t},0,{barrier},{},{},impact\n", p / 2.0, -p / 2.0);
            row(time + 0.5, "upper", 1.0 + off) + &row(time + 1.7, "lower", -2.0 + off)
        });
        format!("time,site,barrier,velocity_before,velocity_after,kind\n{}", rows.collect::<String>())
    }

    #[test]
    fn the_last_impacts_are_told_with_their_periods() {
        let (periods, struck) = settled(&table(12), 2.0).unwrap();
        assert_eq!((periods, struck.len()), (2, 2));
        assert!((struck[1].time - 1.2).abs() < 1e-12 && (struck[0].impulse + 1.0).abs() < 1e-4, "{struck:?}");
        assert!(settled(&table(2), 2.0).unwrap_err().contains("do not repeat"));
        // In whatever order the rows stand.
        let mut lines: Vec<&str> = Vec::new();
        let whole = table(12);
        lines.extend(whole.lines().take(1));
        lines.extend(whole.lines().skip(1).collect::<Vec<_>>().into_iter().rev());
        assert_eq!(settled(&lines.join("\n"), 2.0).unwrap(), (periods, struck));
        let endless = format!("{whole}inf,0,upper,1,-1,impact\n");
        assert!(settled(&endless, 2.0).unwrap_err().contains("finite numbers"));
        assert!(settled("time,site,barrier\n1,0,upper\n", 2.0).unwrap_err().contains("velocity_before"));
    }
}
