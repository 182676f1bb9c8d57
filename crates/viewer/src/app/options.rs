//! Settings of the methods: what the panel shows of them, and their options on the command line.

use planish_geometry::denoise::{Denoiser, Prior};
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
        /// Whether it is measured on the mesh where it is not given.
        measured: bool,
    },
    /// One of these words.
    Words {
        /// All of them.
        all: &'static [&'static str],
        /// Whether it is measured on the mesh where it is not given.
        measured: bool,
    },
    /// Some of these words; none are chosen by what the mesh is like.
    Several(&'static [&'static str]),
    /// One of [`PRIORS`].
    Prior,
}

const fn count(usual: u32) -> Values {
    Values::Count { usual }
}

const fn number(least: f64, usual: f64, most: f64) -> Values {
    Values::Number { least, most, usual, measured: false }
}

const fn words(all: &'static [&'static str]) -> Values {
    Values::Words { all, measured: false }
}

const fn knob(place: &'static str, label: &'static str, values: Values, help: &'static str) -> Knob {
    Knob { place, label, help, values }
}

/// Smallest and largest of a number that is above zero, as on the command line.
const TINY: f64 = 1e-6;
const HUGE: f64 = 1e6;
const BOUNDARIES: Values = words(&["fixed", "free"]);
const MOTIONS: Values = words(&["free", "along-normal"]);

/// Priors of the method `map` by their names on the command line, from flat to smooth.
pub const PRIORS: [(&str, Prior); 6] = [
    ("flat", Prior::FLAT),
    ("sharp", Prior::SHARP),
    ("creases", Prior::CREASES),
    ("mixed", Prior::MIXED),
    ("detail", Prior::DETAIL),
    ("smooth", Prior::SMOOTH),
];

/// In the order of the panel; a method shows those that it has.
pub const KNOBS: &[Knob] = &[
    knob("/prior", "prior", Values::Prior, "What surfaces are taken to be like"),
    knob(
        "/noise",
        "noise",
        Values::Number { least: 0.0, usual: 1.0, most: HUGE, measured: true },
        "Standard deviation of the noise, mean edge lengths",
    ),
    knob(
        "/noise_across",
        "across",
        Values::Number { least: 0.0, usual: 1.0, most: HUGE, measured: true },
        "The same across the normals, at most",
    ),
    knob(
        "/kind",
        "noise kind",
        Values::Words { all: &["none", "independent", "uneven", "correlated"], measured: true },
        "What the noise is like",
    ),
    knob(
        "/candidates",
        "candidates",
        Values::Several(&[
            "flat",
            "sharp",
            "creases",
            "mixed",
            "detail",
            "smooth",
            "linear-faint",
            "linear-light",
            "linear",
            "linear-strong",
            "stay",
        ]),
        "What is tried",
    ),
    knob("/prior/strength", "strength", number(TINY, 10.0, HUGE), "Weight of the prior against the data"),
    knob("/prior/rounds", "iterations", count(30), "Rounds of reweighting"),
    knob("/iterations", "iterations", count(100), "Number of steps; of the normals with the filters of normals"),
    knob("/step", "step", number(0.0, 1.0, 1.0), "Share of the way to the mean of the neighbours that a step goes"),
    knob("/inflate", "inflate", number(-1.5, 0.0, 0.0), "The step away from the mean that follows each step"),
    knob("/time", "time", number(0.0, 10.0, HUGE), "How long a step is, in whole steps of the laplacian"),
    knob("/solver", "solver", words(&["iterative", "direct"]), "Direct is exact, for up to some 100 000 vertices"),
    knob("/weights", "weights", words(&["uniform", "cotangent"]), "How much each neighbour counts"),
    knob(
        "/alpha",
        "alpha",
        number(0.0, 1.0, 1.0),
        "hc: share of the input in the place that vertices are pushed back to; l0: weight against folds",
    ),
    knob("/beta", "beta", number(0.0, 1.0, 1.0), "Share of a vertex's own way in how far it is pushed back"),
    knob("/threshold", "threshold", number(0.0, 1.0, 1.0), "Cosine of the angle beyond which neighbours do not count"),
    knob("/scheme", "scheme", words(&["local", "global"]), "Step by step, or one linear system"),
    knob(
        "/smoothness",
        "smoothness",
        number(TINY, 1.0, 1.0),
        "How near normals stay to the input, with the global scheme",
    ),
    knob(
        "/neighbours",
        "neighbours",
        words(&["vertex", "edge"]),
        "Which faces are averaged: those that share a vertex or an edge",
    ),
    knob(
        "/radius",
        "radius",
        number(TINY, 5.0, HUGE),
        "How far off faces are averaged, in mean distances of neighbouring faces",
    ),
    knob(
        "/sigma_spatial",
        "σ spatial",
        number(TINY, 4.0, HUGE),
        "Reach of the filter, in mean distances of neighbouring faces",
    ),
    knob("/sigma_range", "σ range", number(TINY, 1.5, HUGE), "How far unit normals may differ and still be averaged"),
    knob("/sparsity", "sparsity", number(0.0, 4.0, HUGE), "More than 1 makes more edges flat, less makes fewer"),
    knob(
        "/fidelity",
        "fidelity",
        number(TINY, 4.0, HUGE),
        "How near normals stay to the input, against how noisy they are",
    ),
    knob(
        "/second_order",
        "second order",
        number(TINY, 2.0, HUGE),
        "Weight of curvature that changes against normals that jump",
    ),
    knob(
        "/vertex_update/scheme",
        "vertex update",
        words(&["descent", "least-squares"]),
        "How vertices follow the filtered normals: some steps, or to the end",
    ),
    knob("/vertex_update/iterations", "vertex steps", count(100), "Steps of the vertices towards the filtered normals"),
    knob(
        "/vertex_update/closeness",
        "closeness",
        number(0.0, 1.0, HUGE),
        "Pull of the vertices to the input, in pulls of a face around",
    ),
    knob("/motion", "motion", MOTIONS, "Where vertices may go; maps of heights are along-normal always"),
    knob("/vertex_update/motion", "motion", MOTIONS, "Where vertices may go; maps of heights are along-normal always"),
    knob(
        "/vertex_update/fold_overs",
        "fold-overs",
        words(&["prevent", "allow"]),
        "What happens to steps that fold the surface over",
    ),
    knob("/boundary", "boundary", BOUNDARIES, "What happens at the rim of an open mesh"),
    knob("/vertex_update/boundary", "boundary", BOUNDARIES, "What happens at the rim of an open mesh"),
];

/// Option of a setting on the command line, without dashes.
pub fn option(place: &str) -> String {
    match place {
        "/kind" => "noise-kind".to_owned(),
        "/prior/rounds" => "iterations".to_owned(),
        "/vertex_update/scheme" => "vertex-update".to_owned(),
        "/vertex_update/iterations" => "vertex-iterations".to_owned(),
        _ => place.rsplit('/').next().unwrap_or_default().replace('_', "-"),
    }
}

/// The name of the prior that a method has, whatever its strength and rounds.
pub fn prior_name(prior: &Value) -> &'static str {
    let shape = |prior: &Value| ["exponent", "threshold", "curvature", "spread"].map(|field| prior[field].clone());
    let same = |known: &&(&str, Prior)| shape(&serde_json::to_value(known.1).unwrap_or_default()) == shape(prior);
    PRIORS.iter().find(same).map_or("", |known| known.0)
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

/// What a method is good for, in a few words.
pub fn described(method: &str) -> &'static str {
    match method {
        "auto" => "measures the noise and mixes what suits it",
        "map" => "most probable surface, for any shape whose nature is known",
        "laplacian" => "steps to the mean of the neighbours: light noise, organic shapes",
        "taubin" => "smoothing that does not shrink: light noise, organic shapes",
        "hc" => "smoothing that is pushed back after each step",
        "implicit" => "one long stable step: strong smoothing",
        "bilateral" => "filter of the vertices that keeps edges: light noise",
        "sun" => "averaged face normals: sharp edges",
        "bilateral-normals" => "bilateral filter of the face normals: sharp edges",
        "guided-normals" => "guided by consistent patches: sharp edges, heavy noise",
        "l0" => "few edges that are not flat: parts made of planes",
        "tgv-normals" => "sharp edges and curved faces",
        _ => "",
    }
}

/// The method of that name with its default settings.
pub fn named(name: &str) -> Denoiser {
    Denoiser::every().into_iter().find(|method| method.name() == name).unwrap_or_default()
}

/// The options that make a method from its defaults.
pub(super) fn arguments(denoiser: &Denoiser, add: &mut impl FnMut(&str, String)) {
    if denoiser.name() != Denoiser::default().name() {
        add("method", denoiser.name().to_owned());
    }
    let (chosen, mut known) = (json(denoiser), json(&named(denoiser.name())));
    for knob in KNOBS {
        let (Some(value), Some(before)) = (chosen.pointer(knob.place), known.pointer(knob.place)) else { continue };
        if knob.values == Values::Prior {
            let name = prior_name(value);
            if name != prior_name(before)
                && let Some((_, prior)) = PRIORS.iter().find(|known| known.0 == name)
            {
                add("prior", name.to_owned());
                // The other settings of a prior are what this one has.
                known[&knob.place[1..]] = serde_json::to_value(prior).unwrap_or_default();
            }
        } else if before != value {
            add(&option(knob.place), text(value));
        }
    }
}

/// A value as the command line has it.
fn text(value: &Value) -> String {
    match value {
        Value::String(word) => word.clone(),
        Value::Array(all) => all.iter().map(text).collect::<Vec<_>>().join(","),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of the methods l0 and map; the command line has no options for them either.
    const HIDDEN: [&str; 9] = [
        "/alpha_growth",
        "/beta_min",
        "/beta_max",
        "/beta_growth",
        "/steps",
        "/prior/exponent",
        "/prior/threshold",
        "/prior/curvature",
        "/prior/spread",
    ];

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

    /// All values that a knob stands for, at its ends.
    pub(crate) fn values(knob: &Knob) -> Vec<Value> {
        match knob.values {
            Values::Count { usual } => vec![usual.into()],
            Values::Number { least, most, .. } => vec![least.into(), most.into()],
            Values::Words { all, .. } => all.iter().map(|w| Value::from(*w)).collect(),
            Values::Several(all) => vec![all.into(), all[..1].into()],
            Values::Prior => PRIORS.iter().map(|(_, prior)| serde_json::to_value(prior).unwrap()).collect(),
        }
    }

    #[test]
    fn words_and_bounds_are_ones_that_methods_take() {
        for denoiser in Denoiser::every() {
            for knob in KNOBS.iter().filter(|k| json(&denoiser).pointer(k.place).is_some()) {
                for value in values(knob) {
                    let changed = with(&denoiser, knob.place, value.clone());
                    let read = changed.as_ref().map(json).and_then(|j| j.pointer(knob.place).cloned());
                    assert_eq!(read, Some(value), "{} {}", denoiser.name(), knob.place);
                }
            }
        }
    }

    #[test]
    fn every_method_is_described() {
        let silent = Denoiser::every().into_iter().find(|method| described(method.name()).is_empty());
        assert_eq!(silent, None);
    }

    #[test]
    fn priors_are_told_apart_whatever_their_strength() {
        for (name, prior) in PRIORS {
            let stronger = Prior { strength: 9.0, rounds: 1, ..prior };
            assert_eq!(prior_name(&serde_json::to_value(stronger).unwrap()), name);
        }
    }

    #[test]
    fn only_what_differs_from_the_prior_that_is_named_is_said() {
        let smooth = with(&named("map"), "/prior", serde_json::to_value(Prior::SMOOTH).unwrap()).unwrap();
        let stronger = with(&smooth, "/prior/strength", 8.5.into()).unwrap();
        let mut words = Vec::new();
        arguments(&stronger, &mut |option, value| words.push(format!("{option}={value}")));
        assert_eq!(words, ["method=map", "prior=smooth", "strength=8.5"]);
    }
}
