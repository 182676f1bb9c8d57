//! The only file that reads `shaders/`.

macro_rules! wgsl {
    ($name:literal) => {
        include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shaders/", $name))
    };
}

/// One shader module.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Program {
    /// The displacement alone, to be joined to a vertex stage.
    Displace,
    /// The displaced mesh; every way to shade it is an entry point.
    Mesh,
    /// What is behind it.
    Background,
    /// Samples to pixels.
    Resolve,
    /// Displaced positions and their normals.
    Derive,
    /// Wires and seams.
    Overlay,
    /// The colour bar.
    Legend,
}

impl Program {
    /// Every program, for tests.
    pub const ALL: [Self; 7] = [
        Self::Displace,
        Self::Mesh,
        Self::Background,
        Self::Resolve,
        Self::Derive,
        Self::Overlay,
        Self::Legend,
    ];

    fn parts(self) -> &'static [&'static str] {
        match self {
            Self::Displace => &[wgsl!("displace.wgsl")],
            Self::Mesh => &[
                wgsl!("frame.wgsl"),
                wgsl!("colour.wgsl"),
                wgsl!("vector.wgsl"),
                wgsl!("displace.wgsl"),
                wgsl!("wedge.wgsl"),
                wgsl!("pictures.wgsl"),
                wgsl!("mesh_vertex.wgsl"),
                wgsl!("unshadowed.wgsl"),
                wgsl!("lighting.wgsl"),
                wgsl!("noise.wgsl"),
                wgsl!("tilt.wgsl"),
                wgsl!("clay.wgsl"),
                wgsl!("gouraud.wgsl"),
                wgsl!("mesh.wgsl"),
            ],
            Self::Background => {
                &[wgsl!("frame.wgsl"), wgsl!("colour.wgsl"), wgsl!("screen.wgsl"), wgsl!("background.wgsl")]
            }
            Self::Derive => {
                &[wgsl!("displace.wgsl"), wgsl!("vector.wgsl"), wgsl!("wedge.wgsl"), wgsl!("derive.wgsl")]
            }
            Self::Overlay => &[
                wgsl!("frame.wgsl"),
                wgsl!("displace.wgsl"),
                wgsl!("wedge.wgsl"),
                wgsl!("pictures.wgsl"),
                wgsl!("mesh_vertex.wgsl"),
                wgsl!("overlay.wgsl"),
            ],
            Self::Legend => &[wgsl!("colour.wgsl"), wgsl!("legend.wgsl")],
            Self::Resolve => &[wgsl!("colour.wgsl"), wgsl!("screen.wgsl"), wgsl!("resolve.wgsl")],
        }
    }
}

/// The whole WGSL text of a program (WGSL does not care about the order of declarations).
pub fn source(program: Program) -> String {
    program.parts().concat()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use naga::valid::{Capabilities, ValidationFlags, Validator};

    pub(crate) fn module(program: Program) -> naga::Module {
        let text = source(program);
        naga::front::wgsl::parse_str(&text).unwrap_or_else(|e| panic!("{program:?}\n{}", e.emit_to_string(&text)))
    }

    #[test]
    fn every_program_validates() {
        for program in Program::ALL {
            let text = source(program);
            Validator::new(ValidationFlags::all(), Capabilities::default())
                .validate(&module(program))
                .unwrap_or_else(|e| panic!("{program:?}\n{}", e.emit_to_string(&text)));
        }
    }
}
