//! Impact words of two instants.

use pyo3::prelude::*;
use vibrochain_breather::{Family, Word};

use crate::failure::{Failure, named};
use crate::params::PyModel;

/// The most words that are looked at before symmetry makes them fewer.
const MOST: f64 = 1e6;

/// Words on so many sites, each of which hits as one of the families does.
#[pyfunction]
pub(crate) fn _words(
    model: PyRef<'_, PyModel>,
    sites_used: u32,
    reach: u32,
    families: Vec<String>,
) -> PyResult<Vec<String>> {
    let (model, sites, reach) = (&model.0, sites_used as usize, reach as usize);
    let known = [Family::DoubleSided, Family::SingleSided];
    let families = families.iter().map(|name| named("families", name, known.map(|family| (family.name(), family))));
    let families = families.collect::<Result<Vec<_>, Failure>>()?;
    let layout = model.chain().layout();
    let most = (reach.min(layout.length.saturating_sub(1)) + 1) * layout.layers;
    if sites == 0 || sites > most {
        let message = format!("sites_used = {sites} is out of range: a reach of {reach} has room for 1 to {most}");
        return Err(Failure::request(message).into());
    }
    if Word::combinations(&layout, sites, reach, &families) > MOST {
        let message = "these are more than a million words: give fewer sites, a smaller reach or one family";
        return Err(Failure::TooLarge(message.to_owned()).into());
    }
    let words = Word::enumerate(model, sites, reach, &families).map_err(Failure::from)?;
    Ok(words.iter().map(Word::to_string).collect())
}
