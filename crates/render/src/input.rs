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

mod backs;

use crate::displaced_mesh::{DisplacementBinding, Sign};
use crate::mesh::{Facing, Mesh, Side, Triangle};
use crate::scene::{Occlusion, Scene, SceneError};
use crate::texture::{Content, Texture};
use backs::OwnBacks;
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
/// where it gives none. Backs of leaves and sheets that have source vertices of their own follow the triangles of the surface, and each
/// side is drawn where it is seen.
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
    let backs = OwnBacks::of(model);
    let triangle = |of: &Model, seams: &[bool], corners: [u32; 3], facing: Facing| {
        let topology = of.surface().topology();
        let side = |from: Index, to: Index| match () {
            () if topology.next(from) == to && seams.get(from as usize) == Some(&true) => Side::Seam,
            () if topology.next(from) == to => Side::Edge,
            () => Side::Diagonal,
        };
        let vertex = |c: u32| model.weld().vertex_of()[of.source_corner(c).position as usize];
        // Normals of the vertices, turned round for backs, follow those of the file.
        let turned = if facing == Facing::Back { first_file_normal + data.normals().len() as u32 } else { 0 };
        let normal = |c: u32| match of.source_corner(c).normal().filter(usable) {
            Some(n) => first_file_normal + n,
            None => turned + vertex(c),
        };
        let uvs = corners.map(|c| of.source_corner(c).uv().filter(|uv| data.uvs()[*uv as usize].is_finite()));
        let uvs = if let [Some(a), Some(b), Some(c)] = uvs { Some([a, b, c]) } else { None };
        let sides = [0, 1, 2].map(|k| side(corners[k], corners[(k + 1) % 3]));
        Triangle { positions: corners.map(vertex), normals: corners.map(normal), uvs, sides, facing }
    };
    let seams_of = |of: &Model, atlas: Option<&Atlas>| atlas.map_or_else(Vec::new, |atlas| seams(of, atlas));
    let seams = seams_of(model, atlas.as_ref());
    let fronts = surface.triangle_corners().iter().map(|corners| {
        let facing = backs.as_ref().map_or(Facing::Both, |backs| backs.facing(model, corners[0]));
        triangle(model, &seams, *corners, facing)
    });
    let mut triangles: Vec<Triangle> = fronts.collect();
    let mut tangents = atlas.as_ref().map_or_else(Vec::new, |atlas| frames(model, atlas, &vertex_normals));
    let mut turned_normals = Vec::new();
    if let Some(backs) = &backs {
        let (both, of_both) = (backs.model(), backs.triangles());
        let atlas = both.atlas().ok();
        let seams = seams_of(both, atlas.as_ref());
        triangles.extend(of_both.iter().map(|t| {
            let corners = both.surface().triangle_corners()[*t];
            triangle(both, &seams, corners, Facing::Back)
        }));
        if !tangents.is_empty() {
            let of_both_normals = backs.turned(&vertex_normals);
            let frames = atlas.map_or_else(Vec::new, |atlas| frames(both, &atlas, &of_both_normals));
            tangents.extend(of_both.iter().map(|t| frames.get(*t).copied().unwrap_or_default()));
        }
        turned_normals.extend(vertex_normals.iter().map(|n| -n));
    }
    let origin = origin(model);
    let normals = vertex_normals.into_iter().chain(file_normals).chain(turned_normals);
    Scene::new(Mesh {
        positions: surface.positions().iter().map(|p| (p - origin).as_vec3()).collect(),
        tangents,
        normals: normals.map(|n: DVec3| n.as_vec3()).collect::<Vec<Vec3>>(),
        uvs: data.uvs().iter().map(|uv| uv.as_vec2()).collect(),
        triangles,
        scalars: scalars.map(of_vertex).transpose()?,
    })
}

/// Returns the face of the source from which each triangle of the model's [`scene`] is. #T
pub fn faces_of_triangles(model: &Model) -> Vec<Index> {
    let of_surface = |of: &Model, corners: &[u32; 3]| of.source_face(of.surface().topology().face(corners[0]));
    let mut faces: Vec<Index> =
        model.surface().triangle_corners().iter().map(|corners| of_surface(model, corners)).collect();
    if let Some(backs) = OwnBacks::of(model) {
        let corners = backs.model().surface().triangle_corners();
        faces.extend(backs.triangles().iter().map(|t| of_surface(backs.model(), &corners[*t])));
    }
    faces
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
    use crate::settings::{Normals, Settings, Shading, Size};
    use crate::software;
    use crate::texture::Textures;
    use planish_geometry::map::displacement::{Encoding, MapKind, TexelFormat};
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

    /// A rough sheet of triangles; with a back, whose faces name `v` and `vt` lines of their own.
    fn leaf(has_back: bool) -> Model {
        let (mut text, n) = (String::new(), 9);
        for side in 0..2 {
            for i in 0..n * n {
                let [x, y] = [i % n, i / n].map(f64::from);
                let [u, v] = [0.01 + 0.06 * x + 0.5 * f64::from(side), 0.05 + 0.1 * y];
                text += &format!("v {x} {y} {}\nvt {u} {v}\n", 0.1 * f64::from(i * i % 11));
            }
        }
        for i in (0..n * (n - 1)).filter(|i| i % n < n - 1) {
            for [a, b, c] in [[i, i + 1, i + n], [i + 1, i + n + 1, i + n]].map(|t| t.map(|v| v + 1)) {
                text += &format!("f {a}/{a} {b}/{b} {c}/{c}\n");
                let [a, b, c] = [a, b, c].map(|v| v + n * n);
                text += if has_back { format!("f {c}/{c} {b}/{b} {a}/{a}\n") } else { String::new() }.as_str();
            }
        }
        model(&text)
    }

    #[test]
    fn each_side_of_a_leaf_has_its_texture_and_the_light_of_its_side() {
        let fronts = 128;
        let both = leaf(true);
        let scene_of = |model: &Model| {
            let mut scene = scene(model, None).unwrap();
            let lines = model.data().positions();
            let vertex = |p: &DVec3| ShaderVertex {
                position: (*p - origin(model)).as_vec3(),
                normal: Vec3::Z,
                sample_at: Some(SampleAt::Texel(0)),
                ..ShaderVertex::default()
            };
            let map = planish_geometry::map::per_vertex::bake(&[0.3], &[0]);
            let encoding = Encoding::covering(0.0, 1.0, TexelFormat::Png16);
            let map = Displacement::encode(&[map], MapKind::Scalar, encoding);
            let vertices: Vec<_> = lines.iter().map(vertex).collect();
            scene.displacement = Some(bind_map(model, &scene, map, &vertices));
            scene
        };
        let (mut leaf_scene, front_scene) = (scene_of(&both), scene_of(&leaf(false)));
        let triangles = &leaf_scene.mesh().triangles;
        assert_eq!((triangles.len(), leaf_scene.mesh().tangents.len()), (2 * fronts, 2 * fronts));
        assert!(triangles[..fronts].iter().all(|t| t.facing == Facing::Front));
        assert!(triangles[fronts..].iter().all(|t| t.facing == Facing::Back && t.uvs.is_some_and(|uvs| uvs[0] >= 81)));
        let faces = faces_of_triangles(&both);
        assert!(faces[..fronts].iter().all(|f| f % 2 == 0) && faces[fronts..].iter().all(|f| f % 2 == 1));
        let settings = |yaw: f32, shading: Shading, normals: Normals| {
            let mut settings = Settings { size: Size { width: 80, height: 80 }, shading, ..Settings::default() };
            (settings.camera.yaw, settings.camera.pitch) = (yaw, 20.0);
            (settings.displace.lambda, settings.displace.normals) = (1.0, normals);
            settings
        };
        // Two surfaces at one place look like one that is lit from both sides.
        for (yaw, normals) in
            [(25.0, Normals::Base), (25.0, Normals::Derived), (200.0, Normals::Base), (200.0, Normals::Derived)]
        {
            let settings = settings(yaw, Shading::Phong, normals);
            let [two, one] = [&leaf_scene, &front_scene].map(|scene| software::render(scene, &settings));
            let off = two.iter().zip(one.iter()).filter(|(a, b)| a.abs_diff(**b) > 1).count();
            assert_eq!(off, 0, "{yaw} {normals:?}");
        }
        let colour = |rgb: [u8; 3]| {
            let [r, g, b] = rgb;
            Texture::new(RgbaImage::from_pixel(1, 1, [r, g, b, 255].into()), Content::Colour).unwrap()
        };
        let of_triangles = faces.iter().map(|face| Some(face % 2)).collect();
        leaf_scene.textures =
            Textures::by_triangle(vec![colour([230, 20, 20]), colour([20, 20, 230])], of_triangles).unwrap();
        for (yaw, more, less) in [(0.0, 0, 2), (180.0, 2, 0)] {
            let picture = software::render(&leaf_scene, &settings(yaw, Shading::Texture, Normals::Base));
            let strong = |a: usize, b: usize| {
                picture.pixels().filter(|p| u16::from(p.0[a]) > 2 * u16::from(p.0[b].max(20))).count()
            };
            assert!(strong(more, less) > 1000 && strong(less, more) == 0, "from {yaw}°");
        }
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
