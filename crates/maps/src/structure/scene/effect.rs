//! Whether a number of a scene changes anything: one that does not has a map of equal rows, and a branch of one orbit.

use super::StructureScene;
use crate::structure::setting::Setting;

/// Axes at whose ends all is asked together: of more, each further one doubles the work, and nothing is refused.
const MOST_AXES: u32 = 8;

impl StructureScene {
    /// Whether a number changes what the structure does, as its other numbers are now.
    ///
    /// # Errors
    /// Why it changes nothing, and what to vary instead.
    pub fn has_effect(&self, setting: Setting) -> Result<(), String> {
        let why = match setting {
            Setting::Omega if self.structure()?.has_own_period() => {
                "no load has it, and with losses or negative damping no other motion does; vary another number, or give a load"
            }
            Setting::Load if !self.modal.is_forced() => "no load changes with time; vary another number, or give one",
            Setting::Static if self.modal.modes().iter().flat_map(|mode| mode.still).all(|load| load == 0.0) => {
                "there is no static load; vary static.I, or give one"
            }
            Setting::Damping if !self.definition.has_dashpots() => "there is no dashpot; vary damping.I.J, or give one",
            Setting::Asymmetry if self.get(setting).is_none() => {
                "no contact has both barriers; vary contact.N.lower or contact.N.upper"
            }
            _ => return Ok(()),
        };
        Err(format!("{setting} changes nothing here: {why}"))
    }

    /// The same of an axis, with all others at any of their ends.
    pub(super) fn axis_has_effect(&self, setting: Setting) -> Result<(), String> {
        let refused = self.has_effect(setting);
        let others: Vec<_> = self.axes.iter().filter(|axis| axis.parameter != setting).collect();
        let count = others.len() as u32;
        if refused.is_ok() || count > MOST_AXES {
            return Ok(());
        }
        let idle = |corner: u32| {
            let mut scene = self.clone();
            let at = |(i, axis): (usize, &&crate::scene::Axis<Setting>)| {
                let end = axis.limits()[(corner >> i & 1) as usize];
                scene.set(axis.parameter, end).is_ok()
            };
            others.iter().enumerate().all(at) && scene.has_effect(setting).is_err()
        };
        if (0..1 << count).all(idle) { refused } else { Ok(()) }
    }
}
