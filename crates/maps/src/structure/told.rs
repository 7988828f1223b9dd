//! What pictures and answers say of a structure's scene.

use vibrochain_lattice::{Contact, DampedChain, Parameter, Row};

use super::scene::StructureScene;
use super::setting::Setting;
use crate::scene::criterion;

impl StructureScene {
    /// Its title, or what it is.
    #[must_use]
    pub fn heading(&self) -> String {
        let kind = if self.is_chain() { "Damped chain" } else { "Structure with stops" };
        self.title.clone().unwrap_or_else(|| kind.to_owned())
    }

    /// Whether it is a chain with numbers of its own.
    #[must_use]
    pub fn is_chain(&self) -> bool {
        self.chain().is_some()
    }

    /// "2 modes, 1 contact, e = 0.8, ω = 1.05": all that is fixed, in words.
    #[must_use]
    pub fn fixed(&self) -> String {
        self.told(&|setting| self.axes.iter().any(|axis| axis.parameter == setting))
    }

    /// The same of one point: what a map varies is told, too.
    #[must_use]
    pub fn here(&self) -> String {
        self.told(&|_| false)
    }

    /// Which orbits of what, and what is fixed while these numbers vary.
    #[must_use]
    pub fn fixed_but(&self, word: &str, varied: &[Setting]) -> String {
        format!("{}, {word}: {}", self.heading(), self.told(&|setting| varied.contains(&setting)))
    }

    fn told(&self, swept: &dyn Fn(Setting) -> bool) -> String {
        let plural = |count: usize, what: &str| format!("{count} {what}{}", if count == 1 { "" } else { "s" });
        let (is_chain, is_uniform) = (self.is_chain(), self.is_uniform());
        let contacts = self.contacts();
        let modes = match self.all_modes() {
            Some(all) => format!("{} of {}", self.modes(), plural(all, "mode")),
            None => plural(self.modes(), "mode"),
        };
        let mut parts = match self.chain() {
            Some(chain) if self.all_modes().is_some() => vec![layout(chain), modes],
            Some(chain) => vec![layout(chain)],
            None => vec![modes, plural(contacts.len(), "contact")],
        };
        let told = |setting: Setting, usual: Option<f64>| {
            let value = self.get(setting).filter(|value| Some(*value) != usual)?;
            (!swept(setting)).then(|| format!("{} = {value}", self.symbol(setting)))
        };
        parts.extend([Setting::Gamma1, Setting::Gamma2].into_iter().filter_map(|setting| told(setting, None)));
        // None, of what is a number of its own; what multiplies loads and dashpots is 1.
        let usual = |is_own: bool| Some(if is_own { 0.0 } else { 1.0 });
        parts.extend(told(Setting::Damping, usual(is_chain)));
        parts.extend(told(Setting::CouplingDamping, Some(0.0)));
        parts.extend(told(Setting::Load, usual(is_uniform)));
        parts.extend(told(Setting::Static, usual(is_uniform)));
        // Where they are the same for all.
        let same = |of: fn(&Contact) -> f64| {
            let first = contacts.first().map(of)?;
            contacts.iter().all(|contact| of(contact) == first).then_some(first)
        };
        let place = |contact: &Contact| Some(0.5 * (contact.lower? + contact.upper?));
        let places = contacts.iter().map(place).collect::<Option<Vec<f64>>>().unwrap_or_default();
        let middle = places.first().filter(|first| is_uniform && places.iter().all(|place| place == *first));
        if let Some(middle) = middle
            && !swept(Setting::Asymmetry)
        {
            // Without the rounding of the two barriers that it is the middle of.
            let rounded = format!("{middle:.14e}").parse().unwrap_or(*middle);
            parts.push(format!("{} = {rounded}", Parameter::Asymmetry.symbol()));
        }
        let own = |one: &dyn Fn(usize) -> Setting| (0..contacts.len()).any(|contact| swept(one(contact)));
        if let Some(e) = same(|contact| contact.restitution)
            && !swept(Setting::RestitutionOfAll)
            && !own(&Setting::Restitution)
        {
            parts.push(format!("{} = {e}", Parameter::Restitution.symbol()));
        }
        parts.extend(told(Setting::Omega, None));
        parts.join(", ")
    }

    /// What counts as stable, if stability is asked for.
    #[must_use]
    pub fn criterion(&self) -> String {
        if self.stability { criterion(self.tolerance) } else { String::new() }
    }
}

/// As a chain's layout is told.
fn layout(chain: &DampedChain) -> String {
    let DampedChain { sites, ends, .. } = *chain;
    let masses = if sites == 1 { "mass" } else { "masses" };
    match ends.name() {
        "closed" if sites > 1 => format!("{sites} {masses} (N = {})", sites - 1),
        "closed" => format!("{sites} {masses}"),
        ends => format!("{sites} {masses}, {ends} ends"),
    }
}

impl StructureScene {
    /// The parameter of a chain that a number is; what multiplies loads and dashpots is none.
    fn row(&self, setting: Setting) -> Option<&'static Row> {
        let is_own = match setting {
            Setting::Load | Setting::Static => self.is_uniform(),
            Setting::Damping => self.is_chain(),
            _ => true,
        };
        setting.row().filter(|_| is_own)
    }

    /// The letter of a number, or its name, on pictures.
    fn symbol(&self, setting: Setting) -> String {
        match (self.row(setting), setting) {
            (Some(row), _) => row.symbol.to_owned(),
            (None, Setting::Load) => "factor of the load".to_owned(),
            (None, Setting::Static) => "factor of the static load".to_owned(),
            (None, Setting::Damping) => "factor of the damping".to_owned(),
            (None, own) => own.to_string(),
        }
    }

    /// What stands at an axis of it.
    #[must_use]
    pub fn label(&self, setting: Setting) -> String {
        match setting {
            Setting::Lower(contact) => format!("lower barrier of contact {contact}"),
            Setting::Upper(contact) => format!("upper barrier of contact {contact}"),
            Setting::Restitution(contact) => format!("restitution of contact {contact}"),
            Setting::LoadOf(coordinate) => format!("load on coordinate {coordinate}"),
            Setting::StaticOf(coordinate) => format!("static load on coordinate {coordinate}"),
            Setting::Entry(matrix, row, column) => format!("{} at ({row}, {column})", matrix.name()),
            _ => match self.row(setting) {
                Some(row) => format!("{} {}", row.meaning, row.symbol),
                None => self.symbol(setting),
            },
        }
    }
}
