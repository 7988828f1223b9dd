//! `mapgen merge`: a folder of chunks → table, manifest, pictures.

use std::path::Path;

use rayon::ThreadPool;
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use vibrochain_fate::Fates;
use vibrochain_lattice::{Short, Stop};

use crate::args::{MergeArgs, QuantityName};
use crate::common::chunked_run::quoted;
use crate::common::console::{Console, destinations, interruptible};
use crate::common::error::CliError;
use crate::common::pictures::files::{PictureFiles, of_no_map};
use crate::common::swept_scene::SweptScene;
use crate::common::table_manifest::{Manifest, beside};
use crate::common::threads::threads;
use crate::fate::{self, Seen};
use crate::sweep::report::report;
use crate::sweep::{manifest_text, tell};
use vibrochain_maps::files::Output;
use vibrochain_maps::files::name_within;
use vibrochain_maps::grid::Grid;
use vibrochain_maps::scene::Scene;
use vibrochain_maps::structure::StructureScene;
use vibrochain_maps::summary::Summary;
use vibrochain_maps::sweep::{Assembly, Cells, Content, Fault, Plan, Store, Unassembled, Watcher};
use vibrochain_maps::table::{Form, TableFile};

/// The most runs of missing chunks that are named.
const MOST_NAMED: usize = 12;

/// Runs the subcommand.
///
/// # Errors
/// [`CliError`].
pub fn run(args: &MergeArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    if Store::is_of::<StructureScene>(&args.folder)? {
        merged::<StructureScene>(args, console)
    } else {
        merged::<Scene>(args, console)
    }
}

fn merged<S: SweptScene>(args: &MergeArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let folder = args.folder.clone();
    let plan = interruptible(move || Store::plan::<S>(&folder))??;
    let pool = threads(console.threads)?;
    match &plan.ensemble {
        None => sweep(args, &plan, &pool, console),
        Some(settings) => {
            let fates = Fates::from_settings(settings).map_err(|wrong| {
                let place = args.folder.display();
                CliError::Request(format!(
                    "the plan of {place} cannot be used: {wrong}; compute it into another folder"
                ))
            })?;
            ensemble(args, &plan, &fates, &pool, console)
        }
    }
}

/// The table, manifest and pictures of a sweep.
fn sweep<S: SweptScene>(
    args: &MergeArgs,
    plan: &Plan<S>,
    pool: &ThreadPool,
    console: &mut Console<'_>,
) -> Result<(), CliError> {
    let manifest_file = beside(Some(&args.out))?;
    apart(args, manifest_file.as_deref())?;
    Form::of(&args.out)?;
    // All fail early where they cannot be written.
    manifest_file.as_deref().map(Output::create).transpose()?;
    let mut pictures = plan.scene.pictures(&args.pictures, args.show)?;
    let Merged { table, summary, stop } = assembled(&Cells, args, plan, pool, &mut pictures, console)?;
    let told = pictures.find_borders(pool, &stop, console.progress)?;
    table.commit()?;
    let manifest = manifest_text(plan, &summary, None);
    if let Some(file) = &manifest_file {
        Output::create(file)?.finish_with(manifest.as_bytes())?;
    }
    pictures.finish()?;
    tell(args.json, &manifest, || report(&plan.scene, &summary, None) + &told, console)
}

/// The table and pictures of an ensemble.
fn ensemble<S: SweptScene>(
    args: &MergeArgs,
    plan: &Plan<S>,
    fates: &Fates,
    pool: &ThreadPool,
    console: &mut Console<'_>,
) -> Result<(), CliError> {
    let manifest = beside(Some(&args.out))?;
    let taken = apart(args, manifest.as_deref())?;
    of_no_map(
        &args.pictures,
        args.show != QuantityName::default(),
        &format!("{} holds an ensemble", args.folder.display()),
    )?;
    let manifest = Manifest::create(manifest.as_deref())?;
    let mut seen = Seen::new(&plan.scene, &fates.ensemble, PictureFiles::asked(&args.pictures)?)?;
    assembled(fates, args, plan, pool, &mut seen, console)?.table.commit()?;
    console.answer(&seen.answer(args.json)?, args.json, taken)?;
    seen.finish(manifest)
}

/// Sees to it that no file is another, or a chunk. Tells whether one is standard output.
fn apart(args: &MergeArgs, manifest_file: Option<&Path>) -> Result<bool, CliError> {
    let outputs =
        args.pictures.beside(&[("--out", Some(args.out.as_path())), ("the manifest of --out", manifest_file)]);
    let taken = destinations(args.json, &[("the folder of chunks", Some(&args.folder))], &outputs)?;
    for (flag, path) in outputs {
        let Some(path) = path else { continue };
        if name_within(&args.folder, path).is_some_and(|name| Store::owns(&name)) {
            refuse!("{flag} and a chunk are the same file, {}: name another", path.display());
        }
    }
    Ok(taken)
}

/// The table of all chunks.
struct Merged {
    table: TableFile,
    /// What they add up to.
    summary: Summary,
    /// Raised to end what is still to be done.
    stop: Stop,
}

/// Makes the table of all chunks.
fn assembled<S: Grid, C: Content<S>>(
    content: &C,
    args: &MergeArgs,
    plan: &Plan<S>,
    pool: &ThreadPool,
    watcher: &mut dyn Watcher<C::Item>,
    console: &Console<'_>,
) -> Result<Merged, CliError> {
    let stop = (console.interrupt)()?;
    let mut assembly = Assembly::begin(content, plan, &args.out, pool.current_num_threads(), watcher)?;
    let check = |chunk| Store::check(content, &args.folder, plan, chunk, &stop).err().map(|fault| (chunk, fault));
    let faults: Vec<(u64, Fault)> = pool.install(|| (0..plan.chunks()).into_par_iter().filter_map(check).collect());
    ensure!(!faults.iter().any(|(_, fault)| matches!(fault, Fault::Stopped)), CliError::Interrupted);
    ensure!(faults.is_empty(), incomplete(args, plan, &faults));
    match assembly.chunks(&args.folder, &stop) {
        Ok(summary) => Ok(Merged { table: assembly.into_table(), summary, stop }),
        Err(Unassembled::Stopped) => Err(CliError::Interrupted),
        Err(Unassembled::Table(error)) => Err(error.into()),
        Err(Unassembled::Chunk(chunk, fault)) => Err(incomplete(args, plan, &[(chunk, fault)])),
    }
}

/// Names the chunks that are not there or not sound, and the command that makes them.
fn incomplete<S: Grid>(args: &MergeArgs, plan: &Plan<S>, faults: &[(u64, Fault)]) -> CliError {
    let missing: Vec<u64> =
        faults.iter().filter(|(_, fault)| matches!(fault, Fault::Missing)).map(|(chunk, _)| *chunk).collect();
    let mut lines = Vec::new();
    let (all, place) = (plan.chunks(), args.folder.display());
    if !missing.is_empty() {
        lines.push(format!("{} of {all} chunks are missing in {place}: {}", missing.len(), runs(&missing)));
    }
    let bad: Vec<_> = faults.iter().filter(|(_, fault)| !matches!(fault, Fault::Missing)).collect();
    if !bad.is_empty() {
        lines.push(format!("{} of {all} chunks in {place} are not sound:", bad.len()));
        let line =
            |(chunk, fault): &&(u64, Fault)| format!("  {}: {fault}", Store::path(&args.folder, *chunk).display());
        lines.extend(bad.iter().take(MOST_NAMED).map(line));
        if bad.len() > MOST_NAMED {
            lines.push(format!("  and {} more", bad.len() - MOST_NAMED));
        }
    }
    let command = match &plan.ensemble {
        Some(settings) => fate::command(&plan.scene_file, &args.folder, settings),
        None => {
            let (scene, folder) = (quoted(&plan.scene_file), quoted(&args.folder));
            let mut words = vec![format!("mapgen sweep {scene} --out {folder}")];
            words.extend(plan.threshold.map(|threshold| format!("--threshold {}", Short(threshold))));
            words
        }
    };
    lines.push(format!("make them with: {} --shard 0/1 --resume", command.join(" ")));
    lines.push("(or with the shards of before, each with --resume: what is finished is not computed again)".to_owned());
    CliError::Computation(lines.join("\n"))
}

/// "0, 3–5, 9": neighbours together.
fn runs(numbers: &[u64]) -> String {
    let mut runs: Vec<(u64, u64)> = Vec::new();
    for &number in numbers {
        match runs.last_mut() {
            Some((_, last)) if *last + 1 == number => *last = number,
            _ => runs.push((number, number)),
        }
    }
    let run = |&(first, last): &(u64, u64)| if first == last { first.to_string() } else { format!("{first}–{last}") };
    let mut text = runs.iter().take(MOST_NAMED).map(run).collect::<Vec<_>>().join(", ");
    if runs.len() > MOST_NAMED {
        text += ", …";
    }
    text
}

#[cfg(test)]
mod tests {
    use super::runs;

    #[test]
    fn neighbours_are_named_together() {
        assert_eq!(runs(&[0, 2, 3, 4, 9]), "0, 2–4, 9");
        assert!(runs(&(0..100).map(|i| 2 * i).collect::<Vec<_>>()).ends_with("20, 22, …"));
    }
}
