//! The window of a map: parameters as parts of the unit square, and back.

use serde::{Deserialize, Serialize};

use crate::error::MapError;
use crate::scene::{Axis, Scene, Values};

/// One side of a window, as the picture of a map shows it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
enum Side {
    Linear {
        from: f64,
        to: f64,
    },
    /// Ends by their logarithms.
    Logarithmic {
        from: f64,
        to: f64,
    },
}

impl Side {
    fn of(axis: &Axis) -> Option<Self> {
        match axis.values {
            Values::Linear { from, to, .. } => Some(Self::Linear { from, to }),
            Values::Logarithmic { from, to, .. } => Some(Self::Logarithmic { from: from.ln(), to: to.ln() }),
            Values::List(_) => None,
        }
    }

    fn part(self, value: f64) -> f64 {
        match self {
            Self::Linear { from, to } => (value - from) / (to - from),
            Self::Logarithmic { from, to } => (value.ln() - from) / (to - from),
        }
    }

    fn value(self, part: f64) -> f64 {
        // From the nearer end, so that both are met.
        let between = |from: f64, to: f64| {
            if part < 0.5 { from + part * (to - from) } else { to - (1.0 - part) * (to - from) }
        };
        match self {
            Self::Linear { from, to } => between(from, to),
            Self::Logarithmic { from, to } => between(from, to).exp(),
        }
    }
}

/// The rectangle of parameters that a map shows. Lengths and areas in it are parts of the window as it is drawn: on a logarithmic
/// axis those of the logarithm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Window {
    sides: [Side; 2],
}

impl Window {
    /// Between two values along x and two along y.
    ///
    /// # Errors
    /// [`MapError::Request`] for ends that are not finite, or not in rising order.
    pub fn new(x: [f64; 2], y: [f64; 2]) -> Result<Self, MapError> {
        for [from, to] in [x, y] {
            if !(from < to && (to - from).is_finite()) {
                refuse!("a window from {from} to {to} holds nothing: give finite ends, the smaller one first");
            }
        }
        Ok(Self { sides: [x, y].map(|[from, to]| Side::Linear { from, to }) })
    }

    /// The window of a scene.
    ///
    /// # Errors
    /// [`MapError::Request`] unless the scene has two axes, neither of them a list of values.
    pub fn of(scene: &Scene) -> Result<Self, MapError> {
        let Some(plane) = scene.plane() else {
            let axes = match scene.axes.len() {
                1 => "one axis".to_owned(),
                axes => format!("{axes} axes"),
            };
            refuse!("borders and regions lie in a plane, but the scene has {axes}: give x and y, and none besides");
        };
        let [Some(x), Some(y)] = plane.map(Side::of) else {
            refuse!("regions lie between two ends of each axis, but one has a list of values: give from and to");
        };
        Ok(Self { sides: [x, y] })
    }

    /// Where a point lies, in parts of the window: between 0 and 1 inside.
    pub fn part(&self, point: [f64; 2]) -> [f64; 2] {
        [self.sides[0].part(point[0]), self.sides[1].part(point[1])]
    }

    /// The point at given parts of the window.
    pub fn point(&self, part: [f64; 2]) -> [f64; 2] {
        [self.sides[0].value(part[0]), self.sides[1].value(part[1])]
    }

    /// Its area in units of its axes, of their natural logarithms where they are logarithmic.
    pub fn area(&self) -> f64 {
        self.sides
            .map(|side| match side {
                Side::Linear { from, to } | Side::Logarithmic { from, to } => to - from,
            })
            .iter()
            .product()
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn scene(x: &str, y: &str, more: &str) -> Scene {
        let text = format!(
            "[model]\nsites = 3\ngamma1 = 0.2\n{}[sweep]\nx = {{ parameter = \"omega\", {x} }}\n\
             y = {{ parameter = \"gamma2\", {y} }}\n{more}[compute]\nfamilies = [\"double-sided\"]\n",
            if more.is_empty() { "asymmetry = 0.4\n" } else { "" }
        );
        Scene::parse(Path::new("scene.toml"), &text).unwrap()
    }

    #[test]
    fn ends_are_met_and_parts_come_back() {
        let window = Window::of(&scene(
            "from = 0.4, to = 3, points = 3",
            "from = 1e-3, to = 10, points = 4, spacing = \"log\"",
            "",
        ));
        let window = window.unwrap();
        assert_eq!(window.point([0.0, 0.5])[0], 0.4);
        assert_eq!(window.point([1.0, 0.5])[0], 3.0);
        assert!((window.point([0.5, 0.5])[1] - 0.1).abs() < 1e-15);
        assert!((window.area() - 2.6 * 1e4_f64.ln()).abs() < 1e-12);
        for i in 0..=20 {
            let part = [f64::from(i) / 20.0, f64::from(20 - i) / 20.0];
            let again = window.part(window.point(part));
            assert!((0..2).all(|k| (again[k] - part[k]).abs() < 1e-14), "{again:?} {part:?}");
        }
    }

    #[test]
    fn what_is_no_window_is_refused() {
        let lists = scene("values = [1, 2]", "from = 0, to = 1, points = 2", "");
        assert!(Window::of(&lists).unwrap_err().to_string().contains("list of values"));
        let axes = "axes = [{ parameter = \"asymmetry\", from = 0.1, to = 0.2, points = 2 }]\n";
        let three = scene("from = 1, to = 2, points = 2", "from = 0, to = 1, points = 2", axes);
        assert!(Window::of(&three).unwrap_err().to_string().contains("3 axes"));
        for x in [[1.0, 1.0], [2.0, 1.0], [0.0, f64::NAN], [-1e308, 1e308], [0.0, f64::INFINITY]] {
            assert!(Window::new(x, [0.0, 1.0]).is_err() && Window::new([0.0, 1.0], x).is_err(), "{x:?}");
        }
    }
}
