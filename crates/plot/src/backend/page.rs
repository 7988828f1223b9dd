//! What a picture is made for: kind of file, width, resolution, size of letters.

use crate::backend::format::{Format, PlotError};

/// Units of an inch and of a millimetre.
const INCH: f64 = 96.0;
pub(crate) const MILLIMETRE: f64 = INCH / 25.4;

/// Units of a point of a printer.
pub(crate) const POINT: f64 = INCH / 72.0;

/// Height of letters on a screen.
pub(crate) const SCREEN: f64 = 15.0;

/// The most pixels along a side: beyond that no viewer opens a picture.
const MOST_PIXELS: f64 = 30_000.0;

/// The most pixels of all: a picture takes eleven bytes for each while it is made.
const MOST_AREA: f64 = 2e8;

/// The part of them that a picture may have that is measured before all is known that it will show: its legend grows with that.
const FORESEEN: f64 = 0.8;

/// What a picture is made for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Page {
    /// The kind of file.
    pub format: Format,
    /// Its width in units of 1/96 inch; without it each picture has its own.
    pub width: Option<f64>,
    /// How high it may be, in the same units: of what has any number of parts only the first are drawn. Nothing limits it on a screen.
    pub height: Option<f64>,
    /// Pixels of an inch: of a PNG, and of rasters in the others.
    pub dpi: f64,
    /// Height of the letters of legends, in units of 1/96 inch.
    pub font: f64,
    /// Whether panels have letters, (a), (b), …
    pub letters: bool,
    /// Whether a picture is only to be measured ([`Page::to_measure`]).
    pub measures: bool,
}

impl From<Format> for Page {
    /// For a screen.
    fn from(format: Format) -> Self {
        Self { format, width: None, height: None, dpi: INCH, font: SCREEN, letters: false, measures: false }
    }
}

/// Height of a printed page in millimetres: that of A4 within its margins.
const SHEET: f64 = 240.0;

/// Dots of an inch and points of letters on paper, where nothing else is asked for.
const PRINT_DPI: f64 = 300.0;
const PRINT_POINTS: f64 = 8.0;

/// What pages are for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Purpose {
    /// A screen: each picture has its own width.
    Screen,
    /// A column of a journal, 86 mm, letters of 7.5 points, 600 dpi.
    Column,
    /// The width of a page, 178 mm, letters of 8 points, 600 dpi.
    Page,
    /// Paper, so many millimetres wide: letters of 8 points, 300 dpi.
    Paper(f64),
    /// A slide of 1280 × 720 units, letters that the last row reads.
    Slide,
}

impl Purpose {
    /// The page for it.
    pub fn page(self, format: Format) -> Page {
        let page = Page::from(format);
        let print = |millimetres: f64, points: f64, dpi: f64| Page {
            width: Some(millimetres * MILLIMETRE),
            height: Some(SHEET * MILLIMETRE),
            dpi,
            font: points * POINT,
            ..page
        };
        match self {
            Self::Screen => page,
            Self::Column => print(86.0, 7.5, 600.0),
            Self::Page => print(178.0, 8.0, 600.0),
            Self::Paper(millimetres) => print(millimetres, PRINT_POINTS, PRINT_DPI),
            Self::Slide => Page { width: Some(1280.0), height: Some(720.0), dpi: 2.0 * INCH, font: 20.0, ..page },
        }
    }
}

impl Page {
    /// Pixels of a unit.
    pub(crate) fn scale(&self) -> f64 {
        self.dpi / INCH
    }

    /// The same page, to learn whether a picture can be made before what it shows is computed: a picture drawn on it has no bytes, or the
    /// error that it would end with.
    #[must_use]
    pub fn to_measure(self) -> Self {
        Self { measures: true, ..self }
    }

    /// How many pixels a box has.
    pub(crate) fn pixels(&self, size: [f64; 2]) -> [u32; 2] {
        size.map(|side| (side * self.scale()).round().max(1.0) as u32)
    }

    /// The nearest border between pixels.
    pub(crate) fn snap(&self, place: f64) -> f64 {
        (place * self.scale()).round() / self.scale()
    }

    /// So many units of a unit that is one with the letters of a screen.
    pub(crate) fn px(&self, units: f64) -> f64 {
        units * self.font / SCREEN
    }

    /// Makes sure that a picture of this size, in units, can be made.
    ///
    /// # Errors
    /// [`PlotError`] that says what to do.
    pub(crate) fn holds(&self, [width, height]: [f64; 2]) -> Result<(), PlotError> {
        let [columns, rows] = [width * self.scale(), height * self.scale()];
        let (part, without) = if self.measures { (FORESEEN, " without all of its legend") } else { (1.0, "") };
        let (side, area) = (part * MOST_PIXELS, part * MOST_AREA);
        if columns.max(rows) > side || columns * rows > area {
            return Err(PlotError(format!(
                "{columns:.0} x {rows:.0} pixels{without} are more than {side} along a side or {area:e} in all: \
                 choose a smaller width, or fewer dots per inch than {}",
                self.dpi
            )));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_is_86_millimetres_wide() {
        let page = Purpose::Column.page(Format::Pdf);
        assert!((page.width.unwrap() / 96.0 * 25.4 - 86.0).abs() < 1e-12);
        assert!((page.font / 96.0 * 72.0 - 7.5).abs() < 1e-12);
        // 86 mm at 600 dpi are 2031.5 pixels.
        assert_eq!((page.width.unwrap() * page.scale()).round(), 2031.0);
        assert!((page.snap(100.03) * page.scale()).fract().abs() < 1e-9);
        assert!(page.holds([325.0, 40_000.0]).unwrap_err().0.contains("600"));
        assert!(page.holds([325.0, 4000.0]).is_ok());
        let paper = Purpose::Paper(86.0).page(Format::Png);
        assert_eq!((paper.width, paper.dpi), (page.width, 300.0));
        assert!((paper.font / 96.0 * 72.0 - 8.0).abs() < 1e-12);
    }
}
