//! From the files of a bake to what a scene carries.

use crate::scene::Carried;
use glam::{DVec3, Vec3};
use planish_geometry::apply::{self, Places, ShaderVertex};
use planish_geometry::atlas::AtlasError;
use planish_geometry::bundle::{self, Goal};
use planish_geometry::displacement::{DecodeError, Displacement, MapKind};
use planish_geometry::manifest::{self, Manifest, Method};
use planish_geometry::model::{Model, NoFileNormals};
use planish_geometry::normals;
use planish_geometry::obj::Obj;
use planish_geometry::progress::{Cancelled, Progress};
use planish_geometry::texture::tangents;
use planish_geometry::weld::Welding;
use thiserror::Error;

/// Why a mesh does not carry a map.
#[derive(Debug, Error)]
pub enum BakedError {
    /// The manifest is that of another mesh.
    #[error(
        "is not the mesh that the map belongs to: neither {source_file} nor its carrier {carrier_file}, byte for byte"
    )]
    ForeignMesh {
        /// Of the manifest.
        source_file: String,
        /// Of the manifest.
        carrier_file: String,
    },
    /// The manifest names a vertex or a texture coordinate that the mesh has not.
    #[error("field `dominant_uv.seam_vertices` of the manifest: the mesh has no vertex {vertex} or no `vt` {uv}")]
    NoSuchPlace {
        /// `v` line, from 1.
        vertex: u32,
        /// `vt` line, from 1.
        uv: u32,
    },
    /// The image cannot be read.
    #[error(transparent)]
    Image(#[from] DecodeError),
    /// The normals that the map displaces along are not there.
    #[error(transparent)]
    Normals(#[from] NoFileNormals),
    /// Vectors in tangent space need texture coordinates.
    #[error(transparent)]
    Atlas(#[from] AtlasError),
}

/// Which of a bake's two meshes this is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Role {
    Source,
    Carrier,
}

fn role(obj: &Obj, manifest: &Manifest) -> Result<Role, BakedError> {
    let digest = manifest::sha256(obj.bytes());
    if digest == manifest.source.sha256 {
        Ok(Role::Source)
    } else if digest == manifest.carrier.sha256 {
        Ok(Role::Carrier)
    } else {
        let (source_file, carrier_file) = (manifest.source.file.clone(), manifest.carrier.obj.clone());
        Err(BakedError::ForeignMesh { source_file, carrier_file })
    }
}

/// How the `v` lines of this mesh become vertices: as in the bake.
pub fn welding(obj: &Obj, manifest: &Manifest) -> Result<Welding, BakedError> {
    Ok(match (role(obj, manifest)?, manifest.welding) {
        // A carrier has its vertices where welding put them.
        (Role::Carrier, Welding::Epsilon(_)) => Welding::Exact,
        (_, welding) => welding,
    })
}

/// The map of a manifest on its source or its carrier. `displacement` are the bytes of the image, the model was welded as
/// [`welding`] says.
pub fn carried(model: &Model, manifest: &Manifest, displacement: &[u8]) -> Result<Carried, BakedError> {
    let (obj, entry) = (model.obj(), &manifest.displacement);
    let role = role(obj, manifest)?;
    let map = Displacement::decode(displacement, entry.map, entry.size(), entry.encoding())?;
    let dominant = manifest.dominant_pairs();
    let stray = |&&[v, vt]: &&[u32; 2]| v as usize >= obj.positions().len() || vt as usize >= obj.uvs().len();
    if let Some(&[v, vt]) = dominant.iter().find(stray) {
        return Err(BakedError::NoSuchPlace { vertex: v + 1, uv: vt + 1 });
    }
    let places = Places::new(entry.layout, &dominant);
    let first = model.weld().first();
    let normals: Vec<Vec3> = match role {
        Role::Source => bundle::displacement_normals(model, manifest.normals)?,
        Role::Carrier => {
            let of_lines = apply::carrier_vertices(obj, places, entry.origin);
            first.iter().map(|&line| of_lines[line as usize].normal).collect()
        }
    };
    let of_lines = apply::source_vertices(obj, &model.weld().spread(&normals), places, entry.origin);
    let mut vertices: Vec<ShaderVertex> = first.iter().map(|&line| of_lines[line as usize]).collect();
    if entry.map == MapKind::VectorTangent {
        let atlas = model.atlas()?;
        let of_corners = tangents::tangents(model.surface(), &atlas, &normals);
        let frames = tangents::at_vertices(model.surface(), &atlas, &normals, &of_corners);
        for (vertex, frame) in vertices.iter_mut().zip(frames) {
            vertex.tangent = frame;
        }
    }
    Ok(Carried { map, vertices, errors: None })
}

/// How far the map leaves each vertex (#V) off the place where the method of the manifest wants it at λ = 1, model units;
/// none if the method is not one that can be computed again.
pub fn errors(
    model: &Model,
    manifest: &Manifest,
    carried: &Carried,
    progress: &dyn Progress,
) -> Result<Option<Vec<f32>>, Cancelled> {
    let Method::Denoiser(denoiser) = &manifest.method else { return Ok(None) };
    let deltas = Goal::Denoiser(denoiser.clone()).deltas(model.surface(), progress)?;
    let normals: Vec<Vec3> = carried.vertices.iter().map(|v| v.normal).collect();
    let held: Vec<DVec3> = match manifest.displacement.map {
        MapKind::Scalar => {
            let heights = normals::heights(&deltas, &normals);
            heights.iter().zip(&normals).map(|(h, n)| *h * n.as_dvec3()).collect()
        }
        MapKind::VectorObject | MapKind::VectorTangent => deltas,
    };
    let origin = manifest.displacement.origin;
    let error = |((position, held), vertex): ((&DVec3, &DVec3), &ShaderVertex)| {
        let place = vertex.displaced(&carried.map, 1.0).as_dvec3() + origin;
        place.distance(*position - *held) as f32
    };
    Ok(Some(model.surface().positions().iter().zip(&held).zip(&carried.vertices).map(error).collect()))
}
