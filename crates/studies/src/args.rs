//! The command line.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};

/// What vibrochain is checked by: the paper's figures and misprints, closed forms against simulation, error against run time.
#[derive(Debug, Parser)]
#[command(
    name = "studies",
    version,
    about,
    after_help = "Files appear whole or not at all; `-` is standard output.\n\
                  Exit codes: those of mapgen."
)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The studies.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Print the table of closed forms against simulation (docs/validation.md).
    Validate(ValidateArgs),
    /// Draw every figure of the paper, with the numbers behind it (docs/figures.md).
    Figures(FiguresArgs),
    /// Print the corrections to the paper, each with its evidence (docs/errata.md).
    Errata(ErrataArgs),
    /// Measure error against run time, this program's methods beside others (docs/accuracy).
    Accuracy(AccuracyArgs),
    /// Print how wide stripes of instability are and how strong, beside the law they follow (docs/stripes.md).
    Stripes(StripesArgs),
    /// Draw where two modes collide over a conservative map, and print how much of the instability that explains (docs/stripes.md).
    Lines(LinesArgs),
    /// Run one inner loop, whose instructions scripts/instructions.sh counts.
    Loop(LoopArgs),
}

/// Inner loops.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LoopName {
    /// Cells of the paper's conservative map, N = 20: existence and stability of both families.
    ConservativeCells,
    /// The same of the ring as a structure: by matrices, contacts and words.
    StructureCells,
    /// The same of its forced map, all solutions.
    ForcedCells,
    /// Cells of a forced map with dashpots.
    DampedCells,
    /// Rows of a table as text.
    TableRows,
    /// Periods of a simulated breather.
    SimulatedBreather,
    /// Periods of a simulated ring all of whose masses hit.
    HotRing,
}

/// Arguments of `studies loop`.
#[derive(Debug, Args)]
pub struct LoopArgs {
    /// Which.
    #[arg(value_enum, value_name = "NAME")]
    pub name: LoopName,
}

/// Arguments of `studies validate`.
#[derive(Debug, Args)]
pub struct ValidateArgs {
    /// File to write instead of standard output (Markdown).
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
}

/// Arguments of `studies figures`.
#[derive(Debug, Args)]
pub struct FiguresArgs {
    /// Folder to write into: figure-NUMBER.png, .svg and .csv for each figure.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Figures to make, by number (3,9; 15 is all its panels) or name (15c, 10-strict) [default: all].
    #[arg(long, value_name = "NUMBERS", value_delimiter = ',', allow_hyphen_values = true)]
    pub only: Vec<String>,
    /// Folder with scenes figure-NUMBER.toml to use instead of those built in, see scenes/figures.
    #[arg(long, value_name = "DIR")]
    pub scenes: Option<PathBuf>,
    /// Also write a document (Markdown) that shows the figures and what is found in them.
    #[arg(long, value_name = "FILE")]
    pub document: Option<PathBuf>,
}

/// Arguments of `studies errata`.
#[derive(Debug, Args)]
pub struct ErrataArgs {
    /// File to write instead of standard output (Markdown).
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
}

/// Arguments of `studies stripes`.
#[derive(Debug, Args)]
pub struct StripesArgs {
    /// File to write instead of standard output (Markdown).
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Picture of their growth over ω in rings of all lengths, .png or .svg.
    #[arg(long, value_name = "FILE")]
    pub plot: Option<PathBuf>,
}

/// Arguments of `studies lines`.
#[derive(Debug, Args)]
pub struct LinesArgs {
    /// The scene, a conservative map with x = omega and y = gamma2.
    #[arg(value_name = "SCENE")]
    pub scene: PathBuf,
    /// Table of the lines (.csv).
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Picture of the map and its lines, .png or .svg.
    #[arg(long, value_name = "FILE")]
    pub plot: Option<PathBuf>,
}

/// Suites of `studies accuracy`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SuiteName {
    /// The kernels χ₁, χ₂, χ₃ of the periodic impulse response.
    Kernels,
    /// Impulses, φ and ψ of breathers.
    Orbits,
    /// Floquet multipliers.
    Spectrum,
    /// The state after many periods of a breather.
    Simulation,
    /// Classes of a map's cells.
    Map,
    /// Impulses, times and ψ of an orbit of two damped masses.
    Shooting,
    /// Extreme corners of the parameters and random points: promised and delivered errors.
    Extremes,
    /// Random structures: are errors within the bounds that are told with each number?
    Structures,
}

/// Arguments of `studies accuracy`.
#[derive(Debug, Args)]
pub struct AccuracyArgs {
    /// Folder to write into: accuracy.md and, in accuracy/, a table (CSV) and a picture (PNG, SVG) for each suite.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Suite to run; may be given several times, accuracy.md then holds these alone [default: all].
    #[arg(long, value_enum, value_name = "SUITE")]
    pub suite: Vec<SuiteName>,
    /// Fewer settings and short timings: a look, not a measurement.
    #[arg(long)]
    pub quick: bool,
    /// Measure nothing: draw the pictures of the tables that are there, and leave those and accuracy.md as they are.
    #[arg(long, conflicts_with = "quick")]
    pub redraw: bool,
}
