//! Which chunks are whose, where many processes share a sweep.

use std::str::FromStr;

use super::plan::Plan;
use crate::error::MapError;
use crate::grid::Grid;

/// One of several shares of a sweep: every `count`-th chunk, so that slow regions are spread over all.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    /// Number of this one, from 0.
    pub index: u64,
    /// How many there are.
    pub count: u64,
}

/// `--shard`, as given.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ShardFlag {
    /// i/n.
    Of(Shard),
    /// As the task of a Slurm array says.
    Slurm,
}

impl FromStr for ShardFlag {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "slurm" {
            return Ok(Self::Slurm);
        }
        let parts = text.split_once('/').and_then(|(i, n)| Some((i.parse::<u64>().ok()?, n.parse::<u64>().ok()?)));
        match parts {
            Some((index, count)) if index < count => Ok(Self::Of(Shard { index, count })),
            Some((index, count)) => {
                let range = if count == 0 { "at least one shard".to_owned() } else { format!("0 to {}", count - 1) };
                Err(format!("there is no shard {index} of {count}: give {range}; shards count from 0"))
            }
            None => Err("give i/n, shard i of n counted from 0, as in 0/4; or slurm, in a job array".to_owned()),
        }
    }
}

impl std::fmt::Display for ShardFlag {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Of(Shard { index, count }) => write!(f, "{index}/{count}"),
            Self::Slurm => f.write_str("slurm"),
        }
    }
}

/// A variable that Slurm sets.
fn number(get: &impl Fn(&str) -> Option<String>, name: &str) -> Result<Option<u64>, MapError> {
    let Some(text) = get(name) else { return Ok(None) };
    let wrong = |_| MapError::Request(format!("{name} = {text} is no whole number: give --shard i/n instead of slurm"));
    text.trim().parse().map(Some).map_err(wrong)
}

impl Shard {
    /// The whole.
    pub const WHOLE: Self = Self { index: 0, count: 1 };

    /// Numbers of its chunks.
    pub fn chunks<S: Grid>(self, plan: &Plan<S>) -> impl Iterator<Item = u64> + use<S> {
        // More steps than any folder has chunks are as good as any number of them.
        (self.index..plan.chunks()).step_by(usize::try_from(self.count).unwrap_or(usize::MAX))
    }

    /// The shard of this task of a Slurm array, whatever its numbers start at and step by. `get` looks up the environment.
    ///
    /// # Errors
    /// [`MapError::Request`] outside an array, and in one with gaps.
    pub fn of_slurm(get: impl Fn(&str) -> Option<String>) -> Result<Self, MapError> {
        let required = |name: &str| {
            number(&get, name)?.ok_or_else(|| {
                let advice = "submit a job array, as in `sbatch --array=0-7`, or give --shard i/n";
                MapError::Request(format!("--shard slurm needs {name}, which is not set: {advice}"))
            })
        };
        let task = required("SLURM_ARRAY_TASK_ID")?;
        let (least, most) = (required("SLURM_ARRAY_TASK_MIN")?, required("SLURM_ARRAY_TASK_MAX")?);
        let span = most.saturating_sub(least);
        let step = number(&get, "SLURM_ARRAY_TASK_STEP")?.filter(|&step| step > 0);
        let count = number(&get, "SLURM_ARRAY_TASK_COUNT")?;
        // Without a step, the one that the count asks for.
        let step = step.or(count.and_then(|count| span.checked_div(count.saturating_sub(1)))).unwrap_or(1).max(1);
        let tasks = (span / step).checked_add(1).filter(|&tasks| count.is_none_or(|count| count == tasks));
        let even = (least..=most).contains(&task) && span.is_multiple_of(step) && (task - least).is_multiple_of(step);
        match tasks.filter(|_| even) {
            Some(count) => Ok(Self { index: (task - least) / step, count }),
            None => {
                let count = count.map_or_else(String::new, |count| format!("{count} of them, "));
                refuse!(
                    "the job array has gaps (task {task}; {count}from {least} to {most} in steps of {step}): number its tasks evenly, as in `sbatch --array=0-7` or `1-15:2`, or give --shard i/n"
                )
            }
        }
    }

    /// Threads a Slurm task is given, if it says so.
    ///
    /// # Errors
    /// [`MapError::Request`] for a number that is none.
    pub fn threads_of_slurm(get: impl Fn(&str) -> Option<String>) -> Result<Option<usize>, MapError> {
        Ok(number(&get, "SLURM_CPUS_PER_TASK")?.and_then(|threads| usize::try_from(threads).ok()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn slurm(id: u64, least: u64, most: u64, count: Option<u64>, step: Option<u64>) -> Result<Shard, MapError> {
        Shard::of_slurm(|name| match name {
            "SLURM_ARRAY_TASK_ID" => Some(id.to_string()),
            "SLURM_ARRAY_TASK_MIN" => Some(least.to_string()),
            "SLURM_ARRAY_TASK_MAX" => Some(most.to_string()),
            "SLURM_ARRAY_TASK_COUNT" => count.map(|count| count.to_string()),
            "SLURM_ARRAY_TASK_STEP" => step.map(|step| step.to_string()),
            _ => None,
        })
    }

    #[test]
    fn arrays_of_every_even_numbering_are_shards_from_0() {
        for count in [1, 2, 5] {
            for least in [0, 1, 10] {
                for step in [1, 3] {
                    for index in 0..count {
                        let (id, most) = (least + index * step, least + (count - 1) * step);
                        let expected = Shard { index, count };
                        assert_eq!(slurm(id, least, most, Some(count), Some(step)).unwrap(), expected);
                        assert_eq!(slurm(id, least, most, Some(count), None).unwrap(), expected);
                    }
                }
            }
        }
        assert_eq!(slurm(2, 1, 4, None, None).unwrap(), Shard { index: 1, count: 4 });
    }

    #[test]
    fn gaps_and_missing_numbers_are_refused() {
        for (id, least, most, count, step) in [
            (3, 1, 7, Some(3), None),
            (3, 1, 7, Some(3), Some(1)),
            (2, 1, 7, Some(4), Some(2)),
            (9, 1, 7, Some(7), Some(1)),
            (5, 7, 1, Some(7), Some(1)),
            (7, 1, 7, Some(0), Some(1)),
            // More tasks than can be counted.
            (5, 0, u64::MAX, None, None),
            (5, 0, u64::MAX, Some(u64::MAX), Some(1)),
        ] {
            let error = slurm(id, least, most, count, step).unwrap_err();
            assert!(matches!(error, MapError::Request(_)) && error.to_string().contains("gaps"), "{error}");
        }
        let error = Shard::of_slurm(|_| None).unwrap_err();
        assert!(error.to_string().contains("--shard slurm needs SLURM_ARRAY_TASK_ID, which is not set"));
        let error = Shard::of_slurm(|_| Some("x".to_owned())).unwrap_err();
        assert!(error.to_string().contains("SLURM_ARRAY_TASK_ID = x is no whole number"));
    }

    #[test]
    fn flags() {
        assert_eq!("2/7".parse(), Ok(ShardFlag::Of(Shard { index: 2, count: 7 })));
        assert_eq!("slurm".parse(), Ok(ShardFlag::Slurm));
        for (text, message) in [
            ("7/7", "give 0 to 6; shards count from 0"),
            ("0/0", "give at least one shard"),
            ("1", "give i/n"),
            ("-1/2", "give i/n"),
            ("", "give i/n"),
        ] {
            assert!(text.parse::<ShardFlag>().unwrap_err().contains(message), "{text}");
        }
    }
}
