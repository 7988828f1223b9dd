//! Regions of a window: areas, outlines, the class at any point.

use std::collections::HashMap;

use serde::{Deserialize, Serialize};

use crate::regions::boxes::{BoxTree, bounds};
use crate::regions::noding::{GRID, Node, place};
use crate::regions::smooth::Place;
use crate::regions::subdivision::{OUTSIDE, Subdivision};
use crate::regions::window::Window;

/// Faces joined where what lives there is the same on both sides.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Region<T> {
    /// What lives there.
    pub class: T,
    /// Its area, as a part of the window.
    pub share: f64,
    /// Its outlines in parts of the window, closed without the first point coming again: counterclockwise around it, clockwise
    /// around what it leaves out.
    pub outlines: Vec<Vec<[f64; 2]>>,
}

/// How much of the window a class takes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Area<T> {
    /// What lives there.
    pub class: T,
    /// The area, as a part of the window.
    pub share: f64,
    /// How far it may be from the true one.
    pub error: f64,
}

/// A face in which points differ: a border is missing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Unexplained<T> {
    /// Its area, as a part of the window.
    pub share: f64,
    /// The points looked at, in units of the axes, and what lives there: at least two different classes.
    pub points: Vec<([f64; 2], T)>,
    /// Pairs of places of it, next to each other, between which what lives there changes: some of them.
    pub changes: Vec<[[f64; 2]; 2]>,
}

/// A part of a border.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// Its points in parts of the window.
    pub points: Vec<[f64; 2]>,
    /// Whether what lives on its two sides differs.
    pub separates: bool,
}

/// A piece of a border between two regions.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct Wall {
    ends: [Node; 2],
    /// Regions on its left and on its right.
    regions: [u32; 2],
}

/// The regions of a window.
///
/// ```
/// use vibrochain_maps::regions::{Subdivision, Window};
/// let angle = |i: i32| f64::from(i % 360).to_radians();
/// let circle = (0..=360).map(|i| [2.0 + angle(i).cos(), 2.0 + angle(i).sin()]).collect();
/// let subdivision = Subdivision::new(Window::new([0.0, 4.0], [0.0, 4.0])?, &[circle], 1e-6)?;
/// let inside = |[x, y]: [f64; 2]| (x - 2.0).hypot(y - 2.0) < 1.0;
/// let regions = subdivision.classified(100, || (), |(), point| inside(point));
/// assert_eq!((regions.regions().len(), regions.at([2.5, 2.5])), (2, Some(&true)));
/// let area = regions.areas().iter().find(|area| area.class).unwrap();
/// let whole = regions.window().area();
/// assert!((area.share * whole - std::f64::consts::PI).abs() < area.error * whole);
/// # Ok::<(), vibrochain_maps::error::MapError>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Regions<T> {
    window: Window,
    regions: Vec<Region<T>>,
    areas: Vec<Area<T>>,
    unexplained: Vec<Unexplained<T>>,
    closed: Vec<([f64; 2], f64)>,
    borders: Vec<Vec<Part>>,
    walls: Vec<Wall>,
    tree: BoxTree,
}

impl<T> Regions<T> {
    /// All regions, the largest first.
    pub fn regions(&self) -> &[Region<T>] {
        &self.regions
    }

    /// The area of each class, the largest first. A border lies within the tolerance of where it should, so that each unit of its
    /// length may hide so much on either side; what a face without explanation holds is not known, and no more what one does that is
    /// too thin to be asked. That no other border is missing is for the points to say that were looked at: of `n` points over the
    /// window, spread by area, none falls into a piece of share `s` with a chance of about e^(−ns).
    pub fn areas(&self) -> &[Area<T>] {
        &self.areas
    }

    /// The faces in which points differ, the largest first.
    pub fn unexplained(&self) -> &[Unexplained<T>] {
        &self.unexplained
    }

    /// Gaps that were closed between ends of borders: where, and how wide, as a part of the window.
    pub fn closed(&self) -> &[([f64; 2], f64)] {
        &self.closed
    }

    /// The parts of border number `border` inside the window, as it is drawn.
    pub fn border(&self, border: usize) -> &[Part] {
        &self.borders[border]
    }

    /// Number of borders.
    pub fn borders(&self) -> usize {
        self.borders.len()
    }

    /// The window.
    pub fn window(&self) -> &Window {
        &self.window
    }

    /// The same with other words for what lives there. Classes that `name` does not tell apart stay regions of their own.
    #[must_use]
    pub fn named<U>(&self, name: impl Fn(&T) -> U) -> Regions<U> {
        let region = |region: &Region<T>| Region {
            class: name(&region.class),
            share: region.share,
            outlines: region.outlines.clone(),
        };
        let area = |area: &Area<T>| Area { class: name(&area.class), share: area.share, error: area.error };
        let face = |face: &Unexplained<T>| Unexplained {
            share: face.share,
            points: face.points.iter().map(|(point, class)| (*point, name(class))).collect(),
            changes: face.changes.clone(),
        };
        Regions {
            window: self.window,
            regions: self.regions.iter().map(region).collect(),
            areas: self.areas.iter().map(area).collect(),
            unexplained: self.unexplained.iter().map(face).collect(),
            closed: self.closed.clone(),
            borders: self.borders.clone(),
            walls: self.walls.clone(),
            tree: self.tree.clone(),
        }
    }

    /// What lives at a point, in units of the axes; nearer to a border than the tolerance, it may be what lives on the other side.
    /// `None` outside the window.
    pub fn at(&self, point: [f64; 2]) -> Option<&T> {
        self.region(point).map(|region| &region.class)
    }

    /// The region at a point.
    pub fn region(&self, point: [f64; 2]) -> Option<&Region<T>> {
        let [x, y] = self.window.part(point);
        if !((0.0..=1.0).contains(&x) && (0.0..=1.0).contains(&y)) {
            return None;
        }
        // Half a step off the edges on the right and above, which a line to the right could not meet behind the point.
        let [x, y] = [x, y].map(|part| (part * GRID as f64).min(GRID as f64 - 0.5));
        let mut nearest: Option<([f64; 2], u32)> = None;
        self.tree.meeting([x, y, f64::INFINITY, y], |i| {
            let Wall { ends: [a, b], regions: [left, right] } = self.walls[i];
            let rises = b[1] > a[1];
            let ([low, high], region) = if rises { ([a, b], left) } else { ([b, a], right) };
            if low[1] as f64 <= y && y < high[1] as f64 {
                let slope = (high[0] - low[0]) as f64 / (high[1] - low[1]) as f64;
                // Of walls from one node the first is the one that leans to the left.
                let met = [low[0] as f64 + (y - low[1] as f64) * slope, slope];
                if met[0] > x && nearest.is_none_or(|(other, _)| met < other) {
                    nearest = Some((met, region));
                }
            }
        });
        nearest.and_then(|(_, region)| self.regions.get(region as usize))
    }
}

impl<T: Clone> Regions<T> {
    /// The regions of faces with these classes, by number.
    pub(crate) fn new(
        cut: &Subdivision,
        classes: &[T],
        class_of: &[usize],
        mut unexplained: Vec<Unexplained<T>>,
        closed: Vec<([f64; 2], f64)>,
    ) -> Self {
        let region_of = joined(cut, class_of);
        let mut regions: Vec<(f64, usize)> = Vec::new();
        for (face, &region) in region_of.iter().enumerate() {
            regions.resize(regions.len().max(region as usize + 1), (0.0, class_of[face]));
            regions[region as usize].0 += cut.faces[face].share;
            regions[region as usize].1 = class_of[face];
        }
        let mut order: Vec<usize> = (0..regions.len()).collect();
        order.sort_by(|&i, &j| regions[j].0.total_cmp(&regions[i].0));
        let mut rank = vec![0; order.len()];
        for (place, &region) in order.iter().enumerate() {
            rank[region] = place as u32;
        }
        // The region on the left of a side.
        let left = |side: u32| match cut.face_of[side as usize] {
            OUTSIDE => OUTSIDE,
            face => rank[region_of[face as usize] as usize],
        };
        let twin = |side: u32| cut.sides[side as usize].twin;
        let mut outlines = outlines(cut, order.len(), left);
        let class = |region: usize| regions[order[region]].1;
        let named = (0..order.len()).map(|region| Region {
            class: classes[class(region)].clone(),
            share: regions[order[region]].0,
            outlines: std::mem::take(&mut outlines[region]),
        });

        let mut shares = vec![0.0; classes.len()];
        let mut lengths = vec![0.0; classes.len()];
        for &(share, class) in &regions {
            shares[class] += share;
        }
        for side in 0..cut.sides.len() as u32 {
            let (own, other) = (left(side), left(twin(side)));
            if own != other && own != OUTSIDE && other != OUTSIDE {
                lengths[class(own as usize)] += cut.length(side);
            }
        }
        let unknown: f64 = unexplained.iter().map(|face| face.share).sum::<f64>()
            + cut.faces.iter().filter(|face| face.thin).map(|face| face.share).sum::<f64>();
        // Corners were rounded to the grid.
        let astray = cut.tolerance + 1.0 / GRID as f64;
        let area = |number: usize| Area {
            class: classes[number].clone(),
            share: shares[number],
            error: unknown + astray * lengths[number],
        };
        let mut areas: Vec<Area<T>> = (0..classes.len()).map(area).collect();
        areas.sort_by(|one, two| two.share.total_cmp(&one.share));
        unexplained.sort_by(|one, two| two.share.total_cmp(&one.share));

        let pairs = (0..cut.sides.len() as u32).filter(|&side| cut.sides[side as usize].border);
        let pairs: HashMap<[u32; 2], u32> =
            pairs.map(|side| ([cut.sides[side as usize].from, cut.sides[twin(side) as usize].from], side)).collect();
        let regions_of = |pair: &[u32]| pairs.get(&[pair[0], pair[1]]).map(|&side| [left(side), left(twin(side))]);
        // In the order of the borders, in which pieces follow one another in space.
        let mut walls = Vec::new();
        for pair in cut.paths.iter().flatten().flat_map(|path| path.windows(2)) {
            if let Some(regions) = regions_of(pair).filter(|[left, right]| left != right) {
                walls.push(Wall { ends: [pair[0], pair[1]].map(|node| cut.nodes[node as usize]), regions });
            }
        }
        let real = |[x, y]: Node| [x as f64, y as f64];
        let tree = BoxTree::new(walls.iter().map(|wall| bounds(wall.ends.map(real), 0.0)).collect());
        let at = |node: u32| place(cut.nodes[node as usize]);
        let parts = |path: &Vec<u32>| {
            let separates = |pair: &[u32]| regions_of(pair).is_some_and(|[left, right]| left != right);
            let mut parts: Vec<Part> = Vec::new();
            for pair in path.windows(2) {
                match parts.last_mut() {
                    Some(part) if part.separates == separates(pair) => part.points.push(at(pair[1])),
                    _ => parts.push(Part { points: vec![at(pair[0]), at(pair[1])], separates: separates(pair) }),
                }
            }
            parts
        };
        // The last one is the edge of the window.
        let borders = cut.paths.iter().take(cut.paths.len() - 1).map(|paths| paths.iter().flat_map(parts).collect());
        let borders = borders.collect();
        Self { window: cut.window, regions: named.collect(), areas, unexplained, closed, borders, walls, tree }
    }
}

/// The region of each face by number: faces of the same class with a border in common are one.
fn joined(cut: &Subdivision, class_of: &[usize]) -> Vec<u32> {
    let mut parent: Vec<u32> = (0..class_of.len() as u32).collect();
    let root = |parent: &mut Vec<u32>, mut face: u32| {
        while parent[face as usize] != face {
            // Halving the way for the next one.
            parent[face as usize] = parent[parent[face as usize] as usize];
            face = parent[face as usize];
        }
        face
    };
    for (i, side) in cut.sides.iter().enumerate().filter(|(_, side)| side.border) {
        let faces = [cut.face_of[i], cut.face_of[side.twin as usize]];
        if !faces.contains(&OUTSIDE) && class_of[faces[0] as usize] == class_of[faces[1] as usize] {
            let [one, two] = faces.map(|face| root(&mut parent, face));
            parent[one.max(two) as usize] = one.min(two);
        }
    }
    let mut numbers = HashMap::new();
    (0..class_of.len() as u32)
        .map(|face| {
            let next = numbers.len() as u32;
            *numbers.entry(root(&mut parent, face)).or_insert(next)
        })
        .collect()
}

/// The outlines of all regions: along sides with the region on the left and another one on the right.
fn outlines(cut: &Subdivision, regions: usize, left: impl Fn(u32) -> u32) -> Vec<Vec<Vec<Place>>> {
    let bounds = |side: u32| left(side) != left(cut.sides[side as usize].twin);
    let mut outlines = vec![Vec::new(); regions];
    let mut seen = vec![false; cut.sides.len()];
    for first in 0..cut.sides.len() as u32 {
        if seen[first as usize] || left(first) == OUTSIDE || !bounds(first) {
            continue;
        }
        let (mut outline, mut side) = (Vec::new(), first);
        while !seen[side as usize] {
            seen[side as usize] = true;
            outline.push(place(cut.nodes[cut.sides[side as usize].from as usize]));
            // On around the next corner, through the triangles of the region.
            side = cut.sides[side as usize].next;
            while !bounds(side) {
                side = cut.sides[cut.sides[side as usize].twin as usize].next;
            }
        }
        outlines[left(first) as usize].push(outline);
    }
    outlines
}
