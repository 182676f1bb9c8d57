//! `apply` on both meshes that a manifest belongs to.

use crate::folder::Folder;
use crate::mesh::Mesh;
use crate::reference::statements;

#[test]
fn the_carrier_and_the_mesh_that_was_baked_give_the_same_vertices() {
    let mesh = Mesh::sphere(6).noisy(0.05).split_at_seams().with_defects();
    let with_normals = mesh.obj() + "v 4 0 0\nv 5 0 0\nv 4 1 0\nvn 0 0.6 0.8\nvn 1 0 0\nf -3/1/1 -2/2/2 -1/3/1\n";
    for normals in ["angle", "area", "uniform", "file"] {
        for bits in [8, 16, 32] {
            let folder = Folder::with("in.obj", &with_normals);
            folder.succeeds(&format!("bake in.obj -o out --size 64 --normals {normals} --bits {bits}"));
            folder.succeeds("apply out/in.planish.json -o from_carrier.obj");
            folder.succeeds("apply out/in.planish.json -o from_source.obj --mesh in.obj");
            let (carrier, source) = (folder.text("from_carrier.obj"), folder.text("from_source.obj"));
            assert!(statements(&carrier, "v") == statements(&source, "v"), "{normals}, {bits} bits");
            assert!(statements(&source, "v") != statements(&with_normals, "v"), "{normals}, {bits} bits");
        }
    }
}

#[test]
fn all_but_the_vertices_of_the_mesh_stays() {
    let mesh = Mesh::sphere(4).noisy(0.05).obj();
    let source = format!("# scan\r\nmtllib none.mtl\r\n{mesh}g end\r\n");
    let folder = Folder::with("in.obj", &source);
    folder.succeeds("bake in.obj -o out --size 64");
    folder.succeeds("apply out/in.planish.json -o new/applied.obj --mesh in.obj");
    let without_vertices = |text: &str| -> Vec<String> {
        text.split('\n').filter(|line| !line.starts_with("v ")).map(str::to_owned).collect()
    };
    assert_eq!(without_vertices(&folder.text("new/applied.obj")), without_vertices(&source));
}
