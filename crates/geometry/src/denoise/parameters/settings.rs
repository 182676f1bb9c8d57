//! Settings of a method by name: read, changed and checked.

use super::{NotAllowed, Parameter, ParameterError, Values};
use crate::denoise::Denoiser;
use serde::{Deserialize, Deserializer, de};
use serde_json::{Map, Value};

impl Denoiser {
    /// Finds the method of a name, with its default settings.
    pub fn named(name: &str) -> Result<Self, ParameterError> {
        let found = Self::every().into_iter().find(|method| method.name() == name);
        found.ok_or_else(|| ParameterError::UnknownMethod { name: name.to_owned() })
    }

    /// Parameters of this method, in the order of lists and menus. Presets come before what they set.
    pub fn parameters(&self) -> impl Iterator<Item = &'static Parameter> + use<> {
        self.info().parameters.iter().copied().flatten()
    }

    /// Parameters of this method that people set: all but the internal ones.
    pub fn options(&self) -> impl Iterator<Item = &'static Parameter> + use<> {
        self.parameters().filter(|parameter| !parameter.is_internal)
    }

    /// Parameter of this method by its name; underscores may stand for hyphens.
    pub fn parameter(&self, name: &str) -> Option<&'static Parameter> {
        let name = name.replace('_', "-");
        self.options().find(|parameter| parameter.name == name || parameter.alias == Some(&name))
    }

    /// Value of a parameter: a number, a word, a list of words, or null where the method chooses. A preset has its word,
    /// or null where the settings are none of the presets.
    pub fn get(&self, parameter: &Parameter) -> Value {
        let value = self.json().pointer(parameter.pointer).cloned().unwrap_or_default();
        match parameter.values {
            Values::Preset(preset) => (preset.name)(&value).into(),
            _ => value,
        }
    }

    /// Changes a setting by its name. A value that is not allowed changes nothing.
    ///
    /// ```
    /// use planish_geometry::denoise::Denoiser;
    ///
    /// let mut method = Denoiser::named("guided-normals")?;
    /// method.set("sigma-range", 0.5)?;
    /// method.set("boundary", "fixed")?;
    /// let error = method.set("radius", -1.0).unwrap_err().to_string();
    /// assert_eq!(error, "setting `radius` of guided-normals: -1.0 is not a number between 0.000001 and 100");
    /// # Ok::<(), planish_geometry::denoise::ParameterError>(())
    /// ```
    pub fn set(&mut self, name: &str, value: impl Into<Value>) -> Result<(), ParameterError> {
        match self.parameter(name) {
            Some(parameter) => self.set_parameter(parameter, value.into()),
            None => Err(self.unknown(name)),
        }
    }

    /// Changes several settings by their names, or none. Presets come first, so that they do not undo what is set beside
    /// them.
    pub fn set_all(&mut self, settings: &[(&str, Value)]) -> Result<(), ParameterError> {
        if let Some((name, _)) = settings.iter().find(|(name, _)| self.parameter(name).is_none()) {
            return Err(self.unknown(name));
        }
        let mut changed = self.clone();
        for parameter in self.options() {
            let is_it = |(name, _): &&(&str, Value)| self.parameter(name).is_some_and(|p| p.name == parameter.name);
            for (_, value) in settings.iter().filter(is_it) {
                changed.set_parameter(parameter, value.clone())?;
            }
        }
        *self = changed;
        Ok(())
    }

    /// Changes the setting of a parameter of this method. A value that is not allowed changes nothing.
    pub fn set_parameter(&mut self, parameter: &Parameter, value: Value) -> Result<(), ParameterError> {
        parameter.check(&value).map_err(|reason| self.refused(parameter, &value, reason))?;
        let mut settings = self.json();
        let slot = settings.pointer_mut(parameter.pointer).ok_or_else(|| self.unknown(parameter.name))?;
        *slot = match (parameter.values, value.as_str()) {
            (Values::Preset(preset), Some(word)) => (preset.settings)(word).unwrap_or_default(),
            _ => value,
        };
        *self = Self::from_json(settings)?;
        Ok(())
    }

    /// Settings that make this method from its defaults, in an order in which they can be set.
    pub fn changes(&self) -> Vec<(&'static Parameter, Value)> {
        let mut known = Self::named(self.name()).unwrap_or_default();
        let mut changes = Vec::new();
        for parameter in self.options() {
            let value = self.get(parameter);
            if known.get(parameter) != value && known.set_parameter(parameter, value.clone()).is_ok() {
                changes.push((parameter, value));
            }
        }
        changes
    }

    /// Checks all settings against the ranges of their parameters.
    pub fn check(&self) -> Result<(), ParameterError> {
        self.check_json(&self.json())
    }

    /// Reads a method with its settings from JSON and checks them.
    fn from_json(mut settings: Value) -> Result<Self, ParameterError> {
        let name = settings.get("name").and_then(Value::as_str).unwrap_or_default();
        let method = Self::named(name)?;
        method.check_json(&settings)?;
        if let Some(fields) = settings.as_object_mut() {
            fields.shift_remove("name");
        }
        let method = method.name();
        Self::from_settings(method, settings).map_err(|e| ParameterError::Incomplete { method, problem: e.to_string() })
    }

    /// All settings as JSON, with the name of the method.
    fn json(&self) -> Value {
        // Numbers and words always have a form in JSON.
        serde_json::to_value(self).unwrap_or_default()
    }

    fn check_json(&self, settings: &Value) -> Result<(), ParameterError> {
        for (pointer, value) in leaves(settings).into_iter().filter(|(pointer, _)| pointer != "/name") {
            let is_it = |p: &&Parameter| p.pointer == pointer && !matches!(p.values, Values::Preset(_));
            if let Some(parameter) = self.parameters().find(is_it) {
                parameter.check(value).map_err(|reason| self.refused(parameter, value, reason))?;
            } else if !self.parameters().any(|p| p.pointer.starts_with(&format!("{pointer}/"))) {
                let known = leaves(&self.json()).iter().map(|(pointer, _)| path(pointer)).collect();
                return Err(self.unknown_among(&path(&pointer), known));
            }
        }
        Ok(())
    }

    fn refused(&self, parameter: &Parameter, value: &Value, reason: NotAllowed) -> ParameterError {
        ParameterError::Value { method: self.name(), setting: parameter.path(), value: value.to_string(), reason }
    }

    fn unknown(&self, name: &str) -> ParameterError {
        self.unknown_among(name, self.options().map(|parameter| parameter.name.to_owned()).collect())
    }

    fn unknown_among(&self, setting: &str, mut known: Vec<String>) -> ParameterError {
        known.retain(|name| name != "name");
        ParameterError::UnknownSetting { method: self.name(), setting: setting.to_owned(), known: known.join(", ") }
    }
}

/// Path with dots of a JSON pointer.
pub(super) fn path(pointer: &str) -> String {
    pointer.trim_start_matches('/').replace('/', ".")
}

/// JSON pointers of all values that are no objects, with these values.
pub(super) fn leaves(settings: &Value) -> Vec<(String, &Value)> {
    match settings.as_object() {
        None => vec![(String::new(), settings)],
        Some(fields) => {
            let below = |(name, value)| leaves(value).into_iter().map(move |(rest, v)| (format!("/{name}{rest}"), v));
            fields.iter().flat_map(below).collect()
        }
    }
}

impl<'de> Deserialize<'de> for Denoiser {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let settings = Map::deserialize(deserializer)?;
        Self::from_json(Value::Object(settings)).map_err(de::Error::custom)
    }
}
