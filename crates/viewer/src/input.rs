//! From a model in f64 to a scene in f32.

use crate::scene::{Group, Mesh, Scene, SceneError, Triangle};
use glam::{DVec3, Vec3};
use planish_geometry::model::Model;
use planish_geometry::normals::{FaceWeight, vertex_normals};
use planish_geometry::texture::tangents;

/// What a scene needs beside positions, normals and texture coordinates.
#[derive(Clone, Copy, Debug, Default)]
pub struct Extras<'a> {
    /// A number for each `v` line of the file.
    pub scalars: Option<&'a [f32]>,
    /// The texture of each of the file's materials, and of faces without a material.
    pub textures: Textures<'a>,
    /// Tangent frames, for what tilts normals.
    pub tangents: Frames,
}

/// Which texture is whose.
#[derive(Clone, Copy, Debug, Default)]
pub enum Textures<'a> {
    /// Everything has the scene's first one, if there is one.
    #[default]
    First,
    /// Indices by material, in the order in which the file first uses them; the last entry is for faces without one.
    ByMaterial(&'a [Option<usize>]),
}

/// Whether tangent frames are computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Frames {
    /// No.
    #[default]
    None,
    /// By MikkTSpace, with the angle-weighted normals of the vertices, in which normal maps are baked.
    MikkTSpace,
}

/// The scene of a model.
///
/// A corner is lit with the normal that the file gives it, and with its vertex's angle-weighted normal
/// where it gives none.
pub fn scene(model: &Model, extras: Extras<'_>) -> Result<Scene, SceneError> {
    let (obj, surface) = (model.obj(), model.surface());
    let topology = surface.topology();
    let lines = obj.positions().len();
    let of_vertex = |numbers: &[f32]| match numbers.len() {
        found if found == lines => Ok(model.weld().first().iter().map(|&v| numbers[v as usize]).collect()),
        found => Err(SceneError::ScalarCount { found, expected: lines }),
    };
    let vertex_normals = vertex_normals(surface, FaceWeight::Angle);
    let tangents = match (extras.tangents, model.atlas()) {
        (Frames::MikkTSpace, Ok(atlas)) => {
            let normals: Vec<Vec3> = vertex_normals.iter().map(DVec3::as_vec3).collect();
            Some(tangents::tangents(surface, &atlas, &normals))
        }
        _ => None,
    };
    let file_normals = obj.normals().iter().map(|n| n.normalize_or_zero());
    let first_file_normal = topology.vertex_count() as u32;
    let usable = |n: &u32| obj.normals()[*n as usize].try_normalize().is_some();

    let triangle = |&corners: &[u32; 3]| {
        let positions = corners.map(|c| topology.vertex(c));
        let normal = |c: u32| match model.source_corner(c).normal().filter(usable) {
            Some(n) => first_file_normal + n,
            None => topology.vertex(c),
        };
        let uvs = corners.map(|c| model.source_corner(c).uv().filter(|uv| obj.uvs()[*uv as usize].is_finite()));
        let uvs = if let [Some(a), Some(b), Some(c)] = uvs { Some([a, b, c]) } else { None };
        Triangle { positions, normals: corners.map(normal), uvs }
    };
    let centre = middle(surface.triangles().flatten().map(|v| surface.positions()[v as usize]));
    let mut mesh = Mesh {
        positions: surface.positions().iter().map(|p| (p - centre).as_vec3()).collect(),
        normals: vertex_normals.iter().copied().chain(file_normals).map(|n: DVec3| n.as_vec3()).collect(),
        uvs: obj.uvs().iter().map(|uv| uv.as_vec2()).collect(),
        triangles: surface.triangle_corners().iter().map(triangle).collect(),
        scalars: extras.scalars.map(of_vertex).transpose()?,
        tangents,
        groups: Vec::new(),
    };
    if let Textures::ByMaterial(textures) = extras.textures {
        group(&mut mesh, model, textures);
    }
    Scene::new(mesh)
}

/// Sorts triangles by texture; those of one texture keep the order of the file.
fn group(mesh: &mut Mesh, model: &Model, textures: &[Option<usize>]) {
    let texture = |corner: u32| {
        let face = model.source_face(model.surface().topology().face(corner));
        let material = model.obj().face_material(face).map_or(textures.len().saturating_sub(1), |m| m as usize);
        textures.get(material).copied().flatten()
    };
    let of_triangles: Vec<Option<usize>> =
        model.surface().triangle_corners().iter().map(|corners| texture(corners[0])).collect();
    let mut order: Vec<usize> = (0..of_triangles.len()).collect();
    order.sort_by_key(|&t| of_triangles[t]);
    mesh.triangles = order.iter().map(|&t| mesh.triangles[t]).collect();
    mesh.tangents = mesh.tangents.as_ref().map(|tangents| order.iter().map(|&t| tangents[t]).collect());
    let mut end = 0;
    for same in order.chunk_by(|&a, &b| of_triangles[a] == of_triangles[b]) {
        mesh.groups.push(Group { triangles: end..end + same.len(), texture: of_triangles[same[0]] });
        end += same.len();
    }
}

/// Middle of the box about some points; f32 is finest near the origin.
fn middle(mut points: impl Iterator<Item = DVec3>) -> DVec3 {
    let Some(first) = points.next() else { return DVec3::ZERO };
    let (low, high) = points.fold((first, first), |(low, high), p| (low.min(p), high.max(p)));
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use planish_geometry::obj::Obj;
    use planish_geometry::weld::Welding;

    fn model(text: &str) -> Model {
        Model::new(Obj::parse(text.as_bytes().to_vec()).unwrap(), Welding::Exact)
    }

    /// A square far from the origin, cut along a diagonal; one `v` line is written twice and one is not used.
    const SQUARE: &str = "v 1e7 0 0\nv 1e7 1 0\nv 1e7 1 1\nv 1e7 0 1\nv 1e7 1 1\nv 0 0 0\n\
        vt 0 0\nvt 1 0\nvt 1 1\nvt nan 0\nvn 0 0 3\nvn 0 0 0\n\
        f 1/1/1 2/2/2 3/3\nf 1/1 5/3 4/4\n";

    #[test]
    fn welded_recentred_and_with_what_each_corner_names() {
        let scene = scene(&model(SQUARE), Extras::default()).unwrap();
        let Mesh { positions, normals, uvs, triangles, .. } = scene.mesh();
        assert_eq!(scene.bounds().centre, Vec3::ZERO);
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
        let given = |numbers| scene(&model(SQUARE), Extras { scalars: Some(numbers), ..Extras::default() });
        let drawn = given(&numbers[..]).unwrap();
        assert_eq!(drawn.mesh().scalars.as_deref(), Some(&[0.0, 1.0, 2.0, 3.0, 5.0][..]));
        let short = given(&numbers[1..]).unwrap_err();
        assert_eq!(short, SceneError::ScalarCount { found: 5, expected: 6 });
    }
}
