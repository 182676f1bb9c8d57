//! Meshes in all the ways OBJ allows to write them.

use super::{coarse, finite};
use glam::{DVec2, DVec3};
use proptest::collection::vec;
use proptest::prelude::*;
use std::ops::Range;

/// Numbers of the `v`, `vt` and `vn` line, counted from 0.
pub(super) type Corner = (usize, Option<usize>, Option<usize>);

/// What a file says, without how.
#[derive(Clone, Debug)]
pub(super) struct Mesh {
    pub(super) positions: Vec<DVec3>,
    pub(super) uvs: Vec<DVec2>,
    pub(super) normals: Vec<DVec3>,
    pub(super) faces: Vec<Vec<Corner>>,
}

pub(super) fn number() -> impl Strategy<Value = f64> {
    prop_oneof![3 => coarse(), 1 => finite()]
}

pub(super) fn position() -> impl Strategy<Value = DVec3> {
    [number(), number(), number()].prop_map(DVec3::from)
}

pub(super) fn mesh() -> impl Strategy<Value = Mesh> {
    (1..12_usize, 0..6_usize, 0..6_usize).prop_flat_map(|(v, vt, vn)| {
        // The first of one more than there are stands for none.
        let maybe = |count: usize| (0..=count).prop_map(|i| i.checked_sub(1));
        let uv = [number(), number()].prop_map(DVec2::from);
        let faces = vec(vec((0..v, maybe(vt), maybe(vn)), 3..7), 1..8);
        (vec(position(), v), vec(uv, vt), vec(position(), vn), faces)
            .prop_map(|(positions, uvs, normals, faces)| Mesh { positions, uvs, normals, faces })
    })
}

/// A spelled file.
#[derive(Clone, Debug, Default)]
pub(super) struct Spelled {
    pub(super) bytes: Vec<u8>,
    /// Where the coordinates of the `v` lines stand, x, y, z of one after the other.
    pub(super) coordinates: Vec<Range<usize>>,
    /// `v` lines with more than three numbers.
    pub(super) extended: usize,
}

pub(super) fn spelled() -> impl Strategy<Value = (Mesh, Spelled)> {
    (mesh(), vec(any::<u8>(), 0..400)).prop_map(|(mesh, choices)| {
        let spelled = Speller::new(&mesh, choices).spell();
        (mesh, spelled)
    })
}

/// Writes a mesh; each choice takes the next of some random bytes, and zero behind the last. Zero is the plainest way,
/// so that a failure shrinks to what matters.
struct Speller<'a> {
    mesh: &'a Mesh,
    choices: Vec<u8>,
    chosen: usize,
    eol: &'static str,
    out: Spelled,
    /// Lines of each kind so far: v, vt, vn, f.
    written: [usize; 4],
}

/// Lines that change nothing of the surface.
const BYSTANDERS: [&str; 15] = [
    "",
    "# comment",
    "#\\",
    "  \t",
    "o C:\\",
    "g a b",
    "s 1",
    "s off",
    "usemtl my skin\\",
    "mtllib a b.mtl",
    "l 1 2 3",
    "p 1",
    "vp 0.5 0.5",
    "unknown # thing \\",
    "\t# f 1 2 3",
];

impl<'a> Speller<'a> {
    fn new(mesh: &'a Mesh, choices: Vec<u8>) -> Self {
        Self { mesh, choices, chosen: 0, eol: "\n", out: Spelled::default(), written: [0; 4] }
    }

    fn choose<T: Copy>(&mut self, from: &[T]) -> T {
        let choice = self.choices.get(self.chosen).copied().unwrap_or(0);
        self.chosen += 1;
        from[usize::from(choice) % from.len()]
    }

    fn push(&mut self, text: &str) {
        self.out.bytes.extend_from_slice(text.as_bytes());
    }

    fn spell(mut self) -> Spelled {
        self.eol = self.choose(&["\n", "\r\n", "\r"]);
        let mark = self.choose(&["", "\u{feff}"]);
        self.push(mark);
        let totals = [self.mesh.positions.len(), self.mesh.uvs.len(), self.mesh.normals.len(), self.mesh.faces.len()];
        while self.written != totals {
            while self.choose(&[false, false, true]) {
                let line = self.choose(&BYSTANDERS);
                self.push(line);
                self.push(self.eol);
            }
            // Kinds may alternate, and faces come before what they name.
            let left: Vec<usize> = (0..4).filter(|&kind| self.written[kind] < totals[kind]).collect();
            let kind = self.choose(&left);
            let indent = self.choose(&["", " ", "\t"]);
            self.push(indent);
            match kind {
                0 => self.position(),
                1 => self.uv(),
                2 => self.normal(),
                _ => self.face(),
            }
            self.written[kind] += 1;
            let tail = self.choose(&["", " ", "\t", " # 1 2 3", " #\\", "#"]);
            self.push(tail);
            if self.written != totals || self.choose(&[true, false]) {
                self.push(self.eol);
            }
        }
        self.out
    }

    fn separator(&mut self) {
        let separator = self.choose(&[" ", "\t", "  ", " \t", "\\", " \\"]);
        self.push(separator);
        if separator.ends_with('\\') {
            self.push(self.eol);
            let indent = self.choose(&["", "  "]);
            self.push(indent);
        }
    }

    fn number(&mut self, x: f64) -> Range<usize> {
        self.separator();
        let text = match self.choose(&[0, 1, 2, 3]) {
            0 => format!("{x:?}"),
            1 => format!("{x:e}"),
            2 => format!("{x}"),
            _ if x.is_sign_positive() => format!("+{x:E}"),
            _ => format!("{x:E}"),
        };
        let start = self.out.bytes.len();
        self.push(&text);
        start..self.out.bytes.len()
    }

    fn position(&mut self) {
        self.push("v");
        for x in self.mesh.positions[self.written[0]].to_array() {
            let place = self.number(x);
            self.out.coordinates.push(place);
        }
        let more: &[f64] = self.choose(&[&[][..], &[1.0], &[0.1, 0.2, 0.3], &[1.0, 0.1, 0.2, 0.3]]);
        self.out.extended += usize::from(!more.is_empty());
        for &x in more {
            self.number(x);
        }
    }

    fn uv(&mut self) {
        self.push("vt");
        for x in self.mesh.uvs[self.written[1]].to_array() {
            self.number(x);
        }
        if self.choose(&[false, true]) {
            self.number(0.0);
        }
    }

    fn normal(&mut self) {
        self.push("vn");
        for x in self.mesh.normals[self.written[2]].to_array() {
            self.number(x);
        }
    }

    fn face(&mut self) {
        self.push("f");
        for &(v, vt, vn) in &self.mesh.faces[self.written[3]] {
            self.separator();
            self.index(0, v);
            match (vt, vn) {
                (None, None) => {
                    let slashes = self.choose(&["", "/", "//"]);
                    self.push(slashes);
                }
                (Some(vt), None) => {
                    self.push("/");
                    self.index(1, vt);
                    let slash = self.choose(&["", "/"]);
                    self.push(slash);
                }
                (vt, Some(vn)) => {
                    self.push("/");
                    if let Some(vt) = vt {
                        self.index(1, vt);
                    }
                    self.push("/");
                    self.index(2, vn);
                }
            }
        }
    }

    /// From the front, or from the back if the line is there already.
    fn index(&mut self, kind: usize, index: usize) {
        let so_far = self.written[kind];
        let backwards = index < so_far && self.choose(&[false, true]);
        let text = if backwards { format!("-{}", so_far - index) } else { format!("{}", index + 1) };
        self.push(&text);
    }
}
