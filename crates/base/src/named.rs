//! Enums whose variants have names.

use thiserror::Error;

/// The error of parsing a name that no variant of an enum has.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("unknown {kind} '{name}': expected {}", choices(.expected))]
#[non_exhaustive]
pub struct UnknownName {
    /// What the name stands for, for example "layout".
    pub kind: &'static str,
    /// The unknown name.
    pub name: String,
    /// All valid names.
    pub expected: Vec<&'static str>,
}

impl UnknownName {
    /// An error for `name`; its message lists the expected names.
    pub fn new(kind: &'static str, name: &str, expected: Vec<&'static str>) -> Self {
        Self { kind, name: name.to_owned(), expected }
    }
}

/// Joins names in the form `a, b or c`.
fn choices(names: &[&str]) -> String {
    match names {
        [] => "none".to_owned(),
        [one] => (*one).to_owned(),
        [first @ .., last] => format!("{} or {last}", first.join(", ")),
    }
}

/// Implements names for the variants of an enum: `ALL` (all variants in the order of the list),
/// `name()`, `Display` and `FromStr`, whose error is [`UnknownName`].
///
/// The enum itself is defined as usual, with variants that carry no data.
/// The compiler rejects a list that leaves a variant out.
/// All names must be distinct.
///
/// ```
/// #[derive(Clone, Copy, Debug, PartialEq)]
/// pub enum Colour {
///     Red,
///     SkyBlue,
/// }
///
/// beadwork_base::named_enum! {
///     Colour, "colour":
///     Red = "red",
///     SkyBlue = "sky_blue",
/// }
///
/// assert_eq!(Colour::ALL, [Colour::Red, Colour::SkyBlue]);
/// assert_eq!("sky_blue".parse(), Ok(Colour::SkyBlue));
/// assert_eq!(Colour::Red.to_string(), "red");
/// let error = "green".parse::<Colour>().unwrap_err();
/// assert_eq!(error.to_string(), "unknown colour 'green': expected red or sky_blue");
/// ```
#[macro_export]
macro_rules! named_enum {
    ($type:ident, $kind:literal: $($variant:ident = $name:literal),+ $(,)?) => {
        impl $type {
            /// All variants, in the order of their declaration.
            pub const ALL: [Self; [$($name),+].len()] = [$(Self::$variant),+];

            /// Name in configuration files and on the command line.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)+
                }
            }
        }

        impl ::std::fmt::Display for $type {
            fn fmt(&self, f: &mut ::std::fmt::Formatter<'_>) -> ::std::fmt::Result {
                f.pad(self.name())
            }
        }

        impl ::std::str::FromStr for $type {
            type Err = $crate::UnknownName;

            fn from_str(name: &str) -> Result<Self, $crate::UnknownName> {
                Self::ALL.into_iter().find(|known| known.name() == name).ok_or_else(|| {
                    $crate::UnknownName::new($kind, name, Self::ALL.map(Self::name).to_vec())
                })
            }
        }
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_list_all_names() {
        let message = |expected: &[&'static str]| {
            UnknownName::new("layout", "x", expected.to_vec()).to_string()
        };
        assert_eq!(message(&["a", "b", "c"]), "unknown layout 'x': expected a, b or c");
        assert_eq!(message(&["a"]), "unknown layout 'x': expected a");
        assert_eq!(message(&[]), "unknown layout 'x': expected none");
    }
}
