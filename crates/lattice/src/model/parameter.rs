//! The table of the model's real parameters. Whatever reads, writes, shows or varies one takes it from here: flags, scenes, JSON, columns,
//! Python, schemas and the explorer's controls. A new parameter is a row of it, and what it does in [`Model`](crate::Model), or, of one that
//! models do not have, in the structure that the chain is then.

use std::sync::LazyLock;

use crate::error::{MAX_MAGNITUDE, ParameterError, check};

/// The values that a parameter may have.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    /// Least value.
    pub least: f64,
    /// Largest value.
    pub most: f64,
    /// Which of the two it may not have itself.
    pub open: [bool; 2],
    /// The range in words, after "give".
    pub told: &'static str,
}

impl Range {
    const STIFFNESS: Self =
        Self { least: 0.0, most: MAX_MAGNITUDE, open: [false; 2], told: "a finite number from 0 to 1e100" };

    /// Any number of a size that can be computed with.
    pub const REAL: Self = Self {
        least: -MAX_MAGNITUDE,
        most: MAX_MAGNITUDE,
        open: [false; 2],
        told: "a number between -1e100 and 1e100",
    };

    /// Whether it holds a value.
    pub fn contains(&self, value: f64) -> bool {
        let inside = (self.least..=self.most).contains(&value);
        inside && !(self.open[0] && value == self.least || self.open[1] && value == self.most)
    }
}

/// What a parameter takes part in, which tells where it may be left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// The springs of every lattice.
    Lattice,
    /// The springs between layers: a lattice of one has none.
    Layers,
    /// The period and the barriers.
    Motion,
    /// The force and what impacts lose: a conservative model has none.
    Driving,
    /// Dashpots: most models have none.
    Dashpots,
}

/// A row of the table.
#[derive(Debug)]
pub struct Row {
    /// The name in scenes, tables, JSON and Python; words are joined by `_`, in its flag by `-`.
    pub name: &'static str,
    /// The letter on pictures, and of its flag's value.
    pub symbol: &'static str,
    /// What it is, on the axes of pictures.
    pub meaning: &'static str,
    /// The same in a word, before the letter.
    pub word: &'static str,
    /// What its flag says.
    pub help: &'static str,
    /// Its values.
    pub range: Range,
    /// What it takes part in.
    pub part: Part,
    /// Its value where it is left out; `None` where it must be given.
    pub default: Option<f64>,
    /// Ends and step of the explorer's slider.
    pub slider: [f64; 3],
}

/// Hands the rows of the table to a macro: documentation, variant, name, and all else.
macro_rules! parameters {
    ($made:ident) => {
        $made! {
            /// On-site stiffness γ₁.
            Gamma1 gamma1 {
                symbol: "γ₁", meaning: "on-site stiffness", word: "stiffness", help: "On-site stiffness γ₁",
                range: Range::STIFFNESS, part: Part::Lattice, default: None, slider: [0.0, 2.0, 0.01],
            }
            /// Coupling stiffness γ₂ along the rows.
            Gamma2 gamma2 {
                symbol: "γ₂", meaning: "coupling stiffness", word: "coupling", help: "Coupling stiffness γ₂",
                range: Range::STIFFNESS, part: Part::Lattice, default: None, slider: [0.0, 1.0, 0.005],
            }
            /// Frequency ω of the force, and of a map.
            Omega omega {
                symbol: "ω", meaning: "frequency", word: "frequency", help: "Frequency ω of the force, and of the map",
                range: Range {
                    least: 1.0 / MAX_MAGNITUDE, most: MAX_MAGNITUDE, open: [false; 2], told: "a positive number, 1e-100 to 1e100",
                },
                part: Part::Motion, default: None, slider: [0.1, 5.0, 0.01],
            }
            /// Centre a of the gap.
            Asymmetry asymmetry {
                symbol: "a", meaning: "asymmetry", word: "asymmetry", help: "Centre a of the gap, 0 ≤ a < 1",
                range: Range { least: 0.0, most: 1.0, open: [false, true], told: "a number from 0 up to but not including 1" },
                part: Part::Motion, default: None, slider: [0.0, 0.95, 0.01],
            }
            /// Amplitude A of the force; of a force of several harmonics Σ|A_j|.
            Amplitude amplitude {
                symbol: "A", meaning: "force amplitude", word: "amplitude",
                help: "Amplitude A of the force A cos ω(t+ψ) [default: no force]",
                range: Range::STIFFNESS, part: Part::Driving, default: Some(0.0), slider: [0.0, 1.0, 0.005],
            }
            /// Coefficient e of restitution.
            Restitution restitution {
                symbol: "e", meaning: "restitution", word: "restitution",
                help: "Coefficient e of restitution, 0 < e ≤ 1 [default without force: 1]",
                range: Range { least: 0.0, most: 1.0, open: [true, false], told: "a number above 0 and up to 1" },
                part: Part::Driving, default: Some(1.0), slider: [0.05, 1.0, 0.01],
            }
            /// Coupling stiffness γ₃ between layers.
            Gamma3 gamma3 {
                symbol: "γ₃", meaning: "coupling of layers", word: "coupling", help: "Coupling stiffness γ₃ between layers",
                range: Range::STIFFNESS, part: Part::Layers, default: Some(0.0), slider: [0.0, 1.0, 0.005],
            }
            /// Dashpot c between each mass and the ground.
            Damping damping {
                symbol: "c", meaning: "damping", word: "damping",
                help: "Dashpot c between each mass and the ground: ü + c u̇ + … (below 0: self-excited)",
                range: Range::REAL, part: Part::Dashpots, default: Some(0.0), slider: [0.0, 1.0, 0.005],
            }
            /// Dashpot c₂ between neighbours along the rows.
            CouplingDamping coupling_damping {
                symbol: "c₂", meaning: "damping between neighbours", word: "damping", help: "Dashpot c₂ in each spring between neighbours",
                range: Range::REAL, part: Part::Dashpots, default: Some(0.0), slider: [0.0, 1.0, 0.005],
            }
        }
    };
}
pub(crate) use parameters;

macro_rules! enumerated {
    ($(#[$of:meta])* $many:ident { $($(#[$doc:meta])* $variant:ident $name:ident { $($rest:tt)* })* }) => {
        $(#[$of])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
        pub enum $many {
            $($(#[$doc])* $variant,)*
        }

        impl $many {
            const TABLE: &[Row] = &[$(Row { name: stringify!($name), $($rest)* }),*];

            /// All of them, in the order of tables.
            pub const ALL: [Self; Self::TABLE.len()] = [$(Self::$variant),*];

            /// Its row of the table.
            pub const fn row(self) -> &'static Row {
                &Self::TABLE[self as usize]
            }

            /// The name in scenes, flags and tables.
            pub fn name(self) -> &'static str {
                self.row().name
            }

            /// The name of its flag, without the two hyphens before it.
            pub fn flag(self) -> String {
                self.name().replace('_', "-")
            }

            /// The parameter of that name.
            pub fn from_name(name: &str) -> Option<Self> {
                Self::ALL.into_iter().find(|parameter| parameter.name() == name)
            }

            /// Refuses a value out of range.
            ///
            /// # Errors
            /// A [`ParameterError`] with the range.
            pub fn check(self, value: f64) -> Result<(), ParameterError> {
                check(self.row().range.contains(value), self.name(), value, self.row().range.told)
            }
        }
    };
}

macro_rules! table {
    ($($rows:tt)*) => {
        enumerated! {
            /// A real parameter of the model, which a sweep can vary or a search can solve for.
            Parameter { $($rows)* }
        }
    };
}
parameters!(table);

enumerated! {
    /// A real parameter that chains have beside those of a model; with one, a chain is asked as a structure.
    DampedParameter {
        /// Force s on every mass that does not change.
        StaticForce static_force {
            symbol: "s", meaning: "static force", word: "force", help: "A force on every mass that does not change",
            range: Range::REAL, part: Part::Driving, default: Some(0.0), slider: [-1.0, 1.0, 0.005],
        }
        /// Place of the lower barrier.
        Lower lower {
            symbol: "g", meaning: "lower barrier", word: "barrier",
            help: "Where the lower barrier is [default: asymmetry − 1; with --upper alone there is none]",
            range: Range::REAL, part: Part::Motion, default: None, slider: [-2.0, 0.0, 0.01],
        }
        /// Place of the upper barrier.
        Upper upper {
            symbol: "g", meaning: "upper barrier", word: "barrier",
            help: "Where the upper barrier is [default: asymmetry + 1; with --lower alone there is none]",
            range: Range::REAL, part: Part::Motion, default: None, slider: [0.0, 2.0, 0.01],
        }
    }
}

impl Parameter {
    /// Those of a lattice of so many layers: γ₃ takes two.
    pub fn of(layers: usize) -> &'static [Self] {
        static OF_ONE: LazyLock<Vec<Parameter>> =
            LazyLock::new(|| Parameter::ALL.into_iter().filter(|one| one.row().part != Part::Layers).collect());
        if layers > 1 { &Self::ALL } else { &OF_ONE }
    }

    /// All of them in the order in which a model is told: the lattice's first.
    pub fn told() -> impl Iterator<Item = Self> + Clone {
        [true, false]
            .into_iter()
            .flat_map(|first| Self::ALL.into_iter().filter(move |one| one.is_of_lattice() == first))
    }

    /// The letter on pictures.
    pub fn symbol(self) -> &'static str {
        self.row().symbol
    }

    /// What it is, on the axes of pictures.
    pub fn meaning(self) -> &'static str {
        self.row().meaning
    }

    /// A parameter of the lattice, not of what moves on it.
    pub fn is_of_lattice(self) -> bool {
        matches!(self.row().part, Part::Lattice | Part::Layers)
    }

    /// Whether the `value` that a model of so many layers has is worth a word: that of a part which it lacks is not, nor what is so unless it
    /// is given.
    pub fn is_told(self, layers: usize, value: f64) -> bool {
        match self.row().part {
            Part::Layers => layers > 1,
            Part::Driving => true,
            Part::Lattice | Part::Motion | Part::Dashpots => self.row().default != Some(value),
        }
    }
}
