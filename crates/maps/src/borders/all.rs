//! All borders of a scene: of each part by itself, then what is left in the faces between the borders of all.

use std::collections::HashMap;

use super::asked::{BorderRequest, Stage};
use super::border::Borders;
use super::grid::Grid;
use super::known::Known;
use super::part::{ClassProbe, Part, parts};
use super::search::Search;
use crate::cell::Class;
use crate::error::MapError;
use crate::regions::{Faces, Regions, Subdivision, Window};
use crate::scene::{Scene, Values};

/// Places that are asked at most: a hundred bytes each.
const MOST_ASKED: usize = 10_000_000;

/// How often the window is cut by all borders to look for what is left, and changes in it at most.
const CUTS: usize = 16;
const MOST_CHANGES: usize = 256;

impl Borders {
    /// The window in which the borders of a scene are followed, and its ends along x and y.
    ///
    /// # Errors
    /// [`MapError::Request`] for a scene without a plane of two equally spaced ranges.
    pub fn window(scene: &Scene) -> Result<(Window, [[f64; 2]; 2]), MapError> {
        let window = Window::of(scene)?;
        let mut ends = [[0.0; 2]; 2];
        for (end, axis) in ends.iter_mut().zip(&scene.axes) {
            let Values::Linear { from, to, .. } = axis.values else {
                refuse!("borders are followed along equally spaced axes: give both by from, to and points");
            };
            *end = [from, to];
        }
        Ok((window, ends))
    }

    /// All borders in the window of a scene, and its regions between them; what lives where no place could tell is `None`. Threads are those of the pool of `rayon` that this is called in.
    ///
    /// # Errors
    /// [`MapError::Request`] for a scene without a plane of two equally spaced ranges, a tolerance out of range.
    pub fn of_scene(scene: &Scene, asked: &BorderRequest<'_>) -> Result<(Self, Regions<Option<Class>>), MapError> {
        let (window, ends) = Self::window(scene)?;
        if !(1e-9..=1e-3).contains(&asked.tolerance) {
            refuse!("a tolerance of {} is out of range: give a part of the window from 1e-9 to 0.001", asked.tolerance);
        }
        ensure!(asked.places <= MOST_ASKED, "{} places are out of range: give at most {MOST_ASKED}", asked.places);
        let parameters = [scene.axes[0].parameter, scene.axes[1].parameter];
        let plane = vibrochain_floquet::Window { from: [ends[0][0], ends[1][0]], to: [ends[0][1], ends[1][1]] };
        let empty = Self {
            parameters,
            borders: Vec::new(),
            unexplained: Vec::new(),
            unresolved: Vec::new(),
            places: 0,
            interrupted: false,
        };
        let parts = parts(&scene.task);
        let search = |part| {
            let grid = Grid::new([0, 0], Vec::new());
            let (asked, found, known) = (*asked, empty.clone(), Known::default());
            Search { scene, asked, window, parameters, plane, part, known, grid, found }
        };
        let mut searches: Vec<Search<'_>> = parts.iter().map(search).collect();
        for search in &mut searches {
            search.look();
            search.stripes();
            search.changes();
        }
        let faces = faces(&mut searches)?;
        let mut all = empty;
        for mut search in searches {
            search.finish();
            let Self { borders, unexplained, unresolved, places, interrupted, .. } = search.found;
            all.borders.extend(borders);
            all.unexplained.extend(unexplained);
            all.unresolved.extend(unresolved);
            all.places += places;
            all.interrupted |= interrupted;
        }
        Ok((all, faces.seen(|classes| merged(classes)).regions()))
    }
}

/// What lives in the faces between the borders of all parts, after what was left in them is found.
fn faces(searches: &mut [Search<'_>]) -> Result<Faces<Vec<Option<Class>>>, MapError> {
    let mut known = HashMap::new();
    let Search { asked, scene, window, .. } = searches[0];
    let mut cut = 0;
    loop {
        (asked.told)("", Stage::Faces, cut, CUTS);
        let lines: Vec<_> = searches.iter().flat_map(|search| search.found.lines()).collect();
        let parts: Vec<&Part> = searches.iter().map(|search| search.part).collect();
        let classes = |probe: &mut ClassProbe<'_>, point: [f64; 2]| -> Vec<Option<Class>> {
            if asked.stop.is_raised() {
                return vec![None];
            }
            let place = window.part(point);
            parts.iter().map(|part| probe.class(part, place)).collect()
        };
        let is_none = |classes: &Vec<Option<Class>>| classes.contains(&None);
        let subdivision = Subdivision::new(window, &lines, asked.tolerance)?;
        let faces = subdivision.asked(
            asked.places,
            || ClassProbe::new(scene, window, asked.stop),
            classes,
            is_none,
            &mut known,
        );
        let changes = faces.unexplained.iter().flat_map(|face| &face.changes);
        let mut changes: Vec<[[f64; 2]; 2]> = changes.map(|ends| ends.map(|point| window.part(point))).collect();
        // Others first another time.
        let count = changes.len().max(1);
        changes.rotate_left(cut * MOST_CHANGES % count);
        changes.truncate(MOST_CHANGES);
        let mut grown = false;
        for search in searches.iter_mut() {
            grown |= cut < CUTS && !search.stopped() && search.explain_all(&changes);
        }
        if !grown {
            return Ok(faces);
        }
        cut += 1;
    }
}

/// What lives at a place of all that does: as a cell has it.
fn merged(classes: &[Option<Class>]) -> Option<Class> {
    let stable = |class: &Class| matches!(class, Class::StableDouble | Class::StableSingle | Class::StableWord);
    let best = |some: &mut dyn Iterator<Item = Class>| some.filter(|class| *class != Class::None).min();
    let all = || classes.iter().copied().flatten();
    match best(&mut all().filter(stable)) {
        Some(class) => Some(class),
        None if classes.contains(&None) => None,
        None => Some(best(&mut all()).unwrap_or(Class::None)),
    }
}
