//! Heights or vectors of the vertices of one tile, as a map will hold them.

use super::measure::surface_of;
use super::merge;
use super::part::Part;
use super::plan::{Plan, of_tile};
use super::records::{NumbersOut, positions_at, read_json, write_json};
use crate::failure::Failure;
use glam::{DVec3, Vec3};
use planish_geometry::map::displacement::{Encoding, MapKind, TexelFormat};
use planish_geometry::mesh::normals::{self, FaceWeight};
use planish_geometry::mesh::surface::Surface;
use planish_geometry::mesh::weld::Weld;
use planish_geometry::progress::Progress;
use planish_geometry::source::model::WeldedSurface;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// How a map of a mesh in tiles is made: decided once, for all tiles.
#[derive(Clone, Debug)]
pub struct MapJob {
    /// Name by which the caller knows the mesh, how it was denoised, and all settings of the map. What is made under this name is made
    /// of these.
    pub key: String,
    /// Kind of the map: heights, or vectors in object space.
    pub map: MapKind,
    /// File format and number of bits of a texel.
    pub texel: TexelFormat,
    /// Strength λ for client programs.
    pub lambda: f64,
}

/// Figures of the displacements of a tile; sums are over its vertices or faces.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct TileHeights {
    /// Lowest and highest number that the map holds, model units; infinite if there is none.
    pub(super) range: Option<[f32; 2]>,
    /// Number of vertices.
    pub(super) vertices: usize,
    /// Number of vertices of faces whose normals cancel.
    pub(super) without_normal: usize,
    /// Sum of the squared lengths of what heights leave out, square model units.
    pub(super) left_out: f64,
    /// Number of triangles.
    pub(super) triangles: usize,
    /// Sum of the angles by which denoising turns the triangles, degrees.
    pub(super) turned: f64,
    /// Sum of the angles between the triangles of the denoised surface and those that the map gives, degrees.
    pub(super) lost: f64,
}

/// Displacements of the vertices of a part, as a map holds them.
pub(super) struct Offsets {
    /// Angle-weighted normals, zero where there is none. #V×3
    pub(super) normals: Vec<Vec3>,
    /// Numbers of each vertex, one for each channel of the map. #V each, model units
    pub(super) channels: Vec<Vec<f64>>,
}

impl MapJob {
    /// Checks that a map of this kind can be had tile by tile.
    pub fn check(&self) -> Result<(), Failure> {
        if self.map == MapKind::VectorTangent {
            let reason = "a map in tangent space needs texture coordinates, and a map in tiles has none";
            return Err(Failure::Input(reason.to_owned()));
        }
        Ok(())
    }

    pub(super) fn file(&self, folder: &Path, tile: usize, what: &str) -> PathBuf {
        of_tile(folder, tile, &format!("{}.{what}", self.key))
    }

    /// Splits displacements into the channels of the map.
    fn offsets(&self, surface: &Surface, deltas: &[DVec3]) -> Offsets {
        let normals: Vec<Vec3> =
            normals::vertex_normals(surface, FaceWeight::Angle).into_iter().map(DVec3::as_vec3).collect();
        let channels = match self.map {
            MapKind::Scalar => vec![normals::heights(deltas, &normals)],
            _ => (0..3).map(|axis| deltas.iter().map(|delta| delta[axis]).collect()).collect(),
        };
        Offsets { normals, channels }
    }
}

impl Offsets {
    /// Displacement that the map gives a vertex, model units.
    pub(super) fn displacement(&self, v: usize) -> DVec3 {
        match self.channels.as_slice() {
            [heights] => heights[v] * self.normals[v].as_dvec3(),
            channels => DVec3::new(channels[0][v], channels[1][v], channels[2][v]),
        }
    }
}

/// Writes what the map holds for the vertices of a tile, given the denoised positions that [`merge`](super::merge()) or
/// [`take_positions`](super::take_positions) has written.
pub fn heights(folder: &Path, tile: usize, job: &MapJob, progress: &dyn Progress) -> Result<(), Failure> {
    let path = job.file(folder, tile, "heights.json");
    if path.exists() {
        return Ok(());
    }
    job.check()?;
    let plan = Plan::of(folder)?;
    // The normal of a vertex depends on the faces around it, and what is lost at a triangle on the normals of its vertices.
    let part = Part::read(folder, &plan, tile, 2, progress)?;
    let WeldedSurface { weld, surface, .. } = surface_of(&part, plan.welding);
    let after = positions_at(merge::positions(folder), &part.ids)?;
    let after: Vec<DVec3> = weld.first().iter().map(|&v| after[v as usize]).collect();
    let deltas: Vec<DVec3> = surface.positions().iter().zip(&after).map(|(p, q)| *p - *q).collect();
    let offsets = job.offsets(&surface, &deltas);
    if offsets.channels.iter().flatten().any(|x| !(*x as f32).is_finite()) {
        return Err(Failure::Input("displacements do not fit into single precision; scale the mesh".to_owned()));
    }
    let figures = figures(&surface, &weld, &part, &after, &offsets);
    let mut out = NumbersOut::create(job.file(folder, tile, "heights"))?;
    for (source, (id, _)) in part.ids.iter().zip(&part.rings).enumerate().filter(|(_, (_, ring))| **ring == 0) {
        let v = weld.vertex_of()[source] as usize;
        out.index(*id)?;
        offsets.normals[v].to_array().into_iter().try_for_each(|x| out.index(x.to_bits()))?;
        offsets.channels.iter().try_for_each(|channel| out.number(channel[v]))?;
    }
    out.finish()?;
    write_json(&path, &figures)
}

fn figures(surface: &Surface, weld: &Weld, part: &Part, after: &[DVec3], offsets: &Offsets) -> TileHeights {
    let is_own = |v: usize| part.rings[weld.first()[v] as usize] == 0;
    let own = || (0..after.len()).filter(|v| is_own(*v));
    let before = surface.positions();
    let map: Vec<DVec3> = (0..after.len()).map(|v| before[v] - offsets.displacement(v)).collect();
    let of_vertex = |v: usize| offsets.channels.iter().map(move |channel| channel[v] as f32);
    let join = |range: Option<[f32; 2]>, x: f32| Some(range.map_or([x, x], |[low, high]| [low.min(x), high.max(x)]));
    let normal = |t: [u32; 3], points: &[DVec3]| {
        let [a, b, c] = t.map(|v| points[v as usize]);
        (b - a).cross(c - a).normalize_or_zero()
    };
    let angle = |a: DVec3, b: DVec3| a.cross(b).length().atan2(a.dot(b)).to_degrees();
    // Each triangle is in the tile of its first vertex.
    let triangles: Vec<[u32; 3]> = surface.triangles().filter(|t| is_own(t[0] as usize)).collect();
    let angles = |points: &[DVec3]| triangles.iter().map(|t| angle(normal(*t, points), normal(*t, after))).sum();
    TileHeights {
        range: own().flat_map(of_vertex).fold(None, join),
        vertices: own().count(),
        without_normal: own()
            .filter(|v| offsets.normals[*v] == Vec3::ZERO && !surface.topology().is_isolated(*v as u32))
            .count(),
        left_out: own().map(|v| map[v].distance_squared(after[v])).sum(),
        triangles: triangles.len(),
        turned: angles(before),
        lost: angles(&map),
    }
}

/// Decides on the bias and scale of all pages of a map, when [`heights`] is done for all tiles.
pub(super) fn encoding(folder: &Path, job: &MapJob) -> Result<Encoding, Failure> {
    let tiles = Plan::of(folder)?.tiles.len();
    let mut range = [f32::INFINITY, f32::NEG_INFINITY];
    for tile in 0..tiles {
        let figures: TileHeights = read_json(&job.file(folder, tile, "heights.json"))?;
        if let Some([low, high]) = figures.range {
            range = [range[0].min(low), range[1].max(high)];
        }
    }
    let [low, high] = if range[0] <= range[1] { range } else { [0.0; 2] };
    Ok(Encoding::covering(low.into(), high.into(), job.texel))
}
