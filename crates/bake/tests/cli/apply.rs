//! `apply` on both meshes that a manifest belongs to.

use crate::folder::Folder;
use crate::mesh::Mesh;
use crate::reference::{Lines, statements};

#[test]
fn the_carrier_and_the_mesh_that_was_baked_give_the_same_vertices() {
    let mesh = Mesh::sphere(6).noisy(0.05).split_at_seams().with_defects();
    let with_normals = mesh.obj() + "v 4 0 0\nv 5 0 0\nv 4 1 0\nvn 0 0.6 0.8\nvn 1 0 0\nf -3/1/1 -2/2/2 -1/3/1\n";
    let maps = [
        "--layout uv --size 64 --bits 8",
        "--layout uv --size 64",
        "--layout vertex",
        "--layout vertex --bits 32",
        "--layout vertex --map vector",
        "--layout uv --size 64 --map vector --space tangent",
        "--layout vertex --map vector --space tangent --format tiff",
    ];
    for normals in ["angle", "area", "uniform", "file"] {
        for map in maps {
            let folder = Folder::with("in.obj", &with_normals);
            folder.succeeds(&format!("bake in.obj --method laplacian -o out --normals {normals} {map}"));
            folder.succeeds("apply out/in.planish.json -o from_carrier.obj");
            folder.succeeds("apply out/in.planish.json -o from_source.obj --mesh in.obj");
            let (carrier, source) = (folder.text("from_carrier.obj"), folder.text("from_source.obj"));
            assert!(statements(&carrier, "v") == statements(&source, "v"), "{normals}, {map}");
            assert!(statements(&source, "v") != statements(&with_normals, "v"), "{normals}, {map}");
        }
    }
}

#[test]
fn vectors_hold_the_whole_way() {
    let mesh = Mesh::sphere(6).noisy(0.05).split_at_seams();
    let folder = Folder::with("in.obj", mesh.obj());
    folder.succeeds("denoise in.obj --method laplacian -o denoised.obj");
    let denoised = Lines::of(&folder.text("denoised.obj")).positions;
    for space in ["object", "tangent"] {
        for layout in ["vertex", "uv --size 256"] {
            let line = format!(
                "bake in.obj --method laplacian -o out --bits 32 --map vector --space {space} --layout {layout}"
            );
            let report = &folder.succeeds_with_json(&line)["manifest"]["report"];
            folder.succeeds("apply out/in.planish.json -o applied.obj");
            let applied = Lines::of(&folder.text("applied.obj")).positions;
            let off = applied.iter().zip(&denoised).map(|(a, d)| a.distance(*d)).fold(0.0, f64::max);
            // What is measured here is what the report measured.
            assert!(off <= report["error_bound"].as_f64().unwrap(), "{space} {layout}: {off:e}");
            // Coordinates of size one in single precision, through products with three axes.
            assert!(off < 1e-6, "{space} {layout}: {off:e}");
            assert_eq!((&report["left_out_rms"], &report["seam_gap"]), (&0.0.into(), &0.0.into()));
        }
    }
}

#[test]
fn all_but_the_vertices_of_the_mesh_stays() {
    let mesh = Mesh::sphere(4).noisy(0.05).obj();
    let source = format!("# scan\r\nmtllib none.mtl\r\n{mesh}g end\r\n");
    let folder = Folder::with("in.obj", &source);
    folder.succeeds("bake in.obj --method laplacian -o out --size 64");
    folder.succeeds("apply out/in.planish.json -o new/applied.obj --mesh in.obj");
    let without_vertices = |text: &str| -> Vec<String> {
        text.split('\n').filter(|line| !line.starts_with("v ")).map(str::to_owned).collect()
    };
    assert_eq!(without_vertices(&folder.text("new/applied.obj")), without_vertices(&source));
}
