//! Laws of the settings: names and JSON.

use super::*;

#[test]
fn settings_survive_json() {
    for denoiser in every() {
        let json = serde_json::to_string(&denoiser).unwrap();
        assert_eq!(serde_json::from_str::<Denoiser>(&json).unwrap(), denoiser, "{json}");
        // Settings without limits are the same text, and an unknown one is refused beside them too.
        let free = Denoising::from(denoiser.clone());
        assert_eq!(serde_json::to_string(&free).unwrap(), json);
        let denoising = Denoising { limits: limits(), ..free };
        let mut json = serde_json::to_value(&denoising).unwrap();
        assert_eq!(serde_json::from_value::<Denoising>(json.clone()).unwrap(), denoising, "{json}");
        json["no_such_setting"] = 1.into();
        assert!(serde_json::from_value::<Denoising>(json).is_err());
    }
}

#[test]
fn names_are_those_of_the_json_and_every_method_is_in_the_battery() {
    for denoiser in Denoiser::every() {
        assert_eq!(serde_json::to_value(&denoiser).unwrap()["name"], denoiser.name());
        assert!(every().iter().any(|tested| tested.name() == denoiser.name()), "{}", denoiser.name());
        let along = denoiser.clone().with_motion(Motion::AlongNormal);
        assert_eq!(along.motion(), denoiser.motion().map(|_| Motion::AlongNormal));
        assert!(denoiser.paper().is_none_or(|paper| paper.name() == denoiser.name()));
    }
}

#[test]
fn a_method_with_a_setting_for_the_motion_has_that_motion() {
    for denoiser in every() {
        let settings = serde_json::to_value(&denoiser).unwrap();
        let of_method = settings.get("motion").or_else(|| settings.get("vertex_update")?.get("motion"));
        let found = denoiser.motion().map(|motion| serde_json::to_value(motion).unwrap());
        assert_eq!(found.as_ref(), of_method, "{denoiser:?}");
        let freed = denoiser.freed();
        assert!(freed.motion().is_none_or(|motion| motion == Motion::Free) && freed.name() == denoiser.name());
    }
}

#[test]
fn every_method_says_what_it_does_in_a_line_of_its_own() {
    let mut said: Vec<&str> = Denoiser::every().iter().map(Denoiser::summary).collect();
    assert!(
        said.iter().all(|line| line.split(' ').count() > 4 && !line.contains('\n') && !line.ends_with('.')),
        "{said:?}"
    );
    said.sort_unstable();
    said.dedup();
    assert_eq!(said.len(), Denoiser::every().len());
}
