//! Targets of fuzzing: whatever bytes a target gets, it must neither panic nor take long. The program `fuzz` and a
//! test of this package call them.

mod corpus;
mod files;
mod mutate;
mod small_mesh;

pub use corpus::{corpus, pieces};
pub use mutate::Mutator;

use glam::{DVec3, Vec2};
use planish_geometry::bake::gltf::Picture;
use planish_geometry::bake::{
    self, BakeSettings, BakeTarget, Bundle, BundleNames, LargestSide, SideFiles, WrittenFiles,
};
use planish_geometry::denoise::limits::Mask;
use planish_geometry::denoise::{Denoiser, Laplacian};
use planish_geometry::map::Size;
use planish_geometry::map::displace;
use planish_geometry::map::displacement::{Displacement, Encoding, MapKind, TexelFormat};
use planish_geometry::map::manifest::{self, Manifest, Method};
use planish_geometry::map::pages::PageRule;
use planish_geometry::mesh::weld::Welding;
use planish_geometry::progress::Silent;
use planish_geometry::source::format::Format;
use planish_geometry::source::mesh_file::MeshFile;
use planish_geometry::source::model::Model;
use planish_geometry::source::obj::Obj;
use planish_geometry::source::{Source, flaws, materials};

/// A target: its name, its function, and the memory that it may use, as a number of bytes and a multiple of the input.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// Name on the command line of the program `fuzz`.
    pub name: &'static str,
    /// Reads bytes.
    pub run: fn(&[u8]),
    /// Bytes of memory that any input may take.
    pub base: usize,
    /// Further bytes of memory for each byte of the input.
    pub factor: usize,
}

/// All targets.
pub const TARGETS: [Target; 14] = [
    Target { name: "obj", run: obj, base: 1 << 20, factor: 400 },
    // JSON takes more memory than text of numbers.
    Target { name: "mesh", run: mesh, base: 64 << 20, factor: 2000 },
    Target { name: "gltf-bake", run: gltf_bake, base: 256 << 20, factor: 2000 },
    Target { name: "mtl", run: mtl, base: 1 << 20, factor: 400 },
    Target { name: "manifest", run: manifest, base: 1 << 20, factor: 400 },
    Target { name: "png", run: png, base: 160 << 20, factor: 100 },
    Target { name: "exr", run: exr, base: 160 << 20, factor: 100 },
    // The decoder reads the directory by limits of its own, 256 MiB, before it can be told others.
    Target { name: "tiff", run: tiff, base: 320 << 20, factor: 100 },
    Target { name: "mask", run: mask, base: 1 << 20, factor: 100 },
    Target { name: "weights", run: files::weights, base: 1 << 20, factor: 100 },
    // A byte of gzip can stand for a thousand values of one byte each, which become four.
    Target { name: "nrrd", run: files::nrrd, base: 16 << 20, factor: 6000 },
    Target { name: "settings", run: settings, base: 1 << 20, factor: 400 },
    Target { name: "bake", run: bake, base: 256 << 20, factor: 0 },
    Target { name: "bundle", run: bundle, base: 256 << 20, factor: 400 },
];

/// Coordinates beyond which the programs refuse a mesh before any method sees it.
const LARGEST: f64 = 1e50;

/// Reads an OBJ, and writes it in every way: parse, write, parse.
pub fn obj(data: &[u8]) {
    let Ok(obj) = Obj::parse(data.to_vec()) else { return };
    let same = obj.with_positions(obj.data().positions(), Some(obj.data().normals()));
    assert!(same == data, "numbers that do not change keep their spelling");
    let moved: Vec<DVec3> = obj.data().positions().iter().map(|p| *p * 0.5).collect();
    let again = Obj::parse(obj.with_positions(&moved, None)).expect("a written mesh can be read");
    let key = |p: &DVec3| (*p + 0.0).to_array().map(f64::to_bits);
    assert!(again.data().positions().iter().map(key).eq(moved.iter().map(key)), "numbers come back");
    assert_eq!(again.data().faces().items(), obj.data().faces().items());
    let normals = vec![glam::Vec3::Z; moved.len()];
    let texels = vec![Vec2::ZERO; moved.len()];
    for uvs in [None, Some(texels.as_slice())] {
        let carrier = Obj::parse(obj.carrier(&moved, &normals, uvs, "m.mtl")).expect("a carrier can be read");
        assert_eq!(carrier.data().positions().len(), moved.len());
        assert_eq!(carrier.extras().material_libraries, [b"m.mtl"]);
    }
    assert!(obj.vertex_line(moved.len() as u32).is_none());
    let model = Model::new(obj, Welding::Exact);
    let _ = (model.defects(), model.atlas());
    for flaw in flaws::flaws(&model) {
        assert!(!flaw.to_string().contains("NaN"), "{flaw}");
    }
}

/// Reads a mesh in any format, and writes it in every format: parse, write, parse.
pub fn mesh(data: &[u8]) {
    let Ok(mesh) = Source::parse(data.to_vec(), None) else { return };
    let positions = mesh.data().positions();
    let same = mesh.written_as(mesh.format(), positions, None);
    assert!(same.bytes == data, "numbers that do not change keep their bytes");
    if positions.iter().any(|p| p.abs().max_element() > LARGEST) {
        return;
    }
    let moved: Vec<DVec3> = positions.iter().map(|p| *p * 0.5).collect();
    for format in [Format::Obj, Format::Ply, Format::Stl, Format::Off, Format::Glb, Format::Gltf] {
        let written = mesh.written_as(format, &moved, None);
        // The programs refuse what single precision cannot hold.
        if written.rounding.is_finite() {
            Source::parse(written.bytes, Some(format)).expect("a written mesh can be read");
        }
    }
    if let Some(file) = mesh.file() {
        let library = file.embedded_library();
        materials::textures(&library).iter().for_each(|name| drop(file.embedded_texture(name)));
        let _ = (file.contents(), file.notes(), file.material_libraries());
    }
    let model = Model::new(mesh, Welding::Exact);
    let _ = (model.defects(), model.atlas(), flaws::flaws(&model));
}

/// Bakes a glTF file, whose document the carrier keeps.
pub fn gltf_bake(data: &[u8]) {
    let Ok(mesh) = Source::parse(data.to_vec(), Some(Format::Gltf)) else { return };
    if mesh.data().positions().iter().any(|p| p.abs().max_element() > LARGEST) {
        return;
    }
    let model = Model::new(mesh, Welding::Exact);
    if model.surface().topology().faces().is_empty() {
        return;
    }
    let target = Denoiser::Laplacian(Laplacian { iterations: 1, ..Laplacian::default() }).into();
    let vertex = BakeSettings { target, layout: bake::LayoutChoice::Vertex, ..BakeSettings::default() };
    let pages = BakeSettings {
        layout: bake::LayoutChoice::Auto,
        pages: PageRule::Material,
        largest_side: LargestSide(64),
        ..vertex.clone()
    };
    let library = model.source().file().map(MeshFile::embedded_library).unwrap_or_default();
    let texture = |picture: Picture| match picture {
        Picture::File(name) => model.source().file()?.embedded_texture(name),
        _ => None,
    };
    let side_files = SideFiles { libraries: &[library], texture: &texture, ..SideFiles::NONE };
    for settings in [vertex, pages] {
        let Ok(bundle) = bake::bake(&model, &names(), side_files, &settings, &Silent) else { continue };
        let glb = bundle.manifest.carrier.glb.as_deref().map(|name| bytes_of(&bundle, name).to_vec());
        let glb = glb.map(|bytes| Source::parse(bytes, Some(Format::Glb)).expect("a carrier can be read"));
        assert!(glb.is_none_or(|mesh| mesh.format() == Format::Glb));
    }
}

/// Reads a material library, and writes that of a carrier.
pub fn mtl(data: &[u8]) {
    let known = materials::read(data);
    let textures = materials::textures(data);
    let mesh =
        Obj::parse(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\nusemtl b\nf 3 2 1\n".to_vec()).expect("a mesh");
    if !materials::is_library(data) {
        return;
    }
    let maps = materials::MapStatements { normal: Some("n.png"), ..Default::default() };
    let written =
        materials::carrier_library(mesh.data(), &[data.to_vec()], |_| maps.clone(), |name| format!("../{name}"));
    assert!(materials::is_library(&written));
    assert!(materials::textures(&written).len() <= textures.len() + written.split(|b| *b == b'\n').count());
    if known.is_ok() {
        let _ = materials::read(&written);
    }
}

/// Reads a manifest, and writes it again.
pub fn manifest(data: &[u8]) {
    let _ = manifest::named_files(data);
    let Ok(read) = Manifest::from_json(data) else { return };
    let again = Manifest::from_json(read.to_json().as_bytes()).expect("a written manifest can be read");
    assert_eq!(again, read);
}

/// Reads an image file in each format of a map that has this file format, in two sizes.
fn image(data: &[u8], texels: &[TexelFormat]) {
    for &texel in texels {
        for (kind, side) in [(MapKind::Scalar, 8), (MapKind::VectorObject, 16), (MapKind::Scalar, 1024)] {
            let encoding = Encoding { texel, bias: -1.0, scale: 2.0 };
            let Ok(map) = Displacement::decode(data, kind, Size::square(side), encoding) else { continue };
            assert!(map.planes().iter().flatten().all(|texel| texel.is_finite()));
            assert!(map.planes().iter().all(|plane| plane.len() == Size::square(side).texels()));
        }
    }
}

/// Reads a PNG as a displacement map.
pub fn png(data: &[u8]) {
    image(data, &[TexelFormat::Png8, TexelFormat::Png16]);
}

/// Reads an EXR as a displacement map.
pub fn exr(data: &[u8]) {
    image(data, &[TexelFormat::Exr16, TexelFormat::Exr32]);
}

/// Reads a TIFF as a displacement map.
pub fn tiff(data: &[u8]) {
    image(data, &[TexelFormat::Tiff16, TexelFormat::Tiff32]);
}

/// Reads a list of vertices that stay.
pub fn mask(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let Ok(mask) = Mask::parse(text, 100) else { return };
    assert_eq!(mask.to_string().parse::<Mask>().as_ref(), Ok(&mask), "a written list can be read");
}

/// Reads the settings of a bake and of a method.
pub fn settings(data: &[u8]) {
    if let Ok(settings) = serde_json::from_slice::<BakeSettings>(data) {
        let json = serde_json::to_string(&settings).expect("settings can be written");
        assert_eq!(serde_json::from_str::<BakeSettings>(&json).ok(), Some(settings));
    }
    let _ = serde_json::from_slice::<Method>(data);
}

const NAMES: [&str; 3] = ["in.obj", "in", "carrier"];

fn names() -> BundleNames {
    let [source, stem, carrier] = NAMES.map(str::to_owned);
    BundleNames { source, stem, carrier }
}

fn bytes_of<'a>(bundle: &'a Bundle, name: &str) -> &'a [u8] {
    let found = bundle.files.iter().find(|file| file.name == name);
    &found.unwrap_or_else(|| panic!("the bundle has no {name}")).bytes
}

/// Bakes a small mesh that the bytes describe, with any texture coordinates and settings; then the files are read back, checked
/// and applied.
pub fn bake(data: &[u8]) {
    let (text, settings) = small_mesh::read(data);
    let Ok(obj) = Obj::parse(text.into_bytes()) else { return };
    let model = Model::new(obj, settings.welding);
    if model.surface().topology().faces().is_empty() {
        return;
    }
    let Ok(bundle) = bake::bake(&model, &names(), SideFiles::NONE, &settings, &Silent) else { return };
    let json = &bundle.files.last().expect("a manifest").bytes;
    let manifest = Manifest::from_json(json).expect("what is written can be read");
    assert_eq!(manifest, bundle.manifest);
    let carrier = Obj::parse(bytes_of(&bundle, &manifest.carrier.obj).to_vec()).expect("a carrier can be read");
    let image = bytes_of(&bundle, &manifest.displacement.file);
    let written = WrittenFiles { displacement: &[image], carrier: carrier.data() };
    let report = bake::check(&model, &manifest, &settings.target, written, &Silent).expect("a bake can be checked");
    assert!(report.max_error <= manifest.report.error_bound, "{report:?}");
    assert_eq!(report.seam_gap, manifest.report.seam_gap);
    let entry = &manifest.displacement;
    let map = Displacement::decode(image, entry.map, entry.size(), entry.encoding()).expect("a map can be read");
    let vertices = displace::baked_vertices(&carrier.into(), &manifest, &|| None).expect("a carrier can be displaced");
    let displaced = displace::displaced(&vertices, &map, 1.0, entry.origin);
    let mut used = vec![false; displaced.len()];
    model.data().faces().items().iter().for_each(|corner| used[corner.position as usize] = true);
    for (p, _) in displaced.iter().zip(&used).filter(|(_, used)| **used) {
        assert!(p.is_finite(), "{p}");
    }
}

/// Replaces one file of a bundle by the bytes, with checksums that fit; then the bundle is checked and applied. The first byte
/// chooses the file.
pub fn bundle(data: &[u8]) {
    let Some((&choice, data)) = data.split_first() else { return };
    let sample = corpus::sample(usize::from(choice / 4));
    let (mut source, mut carrier, mut image) = (sample.source.as_slice(), sample.carrier(), sample.image());
    let mut json = sample.manifest().to_vec();
    match choice % 4 {
        0 => json = data.to_vec(),
        1 => image = data,
        2 => carrier = data,
        _ => source = data,
    }
    let Ok(mut manifest) = Manifest::from_json(&json) else { return };
    let (Ok(source), Ok(carrier)) = (Obj::parse(source.to_vec()), Obj::parse(carrier.to_vec())) else { return };
    let is_small = |obj: &Obj| obj.data().positions().iter().all(|p| p.abs().max_element() <= LARGEST);
    // A map of this size takes memory that the manifest may ask for, and nothing is learnt from it here.
    let map = manifest.displacement.size();
    if !is_small(&source) || !is_small(&carrier) || map.texels() > 1 << 20 || source.data().positions().len() > 5000 {
        return;
    }
    manifest.source.sha256 = manifest::sha256(source.bytes());
    manifest.carrier.sha256 = manifest::sha256(carrier.bytes());
    let (source, carrier): (Source, Source) = (source.into(), carrier.into());
    let entry = &manifest.displacement;
    if let Ok(map) = Displacement::decode(image, entry.map, entry.size(), entry.encoding()) {
        for mesh in [&source, &carrier] {
            let other = || carrier.as_obj().cloned();
            if let Ok(vertices) = displace::baked_vertices(mesh, &manifest, &other) {
                let _ = displace::displaced(&vertices, &map, entry.lambda as f32, entry.origin);
            }
        }
    }
    // A method that the manifest may choose can take minutes by its settings, which is documented; the quick one is enough here.
    let target = BakeTarget::from(Denoiser::Laplacian(Laplacian { iterations: 2, ..Laplacian::default() }));
    let model = Model::new(source, manifest.welding);
    if model.surface().topology().faces().is_empty() {
        return;
    }
    let written = WrittenFiles { displacement: &[image], carrier: carrier.data() };
    let _ = bake::check(&model, &manifest, &target, written, &Silent);
}
