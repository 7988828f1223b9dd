//! Pictures of ensembles: over two axes a map, over one shares or a diagram.

#[cfg(feature = "plot")]
pub(crate) use with_plot::Plot;
#[cfg(not(feature = "plot"))]
pub(crate) use without_plot::Plot;

#[cfg(feature = "plot")]
mod with_plot {
    use vibrochain_fate::{CellFates, End, Ensemble};
    use vibrochain_lattice::Short;
    use vibrochain_maps::scene::{Axis, Scene};
    use vibrochain_plot::{
        Curves, EndsPicture, MOST_VALUES, Mark, Pane, Scale, Series, Stroke, about, curves_picture, ends_picture, place,
    };

    use crate::common::error::CliError;
    use crate::common::picture_files::PictureFiles;

    /// The most cells of a picture.
    const MOST_CELLS: u64 = 36_000_000;

    /// The most points of a diagram that are drawn: dozens for every pixel.
    const MOST_POINTS: usize = 2_000_000;

    /// What legends call the ends, in the order of [`End::NAMES`].
    const WORDS: [&str; End::NAMES.len()] = [
        "stays on the breather",
        "another periodic motion",
        "quiet, no impacts",
        "chaos",
        "quasi-periodic",
        "other",
        "incomplete run",
    ];

    /// Values along an axis up to which each has a mark of its own.
    const MARKED: u64 = 40;

    /// What is collected of a picture.
    pub(crate) struct Plot {
        files: PictureFiles,
        /// Of each cell the number of its most frequent end.
        cells: Vec<Option<usize>>,
        /// Of each end, its share at each value of the axis.
        shares: Vec<Series>,
        /// Points of a diagram.
        points: Vec<(f64, f64)>,
        axis: Option<Axis>,
        is_diagram: bool,
    }

    impl Plot {
        /// Of the ends of runs.
        ///
        /// # Errors
        /// [`CliError::Request`] of more cells than are drawn.
        pub(crate) fn of_ends(files: PictureFiles, scene: &Scene) -> Result<Self, CliError> {
            let axes = scene.axes.len();
            let longest = scene.axes.iter().map(Axis::points).max().unwrap_or(0);
            if !files.is_empty() && (axes > 2 || axes == 2 && longest > MOST_VALUES || scene.cells() > MOST_CELLS) {
                let message = format!(
                    "a picture of ends needs one axis, or two of at most {MOST_VALUES} values each; the scene has {axes}, of up to {longest} values"
                );
                return Err(CliError::Request(message));
            }
            Self::new(files, scene, false)
        }

        /// Of a diagram, over the one axis of its scene.
        ///
        /// # Errors
        /// [`CliError::Request`] of a picture that is too large.
        pub(crate) fn of_diagram(files: PictureFiles, scene: &Scene) -> Result<Self, CliError> {
            Self::new(files, scene, true)
        }

        fn new(files: PictureFiles, scene: &Scene, is_diagram: bool) -> Result<Self, CliError> {
            let axis = match scene.axes.as_slice() {
                [axis] => Some(axis.clone()),
                _ => None,
            };
            files.fit(|page| match &axis {
                Some(axis) => curves_picture(&curves(scene, Pane::over(axis)), page),
                None => {
                    let picture = EndsPicture { scene, caption: String::new(), names: &WORDS, cells: &[] };
                    ends_picture(&picture, page)
                }
            })?;
            let share = |(colour, name): (usize, &&str)| Series {
                name: (*name).to_owned(),
                colour,
                stroke: Stroke::Solid(2),
                mark: if scene.cells() > MARKED { Mark::None } else { Mark::Small(colour) },
                points: Vec::new(),
            };
            let shares = WORDS.iter().enumerate().map(share).collect();
            Ok(Self { files, cells: Vec::new(), shares, points: Vec::new(), axis, is_diagram })
        }

        /// Forgets what was seen.
        pub(crate) fn begin(&mut self) {
            self.cells.clear();
            self.shares.iter_mut().for_each(|series| series.points.clear());
            self.points.clear();
        }

        pub(crate) fn see(&mut self, cell: &CellFates) {
            if self.files.is_empty() {
                return;
            }
            match &self.axis {
                // The most frequent end of all runs of the cell, the first of several.
                None => {
                    let count = |kind: usize| cell.breathers.iter().map(|breather| breather.ends[kind]).sum::<u32>();
                    let most = (0..End::NAMES.len()).rev().max_by_key(|&kind| count(kind));
                    self.cells.push(most.filter(|&kind| count(kind) > 0));
                }
                Some(axis) => {
                    let x = place(axis, axis.value(cell.number as usize));
                    let runs: u32 = cell.breathers.iter().map(|breather| breather.runs()).sum();
                    for (kind, series) in self.shares.iter_mut().enumerate() {
                        let count: u32 = cell.breathers.iter().map(|breather| breather.ends[kind]).sum();
                        // Without runs the line breaks.
                        series.points.push((x, if runs > 0 { f64::from(count) / f64::from(runs) } else { f64::NAN }));
                    }
                }
            }
        }

        /// A point of a diagram: a value of the axis, and the displacement of the first mass that is looked at.
        pub(crate) fn see_point(&mut self, value: f64, displacement: f64) {
            if self.files.is_empty() || self.points.len() == MOST_POINTS {
                return;
            }
            let x = self.axis.as_ref().map_or(value, |axis| place(axis, value));
            self.points.push((x, displacement));
        }

        pub(crate) fn finish(mut self, scene: &Scene, ensemble: &Ensemble) -> Result<(), CliError> {
            if self.files.is_empty() {
                return Ok(());
            }
            let Ensemble { starts, size, periods, .. } = *ensemble;
            let what = if self.is_diagram { "section" } else { "ends" };
            let each = if self.is_diagram { String::new() } else { format!("{starts} ") };
            let runs = if !self.is_diagram && starts == 1 { "run" } else { "runs" };
            let caption = format!("{what} of {each}{runs} of {periods} periods, perturbed by {}", Short(size));
            let Some(axis) = &self.axis else {
                let picture = EndsPicture { scene, caption, names: &WORDS, cells: &self.cells };
                return self.files.draw(|page| ends_picture(&picture, page));
            };
            for series in &mut self.shares {
                // A list of values may come in any order.
                series.points.sort_by(|a, b| a.0.total_cmp(&b.0));
            }
            let (y, scale, series) = if self.is_diagram {
                let (name, points) = (String::new(), self.points);
                let dots = Series { name, colour: 0, stroke: Stroke::None, mark: Mark::Dot, points };
                ("displacement, once a period", Scale::Linear, vec![dots])
            } else {
                let shown = |series: &Series| series.points.iter().any(|point| point.1 > 0.0);
                let shares = self.shares.into_iter().filter(shown).collect();
                ("share of the runs", Scale::Between(-0.03..1.03), shares)
            };
            let pane = Pane { caption, y: y.to_owned(), scale, series, ..Pane::over(axis) };
            self.files.draw(|page| curves_picture(&curves(scene, pane.clone()), page))
        }
    }

    /// One panel under the heading of a scene.
    fn curves(scene: &Scene, pane: Pane) -> Curves {
        Curves { title: about(scene), panes: vec![pane], columns: 1, pane: (960, 560), ..Curves::default() }
    }
}

#[cfg(not(feature = "plot"))]
mod without_plot {
    use vibrochain_fate::{CellFates, Ensemble};
    use vibrochain_maps::scene::Scene;

    use crate::common::error::CliError;
    use crate::common::picture_files::PictureFiles;

    /// This build draws nothing.
    pub(crate) struct Plot;

    impl Plot {
        pub(crate) fn of_ends(_: PictureFiles, _: &Scene) -> Result<Self, CliError> {
            Ok(Self)
        }

        pub(crate) fn of_diagram(_: PictureFiles, _: &Scene) -> Result<Self, CliError> {
            Ok(Self)
        }

        pub(crate) fn begin(&mut self) {}

        pub(crate) fn see(&mut self, _: &CellFates) {}

        pub(crate) fn see_point(&mut self, _: f64, _: f64) {}

        pub(crate) fn finish(self, _: &Scene, _: &Ensemble) -> Result<(), CliError> {
            Ok(())
        }
    }
}
