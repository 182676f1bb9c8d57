//! The only file that reads `shaders/`.

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
}

impl Program {
    /// Every program, for tests.
    pub const ALL: [Self; 1] = [Self::Displace];

    fn parts(self) -> &'static [&'static str] {
        match self {
            Self::Displace => &[wgsl!("displace.wgsl")],
        }
    }
}

/// The whole WGSL text of a program (WGSL does not care about the order of declarations).
pub fn source(program: Program) -> String {
    program.parts().concat()
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
