//! The number of threads changes nothing.

use crate::support::{bake, model, obj_text};
use glam::DVec2;
use planish_geometry::bake::{BakeSettings, LayoutChoice};
use planish_geometry::map::Interpolation;
use planish_geometry::map::displacement::TexelFormat;
use planish_geometry::mesh::shapes;
use planish_geometry::mesh::weld::Welding;
use planish_geometry::source::model::Model;

/// A sphere whose triangles are charts of their own on a lattice: gutter everywhere, and each vertex on a seam.
fn confetti() -> Model {
    let sphere = shapes::dented_sphere(3);
    let triangles: Vec<_> = sphere.triangles().collect();
    let per_row = (triangles.len() as f64).sqrt().ceil();
    let corner = [DVec2::new(0.1, 0.1), DVec2::new(0.9, 0.2), DVec2::new(0.3, 0.8)];
    let cell = |f: usize| DVec2::new(f as f64 % per_row, (f as f64 / per_row).floor());
    let uvs: Vec<_> = (0..triangles.len()).flat_map(|f| corner.map(|c| (cell(f) + c) / per_row)).collect();
    let face = |(f, t): (usize, &[u32; 3])| (0..3).map(|k| (t[k] as usize, Some(3 * f + k))).collect();
    let faces: Vec<_> = triangles.iter().enumerate().map(face).collect();
    model(obj_text(sphere.positions(), &uvs, &faces), Welding::Exact)
}

#[test]
fn a_bake_is_the_same_bytes_on_any_number_of_threads() {
    let model = confetti();
    let fillings = [Interpolation::Barycentric, Interpolation::Natural, Interpolation::Idw, Interpolation::Nearest];
    let formats = [TexelFormat::Png16, TexelFormat::Png8, TexelFormat::Exr32, TexelFormat::Tiff16];
    for (interpolation, texel) in fillings.into_iter().zip(formats) {
        let layout = LayoutChoice::Uv;
        let settings = BakeSettings { side: Some(256), interpolation, texel, layout, ..BakeSettings::default() };
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| bake(&model, &settings).files)
        };
        let alone = on(1);
        for threads in [2, 7] {
            for (one, many) in alone.iter().zip(on(threads)) {
                assert_eq!(one.name, many.name);
                assert!(one.bytes == many.bytes, "{interpolation:?} on {threads} threads: {} differs", one.name);
            }
        }
    }
}
