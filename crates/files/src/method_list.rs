//! The methods and the tables of their parameters as JSON.

use planish_geometry::denoise::{Denoiser, Parameter, Values};
use serde_json::{Value, json};

/// Lists methods and their parameters for programs.
pub fn json(methods: &[Denoiser]) -> Value {
    let parameter = |method: &Denoiser, p: &Parameter| {
        let (kind, min, max, slider_max) = match p.values {
            Values::Count { max, slider_max } => ("count", json!(0), json!(max), json!(slider_max)),
            Values::Number { min, max, slider_max } => ("number", json!(min), json!(max), json!(slider_max)),
            Values::Word(_) => ("word", Value::Null, Value::Null, Value::Null),
            Values::Words(_) => ("words", Value::Null, Value::Null, Value::Null),
            Values::Preset(_) => ("preset", Value::Null, Value::Null, Value::Null),
            Values::Text(_) => ("text", Value::Null, Value::Null, Value::Null),
        };
        json!({
            "name": p.name,
            "label": p.label,
            "field": p.path(),
            "kind": kind,
            "min": min,
            "max": max,
            "slider_max": slider_max,
            "default": method.get(p),
            "optional": p.is_optional,
            "unit": p.unit,
            "words": p.choices(),
            "help": p.help,
        })
    };
    let method = |method: &Denoiser| {
        json!({
            "name": method.name(),
            "summary": method.summary(),
            "reference": method.info().reference,
            "parameters": method.options().map(|p| parameter(method, p)).collect::<Vec<_>>(),
        })
    };
    methods.iter().map(method).collect()
}
