//! Inputs from which fuzzing starts, all of them made here.

use super::{bytes_of, names};
use glam::DVec3;
use planish_geometry::bake::{self, BakeSettings, Bundle, SideFiles};
use planish_geometry::denoise::{Denoiser, Laplacian, NormalField};
use planish_geometry::map::displacement::{Displacement, Encoding, MapKind, TexelFormat};
use planish_geometry::map::{HeightMap, Size};
use planish_geometry::mesh::shapes;
use planish_geometry::mesh::weld::Welding;
use planish_geometry::progress::Silent;
use planish_geometry::source::Source;
use planish_geometry::source::format::Format;
use planish_geometry::source::model::Model;
use planish_geometry::source::obj::Obj;
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::sync::OnceLock;

/// A mesh and its bundle.
pub(super) struct Sample {
    pub(super) source: Vec<u8>,
    bundle: Bundle,
}

impl Sample {
    fn new(source: Vec<u8>, settings: &BakeSettings) -> Self {
        let model = Model::new(Obj::parse(source.clone()).expect("a mesh"), Welding::Exact);
        let bundle = bake::bake(&model, &names(), SideFiles::NONE, settings, &Silent).expect("a bake");
        Self { source, bundle }
    }
    pub(super) fn carrier(&self) -> &[u8] {
        bytes_of(&self.bundle, &self.bundle.manifest.carrier.obj)
    }
    pub(super) fn image(&self) -> &[u8] {
        bytes_of(&self.bundle, &self.bundle.manifest.displacement.file)
    }
    pub(super) fn manifest(&self) -> &[u8] {
        bytes_of(&self.bundle, "in.planish.json")
    }
}

/// A sphere in a few faces with a seam, as an OBJ with much that an OBJ can have.
fn sphere() -> Vec<u8> {
    let sphere = shapes::sphere(1);
    let mut text = String::from("# made by the tests\nmtllib a.mtl\no ball\n");
    for p in sphere.positions() {
        let _ = writeln!(text, "v {} {:e} {}", p.x, p.y, p.z + 0.05 * (p.x * 9.0).sin());
    }
    let corners: Vec<DVec3> =
        (0..sphere.topology().faces().items().len() as u32).map(|c| sphere.at_corner(c)).collect();
    for (k, p) in corners.iter().enumerate() {
        let shift = if k % 3 == 0 { 0.01 } else { 0.0 };
        let _ = writeln!(text, "vt {} {}", 0.5 + 0.4 * p.x + shift, 0.5 + 0.4 * p.y);
    }
    text.push_str("vn 0 0 1\ng a b\ns 1\nusemtl skin\n");
    let mut corner = 0;
    for face in sphere.topology().faces().iter() {
        text.push('f');
        for v in face {
            corner += 1;
            let _ = write!(text, " {}/{corner}/1", v + 1);
        }
        text.push('\n');
    }
    text.push_str("l 1 2\np 3\nusemtl other\nf -1 -2 \\\n-3\n");
    text.into_bytes()
}

/// The bundle with a number; numbers go round.
pub(super) fn sample(number: usize) -> &'static Sample {
    static SAMPLES: OnceLock<Vec<Sample>> = OnceLock::new();
    let samples = SAMPLES.get_or_init(|| {
        let laplacian = Laplacian { iterations: 2, ..Laplacian::default() };
        let plain =
            BakeSettings { target: Denoiser::Laplacian(laplacian).into(), side: Some(16), ..BakeSettings::default() };
        let settings = [
            plain.clone(),
            BakeSettings { map: MapKind::VectorTangent, texel: TexelFormat::Tiff32, ..plain.clone() },
            BakeSettings { normals: Some(NormalField::Denoised), layout: bake::LayoutChoice::Vertex, ..plain.clone() },
            BakeSettings {
                map: MapKind::VectorObject,
                texel: TexelFormat::Exr16,
                layout: bake::LayoutChoice::Uv,
                ..plain
            },
        ];
        settings.iter().map(|settings| Sample::new(sphere(), settings)).collect()
    });
    &samples[number % samples.len()]
}

fn image(texel: TexelFormat) -> Vec<u8> {
    let size = Size::square(8);
    let texels = (0..64u8).map(|i| f32::from(i) / 63.0).collect();
    let map = HeightMap { size, texels };
    let encoding = Encoding { texel, bias: -1.0, scale: 2.0 };
    Displacement::encode(&[map], MapKind::Scalar, encoding).to_bytes().expect("an image")
}

/// Meshes in the other formats; with `is_gltf` in glTF alone.
fn meshes(is_gltf: bool) -> Vec<Vec<u8>> {
    let tetrahedron = "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nv 0 0 1 1 1 1\nvt 0 0\nvt 1 0\nvt 0 1\nvn 0 0 1\nusemtl a\nf 1/1/1 3/2/1 2/3/1\nusemtl b\nf 1/1/1 2/2/1 4/3/1\nf 2/1/1 3/2/1 4/3/1\nf 3/1/1 1/2/1 4/3/1\n";
    let mesh: Source = Obj::parse(tetrahedron.into()).expect("a mesh").into();
    let written = |format| mesh.written_as(format, mesh.data().positions(), None).bytes;
    let mut all = vec![written(Format::Gltf), written(Format::Glb)];
    let mut document: Value = serde_json::from_slice(&all[0]).expect("a document");
    document["nodes"] = json!([
        { "mesh": 0, "scale": [1, 2, 1], "children": [1] }, { "mesh": 0, "translation": [1, 0, 0], "weights": [0.5] }
    ]);
    document["images"] =
        json!([{ "bufferView": 0, "mimeType": "image/png" }, { "uri": "data:image/png;base64,iVBORw0KGgo=" }]);
    document["textures"] = json!([{ "source": 0 }, { "source": 1 }]);
    document["materials"] = json!([
        { "name": "a", "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 }, "baseColorFactor": [1, 0, 0, 1] } },
        { "name": "a", "pbrMetallicRoughness": { "baseColorTexture": { "index": 1, "texCoord": 1 } }, "extras": 5 },
    ]);
    if let Some(mesh) = document["meshes"].as_array().and_then(|meshes| meshes.first()).cloned() {
        let points = json!({ "mode": 0, "attributes": mesh["primitives"][0]["attributes"] });
        document["meshes"] = json!([mesh, { "primitives": [points, mesh["primitives"][0]], "weights": [1] }]);
    }
    all.push(document.to_string().into_bytes());
    if !is_gltf {
        all.extend([written(Format::Ply), written(Format::Stl), written(Format::Off)]);
        let texts = [
            "ply\nformat ascii 1.0\ncomment TextureFile a.png\nelement vertex 4\nproperty float x\nproperty double y\nproperty int z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nelement face 2\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord\nproperty int texnumber\nelement other 1\nproperty list uchar short w\nend_header\n0 0 0 1 2 3\n1 0 0 1 2 3\n0 1 0 1 2 3\n0 0 1 1 2 3\n3 0 1 2 6 0 0 1 0 0 1 0\n3 0 2 3 6 0 0 1 0 0 1 0\n2 1 2\n",
            "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n",
            "STCNOFF # c\n4 2 0\n0 0 0 0 0 1 1 0 0 1 0 0\n1 0 0 0 0 1 1 0 0 1 0 0\n0 1 0 0 0 1 1 0 0 1 0 0\n0 0 1 0 0 1 1 0 0 1 0 0\n3 0 1 2 1 0 0\n3 0 2 3\n",
        ];
        all.extend(texts.map(|text| text.as_bytes().to_vec()));
    }
    all
}

/// Volumes in NRRD files with and without compression, in several types.
fn volumes() -> Vec<Vec<u8>> {
    let values: Vec<u8> = (0..96).collect();
    let packed = planish_files::compression::compressed(&values);
    let header = |fields: &str| format!("NRRD0005\n# made by the tests\ndimension: 3\nsizes: 3 4 2\n{fields}\n\n");
    [
        ("type: float\nencoding: raw\nendian: little\nspacings: 1 nan 2.5", &values),
        (
            "type: uint\nencoding: gzip\nendian: big\nspace directions: (1,0,0) (0,1,0) (0,0,2)\nspace origin: (1,2,3)",
            &packed,
        ),
        ("type: int32\nencoding: gz\nendian: little\nbyte skip: 0\nline skip: 0\nmy key:=any value", &packed),
        ("type: uchar\nencoding: raw\nbyteskip: -1\nlineskip: 1", &values),
        ("type: float\nencoding: raw\nendian: little\ndata file: values.raw", &Vec::new()),
    ]
    .iter()
    .map(|(fields, body)| [header(fields).as_bytes(), body].concat())
    .collect()
}

/// Inputs for a target, by its name.
pub fn corpus(target: &str) -> Vec<Vec<u8>> {
    let text = |texts: &[&str]| texts.iter().map(|text| text.as_bytes().to_vec()).collect::<Vec<_>>();
    match target {
        "obj" => {
            let mut all = text(&[
                "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
                "v 0 0 0 1 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nv 1 1 1\r\nvt 0\r\nvt 1 nan\r\nvn 0 0 -nan(ind)\r\nf 1/1/1 2//1 3/2 4\r\n",
                "\u{feff}mtllib a b.mtl\rv 1e300 0 0\rv 1e-310 .5 -0\rv 0 1 0\rusemtl x\rfo 3 2 1\rf 1 1 2\r",
                "curv 0 1\nv 0 0 \\\n0\nv 1 0 0 # c\nv 0 1 0\nf 1 2 3 1 2\nf -1 -2 -3",
            ]);
            all.push(sphere());
            all
        }
        "mesh" | "gltf-bake" => meshes(target == "gltf-bake"),
        "mtl" => text(&[
            "newmtl a\nKd 0.5\nKs spectral x.rfl\nmap_Kd -s 2 2 -clamp on my skin.png\nnewmtl b\nKd 1 0 0\nillum 2\n",
            "\u{feff}newmtl a\r\nmap_Bump -bm 0.3 b c.png\r\ndisp -mm 0 1 d.png\r\nTr 0.5\r\nPr 1\r\n# x\r\n",
        ]),
        "manifest" => (0..4).map(|number| sample(number).manifest().to_vec()).collect(),
        "png" => vec![image(TexelFormat::Png8), image(TexelFormat::Png16)],
        "exr" => vec![image(TexelFormat::Exr16), image(TexelFormat::Exr32)],
        "tiff" => vec![image(TexelFormat::Tiff16), image(TexelFormat::Tiff32)],
        "mask" => text(&["7 12-40 # nose\n99", "boundary", "1\t2\r\n3-3"]),
        "weights" => text(&["0 0.5 1 0.25", "1\n0\t1e-3\r\n.5 ", "0 0 0 nan"]),
        "nrrd" => volumes(),
        "settings" => {
            let settings =
                Denoiser::every().map(|denoiser| BakeSettings { target: denoiser.into(), ..BakeSettings::default() });
            let json = |settings: &BakeSettings| serde_json::to_vec(settings).expect("settings");
            let methods = Denoiser::every().map(|denoiser| serde_json::to_vec(&denoiser).expect("a method"));
            settings.iter().map(json).chain(methods).collect()
        }
        "bake" => {
            // A strip of squares, whose bytes say little, and two runs of bytes that say more.
            let run = |step: usize| (0..400usize).map(|i| (i * step % 251) as u8).collect::<Vec<u8>>();
            vec![run(7), run(89), run(143), vec![125; 200], vec![]]
        }
        "bundle" => {
            let parts = |number: usize| {
                let sample = sample(number);
                let parts = [sample.manifest(), sample.image(), sample.carrier(), sample.source.as_slice()];
                (0..4).map(move |part| [&[(4 * number + part) as u8], parts[part]].concat())
            };
            (0..4).flat_map(parts).collect()
        }
        _ => Vec::new(),
    }
}

/// Words that mean something in the inputs of a target, which mutations insert.
pub fn pieces() -> &'static [&'static str] {
    &[
        "nan",
        "-inf",
        "1e308",
        "1e-308",
        "1e39",
        "-1",
        "0",
        "4294967295",
        "18446744073709551616",
        "2147483648",
        "\n",
        "\r",
        "\\\n",
        "#",
        "/",
        "//",
        " ",
        "\t",
        "f 1 2 3",
        "v 0 0 0",
        "vt 0 0",
        "usemtl ",
        "mtllib ",
        "newmtl ",
        "map_Kd ",
        "null",
        "[]",
        "{}",
        "\"",
        "../",
        "/dev/zero",
        "true",
        "\u{feff}",
        "\u{0}",
        "\u{ff}",
        "é",
    ]
}
