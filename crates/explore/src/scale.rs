//! How the numbers of a map become colours: as a sweep of what is seen has them.

use std::convert::Infallible;

use rayon::ThreadPool;
use serde_json::{Value, json};
use vibrochain_lattice::Stop;
use vibrochain_maps::scene::Scene;
use vibrochain_maps::sweep::{Ended, sweep};
use vibrochain_plot::{NumberScale, Quantity, Shade, number_scale};

use crate::refusal::Refusal;

/// Cells of a scene whose scale is asked for, at most: a tenth of a second on one core.
const MOST_CELLS: u64 = 1 << 15;

/// What tiles have.
const KNOWN: [Quantity; 3] = [Quantity::SpectralRadius, Quantity::Margin, Quantity::Solutions];

/// The quantity of that name, if cells of the scene have it and there are not too many of them.
pub(crate) fn asked(scene: &Scene, name: &str) -> Result<Quantity, Refusal> {
    let quantity = Quantity::from_name(name).filter(|quantity| KNOWN.contains(quantity)).ok_or_else(|| {
        Refusal::wrong(format!("color = {name} is unknown: give {}", KNOWN.map(Quantity::name).join(", ")))
    })?;
    ensure!(scene.cells() <= MOST_CELLS, "the scene has {} cells: give at most {MOST_CELLS} here", scene.cells());
    let lacks = |key| Refusal::wrong(format!("color = {name}: the scene does not compute it; add {key}"));
    quantity.of_scene(scene).map_err(lacks)?;
    Ok(quantity)
}

/// The scale of a scene's cells. `None` if `stop` was raised.
pub(crate) fn of(scene: &Scene, quantity: Quantity, pool: &ThreadPool, stop: &Stop) -> Option<Value> {
    let mut shades: Vec<Shade> = Vec::new();
    let ended = sweep(
        scene,
        pool,
        stop,
        |_| {},
        |_, cells| {
            shades.extend(cells.iter().map(|cell| quantity.shade(cell)));
            Ok::<_, Infallible>(())
        },
    );
    let Ended::Complete(_) = ended else { return None };
    let NumberScale { heading, by_logarithm, ends, ticks, below } = number_scale(quantity, &shades);
    Some(json!({ "heading": heading, "logarithm": by_logarithm, "ends": ends, "ticks": ticks, "below": below }))
}
