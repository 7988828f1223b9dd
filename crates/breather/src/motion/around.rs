//! A mass and its neighbours: its acceleration just after an impact.

use vibrochain_lattice::simd::lanes::groups;

use super::{Kinematics, Motion};

/// A mass, the displacements of its neighbours, and Σ|Ω²q| over the modes there.
struct Around {
    own: Kinematics,
    sides: [f64; 4],
    modal: f64,
}

/// Sums over the modes: displacement, velocity and acceleration of one mass, displacements of others, and Σ|Ω²q| at the one.
struct Sums<const N: usize> {
    own: [f64; 3],
    moved: [f64; N],
    modal: f64,
}

impl Motion {
    /// Moves just after impact `i`, where interval `i` starts; the state of `site` there, and v̈ from the equation of motion,
    /// −γ₁v − γ₂(2v − v_l − v_r) + F, or from the modes, −Σ Ω²q + G̈, whichever cancels less: the modal sum does where the
    /// coupling is stiff, the neighbours' difference where the ring hangs on soft springs.
    pub(crate) fn just_after(&mut self, i: usize, site: usize) -> (Kinematics, f64) {
        let around = match self.started(i, site) {
            Some(around) => around,
            None => {
                self.seek(i, 0.0);
                self.around(site)
            }
        };
        let (neighbours, modes) = self.sizes(&around);
        let own = around.own;
        // What neighbours move at is not looked at: with dashpots the modes tell.
        let by_modes = modes < neighbours || !self.decays.is_empty();
        let from_forces = || self.chain.spring_force(own.displacement, around.sides) + self.force.value(self.now_time);
        (own, if by_modes { own.acceleration } else { from_forces() })
    }

    /// Sums of the moduli of the terms of v̈ in the two forms of [`Motion::just_after`].
    fn sizes(&self, around: &Around) -> (f64, f64) {
        let (own, sides) = (around.own.displacement.abs(), around.sides.map(f64::abs));
        let neighbours = self.chain.spring_force_bound(own, sides) + self.force.bound(0);
        (neighbours, around.modal + self.steady.bound(2))
    }

    /// A mass and its neighbours at the time last sought.
    fn around(&self, site: usize) -> Around {
        let neighbours = self.chain.neighbours(site);
        if let Some((own, sides)) = self.places(site, neighbours) {
            let [left, right, below, above] = sides;
            let sums = if left == right && self.chain.layers() == 1 {
                let Sums { own, moved: [moved], modal } = self.row_sums(own, [left]);
                Sums { own, moved: [moved; 4], modal }
            } else {
                self.row_sums(own, [left, right, below, above])
            };
            return self.beside(site, neighbours, sums);
        }
        let mut modal = 0.0;
        for (modes, &source) in self.now.chunks_exact(self.frequencies.len().max(1)).zip(&self.sites) {
            let shapes = self.shapes.evens(site, source);
            modal += modes.iter().zip(shapes).map(|(now, shape)| (shape * now[2]).abs()).sum::<f64>();
        }
        let own = self.site(site);
        let displacement = |n: usize| if n == site { own.displacement } else { self.site(n).displacement };
        Around { own, sides: neighbours.map(|n| n.map_or(0.0, displacement)), modal }
    }

    /// [`Motion::seek`] to the start of an interval and [`Motion::around`] in one pass, for the one site of a small ring that is hit.
    fn started(&mut self, i: usize, site: usize) -> Option<Around> {
        if self.table.is_empty() || self.sites != [site] || !self.chain.is_ring() || !self.decays.is_empty() {
            return None;
        }
        let (places, modes) = (self.table_of.1, self.frequencies.len());
        let beside = 1.min(places - 1);
        let states = self.states.get(i * modes..)?.iter().zip(&self.frequencies);
        let rows = self.table.chunks_exact(groups(places));
        let (mut sum, mut moved, mut modal) = ([0.0; 3], 0.0, 0.0);
        for ((now, row), (&(q, p), frequency)) in self.now.iter_mut().zip(rows).zip(states) {
            *now = [q, p, -frequency * frequency * q];
            // All modes are 1 where they are hit.
            (0..3).for_each(|i| sum[i] += now[i]);
            moved += row[0][beside] * q;
            modal += now[2].abs();
        }
        self.seek_force(i, 0.0);
        // Both neighbours move alike.
        Some(self.beside(site, self.chain.neighbours(site), Sums { own: sum, moved: [moved; 4], modal }))
    }

    /// A mass and its neighbours from sums over the modes.
    fn beside(&self, site: usize, neighbours: [Option<usize>; 4], sums: Sums<4>) -> Around {
        let own = self.forced(site, sums.own);
        let side = |i: usize| match neighbours[i] {
            None => 0.0,
            Some(n) if n == site => own.displacement,
            Some(n) => sums.moved[i] + self.driven(n).displacement,
        };
        Around { own, sides: std::array::from_fn(side), modal: sums.modal }
    }

    /// Sums at one place of the table's rows and at some others.
    fn row_sums<const N: usize>(&self, own: usize, others: [usize; N]) -> Sums<N> {
        let mut sums = Sums { own: [0.0; 3], moved: [0.0; N], modal: 0.0 };
        for (now, row) in self.now.iter().zip(self.table.chunks_exact(groups(self.table_of.1))) {
            let row = row.as_flattened();
            let terms = now.map(|part| row[own] * part);
            (0..3).for_each(|i| sums.own[i] += terms[i]);
            (0..N).for_each(|i| sums.moved[i] += row[others[i]] * now[0]);
            sums.modal += terms[2].abs();
        }
        sums
    }

    /// Where a mass and its neighbours stand in the rows of the table; itself for those that it has not.
    fn places(&self, site: usize, neighbours: [Option<usize>; 4]) -> Option<(usize, [usize; 4])> {
        if self.table.is_empty() {
            None
        } else if !self.is_centred() {
            Some((site, neighbours.map(|n| n.unwrap_or(site))))
        } else if self.sites == [site] {
            // Both neighbours of the only site that is hit move alike.
            Some((0, [1.min(self.table_of.1 - 1); 4]))
        } else {
            None
        }
    }
}
