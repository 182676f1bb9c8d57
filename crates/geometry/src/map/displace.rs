//! Displacement of vertices by a map, p' = p − λ · height · n, in single precision: the twin in Rust of the vertex shader.
//!
//! ```
//! use glam::Vec3;
//! use planish_geometry::map::displace::ShaderVertex;
//! use planish_geometry::map::displacement::{Displacement, Encoding, MapKind, SampleAt, TexelFormat};
//! use planish_geometry::map::per_vertex;
//!
//! // A map of two texels that lower their vertices by 1 and by 3.
//! let encoding = Encoding::covering(1.0, 3.0, TexelFormat::Png16);
//! let map = Displacement::encode(&[per_vertex::bake(&[1.0, 3.0], &[0, 1])], MapKind::Scalar, encoding);
//! let vertex = ShaderVertex { normal: Vec3::Z, sample_at: Some(SampleAt::Texel(1)), ..ShaderVertex::default() };
//! assert_eq!(vertex.displaced(&map, 0.0), Vec3::ZERO);
//! assert_eq!(vertex.displaced(&map, 0.5), Vec3::new(0.0, 0.0, -1.5));
//! ```

use crate::denoise::NormalField;
use crate::map::displacement::{Displacement, MapKind, PageSample, SampleAt, Weights};
use crate::map::manifest::{self, Layout, Manifest, PageEntry, UvSource};
use crate::map::tangents::{self, Tangent};
use crate::mesh::atlas::{self, AtlasError};
use crate::mesh::jagged::Index;
use crate::mesh::weld::Welding;
use crate::source::model::{Model, NoFileNormals};
use crate::source::obj::Obj;
use crate::source::{MeshData, Source};
use glam::{DVec3, IVec2, Vec3};
use rayon::prelude::*;

/// Distance from the origin, in diagonals of the bounds, up to which single precision has digits enough for coordinates.
const NEAR: f64 = 8.0;

/// Origin of positions in single precision, model units: zero, or the centre of the bounds if the mesh is so far from zero, in
/// UTM coordinates for example, that its detail would be rounded away.
pub fn origin([low, high]: [DVec3; 2]) -> DVec3 {
    let centre = (low + high) / 2.0;
    if centre.length() > NEAR * low.distance(high) { centre } else { DVec3::ZERO }
}

/// Attributes of a vertex that a shader reads.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ShaderVertex {
    /// Position relative to the origin, model units.
    pub position: Vec3,
    /// Unit normal; zero at a vertex without one.
    pub normal: Vec3,
    /// Tangent frame, which only maps of [`MapKind::VectorTangent`] need.
    pub tangent: Tangent,
    /// Position in the map that the vertex samples; `None` if no face gives it texture coordinates.
    pub sample_at: Option<SampleAt>,
}

impl ShaderVertex {
    /// Displaced position, relative to the origin, model units. A vertex without a sample stays.
    pub fn displaced(&self, map: &Displacement, lambda: f32) -> Vec3 {
        self.displaced_with(map, lambda, Weights::Exact)
    }

    /// Height that the map gives the vertex, or the length of its vector, model units; zero for a vertex without a sample.
    pub fn height(&self, map: &Displacement) -> f32 {
        let Some(sample_at) = self.sample_at else { return 0.0 };
        match map.kind() {
            MapKind::Scalar => map.height_at(sample_at, Weights::Exact),
            MapKind::VectorObject | MapKind::VectorTangent => map.vector_at(sample_at, Weights::Exact).length(),
        }
    }

    /// Displaced position, relative to the origin, with weights of the given accuracy, model units.
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

/// Rule by which source vertices sample the map.
#[derive(Clone, Debug, PartialEq)]
pub enum SamplingRule {
    /// A source vertex samples at a texture coordinate, unless it has a private texel.
    Uv {
        /// Ascending pairs of the indices of a source vertex and of the texture coordinate at which it samples. Others sample at the
        /// texture coordinate of their first corner.
        dominant: Vec<[Index; 2]>,
        /// Ascending pairs of the indices of a source vertex and of its private texel, counted row by row from the top.
        private: Vec<[Index; 2]>,
        /// Lower left corner of the tile of the texture coordinates, which is subtracted from them.
        tile: IVec2,
    },
    /// The i-th source vertex reads the i-th texel.
    PerVertex,
    /// The i-th source vertex reads the i-th texel of a map that was gathered from pages ([`Displacement::gathered`]), if the list
    /// says that it samples a page. #v
    Gathered(Vec<bool>),
}

impl SamplingRule {
    /// Rule of a manifest.
    pub fn of(manifest: &Manifest) -> Self {
        if let Some(pages) = &manifest.pages {
            let mut samples = vec![false; manifest.source.vertices];
            pages.maps.iter().flat_map(|page| page.vertices.indices()).for_each(|v| samples[v as usize] = true);
            return Self::Gathered(samples);
        }
        match manifest.displacement.layout {
            Layout::Uv => Self::Uv {
                dominant: manifest.dominant_pairs(),
                private: manifest.private_pairs(),
                tile: manifest.displacement.tile,
            },
            Layout::Vertex => Self::PerVertex,
        }
    }
}

/// Builds the vertices of a carrier, one for each source vertex (#v), with the normals that its corners name.
pub fn carrier_vertices(carrier: &MeshData, rule: &SamplingRule, origin: DVec3) -> Vec<ShaderVertex> {
    let vertex = |p: &DVec3| ShaderVertex { position: (*p - origin).as_vec3(), ..ShaderVertex::default() };
    let mut vertices: Vec<ShaderVertex> = carrier.positions().iter().map(vertex).collect();
    let tile = if let SamplingRule::Uv { tile, .. } = rule { *tile } else { IVec2::ZERO };
    let uv = |vt: Index| SampleAt::Uv(atlas::in_tile(carrier.uvs()[vt as usize], tile));
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
        SamplingRule::Uv { dominant, private, .. } => {
            for &[v, vt] in dominant {
                vertices[v as usize].sample_at = Some(uv(vt));
            }
            for &[v, texel] in private {
                vertices[v as usize].sample_at = Some(SampleAt::Texel(texel));
            }
        }
        SamplingRule::PerVertex => {
            for (vertex, i) in vertices.iter_mut().zip(0..) {
                vertex.sample_at = Some(SampleAt::Texel(i));
            }
        }
        SamplingRule::Gathered(samples) => {
            for ((vertex, i), samples) in vertices.iter_mut().zip(0..).zip(samples) {
                vertex.sample_at = samples.then_some(SampleAt::Texel(i));
            }
        }
    }
    vertices
}

/// Place in one page at which each source vertex of a carrier, or of the mesh that was baked, samples; `None` for vertices without
/// texture coordinates or, in a mesh that was cut, without a texel in the page. Of vertices whose faces are all on other pages the place means nothing. #v
///
/// # Panics
/// If the page names an element that the mesh has not, which [`check_mesh`] finds.
pub fn samples_in_page(mesh: &MeshData, page: &PageEntry) -> Vec<Option<SampleAt>> {
    let uv = |vt: Index| SampleAt::Uv(page.part.uv_in_image(mesh.uvs()[vt as usize]));
    let mut samples = vec![None; mesh.positions().len()];
    if !page.texels.is_empty() {
        for (texel, v) in (0..).zip(page.texels.indices()) {
            samples[v as usize] = Some(SampleAt::Texel(texel));
        }
        return samples;
    }
    for corner in mesh.faces().items() {
        let sample = &mut samples[corner.position as usize];
        if sample.is_none() {
            *sample = corner.uv().map(uv);
        }
    }
    for [v, vt] in page.seam_vertices.iter().map(|pair| pair.map(|i| i - 1)) {
        samples[v as usize] = Some(uv(vt));
    }
    for texel in &page.private_texels {
        samples[texel.vertex as usize - 1] = Some(SampleAt::Texel(texel.row * page.width + texel.column));
    }
    samples
}

/// Page and place in it that each source vertex of a carrier, or of the mesh that was baked, samples; `None` for vertices that stay. #v
///
/// # Panics
/// If the manifest names an element that the mesh has not, which [`check_mesh`] finds.
pub fn page_samples(mesh: &MeshData, manifest: &Manifest) -> Vec<Option<PageSample>> {
    let mut samples = vec![None; mesh.positions().len()];
    for (page, entry) in (0..).zip(manifest.page_entries()) {
        let in_page = samples_in_page(mesh, entry);
        for v in entry.vertices.indices() {
            samples[v as usize] = in_page[v as usize].map(|at| PageSample { page, at });
        }
    }
    samples
}

/// Gathers the texels of pages that the vertices of a mesh sample, and makes the vertices (#v), which [`carrier_vertices`] or one of its
/// kin built, read them.
///
/// # Panics
/// As [`page_samples`] does, or if there are fewer images than pages.
pub fn gather(
    images: &[Displacement],
    mesh: &MeshData,
    manifest: &Manifest,
    vertices: &mut [ShaderVertex],
) -> Displacement {
    let samples = page_samples(mesh, manifest);
    for (vertex, sample) in vertices.iter_mut().zip(&samples) {
        // A manifest may name a vertex that has no texture coordinates.
        vertex.sample_at = vertex.sample_at.filter(|_| sample.is_some());
    }
    Displacement::gathered(images, &samples, Weights::Exact)
}

/// Builds the vertices of the mesh that was baked, one for each source vertex (#v), with these unit normals (#v×3), because
/// the map does not displace along the normals of the file.
pub fn source_vertices(source: &MeshData, normals: &[Vec3], rule: &SamplingRule, origin: DVec3) -> Vec<ShaderVertex> {
    let mut vertices = carrier_vertices(source, rule, origin);
    for (vertex, normal) in vertices.iter_mut().zip(normals) {
        vertex.normal = *normal;
    }
    vertices
}

/// Reasons why a mesh cannot be displaced by a map.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// The mesh is neither the one that was baked nor the carrier, byte for byte.
    #[error("is neither the mesh that was baked nor its carrier, byte for byte")]
    Foreign,
    /// The map uses texture coordinates that the bake made and only the carrier has.
    #[error("lacks the texture coordinates of the map, which the carrier has")]
    NeedsCarrier,
    /// The map displaces along normals that only the carrier has, and the carrier is missing or has changed.
    #[error("is displaced along the normals of the carrier, which is missing or has changed since the bake")]
    NeedsCarrierNormals,
    /// The mesh has another number of source vertices than the manifest says.
    #[error("has {found} vertices, and the manifest says {expected}")]
    Vertices {
        /// Number of source vertices of the mesh.
        found: usize,
        /// Number of source vertices in the manifest.
        expected: usize,
    },
    /// The manifest names a vertex or a texture coordinate that does not exist.
    #[error("there is no vertex {vertex} or no `vt` {uv} (counted from 0)")]
    NoSuchElement {
        /// Index of the source vertex, from 0.
        vertex: Index,
        /// Index of the texture coordinate, from 0.
        uv: Index,
    },
    /// A page of the manifest names a vertex or a texture coordinate that does not exist.
    #[error("page {page}: there is no vertex {vertex} or no `vt` {uv} (counted from 0)")]
    NoSuchInPage {
        /// Name of the page.
        page: String,
        /// Index of the source vertex, from 0.
        vertex: Index,
        /// Index of the texture coordinate, from 0.
        uv: Index,
    },
    /// The mesh lacks the normals that the map displaces along.
    #[error(transparent)]
    Normals(#[from] NoFileNormals),
    /// The mesh lacks the texture coordinates that tangent frames need.
    #[error(transparent)]
    Atlas(#[from] AtlasError),
}

/// Checks that a mesh, which is that of the manifest or its carrier, has every element that the manifest counts or names. Whatever
/// indexes a mesh by numbers of a manifest calls this first, because equal checksums do not make a manifest honest.
pub fn check_mesh(mesh: &MeshData, manifest: &Manifest) -> Result<(), MeshError> {
    let (found, expected) = (mesh.positions().len(), manifest.source.vertices);
    if found != expected {
        return Err(MeshError::Vertices { found, expected });
    }
    let named = |&&[v, vt]: &&[Index; 2]| (v as usize) < found && (vt as usize) < mesh.uvs().len();
    if let Some(&[vertex, uv]) = manifest.dominant_pairs().iter().find(|pair| !named(pair)) {
        return Err(MeshError::NoSuchElement { vertex, uv });
    }
    for page in manifest.page_entries() {
        let mut pairs = page.seam_vertices.iter().map(|pair| pair.map(|i| i - 1));
        if let Some([vertex, uv]) = pairs.find(|pair| !named(&pair)) {
            return Err(MeshError::NoSuchInPage { page: page.part.to_string(), vertex, uv });
        }
    }
    Ok(())
}

/// Builds the vertices, one for each source vertex (#v), of a carrier, or of the mesh that was baked, with the normals that
/// the bake used.
///
/// `carrier` is called if `mesh` is not the carrier but only the carrier has these normals.
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
    check_mesh(data, manifest)?;
    let rule = SamplingRule::of(manifest);
    let origin = manifest.displacement.origin;
    let needs_frames = manifest.displacement.map == MapKind::VectorTangent;
    if is_carrier && !needs_frames {
        return Ok(carrier_vertices(data, &rule, origin));
    }
    // Source vertices of a carrier that were welded are at the same position.
    let welding = match manifest.welding {
        Welding::Epsilon(_) if is_carrier => Welding::Exact,
        welding => welding,
    };
    let one_sided = Model::new(mesh.clone(), welding);
    let both = one_sided.with_backs(manifest.backs.indices().collect());
    let model = both.as_ref().map_or(&one_sided, |both| &both.model);
    let carrier_normals = |carrier: &MeshData| -> Vec<Vec3> {
        let vertices = carrier_vertices(carrier, &rule, origin);
        model.weld().first().iter().map(|&v| vertices[v as usize].normal).collect()
    };
    let normals = if is_carrier {
        carrier_normals(data)
    } else {
        match manifest.normals {
            NormalField::Source(source) => {
                let normals = one_sided.displacement_normals(source)?;
                both.as_ref().map_or_else(|| normals.clone(), |both| both.turned(&normals))
            }
            NormalField::Denoised | NormalField::Tilted => {
                // The alternative would be to denoise once more.
                let carrier = carrier().filter(|carrier| manifest::sha256(carrier.bytes()) == manifest.carrier.sha256);
                let carrier = carrier.ok_or(MeshError::NeedsCarrierNormals)?;
                check_mesh(carrier.data(), manifest)?;
                carrier_normals(carrier.data())
            }
        }
    };
    let mut frames = Vec::new();
    if needs_frames {
        let atlas = model.atlas_in(manifest.displacement.tile)?;
        let corner_frames = tangents::tangents(model.surface(), &atlas, &normals);
        frames = tangents::at_vertices(model.surface(), &atlas, &normals, &corner_frames);
    }
    let weld = model.weld();
    let frames = if needs_frames { weld.spread(&frames) } else { frames };
    Ok(model_vertices(model, &DisplacementDirections { normals: weld.spread(&normals), frames }, manifest))
}

/// Directions along which a map displaces the source vertices of a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DisplacementDirections {
    /// Unit normals; zero at vertices without one. #v×3
    pub normals: Vec<Vec3>,
    /// Tangent frames (#v) for a map of [`MapKind::VectorTangent`]; empty for others.
    pub frames: Vec<Tangent>,
}

/// Builds the vertices of a mesh that was just baked, one for each source vertex (#v), with the directions of the bake. They
/// equal those that [`baked_vertices`] finds out from the files, at a fraction of the cost.
pub fn model_vertices(model: &Model, directions: &DisplacementDirections, manifest: &Manifest) -> Vec<ShaderVertex> {
    let rule = SamplingRule::of(manifest);
    let mut vertices = source_vertices(model.data(), &directions.normals, &rule, manifest.displacement.origin);
    for (vertex, frame) in vertices.iter_mut().zip(&directions.frames) {
        vertex.tangent = *frame;
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
