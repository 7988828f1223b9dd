//! A slice of a sweep: the cells at which some of its axes have one value each, which are the cells of a scene with fewer axes.

use crate::error::MapError;
use crate::scene::{Axis, Scene};
use vibrochain_lattice::Parameter;

/// A value given in digits is that of an axis if it is no farther from it than this part of the axis' largest value: some units in
/// the last place, which an axis of steps rounds and people do not write.
const SAME: f64 = 16.0 * f64::EPSILON;

/// The cells of a sweep at which some axes are fixed.
///
/// ```
/// use std::path::Path;
/// use vibrochain_lattice::Parameter;
/// use vibrochain_maps::scene::{Scene, Slice};
/// let scene = Scene::parse(Path::new("map.toml"), r#"
///     [model]
///     sites = 21
///     gamma1 = 0.2
///     asymmetry = 0.4
///     [sweep]
///     x = { parameter = "omega", from = 1.0, to = 2.0, points = 11 }
///     y = { parameter = "gamma2", values = [0.1, 0.2, 0.3] }
///     [compute]
///     families = ["double-sided"]
/// "#)?;
/// let slice = Slice::of(&scene, &[(Parameter::Gamma2, 0.2)])?;
/// assert_eq!(slice.scene().cells(), 11);
/// assert_eq!((slice.cell(10), slice.cell(11), slice.cell(21), slice.cell(22)), (None, Some(0), Some(10), None));
/// # Ok::<(), vibrochain_maps::error::MapError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Slice {
    scene: Scene,
    /// Of each axis of the whole, the fastest first: its points, and the number of the value it is fixed at.
    axes: Vec<(u64, Option<u64>)>,
}

impl Slice {
    /// Where each of these axes has the value given for it; all cells if none is given.
    ///
    /// # Errors
    /// [`MapError::Request`] for a parameter that is no axis or is given twice, and for a value that is none of its axis: the
    /// message names those next to it.
    pub fn of(scene: &Scene, fixed: &[(Parameter, f64)]) -> Result<Self, MapError> {
        let mut sliced = scene.clone();
        let mut axes: Vec<(u64, Option<u64>)> = scene.axes.iter().map(|axis| (axis.points() as u64, None)).collect();
        for &(parameter, value) in fixed {
            let name = parameter.name();
            let Some(number) = scene.axes.iter().position(|axis| axis.parameter == parameter) else {
                let known = scene.axis_names();
                refuse!("{name} is no axis of the scene: give one of {known}");
            };
            ensure!(axes[number].1.is_none(), "{name} is given twice: give each axis one value");
            let at = place(&scene.axes[number], value)?;
            axes[number].1 = Some(at as u64);
            sliced.base = sliced.base.with(parameter, scene.axes[number].value(at));
        }
        sliced.axes.retain(|axis| fixed.iter().all(|(parameter, _)| *parameter != axis.parameter));
        Ok(Self { scene: sliced, axes })
    }

    /// The scene of the axes that are left; the others have become a part of its model.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The number in the slice of cell number `cell` of the whole, if it lies in it.
    #[must_use]
    pub fn cell(&self, cell: u64) -> Option<u64> {
        let (mut rest, mut stride, mut number) = (cell, 1, 0);
        for &(points, fixed) in &self.axes {
            let at = rest % points;
            rest /= points;
            match fixed {
                Some(fixed) if fixed != at => return None,
                Some(_) => {}
                None => {
                    number += stride * at;
                    stride *= points;
                }
            }
        }
        Some(number)
    }
}

/// Which of an axis' values this is.
fn place(axis: &Axis, value: f64) -> Result<usize, MapError> {
    let [least, most] = axis.limits();
    let near = SAME * least.abs().max(most.abs());
    let values = || (0..axis.points()).map(|i| axis.value(i));
    let far = |other: f64| (other - value).abs();
    let nearest = values().enumerate().min_by(|one, other| far(one.1).total_cmp(&far(other.1)));
    if let Some((i, _)) = nearest.filter(|(_, nearest)| far(*nearest) <= near) {
        return Ok(i);
    }
    let below = values().filter(|other| *other < value).reduce(f64::max);
    let above = values().filter(|other| *other > value).reduce(f64::min);
    let name = axis.parameter.name();
    let next: Vec<String> = [below, above].into_iter().flatten().map(|value| value.to_string()).collect();
    let message = match next.as_slice() {
        [] => format!("{name} = {value} is none of its {} values: give one of them", axis.points()),
        next => {
            let next = next.join(" and ");
            format!("{name} = {value} is none of its {} values: next to it are {next}", axis.points())
        }
    };
    Err(MapError::Request(message))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn scene() -> Scene {
        let text = "[model]\nsites = 3\ngamma1 = 0.2\nrestitution = 0.9\n[sweep]\n\
                    x = { parameter = \"omega\", from = 0.1, to = 0.7, points = 7 }\n\
                    y = { parameter = \"gamma2\", from = 0.001, to = 1, points = 4, spacing = \"log\" }\n\
                    axes = [{ parameter = \"asymmetry\", values = [0.3, 0, 0.9] }, { parameter = \"amplitude\", values = [0.2] }]\n\
                    [compute]\nfamilies = [\"double-sided\"]\n";
        Scene::parse(Path::new("scene.toml"), text).unwrap()
    }

    /// Against the points of the cells themselves.
    #[test]
    fn the_cells_of_a_slice_are_those_at_its_value_in_the_order_of_its_scene() {
        let scene = scene();
        let all = [
            (Parameter::Omega, scene.axes[0].value(4)),
            (Parameter::Gamma2, scene.axes[1].value(2)),
            (Parameter::Asymmetry, 0.0),
            (Parameter::Amplitude, 0.2),
        ];
        let mut seen = 0;
        for chosen in 0..16_u32 {
            let fixed: Vec<_> = (0..4).filter(|bit| chosen >> bit & 1 == 1).map(|bit| all[bit]).collect();
            let slice = Slice::of(&scene, &fixed).unwrap();
            let inside = |cell: &u64| fixed.iter().all(|(which, value)| scene.point(*cell).get(*which) == *value);
            let expected: Vec<u64> = (0..scene.cells()).filter(inside).collect();
            assert_eq!(slice.scene().cells(), expected.len() as u64);
            let mut numbers = Vec::new();
            for cell in 0..scene.cells() {
                let Some(number) = slice.cell(cell) else { continue };
                assert_eq!(slice.scene().point(number), scene.point(cell));
                numbers.push(number);
                seen += 1;
            }
            assert!(numbers.iter().copied().eq(0..expected.len() as u64), "{chosen}: {numbers:?}");
        }
        assert!(seen > 3 * 7 * 4);
    }

    #[test]
    fn digits_of_people_meet_the_values_of_steps() {
        let scene = scene();
        // The third root of 1000 is not 10 in all digits.
        assert!(scene.axes[1].value(1) != 0.01);
        for fixed in [(Parameter::Omega, 0.3), (Parameter::Gamma2, 0.01), (Parameter::Asymmetry, 0.0)] {
            let slice = Slice::of(&scene, &[fixed]).unwrap();
            assert!((slice.scene().base.get(fixed.0) - fixed.1).abs() < 1e-15);
        }
    }

    #[test]
    fn what_is_no_value_is_refused_by_those_next_to_it() {
        let refused = |fixed: &[(Parameter, f64)]| Slice::of(&scene(), fixed).unwrap_err().to_string();
        assert_eq!(
            refused(&[(Parameter::Omega, 0.35)]),
            format!("omega = 0.35 is none of its 7 values: next to it are {} and 0.4", scene().axes[0].value(2))
        );
        let told = "asymmetry = 0.1 is none of its 3 values: next to it are 0 and 0.3";
        assert_eq!(refused(&[(Parameter::Asymmetry, 0.1)]), told);
        let told = "omega = 2 is none of its 7 values: next to it are 0.7";
        assert_eq!(refused(&[(Parameter::Omega, 2.0)]), told);
        assert_eq!(refused(&[(Parameter::Omega, f64::NAN)]), "omega = NaN is none of its 7 values: give one of them");
        let told = "gamma1 is no axis of the scene: give one of omega, gamma2, asymmetry and amplitude";
        assert_eq!(refused(&[(Parameter::Gamma1, 0.2)]), told);
        let twice = [(Parameter::Amplitude, 0.2), (Parameter::Amplitude, 0.2)];
        assert_eq!(refused(&twice), "amplitude is given twice: give each axis one value");
    }
}
