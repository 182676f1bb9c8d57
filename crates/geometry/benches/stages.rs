//! Time of each stage from the bytes of a file to the files of a map, on the noisy duck of `data/`.
//!
//! `cargo bench -p planish-geometry` runs all stages; a word behind `--` picks those whose names contain it.

use divan::{Bencher, black_box};
use planish_geometry::bake::{self, Belongings, LayoutChoice, Names, Settings};
use planish_geometry::denoise::{Denoiser, Laplacian, NormalField};
use planish_geometry::mesh::topology::Topology;
use planish_geometry::mesh::weld::{Weld, Welding};
use planish_geometry::progress::Silent;
use planish_geometry::source::model::Model;
use planish_geometry::source::obj::Obj;

fn main() {
    divan::main();
}

/// Bytes of the noisy duck, 7,550 vertices with texture coordinates.
fn bytes() -> Vec<u8> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/duck_noisy.obj");
    std::fs::read(path).expect("data/duck_noisy.obj is part of the repository")
}

fn model() -> Model {
    Model::new(Obj::parse(bytes()).expect("the duck is an OBJ file"), Welding::Exact)
}

/// Methods by their names.
fn methods() -> impl Iterator<Item = &'static str> {
    Denoiser::every().into_iter().map(|method| method.name())
}

#[divan::bench]
fn parse(bencher: Bencher) {
    bencher.with_inputs(bytes).bench_values(Obj::parse);
}

#[divan::bench]
fn weld(bencher: Bencher) {
    let obj = Obj::parse(bytes()).expect("the duck is an OBJ file");
    bencher.bench(|| Weld::new(black_box(obj.data().positions()), Welding::Exact));
}

#[divan::bench]
fn connect(bencher: Bencher) {
    let model = model();
    let topology = model.surface().topology();
    let (count, faces) = (model.surface().positions().len(), topology.faces());
    bencher.with_inputs(|| faces.clone()).bench_values(|faces| Topology::new(count, faces));
}

#[divan::bench(args = methods())]
fn denoise(bencher: Bencher, name: &str) {
    let model = model();
    let method = Denoiser::every().into_iter().find(|method| method.name() == name).expect("a method of the list");
    bencher.bench(|| method.deltas(black_box(model.surface()), &Silent));
}

#[divan::bench]
fn normals(bencher: Bencher) {
    let model = model();
    bencher.bench(|| NormalField::default().normals(black_box(&model), &[]));
}

/// The whole bake after a cheap method, at a side of the map in texels.
#[divan::bench(args = [512, 2048])]
fn bake_at(bencher: Bencher, side: u32) {
    let model = model();
    let names = Names { source: "duck.obj".into(), stem: "duck".into(), carrier: "duck".into() };
    let goal = Denoiser::Laplacian(Laplacian::default()).into();
    let settings = Settings { goal, layout: LayoutChoice::Uv, side: Some(side), ..Settings::default() };
    bencher.bench(|| bake::bake(black_box(&model), &names, Belongings::NONE, &settings, &Silent));
}

#[divan::bench]
fn write_back(bencher: Bencher) {
    let model = model();
    let positions = model.data().positions();
    bencher.bench(|| model.source().with_positions(black_box(positions), None));
}
