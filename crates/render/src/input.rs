//! Conversion of a model in f64 to a scene in f32.
//!
//! ```
//! use planish_geometry::mesh::weld::Welding;
//! use planish_geometry::source::{model::Model, obj::Obj};
//! use planish_render::{input, software};
//! use planish_render::settings::{Settings, Shading, Size};
//!
//! // A tent with a number for each vertex, such as its error.
//! let text = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 1\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n";
//! let model = Model::new(Obj::parse(text.into())?, Welding::Exact);
//! let plain = input::scene(&model, None)?;
//! let heat = input::scene(&model, Some(&[0.0, 0.0, 0.0, 0.0, 1.0]))?;
//! assert_eq!(heat.mesh().triangles.len(), 4);
//! let settings = Settings { size: Size { width: 32, height: 24 }, shading: Shading::Heat, ..Settings::default() };
//! assert_ne!(software::render(&plain, &settings), software::render(&heat, &settings));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use crate::displaced_mesh::{DisplacementBinding, Sign};
use crate::mesh::{Mesh, Side, Triangle};
use crate::scene::{Occlusion, Scene, SceneError};
use crate::texture::{Content, Texture};
use glam::{DVec3, Vec3};
use image::RgbaImage;
use planish_geometry::map::displace::{self, ShaderVertex};
use planish_geometry::map::displacement::{Displacement, SampleAt};
use planish_geometry::map::manifest::Layout;
use planish_geometry::map::tangents::{self, Tangent};
use planish_geometry::mesh::atlas::Atlas;
use planish_geometry::mesh::jagged::Index;
use planish_geometry::mesh::normals::{FaceWeight, vertex_normals};
use planish_geometry::mesh::topology::EdgeKind;
use planish_geometry::source::model::Model;

/// The scene of a model, with a number for each `v` line of its file where there are any.
///
/// A corner is lit with the normal that the file gives it, and with its vertex's angle-weighted normal
/// where it gives none.
pub fn scene(model: &Model, scalars: Option<&[f32]>) -> Result<Scene, SceneError> {
    let (data, surface) = (model.data(), model.surface());
    let topology = surface.topology();
    let lines = data.positions().len();
    let of_vertex = |numbers: &[f32]| match numbers.len() {
        found if found == lines => Ok(at_vertices(model, numbers)),
        found => Err(SceneError::ScalarCount { found, expected: lines }),
    };
    let vertex_normals = vertex_normals(surface, FaceWeight::Angle);
    let file_normals = data.normals().iter().map(|n| n.normalize_or_zero());
    let first_file_normal = topology.vertex_count() as u32;
    let usable = |n: &u32| data.normals()[*n as usize].try_normalize().is_some();
    // Without usable texture coordinates there is nothing to cut, and no direction in the texture.
    let atlas = model.atlas().ok();
    let seams = atlas.as_ref().map_or_else(Vec::new, |atlas| seams(model, atlas));
    let side = |from: Index, to: Index| match () {
        () if topology.next(from) == to && seams.get(from as usize) == Some(&true) => Side::Seam,
        () if topology.next(from) == to => Side::Edge,
        () => Side::Diagonal,
    };

    let triangle = |&corners: &[u32; 3]| {
        let positions = corners.map(|c| topology.vertex(c));
        let normal = |c: u32| match model.source_corner(c).normal().filter(usable) {
            Some(n) => first_file_normal + n,
            None => topology.vertex(c),
        };
        let uvs = corners.map(|c| model.source_corner(c).uv().filter(|uv| data.uvs()[*uv as usize].is_finite()));
        let uvs = if let [Some(a), Some(b), Some(c)] = uvs { Some([a, b, c]) } else { None };
        let sides = [0, 1, 2].map(|k| side(corners[k], corners[(k + 1) % 3]));
        Triangle { positions, normals: corners.map(normal), uvs, sides }
    };
    let origin = origin(model);
    Scene::new(Mesh {
        positions: surface.positions().iter().map(|p| (p - origin).as_vec3()).collect(),
        tangents: atlas.map_or_else(Vec::new, |atlas| frames(model, &atlas, &vertex_normals)),
        normals: vertex_normals.into_iter().chain(file_normals).map(|n: DVec3| n.as_vec3()).collect::<Vec<Vec3>>(),
        uvs: data.uvs().iter().map(|uv| uv.as_vec2()).collect(),
        triangles: surface.triangle_corners().iter().map(triangle).collect(),
        scalars: scalars.map(of_vertex).transpose()?,
    })
}

/// Point that is subtracted from the coordinates of a model before they are rounded to single precision, as maps have it.
pub fn origin(model: &Model) -> DVec3 {
    displace::origin(model.surface().bounds())
}

/// The map of a scene, whose vertices (one for each `v` line) displace it as
/// [`baked_vertices`](displace::baked_vertices) has them.
pub fn bind_map(model: &Model, scene: &Scene, map: Displacement, lines: &[ShaderVertex]) -> DisplacementBinding {
    DisplacementBinding::new(scene.mesh(), map, at_vertices(model, lines), Sign::Subtract)
}

/// A map that puts heights on a scene, at the dominant texture coordinate of each vertex, so that nothing cracks.
/// None where the model has no texture coordinates.
pub fn bind_heights(model: &Model, scene: &Scene, map: Displacement) -> Option<DisplacementBinding> {
    let atlas = model.atlas_in(model.tile()).ok()?;
    let mesh = scene.mesh();
    let normals = vertex_normals(model.surface(), FaceWeight::Angle);
    let vertex = |(v, (position, normal)): (Index, (&Vec3, DVec3))| ShaderVertex {
        position: *position,
        normal: normal.as_vec3(),
        tangent: Tangent::default(),
        sample_at: atlas.dominant(v).map(|uv| SampleAt::Uv(atlas.uvs()[uv as usize].as_vec2())),
    };
    let vertices = (0..).zip(mesh.positions.iter().zip(normals)).map(vertex).collect();
    Some(DisplacementBinding::new(mesh, map, vertices, Sign::Add))
}

/// Ambient occlusion of a scene from a grey picture in a layout of the model. `None` if the picture has fewer texels than that layout
/// needs.
pub fn occlusion(model: &Model, picture: RgbaImage, layout: Layout) -> Option<Occlusion> {
    match layout {
        Layout::Uv => Texture::new(picture, Content::Data).map(Occlusion::Picture),
        Layout::Vertex => {
            let lines = model.data().positions().len();
            let open: Vec<f32> = picture.pixels().take(lines).map(|p| f32::from(p.0[0]) / 255.0).collect();
            (open.len() == lines).then(|| Occlusion::Vertices(at_vertices(model, &open)))
        }
    }
}

/// Selects the values of the vertices from values for each `v` line.
fn at_vertices<T: Copy>(model: &Model, of_lines: &[T]) -> Vec<T> {
    model.weld().first().iter().map(|&line| of_lines[line as usize]).collect()
}

/// Marks the corners from which a texture seam runs to the next corner, one entry per corner.
fn seams(model: &Model, atlas: &Atlas) -> Vec<bool> {
    let topology = model.surface().topology();
    let mut seams = vec![false; topology.faces().items().len()];
    for (e, corners) in (0..).zip(topology.edge_corners().iter()) {
        if topology.edge_kind(e) == EdgeKind::Interior && atlas.is_cut(model.surface(), e) {
            corners.iter().for_each(|&c| seams[c as usize] = true);
        }
    }
    seams
}

/// MikkTSpace frames with the normals of the vertices, as the baker has them.
fn frames(model: &Model, atlas: &Atlas, normals: &[DVec3]) -> Vec<[Tangent; 3]> {
    let normals: Vec<Vec3> = normals.iter().map(|n| n.as_vec3()).collect();
    tangents::tangents(model.surface(), atlas, &normals)
}

#[cfg(test)]
mod tests {
    use super::*;
    use planish_geometry::mesh::weld::Welding;
    use planish_geometry::source::obj::Obj;

    fn model(text: &str) -> Model {
        Model::new(Obj::parse(text.as_bytes().to_vec()).unwrap(), Welding::Exact)
    }

    /// A square far from the origin, cut along a diagonal; one `v` line is written twice and one is not used.
    const SQUARE: &str = "v 1e7 0 0\nv 1e7 1 0\nv 1e7 1 1\nv 1e7 0 1\nv 1e7 1 1\nv 0 0 0\n\
        vt 0 0\nvt 1 0\nvt 1 1\nvt nan 0\nvn 0 0 3\nvn 0 0 0\n\
        f 1/1/1 2/2/2 3/3\nf 1/1 5/3 4/4\n";

    #[test]
    fn welded_recentred_and_with_what_each_corner_names() {
        let scene = scene(&model(SQUARE), None).unwrap();
        let Mesh { positions, normals, uvs, triangles, .. } = scene.mesh();
        assert_eq!(scene.bounds().centre, Vec3::ZERO, "the origin is the centre of the used box far away");
        assert_eq!(positions[triangles[0].positions[2] as usize], Vec3::new(0.0, 0.5, 0.5));
        assert_eq!(triangles[0].positions[2], triangles[1].positions[1]);
        let lit = triangles[0].normals.map(|n| normals[n as usize]);
        assert_eq!(lit, [Vec3::Z, Vec3::X, Vec3::X], "named, zero, absent");
        assert_eq!(triangles[0].uvs.map(|t| uvs[t[2] as usize]), Some(glam::Vec2::ONE));
        assert_eq!(triangles[1].uvs, None, "not a number");
    }

    #[test]
    fn numbers_follow_their_lines() {
        let numbers = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0];
        let drawn = scene(&model(SQUARE), Some(&numbers)).unwrap();
        assert_eq!(drawn.mesh().scalars.as_deref(), Some(&[0.0, 1.0, 2.0, 3.0, 5.0][..]));
        let short = scene(&model(SQUARE), Some(&numbers[1..])).unwrap_err();
        assert_eq!(short, SceneError::ScalarCount { found: 5, expected: 6 });
    }
}
