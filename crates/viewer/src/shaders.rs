//! The only file that reads `shaders/`.

use crate::settings::{Normals, Overlay, Sampling, Shading};
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
}

impl Program {
    /// Every program, for tests.
    pub const ALL: [Self; 4] = [Self::Displace, Self::Background, Self::Mesh, Self::Normals];

    fn parts(self) -> &'static [&'static str] {
        match self {
            Self::Displace => &[wgsl!("displace.wgsl")],
            Self::Background => &[wgsl!("frame.wgsl"), wgsl!("background.wgsl")],
            Self::Mesh => &[
                wgsl!("frame.wgsl"),
                wgsl!("displace.wgsl"),
                wgsl!("surface.wgsl"),
                wgsl!("light.wgsl"),
                wgsl!("textures.wgsl"),
                wgsl!("mesh.wgsl"),
            ],
            Self::Normals => &[wgsl!("displace.wgsl"), wgsl!("surface.wgsl"), wgsl!("normals.wgsl")],
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
