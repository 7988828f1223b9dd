//! Ensembles as the content of tables that are computed in chunks: a row a breather, one for a cell without any.

use std::ops::Range;
use std::path::Path;

use vibrochain_maps::error::MapError;
use vibrochain_maps::summary::Summary;
use vibrochain_maps::sweep::{Block, Content, Ended, Job, Settings, Sink};
use vibrochain_maps::table::{ColumnType, Rows, TableFile};

use crate::ensemble::Ensemble;
use crate::fates::{CellFates, Ensembled, From, of_parts};
use crate::reader::Reader;
use crate::table::{header, rows, text, types};

/// Periods of all runs of a chunk: some seconds of work on rings of some twenty masses, which an interruption may cost.
const CHUNK_PERIODS: u64 = 1 << 16;

/// The most cells of a chunk: even where nothing lives each costs a search.
const MOST_CELLS: u64 = 512;

/// The setting of [`Ensemble::in_sequence`], which is there or not.
const IN_SEQUENCE: &str = "in-sequence";

/// What is asked of all cells of a scene.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Fates {
    /// The runs from each breather.
    pub ensemble: Ensemble,
    /// From which breathers they start.
    pub from: From,
}

impl Fates {
    /// Cells of a chunk, by what is asked alone.
    #[must_use]
    pub fn chunk_cells(&self) -> u64 {
        let periods = self.ensemble.starts.saturating_mul(self.ensemble.periods);
        (CHUNK_PERIODS / periods.max(1)).clamp(1, MOST_CELLS)
    }

    /// All of it, by the names of the program's flags.
    #[must_use]
    pub fn settings(&self) -> Settings {
        let Ensemble { starts, size, seed, periods, transient, tolerance, leave, in_sequence } = self.ensemble;
        let all = [
            ("breathers", self.from.name().to_owned()),
            ("starts", starts.to_string()),
            ("perturb", size.to_string()),
            ("seed", seed.to_string()),
            ("periods", periods.to_string()),
            ("transient", transient.to_string()),
            ("tolerance", tolerance.to_string()),
            ("leave", leave.to_string()),
        ];
        let in_sequence = in_sequence.then(|| (IN_SEQUENCE, true.to_string()));
        all.into_iter().chain(in_sequence).map(|(name, value)| (name.to_owned(), value)).collect()
    }

    /// What [`Fates::settings`] was made of.
    ///
    /// # Errors
    /// What is missing, or is no such value.
    pub fn from_settings(settings: &Settings) -> Result<Self, String> {
        fn value<T: std::str::FromStr>(settings: &Settings, name: &str) -> Result<T, String> {
            let text = settings.get(name).ok_or_else(|| format!("its ensemble has no {name}"))?;
            text.parse().map_err(|_| format!("the {name} of its ensemble is `{text}`"))
        }
        let ensemble = Ensemble {
            starts: value(settings, "starts")?,
            size: value(settings, "perturb")?,
            seed: value(settings, "seed")?,
            periods: value(settings, "periods")?,
            transient: value(settings, "transient")?,
            tolerance: value(settings, "tolerance")?,
            leave: value(settings, "leave")?,
            in_sequence: settings.contains_key(IN_SEQUENCE),
        };
        let name: String = value(settings, "breathers")?;
        let from = From::from_name(&name).ok_or_else(|| format!("the breathers of its ensemble are `{name}`"))?;
        Ok(Self { ensemble, from })
    }
}

impl<S: Ensembled> Content<S> for Fates {
    type Item = CellFates;
    type Layout = Vec<ColumnType>;
    type Reader<'a>
        = Reader<'a, S>
    where
        S: 'a;

    fn header(&self, scene: &S) -> String {
        // Names of plain letters need no quotes.
        header(scene).join(",") + "\n"
    }

    fn create(&self, out: &Path, scene: &S, threads: usize) -> Result<TableFile, MapError> {
        TableFile::create(out, &types(scene), threads)
    }

    fn layout(&self, scene: &S) -> Vec<ColumnType> {
        types(scene)
    }

    /// The values are those of the rows of text.
    fn put(
        &self,
        table: &mut TableFile,
        (scene, columns): (&S, &Vec<ColumnType>),
        _: u64,
        cell: &CellFates,
    ) -> Result<(), MapError> {
        for row in rows(scene, cell) {
            let fields = columns.iter().zip(&row);
            table.row(fields.map(|(column, text)| column.kind.value(text).filter(|_| !text.is_empty())))?;
        }
        Ok(())
    }

    fn compute(
        &self,
        job: &Job<'_, S>,
        parts: &[Range<u64>],
        wanted: bool,
        tick: &(dyn Fn(u64) + Sync),
        sink: Sink<'_, CellFates>,
    ) -> Ended<MapError> {
        of_parts(job, (&self.ensemble, self.from), parts, tick, |part, last, cell| {
            let cells = cell.number..cell.number + 1;
            let summary = Summary::of(&[cell.cell]);
            let text = text(job.scene, &cell)?;
            let rows =
                Rows { range: cells.clone(), text, cells: wanted.then_some((cell.number, cell)).into_iter().collect() };
            sink(Block { part, cells, last, summary, made: rows })
        })
    }

    fn reader<'a>(&self, scene: &'a S, cells: Range<u64>) -> Reader<'a, S> {
        Reader::new(scene, cells, self.ensemble.starts)
    }
}
