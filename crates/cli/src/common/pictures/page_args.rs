//! What pictures are made for, on the command line: width, resolution, letters.

use std::path::Path;

use clap::{Args, ValueEnum};
use vibrochain_lattice::Short;
use vibrochain_maps::files::Output;
use vibrochain_maps::numbers::real;
use vibrochain_plot::{Format, Page, Purpose};

use crate::common::error::CliError;

/// What a picture is made for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum StyleName {
    /// A screen: each picture has its own width.
    #[default]
    Screen,
    /// A column of a journal: 86 mm, letters of 7.5 points, 600 dpi.
    Column,
    /// The width of a page: 178 mm, letters of 8 points, 600 dpi.
    Page,
    /// A slide: 1280 pixels at twice their number, large letters.
    Slide,
}

/// The heading of help on pictures. Each flag names it: the heading of a struct would go on over the flags behind it.
pub(crate) const PICTURES: &str = "Pictures";

/// How pictures are made.
#[derive(Debug, Clone, Copy, PartialEq, Default, Args)]
pub struct PageArgs {
    /// What pictures are made for [default: screen].
    #[arg(long, help_heading = PICTURES, value_enum, value_name = "PURPOSE")]
    pub style: Option<StyleName>,
    /// Width of a picture with its unit, such as 86mm; mm, cm, in and pt are for print, 300 dpi and letters of 8 points unless --style,
    /// --dpi or --font-size say otherwise, px are for a screen [default: that of --style].
    #[arg(long, help_heading = PICTURES, value_name = "LENGTH", value_parser = length, allow_hyphen_values = true)]
    pub width: Option<Length>,
    /// Pixels of an inch: of a PNG, and of rasters in the others [default: that of --style, or 300 for a width in mm, cm, in or pt].
    #[arg(long, help_heading = PICTURES, value_name = "DOTS", value_parser = real, allow_negative_numbers = true)]
    pub dpi: Option<f64>,
    /// Height of the letters of legends in points; others are in proportion [default: that of --style].
    #[arg(long, help_heading = PICTURES, value_name = "POINTS", value_parser = real, allow_negative_numbers = true)]
    pub font_size: Option<f64>,
    /// Name panels (a), (b), …
    #[arg(long, help_heading = PICTURES)]
    pub letters: bool,
}

/// A length as it was given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Length {
    number: f64,
    unit: &'static (&'static str, f64),
}

/// Units of length, each in 1/96 inch, which is a pixel of a screen.
static UNITS: [(&str, f64); 5] =
    [("mm", 96.0 / 25.4), ("cm", 96.0 / 2.54), ("in", 96.0), ("pt", 96.0 / 72.0), ("px", 1.0)];

impl Length {
    /// In units of 1/96 inch.
    fn units(self) -> f64 {
        self.number * self.unit.1
    }

    /// Whether it is measured on paper.
    fn is_of_paper(self) -> bool {
        self.unit.0 != "px"
    }
}

/// What is taken: widths in units of 1/96 inch (20 mm to 2 m), dots of an inch, points.
const WIDTHS: (f64, f64) = (75.0, 7600.0);
const DPI: (f64, f64) = (36.0, 2400.0);
const FONT: (f64, f64) = (4.0, 72.0);

fn length(text: &str) -> Result<Length, String> {
    let advice = "give a number with its unit, mm, cm, in, pt or px, such as 86mm";
    let found = UNITS.iter().find_map(|unit| Some((text.strip_suffix(unit.0)?, unit)));
    let Some((number, unit)) = found else {
        let is_number = real(text.trim()).is_ok();
        refuse!("{}: {advice}", if is_number { "no unit" } else { "not a length" });
    };
    let number = real(number.trim()).map_err(|error| format!("{error}: {advice}"))?;
    let length = Length { number, unit };
    if length.units().is_finite() { Ok(length) } else { Err(format!("not finite: {advice}")) }
}

impl PageArgs {
    /// These flags, as they were given.
    pub(crate) fn words(&self) -> Vec<String> {
        let style = self.style.and_then(|style| style.to_possible_value());
        let style = style.map(|style| format!("--style {}", style.get_name()));
        let width = self.width.map(|Length { number, unit }| format!("--width {number}{}", unit.0));
        let dpi = self.dpi.map(|dpi| format!("--dpi {dpi}"));
        let font_size = self.font_size.map(|points| format!("--font-size {points}"));
        [style, width, dpi, font_size, self.letters.then(|| "--letters".to_owned())].into_iter().flatten().collect()
    }

    /// Makes sure that all is within what can be drawn, and that there is something to draw: `flag` asks for that.
    ///
    /// # Errors
    /// [`CliError::Request`].
    pub(crate) fn checked(&self, is_drawn: bool, flag: &str) -> Result<(), CliError> {
        if let (false, Some(given)) = (is_drawn, self.words().first().and_then(|words| words.split(' ').next())) {
            refuse!("{given} is of pictures: ask for one with {flag}, or leave it out");
        }
        let within = |flag: &str, value: Option<f64>, (low, high): (f64, f64), unit: &str| match value {
            Some(value) if !(low..=high).contains(&value) => {
                Err(CliError::Request(format!("{flag} {value}: give {low} to {high}{unit}")))
            }
            _ => Ok(()),
        };
        if let Some(width) = self.width.map(Length::units)
            && !(WIDTHS.0..=WIDTHS.1).contains(&width)
        {
            let millimetres = Short((width * 25.4 / 96.0 * 1e6).round() / 1e6);
            refuse!("--width of {millimetres} mm: give 20 mm to 2 m, 75px to 7600px");
        }
        within("--dpi", self.dpi, DPI, "")?;
        within("--font-size", self.font_size, FONT, " points")
    }
}

/// Pixels across that any viewer opens.
const MOST_ACROSS: f64 = 20_000.0;

impl PageArgs {
    /// The page of a picture of this kind.
    ///
    /// # Errors
    /// [`CliError::Request`] for more pixels than any viewer opens: known before anything is computed.
    pub(crate) fn page(&self, format: Format) -> Result<Page, CliError> {
        let purpose = match (self.style, self.width) {
            // Letters of a screen would fill a column.
            (None, Some(width)) if width.is_of_paper() => Purpose::Paper(width.units() * 25.4 / 96.0),
            (None | Some(StyleName::Screen), _) => Purpose::Screen,
            (Some(StyleName::Column), _) => Purpose::Column,
            (Some(StyleName::Page), _) => Purpose::Page,
            (Some(StyleName::Slide), _) => Purpose::Slide,
        };
        let page = purpose.page(format);
        let page = Page {
            width: self.width.map(Length::units).or(page.width),
            dpi: self.dpi.unwrap_or(page.dpi),
            font: self.font_size.map_or(page.font, |points| points * 96.0 / 72.0),
            letters: self.letters,
            ..page
        };
        let across = page.width.unwrap_or(0.0) * page.dpi / 96.0;
        ensure!(
            across <= MOST_ACROSS,
            "--width and --dpi make a picture {across:.0} pixels across, at most {MOST_ACROSS} are drawn: give less of one"
        );
        Ok(page)
    }

    /// Opens the file of a picture that was asked for with `flag`.
    ///
    /// # Errors
    /// [`CliError::Request`].
    pub(crate) fn open(&self, flag: &str, path: Option<&Path>) -> Result<Option<(Page, Output)>, CliError> {
        self.checked(path.is_some(), flag)?;
        let opened = vibrochain_plot::open(flag, path)?;
        opened.map(|(format, file)| Ok((self.page(format)?, file))).transpose()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_have_units() {
        let px = |text: &str| length(text).map(Length::units);
        assert!((px("25.4mm").unwrap() - 96.0).abs() < 1e-12 && (px("2.54 cm").unwrap() - 96.0).abs() < 1e-12);
        assert!(["1in", "72pt", "96px"].iter().all(|text| (px(text).unwrap() - 96.0).abs() < 1e-9));
        for wrong in ["86", "mm", "86 m", "infmm", "-", "1e400mm"] {
            assert!(px(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_width_on_paper_is_for_print() {
        let page = |width: &str, style: Option<StyleName>, dpi: Option<f64>| {
            let args = PageArgs { width: length(width).ok(), style, dpi, ..PageArgs::default() };
            assert!(args.words().contains(&format!("--width {width}")));
            args.page(Format::Png).unwrap()
        };
        let points = 96.0 / 72.0;
        for same in ["86mm", "8.6cm"] {
            let paper = page(same, None, None);
            assert_eq!((paper.dpi, (paper.width.unwrap() * paper.dpi / 96.0).round()), (300.0, 1016.0));
            assert_eq!(paper.font, 8.0 * points);
        }
        let screen = page("325px", None, None);
        assert_eq!((screen.dpi, screen.width), (96.0, Some(325.0)));
        // What is asked for holds.
        assert_eq!(page("86mm", None, Some(72.0)).dpi, 72.0);
        assert_eq!(page("86mm", Some(StyleName::Screen), None).dpi, 96.0);
        assert_eq!(page("80mm", Some(StyleName::Column), None).dpi, 600.0);
    }

    #[test]
    fn what_is_not_drawn_has_no_width() {
        let wide = PageArgs { width: length("300px").ok(), ..PageArgs::default() };
        assert!(wide.checked(true, "--plot").is_ok());
        assert!(wide.checked(false, "--plot").unwrap_err().to_string().contains("--width is of pictures"));
        let wrong = PageArgs { dpi: Some(1e9), ..PageArgs::default() };
        assert!(wrong.checked(true, "--plot").unwrap_err().to_string().contains("36 to 2400"));
        assert!(PageArgs::default().checked(false, "--plot").is_ok());
    }
}
