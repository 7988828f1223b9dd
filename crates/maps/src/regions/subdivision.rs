//! The faces into which borders cut a window: triangles joined where no border lies between.

use crate::error::MapError;
use crate::regions::noding::{GRID, Node, node, noded};
use crate::regions::smooth::Place;
use crate::regions::strands::{clipped, strands};
use crate::regions::triangles::{Side, Triangle, triangulated};
use crate::regions::window::Window;

/// No face, no region: outside of the window.
pub(crate) const OUTSIDE: u32 = u32::MAX;

/// A face none of whose triangles holds a circle of this radius, in steps of the grid, cannot be told from the error of its
/// borders: it is about 3e-11 of the window wide.
pub(crate) const THIN: f64 = 16.0;

/// A window cut by borders. [`classified`](Self::classified) says what lives in its faces.
#[derive(Debug, Clone)]
pub struct Subdivision {
    pub(crate) window: Window,
    pub(crate) tolerance: f64,
    pub(crate) nodes: Vec<Node>,
    /// The parts of each border inside the window, by their nodes; the edge of the window last.
    pub(crate) paths: Vec<Vec<Vec<u32>>>,
    pub(crate) sides: Vec<Side>,
    /// The face on the left of each side.
    pub(crate) face_of: Vec<u32>,
    pub(crate) faces: Vec<Face>,
}

/// A face.
#[derive(Debug, Clone)]
pub(crate) struct Face {
    /// Its area, as a part of the window.
    pub(crate) share: f64,
    /// Its triangles, each by one of its sides.
    pub(crate) triangles: Vec<u32>,
    /// A point well inside: the centre of the largest circle in a triangle.
    pub(crate) inside: Place,
    /// That triangle.
    pub(crate) fattest: u32,
    /// Too thin to be told from the error of its borders.
    pub(crate) thin: bool,
}

impl Subdivision {
    /// Cuts a window by borders, each a curve through its points in the units of the axes, closed if the last point is the first.
    /// Between neighbours a curve is taken for a cubic where it is smooth, and drawn by chords that err by less than `tolerance`,
    /// a part of the window, as the points themselves should. Borders may cross, touch, run side by side, leave the window, end
    /// anywhere (less than 1e-5 of the window or four tolerances from another one they end on it), and separate nothing.
    ///
    /// # Errors
    /// [`MapError::Request`] for a point that is not finite, a tolerance out of range, borders that need millions of corners.
    pub fn new(window: Window, borders: &[Vec<[f64; 2]>], tolerance: f64) -> Result<Self, MapError> {
        if !(1e-12..=1e-2).contains(&tolerance) {
            refuse!("a tolerance of {tolerance} is out of range: give a part of the window from 1e-12 to 0.01");
        }
        let mut places = Vec::with_capacity(borders.len());
        for (number, border) in borders.iter().enumerate() {
            let own: Vec<Place> = border.iter().map(|&point| window.part(point)).collect();
            // Far outside, where nobody looks, chords are of no use either.
            if let Some(i) = own.iter().position(|place| !place.iter().all(|part| part.abs() < 1e6)) {
                let [x, y] = border[i];
                refuse!("point {i} of border {number}, ({x}, {y}), has no place: give points near the window");
            }
            places.push(own);
        }
        let inside = strands(&places, tolerance)?.into_iter().map(|strand| {
            let parts = clipped(&strand).into_iter();
            parts.map(|part| part.into_iter().map(node).collect()).collect::<Vec<Vec<Node>>>()
        });
        let inside: Vec<Vec<Vec<Node>>> = inside.collect();
        let cut = noded(&inside.concat())?;
        let mut paths = cut.paths.into_iter();
        let paths: Vec<Vec<Vec<u32>>> = inside.iter().map(|parts| paths.by_ref().take(parts.len()).collect()).collect();
        let mut pieces: Vec<[u32; 2]> = paths
            .iter()
            .flatten()
            .flat_map(|path| path.windows(2).map(|pair| [pair[0].min(pair[1]), pair[0].max(pair[1])]))
            .collect();
        pieces.sort_unstable();
        pieces.dedup();
        let sides = triangulated(&cut.nodes, &pieces)?;
        let (face_of, faces) = faces(&cut.nodes, &sides);
        Ok(Self { window, tolerance, nodes: cut.nodes, paths, sides, face_of, faces })
    }

    /// The window.
    pub fn window(&self) -> &Window {
        &self.window
    }

    /// Number of faces.
    pub fn faces(&self) -> usize {
        self.faces.len()
    }

    /// Joins triangles once more, after borders were added.
    pub(crate) fn find_faces(&mut self) {
        (self.face_of, self.faces) = faces(&self.nodes, &self.sides);
    }

    /// The triangle on the left of a side.
    pub(crate) fn triangle(&self, side: u32) -> Triangle {
        triangle(&self.nodes, &self.sides, side)
    }

    /// The two nodes of a side.
    pub(crate) fn ends(&self, side: u32) -> [Node; 2] {
        let side = self.sides[side as usize];
        [side.from, self.sides[side.twin as usize].from].map(|node| self.nodes[node as usize])
    }

    /// The length of a side, as a part of the window.
    pub(crate) fn length(&self, side: u32) -> f64 {
        let [a, b] = self.ends(side);
        ((b[0] - a[0]) as f64).hypot((b[1] - a[1]) as f64) / GRID as f64
    }
}

fn triangle(nodes: &[Node], sides: &[Side], side: u32) -> Triangle {
    let second = sides[side as usize].next;
    let third = sides[second as usize].next;
    Triangle([side, second, third].map(|side| nodes[sides[side as usize].from as usize]))
}

/// Joins triangles: the face on the left of each side, and all faces.
fn faces(nodes: &[Node], sides: &[Side]) -> (Vec<u32>, Vec<Face>) {
    let whole = 2.0 * GRID as f64 * GRID as f64;
    let mut face_of = vec![OUTSIDE; sides.len()];
    let mut faces: Vec<Face> = Vec::new();
    let mut waiting = Vec::new();
    let mut largest = (0.0, 0);
    for start in 0..sides.len() {
        if face_of[start] != OUTSIDE || sides[start].outer {
            continue;
        }
        let number = faces.len() as u32;
        let mut face = Face { share: 0.0, triangles: Vec::new(), inside: [0.0; 2], fattest: start as u32, thin: true };
        let mut fattest = 0.0;
        waiting.push(start as u32);
        while let Some(first) = waiting.pop() {
            if face_of[first as usize] != OUTSIDE {
                continue;
            }
            let triangle = triangle(nodes, sides, first);
            face.triangles.push(first);
            face.share += triangle.doubled() / whole;
            if triangle.radius() > fattest {
                (fattest, face.inside, face.fattest) = (triangle.radius(), triangle.centre(), first);
            }
            let mut side = first;
            for _ in 0..3 {
                face_of[side as usize] = number;
                let Side { next, twin, border, .. } = sides[side as usize];
                if !border {
                    waiting.push(twin);
                }
                side = next;
            }
        }
        face.thin = fattest < THIN;
        if fattest > largest.0 {
            largest = (fattest, faces.len());
        }
        faces.push(face);
    }
    // Someone has to say what lives here.
    if let Some(face) = faces.get_mut(largest.1) {
        face.thin = false;
    }
    (face_of, faces)
}
