//! The CSV table of a sweep.

use std::fmt::Write as _;
use std::io::Write;

use csv::{ByteRecord, Writer};

use crate::cell::Cell;
use crate::output::Number;
use crate::parameter::{Parameter, Point};
use crate::scene::Scene;

/// Columns after the parameters.
const COLUMNS: [&str; 6] = ["class", "mechanism", "spectral_radius", "margin", "solutions", "status"];

/// The parameters with a column of their own: always gamma2 and omega, and whatever else is swept.
fn parameters(scene: &Scene) -> Vec<Parameter> {
    let mut shown = vec![Parameter::Gamma2, Parameter::Omega];
    for axis in [&scene.y, &scene.x] {
        if !shown.contains(&axis.parameter) {
            shown.push(axis.parameter);
        }
    }
    shown
}

/// Writes rows of cells; no value is ever written as 0 or NaN for want of one, its field is empty.
pub struct Table<W: Write> {
    writer: Writer<W>,
    parameters: Vec<Parameter>,
    record: ByteRecord,
    text: String,
}

impl<W: Write> Table<W> {
    /// Writes the header.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn new(scene: &Scene, writer: W) -> csv::Result<Self> {
        let mut writer = Writer::from_writer(writer);
        let parameters = parameters(scene);
        writer.write_record(parameters.iter().map(|parameter| parameter.name()).chain(COLUMNS))?;
        Ok(Self { writer, parameters, record: ByteRecord::new(), text: String::new() })
    }

    /// Writes one cell.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn write(&mut self, point: &Point, cell: &Cell) -> csv::Result<()> {
        self.record.clear();
        for i in 0..self.parameters.len() {
            self.number(Some(point.get(self.parameters[i])));
        }
        self.record.push_field(cell.class.map_or("", |class| class.name()).as_bytes());
        self.record.push_field(cell.mechanism.map_or("", |mechanism| mechanism.name()).as_bytes());
        self.number(cell.spectral_radius);
        self.number(cell.margin);
        self.text.clear();
        // Writing to a String cannot fail.
        let _ = write!(self.text, "{}", cell.solutions);
        self.record.push_field(self.text.as_bytes());
        self.record.push_field(cell.status.name().as_bytes());
        self.writer.write_byte_record(&self.record)
    }

    fn number(&mut self, value: Option<f64>) {
        self.text.clear();
        if let Some(value) = value {
            // Writing to a String cannot fail.
            let _ = write!(self.text, "{}", Number(value));
        }
        self.record.push_field(self.text.as_bytes());
    }

    /// Hands back the writer.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn finish(self) -> std::io::Result<W> {
        self.writer.into_inner().map_err(csv::IntoInnerError::into_error)
    }
}
