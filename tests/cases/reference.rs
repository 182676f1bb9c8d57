//! planish against quantities that numpy computed from their definitions; see `tests/python/README.md`.

mod bounds;

use crate::support::{meshes_in, root};
use bounds::Bounds;
use glam::DVec3;
use planish_geometry::source::obj::Obj;
use planish_tests::quantities;
use serde_json::Value;
use std::path::{Path, PathBuf};

fn meshes() -> Vec<PathBuf> {
    let meshes = meshes_in(&root().join("tests/reference"));
    assert!(!meshes.is_empty());
    meshes
}

fn frozen(mesh: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(mesh.with_extension("json")).unwrap()).unwrap()
}

fn bounds_of(bytes: &[u8]) -> Bounds {
    let obj = Obj::parse(bytes.to_vec()).unwrap();
    let triangle = |face: &[planish_geometry::source::Corner]| std::array::from_fn(|k| face[k].position as usize);
    let triangles: Vec<[usize; 3]> = obj.data().faces().iter().map(triangle).collect();
    let positions: Vec<DVec3> = obj.data().positions().to_vec();
    Bounds::new(&positions, &triangles)
}

#[test]
fn quantities_are_the_frozen_ones() {
    let mut wrong = Vec::new();
    for mesh in meshes() {
        let bytes = std::fs::read(&mesh).unwrap();
        let bounds = bounds_of(&bytes);
        let found = bounds.differences(&quantities::of(bytes).unwrap(), &frozen(&mesh));
        wrong.extend(found.iter().map(|sentence| format!("{}: {sentence}", mesh.display())));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Changes the last number of a quantity: the tenth digit behind the point, or an integer by one.
fn change(value: &mut Value) {
    match value {
        Value::Array(items) => items.last_mut().map(change).unwrap(),
        Value::Object(items) => items.values_mut().next_back().map(change).unwrap(),
        number => {
            let changed = number.as_u64().map(|integer| Value::from(integer + 1));
            *number = changed.unwrap_or_else(|| Value::from(number.as_f64().unwrap() + 1e-10));
        }
    }
}

#[test]
fn a_changed_digit_is_found() {
    // Of unit size, at the origin, and well shaped: no bound is looser than 1e-11 there.
    let mesh = root().join("tests/reference/dented_sphere.obj");
    let (bounds, fine) = (bounds_of(&std::fs::read(&mesh).unwrap()), frozen(&mesh));
    assert_eq!(bounds.differences(&fine, &fine), [""; 0]);
    for quantity in fine.as_object().unwrap().keys().filter(|name| fine[name] != Value::Array(Vec::new())) {
        let mut broken = fine.clone();
        change(&mut broken[quantity]);
        let found = bounds.differences(&broken, &fine);
        assert!(found.len() == 1 && found[0].starts_with(quantity), "{quantity}: {found:?}");
    }
}

#[test]
fn what_is_missing_or_not_a_number_is_found() {
    let mesh = root().join("tests/reference/cube.obj");
    let (bounds, fine) = (bounds_of(&std::fs::read(&mesh).unwrap()), frozen(&mesh));
    for quantity in fine.as_object().unwrap().keys() {
        let mut broken = fine.clone();
        broken[quantity] = Value::Null;
        assert!(!bounds.differences(&broken, &fine).is_empty(), "{quantity}");
    }
    let mut shorter = fine.clone();
    shorter["mass"].as_array_mut().unwrap().pop();
    assert_eq!(bounds.differences(&shorter, &fine), ["mass has 97 entries, not 98"]);
}
