//! One family or word of a scene at a time.

use vibrochain_breather::{Finder, Orbit, OrbitList, Scope, Word};
use vibrochain_floquet::Tolerance;
use vibrochain_lattice::{Model, Stop};

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
    /// The same where it is only asked whether there is one.
    existence: Task,
}

impl Part {
    /// Whether stability is lost at events: with an excess allowed it is not.
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
        let existence = Task { stability: false, ..task.clone() };
        Part { name, task, existence }
    };
    families.chain(words).map(named).collect()
}

/// Finds the class at places of the window, given as parts of its sides.
pub(super) struct ClassProbe<'a> {
    pub(super) scene: &'a Scene,
    pub(super) window: Window,
    worker: Worker,
    finder: Finder,
}

impl<'a> ClassProbe<'a> {
    /// Once `stop` is raised it finds none.
    pub(super) fn new(scene: &'a Scene, window: Window, stop: &Stop) -> Self {
        let sites = scene.base.sites();
        Self { scene, window, worker: Worker::new(sites).until(stop), finder: Finder::new(sites).until(stop) }
    }

    pub(super) fn stop(&self) -> &Stop {
        self.finder.stop()
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

    /// Whether something may live there, stable or not.
    pub(super) fn may_live(&mut self, part: &Part, place: [f64; 2]) -> bool {
        let Some(model) = self.model(place) else { return true };
        self.worker.cell(&model, &part.existence).class != Some(Class::None)
    }

    /// The physical orbits there.
    pub(super) fn orbits(&mut self, part: &Part, place: [f64; 2]) -> Vec<Orbit> {
        let Some(model) = self.model(place) else { return Vec::new() };
        let word: Option<&Word> = part.task.words.first();
        let wanted = if part.task.symmetric { Scope::SymmetricCandidates } else { Scope::Candidates };
        let mut found = OrbitList::default();
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

#[cfg(test)]
mod tests {
    use std::path::Path;

    use fastrand::Rng;

    use super::*;

    /// Against the class, which needs a verdict.
    #[test]
    fn something_may_live_where_the_class_is_another_than_none() {
        let scene = Scene::parse(
            Path::new("scene.toml"),
            "[model]\nsites = 6\ngamma1 = 0.2\nasymmetry = 0.4\n[sweep]\n\
             x = { parameter = \"omega\", from = 0.4, to = 3.0, points = 40 }\n\
             y = { parameter = \"gamma2\", from = 0.0, to = 0.3, points = 60 }\n\
             [compute]\nfamilies = [\"double-sided\", \"single-sided\"]\nstability = true\n",
        );
        let scene = scene.unwrap();
        let mut probe = ClassProbe::new(&scene, Window::of(&scene).unwrap(), &Stop::default());
        let mut random = Rng::with_seed(3);
        let mut times = [0; 2];
        for part in &parts(&scene.task) {
            for _ in 0..500 {
                // Some on the side where nothing couples masses.
                let place = [random.f64(), (1.1 * random.f64() - 0.1).max(0.0)];
                let lives = probe.class(part, place) != Some(Class::None);
                assert_eq!(probe.may_live(part, place), lives, "{} {place:?}", part.name);
                times[usize::from(lives)] += 1;
            }
        }
        assert!(times.iter().all(|times| *times > 100), "{times:?}");
    }
}
