//! Pictures of ensembles: over two axes a map, over one shares or a diagram.

use std::collections::BTreeMap;

use vibrochain_breather::Word;
use vibrochain_fate::{CellFates, End, Ensemble, From};
use vibrochain_lattice::Short;
use vibrochain_plot::palette::LINES;
use vibrochain_plot::{
    Curves, ENDS, EndsPicture, MOST_VALUES, MapAxis, Mapped, Mark, Pane, Scale, Series, Stroke, about, curves_picture,
    ends_picture, place,
};

use crate::common::error::CliError;
use crate::common::pictures::files::PictureFiles;

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
    "unclassified",
    "incomplete run",
];

/// Values along an axis up to which each has a mark of its own.
const MARKED: usize = 40;

/// Words that have a colour each, and the colour of all others.
const MOST_WORDS: usize = LINES.len() - 1;
const OTHER_WORDS: [u8; 3] = [205, 170, 125];

/// An entry of the legend and its colour.
type Named = (String, [u8; 3]);

/// An end by the number of its kind, or the word of another motion.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
enum Seen {
    Kind(usize),
    Word(Word),
}

/// What is collected of a picture.
pub(crate) struct Plot {
    files: PictureFiles,
    /// Of each cell its most frequent end.
    cells: Vec<Option<Seen>>,
    /// Whether runs start from rest: other motions are told by their words.
    by_word: bool,
    /// Of each end, its share at each value of the axis.
    shares: Vec<Series>,
    /// Points of a diagram.
    points: Vec<(f64, f64)>,
    axis: Option<MapAxis>,
    is_diagram: bool,
}

impl Plot {
    /// Of the ends of runs, other motions by their words if asked.
    ///
    /// # Errors
    /// [`CliError::Request`] of more cells than are drawn.
    pub(crate) fn of_ends(files: PictureFiles, scene: &dyn Mapped) -> Result<Self, CliError> {
        let points: Vec<usize> = scene.axes().iter().map(|axis| axis.values.points()).collect();
        let (axes, longest) = (points.len(), points.iter().max().copied().unwrap_or(0));
        let cells = points.iter().fold(1, |product: u64, points| product.saturating_mul(*points as u64));
        let fits = axes == 1 || axes == 2 && longest <= MOST_VALUES;
        ensure!(
            files.is_empty() || fits && cells <= MOST_CELLS,
            "a picture of ends needs one axis, or two of at most {MOST_VALUES} values each; the scene has {axes}, of up to {longest} values"
        );
        Self::new(files, scene, false)
    }

    /// Of a diagram, over the one axis of its scene.
    ///
    /// # Errors
    /// [`CliError::Request`] of a picture that is too large.
    pub(crate) fn of_diagram(files: PictureFiles, scene: &dyn Mapped) -> Result<Self, CliError> {
        Self::new(files, scene, true)
    }

    fn new(files: PictureFiles, scene: &dyn Mapped, is_diagram: bool) -> Result<Self, CliError> {
        let axes = scene.axes();
        let cells = axes.first().map_or(1, |axis| axis.values.points());
        let axis = <[MapAxis; 1]>::try_from(axes).ok().map(|[axis]| axis);
        files.fit(|page| match &axis {
            Some(axis) => curves_picture(&curves(scene, Pane::over(axis)), page),
            None => {
                let picture = EndsPicture { scene, caption: String::new(), names: &[], cells: &[] };
                ends_picture(&picture, page)
            }
        })?;
        let named = |name: &str| name.replace("breather", scene.orbit());
        let share = |(colour, name): (usize, &&str)| {
            let mark = if cells > MARKED { Mark::None } else { Mark::Small(colour) };
            Series { mark, ..Series::line(named(name), colour, Stroke::Solid(2), []) }
        };
        let shares = WORDS.iter().enumerate().map(share).collect();
        Ok(Self { files, cells: Vec::new(), by_word: false, shares, points: Vec::new(), axis, is_diagram })
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
        self.by_word |= cell.breathers.iter().any(|breather| breather.name == From::Rest.name());
        match &self.axis {
            // The most frequent end of all runs of the cell, the first of several.
            None => {
                let count = |kind: usize| cell.breathers.iter().map(|breather| breather.ends[kind]).sum::<u32>();
                let most = (0..End::NAMES.len()).rev().max_by_key(|&kind| count(kind));
                let most = most.filter(|&kind| count(kind) > 0);
                let words = cell.breathers.iter().flat_map(|breather| &breather.words);
                let word = words.rev().max_by_key(|(_, count)| **count).map(|(word, _)| word.clone());
                self.cells.push(most.map(
                    |kind| match word.filter(|_| self.by_word && End::NAMES[kind] == "periodic") {
                        Some(word) => Seen::Word(word),
                        None => Seen::Kind(kind),
                    },
                ));
            }
            Some(axis) => {
                let x = place(&axis.values, axis.values.value(cell.number as usize));
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
        let x = self.axis.as_ref().map_or(value, |axis| place(&axis.values, value));
        self.points.push((x, displacement));
    }

    pub(crate) fn finish(mut self, scene: &dyn Mapped, ensemble: &Ensemble) -> Result<(), CliError> {
        if self.files.is_empty() {
            return Ok(());
        }
        let Ensemble { starts, size, periods, .. } = *ensemble;
        let what = if self.is_diagram { "section" } else { "ends" };
        let each = if self.is_diagram { String::new() } else { format!("{starts} ") };
        let runs = if !self.is_diagram && starts == 1 { "run" } else { "runs" };
        let from = if self.by_word { " from rest" } else { "" };
        let caption = format!("{what} of {each}{runs} of {periods} periods{from}, perturbed by {}", Short(size));
        let Some(axis) = &self.axis else {
            let (names, cells) = self.legend(scene);
            let picture = EndsPicture { scene, caption, names: &names, cells: &cells };
            return self.files.draw(|page| ends_picture(&picture, page));
        };
        for series in &mut self.shares {
            // A list of values may come in any order.
            series.points.sort_by(|a, b| a.0.total_cmp(&b.0));
        }
        let (y, scale, series) = if self.is_diagram {
            let dots = Series::marks("", 0, Mark::Dot, self.points);
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

impl Plot {
    /// Names and colours of all ends, and of each cell the number of its own: words by their frequency, those that have no colour of
    /// their own together.
    fn legend(&self, scene: &dyn Mapped) -> (Vec<Named>, Vec<Option<usize>>) {
        let mut counts: BTreeMap<&Word, usize> = BTreeMap::new();
        for seen in self.cells.iter().flatten() {
            if let Seen::Word(word) = seen {
                *counts.entry(word).or_default() += 1;
            }
        }
        let mut words: Vec<(&Word, usize)> = counts.into_iter().collect();
        words.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
        words.truncate(MOST_WORDS);
        // The shorter word first.
        words.sort_by_key(|(word, _)| word.letters().count());
        let told = words.iter().map(|(word, _)| word.to_string()).zip(LINES);
        let kinds = WORDS.iter().map(|name| name.replace("breather", scene.orbit())).zip(ENDS);
        let others = ("other words".to_owned(), OTHER_WORDS);
        let names: Vec<Named> =
            if self.by_word { told.chain([others]).chain(kinds).collect() } else { kinds.collect() };
        let first = names.len() - WORDS.len();
        let number = |seen: &Seen| match seen {
            Seen::Kind(kind) => first + kind,
            Seen::Word(word) => words.iter().position(|(known, _)| *known == word).unwrap_or(words.len()),
        };
        let cells = self.cells.iter().map(|seen| seen.as_ref().map(number)).collect();
        (names, cells)
    }
}

/// One panel under the heading of a scene.
fn curves(scene: &dyn Mapped, pane: Pane) -> Curves {
    Curves { title: about(scene), panes: vec![pane], columns: 1, pane: (960, 560), ..Curves::default() }
}
