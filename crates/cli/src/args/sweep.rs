//! Maps: `sweep` and `merge`, and their pictures.

use std::path::{Path, PathBuf};

use clap::{ArgGroup, Args};
use vibrochain_lattice::Parameter;
use vibrochain_maps::numbers::real;
use vibrochain_maps::sweep::ShardFlag;
use vibrochain_plot::Palette;

use super::quantity::{ALL, Meanings, OF_MAPS, QuantityName, among, by_name};
use crate::common::pictures::page_args::{PICTURES, PageArgs};

/// Colours of a map.
const PALETTES: Meanings<Palette> =
    &[(Palette::Colour, "Readable in grey and by colour-blind eyes"), (Palette::Paper, "The paper's greys")];

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
    #[arg(long, alias = "csv", value_name = "FILE", required_unless_present = "dry_run")]
    pub out: Option<PathBuf>,
    /// Go on with the chunks that an interrupted run has left, or start afresh where there are none.
    #[arg(long)]
    pub resume: bool,
    /// Compute one share of the chunks: shard i of n, from 0, or `slurm` for the share of a job array's task. Then `mapgen
    /// merge` makes the table.
    #[arg(long, value_name = "i/n", conflicts_with_all = ["plot", "png", "svg", "pdf"], allow_hyphen_values = true)]
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
    /// What colours the cells of a map, a column of the table.
    #[arg(long, alias = "color", help_heading = PICTURES, value_name = "COLUMN", default_value_t, requires = "picture", value_parser = among(&OF_MAPS))]
    pub show: QuantityName,
    /// Excess per period, |μ| − 1, below which a breather counts as stable [default: strict].
    #[arg(long, value_name = "EXCESS", value_parser = real, allow_negative_numbers = true)]
    pub threshold: Option<f64>,
}

/// Reads a value of an axis, as in `asymmetry=0.4`.
fn axis_value(text: &str) -> Result<(Parameter, f64), String> {
    let Some((name, value)) = text.split_once('=') else {
        refuse!("not a parameter with its value: give one such as asymmetry=0.4");
    };
    let known = || format!("`{name}` is no parameter: give one of {}", Parameter::ALL.map(Parameter::name).join(", "));
    Ok((Parameter::from_name(name).ok_or_else(known)?, real(value)?))
}

/// Pictures of a map.
#[derive(Debug, Clone, Args)]
#[command(group = ArgGroup::new("picture").args(["plot", "png", "svg", "pdf"]).multiple(true))]
pub struct PictureArgs {
    /// Picture, .png, .svg or .pdf; again for one of another kind. A map over two axes; over one, curves of |μ|, margin and (with
    /// `impulse = true`) impulse.
    #[arg(long, help_heading = PICTURES, value_name = "FILE")]
    pub plot: Vec<PathBuf>,
    /// What --plot FILE.png was once.
    #[arg(long, hide = true, value_name = "FILE")]
    pub png: Option<PathBuf>,
    /// What --plot FILE.svg was once.
    #[arg(long, hide = true, value_name = "FILE")]
    pub svg: Option<PathBuf>,
    /// What --plot FILE.pdf was once.
    #[arg(long, hide = true, value_name = "FILE")]
    pub pdf: Option<PathBuf>,
    /// Draw the cells at this value of an axis; again for further axes, until one or two are left. The table stays whole.
    #[arg(long, help_heading = PICTURES, value_name = "PARAMETER=VALUE", value_parser = axis_value, requires = "picture")]
    pub slice: Vec<(Parameter, f64)>,
    /// Draw the borders of the map over its cells, which `mapgen curves` finds; both axes must be equally spaced.
    #[arg(long, help_heading = PICTURES, requires = "picture")]
    pub curves: bool,
    /// Colours of the pictures of maps.
    #[arg(long, help_heading = PICTURES, value_parser = by_name(PALETTES, Palette::name), default_value_t)]
    pub palette: Palette,
    /// How they are made.
    #[command(flatten)]
    pub page: PageArgs,
}

impl PictureArgs {
    /// The files that were asked for, each with its flag.
    pub(crate) fn files(&self) -> impl Iterator<Item = (&'static str, &Path)> {
        let once = [("--png", &self.png), ("--svg", &self.svg), ("--pdf", &self.pdf)];
        let once = once.into_iter().filter_map(|(flag, path)| Some((flag, path.as_deref()?)));
        self.plot.iter().map(|path| ("--plot", path.as_path())).chain(once)
    }

    /// `others` and these, for what looks at all files of a command.
    pub(crate) fn beside<'a>(
        &'a self,
        others: &[(&'static str, Option<&'a Path>)],
    ) -> Vec<(&'static str, Option<&'a Path>)> {
        others.iter().copied().chain(self.files().map(|(flag, path)| (flag, Some(path)))).collect()
    }
}

/// Arguments of `mapgen merge`.
#[derive(Debug, Args)]
pub struct MergeArgs {
    /// Folder of chunks, the --out of `mapgen sweep --shard` or `mapgen fate --shard`.
    pub folder: PathBuf,
    /// Table to write (.csv; .csv.gz or .csv.zst, compressed; .parquet, by columns), the same to the byte as that of an
    /// undivided run; beside that of a sweep a manifest is written. `-` is standard output, which has no manifest.
    #[arg(long, alias = "csv", value_name = "FILE")]
    pub out: PathBuf,
    /// Pictures of the table.
    #[command(flatten)]
    pub pictures: PictureArgs,
    /// What colours the cells of a map, a column of the table.
    #[arg(long, alias = "color", help_heading = PICTURES, value_name = "COLUMN", default_value_t, requires = "picture", value_parser = among(&OF_MAPS))]
    pub show: QuantityName,
    /// Print JSON instead of a summary: the manifest of a sweep, what an ensemble has come to.
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `mapgen draw`.
#[derive(Debug, Args)]
#[command(
    after_help = "Tables that hold a picture: those of sweep, merge, fate, branch and curve. The names of its columns say which one it is; \
                  the manifest beside it says what it is of."
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
    /// What the picture shows: what colours the cells of a map, class or spectral_radius, margin, impulse, solutions [default: class]; of a
    /// branch a list with commas of impulse, phi, psi, margin, spectral_radius [default: impulse,spectral_radius].
    #[arg(long, alias = "color", help_heading = PICTURES, value_name = "QUANTITY", value_delimiter = ',', value_parser = among(&ALL), hide_possible_values = true)]
    pub show: Vec<QuantityName>,
    /// Draw what is left out otherwise: of a branch, orbits that are not physical.
    #[arg(long, help_heading = PICTURES)]
    pub all: bool,
}
