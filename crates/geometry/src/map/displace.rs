//! The vertex shader's Rust twin: p' = p − λ · height · n, in single precision.

use crate::denoise::NormalField;
use crate::map::displacement::{Displacement, MapKind, SampleAt, Weights};
use crate::map::manifest::{self, Layout, Manifest, UvSource};
use crate::map::tangents::{self, Tangent};
use crate::mesh::atlas::AtlasError;
use crate::mesh::jagged::Index;
use crate::mesh::weld::Welding;
use crate::source::model::{Model, NoFileNormals};
use crate::source::obj::Obj;
use crate::source::{MeshData, Source};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Below this many diagonals from the origin coordinates keep enough digits in single precision.
const NEAR: f64 = 8.0;

/// What is subtracted from positions before they go to single precision: nothing, or the centre of the bounds where
/// the mesh lies so far out (UTM coordinates, say) that its detail would be rounded away. Model units.
pub fn origin([low, high]: [DVec3; 2]) -> DVec3 {
    let centre = (low + high) / 2.0;
    if centre.length() > NEAR * low.distance(high) { centre } else { DVec3::ZERO }
}

/// A vertex as a shader gets it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ShaderVertex {
    /// Relative to the origin, model units.
    pub position: Vec3,
    /// Unit, or zero where there is none.
    pub normal: Vec3,
    /// Only maps of [`MapKind::VectorTangent`] need it.
    pub tangent: Tangent,
    /// Where it samples the map; none where no face gives it texture coordinates.
    pub sample_at: Option<SampleAt>,
}

impl ShaderVertex {
    /// The displaced position, relative to the origin. A vertex that samples nowhere stays.
    pub fn displaced(&self, map: &Displacement, lambda: f32) -> Vec3 {
        self.displaced_with(map, lambda, Weights::Exact)
    }

    /// What the map says here, model units: the height, or the length of the vector; zero for a vertex that samples
    /// nowhere.
    pub fn height(&self, map: &Displacement) -> f32 {
        let Some(sample_at) = self.sample_at else { return 0.0 };
        match map.kind() {
            MapKind::Scalar => map.height_at(sample_at, Weights::Exact),
            MapKind::VectorObject | MapKind::VectorTangent => map.vector_at(sample_at, Weights::Exact).length(),
        }
    }

    /// The displaced position with other weights.
    pub fn displaced_with(&self, map: &Displacement, lambda: f32, weights: Weights) -> Vec3 {
        let Some(sample_at) = self.sample_at else { return self.position };
        match map.kind() {
            MapKind::Scalar => self.position - self.normal * (lambda * map.height_at(sample_at, weights)),
            MapKind::VectorObject => self.position - map.vector_at(sample_at, weights) * lambda,
            MapKind::VectorTangent => {
                let [t, b, n] = self.tangent.frame(self.normal);
                let v = map.vector_at(sample_at, weights) * lambda;
                self.position - (t * v.x + b * v.y + n * v.z)
            }
        }
    }
}

/// Where source vertices sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SamplingRule<'a> {
    /// At texture coordinates: those in this list (pairs of indices of a source vertex and of texture coordinates, ascending), or else those that
    /// the first corner names.
    Uv(&'a [[Index; 2]]),
    /// The i-th source vertex in the i-th texel.
    PerVertex,
}

impl<'a> SamplingRule<'a> {
    /// Those of a layout, of which some need the list.
    pub fn new(layout: Layout, dominant: &'a [[Index; 2]]) -> Self {
        match layout {
            Layout::Uv => Self::Uv(dominant),
            Layout::Vertex => Self::PerVertex,
        }
    }
}

/// Vertices of a carrier, one for each source vertex: its normal is the one its corners name.
pub fn carrier_vertices(carrier: &MeshData, rule: SamplingRule, origin: DVec3) -> Vec<ShaderVertex> {
    let vertex = |p: &DVec3| ShaderVertex { position: (*p - origin).as_vec3(), ..ShaderVertex::default() };
    let mut vertices: Vec<ShaderVertex> = carrier.positions().iter().map(vertex).collect();
    let uv = |vt: Index| SampleAt::Uv(carrier.uvs()[vt as usize].as_vec2());
    for corner in carrier.faces().items() {
        let vertex = &mut vertices[corner.position as usize];
        if let Some(n) = corner.normal() {
            vertex.normal = carrier.normals()[n as usize].as_vec3();
        }
        if vertex.sample_at.is_none() {
            vertex.sample_at = corner.uv().map(uv);
        }
    }
    match rule {
        SamplingRule::Uv(dominant) => {
            for &[v, vt] in dominant {
                vertices[v as usize].sample_at = Some(uv(vt));
            }
        }
        SamplingRule::PerVertex => {
            for (vertex, i) in vertices.iter_mut().zip(0..) {
                vertex.sample_at = Some(SampleAt::Texel(i));
            }
        }
    }
    vertices
}

/// Vertices of the mesh that was baked, one for each source vertex. Its own normals are not what it is displaced along,
/// so normals (#v×3) are given.
pub fn source_vertices(source: &MeshData, normals: &[Vec3], rule: SamplingRule, origin: DVec3) -> Vec<ShaderVertex> {
    let mut vertices = carrier_vertices(source, rule, origin);
    for (vertex, normal) in vertices.iter_mut().zip(normals) {
        vertex.normal = *normal;
    }
    vertices
}

/// Why a mesh cannot be displaced by a map.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MeshError {
    /// It is neither what was baked nor the carrier, byte for byte.
    #[error("is neither the mesh that was baked nor its carrier, byte for byte")]
    Foreign,
    /// The map lies in texture coordinates that the bake made.
    #[error("lacks the texture coordinates of the map, which the carrier has")]
    NeedsCarrier,
    /// The map displaces along normals that only the carrier has, and that is not there as it was written.
    #[error("is displaced along the normals of the carrier, which is not there as it was written")]
    NeedsCarrierNormals,
    /// The manifest names an element that is not there; indices from 0.
    #[error("there is no vertex {vertex} or no `vt` {uv} (counted from 0)")]
    NoSuchElement {
        /// Index of the source vertex.
        vertex: Index,
        /// Index of the texture coordinates.
        uv: Index,
    },
    /// The normals that the map displaces along are not there.
    #[error(transparent)]
    Normals(#[from] NoFileNormals),
    /// The texture coordinates that tangent frames need are not there.
    #[error(transparent)]
    Atlas(#[from] AtlasError),
}

/// Vertices, one for each source vertex, of the carrier as it is, or of the mesh that was baked with the normals that the
/// bake used.
///
/// `carrier` is asked for where only the carrier has the normals that the map displaces along.
pub fn baked_vertices(
    mesh: &Source,
    manifest: &Manifest,
    carrier: &dyn Fn() -> Option<Obj>,
) -> Result<Vec<ShaderVertex>, MeshError> {
    let digest = manifest::sha256(&mesh.bytes());
    let is_carrier = digest == manifest.carrier.sha256;
    if !is_carrier && digest != manifest.source.sha256 {
        return Err(MeshError::Foreign);
    }
    if !is_carrier && manifest.displacement.uvs == UvSource::Unwrapped {
        return Err(MeshError::NeedsCarrier);
    }
    let data = mesh.data();
    let dominant = manifest.dominant_pairs();
    let named = |&&[v, vt]: &&[Index; 2]| (v as usize) < data.positions().len() && (vt as usize) < data.uvs().len();
    if let Some(&[vertex, uv]) = dominant.iter().find(|pair| !named(pair)) {
        return Err(MeshError::NoSuchElement { vertex, uv });
    }
    let rule = SamplingRule::new(manifest.displacement.layout, &dominant);
    let origin = manifest.displacement.origin;
    let needs_frames = manifest.displacement.map == MapKind::VectorTangent;
    if is_carrier && !needs_frames {
        return Ok(carrier_vertices(data, rule, origin));
    }
    // A carrier has its vertices where welding put them.
    let welding = match manifest.welding {
        Welding::Epsilon(_) if is_carrier => Welding::Exact,
        welding => welding,
    };
    let model = Model::new(mesh.clone(), welding);
    let of_carrier = |carrier: &MeshData| -> Vec<Vec3> {
        let vertices = carrier_vertices(carrier, rule, origin);
        model.weld().first().iter().map(|&v| vertices[v as usize].normal).collect()
    };
    let normals = if is_carrier {
        of_carrier(data)
    } else {
        match manifest.normals {
            NormalField::Source(source) => model.displacement_normals(source)?,
            NormalField::Denoised | NormalField::Tilted => {
                // Without it one would have to denoise once more.
                let carrier = carrier().filter(|carrier| manifest::sha256(carrier.bytes()) == manifest.carrier.sha256);
                of_carrier(carrier.ok_or(MeshError::NeedsCarrierNormals)?.data())
            }
        }
    };
    let mut frames = Vec::new();
    if needs_frames {
        let atlas = model.atlas()?;
        let of_corners = tangents::tangents(model.surface(), &atlas, &normals);
        frames = tangents::at_vertices(model.surface(), &atlas, &normals, &of_corners);
    }
    Ok(model_vertices(&model, &DisplacementDirections { normals, frames }, manifest))
}

/// Directions that a map displaces the vertices of a surface along.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DisplacementDirections {
    /// Unit normals; zero where a vertex has none. #V×3
    pub normals: Vec<Vec3>,
    /// Tangent frames, for maps of [`MapKind::VectorTangent`] only: other maps have an empty list. #V
    pub frames: Vec<Tangent>,
}

/// Vertices of the mesh that was just baked, one for each `v` line (#v), along the directions that the bake found: the
/// same as [`baked_vertices`] finds out from its files, at a fraction of the cost.
pub fn model_vertices(model: &Model, along: &DisplacementDirections, manifest: &Manifest) -> Vec<ShaderVertex> {
    let dominant = manifest.dominant_pairs();
    let rule = SamplingRule::new(manifest.displacement.layout, &dominant);
    let normals = model.weld().spread(&along.normals);
    let mut vertices = source_vertices(model.data(), &normals, rule, manifest.displacement.origin);
    if !along.frames.is_empty() {
        for (vertex, frame) in vertices.iter_mut().zip(model.weld().spread(&along.frames)) {
            vertex.tangent = frame;
        }
    }
    vertices
}

/// Displaced positions in the coordinates of the source. #v×3, model units
pub fn displaced(vertices: &[ShaderVertex], map: &Displacement, lambda: f32, origin: DVec3) -> Vec<DVec3> {
    vertices.par_iter().map(|v| v.displaced(map, lambda).as_dvec3() + origin).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_far_meshes_are_recentred() {
        assert_eq!(origin([DVec3::splat(-1.0), DVec3::splat(3.0)]), DVec3::ZERO);
        let far = DVec3::new(500_000.0, 4_500_000.0, 250.0);
        assert_eq!(origin([far - 1.0, far + 1.0]), far);
    }
}
