//! Pictures of ensembles: over two axes a map, over one shares or a diagram.

#[cfg(feature = "plot")]
pub(crate) use with_plot::Plot;
#[cfg(not(feature = "plot"))]
pub(crate) use without_plot::Plot;

#[cfg(feature = "plot")]
mod with_plot {
    use std::path::Path;

    use vibrochain_fate::{CellFates, Column, End, Ensemble};
    use vibrochain_lattice::Short;
    use vibrochain_maps::files::Output;
    use vibrochain_maps::scene::{Axis, Scene, Values};
    use vibrochain_plot::{
        Curves, EndsPicture, MOST_VALUES, Mark, Page, Pane, Scale, Series, Stroke, curves_picture, ends_picture,
    };

    use crate::error::CliError;
    use crate::page_args::PageArgs;

    /// The most cells of a picture.
    const MOST_CELLS: u64 = 36_000_000;

    /// The most points of a diagram that are drawn: dozens for every pixel.
    const MOST_POINTS: usize = 2_000_000;

    /// Values along an axis up to which each has a mark of its own.
    const MARKED: u64 = 40;

    /// What is collected of a picture.
    pub(crate) struct Plot {
        file: Option<(Page, Output)>,
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
        pub(crate) fn of_ends(path: Option<&Path>, page: &PageArgs, scene: &Scene) -> Result<Self, CliError> {
            let axes = scene.axes.len();
            let longest = scene.axes.iter().map(Axis::points).max().unwrap_or(0);
            if path.is_some() && (axes > 2 || axes == 2 && longest > MOST_VALUES || scene.cells() > MOST_CELLS) {
                let message = format!(
                    "--plot needs one axis, or two of at most {MOST_VALUES} values each; the scene has {axes}, of up to {longest} values"
                );
                return Err(CliError::Request(message));
            }
            Self::new(path, page, scene, false)
        }

        pub(crate) fn of_diagram(path: Option<&Path>, page: &PageArgs, scene: &Scene) -> Result<Self, CliError> {
            Self::new(path, page, scene, true)
        }

        fn new(path: Option<&Path>, page: &PageArgs, scene: &Scene, is_diagram: bool) -> Result<Self, CliError> {
            let axis = match scene.axes.as_slice() {
                [axis] => Some(axis.clone()),
                _ => None,
            };
            let share = |(colour, name): (usize, &&str)| Series {
                name: (*name).to_owned(),
                colour,
                stroke: Stroke::Solid(2),
                mark: if scene.cells() > MARKED { Mark::None } else { Mark::Small(colour) },
                points: Vec::new(),
            };
            let shares = End::NAMES.iter().enumerate().map(share).collect();
            Ok(Self {
                file: page.open("--plot", path)?,
                cells: Vec::new(),
                shares,
                points: Vec::new(),
                axis,
                is_diagram,
            })
        }

        pub(crate) fn see(&mut self, cell: &CellFates) {
            if self.file.is_none() {
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

        pub(crate) fn see_column(&mut self, value: f64, column: &Column) {
            if self.file.is_none() {
                return;
            }
            let x = self.axis.as_ref().map_or(value, |axis| place(axis, value));
            let room = MOST_POINTS - self.points.len();
            let points = column.points.iter().filter_map(|point| Some((x, point.states.first()?.0)));
            self.points.extend(points.take(room));
        }

        pub(crate) fn finish(mut self, scene: &Scene, ensemble: &Ensemble) -> Result<(), CliError> {
            let Some((page, file)) = self.file else { return Ok(()) };
            let Ensemble { starts, size, periods, .. } = *ensemble;
            let what = if self.is_diagram { "section" } else { "ends" };
            let each = if self.is_diagram { String::new() } else { format!("{starts} ") };
            let runs = if !self.is_diagram && starts == 1 { "run" } else { "runs" };
            let caption = format!("{what} of {each}{runs} of {periods} periods, perturbed by {}", Short(size));
            let bytes = match &self.axis {
                None => {
                    let picture = EndsPicture { scene, caption, names: &End::NAMES, cells: &self.cells };
                    ends_picture(&picture, page)
                }
                Some(axis) => {
                    let dots = |points| Series {
                        name: String::new(),
                        colour: 0,
                        stroke: Stroke::None,
                        mark: Mark::Dot,
                        points,
                    };
                    for series in &mut self.shares {
                        // A list of values may come in any order.
                        series.points.sort_by(|a, b| a.0.total_cmp(&b.0));
                    }
                    let shown = |series: &Series| series.points.iter().any(|point| point.1 > 0.0);
                    let (y, scale, series) = if self.is_diagram {
                        ("displacement, once a period", Scale::Linear, vec![dots(self.points)])
                    } else {
                        let shares = self.shares.into_iter().filter(shown).collect();
                        ("share of the runs", Scale::Between(-0.03..1.03), shares)
                    };
                    let pane = Pane {
                        caption,
                        x: axis_name(axis),
                        y: y.to_owned(),
                        x_range: None,
                        x_log: is_logarithmic(axis),
                        scale,
                        levels: Vec::new(),
                        round: false,
                        series,
                    };
                    curves_picture(
                        &Curves {
                            title: scene.heading(),
                            panes: vec![pane],
                            columns: 1,
                            pane: (960, 560),
                            ..Curves::default()
                        },
                        page,
                    )
                }
            };
            Ok(file.finish_with(&bytes.map_err(|error| CliError::Computation(error.to_string()))?)?)
        }
    }

    /// Where a value lies along the axis: its logarithm where ratios are equal.
    fn place(axis: &Axis, value: f64) -> f64 {
        if is_logarithmic(axis) { value.log10() } else { value }
    }

    fn is_logarithmic(axis: &Axis) -> bool {
        matches!(axis.values, Values::Logarithmic { .. })
    }

    fn axis_name(axis: &Axis) -> String {
        format!("{} {}", axis.parameter.meaning(), axis.parameter.symbol())
    }
}

#[cfg(not(feature = "plot"))]
mod without_plot {
    use std::path::Path;

    use vibrochain_fate::{CellFates, Column, Ensemble};
    use vibrochain_maps::scene::Scene;

    use crate::error::CliError;
    use crate::page_args::PageArgs;

    /// This build draws nothing.
    pub(crate) struct Plot;

    impl Plot {
        pub(crate) fn of_ends(path: Option<&Path>, _: &PageArgs, _: &Scene) -> Result<Self, CliError> {
            match path {
                Some(_) => Err(CliError::Request("--plot needs a build with the feature `plot`".to_owned())),
                None => Ok(Self),
            }
        }

        pub(crate) fn of_diagram(path: Option<&Path>, page: &PageArgs, scene: &Scene) -> Result<Self, CliError> {
            Self::of_ends(path, page, scene)
        }

        pub(crate) fn see(&mut self, _: &CellFates) {}

        pub(crate) fn see_column(&mut self, _: f64, _: &Column) {}

        pub(crate) fn finish(self, _: &Scene, _: &Ensemble) -> Result<(), CliError> {
            Ok(())
        }
    }
}
