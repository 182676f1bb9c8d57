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
