//! The law of the report: what it promises is what `apply` does.

use crate::folder::Folder;
use crate::mesh::Mesh;
use crate::reference::{Lines, OneStep};
use glam::DVec3;

const ONE_STEP: &str = "--method laplacian --iterations 1 --step 1";

fn cases() -> Vec<(&'static str, Mesh)> {
    let sphere = Mesh::sphere(12).noisy(0.02);
    let grid = Mesh::grid(12).noisy(0.02);
    vec![
        ("seam", sphere.clone()),
        ("seam with split `v` lines", sphere.split_at_seams()),
        ("boundary", grid.clone()),
        ("boundary and defects", grid.clone().with_defects()),
        ("split and defects", sphere.split_at_seams().with_defects()),
        // Single precision alone would leave half a unit of the second coordinate.
        ("far from the origin", sphere.split_at_seams().moved([500_000.123, 4_500_000.456, 120.0])),
        ("small and far", grid.moved([500_000.123, -4_500_000.456, 0.0])),
    ]
}

/// Bakes one whole step, applies it at λ = 1, and holds the result against the definition.
fn check(name: &str, mesh: &Mesh, options: &str) {
    let folder = Folder::with("in.obj", mesh.obj());
    let baked = folder.succeeds_with_json(&format!("bake in.obj -o out {ONE_STEP} {options}"));
    folder.succeeds("apply out/in.planish.json --lambda 1 -o displaced.obj");
    let report = &baked["manifest"]["report"];
    let number = |field: &str| report[field].as_f64().unwrap_or_else(|| panic!("{name}: no number {field}"));
    let [source, displaced] = [mesh.obj(), folder.text("displaced.obj")].map(|obj| Lines::of(&obj).positions);
    let OneStep { positions, vertex_of_line } = OneStep::of(&mesh.obj());
    assert_eq!(displaced.len(), positions.len(), "{name}");

    let largest = displaced.iter().zip(&positions).map(|(d, p)| d.distance(*p)).fold(0.0, f64::max);
    let (max_error, bound) = (number("max_error"), number("error_bound"));
    assert!(largest <= bound, "{name} {options}: {largest:e} is more than {bound:e}");
    // And it promises no more than that: the two measurements differ by the rounding that the bound allows for.
    assert!((largest - max_error).abs() <= bound - max_error, "{name} {options}: {largest:e}, reported {max_error:e}");

    assert_eq!(number("seam_gap"), 0.0, "{name} {options}");
    let mut place_of_vertex = vec![None; displaced.len()];
    for (line, (v, p)) in vertex_of_line.iter().zip(&displaced).enumerate() {
        let bits = p.to_array().map(f64::to_bits);
        assert_eq!(*place_of_vertex[*v].get_or_insert(bits), bits, "{name} {options}: v line {}", line + 1);
    }
    let moved = displaced.iter().zip(&source).map(|(d, p)| d.distance(*p));
    assert!(moved.fold(0.0, f64::max) > 0.005, "{name}: something was displaced");
}

#[test]
fn no_vertex_is_farther_off_than_the_report_says() {
    for (name, mesh) in cases() {
        check(name, &mesh, "");
    }
}

#[test]
fn the_bound_holds_for_every_encoding_and_interpolation() {
    let mesh = Mesh::sphere(8).noisy(0.03).split_at_seams();
    for interpolation in ["barycentric", "natural", "idw", "nearest"] {
        for bits in [8, 16, 32] {
            // So few texels that vertices share some: the bound is wide, and must still hold.
            for size in [8, 128] {
                for texels in ["fitted", "interpolated"] {
                    let map = format!("--interpolation {interpolation} --texels {texels} --bits {bits} --size {size}");
                    check("sphere", &mesh, &format!("--layout uv {map}"));
                }
            }
        }
    }
}

#[test]
fn the_bound_holds_with_a_texel_for_each_vertex_in_every_format() {
    for (name, mesh) in cases() {
        for format in ["png --bits 8", "png", "tiff", "tiff --bits 32", "exr --bits 16", "exr"] {
            check(name, &mesh, &format!("--layout vertex --format {format}"));
        }
    }
}

#[test]
fn a_resolved_layout_is_exact_to_some_quanta() {
    // Every vertex of this grid lies on a texel centre, so only the encoding is left: half a quantum of height, and
    // the rounding of coordinates of size one.
    let n = 16;
    let mut mesh = Mesh::grid(n).noisy(0.01);
    let size = 64.0;
    mesh.uvs = (0..=n)
        .flat_map(|j| (0..=n).map(move |i| [i, j]))
        .map(|ij| ij.map(|k| (3.5 * k as f64).floor()))
        .map(|t| t.map(|t| (t + 0.5) / size))
        .collect();
    let folder = Folder::with("in.obj", mesh.obj());
    for (bits, steps) in [(8, 255.0), (16, 65535.0)] {
        let baked = folder.succeeds_with_json(&format!("bake in.obj -o out {ONE_STEP} --size {size} --bits {bits}"));
        let [map, report] = ["displacement", "report"].map(|field| &baked["manifest"][field]);
        let quantum = map["scale"].as_f64().unwrap() / steps;
        assert!((report["quantum"].as_f64().unwrap() / quantum - 1.0).abs() < 1e-12, "{bits} bits");
        let max_error = report["max_error"].as_f64().unwrap();
        assert!(max_error <= 0.5 * quantum + f64::from(f32::EPSILON), "{bits} bits: {max_error:e} {quantum:e}");
        assert_eq!(report["unresolved_vertices"], 0);
    }
}

#[test]
fn lambda_scales_the_displacement() {
    let mesh = Mesh::sphere(8).noisy(0.03);
    let folder = Folder::with("in.obj", mesh.obj());
    folder.succeeds("bake in.obj --method laplacian -o out --lambda 0.25");
    let at = |lambda: &str| {
        folder.succeeds(&format!("apply out/in.planish.json {lambda} -o out.obj"));
        Lines::of(&folder.text("out.obj")).positions
    };
    let as_single = |p: &[f64; 3]| DVec3::from(p.map(|x| f64::from(x as f32)));
    let source: Vec<DVec3> = mesh.positions.iter().map(as_single).collect();
    assert_eq!(at("--lambda 0"), source, "λ = 0 leaves what single precision makes of the source");
    assert_eq!(at(""), at("--lambda 0.25"), "λ of the manifest is the default");
    let (quarter, whole, negative) = (at(""), at("--lambda 1"), at("--lambda -1"));
    for (i, p) in source.iter().enumerate() {
        // λ·h·n and p − λ·h·n round once each; coordinates are of size one.
        let tolerance = 4.0 * f64::from(f32::EPSILON);
        assert!((quarter[i] - *p).distance(0.25 * (whole[i] - *p)) < tolerance);
        assert!((negative[i] - *p).distance(*p - whole[i]) < tolerance);
    }
}
