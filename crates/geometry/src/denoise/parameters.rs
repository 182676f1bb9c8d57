//! Parameters of the methods, as data.
//!
//! Each method has a table of its parameters beside its settings. Checks of the settings, options of the command line, widgets,
//! help and documentation are made from it, so that each fact is said once. Defaults stand in the `Default` of the settings.

mod settings;
#[cfg(test)]
mod tests;

use crate::named::{Named, Word, list};
use serde_json::Value;
use std::fmt;
use thiserror::Error;

/// A setting of a method that somebody may want to change.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Parameter {
    /// Name, as an option of the command line without its dashes.
    pub name: &'static str,
    /// Another spelling of the name.
    pub alias: Option<&'static str>,
    /// Name in a menu; mostly the same with blanks.
    pub label: &'static str,
    /// JSON pointer to the setting in the settings of the method.
    pub pointer: &'static str,
    /// Values that are allowed.
    pub values: Values,
    /// Unit of a number.
    pub unit: Option<&'static str>,
    /// Whether the setting may be absent (`null`), which lets the method choose.
    pub is_optional: bool,
    /// Whether only manifests have the setting, and neither the command line nor menus.
    pub is_internal: bool,
    /// Effect of the parameter, in a line that continues its name.
    pub help: &'static str,
}

/// Values of a parameter.
#[derive(Clone, Copy, Debug)]
pub enum Values {
    /// A whole number, 0 included.
    Count {
        /// Largest number allowed.
        max: u32,
        /// End of a slider; larger numbers can be typed.
        slider_max: u32,
    },
    /// A number.
    Number {
        /// Smallest number allowed.
        min: f64,
        /// Largest number allowed.
        max: f64,
        /// End of a slider; larger numbers can be typed.
        slider_max: f64,
    },
    /// One of some words.
    Word(&'static [Word]),
    /// Several of some words.
    Words(&'static [Word]),
    /// A word that stands for a group of settings; in JSON these settings themselves.
    Preset(Preset),
    /// Any text; the words say what it is.
    Text(&'static str),
}

/// Words that stand for a group of settings each.
#[derive(Clone, Copy, Debug)]
pub struct Preset {
    /// Names of the groups.
    pub words: &'static [Word],
    /// Finds the settings of a name.
    pub(crate) settings: fn(&str) -> Option<Value>,
    /// Finds the name of some settings, whatever those of them are that have a parameter of their own.
    pub(crate) name: fn(&Value) -> Option<&'static str>,
}

/// Requirement that a value does not meet.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("not {expected}")]
pub struct NotAllowed {
    /// Description of the values that are allowed: `a number between 0 and 1`.
    pub expected: String,
}

/// Why a setting cannot be.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ParameterError {
    /// A name that no method has.
    #[error("there is no method `{name}`")]
    UnknownMethod {
        /// Name that was given.
        name: String,
    },
    /// A setting that the method does not have.
    #[error("{method} has no setting `{setting}`; it has {known}")]
    UnknownSetting {
        /// Name of the method.
        method: &'static str,
        /// Setting, as it was named.
        setting: String,
        /// Settings that the method has, with commas between them.
        known: String,
    },
    /// A value outside the range of the parameter.
    #[error("setting `{setting}` of {method}: {value} is {reason}")]
    Value {
        /// Name of the method.
        method: &'static str,
        /// Path of the setting in the JSON, with dots.
        setting: String,
        /// Value that was given, as JSON.
        value: String,
        /// Values that are allowed.
        reason: NotAllowed,
    },
    /// Settings that are missing, or are no settings at all.
    #[error("settings of {method}: {problem}")]
    Incomplete {
        /// Name of the method.
        method: &'static str,
        /// Description of the fault.
        problem: String,
    },
}

/// Largest number of steps of anything.
const MAX_COUNT: u32 = 100_000;

/// Smallest number that is allowed where zero is not.
pub(crate) const TINY: f64 = 1e-6;

/// Largest number that is allowed where nothing else bounds it.
pub(crate) const HUGE: f64 = 1e6;

impl Parameter {
    const fn new(name: &'static str, pointer: &'static str, values: Values, help: &'static str) -> Self {
        Self {
            name,
            alias: None,
            label: name,
            pointer,
            values,
            unit: None,
            is_optional: false,
            is_internal: false,
            help,
        }
    }
    /// A whole number up to [`MAX_COUNT`].
    pub(crate) const fn count(name: &'static str, pointer: &'static str, slider_max: u32, help: &'static str) -> Self {
        Self::new(name, pointer, Values::Count { max: MAX_COUNT, slider_max }, help)
    }
    /// A number between two others, both included.
    pub(crate) const fn number(
        name: &'static str,
        pointer: &'static str,
        [min, max]: [f64; 2],
        help: &'static str,
    ) -> Self {
        Self::new(name, pointer, Values::Number { min, max, slider_max: max }, help)
    }
    /// One of the words of an enum.
    pub(crate) const fn word<T: Named>(name: &'static str, pointer: &'static str, help: &'static str) -> Self {
        Self::new(name, pointer, Values::Word(T::WORDS), help)
    }
    /// Several of the words of an enum.
    pub(crate) const fn words<T: Named>(name: &'static str, pointer: &'static str, help: &'static str) -> Self {
        Self::new(name, pointer, Values::Words(T::WORDS), help)
    }
    /// A word that stands for a group of settings.
    pub(crate) const fn preset(name: &'static str, pointer: &'static str, preset: Preset, help: &'static str) -> Self {
        Self::new(name, pointer, Values::Preset(preset), help)
    }
    /// Any text that is `expected`, with an article.
    pub(crate) const fn text_of(
        name: &'static str,
        pointer: &'static str,
        expected: &'static str,
        help: &'static str,
    ) -> Self {
        Self::new(name, pointer, Values::Text(expected), help)
    }
    /// This parameter with another spelling.
    pub(crate) const fn alias(self, alias: &'static str) -> Self {
        Self { alias: Some(alias), ..self }
    }
    /// This parameter with another name in menus.
    pub(crate) const fn label(self, label: &'static str) -> Self {
        Self { label, ..self }
    }
    /// This parameter with a unit.
    pub(crate) const fn unit(self, unit: &'static str) -> Self {
        Self { unit: Some(unit), ..self }
    }
    /// This parameter with another end of its slider.
    pub(crate) const fn slider(mut self, end: f64) -> Self {
        if let Values::Number { slider_max, .. } = &mut self.values {
            *slider_max = end;
        }
        self
    }
    /// This parameter, which may also be left to the method.
    pub(crate) const fn optional(self) -> Self {
        Self { is_optional: true, ..self }
    }
    /// This parameter for manifests only.
    pub(crate) const fn internal(self) -> Self {
        Self { is_internal: true, ..self }
    }
    /// This parameter at another place of the JSON.
    pub(crate) const fn at(self, pointer: &'static str) -> Self {
        Self { pointer, ..self }
    }

    /// Path in the JSON with dots instead of slashes: `vertex_update.closeness`.
    pub fn path(&self) -> String {
        settings::path(self.pointer)
    }

    /// Words of the parameter; none for numbers.
    pub fn choices(&self) -> &'static [Word] {
        match self.values {
            Values::Word(words) | Values::Words(words) | Values::Preset(Preset { words, .. }) => words,
            Values::Count { .. } | Values::Number { .. } | Values::Text(_) => &[],
        }
    }

    /// Checks a value as it stands in JSON.
    pub fn check(&self, value: &Value) -> Result<(), NotAllowed> {
        let is_word = |word: &Value| word.as_str().is_some_and(|w| self.choices().iter().any(|known| known.name == w));
        let is_fine = match self.values {
            _ if value.is_null() && self.is_optional => true,
            Values::Count { max, .. } => value.as_u64().is_some_and(|count| count <= max.into()),
            Values::Number { min, max, .. } => value.as_f64().is_some_and(|number| (min..=max).contains(&number)),
            Values::Word(_) => is_word(value),
            Values::Words(_) => value.as_array().is_some_and(|words| words.iter().all(is_word)),
            Values::Preset(_) => value.is_object() || is_word(value),
            Values::Text(_) => value.as_str().is_some_and(|text| !text.is_empty()),
        };
        if is_fine { Ok(()) } else { Err(NotAllowed { expected: self.values.to_string() }) }
    }

    /// Reads a value as people type it; words of a list have commas between them.
    pub fn parse(&self, text: &str) -> Result<Value, NotAllowed> {
        let value = match self.values {
            Values::Count { .. } => text.parse::<u32>().ok().map(Value::from),
            Values::Number { .. } => text.parse::<f64>().ok().map(Value::from),
            Values::Word(_) | Values::Preset(_) | Values::Text(_) => Some(text.into()),
            Values::Words(_) => Some(text.split(',').collect()),
        };
        // What is no number at all is as little allowed as one out of range.
        let value = value.filter(|value| !value.is_null());
        let value = value.ok_or_else(|| NotAllowed { expected: self.values.to_string() })?;
        self.check(&value).map(|()| value)
    }

    /// A value as [`Parameter::parse`] reads it.
    pub fn text(&self, value: &Value) -> String {
        match value {
            Value::String(word) => word.clone(),
            Value::Array(all) => all.iter().map(|value| self.text(value)).collect::<Vec<_>>().join(","),
            // Without the fraction of whole numbers that JSON has.
            other => other.as_f64().map_or_else(|| other.to_string(), |number| number.to_string()),
        }
    }
}

/// Describes the values that are allowed, with an article: `a number between 0 and 1`.
impl fmt::Display for Values {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Count { max, .. } => write!(f, "a whole number between 0 and {max}"),
            Self::Number { min, max, .. } => write!(f, "a number between {min} and {max}"),
            Self::Word(words) | Self::Preset(Preset { words, .. }) => write!(f, "one of {}", list(words)),
            Self::Words(words) => write!(f, "a list of some of {}", list(words)),
            Self::Text(expected) => f.write_str(expected),
        }
    }
}
