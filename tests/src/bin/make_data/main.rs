//! Makes the meshes of `data/`: `make_data DIRECTORY`.
//!
//! Clean meshes only; `planish noise` spoils them. Every machine makes the same bytes: see
//! [`sdf`] and [`developable`] for how.

#![allow(clippy::print_stdout)] // One line of statistics per mesh is what the caller wants to see.

mod borders;
mod brep;
mod chart;
mod check;
mod developable;
mod duck;
mod editable;
mod flange;
mod flatten;
mod marching_tetrahedra;
mod mask;
mod mesh;
mod model;
mod obj;
mod pack;
mod planar_mesh;
mod remesh;
mod sdf;
mod segment;
mod unwrap;

use borders::Solid;
use editable::EditableMesh;
use model::{Group, Material, Model};
use remesh::Sizing;
use std::error::Error;
use std::path::{Path, PathBuf};

const SIZING: Sizing = Sizing { min_edge: 0.03, max_edge: 0.054, chord_error: 0.0011, grading: 0.25 };
/// Aimed area of the duck's charts.
const CHART_AREA: f64 = 0.55;

fn main() -> Result<(), Box<dyn Error>> {
    let directory = std::env::args_os().nth(1).map(PathBuf::from);
    let directory = directory.ok_or("usage: make_data DIRECTORY")?;
    write(&directory, duck_model())?;
    write(&directory, flange_model()?)
}

fn write(directory: &Path, model: Model) -> Result<(), Box<dyn Error>> {
    let model = model.rounded();
    println!("{}", check::check(&model));
    std::fs::write(directory.join(format!("{}_clean.obj", model.name)), obj::obj(&model)?)?;
    std::fs::write(directory.join(format!("{}.mtl", model.name)), obj::mtl(&model)?)?;
    Ok(())
}

fn duck_model() -> Model {
    let solid = Solid { whole: duck::distance, parts: duck::parts };
    let raw = marching_tetrahedra::polygonise(duck::distance, duck::BOUNDS, 0.025);
    let mut mesh = EditableMesh::new(raw);
    remesh::remesh(&mut mesh, &duck::distance, &SIZING);
    borders::fit_borders(&mut mesh, &solid);
    let mesh = mesh.into_mesh();
    let part_of: Vec<usize> = mesh.triangles.iter().map(|&t| solid.part_of(mesh.corners(t))).collect();
    let mut charts = unwrap::unwrap(&mesh, &part_of, CHART_AREA);
    pack::pack(&mut charts);
    let colours = [[0.98, 0.78, 0.16], [0.93, 0.42, 0.10], [0.05, 0.05, 0.06]];
    let groups = duck::PART_NAMES.iter().zip(colours).map(|(name, diffuse)| {
        let material = Material { name, diffuse, specular: 0.3, shininess: 60.0 };
        Group { name, material }
    });
    Model {
        name: "duck",
        title: "Rubber duck, an organic closed surface",
        groups: groups.collect(),
        positions: mesh.positions,
        charts,
    }
}

fn flange_model() -> Result<Model, Box<dyn Error>> {
    let (positions, mut charts) = flange::flange()?;
    pack::pack(&mut charts);
    let steel = Material { name: "steel", diffuse: [0.62, 0.65, 0.69], specular: 0.5, shininess: 90.0 };
    Ok(Model {
        name: "flange",
        title: "Bearing flange, planes and cylinders with sharp edges; millimetres",
        groups: flange::GROUP_NAMES.iter().map(|name| Group { name, material: steel }).collect(),
        positions,
        charts,
    })
}
