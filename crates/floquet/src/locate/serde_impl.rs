//! Events as `mapgen --json` tells them.

use serde::{Serialize, Serializer};
use vibrochain_breather::{Approach, Orbit};

use super::answer::{Branching, Event, EventSide, Evidence, Located, Unresolved};

/// As `[from, to]`.
impl Serialize for Unresolved {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        [self.from, self.to].serialize(serializer)
    }
}

/// [`Located`] as text.
#[derive(Serialize)]
struct PlainLocated<'a> {
    event: Event,
    value: f64,
    error: f64,
    evidence: PlainEvidence,
    physical: Option<bool>,
    orbit: &'a Orbit,
    sides: &'a [EventSide],
    branching: Option<&'a Branching>,
    evaluations: usize,
}

/// The mass that touches a barrier stands by its site in its layer, and by that where there are several.
#[derive(Serialize)]
#[serde(untagged)]
enum PlainEvidence {
    Touch {
        #[serde(flatten)]
        touch: Approach,
        #[serde(skip_serializing_if = "Option::is_none")]
        layer: Option<usize>,
    },
    Other(Evidence),
}

impl Serialize for Located {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self { event, value, error, ref orbit, evidence, physical, ref sides, ref branching, evaluations } = *self;
        let evidence = match evidence {
            Evidence::Touch(touch) => {
                let layout = orbit.model().map(|model| model.chain().layout());
                let (site, layer) = layout.map_or((touch.site, None), |layout| layout.site_and_layer(touch.site));
                PlainEvidence::Touch { touch: Approach { site, ..touch }, layer }
            }
            other => PlainEvidence::Other(other),
        };
        let branching = branching.as_ref();
        PlainLocated { event, value, error, evidence, physical, orbit, sides, branching, evaluations }
            .serialize(serializer)
    }
}
