//! Shapes of points: told apart without colour.

/// Corners of marker number `index` in pixels about its point: circle, square, triangle, diamond, triangle on its head,
/// star.
pub fn marker(index: usize) -> Vec<(i32, i32)> {
    match index % 6 {
        0 => (0..16).map(|i| f64::from(i) * std::f64::consts::TAU / 16.0).map(|t| polar(5.0, t)).collect(),
        1 => vec![(-4, -4), (4, -4), (4, 4), (-4, 4)],
        2 => vec![(0, -6), (6, 4), (-6, 4)],
        3 => vec![(0, -6), (6, 0), (0, 6), (-6, 0)],
        4 => vec![(0, 6), (6, -4), (-6, -4)],
        _ => (0..10)
            .map(|i| polar(if i % 2 == 0 { 7.0 } else { 3.0 }, std::f64::consts::TAU * (f64::from(i) / 10.0 - 0.25)))
            .collect(),
    }
}

fn polar(radius: f64, angle: f64) -> (i32, i32) {
    ((radius * angle.cos()).round() as i32, (radius * angle.sin()).round() as i32)
}
