//! The command line.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use clap::builder::PossibleValuesParser;
use clap::{ArgGroup, Args, Parser, Subcommand, ValueEnum};
use vibrochain_breather::Word;
use vibrochain_lattice::Force;

use vibrochain_maps::numbers::{real, whole};
use vibrochain_maps::point::Parameter;
use vibrochain_maps::sweep::ShardFlag;

use crate::page_args::PageArgs;

/// Existence and stability of breathers in vibro-impact chains.
#[derive(Debug, Parser)]
#[command(
    name = "mapgen",
    version,
    about,
    after_help = "Everything is dimensionless: unit masses, barriers at asymmetry ± 1.\n\
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
    /// No progress bar and no summary.
    #[arg(long, short, global = true, display_order = 900)]
    pub quiet: bool,
    /// Tell on standard error how long it took, on how many threads; after --version: what this build can do, and this machine.
    #[arg(long, short, global = true, display_order = 901)]
    pub verbose: bool,
    /// Threads for what computes many points [default: all cores, or what RAYON_NUM_THREADS says; with --shard slurm,
    /// SLURM_CPUS_PER_TASK].
    #[arg(long, global = true, value_name = "N", display_order = 902, value_parser = whole::<usize>, allow_negative_numbers = true)]
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
    P::try_parse_from(arguments.into_iter().map(whole))
}

/// The subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Compute a map over one or more parameters from a scene file.
    Sweep(SweepArgs),
    /// Make one table of the chunks that `sweep --shard` has left in a folder.
    Merge(MergeArgs),
    /// Draw a table of `mapgen sweep` once more, without computing it.
    Draw(DrawArgs),
    /// All breathers of a family at one point, with their stability.
    Orbit(OrbitArgs),
    /// All impact words of a few sites whose breathers live at one point.
    Words(WordsArgs),
    /// Where a breather bifurcates or grazes as one parameter varies, to twelve digits.
    Locate(LocateArgs),
    /// A branch of breathers as one parameter varies, through folds, with all events on it and what branches off.
    Branch(BranchArgs),
    /// The curve on which a breather bifurcates or grazes as two parameters vary, with its points of codimension two.
    Curve(CurveArgs),
    /// All borders in a scene's window, as curves, and the area of what lives between them.
    Curves(CurvesArgs),
    /// Simulate event by event, from a breather or from any state.
    Simulate(SimulateArgs),
    /// What becomes of the breathers of a scene when they are perturbed: many simulated runs of each.
    Fate(FateArgs),
    /// Draw where two modes collide over a conservative map, and print how much of the instability that explains.
    Stripes(StripesArgs),
    /// Look at maps in a browser: a page served on this machine alone, computed as one flies over it (feature `explore`).
    Explore(ExploreArgs),
    /// Write a scene to begin with, every key explained.
    Init(InitArgs),
    /// Print a script that completes commands and flags in a shell.
    Completions(CompletionsArgs),
    /// Write manual pages.
    Man(ManArgs),
    /// Print the JSON Schema of what is written or read; without a name, list them.
    Schema(SchemaArgs),
    /// Commands that have become studies.
    #[command(hide = true, aliases = STUDIES)]
    Study(StudyArgs),
}

/// Arguments of `mapgen init`.
#[derive(Debug, Args)]
pub struct InitArgs {
    /// Scene file to write (.toml), or `-`.
    pub file: PathBuf,
}

/// Arguments of `mapgen completions`.
#[derive(Debug, Args)]
#[command(after_help = "For bash: mapgen completions bash > ~/.local/share/bash-completion/completions/mapgen")]
pub struct CompletionsArgs {
    /// The shell.
    #[arg(value_enum)]
    pub shell: clap_complete::Shell,
}

/// Arguments of `mapgen man`.
#[derive(Debug, Args)]
#[command(
    after_help = "man -l DIR/mapgen-sweep.1 reads one; where `man mapgen-sweep` looks for them: ~/.local/share/man/man1"
)]
pub struct ManArgs {
    /// Folder for the pages, one for each command.
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
}

/// What is computed by the program `studies`.
pub const STUDIES: [&str; 4] = ["validate", "figures", "errata", "accuracy"];

/// Arguments of `mapgen schema`.
#[derive(Debug, Args)]
pub struct SchemaArgs {
    /// Of what.
    #[arg(value_parser = PossibleValuesParser::new(crate::schemas::names()))]
    pub name: Option<String>,
}

/// What was asked of a study.
#[derive(Debug, Args)]
#[command(disable_help_flag = true)]
pub struct StudyArgs {
    /// Its arguments.
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, num_args = 0..)]
    pub arguments: Vec<OsString>,
}

/// Colours of a map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum PaletteName {
    /// Readable in grey and by colour-blind eyes.
    #[default]
    Colour,
    /// The paper's greys.
    Paper,
}

/// Arguments of `mapgen sweep`.
#[derive(Debug, Args)]
#[command(
    after_help = "A sweep keeps the chunks it has finished in FILE.parts until the table is whole. Interrupted by Ctrl-C or SIGTERM \
                  it says how to go on and ends with exit code 130; killed, it goes on from there as well, with --resume."
)]
pub struct SweepArgs {
    /// Scene file (TOML), see scenes/.
    pub scene: PathBuf,
    /// Table to write (.csv; .csv.gz or .csv.zst, compressed; .parquet, by columns); a manifest is written beside it. `-` is
    /// standard output, which has no manifest and keeps no chunks. With --shard: folder of chunks.
    #[arg(long, value_name = "FILE", required_unless_present = "dry_run")]
    pub out: Option<PathBuf>,
    /// Go on with the chunks that an interrupted run has left, or start afresh where there are none.
    #[arg(long)]
    pub resume: bool,
    /// Compute one share of the chunks: shard i of n, from 0, or `slurm` for the share of a job array's task. Then `mapgen
    /// merge` makes the table.
    #[arg(long, value_name = "i/n", conflicts_with_all = ["png", "svg", "pdf"], allow_hyphen_values = true)]
    pub shard: Option<ShardFlag>,
    /// Compute a few cells only, and tell how many there are, how long they will take and how much they will fill.
    #[arg(long)]
    pub dry_run: bool,
    /// Print the manifest, too, instead of a summary.
    #[arg(long, conflicts_with_all = ["shard", "dry_run"])]
    pub json: bool,
    /// Pictures of the table.
    #[command(flatten)]
    pub pictures: PictureArgs,
    /// Growth per period, |μ| − 1, below which a breather counts as stable [default: strict].
    #[arg(long, value_name = "GROWTH", value_parser = real, allow_negative_numbers = true)]
    pub threshold: Option<f64>,
}

/// What colours a map: its cells' class, or a number, as a column of the table has it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum ColorName {
    /// Class and mechanism.
    #[default]
    Class,
    /// Largest modulus of the multipliers; the growth beyond 1, by logarithms, where it spans decades.
    #[value(name = "spectral_radius", alias = "spectral-radius")]
    SpectralRadius,
    /// Smallest distance to a barrier.
    Margin,
    /// Strongest impulse, its modulus; needs `impulse = true` in the scene.
    Impulse,
    /// Number of physical breathers.
    Solutions,
}

/// Reads a value of an axis, as in `asymmetry=0.4`.
fn axis_value(text: &str) -> Result<(Parameter, f64), String> {
    let Some((name, value)) = text.split_once('=') else {
        return Err("not a parameter with its value: give one such as asymmetry=0.4".to_owned());
    };
    let known = || format!("`{name}` is no parameter: give one of {}", Parameter::ALL.map(Parameter::name).join(", "));
    Ok((Parameter::from_name(name).ok_or_else(known)?, real(value)?))
}

/// Pictures of a map.
#[derive(Debug, Clone, Args)]
#[command(group = ArgGroup::new("picture").args(["png", "svg", "pdf"]).multiple(true))]
pub struct PictureArgs {
    /// Picture as PNG: a map over two axes; over one, curves of |μ|, margin and (with `impulse = true`) impulse.
    #[arg(long, value_name = "FILE")]
    pub png: Option<PathBuf>,
    /// The same as SVG.
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,
    /// The same as PDF.
    #[arg(long, value_name = "FILE")]
    pub pdf: Option<PathBuf>,
    /// Draw the cells at this value of an axis; again for further axes, until one or two are left. The table stays whole.
    #[arg(long, value_name = "PARAMETER=VALUE", value_parser = axis_value, requires = "picture")]
    pub slice: Vec<(Parameter, f64)>,
    /// What colours the cells of a map.
    #[arg(long, value_enum, value_name = "COLUMN", default_value_t, requires = "picture")]
    pub color: ColorName,
    /// Draw the borders of the map over its cells, which `mapgen curves` finds; both axes must be equally spaced.
    #[arg(long, requires = "picture")]
    pub curves: bool,
    /// Colours of the pictures of maps.
    #[arg(long, value_enum, default_value_t)]
    pub palette: PaletteName,
    /// How they are made.
    #[command(flatten)]
    pub page: PageArgs,
}

/// Arguments of `mapgen merge`.
#[derive(Debug, Args)]
pub struct MergeArgs {
    /// Folder of chunks, the --out of `mapgen sweep --shard`.
    pub folder: PathBuf,
    /// Table to write (.csv; .csv.gz or .csv.zst, compressed; .parquet, by columns), the same to the byte as that of an
    /// undivided sweep; a manifest is written beside it. `-` is standard output, which has no manifest.
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
    /// Pictures of the table.
    #[command(flatten)]
    pub pictures: PictureArgs,
    /// Print the manifest, too, instead of a summary.
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `mapgen draw`.
#[derive(Debug, Args)]
pub struct DrawArgs {
    /// Table of `mapgen sweep` or `mapgen merge` (.csv).
    pub table: PathBuf,
    /// Scene of the table, or its manifest [default: the manifest beside the table].
    #[arg(long, value_name = "FILE")]
    pub scene: Option<PathBuf>,
    /// Pictures of the table.
    #[command(flatten)]
    pub pictures: PictureArgs,
}

/// Arguments of `mapgen stripes`.
#[derive(Debug, Args)]
#[command(
    after_help = "A line is where two modes of the lattice, as the breather shifts them, have frequencies that sum to a harmonic of \
                  ω. It is labelled k,l,j: mode k lies between Ω_k and Ω_{k+1} of the bare lattice, those counted that have no node at \
                  the breather. Printed is the share of unstable cells within one cell of a line, beside that of stable cells, \
                  of differences of two modes, and of sums and differences of the bare lattice's frequencies."
)]
pub struct StripesArgs {
    /// Scene file (TOML) of a conservative map with x = omega and y = gamma2.
    pub scene: PathBuf,
    /// Picture of the map and the lines, .png, .svg or .pdf.
    #[arg(long, value_name = "FILE", alias = "out")]
    pub plot: PathBuf,
    /// How it is made.
    #[command(flatten)]
    pub page: PageArgs,
    /// Table of the lines (CSV).
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Table of the stripes, however thin (CSV): for each row of the scene where each begins and ends, its width and its growth.
    #[arg(long, value_name = "FILE")]
    pub widths: Option<PathBuf>,
    /// Table of the map, as `mapgen sweep` has written it for the same scene [default: the map is computed].
    #[arg(long, value_name = "FILE")]
    pub map: Option<PathBuf>,
    /// Also draw, faintly, where a difference of two modes is a harmonic: equal signatures, no collision.
    #[arg(long)]
    pub all: bool,
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

/// Families as named on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FamilyName {
    /// One impact on each barrier a period.
    DoubleSided,
    /// One impact a period, on the nearer barrier.
    SingleSided,
    /// Two different impacts on the nearer barrier in two periods of the force.
    PeriodDoubled,
}

/// The model: its parameters as flags, or a scene's, some of them changed by flags.
#[derive(Debug, Args)]
pub struct ModelArgs {
    /// Take the model from a file: a scene, a manifest, a file with `[model]` alone, or what --json has printed, whose orbit is then the
    /// one to start near. Flags change its values; what the scene sweeps they must give.
    #[arg(long, value_name = "FILE")]
    pub scene: Option<PathBuf>,
    /// Number of masses of the ring (the paper's N + 1), or of one layer.
    #[arg(long, value_name = "M", required_unless_present = "scene", value_parser = whole::<i64>, allow_negative_numbers = true)]
    pub sites: Option<i64>,
    /// On-site stiffness γ₁.
    #[arg(long, value_name = "γ₁", required_unless_present = "scene", value_parser = real, allow_negative_numbers = true)]
    pub gamma1: Option<f64>,
    /// Coupling stiffness γ₂.
    #[arg(long, value_name = "γ₂", required_unless_present = "scene", value_parser = real, allow_negative_numbers = true)]
    pub gamma2: Option<f64>,
    /// Frequency ω of the force, and of the map.
    #[arg(long, value_name = "ω", required_unless_present = "scene", value_parser = real, allow_negative_numbers = true)]
    pub omega: Option<f64>,
    /// Centre a of the gap, 0 ≤ a < 1.
    #[arg(long, value_name = "a", required_unless_present = "scene", value_parser = real, allow_negative_numbers = true)]
    pub asymmetry: Option<f64>,
    /// Amplitude A of the force A cos ω(t+ψ) [default: no force].
    #[arg(long, value_name = "A", value_parser = real, allow_negative_numbers = true)]
    pub amplitude: Option<f64>,
    /// Force of several odd harmonics, instead of --amplitude: number:amplitude:phase of each, as in 1:0.1:0,3:0.03:1.57
    /// for 0.1 cos ω(t+ψ) + 0.03 cos(3ω(t+ψ) + 1.57).
    #[arg(long, value_name = "J:A:θ,…", conflicts_with = "amplitude", value_parser = vibrochain_maps::force::parse)]
    pub force: Option<Force>,
    /// Coefficient e of restitution, 0 < e ≤ 1 [default without force: 1].
    #[arg(long, value_name = "e", value_parser = real, allow_negative_numbers = true)]
    pub restitution: Option<f64>,
    /// What stands at the ends of the chain: each other, nothing, or walls [default: closed].
    #[arg(long, value_enum)]
    pub ends: Option<EndsName>,
    /// Number of equal chains side by side, coupled mass by mass [default: 1].
    #[arg(long, value_name = "L", value_parser = whole::<i64>, allow_negative_numbers = true)]
    pub layers: Option<i64>,
    /// Coupling stiffness γ₃ between layers.
    #[arg(long, value_name = "γ₃", value_parser = real, allow_negative_numbers = true)]
    pub gamma3: Option<f64>,
    /// Whether the last layer is the first one's neighbour, too [default: free].
    #[arg(long, value_enum)]
    pub layer_ends: Option<LayerEndsName>,
}

/// What stands at the ends of a chain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum EndsName {
    /// Each other: a ring.
    Closed,
    /// Nothing.
    Free,
    /// Walls, to which springs go as between neighbours.
    Fixed,
}

/// What stands below the first and above the last layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LayerEndsName {
    /// Each other.
    Closed,
    /// Nothing.
    Free,
}

/// Which breathers: of a family, of any impact word, or near a given one. With --scene: the one family or word of the scene, or the orbit
/// of the file, if none of them is given.
#[derive(Debug, Clone, Args)]
#[group(id = "which", multiple = false)]
pub struct WhichArgs {
    /// Family of breathers.
    #[arg(long, value_enum)]
    pub family: Option<FamilyName>,
    /// Breathers of an impact word: instants separated by commas or spaces, each one or more impacts, SITE+ on the upper or SITE- on
    /// the lower barrier, as in "0+3+,0-3-" for two masses in phase; SITE:LAYER+ where there are layers.
    #[arg(long, value_name = "WORD")]
    pub word: Option<Word>,
    /// The breather near that of a file, as `mapgen orbit --json` writes it (its first solution), or an object with `impacts`
    /// (site, barrier, time, impulse) and `psi`.
    #[arg(long, value_name = "FILE")]
    pub near: Option<PathBuf>,
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
    #[arg(long, value_name = "FILE")]
    pub plot: Option<PathBuf>,
    /// How it is made.
    #[command(flatten)]
    pub page: PageArgs,
    /// Folder for pictures of each solution: profile, space and time, trace, phase portrait, multipliers, leading eigenvector, decay.
    #[arg(long, value_name = "DIR")]
    pub all_plots: Option<PathBuf>,
    /// Write the pictures of --all-plots as SVG instead of PNG.
    #[arg(long, requires = "all_plots")]
    pub svg: bool,
    /// Table of displacements and velocities of all masses over a period of each solution (CSV).
    #[arg(long, value_name = "FILE")]
    pub trajectory: Option<PathBuf>,
    /// Samples a period of that table.
    #[arg(long, value_name = "S", default_value_t = 64, requires = "trajectory", value_parser = whole::<u64>, allow_negative_numbers = true)]
    pub samples: u64,
    /// Growth per period, |μ| − 1, below which a breather counts as stable [default: strict].
    #[arg(long, value_name = "GROWTH", value_parser = real, allow_negative_numbers = true)]
    pub threshold: Option<f64>,
}

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
    /// What each of the sites does: double-sided, single-sided, or either (a list with a comma).
    #[arg(long, value_enum, value_delimiter = ',', default_value = "double-sided")]
    pub families: Vec<SiteFamily>,
    /// The model.
    #[command(flatten)]
    pub model: ModelArgs,
    /// Also those whose orbits are not physical, and why.
    #[arg(long)]
    pub all: bool,
    /// Follow each from γ₂ = 0 to the coupling given, and tell up to where it is physical and what ends that.
    #[arg(long, conflicts_with_all = ["all", "csv", "threshold"])]
    pub from_zero: bool,
    /// The list as a table (CSV).
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Print JSON instead of text.
    #[arg(long, conflicts_with = "from_zero")]
    pub json: bool,
    /// Growth per period, |μ| − 1, below which a breather counts as stable [default: strict].
    #[arg(long, value_name = "GROWTH", value_parser = real, allow_negative_numbers = true)]
    pub threshold: Option<f64>,
}

/// What a site of a word does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SiteFamily {
    /// One impact on each barrier a period.
    DoubleSided,
    /// One impact a period, on the nearer barrier.
    SingleSided,
}

/// Events of `mapgen locate`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum EventName {
    /// A mass touches a barrier from inside, or an impact loses its velocity.
    Grazing,
    /// A multiplier meets +1 and the branch goes on; without force and losses also where the energy is extreme.
    Pitchfork,
    /// A multiplier meets −1.
    PeriodDoubling,
    /// A complex pair of multipliers crosses the circle; without loss, two pairs collide on it.
    NeimarkSacker,
    /// The branch turns back.
    Fold,
}

/// Parameters that can be varied.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FreeName {
    /// γ₁
    Gamma1,
    /// γ₂
    Gamma2,
    /// ω
    Omega,
    /// a
    Asymmetry,
    /// A
    Amplitude,
    /// e
    Restitution,
    /// γ₃
    Gamma3,
}

impl From<FreeName> for Parameter {
    fn from(name: FreeName) -> Self {
        match name {
            FreeName::Gamma1 => Self::Gamma1,
            FreeName::Gamma2 => Self::Gamma2,
            FreeName::Omega => Self::Omega,
            FreeName::Asymmetry => Self::Asymmetry,
            FreeName::Amplitude => Self::Amplitude,
            FreeName::Restitution => Self::Restitution,
            FreeName::Gamma3 => Self::Gamma3,
        }
    }
}

/// Where a branch is taken up, and how far it is followed.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("start").args(["family", "word", "near", "scene"]).required(true).multiple(true))]
pub struct AlongArgs {
    /// The parameter that varies.
    #[arg(long, value_enum)]
    pub free: FreeName,
    /// Least value of the free parameter [default: half its start; asymmetry 0, restitution 0.05].
    #[arg(long, value_name = "VALUE", value_parser = real, allow_negative_numbers = true)]
    pub from: Option<f64>,
    /// Largest value of the free parameter [default: twice its start; asymmetry 0.99, restitution 1].
    #[arg(long, value_name = "VALUE", value_parser = real, allow_negative_numbers = true)]
    pub to: Option<f64>,
    /// Which breathers.
    #[command(flatten)]
    pub which: WhichArgs,
    /// Which of several solutions to start from, numbered as `mapgen orbit` lists them [default: the first physical one].
    #[arg(long, value_name = "K", value_parser = whole::<usize>, allow_negative_numbers = true)]
    pub solution: Option<usize>,
    /// The model.
    #[command(flatten)]
    pub model: ModelArgs,
}

impl AlongArgs {
    /// The files that are read, by their flags: none of them is written to.
    pub(crate) fn reads(&self) -> [(&'static str, Option<&Path>); 2] {
        [("--scene", self.model.scene.as_deref()), ("--near", self.which.near.as_deref())]
    }
}

/// Arguments of `mapgen locate`.
#[derive(Debug, Args)]
#[command(
    after_help = "The flags of the model give the start, the free parameter's included. The branch through it is followed both \
                  ways, to the ends of the range or its own; every event on it is an answer, and so is that there is none."
)]
pub struct LocateArgs {
    /// What to look for.
    #[arg(long, value_enum)]
    pub event: EventName,
    /// Where, along what, how far.
    #[command(flatten)]
    pub along: AlongArgs,
    /// The events as a table (CSV).
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Print JSON instead of text.
    #[arg(long)]
    pub json: bool,
}

/// What a bifurcation diagram shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum QuantityName {
    /// Moduli of all impulses.
    Impulse,
    /// Time φ of the second impact, in periods.
    Phi,
    /// Phase ψ of the force, in its periods.
    Psi,
    /// Smallest distance of any mass to a barrier.
    Margin,
    /// Largest modulus of the multipliers.
    SpectralRadius,
}

/// Arguments of `mapgen branch`.
#[derive(Debug, Args)]
#[command(
    after_help = "The flags of the model give the start, the free parameter's included. The branch through it is followed both \
                  ways, round its folds, to the ends of the range or its own. Every step is looked at in its middle and halved \
                  where two events could hide in it. Multipliers come from dense matrices, which takes long from a hundred masses on; \
                  --events grazing,fold needs none."
)]
pub struct BranchArgs {
    /// Where, along what, how far.
    #[command(flatten)]
    pub along: AlongArgs,
    /// Events to look for, a list with commas [default: all].
    #[arg(long, value_enum, value_delimiter = ',')]
    pub events: Vec<EventName>,
    /// Go on along what branches off at period doublings, pitchforks and grazing.
    #[arg(long)]
    pub switch: bool,
    /// How often a branch may leave another.
    #[arg(long, value_name = "K", default_value_t = 1, requires = "switch", value_parser = whole::<u32>, allow_negative_numbers = true)]
    pub generations: u32,
    /// Also what is not physical, in text and picture.
    #[arg(long)]
    pub all: bool,
    /// Growth per period, |μ| − 1, below which a breather counts as stable [default: strict].
    #[arg(long, value_name = "GROWTH", value_parser = real, allow_negative_numbers = true)]
    pub threshold: Option<f64>,
    /// Points and events as a table (CSV).
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Picture of the diagram, .png, .svg or .pdf: solid stable, dashed unstable; with --all, thin not physical.
    #[arg(long, value_name = "FILE")]
    pub plot: Option<PathBuf>,
    /// How it is made.
    #[command(flatten)]
    pub page: PageArgs,
    /// What the picture shows, a list with commas.
    #[arg(long, value_enum, value_delimiter = ',', default_value = "impulse,spectral-radius", requires = "plot")]
    pub show: Vec<QuantityName>,
    /// Print JSON instead of text.
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `mapgen curve`.
#[derive(Debug, Args)]
#[command(
    after_help = "The flags of the model give the start, both varied parameters included. From there the event is looked for along the \
                  first, as `mapgen locate` does; every one that is found is followed both ways in the window of both, round turning \
                  points, to the window's edge or its own end. Errors, and how far a straight line between neighbouring points may be \
                  from the curve, are parts of the window's sides. Multipliers come from dense matrices."
)]
pub struct CurveArgs {
    /// What to look for and to follow.
    #[arg(long, value_enum)]
    pub event: EventName,
    /// Where, along what, how far.
    #[command(flatten)]
    pub along: AlongArgs,
    /// The second parameter that varies.
    #[arg(long, value_enum)]
    pub and: FreeName,
    /// Least value of the second parameter [default: as of the first].
    #[arg(long, value_name = "VALUE", value_parser = real, allow_negative_numbers = true)]
    pub and_from: Option<f64>,
    /// Largest value of the second parameter [default: as of the first].
    #[arg(long, value_name = "VALUE", value_parser = real, allow_negative_numbers = true)]
    pub and_to: Option<f64>,
    /// How far a straight line between two neighbouring points may be from the curve, as a part of the window's sides.
    #[arg(long, value_name = "PART", default_value_t = 1e-6, value_parser = real, allow_negative_numbers = true)]
    pub tolerance: f64,
    /// Points of all curves as a table (CSV).
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Picture of the curves, .png, .svg or .pdf: solid where the orbit is physical.
    #[arg(long, value_name = "FILE")]
    pub plot: Option<PathBuf>,
    /// How it is made.
    #[command(flatten)]
    pub page: PageArgs,
    /// Print JSON instead of text.
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `mapgen curves`.
#[derive(Debug, Args)]
#[command(
    after_help = "Stripes of conservative breathers are found by the modes that meet, with both edges, however thin. What a coarse \
                  look at the window shows besides is enclosed between two neighbouring places; the event there is located and followed \
                  both ways. At last the window is cut by all borders, and what is left in the faces is asked the same question. \
                  Where the scene allows some growth, stability is lost at no event: that border is traced by the growth. Errors, and how far a straight line between \
                  neighbouring points may be from its border, are parts of the window's sides."
)]
pub struct CurvesArgs {
    /// Scene file (TOML) with two equally spaced axes.
    pub scene: PathBuf,
    /// Points of all borders as a table (CSV).
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Points of codimension two as a table (CSV).
    #[arg(long, value_name = "FILE")]
    pub points: Option<PathBuf>,
    /// Picture of the map by its regions, .png, .svg or .pdf: a stripe thinner than a pixel is drawn by its share.
    #[arg(long, value_name = "FILE")]
    pub plot: Option<PathBuf>,
    /// How it is made.
    #[command(flatten)]
    pub page: PageArgs,
    /// Print JSON instead of text.
    #[arg(long)]
    pub json: bool,
    /// How far a straight line between two neighbouring points may be from its border, as a part of the window's sides.
    #[arg(long, value_name = "PART", default_value_t = 1e-6, value_parser = real, allow_negative_numbers = true)]
    pub tolerance: f64,
    /// Places of the window, spread by area, that are asked what lives there once all borders are known: none of N falls into a piece of
    /// share 3/N that a border is missing around in one of twenty cases.
    #[arg(long, value_name = "N", default_value_t = 100_000, value_parser = whole::<usize>, allow_negative_numbers = true)]
    pub places: usize,
    /// Growth per period, |μ| − 1, below which a breather counts as stable [default: that of the scene, or strict].
    #[arg(long, value_name = "GROWTH", value_parser = real, allow_negative_numbers = true)]
    pub threshold: Option<f64>,
}

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
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum StartFrom {
    /// The one that gives the cell its class: a stable one, if there is one.
    #[default]
    Class,
    /// Every physical one.
    Every,
    /// Every unstable one.
    Unstable,
}

/// Arguments of `mapgen fate`.
#[derive(Debug, Args)]
#[command(
    after_help = "A run ends as `breather` (its impacts are the breather's, within the tolerance), `another` (they repeat, as another word), \
                  `quiet` (none any more), `chaos` (the largest Lyapunov exponent is clearly positive), `quasi-periodic` (they do not repeat, and \
                  neighbours part no faster than by a power of time), `other`, or `incomplete`. All numbers follow from the seed, whatever \
                  the number of threads. Interrupted by Ctrl-C or SIGTERM it keeps the rows of the cells that are finished."
)]
pub struct FateArgs {
    /// Scene file (TOML), see scenes/.
    pub scene: PathBuf,
    /// Table to write (CSV), a row a breather.
    #[arg(long, alias = "out", value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Picture, .png, .svg or .pdf: over two axes the most frequent end of each cell, over one the shares of all ends, or the diagram.
    #[arg(long, value_name = "FILE")]
    pub plot: Option<PathBuf>,
    /// How it is made.
    #[command(flatten)]
    pub page: PageArgs,
    /// From which breathers of a cell runs start.
    #[arg(long, value_enum, default_value_t)]
    pub breathers: StartFrom,
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
    /// Instead, a bifurcation diagram by simulation over a scene with one axis (CSV): the last points of a stroboscopic section of one run a cell.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["csv", "starts", "breathers", "json"])]
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
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("start").args(["family", "word", "near", "state", "scene"]).required(true).multiple(true))]
pub struct SimulateArgs {
    /// Start on a breather, in the flight before its impact at t = 0.
    #[command(flatten)]
    pub which: WhichArgs,
    /// Start from a state, JSON {"displacement":[…],"velocity":[…],"psi":0} or what --json has printed, at t = 0. A mass at rest on a barrier leaves it if
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
    /// Stop after this many impacts.
    #[arg(long, value_name = "K", value_parser = whole::<u64>, allow_negative_numbers = true)]
    pub max_impacts: Option<u64>,
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
    #[arg(long, value_name = "FILE")]
    pub animate: Option<PathBuf>,
    /// Picture of the run, .png, .svg or .pdf: the impacting mass over the analytic orbit, all masses in space and time.
    #[arg(long, value_name = "FILE")]
    pub plot: Option<PathBuf>,
    /// How it is made.
    #[command(flatten)]
    pub page: PageArgs,
    /// Print JSON instead of text, with the state at the end, which --state takes up again.
    #[arg(long)]
    pub json: bool,
}
