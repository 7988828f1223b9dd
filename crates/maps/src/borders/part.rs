//! One family or word of a scene at a time.

use vibrochain_breather::{Finder, Found, Orbit, Wanted, Word};
use vibrochain_floquet::Tolerance;
use vibrochain_lattice::Model;

use crate::cell::{Class, Task, Worker};
use crate::regions::Window;
use crate::scene::Scene;

/// A family or word.
#[derive(Debug, Clone)]
pub(super) struct Part {
    /// As the scene names it.
    pub(super) name: String,
    /// What is computed of it.
    pub(super) task: Task,
}

impl Part {
    /// Whether stability is lost at events: with a growth allowed it is not.
    pub(super) fn is_strict(&self) -> bool {
        self.task.stability && self.task.tolerance == Tolerance::Rounding
    }
}

/// All parts of a scene.
pub(super) fn parts(task: &Task) -> Vec<Part> {
    let plain = Task { collisions: false, ..task.clone() };
    let families =
        task.families.iter().map(|&family| Task { families: vec![family], words: Vec::new(), ..plain.clone() });
    let words = task.words.iter().map(|word| Task { families: Vec::new(), words: vec![word.clone()], ..plain.clone() });
    let named = |task: Task| {
        let name = task.family_names().next().unwrap_or_default();
        Part { name, task }
    };
    families.chain(words).map(named).collect()
}

/// Who looks at places of the window, given as parts of its sides.
pub(super) struct Eye<'a> {
    pub(super) scene: &'a Scene,
    pub(super) window: Window,
    worker: Worker,
    finder: Finder,
}

impl<'a> Eye<'a> {
    pub(super) fn new(scene: &'a Scene, window: Window) -> Self {
        let sites = scene.base.sites();
        Self { scene, window, worker: Worker::new(sites), finder: Finder::new(sites) }
    }

    pub(super) fn model(&self, place: [f64; 2]) -> Option<Model> {
        // The scene's corners were checked, so that every point between is a valid model.
        self.scene.at(&self.window.point(place)).model().ok()
    }

    /// What lives there; `None` where that is not known.
    pub(super) fn class(&mut self, part: &Part, place: [f64; 2]) -> Option<Class> {
        let model = self.model(place)?;
        self.worker.cell(&model, &part.task).class
    }

    /// The physical orbits there.
    pub(super) fn orbits(&mut self, part: &Part, place: [f64; 2]) -> Vec<Orbit> {
        let Some(model) = self.model(place) else { return Vec::new() };
        let word: Option<&Word> = part.task.words.first();
        let wanted = if part.task.symmetric { Wanted::SymmetricCandidates } else { Wanted::Candidates };
        let mut found = Found::default();
        let searched = match (word, part.task.families.first()) {
            (Some(word), _) => self.finder.find_word(&model, word, wanted, &mut found),
            (None, Some(&family)) => self.finder.search(&model, family, wanted, &mut found),
            (None, None) => return Vec::new(),
        };
        if searched.is_err() {
            return Vec::new();
        }
        let physical = |orbit: &Orbit| self.finder.quick_admissibility(orbit).is_ok_and(|answer| answer.is_physical());
        found.orbits.into_iter().filter(physical).collect()
    }
}
