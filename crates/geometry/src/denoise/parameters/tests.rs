use super::settings::leaves;
use super::{ParameterError, Values};
use crate::denoise::{Denoiser, Motion};
use serde_json::{Value, json};
use std::collections::HashMap;

fn json_of(denoiser: &Denoiser) -> Value {
    serde_json::to_value(denoiser).unwrap()
}

/// Every method with its default settings, and with those of its paper.
fn starts() -> Vec<Denoiser> {
    Denoiser::every().into_iter().flat_map(|method| [method.paper(), Some(method)]).flatten().collect()
}

#[test]
fn every_setting_of_every_method_has_its_parameter() {
    for denoiser in Denoiser::every() {
        let settings = json_of(&denoiser);
        let in_json: Vec<String> = leaves(&settings).into_iter().map(|(pointer, _)| pointer).collect();
        for pointer in in_json.iter().filter(|pointer| *pointer != "/name") {
            let count = denoiser.parameters().filter(|p| p.pointer == pointer).count();
            assert_eq!(count, 1, "{}: {pointer}", denoiser.name());
        }
        for parameter in denoiser.parameters() {
            let is_group = matches!(parameter.values, Values::Preset(_));
            let found = settings.pointer(parameter.pointer);
            assert!(found.is_some_and(|value| value.is_object() == is_group), "{} {}", denoiser.name(), parameter.name);
        }
    }
}

#[test]
fn defaults_and_settings_of_papers_are_in_their_ranges() {
    for denoiser in starts() {
        assert_eq!(denoiser.check(), Ok(()), "{denoiser:?}");
        for parameter in denoiser.options() {
            let value = denoiser.get(parameter);
            assert!(!value.is_null() || parameter.is_optional, "{} {}", denoiser.name(), parameter.name);
        }
    }
}

#[test]
fn a_name_is_the_same_kind_of_option_with_every_method_and_never_two_in_one() {
    let mut known = HashMap::new();
    for denoiser in Denoiser::every() {
        let mut names: Vec<&str> = denoiser.options().map(|p| p.name).collect();
        for parameter in denoiser.options() {
            let values = parameter.values.to_string();
            let first = known.entry(parameter.name).or_insert_with(|| values.clone());
            assert_eq!(*first, values, "{} of {}", parameter.name, denoiser.name());
            assert!(!parameter.help.is_empty() && !parameter.help.ends_with('.'), "{}", parameter.name);
            assert!(parameter.choices().iter().all(|word| !word.help.is_empty()), "{}", parameter.name);
        }
        let count = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), count, "{}", denoiser.name());
    }
}

#[test]
fn the_ends_of_a_range_are_allowed_and_what_is_beyond_is_not() {
    for denoiser in Denoiser::every() {
        for parameter in denoiser.parameters() {
            let (allowed, refused): (Vec<Value>, Vec<Value>) = match parameter.values {
                Values::Count { max, slider_max } => {
                    assert!(slider_max <= max);
                    (vec![0.into(), max.into()], vec![(max + 1).into(), (-1).into(), 0.5.into(), json!(4294967296_u64)])
                }
                Values::Number { min, max, slider_max } => {
                    assert!(min < slider_max && slider_max <= max, "{}", parameter.name);
                    (vec![min.into(), max.into()], vec![min.next_down().into(), max.next_up().into(), "x".into()])
                }
                Values::Word(words) => (words.iter().map(|w| w.name.into()).collect(), vec!["".into(), 1.into()]),
                Values::Words(words) => {
                    let all: Value = words.iter().map(|w| w.name).collect();
                    (vec![all, json!([words[0].name])], vec![json!(["x"]), words[0].name.into()])
                }
                Values::Text(_) => (vec!["a".into()], vec!["".into(), 1.into()]),
                Values::Preset(preset) => {
                    (preset.words.iter().map(|w| w.name.into()).collect(), vec!["x".into(), json!([])])
                }
            };
            for value in allowed {
                let mut changed = denoiser.clone();
                changed.set_parameter(parameter, value.clone()).unwrap();
                assert_eq!(changed.get(parameter), value, "{} {}", denoiser.name(), parameter.name);
                let read: Denoiser = serde_json::from_value(json_of(&changed)).unwrap();
                assert_eq!(read, changed);
                assert_eq!(parameter.parse(&parameter.text(&value)).unwrap_or_default(), value, "{}", parameter.name);
            }
            for value in refused {
                let mut changed = denoiser.clone();
                let error = changed.set_parameter(parameter, value.clone()).unwrap_err();
                assert!(matches!(&error, ParameterError::Value { setting, .. } if *setting == parameter.path()));
                assert_eq!(changed, denoiser);
                // A manifest is refused for the same reason.
                let mut settings = json_of(&denoiser);
                *settings.pointer_mut(parameter.pointer).unwrap() = value;
                let refused = serde_json::from_value::<Denoiser>(settings).unwrap_err().to_string();
                let is_group = matches!(parameter.values, Values::Preset(_));
                assert!(is_group || refused == error.to_string(), "{refused} / {error}");
            }
            let mut changed = denoiser.clone();
            assert_eq!(
                changed.set_parameter(parameter, Value::Null).is_ok(),
                parameter.is_optional,
                "{}",
                parameter.name
            );
        }
    }
}

#[test]
fn settings_that_are_misspelt_missing_or_no_numbers_are_named() {
    let sun = json_of(&Denoiser::named("sun").unwrap());
    let refused = |change: &dyn Fn(&mut Value)| {
        let mut settings = sun.clone();
        change(&mut settings);
        serde_json::from_value::<Denoiser>(settings).unwrap_err().to_string()
    };
    let error = refused(&|s| s["treshold"] = 0.5.into());
    assert!(
        error.starts_with("sun has no setting `treshold`; it has iterations, threshold, vertex_update."),
        "{error}"
    );
    let error = refused(&|s| s["vertex_update"]["closenes"] = 0.5.into());
    assert!(error.starts_with("sun has no setting `vertex_update.closenes`;"), "{error}");
    let error = refused(&|s| drop(s.as_object_mut().unwrap().remove("threshold")));
    assert_eq!(error, "settings of sun: missing field `threshold`");
    assert!(refused(&|s| s["vertex_update"] = 3.into()).starts_with("settings of sun: "));
    assert!(refused(&|s| s["iterations"] = json!({})).starts_with("settings of sun: "));
    let error = refused(&|s| s["vertex_update"]["boundary"] = "open".into());
    assert_eq!(error, "setting `vertex_update.boundary` of sun: \"open\" is not one of fixed, free");
    assert_eq!(refused(&|s| s["name"] = "moon".into()), "there is no method `moon`");
}

#[test]
fn settings_are_changed_by_name_all_or_none() {
    let mut map = Denoiser::named("map").unwrap();
    let before = map.clone();
    let wrong = [("strength", json!(3)), ("iterations", json!(-1))];
    assert!(map.set_all(&wrong).is_err() && map.set_all(&[("strength", json!(3)), ("threshold", json!(1))]).is_err());
    assert_eq!(map, before);
    // A preset does not undo what is set beside it, in whatever order the two are given.
    map.set_all(&[("strength", json!(3)), ("prior", json!("smooth")), ("noise_across", json!(0.1))]).unwrap();
    let settings = json_of(&map);
    assert_eq!([&settings["prior"]["strength"], &settings["prior"]["threshold"]], [3.0, 0.1]);
    assert_eq!(settings["noise_across"], 0.1);
    assert_eq!(map.get(map.parameter("prior").unwrap()), "smooth");
}

#[test]
fn changes_make_a_method_from_its_defaults() {
    let mut stronger = Denoiser::named("map").unwrap();
    stronger.set("prior", "smooth").unwrap();
    stronger.set("strength", 8.5).unwrap();
    let told = |denoiser: &Denoiser| -> Vec<String> {
        denoiser.changes().iter().map(|(p, value)| format!("{}={}", p.name, p.text(value))).collect()
    };
    assert_eq!(told(&stronger), ["prior=smooth", "strength=8.5"]);
    for denoiser in starts().into_iter().chain([stronger]) {
        let denoiser = denoiser.with_motion(Motion::AlongNormal);
        let mut made = Denoiser::named(denoiser.name()).unwrap();
        let changes: Vec<_> = denoiser.changes().into_iter().map(|(p, value)| (p.name, value)).collect();
        made.set_all(&changes).unwrap();
        assert_eq!(made, denoiser);
    }
    assert!(Denoiser::every().iter().all(|method| method.changes().is_empty()));
}

#[test]
fn a_method_says_what_it_is() {
    for denoiser in Denoiser::every() {
        let info = denoiser.info();
        assert!(!info.summary.is_empty() && !info.summary.ends_with('.'), "{}", info.name);
        assert!(info.reference.is_none_or(|paper| !paper.title.ends_with('.')), "{}", info.name);
        // Where its authors named settings there is a paper.
        assert!(denoiser.paper().is_none() || info.reference.is_some(), "{}", info.name);
        assert_eq!(Denoiser::named(info.name), Ok(denoiser));
    }
}
