//! Small meshes and settings of a bake, read from any bytes.

use planish_geometry::bake::{BakeSettings, Carriers, CurvatureMap, Lambda, LargestSide, LayoutChoice};
use planish_geometry::denoise::{Denoiser, Laplacian, NormalField};
use planish_geometry::map::displacement::{MapKind, TexelFormat};
use planish_geometry::map::occlusion::Occlusion;
use planish_geometry::map::{Interpolation, Texels};
use planish_geometry::mesh::weld::Welding;
use planish_geometry::source::model::NormalSource;
use std::fmt::Write as _;

/// Numbers that are rarely met.
const SPECIAL: [f64; 12] =
    [0.0, -0.0, 1.0, 0.5, 1e-30, 1e30, -1e30, 1e-310, 3.4e38, 1e45, 4_500_000.25, -0.333_333_333_333_333_3];

/// Largest numbers of vertices and faces.
const MOST: usize = 24;

/// Bytes that are taken one after the other; zeros follow the last one.
struct Bytes<'a>(std::slice::Iter<'a, u8>);

impl Bytes<'_> {
    fn byte(&mut self) -> u8 {
        self.0.next().copied().unwrap_or(0)
    }
    fn below(&mut self, count: usize) -> usize {
        usize::from(self.byte()) % count
    }
    fn of<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.below(choices.len())]
    }
    /// A small number with few digits mostly, so that coincidences happen; sometimes a special one.
    fn number(&mut self) -> f64 {
        let byte = self.byte();
        if byte >= 250 { self.of(&SPECIAL) } else { (f64::from(byte) - 125.0) / 64.0 }
    }
}

/// Reads settings and the text of an OBJ.
pub(super) fn read(data: &[u8]) -> (String, BakeSettings) {
    let mut bytes = Bytes(data.iter());
    let settings = settings(&mut bytes);
    let mut text = String::new();
    let (vertices, uvs, faces) = (3 + bytes.below(MOST), bytes.below(MOST), 1 + bytes.below(MOST));
    for _ in 0..vertices {
        let [x, y, z] = [bytes.number(), bytes.number(), bytes.number()];
        let _ = writeln!(text, "v {x:e} {y:e} {z:e}");
    }
    for _ in 0..uvs {
        let [u, v] = [bytes.number(), bytes.number()];
        let _ = writeln!(text, "vt {u:e} {v:e}");
    }
    for _ in 0..faces {
        text.push('f');
        for _ in 0..3 + bytes.below(3) {
            let v = 1 + bytes.below(vertices);
            let vt = bytes.below(uvs + 1);
            let _ = if vt > 0 { write!(text, " {v}/{vt}") } else { write!(text, " {v}") };
        }
        text.push('\n');
    }
    (text, settings)
}

fn settings(bytes: &mut Bytes) -> BakeSettings {
    let laplacian = Laplacian { iterations: bytes.below(4) as u32, ..Laplacian::default() };
    let side = bytes.of(&[None, Some(1), Some(7), Some(64)]);
    BakeSettings {
        target: Denoiser::Laplacian(laplacian).into(),
        welding: bytes.of(&[Welding::Exact, Welding::None, Welding::Epsilon(0.01)]),
        normals: bytes.of(&[
            None,
            Some(NormalField::Source(NormalSource::Uniform)),
            Some(NormalField::Denoised),
            Some(NormalField::Tilted),
        ]),
        lambda: Lambda(bytes.of(&[1.0, 0.0, -3.5])),
        map: bytes.of(&[MapKind::Scalar, MapKind::VectorObject, MapKind::VectorTangent]),
        layout: bytes.of(&[LayoutChoice::Auto, LayoutChoice::Uv, LayoutChoice::Vertex]),
        side,
        largest_side: LargestSide(256),
        interpolation: bytes.of(&[
            Interpolation::Barycentric,
            Interpolation::Natural,
            Interpolation::Idw,
            Interpolation::Nearest,
        ]),
        texels: bytes.of(&[Texels::Fitted, Texels::Interpolated]),
        texel: bytes.of(&TexelFormat::ALL),
        carriers: bytes.of(&[Carriers::ObjAndGlb, Carriers::Obj]),
        occlusion: bytes.of(&[
            None,
            Some(Occlusion { rays: 3, distance: None }),
            Some(Occlusion { rays: 2, distance: Some(0.3) }),
        ]),
        curvature: bytes.of(&[CurvatureMap::None, CurvatureMap::Mean]),
        ..BakeSettings::default()
    }
}
