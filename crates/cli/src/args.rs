//! The command line.

mod events;
mod model;
mod quantity;
mod runs;
mod setup;
mod sweep;

use std::ffi::OsString;
use std::path::PathBuf;

use clap::{ArgGroup, Args, Parser, Subcommand};

use vibrochain_maps::numbers::{real, whole};
use vibrochain_plot::Format;

use crate::common::tips;

use crate::common::pictures::page_args::{PICTURES, PageArgs};
use quantity::{Meanings, by_name};

pub use events::{AlongArgs, BranchArgs, CurveArgs, CurvesArgs, Free, LocateArgs};
pub use model::{ModelArgs, ParameterArgs, SiteFamily, StructureArgs, WhichArgs};
pub use quantity::QuantityName;
pub(crate) use quantity::{OF_BRANCHES, OF_MAPS, SHOWN, of_orbits};
pub use runs::{Direction, FateArgs, SectionName, SimulateArgs};
pub use setup::{CompletionsArgs, InitArgs, ManArgs, SchemaArgs};
pub use sweep::{DrawArgs, MergeArgs, PictureArgs, SweepArgs};

/// Existence and stability of breathers in vibro-impact chains.
#[derive(Debug, Parser)]
#[command(
    name = "mapgen",
    version,
    about,
    after_help = "`mapgen init plane.toml` writes a first scene, `mapgen sweep plane.toml --out map.csv --plot map.png` computes it.\n\
                  Everything is dimensionless: unit masses, barriers at asymmetry ± 1; a structure has its own units.\n\
                  Files appear whole or not at all; `-` is standard output (words then go to standard error), pipes and \
                  devices are written to directly, links are followed.\n\
                  Exit codes: 0 done, 1 the computation could not be completed, 2 the request is wrong, 3 the point has no \
                  answer (no breather to start from, a resonance, a grazing impact), 130 interrupted by Ctrl-C or SIGTERM."
)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
    /// What all commands understand.
    #[command(flatten)]
    pub common: CommonArgs,
}

/// What all commands understand.
#[derive(Debug, Args)]
pub struct CommonArgs {
    /// Say nothing but what is wrong: no bar, no summary, no answer in words. Files, and JSON that is asked for, are written.
    #[arg(long, short, global = true, display_order = 900)]
    pub quiet: bool,
    /// Tell on standard error how long it took, on how many threads, and (simulate) what the simulation did; after --version: what this build can do, and this machine.
    #[arg(long, short, global = true, display_order = 901)]
    pub verbose: bool,
    /// Threads for what computes many points [default: all cores, or what RAYON_NUM_THREADS says; with --shard slurm,
    /// SLURM_CPUS_PER_TASK].
    #[arg(long, global = true, value_name = "N", display_order = 902, value_parser = crate::common::threads::asked, allow_negative_numbers = true)]
    pub threads: Option<usize>,
}

/// Reads a command line, its own name first. A number may begin with a point, as in `-.5`, which clap takes for a flag.
///
/// # Errors
/// What clap finds wrong with it; or it asks for help or the version.
pub fn read<P: Parser>(arguments: impl IntoIterator<Item = OsString>) -> Result<P, clap::Error> {
    let whole = |argument: OsString| match argument.to_str().and_then(|text| text.strip_prefix("-.")) {
        Some(rest) if rest.starts_with(|c: char| c.is_ascii_digit()) => format!("-0.{rest}").into(),
        _ => argument,
    };
    let arguments: Vec<OsString> = arguments.into_iter().map(whole).collect();
    P::try_parse_from(&arguments).map_err(|error| tips::told(error, &P::command(), &arguments))
}

/// The subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Compute a map over one or more parameters from a scene file.
    Sweep(SweepArgs),
    /// Make one table of the chunks that `sweep --shard` has left in a folder.
    Merge(MergeArgs),
    /// Draw a table again, in other colours or at another size, without computing it.
    Draw(DrawArgs),
    /// All breathers of a family at one point, with their stability.
    Orbit(OrbitArgs),
    /// Impact words of two instants on a few sites, each of which hits as a family does, whose breathers live at one point.
    Words(WordsArgs),
    /// Where a breather bifurcates or grazes as one parameter varies, to twelve digits.
    Locate(LocateArgs),
    /// A branch of breathers as one parameter varies, through folds, with all events on it and what branches off.
    Branch(BranchArgs),
    /// The curve on which a breather bifurcates or grazes as two parameters vary, with its points of codimension two.
    Curve(CurveArgs),
    /// All borders in a scene's window, as curves, and the area of what lives between them.
    Curves(CurvesArgs),
    /// Simulate event by event, from a breather or from any state; with --animate as a moving picture.
    Simulate(SimulateArgs),
    /// What becomes of the breathers of a scene when they are perturbed: many simulated runs of each.
    Fate(FateArgs),
    /// Where each stripe of instability of a conservative map begins and ends, however thin, and how strong it is.
    Stripes(StripesArgs),
    /// Fly over a map in the browser: cells are computed as they come into sight.
    Explore(ExploreArgs),
    /// Write a scene to begin with, every key explained.
    Init(InitArgs),
    /// Print a script that completes commands and flags in a shell.
    Completions(CompletionsArgs),
    /// Write manual pages.
    Man(ManArgs),
    /// Print the JSON Schema of what is written or read; without a name, list them.
    Schema(SchemaArgs),
}

/// Arguments of `mapgen stripes`.
#[derive(Debug, Args)]
#[command(
    after_help = "In a stripe two modes of the lattice collide, as the breather shifts them: their frequencies sum to a harmonic of ω. \
                  Mode k lies between Ω_k and Ω_{k+1} of the bare lattice, those counted that have no node at the breather."
)]
pub struct StripesArgs {
    /// Scene file (TOML) of a conservative map with x = omega and y = gamma2.
    pub scene: PathBuf,
    /// Table of the stripes, however thin (CSV): for each row of the scene where each begins and ends, its width and its growth.
    #[arg(long, alias = "widths", value_name = "FILE")]
    pub out: Option<PathBuf>,
}

/// Arguments of `mapgen explore`.
#[derive(Debug, Args)]
#[command(
    after_help = "The address that is printed has a token in it, which every request must show; nothing listens on any other address of this \
                  machine, and the page loads nothing from elsewhere. Ctrl-C ends it."
)]
pub struct ExploreArgs {
    /// Scene file (TOML) whose window is shown first; of more than two axes the others stand at their first value [default: the scene that
    /// `mapgen init` writes].
    pub scene: Option<PathBuf>,
    /// Port of 127.0.0.1 to serve on; 0 takes a free one.
    #[arg(long, value_name = "PORT", default_value_t = 0, value_parser = whole::<u16>, allow_negative_numbers = true)]
    pub port: u16,
}

/// Arguments of `mapgen orbit`.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("start").args(["family", "word", "near", "scene"]).required(true).multiple(true))]
pub struct OrbitArgs {
    /// Which breathers.
    #[command(flatten)]
    pub which: WhichArgs,
    /// The model.
    #[command(flatten)]
    pub model: ModelArgs,
    /// Print JSON instead of text.
    #[arg(long)]
    pub json: bool,
    /// All multipliers of all solutions as CSV: real and imaginary part, modulus, argument, nearest mode.
    /// JSON lists up to 4096 of a solution.
    #[arg(long, value_name = "FILE")]
    pub multipliers: Option<PathBuf>,
    /// Picture of the orbits, .png, .svg or .pdf: profile at the impacts, impacting mass over a period.
    #[arg(long, help_heading = PICTURES, value_name = "FILE")]
    pub plot: Option<PathBuf>,
    /// How it is made.
    #[command(flatten)]
    pub page: PageArgs,
    /// Draw this solution alone, numbered as they are listed [default: the physical ones first, at most 8, and no more than a page holds].
    #[arg(long, help_heading = PICTURES, value_name = "K", value_parser = whole::<usize>, allow_negative_numbers = true)]
    pub solution: Option<usize>,
    /// Folder for pictures of each solution: profile, space and time, trace, phase portrait, multipliers, leading eigenvector, decay.
    #[arg(long, help_heading = PICTURES, value_name = "DIR")]
    pub all_plots: Option<PathBuf>,
    /// Kind of the pictures of --all-plots.
    #[arg(long, help_heading = PICTURES, value_name = "KIND", value_parser = by_name(FORMATS, Format::name), default_value_t = Format::Png, requires = "all_plots")]
    pub format: Format,
    /// What --format svg was once.
    #[arg(long, hide = true, requires = "all_plots", conflicts_with = "format")]
    pub svg: bool,
    /// Table of displacements and velocities of all masses over a period of each solution (CSV).
    #[arg(long, value_name = "FILE")]
    pub trajectory: Option<PathBuf>,
    /// Samples a period of that table.
    #[arg(long, value_name = "S", default_value_t = 64, requires = "trajectory", value_parser = whole::<u64>, allow_negative_numbers = true)]
    pub samples: u64,
    /// Excess per period, |μ| − 1, below which a breather counts as stable [default: strict].
    #[arg(long, value_name = "EXCESS", value_parser = real, allow_negative_numbers = true)]
    pub threshold: Option<f64>,
}

/// Kinds of the pictures of `--all-plots`.
const FORMATS: Meanings<Format> =
    &[(Format::Png, "Pixels"), (Format::Svg, "Vectors"), (Format::Pdf, "Vectors, as printers and journals take them")];

/// Arguments of `mapgen words`.
#[derive(Debug, Args)]
#[command(
    after_help = "Words that a rotation or reflection of the ring turns into each other are listed once, and so are those that \
                  reversal of time (without force and losses) or exchange of centred barriers do. Printed are those with physical \
                  orbits."
)]
pub struct WordsArgs {
    /// Number of sites that are hit.
    #[arg(long, value_name = "R", value_parser = whole::<usize>, allow_negative_numbers = true)]
    pub sites_used: usize,
    /// How far apart they may be.
    #[arg(long, value_name = "D", value_parser = whole::<usize>, allow_negative_numbers = true)]
    pub reach: usize,
    /// What each of the sites does, a list with a comma.
    #[arg(long, value_enum, value_delimiter = ',', default_value = "either")]
    pub families: Vec<SiteFamily>,
    /// The model.
    #[command(flatten)]
    pub model: ModelArgs,
    /// Also those whose orbits are not physical, and why.
    #[arg(long)]
    pub all: bool,
    /// Follow each from γ₂ = 0 to the coupling given, and tell up to where it is physical and what ends that.
    #[arg(long, conflicts_with_all = ["all", "out", "threshold"])]
    pub from_zero: bool,
    /// The list as a table (.csv).
    #[arg(long, alias = "csv", value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Print JSON instead of text.
    #[arg(long, conflicts_with = "from_zero")]
    pub json: bool,
    /// Excess per period, |μ| − 1, below which a breather counts as stable [default: strict].
    #[arg(long, value_name = "EXCESS", value_parser = real, allow_negative_numbers = true)]
    pub threshold: Option<f64>,
}
