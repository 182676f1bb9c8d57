//! Programs joined from the files of `planish-shaders`, for the choices of the settings.

use crate::settings::shadow::{Filter, Outside};
use crate::settings::volume::VolumeDisplay;
use crate::settings::{Normals, Overlay, Sampling, Shading};
use planish_shaders::{
    BACKGROUND, DISPLACE, ENVIRONMENT, FRAME, GROUND, LIGHT, MESH, NOISE, NORMALS, SHADOW, SHADOW_MAP, SHADOW_VIEW,
    SURFACE, TEXTURES, VOLUME,
};
use std::fmt::Write as _;

/// Shader module that can be joined from the WGSL files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Program {
    /// The background behind the model.
    Background,
    /// The displaced surface in colour.
    Mesh,
    /// Displaced positions of the vertices and their normals.
    Normals,
    /// Depth of the displaced surface as a light sees it.
    Shadow,
    /// A shadow map itself.
    ShadowView,
    /// The plane under the model.
    Ground,
}

impl Program {
    /// Every program, for tests.
    #[cfg(test)]
    const ALL: [Self; 6] = [Self::Background, Self::Mesh, Self::Normals, Self::Shadow, Self::ShadowView, Self::Ground];

    fn parts(self) -> &'static [&'static str] {
        match self {
            Self::Background => &[FRAME, SHADOW, ENVIRONMENT, LIGHT, VOLUME, BACKGROUND],
            Self::Mesh => &[FRAME, DISPLACE, SURFACE, SHADOW, ENVIRONMENT, LIGHT, VOLUME, TEXTURES, NOISE, MESH],
            Self::Normals => &[DISPLACE, SURFACE, NORMALS],
            Self::Shadow => &[DISPLACE, SURFACE, SHADOW_MAP],
            Self::ShadowView => &[FRAME, SHADOW, SHADOW_VIEW],
            Self::Ground => &[FRAME, SHADOW, ENVIRONMENT, LIGHT, VOLUME, GROUND],
        }
    }
}

/// Choices that a program is compiled for. What is not chosen costs nothing then, not even on drivers that run every branch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Variant {
    /// Shading of the surface.
    pub(super) shading: Shading,
    /// Normals that light the surface.
    pub(super) normals: Normals,
    /// Lines on top of the surface.
    pub(super) overlay: Overlay,
    /// Interpolation of textures between their texels.
    pub(super) sampling: Sampling,
    /// Filter of the lookups in shadow maps.
    pub(super) filter: Filter,
    /// Light at positions that no shadow map covers.
    pub(super) outside: Outside,
    /// Display of the volume of the scene.
    pub(super) volume: VolumeDisplay,
}

/// The whole WGSL text of a program (WGSL does not care about the order of declarations).
pub(super) fn source(program: Program, variant: Variant) -> String {
    let mut text = program.parts().concat();
    if matches!(program, Program::Mesh) {
        constants(&mut text, "SHADING", Shading::NAMES, variant.shading.name());
        constants(&mut text, "NORMALS", Normals::NAMES, variant.normals.name());
        constants(&mut text, "OVERLAY", Overlay::NAMES, variant.overlay.name());
        constants(&mut text, "SAMPLING", Sampling::NAMES, variant.sampling.name());
    }
    if matches!(program, Program::Background | Program::Mesh | Program::Ground) {
        constants(&mut text, "VOLUME", VolumeDisplay::NAMES, variant.volume.name());
    }
    if matches!(program, Program::Background | Program::Mesh | Program::ShadowView | Program::Ground) {
        constants(&mut text, "FILTER", Filter::NAMES, variant.filter.name());
        constants(&mut text, "OUTSIDE", Outside::NAMES, variant.outside.name());
    }
    text
}

/// Appends numbers for the choices of a setting, `const SHADING_FLAT = 0u;` and so on, and the chosen one as `SHADING`.
fn constants(text: &mut String, prefix: &str, names: &[&str], chosen: &str) {
    for (number, &name) in names.iter().enumerate() {
        let word = name.to_uppercase().replace('-', "_");
        // Writing to a string cannot fail.
        let _ = writeln!(text, "const {prefix}_{word} = {number}u;");
        if name == chosen {
            let _ = writeln!(text, "const {prefix} = {prefix}_{word};");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use naga::valid::{Capabilities, ValidationFlags, Validator};

    fn validate(program: Program, variant: Variant) {
        let text = source(program, variant);
        let module = naga::front::wgsl::parse_str(&text)
            .unwrap_or_else(|e| panic!("{program:?} {variant:?}\n{}", e.emit_to_string(&text)));
        Validator::new(ValidationFlags::all(), Capabilities::default())
            .validate(&module)
            .unwrap_or_else(|e| panic!("{program:?} {variant:?}\n{}", e.emit_to_string(&text)));
    }

    #[test]
    fn every_program_validates() {
        Program::ALL.into_iter().for_each(|program| validate(program, Variant::default()));
    }

    #[test]
    fn every_choice_validates() {
        let usual = Variant::default();
        let mesh = |variant| validate(Program::Mesh, variant);
        Shading::ALL.iter().for_each(|&shading| mesh(Variant { shading, ..usual }));
        Normals::ALL.iter().for_each(|&normals| mesh(Variant { normals, ..usual }));
        Overlay::ALL.iter().for_each(|&overlay| mesh(Variant { overlay, ..usual }));
        Sampling::ALL.iter().for_each(|&sampling| mesh(Variant { sampling, shading: Shading::Texture, ..usual }));
        for &volume in VolumeDisplay::ALL {
            for program in [Program::Background, Program::Mesh, Program::Ground] {
                validate(program, Variant { volume, ..usual });
            }
        }
        for (&filter, &outside) in Filter::ALL.iter().flat_map(|f| Outside::ALL.iter().map(move |o| (f, o))) {
            for program in [Program::Mesh, Program::Ground, Program::ShadowView] {
                validate(program, Variant { filter, outside, ..usual });
            }
        }
    }
}
