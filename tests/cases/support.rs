//! Meshes, and what must be true of a bundle made from one.

use glam::{DVec2, DVec3, Vec3};
use planish_geometry::bake::{self, BakeSettings, BakeTarget, Bundle, BundleNames, SideFiles};
use planish_geometry::denoise::{HeightField, NormalField};
use planish_geometry::map::displace::{self, SamplingRule, ShaderVertex};
use planish_geometry::map::displacement::{Displacement, SampleAt, Weights};
use planish_geometry::map::manifest::{Layout, Manifest};
use planish_geometry::mesh::normals;
use planish_geometry::mesh::weld::Welding;
use planish_geometry::progress::Silent;
use planish_geometry::source::model::Model;
use planish_geometry::source::obj::Obj;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// A corner as (position, uv), counted from 0.
pub(crate) type Corner = (usize, Option<usize>);

/// A plain OBJ file; numbers are written in full.
pub(crate) fn obj_text(positions: &[DVec3], uvs: &[DVec2], faces: &[Vec<Corner>]) -> String {
    let mut text = String::new();
    for p in positions {
        writeln!(text, "v {:?} {:?} {:?}", p.x, p.y, p.z).unwrap();
    }
    for uv in uvs {
        writeln!(text, "vt {:?} {:?}", uv.x, uv.y).unwrap();
    }
    for face in faces {
        text.push('f');
        for (position, uv) in face {
            write!(text, " {}", position + 1).unwrap();
            if let Some(uv) = uv {
                write!(text, "/{}", uv + 1).unwrap();
            }
        }
        text.push('\n');
    }
    text
}

pub(crate) fn model(bytes: impl Into<Vec<u8>>, welding: Welding) -> Model {
    Model::new(Obj::parse(bytes.into()).unwrap(), welding)
}

/// Files of a folder that end in `.obj`, by name; none where there is no such folder.
pub(crate) fn meshes_in(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = folder.read_dir() else { return Vec::new() };
    let paths = entries.map(|entry| entry.unwrap().path());
    let mut paths: Vec<_> = paths.filter(|path| path.extension().is_some_and(|e| e == "obj")).collect();
    paths.sort();
    paths
}

/// The root of the repository.
pub(crate) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The folder of meshes that are not part of the repository, from the environment variable `PLANISH_MESHES`. Tests that
/// need it are ignored, and `tests/run` runs them where the variable is set.
pub(crate) fn meshes_from_outside() -> PathBuf {
    let folder = std::env::var_os("PLANISH_MESHES").map(PathBuf::from);
    let folder = folder.expect("PLANISH_MESHES names a folder of meshes");
    assert!(folder.is_dir(), "PLANISH_MESHES: there is no folder {}", folder.display());
    folder
}

pub(crate) fn bake(model: &Model, settings: &BakeSettings) -> Bundle {
    let names = BundleNames { source: "in.obj".to_owned(), stem: "out".to_owned(), carrier: "out.carrier".to_owned() };
    bake::bake(model, &names, SideFiles::NONE, settings, &Silent).unwrap()
}

/// A bundle read back from its own files.
pub(crate) struct Read {
    pub(crate) manifest: Manifest,
    pub(crate) map: Displacement,
    pub(crate) carrier: Obj,
}

impl Read {
    pub(crate) fn new(bundle: &Bundle) -> Self {
        let bytes = |name: &str| &bundle.files.iter().find(|file| file.name == name).unwrap().bytes;
        let manifest = Manifest::from_json(&bundle.files.last().unwrap().bytes).unwrap();
        let entry = &manifest.displacement;
        let map = Displacement::decode(bytes(&entry.file), entry.map, entry.size(), entry.encoding()).unwrap();
        let carrier = Obj::parse(bytes(&manifest.carrier.obj).clone()).unwrap();
        Self { manifest, map, carrier }
    }

    /// Where a shader puts each corner of each face at λ = 1: by the texel of its `v` line, or its private texel, or the place that the manifest
    /// names for it, or else its own texture coordinates. Relative to the manifest's origin.
    fn displaced_corners(&self) -> impl Iterator<Item = (usize, Vec3)> + '_ {
        let origin = self.manifest.displacement.origin;
        let mut dominant = vec![None; self.carrier.data().positions().len()];
        for [v, vt] in self.manifest.dominant_pairs() {
            dominant[v as usize] = Some(vt);
        }
        let mut private = vec![None; dominant.len()];
        for texel in &self.manifest.private_texels {
            private[texel.vertex as usize - 1] = Some(texel.row * self.manifest.displacement.width + texel.column);
        }
        self.carrier.data().faces().items().iter().map(move |corner| {
            let v = corner.position as usize;
            let vertex = ShaderVertex {
                position: (self.carrier.data().positions()[v] - origin).as_vec3(),
                normal: self.carrier.data().normals()[corner.normal().unwrap() as usize].as_vec3(),
                sample_at: match self.manifest.displacement.layout {
                    Layout::Uv => private[v].map(SampleAt::Texel).or_else(|| {
                        let vt = dominant[v].or(corner.uv())?;
                        Some(SampleAt::Uv(self.carrier.data().uvs()[vt as usize].as_vec2()))
                    }),
                    Layout::Vertex => Some(SampleAt::Texel(corner.position)),
                },
                ..ShaderVertex::default()
            };
            (v, vertex.displaced(&self.map, 1.0))
        })
    }
}

/// Heights of the vertices from first principles, and the normals they belong to. #V
pub(crate) fn heights(model: &Model, settings: &BakeSettings) -> (Vec<f64>, Vec<Vec3>) {
    let BakeTarget::Method(denoising) = &settings.target else { panic!("the tests bake no targets") };
    let deltas = denoising.run(model.surface(), model.weld(), denoising.output(), &Silent).unwrap().deltas;
    let source = settings.normals.unwrap_or_default();
    if source == NormalField::Tilted {
        // Normals that lean are fitted together with the heights.
        let HeightField { heights, normals, .. } = HeightField::tilted(model.surface(), &deltas, &Silent).unwrap();
        return (heights, normals);
    }
    let along = source.normals(model, &deltas).unwrap();
    (normals::heights(&deltas, &along), along)
}

/// What a bundle promises: no vertex is farther from p − h·n than the report says, and all wedges of a vertex land on
/// the same bits.
#[track_caller]
pub(crate) fn keeps_its_promises(model: &Model, settings: &BakeSettings, bundle: &Bundle) -> Read {
    let read = Read::new(bundle);
    assert_eq!(read.manifest, bundle.manifest);
    let (heights, normals) = heights(model, settings);
    let expected = |vertex: usize| model.surface().positions()[vertex] - heights[vertex] * normals[vertex].as_dvec3();
    let bound = read.manifest.report.error_bound;
    let mut places: Vec<Option<[u32; 3]>> = vec![None; heights.len()];
    for (line, place) in read.displaced_corners() {
        let vertex = model.weld().vertex_of()[line] as usize;
        let bits = place.to_array().map(f32::to_bits);
        assert_eq!(*places[vertex].get_or_insert(bits), bits, "wedges of vertex {vertex} come apart");
        let off = (place.as_dvec3() + read.manifest.displacement.origin).distance(expected(vertex));
        assert!(off <= bound, "`v` line {line} is off by {off:e}, but the bound is {bound:e}");
    }
    assert_eq!(read.manifest.report.seam_gap, 0.0);
    read
}

/// Height that the map gives a vertex where a shader samples it.
pub(crate) fn sampled(read: &Read) -> impl Iterator<Item = f32> + '_ {
    let rule = SamplingRule::of(&read.manifest);
    let vertices = displace::carrier_vertices(read.carrier.data(), &rule, DVec3::ZERO);
    vertices.into_iter().filter_map(|v| v.sample_at).map(|sample_at| read.map.height_at(sample_at, Weights::Exact))
}
