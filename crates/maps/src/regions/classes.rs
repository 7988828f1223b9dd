//! What lives in the faces of a window cut by borders.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use rayon::prelude::{IntoParallelRefIterator, ParallelIterator};

use crate::regions::plane::{Regions, Unexplained};
use crate::regions::smooth::Place;
use crate::regions::subdivision::{Face, OUTSIDE, Subdivision, THIN};
use crate::regions::triangles::Triangle;

impl Subdivision {
    /// Asks `class` what lives at a point, in units of the axes, of each face. In all faces but the thinnest a few more points are
    /// looked at, `samples` over the whole window by area and at least two a face; where they differ the face is
    /// [unexplained](Regions::unexplained), and what most of its points say holds. `worker` makes what a thread computes with.
    /// A face less than about 3e-11 of the window wide is not asked: it belongs to the neighbour along which it runs.
    ///
    /// Threads are those of the pool of `rayon` that this is called in.
    pub fn classified<W, T: Clone + Eq + Send + Sync>(
        self,
        samples: usize,
        worker: impl Fn() -> W + Send + Sync,
        class: impl Fn(&mut W, [f64; 2]) -> T + Send + Sync,
    ) -> Regions<T> {
        let mut questions: Vec<(usize, [f64; 2])> = Vec::new();
        for (number, face) in self.faces.iter().enumerate().filter(|(_, face)| !face.thin) {
            let places = std::iter::once(face.inside).chain(self.more(face, samples));
            questions.extend(places.map(|place| (number, self.window.point(place))));
        }
        let answers: Vec<T> =
            questions.par_iter().map_init(worker, |worker, &(_, point)| class(worker, point)).collect();
        // Few are different: numbers instead.
        let mut classes: Vec<T> = Vec::new();
        let numbers = answers.iter().map(|answer| {
            classes.iter().position(|class| class == answer).unwrap_or_else(|| {
                classes.push(answer.clone());
                classes.len() - 1
            })
        });
        let numbers: Vec<usize> = numbers.collect();
        let mut class_of = vec![None; self.faces.len()];
        let mut unexplained = Vec::new();
        let mut first = 0;
        for group in questions.chunk_by(|one, two| one.0 == two.0) {
            let own = &numbers[first..first + group.len()];
            first += group.len();
            let count = |class: usize| own.iter().filter(|&&other| other == class).count();
            let most = own.iter().map(|&class| count(class)).max().unwrap_or(0);
            // Of classes that as many points have, that of the point well inside.
            let face = group[0].0;
            class_of[face] = own.iter().copied().find(|&class| count(class) == most);
            if most < own.len() {
                let points = group.iter().zip(own).map(|((_, point), &class)| (*point, classes[class].clone()));
                unexplained.push(Unexplained { share: self.faces[face].share, points: points.collect() });
            }
        }
        let class_of = self.with_thin(class_of);
        Regions::new(&self, &classes, &class_of, unexplained)
    }

    /// More points of a face: spread by area over its triangles, far enough from its borders to be on their side for certain.
    fn more(&self, face: &Face, samples: usize) -> Vec<Place> {
        let wanted = 2 + (samples as f64 * face.share).round() as usize;
        // In the narrow ends of a face rounding decides on which side a point lies.
        let triangles = face.triangles.iter().map(|&side| self.triangle(side)).filter(|one| one.radius() >= THIN);
        let triangles: Vec<Triangle> = triangles.collect();
        let whole: f64 = triangles.iter().map(Triangle::doubled).sum();
        let (mut places, mut reached, mut k) = (Vec::with_capacity(wanted), 0.0, 0);
        for triangle in &triangles {
            reached += triangle.doubled();
            while k < wanted && (k as f64 + 0.5) / wanted as f64 * whole <= reached {
                // Two irrational steps, which fill a square evenly.
                let spread = [0.754_877_666_246_692_8, 0.569_840_290_998_053_3].map(|step| (k as f64 * step).fract());
                places.push(triangle.point(spread, 2.0 * self.tolerance));
                k += 1;
            }
        }
        places.dedup();
        places.retain(|place| *place != face.inside);
        places
    }

    /// Gives thin faces the class of the neighbour with the longest common border, from the others on.
    fn with_thin(&self, mut class_of: Vec<Option<usize>>) -> Vec<usize> {
        let mut common: Vec<([u32; 2], f64)> = Vec::new();
        for (i, side) in self.sides.iter().enumerate().filter(|(_, side)| side.border) {
            let faces = [self.face_of[i], self.face_of[side.twin as usize]];
            if !faces.contains(&OUTSIDE) && self.faces[faces[1] as usize].thin {
                common.push((faces, self.length(i as u32)));
            }
        }
        common.sort_by_key(|(faces, _)| *faces);
        let common: Vec<([u32; 2], f64)> = common
            .chunk_by(|one, two| one.0 == two.0)
            .map(|group| (group[0].0, group.iter().map(|(_, length)| length).sum()))
            .collect();
        let mut next = BinaryHeap::new();
        let known: Vec<u32> = (0..class_of.len() as u32).filter(|&face| class_of[face as usize].is_some()).collect();
        let push = |next: &mut BinaryHeap<Common>, face: u32| {
            let first = common.partition_point(|(faces, _)| faces[0] < face);
            let own = common[first..].iter().take_while(|(faces, _)| faces[0] == face);
            next.extend(own.map(|&(faces, length)| Common { length, faces }));
        };
        for face in known {
            push(&mut next, face);
        }
        while let Some(Common { faces: [from, to], .. }) = next.pop() {
            if class_of[to as usize].is_none() {
                class_of[to as usize] = class_of[from as usize];
                push(&mut next, to);
            }
        }
        // The whole window is one piece, and not all of it is thin.
        class_of.into_iter().map(|class| class.unwrap_or(0)).collect()
    }
}

/// What a face with a class and a thin one have in common; the longest is the greatest.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Common {
    length: f64,
    faces: [u32; 2],
}

impl Eq for Common {}

impl Ord for Common {
    fn cmp(&self, other: &Self) -> Ordering {
        self.length.total_cmp(&other.length).then_with(|| other.faces.cmp(&self.faces))
    }
}

impl PartialOrd for Common {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
