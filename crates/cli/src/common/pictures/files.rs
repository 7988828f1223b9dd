//! The files that a picture goes to, opened before anything is computed for it.

use std::path::{Path, PathBuf};

use vibrochain_maps::files::{Output, promises};
use vibrochain_plot::{Format, Page, Palette, PlotError};

use crate::args::PictureArgs;
use crate::common::error::CliError;
use crate::common::pictures::page_args::PageArgs;

/// Refuses what is of maps alone, where another picture is drawn: that of `what`. `show` tells whether --show was given.
pub(crate) fn of_no_map(wanted: &PictureArgs, show: bool, what: &str) -> Result<(), CliError> {
    let PictureArgs { slice, curves, palette, .. } = wanted;
    let of_maps = [
        ("--slice", !slice.is_empty()),
        ("--show", show),
        ("--curves", *curves),
        ("--palette", *palette != Palette::default()),
    ];
    match of_maps.iter().find(|(_, given)| *given) {
        Some((flag, _)) => Err(CliError::Request(format!("{flag} is of maps, {what}: leave it out"))),
        None => Ok(()),
    }
}

/// Files, each with what it is drawn for.
pub(crate) struct PictureFiles(Vec<(Page, Output)>);

impl PictureFiles {
    /// The one that `flag` names, if it does.
    ///
    /// # Errors
    /// [`CliError::Request`] of a file that cannot be written, or of a page that cannot be.
    pub(crate) fn one(flag: &str, path: Option<&Path>, page: &PageArgs) -> Result<Self, CliError> {
        Ok(Self(page.open(flag, path)?.into_iter().collect()))
    }

    /// Those of --plot, and of --png, --svg and --pdf.
    ///
    /// # Errors
    /// As [`PictureFiles::one`].
    pub(crate) fn asked(wanted: &PictureArgs) -> Result<Self, CliError> {
        Self::open(&Self::named(wanted)?)
    }

    /// The names that these flags give, each with what is drawn for it.
    ///
    /// # Errors
    /// [`CliError::Request`] of a name that promises something else, or of a page that cannot be.
    pub(crate) fn named(wanted: &PictureArgs) -> Result<Vec<(Page, PathBuf)>, CliError> {
        wanted.page.checked(wanted.files().next().is_some(), "--plot")?;
        let page = |(flag, path): (&'static str, &Path)| {
            let format = match Format::from_name(flag.trim_start_matches('-')) {
                Some(format) => promises(flag, path, "a picture", &[format.name()]).map(|()| format)?,
                None => Format::asked(flag, path)?,
            };
            Ok((wanted.page.page(format)?, path.to_owned()))
        };
        wanted.files().map(page).collect()
    }

    /// Opens files that were named.
    ///
    /// # Errors
    /// [`CliError::Request`] of a file that cannot be written.
    pub(crate) fn open(named: &[(Page, PathBuf)]) -> Result<Self, CliError> {
        let open = |(page, path): &(Page, PathBuf)| Ok((*page, Output::create(path)?));
        Ok(Self(named.iter().map(open).collect::<Result<_, CliError>>()?))
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Makes sure that a picture can be made for each, drawn as yet of nothing.
    ///
    /// # Errors
    /// [`CliError::Request`] of a picture that is too large.
    pub(crate) fn fit(&self, picture: impl Fn(Page) -> Result<Vec<u8>, PlotError>) -> Result<(), CliError> {
        let fits = |(page, _): &(Page, Output)| picture(page.to_measure()).map(drop);
        self.0.iter().try_for_each(fits).map_err(|error| CliError::Request(error.0))
    }

    /// Draws a picture into each.
    ///
    /// # Errors
    /// [`CliError::Computation`] of a picture that cannot be drawn, or a file that cannot be written.
    pub(crate) fn draw(self, picture: impl Fn(Page) -> Result<Vec<u8>, PlotError>) -> Result<(), CliError> {
        for (page, file) in self.0 {
            file.finish_with(&picture(page).map_err(|error| CliError::Computation(error.to_string()))?)?;
        }
        Ok(())
    }
}
