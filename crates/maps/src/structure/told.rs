//! What pictures and answers say of a structure's scene.

use vibrochain_breather::Word;
use vibrochain_lattice::{Contact, Parameter};

use super::definition::ChainTable;
use super::map::StructureCell;
use super::scene::StructureScene;
use super::setting::Setting;
use crate::cell::{Cell, Class, Status};
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
        self.told(&|setting| self.axes.iter().any(|axis| axis.setting == setting))
    }

    /// The same of one point: what a map varies is told, too.
    #[must_use]
    pub fn here(&self) -> String {
        self.told(&|_| false)
    }

    fn told(&self, swept: &dyn Fn(Setting) -> bool) -> String {
        let plural = |count: usize, what: &str| format!("{count} {what}{}", if count == 1 { "" } else { "s" });
        let is_chain = self.is_chain();
        let contacts = self.contacts();
        let mut parts = match self.chain() {
            Some(chain) => vec![layout(chain)],
            None => vec![plural(self.modes(), "mode"), plural(contacts.len(), "contact")],
        };
        let told = |setting: Setting, usual: Option<f64>| {
            let value = self.get(setting).filter(|value| Some(*value) != usual)?;
            (!swept(setting)).then(|| format!("{} = {value}", setting.symbol(is_chain)))
        };
        parts.extend([Setting::Gamma1, Setting::Gamma2].into_iter().filter_map(|setting| told(setting, None)));
        let usual = if is_chain { 0.0 } else { 1.0 };
        for setting in [Setting::Damping, Setting::CouplingDamping, Setting::Load, Setting::Static] {
            parts.extend(told(setting, Some(usual)));
        }
        // Where they are the same for all.
        let same = |of: fn(&Contact) -> f64| {
            let first = contacts.first().map(of)?;
            contacts.iter().all(|contact| of(contact) == first).then_some(first)
        };
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
fn layout(chain: &ChainTable) -> String {
    let ChainTable { sites, ends, .. } = chain;
    let masses = if *sites == 1 { "mass" } else { "masses" };
    match ends.as_str() {
        "closed" if *sites > 1 => format!("{sites} {masses} (N = {})", sites - 1),
        "closed" => format!("{sites} {masses}"),
        ends => format!("{sites} {masses}, {ends} ends"),
    }
}

impl Setting {
    /// Its letter, or its name, on pictures: of a chain, or of what multiplies a structure's own loads and dashpots.
    #[must_use]
    pub fn symbol(self, is_chain: bool) -> String {
        let times = |what: &str| format!("{what} ×");
        match self {
            Self::Omega => Parameter::Omega.symbol().to_owned(),
            Self::Gamma1 => Parameter::Gamma1.symbol().to_owned(),
            Self::Gamma2 => Parameter::Gamma2.symbol().to_owned(),
            Self::Asymmetry => Parameter::Asymmetry.symbol().to_owned(),
            Self::RestitutionOfAll => Parameter::Restitution.symbol().to_owned(),
            Self::Load if is_chain => Parameter::Amplitude.symbol().to_owned(),
            Self::Static if is_chain => "s".to_owned(),
            Self::Damping if is_chain => "c".to_owned(),
            Self::CouplingDamping => "c₂".to_owned(),
            Self::Load => times("load"),
            Self::Static => times("static load"),
            Self::Damping => times("damping"),
            own => own.to_string(),
        }
    }

    /// What stands at an axis of it.
    #[must_use]
    pub fn label(self, is_chain: bool) -> String {
        let of = |parameter: Parameter| format!("{} {}", parameter.meaning(), parameter.symbol());
        match self {
            Self::Omega => of(Parameter::Omega),
            Self::Gamma1 => of(Parameter::Gamma1),
            Self::Gamma2 => of(Parameter::Gamma2),
            Self::Asymmetry => of(Parameter::Asymmetry),
            Self::RestitutionOfAll => of(Parameter::Restitution),
            Self::Load if is_chain => of(Parameter::Amplitude),
            Self::Static if is_chain => "static force s".to_owned(),
            Self::Damping if is_chain => "damping c".to_owned(),
            Self::CouplingDamping => "damping between neighbours c₂".to_owned(),
            Self::Load => "factor of the load".to_owned(),
            Self::Static => "factor of the static load".to_owned(),
            Self::Damping => "factor of the damping".to_owned(),
            own => own.to_string(),
        }
    }
}

impl StructureCell {
    /// What pictures show of it, of a map of these words: the first has the classes of double-sided breathers, the second those of
    /// single-sided ones, all others those of words.
    #[must_use]
    pub fn cell(&self, words: &[(Word, u32)]) -> Cell {
        let mut cell = Cell { solutions: self.solutions as u32, ..Cell::EMPTY };
        if self.trouble.is_some() {
            cell.status = Status::IllConditioned;
        }
        let Some((word, verdict, margin)) = &self.best else {
            cell.class = cell.class.filter(|_| self.trouble.is_none());
            return cell;
        };
        let place = words.iter().position(|(known, _)| known.to_string() == *word).unwrap_or(2);
        let of = |classes: [Class; 3]| classes[place.min(2)];
        cell.class = match verdict {
            None => Some(of([Class::Double, Class::Single, Class::Word])),
            Some(verdict) if verdict.marginal => None,
            Some(verdict) if verdict.stable => Some(of([Class::StableDouble, Class::StableSingle, Class::StableWord])),
            Some(_) => Some(of([Class::UnstableDouble, Class::UnstableSingle, Class::UnstableWord])),
        };
        cell.mechanism = verdict.and_then(|verdict| verdict.mechanism);
        cell.spectral_radius = verdict.map(|verdict| verdict.spectral_radius);
        Cell { margin: *margin, ..cell }
    }
}
