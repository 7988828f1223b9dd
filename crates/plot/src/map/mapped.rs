//! What a picture says of a map and along which axes it lies: of a chain's scene, or of a structure's.

use std::ops::Range;

use vibrochain_maps::cell::Class;
use vibrochain_maps::scene::{Axis, Scene, Values};
use vibrochain_maps::structure::{Setting, StructureScene};

use crate::axes::axis::spanned;
use crate::backend::format::PlotError;
use crate::map::classes::{NOTHING, class_words, parts};
use crate::map::quantity::Quantity;

/// An axis of a map.
#[derive(Debug, Clone, PartialEq)]
pub struct MapAxis {
    /// Its name in scenes and tables.
    pub name: String,
    /// What stands at it.
    pub label: String,
    /// The values along it.
    pub values: Values,
}

impl From<&Axis> for MapAxis {
    fn from(axis: &Axis) -> Self {
        let label = format!("{} {}", axis.parameter.meaning(), axis.parameter.symbol());
        Self { name: axis.parameter.name().to_owned(), label, values: axis.values.clone() }
    }
}

impl MapAxis {
    /// What its values span, with so many steps of air at either end.
    pub(crate) fn spanned(&self, air: f64) -> Range<f64> {
        spanned(&self.values, self.values.points(), air)
    }
}

/// What can be drawn as a map.
pub trait Mapped: std::fmt::Debug {
    /// The title.
    fn heading(&self) -> String;

    /// Lines under it: all that is fixed, what counts as stable.
    fn notes(&self) -> Vec<String>;

    /// The axes, the fastest first.
    fn axes(&self) -> Vec<MapAxis>;

    /// What the legend calls a class beside others.
    fn class(&self, class: Class, all: &[Class]) -> String;

    /// What it calls its motions.
    fn orbit(&self) -> &'static str {
        "breather"
    }

    /// Whether its cells have a number; if not, the key of the scene that asks for it.
    ///
    /// # Errors
    /// That key, as it stands in `[compute]`.
    fn has(&self, quantity: Quantity) -> Result<(), &'static str>;
}

/// The axes of what has two.
///
/// # Errors
/// [`PlotError`] of what has not.
pub(crate) fn plane(scene: &dyn Mapped) -> Result<[MapAxis; 2], PlotError> {
    <[MapAxis; 2]>::try_from(scene.axes()).map_err(|_| PlotError("a map has two axes".to_owned()))
}

/// What the picture of a scene says above its panels: heading, all that is fixed, and what counts as stable.
pub fn about(scene: &dyn Mapped) -> String {
    std::iter::once(scene.heading()).chain(scene.notes()).collect::<Vec<_>>().join(", ")
}

fn told(lines: [String; 2]) -> Vec<String> {
    lines.into_iter().filter(|line| !line.is_empty()).collect()
}

impl Mapped for Scene {
    fn heading(&self) -> String {
        Self::heading(self)
    }

    fn notes(&self) -> Vec<String> {
        told([self.fixed(), self.criterion()])
    }

    fn axes(&self) -> Vec<MapAxis> {
        self.axes.iter().map(MapAxis::from).collect()
    }

    fn class(&self, class: Class, all: &[Class]) -> String {
        class_words(Some(class), || all.iter().copied()).to_owned()
    }

    fn has(&self, quantity: Quantity) -> Result<(), &'static str> {
        quantity.of_scene(self)
    }
}

impl Mapped for StructureScene {
    fn heading(&self) -> String {
        Self::heading(self)
    }

    fn notes(&self) -> Vec<String> {
        told([self.fixed(), self.criterion()])
    }

    fn axes(&self) -> Vec<MapAxis> {
        let axis = |(axis, name): (&Axis<Setting>, &String)| MapAxis {
            name: name.clone(),
            label: self.label(axis.parameter),
            values: axis.values.clone(),
        };
        self.axes.iter().zip(&self.axis_names).map(axis).collect()
    }

    fn orbit(&self) -> &'static str {
        "orbit"
    }

    /// The first word has the colours of double-sided breathers, the second those of single-sided ones, all others those of words.
    fn class(&self, class: Class, _: &[Class]) -> String {
        let words: Vec<String> = self.words.iter().map(|(word, _)| word.to_string()).collect();
        let Some((place, stable)) = parts(class) else { return NOTHING.replace("breather", "orbit") };
        let how = stable.map_or("", |stable| if stable { "stable " } else { "unstable " });
        match words.get(place) {
            Some(word) if place < 2 || words.len() == 3 => format!("{how}{word}"),
            _ => format!("{how}{}", if how.is_empty() { "other words" } else { "orbits of other words" }),
        }
    }

    fn has(&self, quantity: Quantity) -> Result<(), &'static str> {
        match quantity {
            Quantity::SpectralRadius if !self.stability => Err("stability = true"),
            Quantity::Impulse => Err("an impulse, which maps of structures do not have"),
            _ => Ok(()),
        }
    }
}
