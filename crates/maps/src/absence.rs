//! Why a point has no physical orbit.

/// Why a point of a map has no physical orbit. Of several candidates that are not physical the first decides.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Absence {
    /// There is no orbit whose barriers push.
    NoOrbit,
    /// None was found, by a search that may miss some.
    NotFound,
    /// At an impact the contact moves away from its barrier, which would have to pull.
    WrongSign,
    /// A contact begins to rest at its barrier after a plastic impact.
    Sticks,
    /// A contact is beyond a barrier within [`AT_ONCE`] of the period after an impact.
    CrossesAtOnce,
    /// A contact is beyond a barrier later.
    Crosses,
}

vibrochain_lattice::names!(Absence {
    NoOrbit "no-orbit", NotFound "not-found", WrongSign "wrong-sign", Sticks "sticks", CrossesAtOnce "crosses-at-once", Crosses "crosses",
});

/// The part of a period after an impact that is soon: a light contact that rings, or bounces, comes back in it.
pub const AT_ONCE: f64 = 0.1;

impl Absence {
    /// In the summary of a map.
    #[must_use]
    pub fn told(self) -> String {
        match self {
            Self::NoOrbit => "there is no orbit".to_owned(),
            Self::NotFound => "no orbit was found".to_owned(),
            Self::WrongSign => "not physical: a barrier would have to pull".to_owned(),
            Self::Sticks => "not physical: a contact begins to rest at its barrier".to_owned(),
            Self::CrossesAtOnce => {
                format!("not physical: a contact is beyond a barrier within {AT_ONCE} of a period after an impact")
            }
            Self::Crosses => "not physical: a contact is beyond a barrier later than that".to_owned(),
        }
    }
}
