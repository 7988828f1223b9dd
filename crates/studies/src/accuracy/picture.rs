//! Error against run time: one panel a case, one line and marker a method, both axes logarithmic.

use vibrochain_plot::{Curves, Format, Mark, Pane, PlotError, Scale, Series, Stroke, curves_picture};

/// What is drawn.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct WorkPrecision {
    /// Line above the panels.
    pub title: String,
    /// What the errors are.
    pub error: String,
    /// Names of the methods.
    pub methods: Vec<String>,
    /// One panel a case.
    pub panels: Vec<WorkPrecisionPanel>,
}

/// One case.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct WorkPrecisionPanel {
    /// Its name.
    pub caption: String,
    /// For each method, seconds and error of its settings. An error of 0 is drawn below all others.
    pub series: Vec<Vec<(f64, f64)>>,
}

const PANEL: (u32, u32) = (430, 380);
/// Panels side by side.
const COLUMNS: usize = 3;

/// The bytes of the picture.
///
/// # Errors
/// [`PlotError`].
pub(super) fn work_precision_picture(picture: &WorkPrecision, format: Format) -> Result<Vec<u8>, PlotError> {
    let points = || picture.panels.iter().flat_map(|panel| panel.series.iter().flatten());
    let positive = points().map(|point| point.1).filter(|error| *error > 0.0);
    // What is exact has no logarithm: it stands a decade below all others.
    let exact = 10f64.powf((positive.fold(f64::INFINITY, f64::min).log10() - 1.0).floor().clamp(-300.0, 300.0));
    let place = |&(seconds, error): &(f64, f64)| (seconds.log10(), if error > 0.0 { error } else { exact });
    let series = |(method, points): (usize, &Vec<(f64, f64)>)| Series {
        name: picture.methods.get(method).cloned().unwrap_or_default(),
        colour: method,
        stroke: Stroke::Solid(2),
        mark: Mark::Filled(method),
        points: points.iter().map(place).collect(),
    };
    let pane = |panel: &WorkPrecisionPanel| Pane {
        caption: panel.caption.clone(),
        x: "time of one evaluation, seconds".to_owned(),
        y: "error".to_owned(),
        x_log: true,
        scale: Scale::Logarithmic,
        series: panel.series.iter().enumerate().map(series).collect(),
        ..Pane::default()
    };
    let title = format!("{} (error: {})", picture.title, picture.error);
    let panes: Vec<Pane> = picture.panels.iter().map(pane).collect();
    // Panels share their axes: they can be compared.
    let picture =
        Curves { title, columns: panes.len().min(COLUMNS), panes, pane: PANEL, shared: true, ..Curves::default() };
    curves_picture(&picture, format)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_of_any_number_of_panels_are_drawn() {
        for panels in [1, 2, 7] {
            let panel = WorkPrecisionPanel {
                caption: "χ₂".to_owned(),
                series: vec![vec![(1e-6, 1e-3), (1e-3, 0.0)], vec![(1e-5, 1e-9)], Vec::new()],
            };
            let methods = vec!["a".to_owned(), "b".to_owned(), "c".to_owned()];
            let picture = WorkPrecision {
                title: "title".to_owned(),
                error: "of something".to_owned(),
                methods,
                panels: vec![panel; panels],
            };
            let svg = String::from_utf8(work_precision_picture(&picture, Format::Svg).unwrap()).unwrap();
            assert!(svg.contains("χ₂") && svg.contains("10⁻⁶") && svg.contains("error: of something"), "{panels}");
            assert!(work_precision_picture(&picture, Format::Png).unwrap().starts_with(b"\x89PNG"));
        }
    }
}
