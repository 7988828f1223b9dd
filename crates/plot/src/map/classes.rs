//! What legends call classes of cells, and how stability is lost.

use vibrochain_breather::Family;
use vibrochain_floquet::Mechanism;
use vibrochain_maps::cell::Class;

pub(crate) const NOTHING: &str = "no physical breather";
pub(crate) const UNKNOWN: &str = "not computed (see status)";

/// Which family gives a class, 0 the double-sided, 1 the single-sided, 2 other words, and whether it is stable.
pub(crate) fn parts(class: Class) -> Option<(usize, Option<bool>)> {
    let place = |family| [Family::DoubleSided, Family::SingleSided].iter().position(|one| *one == family).unwrap_or(2);
    class.parts().map(|(family, stable)| (place(family), stable))
}

/// A class as the legend of a picture with these classes has it.
pub fn class_words<I: Iterator<Item = Class>>(class: Option<Class>, all: impl Fn() -> I) -> &'static str {
    let words = [Class::StableWord, Class::UnstableWord, Class::Word];
    let only_words = || all().all(|class| class == Class::None || words.contains(&class));
    let Some(class) = class else { return UNKNOWN };
    match class {
        Class::None => NOTHING,
        Class::StableDouble => "stable double-sided",
        Class::StableSingle => "stable single-sided",
        Class::UnstableDouble => "unstable double-sided",
        Class::UnstableSingle => "unstable single-sided",
        Class::Double => "double-sided",
        Class::Single => "single-sided",
        // The title names the words.
        Class::StableWord if only_words() => "stable breather",
        Class::UnstableWord if only_words() => "unstable breather",
        Class::Word if only_words() => "breather",
        Class::StableWord => "stable, other words",
        Class::UnstableWord => "unstable, other words",
        Class::Word => "other words",
    }
}

/// A mechanism as a legend has it.
pub fn loss(mechanism: Mechanism) -> &'static str {
    match mechanism {
        Mechanism::NeimarkSacker => "Neimark–Sacker",
        Mechanism::PeriodDoubling => "period doubling",
        Mechanism::PlusOne => "through +1",
        Mechanism::Pitchfork => "pitchfork",
    }
}
