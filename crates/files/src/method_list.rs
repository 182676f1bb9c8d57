//! The methods and the tables of their parameters as JSON.
//!
//! ```
//! use planish_files::method_list;
//! use planish_geometry::denoise::Denoiser;
//!
//! let list = method_list::json(&Denoiser::every());
//! let laplacian = list.as_array().unwrap().iter().find(|method| method["name"] == "laplacian").unwrap();
//! let parameters = laplacian["parameters"].as_array().unwrap();
//! let step = parameters.iter().find(|parameter| parameter["name"] == "step").unwrap();
//! assert_eq!((step["kind"].as_str(), step["default"].as_f64()), (Some("number"), Some(0.5)));
//! ```

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
