//! Borders made fit to be cut: chords as short as the tolerance asks, corresponding corners where two run side by side, ends that
//! reach what they end on.
//!
//! The two edges of a stripe may run a thousandth of their chords' error apart, and their chords would cross each other between
//! any two corners. So each corner has its foot on every border that near: chords between corresponding corners keep their
//! order, however far both lie from the curves. And where chords cross, the curves have a corner at their own crossing: around any
//! corner points are on that side of a border where they seem to be.

use crate::error::MapError;
use crate::regions::boxes::{BoxTree, bounds};
use crate::regions::smooth::{Arc, Place, along, dot, length, minus};

/// An end this near a border, or the edge of the window, is joined to it: ten times the error of chords as they usually come, or as many
/// tolerances: a curve that meets another at no angle ends two of them aside, where that is known. One that is joined without need is a spur,
/// which separates nothing.
const JOINED: f64 = 1e-5;
const TOLERANCES: f64 = 4.0;

/// What two points may be apart by rounding alone: those of events are good to about a thousandth of a billionth.
const ROUNDING: f64 = 4e-12;

/// The edge of the window.
const EDGE: [Place; 5] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]];

/// How often the foot of a foot is taken: more than a few borders side by side are rare, and where two cross the steps lead to the
/// crossing without end.
const STEPS: usize = 3;

/// The most corners after refining, ten times what the largest maps need, in 2 GB.
const MOST: usize = 4_000_000;

/// A chord between two neighbouring corners, and the arc it stands for.
#[derive(Debug, Clone, Copy)]
struct Chord {
    border: usize,
    arc: usize,
    /// Where on the arc it begins and ends.
    u: [f64; 2],
    ends: [Place; 2],
    sagitta: f64,
    /// Length of the border up to its beginning.
    before: f64,
}

impl Chord {
    /// The foot of a point: where on the chord, 0 to 1 inside.
    fn foot(&self, point: Place) -> f64 {
        let chord = minus(self.ends[1], self.ends[0]);
        dot(minus(point, self.ends[0]), chord) / dot(chord, chord)
    }

    /// The foot of a point on the arc itself, and where on the chord.
    fn foot_on(&self, arc: &Arc, point: Place) -> (f64, Place) {
        let mut part = self.foot(point);
        let mut foot = arc.at(self.on_arc(part.clamp(0.0, 1.0)));
        // An arc runs on faster or slower than its chord, by thousandths.
        for _ in 0..3 {
            part -= self.foot(foot) - self.foot(point);
            foot = arc.at(self.on_arc(part.clamp(0.0, 1.0)));
        }
        (part, foot)
    }

    fn on_arc(&self, part: f64) -> f64 {
        self.u[0] + part * (self.u[1] - self.u[0])
    }
}

#[derive(Debug)]
struct Border {
    closed: bool,
    arcs: Vec<Arc>,
    /// The corners of each arc besides its ends, and where on it they lie.
    corners: Vec<Vec<(f64, Place)>>,
    /// Numbers of its chords.
    chords: std::ops::Range<usize>,
    length: f64,
    /// What its first and its last point are joined to.
    joined: [Option<Place>; 2],
}

fn too_many() -> MapError {
    let advice = "ask for a larger tolerance, or remove copies of the same border";
    MapError::Request(format!("the borders need more than {MOST} corners: {advice}"))
}

/// Borders with chords that err by less than `tolerance`, as far as four neighbouring points can tell, met and joined, to the edge of
/// the window, too, which comes last. All in parts of the window. Each keeps its number; one of less than two points is empty.
///
/// # Errors
/// [`MapError::Request`] if they need too many corners.
pub(crate) fn strands(borders: &[Vec<Place>], tolerance: f64) -> Result<Vec<Vec<Place>>, MapError> {
    let mut strands = Strands::new(borders.iter().map(Vec::as_slice).chain([EDGE.as_slice()]), tolerance)?;
    let crossings = strands.cross()?;
    strands.meet(&crossings)?;
    strands.join(JOINED.max(TOLERANCES * tolerance));
    // The edge itself stays where it is, to the last digit.
    strands.borders.pop();
    Ok(strands.borders.iter().map(Border::points).chain([EDGE.to_vec()]).collect())
}

#[derive(Debug)]
struct Strands {
    borders: Vec<Border>,
    chords: Vec<Chord>,
    tree: BoxTree,
}

impl Strands {
    fn new<'a>(borders: impl Iterator<Item = &'a [Place]>, tolerance: f64) -> Result<Self, MapError> {
        let mut chords: Vec<Chord> = Vec::new();
        let mut all = Vec::new();
        for (border, points) in borders.enumerate() {
            let mut points = points.to_vec();
            points.dedup();
            let closed = points.len() > 3 && points.first() == points.last();
            let arcs: Vec<Arc> = (1..points.len()).map(|i| Arc::new(&points, i - 1, closed)).collect();
            let (first, mut before) = (chords.len(), 0.0);
            let mut corners = Vec::with_capacity(arcs.len());
            for (number, arc) in arcs.iter().enumerate() {
                // The sagitta falls with the square of the number of parts.
                let parts = (arc.sagitta() / tolerance).sqrt().ceil().max(1.0);
                ensure!(chords.len() as f64 + parts <= MOST as f64, too_many());
                let inner = (1..parts as usize).map(|i| i as f64 / parts);
                let inner: Vec<(f64, Place)> = inner.map(|u| (u, arc.at(u))).collect();
                for i in 0..=inner.len() {
                    let at = |i: usize| i as f64 / parts;
                    let (u, ends) = ([at(i), at(i + 1)], [arc.at(at(i)), arc.at(at(i + 1))]);
                    let sagitta = arc.sagitta() / (parts * parts);
                    chords.push(Chord { border, arc: number, u, ends, sagitta, before });
                    before += length(minus(ends[1], ends[0]));
                }
                corners.push(inner);
            }
            all.push(Border { closed, arcs, corners, chords: first..chords.len(), length: before, joined: [None; 2] });
        }
        let boxes = chords.iter().map(|chord| bounds(chord.ends, 2.0 * chord.sagitta)).collect();
        Ok(Self { borders: all, chords, tree: BoxTree::new(boxes) })
    }

    /// The arc of a chord.
    fn arc(&self, chord: usize) -> &Arc {
        let Chord { border, arc, .. } = self.chords[chord];
        &self.borders[border].arcs[arc]
    }

    /// The chords before and behind a corner; a closed border's last point is its first, and asked for there.
    fn about(&self, border: &Border, corner: usize) -> Option<[usize; 2]> {
        let range = &border.chords;
        let before = if corner > range.start { corner - 1 } else { range.end - 1 };
        let (here, open) = (corner.min(range.end - 1), !border.closed);
        (corner < range.end || open).then_some(if open && corner == range.start { [here; 2] } else { [before, here] })
    }

    /// Gives curves whose chords cross a corner where they do themselves. The corners, each with the two chords.
    fn cross(&mut self) -> Result<Vec<([usize; 2], Place)>, MapError> {
        let mut found: Vec<([usize; 2], [f64; 2])> = Vec::new();
        for (i, chord) in self.chords.iter().enumerate() {
            self.tree.meeting(bounds(chord.ends, 0.0), |j| {
                let other = &self.chords[j];
                if j <= i || found.len() > MOST || !crosses(chord.ends, other.ends) {
                    return;
                }
                let arcs = [(self.arc(i), chord.u), (self.arc(j), other.u)];
                found.extend(crossing(arcs).map(|places| ([i, j], places)));
            });
        }
        ensure!(self.chords.len() + 2 * found.len() <= MOST, too_many());
        let mut places = Vec::with_capacity(found.len());
        for (chords, on_arcs) in found {
            // The same corner of both, not one a step of the grid beside the other.
            let place = self.arc(chords[0]).at(on_arcs[0]);
            for (i, u) in chords.into_iter().zip(on_arcs) {
                let Chord { border, arc, .. } = self.chords[i];
                self.borders[border].corners[arc].push((u, place));
            }
            places.push((chords, place));
        }
        Ok(places)
    }

    /// Gives every corner, these among them, its feet on the borders that run past within the error of chords.
    fn meet(&mut self, crossings: &[([usize; 2], Place)]) -> Result<(), MapError> {
        let mut corners: Vec<([usize; 2], Place, usize)> =
            crossings.iter().map(|&(about, place)| (about, place, 0)).collect();
        for border in self.borders.iter().filter(|border| !border.chords.is_empty()) {
            for corner in border.chords.start..=border.chords.end {
                if let Some(about) = self.about(border, corner) {
                    let chord = &self.chords[about[1]];
                    corners.push((about, chord.ends[usize::from(corner == border.chords.end)], 0));
                }
            }
        }
        let mut count = self.chords.len() + corners.len();
        // A foot is a corner, too: what runs beside it may be too far from where it came from.
        while let Some((about, point, steps)) = corners.pop() {
            let own = about.map(|i| self.chords[i].sagitta).into_iter().fold(0.0, f64::max);
            let mut feet = Vec::new();
            self.tree.meeting(bounds([point; 2], 2.0 * own + ROUNDING), |i| {
                let chord = &self.chords[i];
                let border = &self.borders[chord.border];
                let (part, foot) = chord.foot_on(&border.arcs[chord.arc], point);
                if about.contains(&i) || part <= 0.0 || part >= 1.0 {
                    return;
                }
                let u = chord.on_arc(part);
                let distance = length(minus(foot, point));
                // So near a corner it would only repeat it: of two feet of each other both would wander.
                let margin = (ROUNDING + 0.05 * distance) * (chord.u[1] - chord.u[0]) / chord.length();
                let near = |other: f64| (other - u).abs() < margin;
                let known =
                    chord.u.into_iter().any(near) || border.corners[chord.arc].iter().any(|(other, _)| near(*other));
                if distance < 2.0 * (own + chord.sagitta) + ROUNDING && !known {
                    feet.push((i, u, foot));
                }
            });
            count += feet.len();
            ensure!(count <= MOST, too_many());
            for (i, u, foot) in feet {
                let Chord { border, arc, .. } = self.chords[i];
                self.borders[border].corners[arc].push((u, foot));
                if steps < STEPS {
                    corners.push(([i; 2], foot, steps + 1));
                }
            }
        }
        Ok(())
    }

    /// Joins the ends of open borders to what they come near.
    fn join(&mut self, reach: f64) {
        for border in 0..self.borders.len() {
            let range = self.borders[border].chords.clone();
            if self.borders[border].closed || range.is_empty() {
                continue;
            }
            let ends = [self.chords[range.start].ends[0], self.chords[range.end - 1].ends[1]];
            for (side, end) in ends.into_iter().enumerate() {
                if end.iter().any(|part| !(0.0..=1.0).contains(part)) {
                    continue;
                }
                let mut best: Option<(f64, Place, (usize, usize, f64))> = None;
                let along_border = if side == 0 { 0.0 } else { self.borders[border].length };
                self.tree.meeting(bounds([end; 2], reach), |i| {
                    let chord = &self.chords[i];
                    // What leads to the end is no other border; a loop's beginning is.
                    if chord.border == border && (chord.before - along_border).abs() < 10.0 * reach + chord.length() {
                        return;
                    }
                    let u = chord.on_arc(chord.foot_on(self.arc(i), end).0.clamp(0.0, 1.0));
                    let place = self.arc(i).at(u);
                    let distance = length(minus(place, end));
                    if distance < best.map_or(reach, |(least, ..)| least) {
                        best = Some((distance, place, (chord.border, chord.arc, u)));
                    }
                });
                let Some((_, place, (other, arc, u))) = best else { continue };
                self.borders[border].joined[side] = Some(place);
                self.borders[other].corners[arc].push((u, place));
            }
        }
    }
}

impl Chord {
    fn length(&self) -> f64 {
        length(minus(self.ends[1], self.ends[0]))
    }
}

impl Border {
    fn points(&self) -> Vec<Place> {
        let mut points: Vec<Place> = self.joined[0].into_iter().collect();
        for (arc, corners) in self.arcs.iter().zip(&self.corners) {
            let mut corners = corners.clone();
            corners.sort_by(|one, two| one.0.total_cmp(&two.0));
            points.push(arc.at(0.0));
            points.extend(corners.into_iter().map(|(_, place)| place));
        }
        points.extend(self.arcs.last().map(|arc| arc.at(1.0)));
        points.extend(self.joined[1]);
        points
    }
}

fn area(a: Place, b: Place) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// Whether two chords cross inside both.
fn crosses([a, b]: [Place; 2], [c, d]: [Place; 2]) -> bool {
    let sides = |from: Place, to: Place| [c, d].map(|end| area(minus(to, from), minus(end, from)));
    let [one, two] = sides(a, b);
    let other = [a, b].map(|end| area(minus(d, c), minus(end, c)));
    one * two < 0.0 && other[0] * other[1] < 0.0
}

/// Where two arcs cross, by Newton's method from the middles of pieces of them; `None` where they are too nearly parallel to tell,
/// or cross beyond their ends.
fn crossing([(one, u), (two, v)]: [(&Arc, [f64; 2]); 2]) -> Option<[f64; 2]> {
    let (mut u, mut v) = (0.5 * (u[0] + u[1]), 0.5 * (v[0] + v[1]));
    for _ in 0..8 {
        let (off, r, s) = (minus(two.at(v), one.at(u)), one.direction(u), two.direction(v));
        if length(off) < 0.1 * ROUNDING {
            return Some([u, v]);
        }
        let whole = area(r, s);
        (u, v) = (u + area(off, s) / whole, v + area(off, r) / whole);
        if ![u, v].iter().all(|at| (0.0..=1.0).contains(at)) {
            return None;
        }
    }
    None
}

/// The parts of a border inside the window, ends on its edge included.
pub(crate) fn clipped(points: &[Place]) -> Vec<Vec<Place>> {
    let mut parts: Vec<Vec<Place>> = Vec::new();
    for pair in points.windows(2) {
        let (from, chord) = (pair[0], minus(pair[1], pair[0]));
        let (mut enters, mut leaves) = ((0.0, None), (1.0, None));
        for k in 0..2 {
            for edge in [0.0, 1.0] {
                let outward = if edge == 0.0 { -chord[k] } else { chord[k] };
                let outside = if edge == 0.0 { -from[k] } else { from[k] - 1.0 };
                let at = (edge - from[k]) / chord[k];
                if outward == 0.0 && outside > 0.0 {
                    enters.0 = 2.0;
                } else if outward < 0.0 && at > enters.0 {
                    enters = (at, Some((k, edge)));
                } else if outward > 0.0 && at < leaves.0 {
                    leaves = (at, Some((k, edge)));
                }
            }
        }
        if enters.0 >= leaves.0 {
            continue;
        }
        // Exactly on the edge, whatever rounding says.
        let place = |(at, cut): (f64, Option<(usize, f64)>), whole: Place| {
            let mut place = whole;
            if let Some((k, edge)) = cut {
                place = along(from, at, chord).map(|part| part.clamp(0.0, 1.0));
                place[k] = edge;
            }
            place
        };
        let (first, last) = (place(enters, pair[0]), place(leaves, pair[1]));
        match parts.last_mut() {
            Some(part) if enters.1.is_none() && part.last() == Some(&first) => part.push(last),
            _ => parts.push(vec![first, last]),
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    fn circle(radius: f64, points: usize, turn: f64) -> Vec<Place> {
        let angle = |i: usize| std::f64::consts::TAU * ((i % points) as f64 + turn) / points as f64;
        let place = |angle: f64| [0.5 + radius * angle.cos(), 0.5 + radius * angle.sin()];
        (0..=points).map(|i| place(angle(i))).collect()
    }

    #[test]
    fn chords_are_refined_to_the_tolerance() {
        let fine = strands(&[circle(0.4, 300, 0.0)], 1e-8).unwrap();
        let points = &fine[0];
        // A chord of length h errs by h²/8r.
        assert!((13_500..15_000).contains(&points.len()), "{}", points.len());
        let middles = points.windows(2).map(|pair| along(pair[0], 0.5, minus(pair[1], pair[0])));
        let worst = middles.map(|p| (length(minus(p, [0.5; 2])) - 0.4).abs()).fold(0.0, f64::max);
        assert!(worst < 1.2e-8 && worst > 1e-9, "{worst:e}");
    }

    #[test]
    fn borders_side_by_side_have_corresponding_corners() {
        for apart in [1e-7, 1e-9, 1e-11] {
            let pair = strands(&[circle(0.4, 1600, 0.0), circle(0.4 + apart, 1601, 0.3)], 1e-6).unwrap();
            // All corners of either, the first ones twice.
            assert!((3200..3210).contains(&pair[0].len()) && (3200..3210).contains(&pair[1].len()));
            let far = strands(&[circle(0.4, 1600, 0.0), circle(0.4001, 1601, 0.3)], 1e-6).unwrap();
            assert_eq!((far[0].len(), far[1].len()), (1601, 1602));
        }
    }

    #[test]
    fn ends_near_a_border_or_an_edge_are_joined_to_it() {
        let line = vec![[0.0, 0.5], [1.0, 0.5]];
        let end = |place| vec![[0.25, 0.75], place];
        for (place, joined) in [
            ([0.25, 0.500_005], Some([0.25, 0.5])),
            ([0.25, 0.499_995], Some([0.25, 0.5])),
            ([0.25, 0.500_05], None),
            ([0.999_995, 0.9], Some([1.0, 0.9])),
            ([0.3, 3e-6], Some([0.3, 0.0])),
        ] {
            let met = strands(&[line.clone(), end(place)], 1e-6).unwrap();
            let last = met[1][met[1].len() - 1];
            assert!(length(minus(last, joined.unwrap_or(place))) < 1e-15, "{:?}", met[1]);
        }
        // A loop that stops short of its beginning.
        let mut open = circle(0.3, 100, 0.0);
        open.truncate(100);
        open.push([0.8 - 2e-6, 0.5 - 2e-6]);
        let met = strands(&[open], 1e-3).unwrap();
        assert!(length(minus(met[0][met[0].len() - 1], met[0][0])) < 3e-6, "{:?}", &met[0][98..]);
    }

    #[test]
    fn a_border_is_cut_where_it_leaves_the_window() {
        let parts = clipped(&[[-0.5, 0.5], [0.5, 0.5], [0.5, 1.5], [0.75, 1.5], [0.75, 0.25], [2.0, 0.25]]);
        assert_eq!(parts, [vec![[0.0, 0.5], [0.5, 0.5], [0.5, 1.0]], vec![[0.75, 1.0], [0.75, 0.25], [1.0, 0.25]]]);
        assert_eq!(clipped(&[[0.0, 0.0], [1.0, 1.0]]), [vec![[0.0, 0.0], [1.0, 1.0]]]);
        assert_eq!(clipped(&[[-1.0, 0.5], [2.0, 0.5]]), [vec![[0.0, 0.5], [1.0, 0.5]]]);
        assert!(clipped(&[[-1.0, -0.5], [2.0, -0.5]]).is_empty() && clipped(&[[0.5, 0.5]]).is_empty());
    }
}
