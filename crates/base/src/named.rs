//! Enums whose variants have names.

use thiserror::Error;

/// A name that none of an enum's variants has.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("unknown {kind} '{name}': expected {}", choices(.expected))]
#[non_exhaustive]
pub struct UnknownName {
    /// What was to be named: "layout", for example.
    pub kind: &'static str,
    /// The name that is not known.
    pub name: String,
    /// All names that are.
    pub expected: Vec<&'static str>,
}

impl UnknownName {
    /// An error that lists the names that are known.
    pub fn new(kind: &'static str, name: &str, expected: Vec<&'static str>) -> Self {
        Self { kind, name: name.to_owned(), expected }
    }
}

/// Names as people list them: `a, b or c`.
fn choices(names: &[&str]) -> String {
    match names {
        [] => "none".to_owned(),
        [one] => (*one).to_owned(),
        [first @ .., last] => format!("{} or {last}", first.join(", ")),
    }
}

/// Gives each variant of an enum a name: `ALL` (all variants in the order of the list), `name()`,
/// `Display` and `FromStr`, whose error is [`UnknownName`].
///
/// The enum itself is defined as usual; the compiler refuses a list that leaves a variant out.
///
/// ```
/// #[derive(Clone, Copy, Debug, PartialEq)]
/// pub enum Colour {
///     /// As blood.
///     Red,
///     /// As the sky.
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
            /// All variants, in the order of their documentation.
            pub const ALL: [Self; [$($name),+].len()] = [$(Self::$variant),+];

            /// Its name in configuration files and on the command line.
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
