//! Helpers that all settings share: choices with words, and numbers with ranges.

use thiserror::Error;

/// Defines an enum whose variants have a word each, which JSON, command lines and shaders share.
macro_rules! named {
    ($(#[$meta:meta])* pub enum $name:ident { $($(#[$attribute:meta])* $variant:ident = $word:literal,)+ }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
        #[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
        pub enum $name {
            $(
                $(#[$attribute])*
                #[serde(rename = $word)]
                #[cfg_attr(feature = "clap", value(name = $word))]
                $variant,
            )+
        }

        impl $name {
            /// All choices; the index of each in this list is its number in the shaders.
            pub const ALL: &'static [Self] = &[$(Self::$variant,)+];
            /// The words of the choices, in the order of [`Self::ALL`].
            pub const NAMES: &'static [&'static str] = &[$($word,)+];

            /// The word of this choice.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $word,)+
                }
            }
        }
    };
}
pub(crate) use named;

/// Reason why a text is not the settings of a picture.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SettingsError {
    /// The text is not JSON, or has an unknown field or a value of the wrong kind.
    #[error("{0}")]
    Json(#[from] serde_json::Error),
    /// A number is out of its range.
    #[error("{name} must be {expected}")]
    OutOfRange {
        /// Path of the field.
        name: &'static str,
        /// Range of the field, in words.
        expected: &'static str,
    },
}

/// A condition on a field: whether it holds, the path of the field, and its range in words.
pub(crate) type Rule = (bool, &'static str, &'static str);

/// Checks the rules, and names the field of the first one that does not hold.
pub(crate) fn require(rules: &[Rule]) -> Result<(), SettingsError> {
    match rules.iter().find(|(holds, ..)| !holds) {
        Some(&(_, name, expected)) => Err(SettingsError::OutOfRange { name, expected }),
        None => Ok(()),
    }
}
