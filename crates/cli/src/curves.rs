//! `mapgen curves`: all borders in a scene's window, and the area of what lives between them.

use std::fmt::Write as _;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use vibrochain_lattice::{Parameter, Short};
use vibrochain_maps::borders::{Border, BorderKind, Borders, UnexplainedChange};
use vibrochain_maps::cell::Class;
use vibrochain_maps::files::CsvFile;
use vibrochain_maps::numbers::Number;
use vibrochain_maps::regions::Regions;
use vibrochain_maps::scene::Scene;
use vibrochain_maps::sweep::Plan;

use crate::args::CurvesArgs;
use crate::common::answer::printed;
use crate::common::border_search::BorderSearch;
use crate::common::console::{Console, destinations};
use crate::common::error::CliError;
use crate::common::pictures::files::PictureFiles;
use crate::common::schemas::CURVES;
use crate::common::threads::threads;
use crate::sweep::report::counted;

/// So many of what is left unexplained are told to people.
const SHOWN: usize = 8;

/// What lives in a region.
pub(crate) type Lives = Option<Class>;

/// Runs the subcommand.
///
/// # Errors
/// [`CliError`].
pub fn run(args: &CurvesArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    crate::structures::refuse_scene(&args.scene)?;
    let scene = Plan::<Scene>::read(&args.scene, args.threshold)?.scene;
    let files =
        [("--out", args.out.as_deref()), ("--points", args.points.as_deref()), ("--plot", args.plot.as_deref())];
    let taken = destinations(args.json, &[("the scene", Some(&args.scene))], &files)?;
    let names = match scene.axes.as_slice() {
        [x, y] => [x, y].map(|axis| axis.parameter.name()),
        _ => ["x", "y"],
    };
    let header = ["border", "family", "event", names[0], names[1], "error", "stripe", "half_width"];
    let stop = (console.interrupt)()?;
    // Destinations first: an impossible one should not cost a computation.
    let table = args.out.as_deref().map(|path| CsvFile::create("--out", path, header)).transpose()?;
    let header = ["border", "family", "event", "special", names[0], names[1], "error"];
    let points = args.points.as_deref().map(|path| CsvFile::create("--points", path, header)).transpose()?;
    let pictures = PictureFiles::one("--plot", args.plot.as_deref(), &args.page)?;
    fits(&pictures, &scene)?;
    let pool = threads(console.threads)?;
    let started = Instant::now();
    let (tolerance, places) = (args.tolerance, args.places);
    let (special, progress) = (args.points.is_some() || args.json, console.progress && !taken);
    let search = BorderSearch { tolerance, places, special, stop: &stop, progress };
    let (borders, regions) = search.run(&scene, &pool)?;
    if let Some(table) = table {
        write_borders(&borders, table)?;
    }
    if let Some(points) = points {
        write_points(&borders, points)?;
    }
    let time = started.elapsed();
    let answer = Answer { scene: &scene, borders: &borders, regions: &regions, places, time };
    let text = if args.json { printed(&answer.told())? } else { answer.as_text() };
    console.answer(&text, args.json, taken)?;
    draw(pictures, &scene, &regions)
}

fn stripe(border: &Border) -> String {
    border.stripe.map_or(String::new(), |stripe| {
        let (k, l) = stripe.modes;
        format!("{k},{l},{}", stripe.harmonic)
    })
}

fn write_borders(borders: &Borders, mut table: CsvFile) -> Result<(), CliError> {
    for (i, border) in borders.borders.iter().enumerate() {
        for point in &border.points {
            let [x, y] = point.values;
            let (family, event) = (&border.family, border.kind);
            table.record(&(i + 1, family, event, x, y, point.error, stripe(border), point.half_width))?;
        }
    }
    Ok(table.finish()?)
}

fn write_points(borders: &Borders, mut table: CsvFile) -> Result<(), CliError> {
    for (i, border) in borders.borders.iter().enumerate() {
        for one in &border.special {
            let [x, y] = one.values;
            table.record(&(i + 1, &border.family, border.kind, one.special.to_string(), x, y, one.error))?;
        }
    }
    Ok(table.finish()?)
}

/// What is told.
struct Answer<'a> {
    scene: &'a Scene,
    borders: &'a Borders,
    regions: &'a Regions<Lives>,
    places: usize,
    time: Duration,
}

fn class_name(class: Lives) -> &'static str {
    class.map_or("unknown", Class::name)
}

impl Answer<'_> {
    /// Number of borders of each family and kind, in the order in which they come.
    fn counts(&self) -> Vec<(&str, BorderKind, usize)> {
        let mut counts: Vec<(&str, BorderKind, usize)> = Vec::new();
        for border in self.borders.borders.iter().filter(|border| border.stripe.is_none()) {
            match counts.iter_mut().find(|(family, kind, _)| (*family, *kind) == (&border.family, border.kind)) {
                Some((_, _, count)) => *count += 1,
                None => counts.push((&border.family, border.kind, 1)),
            }
        }
        counts
    }

    /// Number of stripes of each family.
    fn stripes(&self) -> Vec<(&str, usize)> {
        let mut counts: Vec<(&str, usize)> = Vec::new();
        for border in self.borders.borders.iter().filter(|border| border.stripe.is_some_and(|stripe| stripe.upper)) {
            match counts.iter_mut().find(|(family, _)| *family == border.family) {
                Some((_, count)) => *count += 1,
                None => counts.push((&border.family, 1)),
            }
        }
        counts
    }

    /// As JSON.
    fn told(&self) -> Value {
        let Borders { parameters, borders, unexplained, unresolved, .. } = self.borders;
        json!({
            "schema": CURVES,
            "free": parameters,
            "borders": borders,
            "areas": self.regions.areas(),
            "unexplained": unexplained,
            "unresolved": unresolved,
        })
    }

    /// The answer for people. Writing to a String cannot fail.
    fn as_text(&self) -> String {
        let mut out = String::new();
        let [x, y] = self.borders.parameters.map(Parameter::name);
        let [from_x, to_x] = self.scene.axes[0].limits().map(Short);
        let [from_y, to_y] = self.scene.axes[1].limits().map(Short);
        let points: usize = self.borders.borders.iter().map(|border| border.points.len()).sum();
        let _ = writeln!(
            out,
            "{} of {} over {x} from {from_x} to {to_x}, {y} from {from_y} to {to_y}",
            counted(self.borders.borders.len(), "border"),
            counted(points, "point")
        );
        for (family, count) in self.stripes() {
            let _ = writeln!(out, "  {family}: {}, two edges each", counted(count, "stripe"));
        }
        for (family, kind, count) in self.counts() {
            let _ = writeln!(out, "  {family}: {count} {kind}");
        }
        let _ = writeln!(out, "\nshare of the window");
        for area in self.regions.areas() {
            let _ = writeln!(out, "  {:<16} {:.9} ± {:.0e}", class_name(area.class), area.share, area.error);
        }
        if self.places > 0 {
            let missed = 3.0 / self.places as f64;
            let _ = writeln!(
                out,
                "a piece of {missed:.0e} of the window whose border is missing would have been seen in 19 of 20 cases"
            );
        }
        let closed = self.regions.closed();
        if !closed.is_empty() {
            let widest = closed.iter().map(|(_, width)| *width).fold(0.0, f64::max);
            let _ = writeln!(
                out,
                "\n{} gaps between ends of borders were closed, the widest {widest:.0e} of the window",
                closed.len()
            );
        }
        let left = self.borders.unexplained.len();
        let faces = self.regions.unexplained();
        if left > 0 || !faces.is_empty() {
            let share: f64 = faces.iter().map(|face| face.share).sum();
            let _ = writeln!(
                out,
                "\n{left} changes without a border, {} faces in which places differ, {share:.1e} of the window",
                faces.len()
            );
            let place = |[a, b]: [f64; 2]| format!("{x} = {}, {y} = {}", Number(a), Number(b));
            for face in faces.iter().take(SHOWN) {
                let first = &face.points[0];
                let other = face.points.iter().find(|point| point.1 != first.1).unwrap_or(first);
                let (one, two) = (class_name(first.1), class_name(other.1));
                let _ = writeln!(out, "  {one} at {}, {two} at {}", place(first.0), place(other.0));
            }
            for UnexplainedChange { family, between: [one, other] } in self.borders.unexplained.iter().take(SHOWN) {
                let _ = writeln!(out, "  {family}: between {} and {}", place(*one), place(*other));
            }
        }
        if !self.borders.unresolved.is_empty() {
            let _ =
                writeln!(out, "\n{} places in rows where stripes cannot be told apart", self.borders.unresolved.len());
        }
        let _ = writeln!(out, "\n{} places looked at, {:.1} s", self.borders.places, self.time.as_secs_f64());
        out
    }
}

fn draw(files: PictureFiles, scene: &Scene, regions: &Regions<Lives>) -> Result<(), CliError> {
    use vibrochain_plot::{Palette, RegionsPicture, Tile, regions_picture};
    if files.is_empty() {
        return Ok(());
    }
    let regions = regions.named(|class| Tile { class: *class, mechanism: None });
    let picture = RegionsPicture { scene, regions: &regions, borders: &[], palette: Palette::default() };
    files.draw(|page| regions_picture(&picture, page))
}

/// Makes sure that the picture can be made.
fn fits(files: &PictureFiles, scene: &Scene) -> Result<(), CliError> {
    files.fit(|page| vibrochain_plot::regions_fit(scene, page))
}
