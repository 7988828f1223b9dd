//! What a point of a structure's map says, and its columns in a table.

use std::sync::Arc;

use crate::absence::Absence;
use crate::cell::{Cell, Status};
use crate::first_obstruction::FirstObstruction;
use crate::table::columns::{Column, Found, Kind, Value};

/// Existence and stability in one word.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StructureClass {
    /// No physical orbit of these words was found.
    None,
    /// Something could not be worked out, and nothing was found.
    Unknown,
    /// A stable orbit.
    Stable,
    /// An orbit whose excess is closer to the border of stability than its own error.
    Undecided,
    /// An unstable orbit.
    Unstable,
    /// An orbit, stability not asked for, or not worked out.
    Physical,
}

vibrochain_lattice::names!(StructureClass {
    None "none", Unknown "unknown", Stable "stable", Undecided "undecided" | "marginal", Unstable "unstable", Physical "physical",
});

/// What a point says.
#[derive(Debug, Clone, PartialEq)]
pub struct StructureCell {
    /// What lives there.
    pub class: StructureClass,
    /// The word of the best orbit, with its periods of the load where these are several: a stable one if there is one, of several the first.
    pub word: Option<Arc<str>>,
    /// Why something could not be worked out.
    pub trouble: Option<String>,
    /// How the best orbit's stability is lost, its spectral radius and margin; the number of physical orbits of the words asked for, and
    /// their largest residual; whether the lists are complete, and nothing was left open. Its class is that of [`Grid::shown`](crate::grid::Grid::shown).
    pub found: Cell,
}

impl Found for StructureCell {
    fn found(&self) -> &Cell {
        &self.found
    }

    fn found_mut(&mut self) -> &mut Cell {
        &mut self.found
    }
}

impl StructureCell {
    pub(super) const EMPTY: Self = Self { class: StructureClass::None, word: None, trouble: None, found: Cell::EMPTY };

    /// What is in the way, to be filled in.
    fn first_obstruction(&mut self) -> &mut FirstObstruction {
        self.found.obstruction.get_or_insert(FirstObstruction::EMPTY)
    }

    pub(super) fn troubled(why: String) -> Self {
        Self { class: StructureClass::Unknown, trouble: Some(why), ..Self::EMPTY }
    }

    /// Its status: that of its lists, unless it has trouble of its own.
    pub(super) fn judged(mut self) -> Self {
        self.found.status = match (&self.trouble, self.class) {
            (Some(_), _) => Status::IllConditioned,
            (None, StructureClass::Undecided) => Status::Undecided,
            (None, _) => self.found.status,
        };
        self
    }
}

/// The columns after the axes, but for those common to all scenes, which stand before the last.
pub(super) const COLUMNS: [Column<StructureCell>; 7] = [
    Column {
        name: "class",
        kind: Kind::Word,
        optional: false,
        get: |cell| Some(Value::Word(cell.class.name())),
        set: |cell, value| {
            let Value::Word(name) = value else { return None };
            cell.class = StructureClass::from_name(name)?;
            Some(())
        },
    },
    Column {
        name: "word",
        kind: Kind::Word,
        optional: true,
        get: |cell| cell.word.as_deref().map(Value::Word),
        set: |cell, value| {
            let Value::Word(word) = value else { return None };
            cell.word = Some(word.into());
            Some(())
        },
    },
    Column {
        name: "trouble",
        kind: Kind::Text,
        optional: true,
        get: |cell| cell.trouble.as_deref().map(Value::Text),
        set: |cell, value| {
            let Value::Text(text) = value else { return None };
            cell.trouble = Some(text.to_owned());
            Some(())
        },
    },
    Column {
        name: "absence",
        kind: Kind::Word,
        optional: true,
        get: |cell| Some(Value::Word(cell.found.absence?.name())),
        set: |cell, value| {
            let Value::Word(name) = value else { return None };
            cell.found.absence = Some(Absence::from_name(name)?);
            Some(())
        },
    },
    Column {
        name: "obstruction_contact",
        kind: Kind::Count,
        optional: true,
        get: |cell| Some(Value::Count(cell.found.obstruction?.contact.into())),
        set: |cell, value| number(&mut cell.first_obstruction().contact, value),
    },
    Column {
        name: "obstruction_impact",
        kind: Kind::Count,
        optional: true,
        get: |cell| Some(Value::Count(cell.found.obstruction?.impact.into())),
        set: |cell, value| number(&mut cell.first_obstruction().impact, value),
    },
    Column {
        name: "obstruction_after",
        kind: Kind::Number,
        optional: true,
        get: |cell| Some(Value::Number(cell.found.obstruction?.after)),
        set: |cell, value| {
            let Value::Number(number) = value else { return None };
            cell.first_obstruction().after = number;
            Some(())
        },
    },
];

fn number(place: &mut u32, value: Value<'_>) -> Option<()> {
    let Value::Count(count) = value else { return None };
    *place = u32::try_from(count).ok()?;
    Some(())
}
