//! All borders of a scene, with a bar that tells how far the search is.

use std::sync::Mutex;

use indicatif::ProgressBar;
use rayon::ThreadPool;
use vibrochain_lattice::Stop;
use vibrochain_maps::borders::{BorderRequest, Borders, Stage};
use vibrochain_maps::cell::Class;
use vibrochain_maps::regions::Regions;
use vibrochain_maps::scene::Scene;

use crate::common::error::CliError;
use crate::common::progress::bar;

/// What is asked of a search.
pub(crate) struct BorderSearch<'a> {
    /// How far a straight line between neighbouring points may be from the border, as a part of the window's sides.
    pub(crate) tolerance: f64,
    /// Places of the window that are asked what lives there once all borders are known.
    pub(crate) places: usize,
    /// Whether points of codimension two are wanted.
    pub(crate) special: bool,
    /// Raised to end it.
    pub(crate) stop: &'a Stop,
    /// Whether a bar is drawn.
    pub(crate) progress: bool,
}

impl BorderSearch<'_> {
    /// The borders of a scene, and the regions between them.
    ///
    /// # Errors
    /// [`CliError::Request`] as of [`Borders::of_scene`]; [`CliError::Interrupted`].
    pub(crate) fn run(&self, scene: &Scene, pool: &ThreadPool) -> Result<(Borders, Regions<Option<Class>>), CliError> {
        let bar = Bar::new(self.progress);
        let asked = BorderRequest {
            tolerance: self.tolerance,
            places: self.places,
            special: self.special,
            stop: self.stop,
            told: &|family, stage, done, all| bar.told(family, stage, done, all),
        };
        let found = pool.install(|| Borders::of_scene(scene, &asked));
        bar.finish();
        let (borders, regions) = found?;
        ensure!(!borders.interrupted, CliError::Interrupted);
        Ok((borders, regions))
    }
}

/// How far the search is.
struct Bar {
    bar: ProgressBar,
    shown: Mutex<Option<(String, Stage)>>,
}

impl Bar {
    fn new(wanted: bool) -> Self {
        Self { bar: bar(1, "{bar:32} {pos}/{len} {msg}", wanted), shown: Mutex::new(None) }
    }

    fn told(&self, family: &str, stage: Stage, done: usize, all: usize) {
        self.bar.set_length(all as u64);
        self.bar.set_position(done as u64);
        let Ok(mut shown) = self.shown.lock() else { return };
        if shown.as_ref().is_none_or(|(other, at)| other != family || *at != stage) {
            let what = match stage {
                Stage::Places => "places looked at",
                Stage::Rows => "rows searched for stripes",
                Stage::Changes => "changes explained",
                Stage::Faces => "looks at what is left",
            };
            self.bar.set_message(format!("{what}, {family}"));
            *shown = Some((family.to_owned(), stage));
        }
    }

    fn finish(&self) {
        self.bar.finish_and_clear();
    }
}
