//! The only file that reads `shaders/`.

use crate::settings::{Normals, Overlay, Sampling, Shading};
use crate::shadow::{Filter, Outside};
use clap::ValueEnum;
use std::fmt::Write as _;

macro_rules! wgsl {
    ($name:literal) => {
        include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shaders/", $name))
    };
}

/// One shader module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Program {
    /// The displacement alone, to be joined to a vertex stage.
    Displace,
    /// What lies behind the model.
    Background,
    /// The displaced surface in colour.
    Mesh,
    /// Where the vertices go, and the normals there.
    Normals,
    /// What a light sees of the displaced surface.
    Shadow,
    /// A shadow map itself.
    ShadowView,
    /// The plane under the model.
    Ground,
}

impl Program {
    /// Every program, for tests.
    pub const ALL: [Self; 7] =
        [Self::Displace, Self::Background, Self::Mesh, Self::Normals, Self::Shadow, Self::ShadowView, Self::Ground];

    fn parts(self) -> &'static [&'static str] {
        match self {
            Self::Displace => &[wgsl!("displace.wgsl")],
            Self::Background => &[wgsl!("frame.wgsl"), wgsl!("environment.wgsl"), wgsl!("background.wgsl")],
            Self::Mesh => &[
                wgsl!("frame.wgsl"),
                wgsl!("displace.wgsl"),
                wgsl!("surface.wgsl"),
                wgsl!("shadow.wgsl"),
                wgsl!("environment.wgsl"),
                wgsl!("light.wgsl"),
                wgsl!("textures.wgsl"),
                wgsl!("noise.wgsl"),
                wgsl!("mesh.wgsl"),
            ],
            Self::Normals => &[wgsl!("displace.wgsl"), wgsl!("surface.wgsl"), wgsl!("normals.wgsl")],
            Self::Shadow => &[wgsl!("displace.wgsl"), wgsl!("surface.wgsl"), wgsl!("shadow_map.wgsl")],
            Self::ShadowView => &[wgsl!("frame.wgsl"), wgsl!("shadow.wgsl"), wgsl!("shadow_view.wgsl")],
            Self::Ground => &[
                wgsl!("frame.wgsl"),
                wgsl!("shadow.wgsl"),
                wgsl!("environment.wgsl"),
                wgsl!("light.wgsl"),
                wgsl!("ground.wgsl"),
            ],
        }
    }
}

/// The whole WGSL text of a program (WGSL does not care about the order of declarations).
pub fn source(program: Program) -> String {
    let mut text = program.parts().concat();
    if matches!(program, Program::Mesh) {
        constants(&mut text, "SHADING", Shading::ALL);
        constants(&mut text, "NORMALS", Normals::ALL);
        constants(&mut text, "OVERLAY", Overlay::ALL);
        constants(&mut text, "SAMPLING", Sampling::ALL);
    }
    if matches!(program, Program::Mesh | Program::ShadowView | Program::Ground) {
        constants(&mut text, "FILTER", Filter::ALL);
        constants(&mut text, "OUTSIDE", Outside::ALL);
    }
    text
}

/// Numbers for the choices of the settings: `const SHADING_FLAT = 0u;` and so on.
fn constants<T: ValueEnum>(text: &mut String, prefix: &str, all: &[T]) {
    for (number, choice) in all.iter().filter_map(ValueEnum::to_possible_value).enumerate() {
        let name = choice.get_name().to_uppercase().replace('-', "_");
        // Writing to a string cannot fail.
        let _ = writeln!(text, "const {prefix}_{name} = {number}u;");
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use naga::valid::{Capabilities, ValidationFlags, Validator};

    #[test]
    fn every_program_validates() {
        for program in Program::ALL {
            let text = source(program);
            let module = naga::front::wgsl::parse_str(&text)
                .unwrap_or_else(|e| panic!("{program:?}\n{}", e.emit_to_string(&text)));
            Validator::new(ValidationFlags::all(), Capabilities::default())
                .validate(&module)
                .unwrap_or_else(|e| panic!("{program:?}\n{}", e.emit_to_string(&text)));
        }
    }
}
