//! Shapes of points: told apart without colour.

use std::f64::consts::TAU;

use crate::backend::drawing::{Drawing, Fill, Line, Place, Rgb, Shape};

/// Draws marker number `index`, so many times as large as it is: circle, square, triangle, diamond, triangle on its head, star, cross.
pub(crate) fn draw(drawing: &mut Drawing, index: usize, at: Place, times: f64, fill: Option<Rgb>, line: Option<Line>) {
    if index.is_multiple_of(7) {
        drawing.circle(at, 5.0 * times, fill, line);
        return;
    }
    let place = |[x, y]: Place| [at[0] + times * x, at[1] + times * y];
    let outlines = vec![corners(index).into_iter().map(place).collect()];
    drawing.shape(Shape { outlines, closed: true, fill: fill.map(Fill::Colour), line, title: String::new() });
}

/// Corners about the point; of the circle, none.
fn corners(index: usize) -> Vec<Place> {
    match index % 7 {
        0 => Vec::new(),
        1 => vec![[-4.4, -4.4], [4.4, -4.4], [4.4, 4.4], [-4.4, 4.4]],
        2 => vec![[0.0, -6.0], [5.8, 4.2], [-5.8, 4.2]],
        3 => vec![[0.0, -6.2], [6.2, 0.0], [0.0, 6.2], [-6.2, 0.0]],
        4 => vec![[0.0, 6.0], [5.8, -4.2], [-5.8, -4.2]],
        6 => {
            let (arm, half) = (6.0, 1.8);
            let quarter = [[half, -half], [half, -arm], [-half, -arm]];
            (0..4).flat_map(|turn| quarter.map(|[x, y]| [[x, y], [y, -x], [-x, -y], [-y, x]][turn])).collect()
        }
        _ => (0..10)
            .map(|i| (if i % 2 == 0 { 7.0 } else { 3.0 }, TAU * (f64::from(i) / 10.0 - 0.25)))
            .map(|(radius, angle)| [radius * angle.cos(), radius * angle.sin()])
            .collect(),
    }
}
