//! Maps: `sweep` and `merge`, and their pictures.

use std::path::{Path, PathBuf};

use clap::{ArgGroup, Args, ValueEnum};
use vibrochain_maps::numbers::real;
use vibrochain_maps::point::Parameter;
use vibrochain_maps::sweep::ShardFlag;

use super::events::QuantityName;
use crate::page_args::PageArgs;

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

impl PictureArgs {
    /// The flags that name a file each, and the file, if they were given.
    pub(crate) fn files(&self) -> [(&'static str, Option<&Path>); 3] {
        [("--png", self.png.as_deref()), ("--svg", self.svg.as_deref()), ("--pdf", self.pdf.as_deref())]
    }
}

/// Arguments of `mapgen merge`.
#[derive(Debug, Args)]
pub struct MergeArgs {
    /// Folder of chunks, the --out of `mapgen sweep --shard` or the --csv of `mapgen fate --shard`.
    pub folder: PathBuf,
    /// Table to write (.csv; .csv.gz or .csv.zst, compressed; .parquet, by columns), the same to the byte as that of an
    /// undivided run; beside that of a sweep a manifest is written. `-` is standard output, which has no manifest.
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
    /// Pictures of the table.
    #[command(flatten)]
    pub pictures: PictureArgs,
    /// Print JSON instead of a summary: the manifest of a sweep, what an ensemble has come to.
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `mapgen draw`.
#[derive(Debug, Args)]
#[command(
    after_help = "Tables that hold a picture: those of sweep, merge and fate, branch --csv, curve --csv, and stripes --csv together with the table \
                  of its map. Which one it is the names of its columns say; what it is of, the manifest beside it."
)]
pub struct DrawArgs {
    /// Table (.csv); `-` is standard input.
    pub table: PathBuf,
    /// Manifest of the table, or of one of sweep and merge its scene [default: the manifest beside the table].
    #[arg(long, value_name = "FILE")]
    pub scene: Option<PathBuf>,
    /// Pictures of the table.
    #[command(flatten)]
    pub pictures: PictureArgs,
    /// Of the table of a branch: what the picture shows, a list with commas [default: impulse,spectral-radius].
    #[arg(long, value_enum, value_delimiter = ',')]
    pub show: Vec<QuantityName>,
    /// Of the table of a branch: also what is not physical; of lines of stripes: also differences, faintly.
    #[arg(long)]
    pub all: bool,
    /// Of the table of lines of stripes: the table of the map that they lie on.
    #[arg(long, value_name = "FILE")]
    pub map: Option<PathBuf>,
}
