//! A glTF document on its way into a file. Its long lists are kept as text, which takes less memory than values: a mesh may
//! have as many materials as faces.

use serde::ser::{Serialize, SerializeMap, Serializer};
use serde_json::value::{RawValue, to_raw_value};
use serde_json::{Map as Object, Value};

/// Entry of a list of a document, as text.
pub(super) struct Entry(Box<RawValue>);

impl Entry {
    pub(super) fn of(value: &impl Serialize) -> Self {
        // Only keys that are no strings could fail.
        Self(to_raw_value(value).unwrap_or_else(|_| RawValue::NULL.to_owned()))
    }

    pub(super) fn value(&self) -> Value {
        serde_json::from_str(self.0.get()).unwrap_or_default()
    }
}

impl Serialize for Entry {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.serialize(serializer)
    }
}

/// Entries of a list of values.
pub(super) fn entries(list: Vec<Value>) -> Vec<Entry> {
    list.into_iter().map(|value| Entry::of(&value)).collect()
}

enum Part {
    Value(Value),
    List(Vec<Entry>),
}

impl Serialize for Part {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Value(value) => value.serialize(serializer),
            Self::List(list) => list.serialize(serializer),
        }
    }
}

/// Parts of a document in the order in which they are written.
#[derive(Default)]
pub(super) struct Document {
    parts: Vec<(String, Part)>,
}

impl Document {
    /// Adds a part, which the document must not have yet.
    pub(super) fn insert(&mut self, name: &str, value: Value) {
        self.parts.push((name.to_owned(), Part::Value(value)));
    }

    /// Adds a list, which the document must not have yet, unless it is empty, which glTF does not allow.
    pub(super) fn insert_list(&mut self, name: &str, list: Vec<Entry>) {
        if !list.is_empty() {
            self.parts.push((name.to_owned(), Part::List(list)));
        }
    }
}

impl From<Object<String, Value>> for Document {
    fn from(values: Object<String, Value>) -> Self {
        Self { parts: values.into_iter().map(|(name, value)| (name, Part::Value(value))).collect() }
    }
}

impl Serialize for Document {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.parts.len()))?;
        for (name, part) in &self.parts {
            map.serialize_entry(name, part)?;
        }
        map.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_document_is_written_as_its_values_would_be() {
        let list = [json!({ "name": "a", "numbers": [0.1, 1e300, -0.0] }), json!(null)];
        let mut document = Document::from(Object::from_iter([("z".to_owned(), json!({ "b": 1, "a": 2 }))]));
        document.insert("asset", json!({ "version": "2.0" }));
        document.insert_list("materials", entries(list.to_vec()));
        document.insert_list("images", Vec::new());
        let expected = json!({ "z": { "b": 1, "a": 2 }, "asset": { "version": "2.0" }, "materials": list });
        assert_eq!(serde_json::to_string(&document).unwrap(), expected.to_string());
        assert_eq!(Entry::of(&list[0]).value(), list[0]);
    }
}
