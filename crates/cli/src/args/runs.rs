//! Simulated runs: `simulate` and `fate`.

use std::path::PathBuf;

use clap::{ArgGroup, Args, ValueEnum};
use vibrochain_fate::From;
use vibrochain_maps::numbers::{real, whole};
use vibrochain_maps::sweep::ShardFlag;

use super::model::{ModelArgs, WhichArgs};
use super::quantity::{Meanings, by_name};
use crate::common::pictures::page_args::{PICTURES, PageArgs};

/// Direction of a perturbation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum Direction {
    /// Random, by --seed.
    #[default]
    Random,
    /// Along the eigenvector of the leading multiplier.
    Unstable,
}

/// Kinds of Poincaré sections.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum SectionName {
    /// A row a period of the force, always at one phase of it: displacements and velocities.
    #[default]
    Strobe,
    /// A row an impact: when, at which phase of the force, how fast.
    Impact,
}

/// Breathers of a cell from which runs start.
const STARTS: Meanings<From> = &[
    (From::Class, "The one that gives the cell its class: a stable one, if there is one"),
    (From::Every, "Every physical one"),
    (From::Unstable, "Every unstable one"),
    (From::Rest, "None: a structure at rest under its static load, to see what it settles on"),
];

/// Arguments of `mapgen fate`.
#[derive(Debug, Args)]
#[command(
    after_help = "A run ends as `breather` (its impacts are the breather's, within the tolerance), `periodic` (they repeat, as another word), \
                  `quiet` (none any more), `chaos` (the largest Lyapunov exponent is clearly positive), `quasi-periodic` (they do not repeat, and \
                  neighbours part no faster than by a power of time), `unclassified` (none of these), or `incomplete`. All numbers follow from the seed, whatever \
                  the number of threads. Work is kept in chunks in a folder FILE.parts until the table is whole: after Ctrl-C, SIGTERM or a kill, \
                  --resume goes on with it."
)]
pub struct FateArgs {
    /// Scene file (TOML), see scenes/.
    pub scene: PathBuf,
    /// Table to write (.csv; .csv.gz or .csv.zst, compressed; .parquet, by columns), a row a breather. `-` is standard
    /// output, which keeps no chunks. With --shard: folder of chunks.
    #[arg(long, alias = "csv", value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Go on with the chunks that an interrupted run has left, or start afresh where there are none.
    #[arg(long, requires = "out")]
    pub resume: bool,
    /// Compute one share of the chunks: shard i of n, from 0, or `slurm` for the share of a job array's task. Then `mapgen
    /// merge` makes the table.
    #[arg(long, value_name = "i/n", requires = "out", conflicts_with_all = ["plot", "json"], allow_hyphen_values = true)]
    pub shard: Option<ShardFlag>,
    /// Picture, .png, .svg or .pdf: over two axes the most frequent end of each cell, over one the shares of all ends, or the diagram.
    #[arg(long, help_heading = PICTURES, value_name = "FILE")]
    pub plot: Option<PathBuf>,
    /// How it is made.
    #[command(flatten)]
    pub page: PageArgs,
    /// From which breathers of a cell runs start.
    #[arg(long, value_parser = by_name(STARTS, From::name), default_value_t)]
    pub breathers: From,
    /// Runs from each breather.
    #[arg(long, value_name = "K", default_value_t = 16, value_parser = whole::<u64>, allow_negative_numbers = true)]
    pub starts: u64,
    /// Size of the perturbations: largest change of a displacement, or of a velocity over ω.
    #[arg(long, value_name = "SIZE", default_value_t = 1e-3, value_parser = real, allow_negative_numbers = true)]
    pub perturb: f64,
    /// Seed of all perturbations.
    #[arg(long, default_value_t = 1, value_parser = whole::<u64>, allow_negative_numbers = true)]
    pub seed: u64,
    /// Periods of the force of each run.
    #[arg(long, value_name = "P", default_value_t = 2000, value_parser = whole::<u64>, allow_negative_numbers = true)]
    pub periods: u64,
    /// Share of a run that is left out before its end is looked at.
    #[arg(long, value_name = "SHARE", default_value_t = 0.5, value_parser = real, allow_negative_numbers = true)]
    pub transient: f64,
    /// By how much impacts may differ and still repeat: times in periods, velocities in the fastest.
    #[arg(long, value_name = "PART", default_value_t = 0.02, value_parser = real, allow_negative_numbers = true)]
    pub tolerance: f64,
    /// By how much impacts must differ from the breather's before a run has left it, likewise.
    #[arg(long, value_name = "PART", default_value_t = 0.1, value_parser = real, allow_negative_numbers = true)]
    pub leave: f64,
    /// Let contacts of a structure that share coordinates and hit at one instant do so in the order of their numbers, again until none moves into its
    /// barrier; otherwise such a run is incomplete. A scene says it by `in_sequence = true` in `[structure]`.
    #[arg(long)]
    pub in_sequence: bool,
    /// Instead, a bifurcation diagram by simulation over a scene with one axis (CSV): the last points of a stroboscopic section of one run a cell.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["out", "starts", "breathers", "json", "resume", "shard"])]
    pub diagram: Option<PathBuf>,
    /// Points that the diagram keeps of each run [default: 100].
    #[arg(long, value_name = "K", value_parser = whole::<u64>, allow_negative_numbers = true)]
    pub points: Option<u64>,
    /// Start each run of the diagram from the end of the one before.
    #[arg(long)]
    pub carry: bool,
    /// Print JSON instead of text.
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `mapgen simulate`.
#[derive(Debug, Clone, Args)]
#[command(group = ArgGroup::new("start").args(["family", "word", "near", "state", "scene"]).required(true).multiple(true))]
pub struct SimulateArgs {
    /// Start on a breather, in the flight before its impact at t = 0.
    #[command(flatten)]
    pub which: WhichArgs,
    /// Start from a state, JSON {"displacement":[…],"velocity":[…],"psi":0} or what --json has printed, at t = 0: a file, `-` for standard
    /// input, or the JSON itself in quotes. A mass at rest on a barrier leaves it if
    /// springs and force pull it inward; if not, it rests there (event stick at t = 0) until they do.
    #[arg(long, value_name = "FILE", conflicts_with = "which")]
    pub state: Option<PathBuf>,
    /// Phase ψ of the force at t = 0, as a time; with --state [default: that of the file, or 0].
    #[arg(long, value_name = "ψ", requires = "state", value_parser = real, allow_negative_numbers = true)]
    pub psi: Option<f64>,
    /// Which of several solutions, numbered as `mapgen orbit` lists them [default: the first physical one].
    #[arg(long, value_name = "K", conflicts_with = "state", value_parser = whole::<usize>, allow_negative_numbers = true)]
    pub solution: Option<usize>,
    /// The model.
    #[command(flatten)]
    pub model: ModelArgs,
    /// Perturb the start: largest change of a displacement, or of a velocity over ω.
    #[arg(long, value_name = "SIZE", conflicts_with = "state", value_parser = real, allow_negative_numbers = true)]
    pub perturb: Option<f64>,
    /// Direction of the perturbation.
    #[arg(long, value_enum, default_value_t, requires = "perturb")]
    pub direction: Direction,
    /// Seed of a random perturbation.
    #[arg(long, default_value_t = 1, requires = "perturb", value_parser = whole::<u64>, allow_negative_numbers = true)]
    pub seed: u64,
    /// Periods of the force to simulate, whole or not.
    #[arg(long, value_name = "P", default_value_t = 20.0, value_parser = real, allow_negative_numbers = true)]
    pub periods: f64,
    /// Instead, the length of the run in units of time. Where nothing has a period, a structure without load and omega, it is needed, and
    /// --samples are of an eighth of the run.
    #[arg(long, value_name = "T", conflicts_with = "periods", value_parser = real, allow_negative_numbers = true)]
    pub time: Option<f64>,
    /// Stop after this many impacts.
    #[arg(long, value_name = "K", value_parser = whole::<u64>, allow_negative_numbers = true)]
    pub max_impacts: Option<u64>,
    /// Let contacts of a structure that share coordinates and hit at one instant do so in the order of their numbers, again until none moves into its
    /// barrier; otherwise the run ends there. A scene says it by `in_sequence = true` in `[structure]`.
    #[arg(long)]
    pub in_sequence: bool,
    /// Table of all events (CSV): time, site, barrier, velocity_before, velocity_after, kind (impact, stick, release).
    #[arg(long, value_name = "FILE")]
    pub impacts: Option<PathBuf>,
    /// Table of displacements and velocities of all masses (CSV).
    #[arg(long, value_name = "FILE")]
    pub trajectory: Option<PathBuf>,
    /// Samples a period of tables and pictures.
    #[arg(long, value_name = "S", default_value_t = 64, value_parser = whole::<u64>, allow_negative_numbers = true)]
    pub samples: u64,
    /// Table of a Poincaré section (CSV), as --section-at says.
    #[arg(long, value_name = "FILE")]
    pub section: Option<PathBuf>,
    /// Where the section is: once a period of the force, or at every impact.
    #[arg(long, value_enum, default_value_t, requires = "section")]
    pub section_at: SectionName,
    /// Masses that the section looks at, a list with commas [default: those that the breather hits, or 0].
    #[arg(long, value_name = "SITES", value_delimiter = ',', requires = "section", value_parser = whole::<usize>)]
    pub section_sites: Vec<usize>,
    /// Phase of the force at which a stroboscopic section is taken, in periods: 0 where the force is greatest.
    #[arg(long, value_name = "PART", default_value_t = 0.0, requires = "section", value_parser = real, allow_negative_numbers = true)]
    pub section_phase: f64,
    /// Periods at the beginning that the section leaves out.
    #[arg(long, value_name = "P", default_value_t = 0.0, requires = "section", value_parser = real, allow_negative_numbers = true)]
    pub skip: f64,
    /// The run as a moving picture, .gif, .png (APNG) or .svg: the chain between its barriers, impacts glow; of a long run its last
    /// 12 periods. It goes round: give whole periods of an orbit.
    #[arg(long, help_heading = PICTURES, value_name = "FILE")]
    pub animate: Option<PathBuf>,
    /// Picture of the run, .png, .svg or .pdf: the impacting mass over the analytic orbit, all masses in space and time.
    #[arg(long, help_heading = PICTURES, value_name = "FILE")]
    pub plot: Option<PathBuf>,
    /// How it is made.
    #[command(flatten)]
    pub page: PageArgs,
    /// Print JSON instead of text, with the state at the end, which --state takes up again.
    #[arg(long)]
    pub json: bool,
}
