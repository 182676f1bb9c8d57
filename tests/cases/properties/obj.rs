//! Reading and writing.

use super::cases;
use super::spelling::{Mesh, Spelled, position, spelled};
use crate::support::{bake, model};
use glam::{DVec2, DVec3, Vec3};
use planish_geometry::bake::{self, BakeSettings, BundleNames, SideFiles};
use planish_geometry::mesh::weld::Welding;
use planish_geometry::progress::Silent;
use planish_geometry::source::model::{Model, NormalSource};
use planish_geometry::source::obj::Obj;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::{Index, select};

fn bits(positions: &[DVec3]) -> Vec<[u64; 3]> {
    positions.iter().map(|p| p.to_array().map(f64::to_bits)).collect()
}

fn uv_bits(uvs: &[DVec2]) -> Vec<[u64; 2]> {
    uvs.iter().map(|uv| uv.to_array().map(f64::to_bits)).collect()
}

fn says(obj: &Obj, mesh: &Mesh) -> Result<(), TestCaseError> {
    let named = |i: Option<u32>| i.map(|i| i as usize);
    let corner = |c: &planish_geometry::source::Corner| (c.position as usize, named(c.uv()), named(c.normal()));
    let faces: Vec<Vec<_>> = obj.data().faces().iter().map(|face| face.iter().map(corner).collect()).collect();
    prop_assert_eq!(bits(obj.data().positions()), bits(&mesh.positions));
    prop_assert_eq!(uv_bits(obj.data().uvs()), uv_bits(&mesh.uvs));
    prop_assert_eq!(bits(obj.data().normals()), bits(&mesh.normals));
    prop_assert_eq!(&faces, &mesh.faces);
    Ok(())
}

/// Takes a written file apart along the spelled one: outside the coordinates the same bytes, a coordinate that did not
/// change spelled as before, and any other one a number with the new bits.
fn differs_only_in_coordinates(
    spelled: &Spelled,
    old: &[DVec3],
    new: &[DVec3],
    mut written: &[u8],
) -> Result<(), TestCaseError> {
    let flat = |positions: &[DVec3]| positions.iter().flat_map(DVec3::to_array).collect::<Vec<f64>>();
    let mut copied = 0;
    for ((place, old), new) in spelled.coordinates.iter().zip(flat(old)).zip(flat(new)) {
        let between = &spelled.bytes[copied..place.start];
        prop_assert!(written.starts_with(between));
        written = &written[between.len()..];
        let is_number = |b: &u8| b.is_ascii_alphanumeric() || matches!(b, b'+' | b'-' | b'.');
        let length = written.iter().position(|b| !is_number(b)).unwrap_or(written.len());
        let token = std::str::from_utf8(&written[..length]).unwrap();
        prop_assert_eq!(token.parse::<f64>().unwrap().to_bits(), new.to_bits());
        if old.to_bits() == new.to_bits() {
            prop_assert_eq!(token.as_bytes(), &spelled.bytes[place.clone()]);
        }
        written = &written[length..];
        copied = place.end;
    }
    prop_assert_eq!(written, &spelled.bytes[copied..]);
    Ok(())
}

/// Everything that is made from a file before a method is chosen. Nothing of it refuses a file that parses.
fn gets_through(bytes: &[u8]) -> Result<(), TestCaseError> {
    let Ok(obj) = Obj::parse(bytes.to_vec()) else { return Ok(()) };
    prop_assert_eq!(&obj.with_positions(obj.data().positions(), Some(obj.data().normals())), bytes);
    let carrier = obj.carrier(obj.data().positions(), &vec![Vec3::Z; obj.data().positions().len()], None, "a.mtl");
    let carrier =
        Obj::parse(carrier).map_err(|e| TestCaseError::fail(format!("the carrier does not read back: {e}")))?;
    prop_assert_eq!(bits(carrier.data().positions()), bits(obj.data().positions()));
    prop_assert_eq!(carrier.data().uvs().len(), obj.data().uvs().len());
    let corners = |obj: &Obj| obj.data().faces().items().iter().map(|c| (c.position, c.uv())).collect::<Vec<_>>();
    prop_assert_eq!(corners(&carrier), corners(&obj));
    for welding in [Welding::Exact, Welding::Epsilon(0.5), Welding::None] {
        let model = Model::new(obj.clone(), welding);
        model.defects();
        if let Ok(atlas) = model.atlas() {
            atlas.charts(model.surface());
        }
        for source in [NormalSource::File, NormalSource::Uniform, NormalSource::Area, NormalSource::Angle] {
            let normals = model.vertex_normals(source);
            prop_assert!(normals.is_ok() || source == NormalSource::File);
        }
        model.updated_file_normals(model.surface().positions());
    }
    Ok(())
}

/// A small accident.
#[derive(Clone, Debug)]
enum Accident {
    Byte(Index, u8),
    Insert(Index, &'static str),
    Remove(Index, Index),
    Repeat(Index, Index),
}

/// What files break on.
const BITS_AND_PIECES: [&str; 20] = [
    " ", "\n", "\r", "\r\n", "\\", "\\\n", "#", "/", "//", "-", "0", "9", "1e308", "nan", "-1.#IND", "v ", "vt ",
    "vn ", "f ", "\u{feff}",
];

fn accident() -> impl Strategy<Value = Accident> {
    let at = any::<Index>;
    prop_oneof![
        (at(), any::<u8>()).prop_map(|(at, byte)| Accident::Byte(at, byte)),
        (at(), select(&BITS_AND_PIECES[..])).prop_map(|(at, text)| Accident::Insert(at, text)),
        (at(), at()).prop_map(|(a, b)| Accident::Remove(a, b)),
        (at(), at()).prop_map(|(a, b)| Accident::Repeat(a, b)),
    ]
}

fn damage(bytes: &mut Vec<u8>, accident: &Accident) {
    let end = bytes.len() + 1;
    let range = |a: &Index, b: &Index| {
        let (a, b) = (a.index(end), b.index(end));
        // Mostly short ones, or nothing would be left.
        a.min(b)..a.max(b).min(a.min(b) + 12)
    };
    match accident {
        Accident::Byte(at, byte) => {
            if let Some(old) = bytes.get_mut(at.index(end)) {
                *old = *byte;
            }
        }
        Accident::Insert(at, text) => {
            let at = at.index(end);
            bytes.splice(at..at, text.bytes());
        }
        Accident::Remove(a, b) => drop(bytes.drain(range(a, b))),
        Accident::Repeat(a, b) => {
            let piece = bytes[range(a, b)].to_vec();
            let at = range(a, b).end;
            bytes.splice(at..at, piece);
        }
    }
}

/// Two textured squares with a seam between them.
const SQUARES: &str = "\
v 0 0 0\nv 1 0 0.1\nv 2 0 0\nv 0 1 0\nv 1 1 0.3\nv 2 1 0.1\nv 0 2 0\nv 1 2 0\nv 2 2 0.2
vt .1 .1\nvt .4 .1\nvt .4 .8\nvt .1 .8\nvt .6 .1\nvt .9 .1\nvt .9 .8\nvt .6 .8\nvn 0 0 1
f 1/1/1 2/2/1 5/3/1 4/4/1\nf 2/5/1 3/6/1 6/7/1 5/8/1\nf 4/1 5/2 8/3 7/4\nf 5/5 6/6 9/7\nf 5/5 9/7 8/8
";

proptest! {
    #![proptest_config(cases(400))]

    #[test]
    fn a_file_says_the_same_in_every_spelling((mesh, spelled) in spelled()) {
        let obj = Obj::parse(spelled.bytes.clone()).expect("it is well formed");
        says(&obj, &mesh)?;
        prop_assert_eq!(obj.extras().extended_vertices, spelled.extended);
    }

    #[test]
    fn only_coordinates_change((mesh, spelled) in spelled(), new in vec(position(), 12), kept in vec(any::<bool>(), 12)) {
        let obj = Obj::parse(spelled.bytes.clone()).expect("it is well formed");
        let choose = |i: usize| if kept[i] { mesh.positions[i] } else { new[i] };
        let new: Vec<DVec3> = (0..mesh.positions.len()).map(choose).collect();
        let written = obj.with_positions(&new, None);
        differs_only_in_coordinates(&spelled, &mesh.positions, &new, &written)?;
        says(&Obj::parse(written).expect("it reads back"), &Mesh { positions: new, ..mesh })?;
    }

    #[test]
    fn every_spelling_gets_through((_, spelled) in spelled()) {
        gets_through(&spelled.bytes)?;
    }

    #[test]
    fn damaged_files_are_read_or_refused((_, spelled) in spelled(), accidents in vec(accident(), 1..6)) {
        let mut bytes = spelled.bytes;
        accidents.iter().for_each(|accident| damage(&mut bytes, accident));
        gets_through(&bytes)?;
    }

    #[test]
    fn bits_and_pieces_are_read_or_refused(pieces in vec(select(&BITS_AND_PIECES[..]), 0..60)) {
        gets_through(&[SQUARES.as_bytes(), pieces.concat().as_bytes(), b"\n"].concat())?;
        gets_through(pieces.concat().as_bytes())?;
    }

    #[test]
    fn noise_is_read_or_refused(bytes in vec(any::<u8>(), 0..300)) {
        gets_through(&bytes)?;
    }

    #[test]
    fn damaged_layouts_are_baked_or_refused(accidents in vec(accident(), 1..8)) {
        let mut bytes = SQUARES.as_bytes().to_vec();
        accidents.iter().for_each(|accident| damage(&mut bytes, accident));
        if let Ok(obj) = Obj::parse(bytes) {
            let names = BundleNames { source: String::new(), stem: String::new(), carrier: String::new() };
            let settings = BakeSettings { side: Some(8), ..BakeSettings::default() };
            // Refusing is fine; panicking is not.
            let _ = bake::bake(&Model::new(obj, Welding::Exact), &names, SideFiles::NONE, &settings, &Silent);
        }
    }
}

#[test]
fn the_undamaged_squares_are_baked() {
    let model = model(SQUARES, Welding::Exact);
    let charts = model.atlas().unwrap().charts(model.surface());
    assert_eq!((charts.charts, charts.seam_edges), (4, 4));
    bake(&model, &BakeSettings { side: Some(8), ..BakeSettings::default() });
}
