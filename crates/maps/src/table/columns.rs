//! The columns of a table: first the parameters, then what was found. A new one of a chain is a line here and a field of [`Cell`].

use vibrochain_floquet::{Collision, Mechanism};
use vibrochain_lattice::Parameter;

use crate::cell::{Cell, Class, Status, Task};
use crate::scene::Scene;

/// A value of a cell in a table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Value<'a> {
    /// Finite.
    Number(f64),
    /// Of things.
    Count(u64),
    /// One of a few words.
    Word(&'a str),
    /// Any text.
    Text(&'a str),
}

/// What the values of a column are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// [`Value::Number`]
    Number,
    /// [`Value::Count`]
    Count,
    /// [`Value::Word`]
    Word,
    /// [`Value::Text`]
    Text,
}

impl Kind {
    /// The value in a field; `None` of one that has none.
    pub fn value(self, text: &str) -> Option<Value<'_>> {
        match self {
            Self::Number => text.parse().ok().filter(|number: &f64| number.is_finite()).map(Value::Number),
            Self::Count => text.parse().ok().map(Value::Count),
            Self::Word => Some(Value::Word(text)),
            Self::Text => Some(Value::Text(text)),
        }
    }
}

/// A column of what was found in a cell.
#[derive(Debug, Clone, Copy)]
pub struct Column<T = Cell> {
    /// Its name in files.
    pub name: &'static str,
    /// What its values are.
    pub kind: Kind,
    /// Whether a cell may have none.
    pub optional: bool,
    /// The value of a cell.
    pub get: for<'a> fn(&'a T) -> Option<Value<'a>>,
    /// Puts a value into a cell; `None` for one that it cannot have.
    pub set: fn(&mut T, Value<'_>) -> Option<()>,
}

/// What is found in the cells of a scene of any kind.
pub(crate) trait Found {
    /// What all kinds have.
    fn found(&self) -> &Cell;

    /// The same, to be filled in.
    fn found_mut(&mut self) -> &mut Cell;
}

impl Found for Cell {
    fn found(&self) -> &Cell {
        self
    }

    fn found_mut(&mut self) -> &mut Cell {
        self
    }
}

/// A column of a number that a cell may have, read at one place and written at another.
macro_rules! number {
    ($name:literal, $cell:ident => $read:expr, $write:expr) => {
        Column {
            name: $name,
            kind: Kind::Number,
            optional: true,
            get: |$cell| $read.map(Value::Number),
            set: |$cell, value| number(&mut $write, value),
        }
    };
}

/// A column of a count within a part that a cell may have, whose function writes it.
macro_rules! count {
    ($name:literal, $optional:literal, $part:ident.$($place:tt)+) => {
        Column {
            name: $name,
            kind: Kind::Count,
            optional: $optional,
            get: |cell| Some(Value::Count(cell.$part?.$($place)+ as u64)),
            set: |cell, value| $part(cell, value, |part| &mut part.$($place)+),
        }
    };
}

/// How stability is lost, the spectral radius and the margin of what gives a cell its class, how many there are, and the status.
pub(crate) const fn common<T: Found>() -> [Column<T>; 5] {
    [
        Column {
            name: "mechanism",
            kind: Kind::Word,
            optional: true,
            get: |cell| Some(Value::Word(cell.found().mechanism?.name())),
            set: |cell, value| {
                let Value::Word(name) = value else { return None };
                cell.found_mut().mechanism = Some(Mechanism::from_name(name)?);
                Some(())
            },
        },
        number!("spectral_radius", cell => cell.found().spectral_radius, cell.found_mut().spectral_radius),
        number!("margin", cell => cell.found().margin, cell.found_mut().margin),
        Column {
            name: "solutions",
            kind: Kind::Count,
            optional: false,
            get: |cell| Some(Value::Count(cell.found().solutions.into())),
            set: |cell, value| {
                let Value::Count(count) = value else { return None };
                cell.found_mut().solutions = u32::try_from(count).ok()?;
                Some(())
            },
        },
        Column {
            name: "status",
            kind: Kind::Word,
            optional: false,
            get: |cell| Some(Value::Word(cell.found().status.name())),
            set: |cell, value| {
                let Value::Word(name) = value else { return None };
                cell.found_mut().status = Status::from_name(name)?;
                Some(())
            },
        },
    ]
}

/// The first column of what was found.
const CLASS: Column = Column {
    name: "class",
    kind: Kind::Word,
    optional: true,
    get: |cell| Some(Value::Word(cell.class?.name())),
    set: |cell, value| {
        cell.class = Some(Class::ALL.into_iter().find(|class| value == Value::Word(class.name()))?);
        Some(())
    },
};

/// Further columns where the modes that have collided are asked for.
const COLLISION: [Column; 3] = [
    count!("mode1", true, collision.modes.0),
    count!("mode2", true, collision.modes.1),
    count!("harmonic", true, collision.harmonic),
];

/// A further column where it is asked for.
const IMPULSE: [Column; 1] = [number!("impulse", cell => cell.impulse, cell.impulse)];

fn number(place: &mut Option<f64>, value: Value<'_>) -> Option<()> {
    let Value::Number(number) = value else { return None };
    *place = Some(number);
    Some(())
}

fn collision(cell: &mut Cell, value: Value<'_>, place: fn(&mut Collision) -> &mut usize) -> Option<()> {
    let Value::Count(count) = value else { return None };
    let nothing = Collision { modes: (0, 0), harmonic: 0, detuning: None };
    *place(cell.collision.get_or_insert(nothing)) = usize::try_from(count).ok()?;
    Some(())
}

/// The parameters with a column of their own: always gamma2 and omega, and whatever else is swept, slowest first.
#[must_use]
pub fn parameters(scene: &Scene) -> Vec<Parameter> {
    let mut shown = vec![Parameter::Gamma2, Parameter::Omega];
    for axis in scene.axes.iter().rev() {
        if !shown.contains(&axis.parameter) {
            shown.push(axis.parameter);
        }
    }
    shown
}

/// The columns after the parameters.
pub fn columns(scene: &Scene) -> impl Iterator<Item = Column> + use<> {
    let Task { impulse, collisions, .. } = scene.task;
    let further = IMPULSE.into_iter().filter(move |_| impulse);
    let found = [CLASS].into_iter().chain(common()).chain(further);
    found.chain(COLLISION.into_iter().filter(move |_| collisions))
}
