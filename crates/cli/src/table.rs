//! The CSV table of a sweep.

use std::fmt::Write as _;
use std::io::Write;
use std::ops::Range;

use csv::{ByteRecord, Writer};

use crate::cell::Cell;
use crate::output::Number;
use crate::parameter::{Parameter, Point};
use crate::scene::Scene;

/// Columns after the parameters.
const COLUMNS: [&str; 6] = ["class", "mechanism", "spectral_radius", "margin", "solutions", "status"];

/// Columns after these where the modes that have collided are asked for.
const COLLISION: [&str; 3] = ["mode1", "mode2", "harmonic"];

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

/// Writes rows of cells; no value is ever written as 0 or NaN for want of one, its field is empty.
pub struct Table<W: Write> {
    writer: Writer<W>,
    parameters: Vec<Parameter>,
    collisions: bool,
    record: ByteRecord,
    /// The digits that each parameter had last: all but the fastest axis stand still for a row of the map.
    last: Vec<(Option<u64>, String)>,
    text: String,
}

impl<W: Write> Table<W> {
    /// For rows alone, without the header.
    pub fn new(scene: &Scene, writer: W) -> Self {
        let writer = Writer::from_writer(writer);
        let parameters = parameters(scene);
        Self {
            writer,
            last: vec![(None, String::new()); parameters.len()],
            parameters,
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
        for (parameter, (last, digits)) in self.parameters.iter().zip(&mut self.last) {
            let value = point.get(*parameter);
            if *last != Some(value.to_bits()) {
                *last = Some(value.to_bits());
                digits.clear();
                digits.push_str(Number(value).text(&mut ryu::Buffer::new()));
            }
            self.record.push_field(digits.as_bytes());
        }
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
