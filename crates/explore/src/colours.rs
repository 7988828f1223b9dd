//! The colours and textures of printed maps, for the page.

use serde_json::{Value, json};
use vibrochain_floquet::Mechanism;
use vibrochain_maps::cell::{Class, Status};
use vibrochain_plot::palette::{BORDERS, sample};
use vibrochain_plot::{Palette, Tile};

/// Pixels after which every texture repeats, both ways: of stripes that are 6 apart, dots that are 4 apart.
const PERIOD: u32 = 12;

/// Steps of the scale of numbers: more than a screen tells apart.
const STEPS: u32 = 512;

/// Names of classes, mechanisms and statuses, in the order of a tile's bytes, the pixels of each pair of class and mechanism, by rows, as
/// numbers of 24 bits, those of each mechanism in a legend, the colours of borders, of the scale of numbers from its foot, and of what is below.
pub(crate) fn value() -> Value {
    let mechanisms = || std::iter::once(None).chain(Mechanism::ALL.into_iter().map(Some));
    let classes = || std::iter::once(None).chain(Class::ALL.into_iter().map(Some));
    let tiles = classes().flat_map(|class| mechanisms().map(move |mechanism| Tile { class, mechanism }));
    let tiles: Vec<Value> = tiles
        .map(|tile| {
            json!({
                "class": tile.class.map(Class::name),
                "mechanism": tile.mechanism.map(Mechanism::name),
                "pixels": pattern(|x, y| Palette::default().pixel(tile, x, y)).collect::<Vec<_>>(),
            })
        })
        .collect();
    let samples = Mechanism::ALL.map(|mechanism| {
        json!({ "mechanism": mechanism.name(), "pixels": pattern(|x, y| sample(mechanism, x, y)).collect::<Vec<_>>() })
    });
    let step = |i: u32| number(Palette::default().scale(f64::from(i) / f64::from(STEPS - 1)));
    json!({
        "classes": Class::ALL.map(Class::name),
        "mechanisms": Mechanism::ALL.map(Mechanism::name),
        "statuses": Status::ALL.map(Status::name),
        "period": PERIOD,
        "tiles": tiles,
        "samples": samples,
        "borders": BORDERS.map(number),
        "scale": (0..STEPS).map(step).collect::<Vec<_>>(),
        "below": number(Palette::default().below()),
    })
}

fn pattern(colour: impl Fn(u32, u32) -> [u8; 3]) -> impl Iterator<Item = u32> {
    let places = (0..PERIOD).flat_map(|y| (0..PERIOD).map(move |x| (x, y)));
    places.map(move |(x, y)| number(colour(x, y)))
}

fn number(colour: [u8; 3]) -> u32 {
    let [r, g, b] = colour.map(u32::from);
    r << 16 | g << 8 | b
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Should the textures of printed maps change, this says whether the page still shows them.
    #[test]
    fn textures_repeat_after_the_pixels_that_are_handed_over() {
        let value = value();
        let mut seen = 0;
        for class in Class::ALL.into_iter().map(Some).chain([None]) {
            for mechanism in Mechanism::ALL.into_iter().map(Some).chain([None]) {
                let tile = Tile { class, mechanism };
                let far = |x: u32, y: u32| Palette::default().pixel(tile, x, y);
                for (x, y) in (0..40).flat_map(|x| (0..40).map(move |y| (x, y))) {
                    assert_eq!(far(x, y), far(x % PERIOD, y % PERIOD), "{tile:?} at {x}, {y}");
                }
                let names = [class.map(Class::name), mechanism.map(Mechanism::name)].map(Value::from);
                let here = value["tiles"].as_array().unwrap().iter();
                let found = here.filter(|one| [&one["class"], &one["mechanism"]] == [&names[0], &names[1]]).count();
                assert_eq!(found, 1, "{tile:?}");
                seen += 1;
            }
        }
        assert_eq!(seen, (Class::ALL.len() + 1) * (Mechanism::ALL.len() + 1));
    }
}
