//! What branches and curves are written to.

use std::path::Path;

use vibrochain_lattice::Stop;
use vibrochain_maps::files::CsvFile;

use super::Along;
use crate::args::AlongArgs;
use crate::common::console::{Console, destinations};
use crate::common::error::CliError;
use crate::common::pictures::files::PictureFiles;
use crate::common::pictures::page_args::PageArgs;
use crate::common::table_manifest::{Manifest, beside};

/// What flags ask for.
pub(crate) struct Wanted<'a> {
    pub(crate) along: &'a AlongArgs,
    pub(crate) json: bool,
    pub(crate) out: Option<&'a Path>,
    pub(crate) plot: Option<&'a Path>,
    pub(crate) page: &'a PageArgs,
}

/// Files that are open before anything is computed, and what ends the work.
pub(crate) struct Outputs {
    /// Whether one of them takes standard output.
    pub(crate) taken: bool,
    pub(crate) stop: Stop,
    /// The table, for which a chain has a manifest.
    pub(crate) file: Option<CsvFile>,
    pub(crate) manifest: Manifest,
    pub(crate) pictures: PictureFiles,
}

impl Outputs {
    /// # Errors
    /// [`CliError`] if two are one, or one cannot be written.
    pub(crate) fn open<'h, A: Along>(
        wanted: &Wanted<'_>,
        header: impl IntoIterator<Item = &'h str>,
        console: &mut Console<'_>,
    ) -> Result<Self, CliError> {
        let Wanted { along, json, out, plot, page } = *wanted;
        let manifest = beside(out.filter(|_| A::OF_CHAINS))?;
        let files = [("--out", out), ("the manifest of --out", manifest.as_deref()), ("--plot", plot)];
        Ok(Self {
            taken: destinations(json, &along.reads(), &files)?,
            stop: (console.interrupt)()?,
            file: out.map(|path| CsvFile::create("--out", path, header)).transpose()?,
            manifest: Manifest::create(manifest.as_deref())?,
            pictures: PictureFiles::one("--plot", plot, page)?,
        })
    }
}
