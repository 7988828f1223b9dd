//! Words for the variants of an enumeration, as files and command lines have them.

/// Gives an enumeration without data its words: `ALL`, `name`, `from_name` and [`Display`](std::fmt::Display) come from one list.
///
/// ```
/// #[derive(Clone, Copy, Debug, PartialEq)]
/// pub enum Side {
///     Left,
///     Right,
/// }
/// vibrochain_lattice::names!(Side { Left "left", Right "right" });
/// assert_eq!(Side::ALL.map(Side::name), ["left", "right"]);
/// assert_eq!(Side::from_name("right"), Some(Side::Right));
/// assert_eq!(Side::Left.to_string(), "left");
/// ```
///
/// A variant that had another word before keeps it after `|`: `from_name` reads both, `name` writes the first.
///
/// ```
/// #[derive(Clone, Copy, Debug, PartialEq)]
/// pub enum Outcome {
///     Known,
///     Undecided,
/// }
/// vibrochain_lattice::names!(Outcome { Known "known", Undecided "undecided" | "marginal" });
/// assert_eq!(Outcome::from_name("marginal"), Some(Outcome::Undecided));
/// assert_eq!(Outcome::Undecided.name(), "undecided");
/// ```
#[macro_export]
macro_rules! names {
    ($type:ident { $($variant:ident $name:literal $(| $old:literal)*),* $(,)? }) => {
        impl $type {
            /// All of them, in the order of tables and legends.
            pub const ALL: [Self; [$($name),*].len()] = [$(Self::$variant),*];

            /// The name in files and on the command line.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name),*
                }
            }

            /// The one of that name, or of a name that it had before.
            #[must_use]
            pub fn from_name(name: &str) -> Option<Self> {
                Self::ALL.into_iter().find(|one| {
                    one.name() == name $($(|| matches!(one, Self::$variant) && name == $old)*)*
                })
            }
        }

        /// The name in files.
        impl ::std::fmt::Display for $type {
            fn fmt(&self, f: &mut ::std::fmt::Formatter<'_>) -> ::std::fmt::Result {
                f.pad(self.name())
            }
        }
    };
}
