//! Volumes of pictures: read from files, or computed from the mesh.

mod nrrd;
mod numbers;

use glam::{Affine3A, DAffine3, DVec3, Vec3};
use planish_files::failure::Failure;
use planish_files::input::{self, Trust};
use planish_geometry::mesh::signed_distance::{Grid, SignedDistance};
use planish_geometry::progress::Progress;
use planish_geometry::source::model::Model;
use planish_render::input::origin;
use planish_render::settings::Range;
use planish_render::settings::volume::{Placement, RawVolume, VolumeSource};
use planish_render::volume::Volume;
use std::path::Path;

/// Values of a file, and what it says about their position.
#[derive(Clone, Debug, PartialEq)]
struct VolumeFile {
    size: [u32; 3],
    /// The first axis is the fastest.
    values: Vec<f32>,
    /// Lengths of the sides of a voxel.
    spacing: DVec3,
    /// Model coordinates of a value from its indices; `None` where the file says nothing.
    model_from_index: Option<DAffine3>,
}

/// Reads or computes a volume in the coordinates of the scene of a model. Without a model, files lie where they say.
pub fn load(
    source: &VolumeSource,
    placement: Placement,
    model: Option<&Model>,
    trust: Trust,
    progress: &dyn Progress,
) -> Result<Volume, Failure> {
    progress.stage("volume");
    match source {
        VolumeSource::Distance { size } => {
            let none = || Failure::Input("the distance to a mesh needs a mesh".to_owned());
            distance(model.ok_or_else(none)?, *size, progress)
        }
        VolumeSource::File(path) => in_scene(nrrd::read(path, trust)?, path, placement, model),
        VolumeSource::Raw(raw) => in_scene(read_raw(raw)?, &raw.file, placement, model),
    }
}

/// Signed distance to the surface of a model, in model units, on a grid around it. Zero is the middle of the transfer function.
fn distance(model: &Model, size: u32, progress: &dyn Progress) -> Result<Volume, Failure> {
    let [low, high] = model.surface().bounds();
    let (size, corner, voxel) = Volume::grid_around(size, low, high);
    let grid = Grid { size, first: corner + 0.5 * voxel, step: voxel };
    let values = SignedDistance::new(model.surface()).on_grid(grid, progress)?;
    let world_from_texel = Affine3A::from_scale_rotation_translation(
        Vec3::splat(voxel as f32),
        glam::Quat::IDENTITY,
        (corner - origin(model)).as_vec3(),
    );
    let volume = Volume::new(size, values, world_from_texel)
        .map_err(|e| Failure::Input(format!("the distance to the mesh is no volume: {e}")))?;
    let Range { low, high } = volume.range();
    let most = low.abs().max(high.abs());
    Ok(volume.with_range(Range { low: -most, high: most }))
}

fn read_raw(raw: &RawVolume) -> Result<VolumeFile, Failure> {
    let bytes = input::read(&raw.file)?;
    let values = numbers::read(&bytes, raw.size, raw.sample, numbers::ByteOrder::Little);
    let values = values.map_err(|e| Failure::at(&raw.file, e))?;
    let spacing = DVec3::from(raw.spacing.map(f64::from));
    Ok(VolumeFile { size: raw.size, values, spacing, model_from_index: None })
}

/// Puts the values of a file into the scene of a model.
fn in_scene(file: VolumeFile, path: &Path, placement: Placement, model: Option<&Model>) -> Result<Volume, Failure> {
    let VolumeFile { size, values, spacing, model_from_index } = file;
    let origin = model.map_or(DVec3::ZERO, origin);
    let world_from_texel = match model_from_index.filter(|_| placement == Placement::File) {
        Some(model_from_index) => {
            // Indices name the middle of voxels.
            let model_from_texel = model_from_index * DAffine3::from_translation(DVec3::splat(-0.5));
            let matrix3 = model_from_texel.matrix3.as_mat3();
            Affine3A::from_mat3_translation(matrix3, (model_from_texel.translation - origin).as_vec3())
        }
        None => {
            let [low, high] = model.map_or([DVec3::ZERO; 2], |model| model.surface().bounds().map(|p| p - origin));
            Volume::fitted(size, (spacing / spacing.max_element()).as_vec3(), low.as_vec3(), high.as_vec3())
        }
    };
    Volume::new(size, values, world_from_texel).map_err(|e| Failure::at(path, e))
}

#[cfg(test)]
mod tests;
