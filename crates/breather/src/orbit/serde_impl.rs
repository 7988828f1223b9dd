//! Values as files have them, where a derive does not say it.

use serde::de::Error as _;
use serde::ser::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use vibrochain_lattice::{Barrier, Model};

use crate::orbit::{AtContacts, Family, Impact, LatticePart, Of, Orbit, Source};

/// What `mapgen --json` tells of an orbit; its parameters stand beside it. It is written only: an orbit that is read from text is made
/// from parameters and impacts, see [`Orbit::from_impulses`].
#[derive(Serialize)]
struct PlainOrbit {
    family: Family,
    period: f64,
    phi: Option<f64>,
    psi: Option<f64>,
    impacts: Vec<PlainImpact>,
    residual: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    word: Option<String>,
}

#[derive(Serialize)]
struct PlainImpact {
    site: usize,
    barrier: Barrier,
    time: f64,
    impulse: f64,
    velocity_before: f64,
    velocity_after: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    layer: Option<usize>,
}

/// An orbit to the last bit, in formats that no person reads: sums and residual are not worked out anew.
#[derive(Serialize, Deserialize)]
struct WholeOrbit {
    model: Model,
    family: Family,
    force_periods: u32,
    psi: f64,
    impacts: Vec<Impact>,
    sources: Vec<(usize, f64)>,
    uniform_offset: f64,
    fixed_times: bool,
    residual: f64,
}

impl WholeOrbit {
    /// What all else takes for granted of an orbit.
    fn check(&self) -> Result<(), &'static str> {
        let (sites, period) = (self.model.chain().sites(), self.model.period() * f64::from(self.force_periods));
        let in_time = |impact: &Impact| (0.0..=period).contains(&impact.time);
        let hit = |site: usize| self.sources.iter().any(|(source, _)| *source == site);
        let known = self.impacts.iter().all(|impact| hit(impact.site) && in_time(impact));
        let in_order = self.impacts.is_sorted_by(|one, next| one.time <= next.time);
        let there = self.sources.iter().all(|(site, _)| *site < sites);
        match self.force_periods > 0 && known && in_order && there {
            true => Ok(()),
            false => Err("these impacts are not those of an orbit of their model"),
        }
    }
}

impl Serialize for Orbit {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if !serializer.is_human_readable() {
            let part = match &self.of {
                Of::Lattice(part) => part,
                Of::Structure(_) => {
                    return Err(S::Error::custom("orbits of lattices alone are written to binary formats"));
                }
            };
            let whole = WholeOrbit {
                model: part.model,
                family: self.family,
                force_periods: self.force_periods,
                psi: self.psi,
                impacts: self.impacts.to_vec(),
                sources: part.sources.iter().map(|source| (source.site, source.net_impulse)).collect(),
                uniform_offset: part.uniform_offset,
                fixed_times: part.fixed_times,
                residual: self.residual,
            };
            return whole.serialize(serializer);
        }
        let layout = self.model().map(|model| model.chain().layout());
        let plain = |&Impact { site, barrier, time, impulse, velocity_before, velocity_after, .. }: &Impact| {
            let (site, layer) = layout.map_or((site, None), |layout| layout.site_and_layer(site));
            PlainImpact { site, barrier, time, impulse, velocity_before, velocity_after, layer }
        };
        PlainOrbit {
            family: self.family,
            period: self.period(),
            phi: self.phi(),
            psi: self.psi(),
            impacts: self.impacts.iter().map(plain).collect(),
            residual: self.residual,
            word: self.word(),
        }
        .serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Orbit {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        if deserializer.is_human_readable() {
            return Err(D::Error::custom("an orbit is not read from text: make it from its parameters and impacts"));
        }
        let whole = WholeOrbit::deserialize(deserializer)?;
        whole.check().map_err(D::Error::custom)?;
        let source = |(site, net_impulse)| Source { site, net_impulse };
        let part = LatticePart {
            model: whole.model,
            steady: whole.model.steady().map_err(D::Error::custom)?,
            sources: whole.sources.into_iter().map(source).collect(),
            uniform_offset: whole.uniform_offset,
            fixed_times: whole.fixed_times,
            at_contacts: AtContacts::default(),
        };
        Ok(Self {
            family: whole.family,
            force_periods: whole.force_periods,
            psi: whole.psi,
            impacts: whole.impacts.into(),
            residual: whole.residual,
            of: Of::Lattice(part),
        })
    }
}
