//! Measuring files that were written before.

use super::maps::{self, Offsets};
use super::report::{self, Evidence};
use super::{BakeError, Goal};
use crate::atlas::AtlasError;
use crate::displacement::MapKind;
use crate::manifest::{Layout, Manifest, Report, UvSource};
use crate::model::Model;
use crate::obj::Obj;
use crate::progress::Progress;
use crate::ragged::Index;
use crate::texture::findings::Findings;
use crate::texture::resolution::Spacing;
use crate::texture::{Coverage, tangents};
use crate::weld::Welding;
use glam::Vec2;

/// Measures written files once more: the report that their manifest should have.
///
/// `goal` is what the manifest's method says, `displacement` and `carrier` are the files that it names.
pub fn check(
    model: &Model,
    manifest: &Manifest,
    goal: &Goal,
    displacement: &[u8],
    carrier: &Obj,
    progress: &dyn Progress,
) -> Result<Report, BakeError> {
    progress.stage("layout");
    let entry = &manifest.displacement;
    let unwrapped =
        (entry.uvs == UvSource::Unwrapped).then(|| with_uvs_of(model, carrier, manifest.welding)).transpose()?;
    let model = unwrapped.as_ref().unwrap_or(model);
    let atlas = match model.atlas() {
        Err(AtlasError::NoUvs) if entry.layout == Layout::Vertex => None,
        atlas => Some(atlas?),
    };
    let ways = goal.ways(model, entry.map, Some(manifest.normals), progress)?;
    let mut frames = Vec::new();
    if entry.map == MapKind::VectorTangent {
        let atlas = atlas.as_ref().ok_or(BakeError::NoTangents)?;
        let of_corners = tangents::tangents(model.surface(), atlas, &ways.normals);
        frames = tangents::at_vertices(model.surface(), atlas, &ways.normals, &of_corners);
    }
    let offsets = Offsets::new(model, entry.map, &ways, &frames);
    let findings = match (&atlas, entry.layout) {
        (Some(atlas), Layout::Uv) => {
            let coverage = Coverage::new(model.surface(), atlas, entry.size(), progress)?;
            Findings::of(model.surface(), atlas, &Spacing::new(atlas), &coverage)
        }
        _ => Findings { coverage: maps::share(model, entry.size()), ..Findings::default() },
    };
    progress.stage("verifying");
    let evidence = Evidence {
        model,
        ways: &ways,
        frames: &frames,
        offsets: &offsets,
        findings,
        channels: &[],
        displacement,
        carrier,
    };
    Ok(report::measure(&evidence, manifest)?)
}

/// A mesh with the texture coordinates of its carrier.
fn with_uvs_of(model: &Model, carrier: &Obj, welding: Welding) -> Result<Model, BakeError> {
    let (own, of_carrier) = (model.obj().faces(), carrier.faces());
    let same = own.len() == of_carrier.len() && own.iter().zip(of_carrier.iter()).all(|(f, g)| f.len() == g.len());
    let corners: Option<Vec<Index>> = of_carrier.items().iter().map(|corner| corner.uv()).collect();
    let corners = corners.filter(|_| same).ok_or(BakeError::OtherFaces)?;
    let uvs: Vec<Vec2> = carrier.uvs().iter().map(|uv| uv.as_vec2()).collect();
    Ok(Model::new(Obj::parse(model.obj().with_uvs(&uvs, &corners))?, welding))
}
