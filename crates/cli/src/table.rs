//! The CSV table of a sweep: its rows written, and read back.

use std::fmt::Write as _;
use std::io::Write;
use std::ops::Range;

use csv::{ByteRecord, Writer};
use vibrochain_floquet::Mechanism;

use crate::cell::{Cell, Class, Status};
use crate::lines::Lines;
use crate::output::Number;
use crate::parameter::{Parameter, Point};
use crate::scene::Scene;
use crate::sweep::Summary;
use crate::text::clipped;

/// Columns after the parameters.
const COLUMNS: [&str; 6] = ["class", "mechanism", "spectral_radius", "margin", "solutions", "status"];

/// Columns after these where the modes that have collided are asked for.
const COLLISION: [&str; 3] = ["mode1", "mode2", "harmonic"];
/// Characters shown of a field that is not as it must be.
const MOST_SHOWN: usize = 40;

/// The parameters with a column of their own: always gamma2 and omega, and whatever else is swept, slowest first.
fn parameters(scene: &Scene) -> Vec<Parameter> {
    let mut shown = vec![Parameter::Gamma2, Parameter::Omega];
    for axis in scene.axes.iter().rev() {
        if !shown.contains(&axis.parameter) {
            shown.push(axis.parameter);
        }
    }
    shown
}

/// The columns of a scene's table, by name.
pub fn columns(scene: &Scene) -> Vec<&'static str> {
    let collision = COLLISION.into_iter().filter(|_| scene.task.collisions);
    parameters(scene).iter().map(|parameter| parameter.name()).chain(COLUMNS).chain(collision).collect()
}

/// The header of a scene's table, as it stands in the file.
pub fn header(scene: &Scene) -> String {
    // Names of plain letters need no quotes.
    columns(scene).join(",") + "\n"
}

/// Where the class of a cell stands in its row, by number of the column; its mechanism is the next one.
pub fn class_column(scene: &Scene) -> usize {
    parameters(scene).len()
}

/// The parameters of cells that follow each other, in digits.
#[derive(Debug)]
struct Places {
    parameters: Vec<Parameter>,
    /// The digits that each parameter had last: all but the fastest axis stand still for a row of the map.
    last: Vec<(Option<u64>, String)>,
}

impl Places {
    fn new(scene: &Scene) -> Self {
        let parameters = parameters(scene);
        Self { last: vec![(None, String::new()); parameters.len()], parameters }
    }

    /// Those of a point, in the order of the columns.
    fn of(&mut self, point: &Point) -> impl Iterator<Item = &str> {
        self.parameters.iter().zip(&mut self.last).map(|(parameter, (last, digits))| {
            let value = point.get(*parameter);
            if *last != Some(value.to_bits()) {
                *last = Some(value.to_bits());
                digits.clear();
                digits.push_str(Number(value).text(&mut ryu::Buffer::new()));
            }
            digits.as_str()
        })
    }
}

/// Writes rows of cells; no value is ever written as 0 or NaN for want of one, its field is empty.
pub struct Table<W: Write> {
    writer: Writer<W>,
    places: Places,
    collisions: bool,
    record: ByteRecord,
    text: String,
}

impl<W: Write> Table<W> {
    /// For rows alone, without the header.
    pub fn new(scene: &Scene, writer: W) -> Self {
        Self {
            writer: Writer::from_writer(writer),
            places: Places::new(scene),
            collisions: scene.task.collisions,
            record: ByteRecord::new(),
            text: String::new(),
        }
    }

    /// Writes the cells numbered `range` of a scene.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn write_all(&mut self, scene: &Scene, range: Range<u64>, cells: &[Cell]) -> csv::Result<()> {
        range.zip(cells).try_for_each(|(number, cell)| self.write(&scene.point(number), cell))
    }

    /// Writes one cell.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn write(&mut self, point: &Point, cell: &Cell) -> csv::Result<()> {
        self.record.clear();
        self.places.of(point).for_each(|digits| self.record.push_field(digits.as_bytes()));
        self.record.push_field(cell.class.map_or("", |class| class.name()).as_bytes());
        self.record.push_field(cell.mechanism.map_or("", |mechanism| mechanism.name()).as_bytes());
        self.number(cell.spectral_radius);
        self.number(cell.margin);
        self.count(Some(cell.solutions as usize));
        self.record.push_field(cell.status.name().as_bytes());
        if self.collisions {
            let collision = cell.collision;
            self.count(collision.map(|collision| collision.modes.0));
            self.count(collision.map(|collision| collision.modes.1));
            self.count(collision.map(|collision| collision.harmonic));
        }
        self.writer.write_byte_record(&self.record)
    }

    fn count(&mut self, value: Option<usize>) {
        self.text.clear();
        if let Some(value) = value {
            // Writing to a String cannot fail.
            let _ = write!(self.text, "{value}");
        }
        self.record.push_field(self.text.as_bytes());
    }

    fn number(&mut self, value: Option<f64>) {
        let mut digits = ryu::Buffer::new();
        self.record.push_field(value.map_or("", |value| Number(value).text(&mut digits)).as_bytes());
    }

    /// Hands back the writer.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn finish(self) -> std::io::Result<W> {
        self.writer.into_inner().map_err(csv::IntoInnerError::into_error)
    }
}

/// Reads rows against the cells they must be of, and counts them.
#[derive(Debug)]
pub(crate) struct Reader<'a> {
    scene: &'a Scene,
    cells: Range<u64>,
    next: u64,
    places: Places,
    lines: Lines,
    counts: Summary,
}

impl<'a> Reader<'a> {
    /// For the rows of the cells numbered `cells`.
    pub(crate) fn new(scene: &'a Scene, cells: Range<u64>) -> Self {
        let (next, places) = (cells.start, Places::new(scene));
        Self { scene, cells, next, places, lines: Lines::default(), counts: Summary::default() }
    }

    /// Reads the rows in `bytes`, which may end anywhere.
    ///
    /// # Errors
    /// What is wrong with the first row that is not as it must be.
    pub(crate) fn take(&mut self, bytes: &[u8]) -> Result<(), String> {
        let Self { scene, cells, next, places, lines, counts } = self;
        lines.take(bytes, |row| {
            let number = *next - cells.start + 1;
            if !cells.contains(next) {
                return Err(format!("it has more rows than its {} cells", cells.end - cells.start));
            }
            read_row(row, scene, places.of(&scene.point(*next)), counts)
                .map_err(|wrong| format!("row {number}: {wrong}"))?;
            *next += 1;
            Ok(())
        })
    }

    /// Tells whether that was every row, and as many of each class and status as in `summary`.
    ///
    /// # Errors
    /// What is wrong.
    pub(crate) fn finish(self, summary: &Summary) -> Result<(), String> {
        let Self { cells, next, lines, counts, .. } = self;
        if next != cells.end || !lines.ended() {
            return Err(format!("it has {} rows for {} cells", next - cells.start, cells.end - cells.start));
        }
        if (counts.classes, counts.statuses) != (summary.classes, summary.statuses) {
            return Err("its counts are not those of its rows".to_owned());
        }
        Ok(())
    }
}

/// Counts a row whose first fields are `places`, or tells what is wrong with it.
fn read_row<'a>(
    row: &[u8],
    scene: &Scene,
    mut places: impl Iterator<Item = &'a str>,
    counts: &mut Summary,
) -> Result<(), String> {
    let row = std::str::from_utf8(row).map_err(|_| "it is no text".to_owned())?;
    let mut fields = row.split(',');
    let mut field = |name: &str| fields.next().ok_or_else(|| format!("it ends before its {name}"));
    let unfit = |name: &str, text: &str| Err(format!("its {name} is `{}`", clipped(text, MOST_SHOWN)));
    places.try_for_each(|digits| match field("class")? {
        text if text == digits => Ok(()),
        text => Err(format!("it is of the cell at {} and not at {digits}", clipped(text, MOST_SHOWN))),
    })?;
    let class = field("class")?;
    match Class::ALL.iter().position(|known| known.name() == class) {
        Some(known) => counts.classes[known] += 1,
        None if class.is_empty() => {}
        None => return unfit("class", class),
    }
    let mechanism = field("mechanism")?;
    if !mechanism.is_empty() && Mechanism::from_name(mechanism).is_none() {
        return unfit("mechanism", mechanism);
    }
    for name in ["spectral_radius", "margin"] {
        let text = field(name)?;
        if !text.is_empty() && !text.parse().is_ok_and(f64::is_finite) {
            return unfit(name, text);
        }
    }
    let solutions = field("solutions")?;
    if solutions.parse::<u32>().is_err() {
        return unfit("solutions", solutions);
    }
    let status = field("status")?;
    match Status::ALL.iter().position(|known| known.name() == status) {
        Some(known) => counts.statuses[known] += 1,
        None => return unfit("status", status),
    }
    for name in COLLISION.into_iter().filter(|_| scene.task.collisions) {
        let text = field(name)?;
        if !text.is_empty() && text.parse::<usize>().is_err() {
            return unfit(name, text);
        }
    }
    match fields.next() {
        None => Ok(()),
        Some(more) => Err(format!("it goes on after its last column with `{}`", clipped(more, MOST_SHOWN))),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::cell::Worker;

    const SCENE: &str = r#"
        [model]
        sites = 5
        gamma1 = 0.2
        [sweep]
        axes = [
            { parameter = "omega", from = 0.4, to = 3.0, points = 40 },
            { parameter = "gamma2", from = 0.0, to = 0.3, points = 4 },
            { parameter = "asymmetry", values = [0.4, 0.1] },
        ]
        [compute]
        families = ["double-sided", "single-sided"]
        stability = true
        collisions = true
    "#;

    /// The rows of some cells, and their counts.
    fn rows(scene: &Scene, range: Range<u64>) -> (String, Summary) {
        let mut worker = Worker::new(scene.base.sites);
        let cell = |number| worker.cell(&scene.point(number).model().unwrap(), &scene.task);
        let cells: Vec<Cell> = range.clone().map(cell).collect();
        let mut table = Table::new(scene, Vec::new());
        table.write_all(scene, range, &cells).unwrap();
        (String::from_utf8(table.finish().unwrap()).unwrap(), Summary::of(&cells))
    }

    fn read(scene: &Scene, range: Range<u64>, rows: &str, summary: &Summary) -> Result<(), String> {
        let mut reader = Reader::new(scene, range);
        // In pieces that end anywhere.
        rows.as_bytes().chunks(37).try_for_each(|piece| reader.take(piece))?;
        reader.finish(summary)
    }

    #[test]
    fn what_is_written_reads_back_and_every_change_of_a_field_is_seen() {
        let scene = Scene::parse(Path::new("scene.toml"), SCENE).unwrap();
        let range = 30..290;
        let (text, summary) = rows(&scene, range.clone());
        assert_eq!(read(&scene, range.clone(), &text, &summary), Ok(()));
        assert!(read(&scene, 31..291, &text, &summary).unwrap_err().starts_with("row 1: it is of the cell at "));
        assert!(read(&scene, 30..289, &text, &summary).unwrap_err().contains("more rows than its 259 cells"));
        assert_eq!(read(&scene, 30..291, &text, &summary).unwrap_err(), "it has 260 rows for 261 cells");
        assert_eq!(
            read(&scene, range.clone(), text.trim_end(), &summary).unwrap_err(),
            "it has 259 rows for 260 cells"
        );
        let other = Summary { classes: summary.statuses[..7].try_into().unwrap(), ..summary.clone() };
        assert_eq!(read(&scene, range.clone(), &text, &other).unwrap_err(), "its counts are not those of its rows");

        let lines: Vec<&str> = text.lines().collect();
        let mut changed = 0;
        for (i, line) in lines.iter().enumerate().step_by(7) {
            let fields: Vec<&str> = line.split(',').collect();
            assert_eq!(fields.len(), columns(&scene).len());
            let with = |line: &str| [&lines[..i], &[line], &lines[i + 1..]].concat().join("\n") + "\n";
            let refused = |line: &str| {
                let wrong = read(&scene, range.clone(), &with(line), &summary);
                assert!(wrong.is_err_and(|wrong| wrong.starts_with(&format!("row {}: ", i + 1))), "{line}");
            };
            for column in 0..fields.len() {
                for value in ["NaN", "inf", "-inf", "1e999", "0x1", "none at all", "\u{1b}"] {
                    let mut fields = fields.clone();
                    fields[column] = value;
                    refused(&fields.join(","));
                    changed += 1;
                }
                // One column fewer; all after it stand under other names.
                refused(&[&fields[..column], &fields[column + 1..]].concat().join(","));
            }
            refused(&format!("{line},"));
            refused("");
        }
        assert!(changed > 2000, "{changed}");
    }
}
