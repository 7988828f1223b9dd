//! What lives in the faces of a window cut by borders.

use std::collections::{BinaryHeap, HashMap};

use rayon::prelude::{IntoParallelRefIterator, ParallelIterator};

use crate::regions::gaps::{GAP, Neck, Spot, Widest};
use crate::regions::plane::{Regions, Unexplained};
use crate::regions::smooth::Place;
use crate::regions::subdivision::{Face, OUTSIDE, Subdivision, THIN};
use crate::regions::triangles::Triangle;

/// Gaps between borders that are closed at most.
const MOST_GAPS: usize = 1000;

/// Places of one face from which the way to where something else lives is looked at.
const MOST_WAYS: usize = 4;

/// A place to ask about: its face, a triangle of it, the point in units of the axes.
#[derive(Debug, Clone, Copy)]
struct Question {
    face: usize,
    triangle: u32,
    point: [f64; 2],
}

/// What lives in faces, as far as they were asked.
pub(crate) struct Faces<T> {
    cut: Subdivision,
    classes: Vec<T>,
    /// Of each face, by its number in the list.
    class_of: Vec<Option<usize>>,
    pub(crate) unexplained: Vec<Unexplained<T>>,
    closed: Vec<([f64; 2], f64)>,
}

impl<T: Clone + PartialEq> Faces<T> {
    /// The same seen otherwise: what is told apart no more is one.
    pub(crate) fn seen<U: Clone + PartialEq>(self, see: impl Fn(&T) -> U) -> Faces<U> {
        let mut classes: Vec<U> = Vec::new();
        let seen = self.classes.iter().map(|class| {
            let class = see(class);
            classes.iter().position(|other| *other == class).unwrap_or_else(|| {
                classes.push(class);
                classes.len() - 1
            })
        });
        let seen: Vec<usize> = seen.collect();
        let unexplained = self.unexplained.into_iter().map(|face| {
            let points = face.points.iter().map(|(point, class)| (*point, see(class))).collect();
            Unexplained { share: face.share, points, changes: face.changes }
        });
        let differing = |face: &Unexplained<U>| face.points.iter().any(|point| point.1 != face.points[0].1);
        let unexplained = unexplained.filter(differing).collect();
        let class_of = self.class_of.into_iter().map(|class| class.map(|class| seen[class])).collect();
        Faces { cut: self.cut, classes, class_of, unexplained, closed: self.closed }
    }

    /// Faces joined to regions.
    pub(crate) fn regions(self) -> Regions<T> {
        let class_of = self.cut.with_thin(self.class_of);
        Regions::new(&self.cut, &self.classes, &class_of, self.unexplained, self.closed)
    }
}

fn bits(point: [f64; 2]) -> [u64; 2] {
    point.map(f64::to_bits)
}

impl Subdivision {
    /// Asks `class` what lives at a point, in units of the axes, of each face. In all faces but the thinnest a few more points are
    /// looked at, `samples` over the whole window by area and at least two a face; where they differ the face is
    /// [unexplained](Regions::unexplained), and what most of its points say holds, unless it reaches through a gap between ends of
    /// borders: one narrower than 1e-4 of the window is [closed](Regions::closed). `worker` makes what a thread computes with.
    /// A face less than about 3e-11 of the window wide is not asked: it belongs to the neighbour along which it runs.
    ///
    /// Threads are those of the pool of `rayon` that this is called in.
    pub fn classified<W, T: Clone + Eq + Send + Sync>(
        self,
        samples: usize,
        worker: impl Fn() -> W + Send + Sync,
        class: impl Fn(&mut W, [f64; 2]) -> T + Send + Sync,
    ) -> Regions<T> {
        self.asked(samples, worker, class, |_| false, &mut HashMap::new()).regions()
    }

    /// What lives in the faces, and which of them are unexplained. A face has an answer that is none only if all its points do. Answers are taken from those known already, and added to them.
    pub(crate) fn asked<W, T: Clone + Eq + Send + Sync>(
        mut self,
        samples: usize,
        worker: impl Fn() -> W + Send + Sync,
        class: impl Fn(&mut W, [f64; 2]) -> T + Send + Sync,
        is_none: impl Fn(&T) -> bool + Sync,
        known: &mut HashMap<[u64; 2], T>,
    ) -> Faces<T> {
        let mut closed = Vec::new();
        loop {
            let mut questions: Vec<Question> = Vec::new();
            for (number, face) in self.faces.iter().enumerate().filter(|(_, face)| !face.thin) {
                let places = std::iter::once((face.inside, face.fattest)).chain(self.more(face, samples));
                let ask = |(place, triangle)| Question { face: number, triangle, point: self.window.point(place) };
                questions.extend(places.map(ask));
            }
            // Faces between other borders were asked before.
            let new: Vec<[f64; 2]> =
                questions.iter().map(|one| one.point).filter(|point| !known.contains_key(&bits(*point))).collect();
            let answers: Vec<T> = new.par_iter().map_init(&worker, |worker, &point| class(worker, point)).collect();
            known.extend(new.iter().map(|point| bits(*point)).zip(answers));
            // Few are different: numbers instead.
            let mut classes: Vec<T> = Vec::new();
            let numbers = questions.iter().filter_map(|one| known.get(&bits(one.point))).map(|answer| {
                classes.iter().position(|class| class == answer).unwrap_or_else(|| {
                    classes.push(answer.clone());
                    classes.len() - 1
                })
            });
            let numbers: Vec<usize> = numbers.collect();
            let mut class_of = vec![None; self.faces.len()];
            let mut differing: Vec<(usize, &[Question], &[usize])> = Vec::new();
            let mut first = 0;
            for group in questions.chunk_by(|one, two| one.face == two.face) {
                let own = &numbers[first..first + group.len()];
                first += group.len();
                let mut counts = vec![0; classes.len()];
                for &class in own {
                    counts[class] += 1;
                }
                let is_told = own.iter().any(|&class| !is_none(&classes[class]));
                let counted = |class: usize| if is_told && is_none(&classes[class]) { 0 } else { counts[class] };
                let most = (0..classes.len()).map(counted).max().unwrap_or(0);
                // Of classes that as many points have, that of the point well inside.
                let face = group[0].face;
                class_of[face] = own.iter().copied().find(|&class| counted(class) == most);
                if is_told && most < (0..classes.len()).map(counted).sum() {
                    differing.push((face, group, own));
                }
            }
            let necks: Vec<Vec<Neck>> = differing
                .par_iter()
                .map_init(&worker, |worker, (_, group, own)| {
                    let told = |class: &usize| !is_none(&classes[*class]);
                    let Some(first) = own.iter().position(told) else { return Vec::new() };
                    let at = |i: usize| {
                        let Question { triangle, point, .. } = group[i];
                        Spot { triangle, point, lives: classes[own[i]].clone() }
                    };
                    let differs = |i: &usize| told(&own[*i]) && own[*i] != own[first];
                    let others: Vec<usize> = (0..own.len()).filter(differs).collect();
                    let some = others.iter().step_by(others.len().div_ceil(MOST_WAYS).max(1));
                    some.filter_map(|&other| {
                        self.neck(at(first), at(other), |point| Some(class(worker, point)).filter(|one| !is_none(one)))
                    })
                    .fold(Vec::new(), |mut necks: Vec<Neck>, neck| {
                        if !necks.iter().any(|other| other.side == neck.side) {
                            necks.push(neck);
                        }
                        necks
                    })
                })
                .collect();
            let mut gaps: Vec<Neck> = necks.iter().flatten().copied().filter(|neck| neck.length <= GAP).collect();
            gaps.sort_by_key(|neck| neck.side);
            gaps.dedup_by_key(|neck| neck.side);
            if gaps.is_empty() || closed.len() >= MOST_GAPS {
                let unexplained = differing.iter().zip(&necks).map(|((face, group, own), necks)| Unexplained {
                    share: self.faces[*face].share,
                    points: group.iter().zip(*own).map(|(one, class)| (one.point, classes[*class].clone())).collect(),
                    changes: necks.iter().map(|neck| neck.between).collect(),
                });
                let unexplained = unexplained.collect();
                return Faces { cut: self, classes, class_of, unexplained, closed };
            }
            closed.extend(gaps.iter().map(|neck| (self.middle(neck.side), neck.length)));
            self.close(&gaps.iter().map(|neck| neck.side).collect::<Vec<_>>());
        }
    }

    /// More points of a face: spread by area over its triangles, far enough from its borders to be on their side for certain.
    fn more(&self, face: &Face, samples: usize) -> Vec<(Place, u32)> {
        let wanted = 2 + (samples as f64 * face.share).round() as usize;
        // In the narrow ends of a face rounding decides on which side a point lies.
        let triangles = face.triangles.iter().map(|&side| (self.triangle(side), side));
        let triangles: Vec<(Triangle, u32)> = triangles.filter(|(one, _)| one.radius() >= THIN).collect();
        let whole: f64 = triangles.iter().map(|(triangle, _)| triangle.doubled()).sum();
        let (mut places, mut reached, mut k) = (Vec::with_capacity(wanted), 0.0, 0);
        for (triangle, side) in &triangles {
            reached += triangle.doubled();
            while k < wanted && (k as f64 + 0.5) / wanted as f64 * whole <= reached {
                // Two irrational steps, which fill a square evenly.
                let spread = [0.754_877_666_246_692_8, 0.569_840_290_998_053_3].map(|step| (k as f64 * step).fract());
                places.push((triangle.point(spread, 2.0 * self.tolerance), *side));
                k += 1;
            }
        }
        places.dedup();
        places.retain(|(place, _)| *place != face.inside);
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
        let push = |next: &mut BinaryHeap<Widest<[u32; 2]>>, face: u32| {
            let first = common.partition_point(|(faces, _)| faces[0] < face);
            let own = common[first..].iter().take_while(|(faces, _)| faces[0] == face);
            next.extend(own.map(|&(faces, length)| Widest { width: length, what: faces }));
        };
        for face in known {
            push(&mut next, face);
        }
        while let Some(Widest { what: [from, to], .. }) = next.pop() {
            if class_of[to as usize].is_none() {
                class_of[to as usize] = class_of[from as usize];
                push(&mut next, to);
            }
        }
        // The whole window is one piece, and not all of it is thin.
        class_of.into_iter().map(|class| class.unwrap_or(0)).collect()
    }
}
