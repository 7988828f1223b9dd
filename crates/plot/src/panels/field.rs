//! All masses of a run in space and time, thinned while it runs to what a picture can show.
//!
//! A short run is shown as it is, by displacements. Of a long one so few samples would be left that they show a slow
//! motion that is not there; it is shown by the amplitude of each mass, half its swing in each period. Of masses that
//! share a row the one farthest from rest is shown, so that no breather is lost on a large ring.

use vibrochain_lattice::Chain;

/// Columns and rows at most: fewer than the panel has pixels, so that none of them is lost.
const COLUMNS: f64 = 900.0;
const ROWS: usize = 256;

/// Columns of displacements that a period needs for its motion to be seen.
const LEAST: u64 = 8;

/// What the rows of a field hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FieldValue {
    /// Displacements at the time of the column.
    Displacement,
    /// Half the way between the outermost displacements within the column's time.
    Amplitude,
}

/// A run in space and time.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    /// What is shown.
    pub shown: FieldValue,
    /// Masses, of all layers.
    pub sites: usize,
    /// The site of the lowest row: on a ring the last one left of site 0, otherwise 0.
    pub lowest: i64,
    /// Masses of one layer.
    pub length: usize,
    /// Each column from the lowest site to the highest.
    pub columns: Vec<Vec<f64>>,
    /// Periods from one column to the next.
    pub spacing: f64,
    /// Periods that were run.
    pub covered: f64,
}

/// A field under way.
pub struct FieldWriter {
    field: Field,
    /// Samples from one column to the next.
    stride: u64,
    seen: u64,
    /// The outermost displacements of each mass since the last column; empty where displacements are shown.
    least: Vec<f64>,
    most: Vec<f64>,
}

impl FieldWriter {
    /// Of a run over so many periods, of which each gives so many samples.
    pub fn new(chain: &Chain, periods: f64, samples: u64) -> Self {
        let sparse = (periods * samples as f64 / COLUMNS).ceil().max(1.0);
        // Who asks for few samples wants to see those.
        let resolved = sparse * LEAST as f64 <= samples as f64 || samples < LEAST;
        let per_column = (periods / COLUMNS).ceil().max(1.0);
        let (shown, stride) = if resolved {
            (FieldValue::Displacement, sparse)
        } else {
            (FieldValue::Amplitude, per_column * samples as f64)
        };
        let sites = chain.sites();
        // The masses of a ring stand on both sides of site 0.
        let lowest = if chain.is_ring() { -(sites.saturating_sub(1) as i64 / 2) } else { 0 };
        let spacing = stride / samples as f64;
        let swings = if resolved { 0 } else { sites };
        Self {
            field: Field { shown, sites, lowest, length: chain.length(), columns: Vec::new(), spacing, covered: 0.0 },
            stride: stride as u64,
            seen: 0,
            least: vec![f64::INFINITY; swings],
            most: vec![f64::NEG_INFINITY; swings],
        }
    }

    /// Whether the next sample is looked at.
    pub fn wants(&self) -> bool {
        self.field.shown == FieldValue::Amplitude || self.is_column()
    }

    fn is_column(&self) -> bool {
        self.seen.is_multiple_of(self.stride)
    }

    /// Takes the next sample: all displacements, if it is wanted, after so many periods.
    pub fn see(&mut self, displacement: &[f64], periods: f64) {
        self.field.covered = periods;
        let column = self.is_column();
        match self.field.shown {
            FieldValue::Displacement if column => {
                let rows = rows(displacement.iter().copied(), self.field.lowest);
                self.field.columns.push(rows);
            }
            FieldValue::Displacement => {}
            FieldValue::Amplitude => {
                self.widen(displacement);
                // A sample on the border belongs to the columns on both sides.
                if column && self.seen > 0 {
                    self.close();
                    self.widen(displacement);
                }
            }
        }
        self.seen += 1;
    }

    fn widen(&mut self, displacement: &[f64]) {
        for ((least, most), u) in self.least.iter_mut().zip(&mut self.most).zip(displacement) {
            (*least, *most) = (least.min(*u), most.max(*u));
        }
    }

    fn close(&mut self) {
        let swings = self.least.iter().zip(&self.most).map(|(least, most)| 0.5 * (most - least));
        let rows = rows(swings, self.field.lowest);
        self.field.columns.push(rows);
        self.least.fill(f64::INFINITY);
        self.most.fill(f64::NEG_INFINITY);
    }

    /// The field. What is left of a run after its last column has no whole period; it counts only if there is no other.
    pub fn finish(mut self) -> Field {
        if self.field.shown == FieldValue::Amplitude && self.field.columns.is_empty() && self.seen > 0 {
            self.close();
        }
        self.field
    }
}

/// Rows of a column of values, one a mass in the order of sites: from the lowest on, and of several masses in a row the largest
/// value.
fn rows(values: impl ExactSizeIterator<Item = f64>, lowest: i64) -> Vec<f64> {
    let sites = values.len();
    let left = lowest.unsigned_abs() as usize;
    let mut rows = vec![0.0_f64; sites.min(ROWS)];
    let count = rows.len();
    for (site, value) in values.enumerate() {
        let row = &mut rows[(site + left) % sites * count / sites];
        if value.abs() > row.abs() {
            *row = value;
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The field of a motion of all masses, given by site and time in periods.
    fn field(sites: usize, periods: f64, samples: u64, motion: impl Fn(usize, f64) -> f64) -> Field {
        let chain = Chain::new(sites, 0.2, 0.1).unwrap();
        let mut writer = FieldWriter::new(&chain, periods, samples);
        for k in 0..=(periods * samples as f64) as u64 {
            let t = k as f64 / samples as f64;
            let u: Vec<f64> = if writer.wants() { (0..sites).map(|n| motion(n, t)).collect() } else { Vec::new() };
            writer.see(&u, t);
        }
        writer.finish()
    }

    /// Runs of any length beside any frequency: what is drawn is the motion itself, or its amplitude.
    #[test]
    fn no_length_of_a_run_makes_a_motion_slow_or_small() {
        let (mut shown, mut compared) = ([0, 0], 0);
        for periods in [0.5, 3.0, 20.0, 111.0, 112.5, 113.0, 899.0, 900.0, 901.0, 1000.0, 4000.0] {
            for rate in [1.0, 3.0, 0.5, 1.37] {
                let turn = std::f64::consts::TAU * rate;
                // A mass that swings about 0.3, and one at rest there.
                let field = field(2, periods, 64, |n, t| if n == 0 { 0.3 + 0.6 * (turn * t).sin() } else { 0.3 });
                assert!(field.columns.len() <= 902 && (field.covered - periods).abs() < 0.02);
                shown[field.shown as usize] += 1;
                let reach = field.columns.len() as f64 * field.spacing;
                assert!((reach - periods).abs() <= field.spacing + 1e-9, "{periods} {reach}");
                for (k, column) in field.columns.iter().enumerate() {
                    match field.shown {
                        FieldValue::Displacement => {
                            let t = k as f64 * field.spacing;
                            assert!((column[0] - 0.3 - 0.6 * (turn * t).sin()).abs() < 1e-9 && column[1] == 0.3);
                            // Eight columns a period at least: rate 3 is still drawn, not folded.
                            assert!(field.spacing <= 0.125);
                        }
                        FieldValue::Amplitude => {
                            // Half a turn in a period swings by 0.6·(1 − 0) at least.
                            let least = if rate < 1.0 { 0.29 } else { 0.6 * (1.0 - 0.02) };
                            assert!(column[0] > least && column[0] <= 0.6 + 1e-12, "{periods} {rate} {column:?}");
                            assert_eq!(column[1], 0.0);
                        }
                    }
                    compared += 1;
                }
            }
        }
        assert!(shown[0] >= 8 && shown[1] >= 8 && compared > 10_000, "{shown:?} {compared}");
    }

    #[test]
    fn a_large_ring_takes_no_more_than_the_picture_and_hides_no_mass() {
        for (sites, hot) in [(100_000, 0), (100_000, 49_999), (100_001, 50_001), (3, 2), (256, 255), (257, 100), (1, 0)]
        {
            let lowest = -((sites - 1) as i64 / 2);
            let column = rows((0..sites).map(|n| if n == hot { -0.9 } else { 0.1 }), lowest);
            assert_eq!(column.len(), sites.min(ROWS));
            let place = column.iter().position(|&u| u == -0.9).unwrap();
            assert_eq!(column.iter().filter(|&&u| u == -0.9).count(), 1);
            // Site 0 is in the middle; sites beyond half the ring are left of it.
            let offset = if hot > sites / 2 { hot as f64 - sites as f64 } else { hot as f64 };
            let expected = (offset + ((sites - 1) / 2) as f64) / sites as f64 * column.len() as f64;
            assert!((place as f64 - expected).abs() <= 1.0, "{sites} {hot}: {place} {expected}");
        }
    }

    #[test]
    fn an_interrupted_run_and_a_stroboscope_show_what_they_have() {
        let chain = Chain::new(1, 0.2, 0.1).unwrap();
        let mut writer = FieldWriter::new(&chain, 1000.0, 64);
        (0..10).for_each(|k| writer.see(&[f64::from(k)], f64::from(k) / 64.0));
        let cut = writer.finish();
        assert_eq!((cut.columns, cut.covered), (vec![vec![4.5]], 9.0 / 64.0));
        let strobe = field(1, 500.0, 1, |_, t| 0.001 * t);
        assert_eq!((strobe.shown, strobe.columns.len()), (FieldValue::Displacement, 501));
        assert_eq!(strobe.columns[250], [0.25]);
    }
}
