//! Enums whose values have names. JSON, the command line, menus and the documentation are made from that one list.

use thiserror::Error;

/// A name with its meaning.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Word {
    /// Word as JSON and the command line spell it.
    pub name: &'static str,
    /// Meaning of the word in one line.
    pub help: &'static str,
}

/// A closed set of named values, which is declared by [`named!`](crate::named!).
pub trait Named: Copy + PartialEq + Sized + Send + Sync + 'static {
    /// All values, in the order of lists and menus.
    const VALUES: &'static [Self];
    /// Names and meanings of all values, in the order of [`Named::VALUES`].
    const WORDS: &'static [Word];

    /// Name and meaning of this value.
    fn word(self) -> Word;

    /// Finds a value by its name.
    fn named(name: &str) -> Result<Self, UnknownName> {
        let found = Self::VALUES.iter().find(|value| value.word().name == name);
        found.copied().ok_or_else(|| UnknownName { name: name.to_owned(), known: Self::WORDS })
    }
}

/// The name belongs to none of the values.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("`{name}` is not one of {}", list(.known))]
pub struct UnknownName {
    /// Name that is unknown.
    pub name: String,
    /// Names of all values.
    pub known: &'static [Word],
}

/// Lists the names with commas between them.
pub(crate) fn list(words: &[Word]) -> String {
    words.iter().map(|word| word.name).collect::<Vec<_>>().join(", ")
}

/// Declares an enum whose variants have names. The doc comment of a variant is its help text too, so it must be one line that
/// users understand.
///
/// The enum gets `ALL`, `name()`, `help()`, [`Named`], [`FromStr`](std::str::FromStr) and serde, all by the same names.
///
/// ```
/// planish_geometry::named! {
///     /// Colour of a traffic light.
///     #[derive(Default)]
///     pub enum Light {
///         /// Stop.
///         #[default]
///         Red = "red",
///         /// Go.
///         Green = "green",
///     }
/// }
/// assert_eq!(Light::ALL, [Light::Red, Light::Green]);
/// assert_eq!((Light::Red.name(), Light::Red.help()), ("red", "Stop."));
/// assert_eq!("green".parse(), Ok(Light::Green));
/// assert_eq!("blue".parse::<Light>().unwrap_err().to_string(), "`blue` is not one of red, green");
/// ```
#[macro_export]
macro_rules! named {
    ($(#[$meta:meta])* $vis:vis enum $name:ident {
        $($(#[$($attribute:tt)*])* $variant:ident = $word:literal,)+
    }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, ::serde::Serialize, ::serde::Deserialize)]
        $vis enum $name {
            $($(#[$($attribute)*])* #[serde(rename = $word)] $variant,)+
        }

        impl $name {
            /// All values, in the order of lists and menus.
            pub const ALL: [Self; [$($word),+].len()] = [$(Self::$variant),+];

            /// Name of this value, as in JSON and on the command line.
            pub fn name(self) -> &'static str {
                $crate::named::Named::word(self).name
            }

            /// Meaning of this value in one line.
            pub fn help(self) -> &'static str {
                $crate::named::Named::word(self).help
            }
        }

        impl $crate::named::Named for $name {
            const VALUES: &'static [Self] = &Self::ALL;
            const WORDS: &'static [$crate::named::Word] = &[$($crate::named::Word {
                name: $word,
                help: $crate::doc_text!($([$($attribute)*])*).trim_ascii(),
            }),+];

            fn word(self) -> $crate::named::Word {
                Self::WORDS[self as usize]
            }
        }

        impl ::std::str::FromStr for $name {
            type Err = $crate::named::UnknownName;

            fn from_str(name: &str) -> Result<Self, Self::Err> {
                $crate::named::Named::named(name)
            }
        }
    };
}

/// Joins the text of the doc comments among attributes.
#[doc(hidden)]
#[macro_export]
macro_rules! doc_text {
    () => { "" };
    ([doc = $text:literal] $($rest:tt)*) => { concat!($text, $crate::doc_text!($($rest)*)) };
    ([$($other:tt)*] $($rest:tt)*) => { $crate::doc_text!($($rest)*) };
}
