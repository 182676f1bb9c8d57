//! Measures the files of an earlier bake again.

use super::fill;
use super::normal_maps::Frames;
use super::offsets::Offsets;
use super::report::{self, Verification};
use super::{BakeError, BakeTarget, pages};
use crate::map::Coverage;
use crate::map::displace;
use crate::map::displacement::MapKind;
use crate::map::layout_issues::LayoutIssues;
use crate::map::manifest::{Layout, Manifest, Report, UvSource};
use crate::map::map_size::Spacing;
use crate::mesh::atlas::AtlasError;
use crate::mesh::jagged::Index;
use crate::mesh::weld::Welding;
use crate::progress::Progress;
use crate::source::MeshData;
use crate::source::model::Model;
use glam::Vec2;

/// Files of a bundle, as read from disk.
#[derive(Clone, Copy, Debug)]
pub struct WrittenFiles<'a> {
    /// Bytes of the displacement map's image file, or of those of its pages in their order.
    pub displacement: &'a [&'a [u8]],
    /// Mesh in the carrier OBJ.
    pub carrier: &'a MeshData,
}

/// Measures the files of an earlier bake and returns the report that their manifest should have. `target` is the target
/// of that bake, made from the method in the manifest.
///
/// # Errors
/// If the map cannot be decoded, if the carrier belongs to another mesh, or if the caller cancels; see [`BakeError`].
pub fn check(
    model: &Model,
    manifest: &Manifest,
    target: &BakeTarget,
    files: WrittenFiles,
    progress: &dyn Progress,
) -> Result<Report, BakeError> {
    progress.stage("layout");
    let entry = &manifest.displacement;
    displace::check_mesh(files.carrier, manifest).map_err(BakeError::OtherCarrier)?;
    let unwrapped =
        (entry.uvs == UvSource::Unwrapped).then(|| with_uvs_of(model, files.carrier, manifest.welding)).transpose()?;
    let model = unwrapped.as_ref().unwrap_or(model);
    displace::check_mesh(model.data(), manifest)?;
    let displacements = target.displacements(model, entry.map, Some(manifest.normals), progress)?;
    let both = model.with_backs(manifest.backs.indices().collect());
    let (model, displacements) = match &both {
        Some(both) => (&both.model, displacements.on_both(both)),
        None => (model, displacements),
    };
    let atlas = match model.atlas_in(entry.tile) {
        Err(AtlasError::NoUvs) if entry.layout == Layout::Vertex => None,
        atlas => Some(atlas?),
    };
    let mut frames = Vec::new();
    if entry.map == MapKind::VectorTangent {
        let atlas = atlas.as_ref().ok_or(BakeError::NoTangents)?;
        frames = Frames::new(model, atlas, &displacements.normals).of_vertices;
    }
    let offsets = Offsets::new(model, entry.map, &displacements, &frames);
    let pages = pages::of_manifest(model, manifest)?;
    if files.displacement.len() != manifest.page_entries().len().max(1) {
        return Err(BakeError::OtherPages);
    }
    let findings = match (&atlas, &pages, entry.layout) {
        (Some(atlas), Some(pages), Layout::Uv) => pages::issues(model, atlas, pages, manifest, progress)?,
        (Some(atlas), None, Layout::Uv) => {
            let coverage = Coverage::new(model.surface(), atlas, entry.size(), progress)?;
            LayoutIssues::of(model.surface(), atlas, &Spacing::new(atlas), &coverage)
        }
        _ => {
            let pages = manifest.page_entries().iter().map(|page| page.size().texels());
            let texels = if pages.len() == 0 { entry.size().texels() } else { pages.sum() };
            LayoutIssues { coverage: fill::texel_usage(model, texels), ..LayoutIssues::default() }
        }
    };
    progress.stage("verifying");
    let verification = Verification {
        model,
        displacements: &displacements,
        frames: &frames,
        offsets: &offsets,
        findings,
        pages: pages.as_ref(),
        channels: Vec::new(),
        images: files.displacement.to_vec(),
        carrier: files.carrier,
    };
    report::measure(&verification, manifest)
}

/// The model with the texture coordinates of its carrier, whose faces must be the same.
fn with_uvs_of(model: &Model, carrier: &MeshData, welding: Welding) -> Result<Model, BakeError> {
    let (own, of_carrier) = (model.data().faces(), carrier.faces());
    let same = own.len() == of_carrier.len() && own.iter().zip(of_carrier.iter()).all(|(f, g)| f.len() == g.len());
    let corners: Option<Vec<Index>> = of_carrier.items().iter().map(|corner| corner.uv()).collect();
    let corners = corners.filter(|_| same).ok_or(BakeError::OtherFaces)?;
    let uvs: Vec<Vec2> = carrier.uvs().iter().map(|uv| uv.as_vec2()).collect();
    Ok(Model::new(model.source().with_uvs(&uvs, &corners)?, welding))
}
