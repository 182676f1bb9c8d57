//! Settings of the methods: what the panel shows of them, and their options on the command line.

use planish_geometry::denoise::Denoiser;
use serde_json::Value;

/// A setting that people turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knob {
    /// Where it is in the JSON of a method.
    pub place: &'static str,
    /// What the panel calls it.
    pub label: &'static str,
    /// What it does.
    pub help: &'static str,
    /// What it may be.
    pub values: Values,
}

/// What a setting may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Values {
    /// A whole number; the slider ends here, typing goes on.
    Count {
        /// End of the slider.
        usual: u32,
    },
    /// A number.
    Number {
        /// Smallest allowed.
        least: f64,
        /// Largest allowed.
        most: f64,
        /// End of the slider.
        usual: f64,
    },
    /// One of these words.
    Words(&'static [&'static str]),
}

const fn count(usual: u32) -> Values {
    Values::Count { usual }
}

const fn number(least: f64, usual: f64, most: f64) -> Values {
    Values::Number { least, most, usual }
}

const fn knob(place: &'static str, label: &'static str, values: Values, help: &'static str) -> Knob {
    Knob { place, label, help, values }
}

/// Smallest and largest of a number that is above zero, as on the command line.
const TINY: f64 = 1e-6;
const HUGE: f64 = 1e6;
const BOUNDARIES: Values = Values::Words(&["fixed", "free"]);

/// In the order of the panel; a method shows those that it has.
pub const KNOBS: [Knob; 24] = [
    knob("/iterations", "iterations", count(100), "Number of steps; of the normals with the filters of normals"),
    knob("/step", "step", number(0.0, 1.0, 1.0), "Share of the way to the mean of the neighbours that a step goes"),
    knob("/inflate", "inflate", number(-1.5, 0.0, 0.0), "The step away from the mean that follows each step"),
    knob("/time", "time", number(0.0, 10.0, HUGE), "How long a step is, in whole steps of the laplacian"),
    knob("/solver", "solver", Values::Words(&["iterative", "direct"]), "Direct is exact, for up to some 100 000 vertices"),
    knob("/weights", "weights", Values::Words(&["uniform", "cotangent"]), "How much each neighbour counts"),
    knob("/alpha", "alpha", number(0.0, 1.0, 1.0), "hc: share of the input in the place that vertices are pushed back to; l0: weight against folds"),
    knob("/beta", "beta", number(0.0, 1.0, 1.0), "Share of a vertex's own way in how far it is pushed back"),
    knob("/threshold", "threshold", number(0.0, 1.0, 1.0), "Cosine of the angle beyond which neighbours do not count"),
    knob("/scheme", "scheme", Values::Words(&["local", "global"]), "Step by step, or one linear system"),
    knob("/smoothness", "smoothness", number(TINY, 1.0, 1.0), "How near normals stay to the input, with the global scheme"),
    knob("/neighbours", "neighbours", Values::Words(&["vertex", "edge"]), "Which faces are averaged: those that share a vertex or an edge"),
    knob("/radius", "radius", number(TINY, 5.0, HUGE), "How far off faces are averaged, in mean distances of neighbouring faces"),
    knob("/sigma_spatial", "σ spatial", number(TINY, 4.0, HUGE), "Reach of the filter, in mean distances of neighbouring faces"),
    knob("/sigma_range", "σ range", number(TINY, 1.5, HUGE), "How far unit normals may differ and still be averaged"),
    knob("/sparsity", "sparsity", number(0.0, 4.0, HUGE), "More than 1 makes more edges flat, less makes fewer"),
    knob("/fidelity", "fidelity", number(TINY, 4.0, HUGE), "How near normals stay to the input, against how noisy they are"),
    knob("/second_order", "second order", number(TINY, 2.0, HUGE), "Weight of curvature that changes against normals that jump"),
    knob("/vertex_update/iterations", "vertex steps", count(100), "Steps of the vertices towards the filtered normals"),
    knob("/vertex_update/closeness", "closeness", number(0.0, 1.0, HUGE), "Pull of the vertices to the input, in pulls of a face around"),
    knob("/vertex_update/motion", "motion", Values::Words(&["free", "along-normal"]), "Where vertices may go"),
    knob("/vertex_update/fold_overs", "fold-overs", Values::Words(&["prevent", "allow"]), "What happens to steps that fold the surface over"),
    knob("/boundary", "boundary", BOUNDARIES, "What happens at the rim of an open mesh"),
    knob("/vertex_update/boundary", "boundary", BOUNDARIES, "What happens at the rim of an open mesh"),
];

/// Option of a setting on the command line, without dashes.
pub fn option(place: &str) -> String {
    match place {
        "/vertex_update/iterations" => "vertex-iterations".to_owned(),
        _ => place.rsplit('/').next().unwrap_or_default().replace('_', "-"),
    }
}

/// The settings of a method as JSON.
pub fn json(denoiser: &Denoiser) -> Value {
    // Plain numbers and names, which always have a form in JSON.
    serde_json::to_value(denoiser).unwrap_or_default()
}

/// The same method with one setting changed; none if it cannot have that value.
pub fn with(denoiser: &Denoiser, place: &str, value: Value) -> Option<Denoiser> {
    let mut settings = json(denoiser);
    *settings.pointer_mut(place)? = value;
    serde_json::from_value(settings).ok()
}

/// The options that make a method from its defaults.
pub(super) fn arguments(denoiser: &Denoiser, add: &mut impl FnMut(&str, String)) {
    let default = Denoiser::every().into_iter().find(|d| d.name() == denoiser.name()).unwrap_or_default();
    if denoiser.name() != Denoiser::default().name() {
        add("method", denoiser.name().to_owned());
    }
    let (chosen, default) = (json(denoiser), json(&default));
    for knob in &KNOBS {
        let Some(value) = chosen.pointer(knob.place) else { continue };
        if default.pointer(knob.place) != Some(value) {
            let text = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
            add(&option(knob.place), text);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of the L0 method; the command line has no options for them either.
    const HIDDEN: [&str; 4] = ["/alpha_growth", "/beta_min", "/beta_max", "/beta_growth"];

    fn leaves(value: &Value, place: &str, out: &mut Vec<String>) {
        match value.as_object() {
            Some(fields) => fields.iter().for_each(|(name, v)| leaves(v, &format!("{place}/{name}"), out)),
            None => out.push(place.to_owned()),
        }
    }

    #[test]
    fn every_setting_of_every_method_has_its_knob() {
        for denoiser in Denoiser::every() {
            let mut places = Vec::new();
            leaves(&json(&denoiser), "", &mut places);
            for place in places.iter().filter(|p| *p != "/name" && !HIDDEN.contains(&p.as_str())) {
                assert!(KNOBS.iter().any(|k| k.place == place), "{}: {place}", denoiser.name());
            }
        }
    }

    #[test]
    fn words_and_bounds_are_ones_that_methods_take() {
        for denoiser in Denoiser::every() {
            for knob in KNOBS.iter().filter(|k| json(&denoiser).pointer(k.place).is_some()) {
                let values: Vec<Value> = match knob.values {
                    Values::Count { usual } => vec![usual.into()],
                    Values::Number { least, most, .. } => vec![least.into(), most.into()],
                    Values::Words(words) => words.iter().map(|w| Value::from(*w)).collect(),
                };
                for value in values {
                    let changed = with(&denoiser, knob.place, value.clone());
                    let read = changed.as_ref().map(json).and_then(|j| j.pointer(knob.place).cloned());
                    assert_eq!(read, Some(value), "{} {}", denoiser.name(), knob.place);
                }
            }
        }
    }
}
