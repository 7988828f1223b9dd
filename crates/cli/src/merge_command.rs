//! `mapgen merge`: a folder of chunks → table, manifest, pictures.

use rayon::iter::{IntoParallelIterator, ParallelIterator};
use vibrochain_lattice::Short;

use crate::args::MergeArgs;
use crate::console::{Console, nothing_else};
use crate::error::CliError;
use crate::pictures::Pictures;
use crate::report::report;
use crate::sweep_command::{manifest_path, manifest_text, place, quoted, tell};
use crate::threads::threads;
use vibrochain_maps::files::Output;
use vibrochain_maps::files::{distinct, name_within};
use vibrochain_maps::sweep::{Assembly, Fault, Plan, Store, Unassembled};
use vibrochain_maps::table::Form;

/// The most runs of missing chunks that are named.
const MOST_NAMED: usize = 12;

/// Runs the subcommand.
///
/// # Errors
/// [`CliError`].
pub fn run(args: &MergeArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let plan = Store::plan(&args.folder)?;
    let pool = threads(console.threads)?;
    let manifest_file = place(&args.out)?.map(|_| manifest_path(&args.out));
    let wanted = &args.pictures;
    let outputs = [
        ("--out", Some(args.out.as_path())),
        ("the manifest of --out", manifest_file.as_deref()),
        ("--png", wanted.png.as_deref()),
        ("--svg", wanted.svg.as_deref()),
        ("--pdf", wanted.pdf.as_deref()),
    ];
    nothing_else(args.json, distinct(&[("the folder of chunks", Some(&args.folder))], &outputs)?)?;
    for (flag, path) in outputs {
        let Some(path) = path else { continue };
        if name_within(&args.folder, path).is_some_and(|name| Store::owns(&name)) {
            let message = format!("{flag} and a chunk are the same file, {}: name another", path.display());
            return Err(CliError::Request(message));
        }
    }
    Form::of(&args.out)?;
    // All fail early where they cannot be written.
    manifest_file.as_deref().map(Output::create).transpose()?;
    let mut pictures = Pictures::plan(wanted, &plan.scene)?;
    let mut assembly = Assembly::begin(&plan, &args.out, &mut pictures)?;
    let stop = (console.interrupt)()?;

    let check = |chunk| Store::check(&args.folder, &plan, chunk, &stop).err().map(|fault| (chunk, fault));
    let faults: Vec<(u64, Fault)> = pool.install(|| (0..plan.chunks()).into_par_iter().filter_map(check).collect());
    if faults.iter().any(|(_, fault)| matches!(fault, Fault::Stopped)) {
        return Err(CliError::Interrupted);
    }
    if !faults.is_empty() {
        return Err(incomplete(args, &plan, &faults));
    }
    let summary = match assembly.chunks(&plan, &args.folder, &stop) {
        Ok(summary) => summary,
        Err(Unassembled::Stopped) => return Err(CliError::Interrupted),
        Err(Unassembled::Table(error)) => return Err(error.into()),
        Err(Unassembled::Chunk(chunk, fault)) => return Err(incomplete(args, &plan, &[(chunk, fault)])),
    };
    let table = assembly.into_table();
    let told = pictures.find_borders(&pool, &stop, console.progress)?;
    table.commit()?;
    let manifest = manifest_text(&plan, &summary, None);
    if let Some(file) = &manifest_file {
        Output::create(file)?.finish_with(manifest.as_bytes())?;
    }
    pictures.finish()?;
    tell(args.json, &manifest, || report(&plan.scene, &summary, None) + &told, console)
}

/// Names the chunks that are not there or not sound, and the command that makes them.
fn incomplete(args: &MergeArgs, plan: &Plan, faults: &[(u64, Fault)]) -> CliError {
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
    let threshold = plan.threshold.map_or_else(String::new, |threshold| format!(" --threshold {}", Short(threshold)));
    let (scene, folder) = (quoted(&plan.scene_file), quoted(&args.folder));
    lines.push(format!("make them with: mapgen sweep {scene} --out {folder}{threshold} --shard 0/1 --resume"));
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
