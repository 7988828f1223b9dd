//! The pictures of `mapgen orbit`, of a chain or of a structure: --plot and --all-plots.

use std::path::{Path, PathBuf};

use vibrochain_maps::files::{Output, name_within, promises_folder};
use vibrochain_plot::{Curves, Format, OrbitPanels, Page, Pane, curves_picture, orbit_picture, orbits_on_page};

use crate::args::OrbitArgs;
use crate::common::console::{Console, destinations};
use crate::common::error::CliError;

/// Orbits beyond this are left to the printed list.
const MOST: usize = 8;

/// Begins the names of all files of --all-plots.
const NAME: &str = "solution-";

/// Sees to it that no file of the command is another. Tells whether one is standard output.
pub(crate) fn apart(args: &OrbitArgs) -> Result<bool, CliError> {
    destinations(
        args.json,
        &[("--scene", args.model.scene.as_deref()), ("--near", args.which.near.as_deref())],
        &[
            ("--multipliers", args.multipliers.as_deref()),
            ("--plot", args.plot.as_deref()),
            ("--all-plots", args.all_plots.as_deref()),
            ("--trajectory", args.trajectory.as_deref()),
        ],
    )
}

fn computation(error: impl std::fmt::Display) -> CliError {
    CliError::Computation(error.to_string())
}

/// The folder of the pictures of one solution.
pub(crate) struct Folder<'a> {
    pub(crate) path: &'a Path,
    pub(crate) page: Page,
    /// Of the solution, from 1.
    pub(crate) number: usize,
    /// Above every picture.
    pub(crate) title: String,
}

impl Folder<'_> {
    /// Writes the picture `name` of panels side by side.
    ///
    /// # Errors
    /// [`CliError`].
    pub(crate) fn save(&self, name: &str, pane: (u32, u32), panes: Vec<Pane>) -> Result<(), CliError> {
        let columns = panes.len();
        let picture = Curves { title: self.title.clone(), panes, columns, pane, ..Curves::default() };
        self.write(name, &curves_picture(&picture, self.page).map_err(computation)?)
    }

    /// Writes the picture `name`.
    ///
    /// # Errors
    /// [`CliError`].
    pub(crate) fn write(&self, name: &str, bytes: &[u8]) -> Result<(), CliError> {
        let (number, ending) = (self.number, self.page.format);
        Ok(Output::create(&self.path.join(format!("{NAME}{number}-{name}.{ending}")))?.finish_with(bytes)?)
    }
}

/// A solution that can be drawn.
pub(crate) trait Pictured {
    /// Those that are physical come first.
    fn is_physical(&self) -> bool;

    /// Its panels in the picture of all, solution `number` from 1.
    fn panels(&self, number: usize) -> Result<OrbitPanels, CliError>;

    /// Writes its own pictures into a folder.
    fn write(&self, folder: &Path, page: Page, number: usize) -> Result<(), CliError>;
}

pub(crate) struct OrbitPictures {
    one: Option<(Page, Output)>,
    /// The folder of --all-plots.
    all: Option<(Page, PathBuf)>,
    /// The one solution that is drawn.
    solution: Option<usize>,
}

impl OrbitPictures {
    /// # Errors
    /// [`CliError::Request`] of files that cannot be written, or of a page that cannot be.
    pub(crate) fn open(args: &OrbitArgs) -> Result<Self, CliError> {
        let page = args.page.page(if args.svg { Format::Svg } else { args.format })?;
        let is_drawn = args.plot.is_some() || args.all_plots.is_some();
        args.page.checked(is_drawn, "--plot or --all-plots")?;
        ensure!(
            is_drawn || args.solution.is_none(),
            "--solution is of pictures: ask for one with --plot or --all-plots, or leave it out"
        );
        if let (Some(folder), Some(plot)) = (&args.all_plots, &args.plot)
            && name_within(folder, plot).is_some_and(|name| name.to_string_lossy().starts_with(NAME))
        {
            refuse!("--plot {} is a name that --all-plots uses: name another", plot.display());
        }
        let all = args.all_plots.as_deref().map(|folder| {
            promises_folder("--all-plots", folder)?;
            std::fs::create_dir_all(folder).map_err(|error| CliError::file("cannot make folder", folder, &error))?;
            Ok::<_, CliError>((page, folder.to_owned()))
        });
        let one = args.plot.as_deref().map(|plot| args.page.open("--plot", Some(plot))).transpose()?.flatten();
        if let Some((page, _)) = &one {
            let nothing = OrbitPanels { caption: String::new(), panes: vec![Pane::default(); 2] };
            orbit_picture(&[nothing], page.to_measure()).map_err(|error| CliError::Request(error.0))?;
        }
        Ok(Self { one, all: all.transpose()?, solution: args.solution })
    }

    /// # Errors
    /// [`CliError`] of what cannot be drawn or written.
    pub(crate) fn finish(self, solutions: &[impl Pictured], console: &mut Console<'_>) -> Result<(), CliError> {
        let count = solutions.len();
        if let Some(number) = self.solution.filter(|number| !(1..=count).contains(number)) {
            refuse!("--solution {number} is out of range: there are {count}, give 1 to {count}");
        }
        let wanted = |(solution, number): &(&_, usize)| match self.solution {
            Some(wanted) => wanted == *number,
            None => Pictured::is_physical(*solution),
        };
        let all = || solutions.iter().zip(1..);
        let others = all().filter(|one| self.solution.is_none() && !wanted(one));
        let drawn: Vec<_> = all().filter(wanted).chain(others).take(MOST).collect();
        if let Some((page, folder)) = &self.all {
            drawn.iter().try_for_each(|(solution, number)| solution.write(folder, *page, *number))?;
            let (drawn, folder) = (drawn.len(), folder.display());
            console.summary(&format!("pictures of {drawn} of {count} solutions are in {folder}"));
        }
        let Some((page, file)) = self.one else { return Ok(()) };
        let mut panels =
            drawn.iter().map(|(solution, number)| solution.panels(*number)).collect::<Result<Vec<_>, _>>()?;
        panels.truncate(orbits_on_page(&panels, page));
        if panels.len() < count && self.solution.is_none() {
            let (shown, path) = (panels.len(), file.path().display());
            console.summary(&format!(
                "{path} shows {shown} of {count} solutions, the physical ones first: --solution K draws one"
            ));
        }
        if panels.is_empty() {
            // The answer has been printed; that there is nothing to draw is not a failure.
            let path = file.path().display();
            console.remark(&format!("nothing to plot: there is no solution, {path} was not written"));
            return Ok(());
        }
        let bytes = orbit_picture(&panels, page).map_err(computation)?;
        Ok(file.finish_with(&bytes)?)
    }
}
