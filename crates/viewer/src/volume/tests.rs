//! Laws of volumes that are read, computed and put around a mesh.

use super::*;
use glam::{DMat3, DQuat};
use planish_files::compression;
use planish_geometry::mesh::weld::Welding;
use planish_geometry::progress::Silent;
use planish_geometry::source::obj::Obj;
use planish_render::settings::volume::SampleType;
use std::fs;
use std::path::PathBuf;

const SIZE: [u32; 3] = [3, 2, 4];

fn values() -> Vec<i16> {
    (0..24).map(|i| 37 * i - 300).collect()
}

/// A folder in which each test writes its files.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn file(&self, name: &str, content: &[&[u8]]) -> PathBuf {
        let path = self.0.path().join(name);
        fs::write(&path, content.concat()).unwrap();
        path
    }
}

fn read(path: &Path) -> Result<VolumeFile, Failure> {
    nrrd::read(path, Trust::Folder)
}

/// A box of 2 × 1 × 1, far from the origin, so that the scene has its own.
fn model() -> Model {
    let mut text = String::new();
    for i in 0..8 {
        text += &format!("v {} {} {}\n", 1000 + 2 * (i & 1), 1000 + (i >> 1 & 1), 1000 + (i >> 2));
    }
    text += "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
    Model::new(Obj::parse(text.into_bytes()).unwrap(), Welding::Exact)
}

#[test]
fn every_type_byte_order_and_encoding_gives_its_values_back() {
    let folder = Folder::new();
    let little: Vec<u8> = values().iter().flat_map(|v| v.to_le_bytes()).collect();
    let big: Vec<u8> = values().iter().flat_map(|v| v.to_be_bytes()).collect();
    let doubles: Vec<u8> = values().iter().flat_map(|v| f64::from(*v).to_be_bytes()).collect();
    let expected: Vec<f32> = values().iter().map(|v| f32::from(*v)).collect();
    let packed = compression::compressed(&little);
    for (i, (fields, body)) in [
        ("type: short\nencoding: raw\nendian: little", &little),
        ("type: int16_t\nendian: big\nencoding: raw", &big),
        ("type: double\nendian: big\nencoding: raw", &doubles),
        ("type: signed short int\nendian: little\nencoding: gzip", &packed),
        ("type: short\nendian: little\nencoding: raw\nbyte skip: -1", &[b"before the values", &little[..]].concat()),
        (
            "type: short\nendian: little\nencoding: raw\nline skip: 1\nbyteskip: 2",
            &[b"a line\nab", &little[..]].concat(),
        ),
    ]
    .into_iter()
    .enumerate()
    {
        for line in ["\n", "\r\n"] {
            let header = format!("NRRD0004\n# a comment\ndimension: 3\nsizes: 3 2 4\nown key:=a: b\n{fields}\n\n");
            let path = folder.file(&format!("{i}.nrrd"), &[header.replace('\n', line).as_bytes(), body]);
            let file = read(&path).unwrap_or_else(|e| panic!("{fields}: {e}"));
            assert_eq!((file.size, &file.values), (SIZE, &expected), "{fields}");
            assert_eq!((file.spacing, file.model_from_index), (DVec3::ONE, None));
        }
    }
}

#[test]
fn values_may_lie_in_another_file_of_the_same_folder() {
    let folder = Folder::new();
    let header = |name: &str| {
        format!(
            "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 3 2 4\nspacings: 1 nan 2\nencoding: raw\ndata file: {name}\n"
        )
    };
    folder.file("a.raw", &[&[7; 24]]);
    let file = read(&folder.file("a.nhdr", &[header("a.raw").as_bytes()])).unwrap();
    assert_eq!((file.values, file.spacing), (vec![7.0; 24], DVec3::new(1.0, 1.0, 2.0)));
    let outside = folder.file("b.nhdr", &[header("../a.raw").as_bytes()]);
    assert!(read(&outside).is_err());
    let said = read(&folder.file("c.nhdr", &[header("slice%03d.raw 1 4 1").as_bytes()])).unwrap_err().to_string();
    assert!(said.contains("several files"), "{said}");
}

#[test]
fn a_file_lies_where_it_says_and_else_around_the_mesh() {
    let folder = Folder::new();
    let turn = DMat3::from_quat(DQuat::from_rotation_z(0.4)) * DMat3::from_diagonal(DVec3::new(0.5, 0.25, 2.0));
    let vector = |v: DVec3| format!("({},{},{})", v.x, v.y, v.z);
    let directions = [turn.x_axis, turn.y_axis, turn.z_axis].map(vector).join(" ");
    let header = format!(
        "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 3 2 4\nencoding: raw\nspace: right-anterior-superior\n\
         space directions: {directions}\nspace origin: (1000.5,1000.25,999.0)\n\n"
    );
    let bytes: Vec<u8> = (0..24).collect();
    let path = folder.file("a.nrrd", &[header.as_bytes(), &bytes]);
    let model = model();
    let at =
        |placement| load(&VolumeSource::File(path.clone()), placement, Some(&model), Trust::Folder, &Silent).unwrap();
    let volume = at(Placement::File);
    for (i, value) in (0..24).zip(&bytes) {
        let index = DVec3::new(f64::from(i % 3), f64::from(i / 3 % 2), f64::from(i / 6));
        let place = DVec3::new(1000.5, 1000.25, 999.0) + turn * index - origin(&model);
        assert!((volume.at(place.as_vec3()) - f32::from(*value)).abs() < 1e-3, "{index}");
    }
    // The spacings are 0.5, 0.25 and 2: of boxes of 1.5 × 0.5 × 8, the one of 3 × 1 × 16 contains the mesh.
    let bounds = at(Placement::Fit).bounds();
    let expected = 0.5 * Vec3::new(3.0, 1.0, 16.0).length();
    assert!((bounds.radius - expected).abs() < 1e-4 && bounds.centre.length() < 1e-4, "{bounds:?}");
}

#[test]
fn bare_numbers_are_little_endian_and_as_many_as_said() {
    let folder = Folder::new();
    let bytes: Vec<u8> = values().iter().flat_map(|v| v.to_le_bytes()).collect();
    let file = folder.file("a.raw", &[&bytes]);
    let raw = RawVolume { file, size: SIZE, sample: SampleType::I16, spacing: [1.0; 3] };
    let with = |raw: RawVolume| load(&VolumeSource::Raw(raw), Placement::File, None, Trust::Folder, &Silent);
    let volume = with(raw.clone()).unwrap();
    assert_eq!(volume.values(), values().iter().map(|v| f32::from(*v)).collect::<Vec<_>>());
    let said = |raw| with(raw).unwrap_err().to_string();
    let long = said(RawVolume { sample: SampleType::F32, ..raw.clone() });
    assert!(long.ends_with("a.raw: has 48 bytes of values, but 3 × 2 × 4 of type f32 take 96"), "{long}");
    let nan = folder.file("nan.raw", &[&[f32::NAN.to_le_bytes(), 1f32.to_le_bytes()].concat()]);
    let nan = said(RawVolume { file: nan, size: [1, 2, 1], sample: SampleType::F32, spacing: [1.0; 3] });
    assert!(nan.ends_with("nan.raw: value 0 (counted from 0) is not finite in single precision"), "{nan}");
    assert!(said(RawVolume { file: "none.raw".into(), ..raw }).starts_with("none.raw: "));
}

#[test]
fn bad_headers_are_refused_in_words() {
    let folder = Folder::new();
    let good = "NRRD0004\ntype: short\ndimension: 3\nsizes: 3 2 4\nencoding: raw\nendian: little\n\n";
    let body = [0; 48];
    let packed = compression::compressed(&[0; 60]);
    for (from, to, body, word) in [
        ("NRRD0004", "nothing", &body[..], "--volume-size"),
        ("dimension: 3", "dimension: 4", &body, "4 axes"),
        ("sizes: 3 2 4", "sizes: 3 2", &body, "`sizes: 3 2`"),
        ("sizes: 3 2 4", "sizes: 3 -2 4", &body, "`sizes: 3 -2 4`"),
        ("sizes: 3 2 4", "sizes: 3 2 0", &body, "2^28"),
        ("sizes: 3 2 4", "sizes: 4000000000 4000000000 4000000000", &body, "2^28"),
        ("sizes: 3 2 4", "no field", &body, "line 4: is no field"),
        ("type: short", "type: block", &body, "`block`"),
        // A word of a stranger is printed on one line.
        ("type: short", "type: sh\u{1b}[2Jort", &body, "`sh\\u{1b}[2Jort`"),
        ("type: short\n", "", &body, "`type`"),
        ("encoding: raw", "encoding: bzip2", &body, "`bzip2`"),
        ("endian: little\n", "", &body, "endian"),
        ("endian: little", "endian: little\nbyte skip: 100", &body, "byte 100"),
        ("endian: little", "endian: little\nbyte skip: -2", &body, "negative"),
        ("endian: little", "endian: little\nline skip: 3", &body, "fewer lines"),
        ("endian: little", "endian: little\nspacings: 1 0 1", &body, "spacings"),
        ("endian: little", "endian: little\nspace directions: (1,0,0) (2,0,0) (0,0,1)", &body, "plane"),
        ("endian: little", "endian: little\nspace directions: none (2,0,0) (0,0,1)", &body, "vectors"),
        ("encoding: raw", "encoding: raw", &body[..47], "has 47 bytes of values"),
        ("encoding: raw", "encoding: gzip", &body, "damaged"),
        ("encoding: raw", "encoding: gzip", &packed, "more than the 48 bytes"),
        ("encoding: raw", "encoding: gzip\nbyte skip: 1000000000000", &packed, "skips 1000000000000 bytes"),
    ] {
        let path = folder.file("a.nrrd", &[good.replace(from, to).as_bytes(), body]);
        let said = read(&path).unwrap_err().to_string();
        assert!(said.contains("a.nrrd: ") && said.contains(word), "{to}: {said}");
        assert!(!said.contains(char::is_control), "{said:?}");
    }
}

#[test]
fn the_distance_to_a_box_is_that_of_its_formula_and_zero_is_in_the_middle() {
    let model = model();
    let distance = |size| load(&VolumeSource::Distance { size }, Placement::File, Some(&model), Trust::Folder, &Silent);
    let volume = distance(24).unwrap();
    assert_eq!(volume.size(), [24, 14, 14]);
    assert_eq!(volume.range().low, -volume.range().high);
    for p in [Vec3::ZERO, Vec3::new(0.3, 0.1, -0.2), Vec3::new(1.1, 0.0, 0.0)] {
        let q = p.abs() - Vec3::new(1.0, 0.5, 0.5);
        let expected = q.max(Vec3::ZERO).length() + q.max_element().min(0.0);
        // Between values 0.1 apart, creases are rounded by half of that.
        assert!((volume.at(p) - expected).abs() < 0.0501, "{p}: {} {expected}", volume.at(p));
    }
    let alone = load(&VolumeSource::Distance { size: 8 }, Placement::File, None, Trust::Folder, &Silent).unwrap_err();
    assert!(alone.to_string().contains("needs a mesh"));
}
