//! A new texture atlas for a mesh, by xatlas (Jonathan Young, after thekla_atlas by Ignacio Castaño).
//!
//! This module needs the feature `unwrap`. Charts are cut and flattened once; then they are packed for maps of any size, with
//! a gutter in texels of that size.
//!
//! xatlas checks itself with C++ assertions, and a failed one ends the program. This repository switches them off in
//! `.cargo/config.toml` (`CXXFLAGS=-DNDEBUG`). Cargo reads that file inside the repository only: set the same variable
//! wherever else this feature is built.
//!
//! ```
//! use planish_geometry::bake::unwrap::Charts;
//! use planish_geometry::mesh::weld::Welding;
//! use planish_geometry::progress::Silent;
//! use planish_geometry::source::{model::Model, obj::Obj};
//!
//! // A square of two triangles without texture coordinates gets some within the texture, one for each corner.
//! let model = Model::new(Obj::parse(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n".to_vec())?, Welding::Exact);
//! let charts = Charts::cut(&model, model.surface().positions(), &Silent)?;
//! let unwrapped = charts.pack(64, &Silent)?.expect("room for two triangles");
//! assert_eq!(unwrapped.corners.len(), 6);
//! let corners: Vec<_> = unwrapped.corners.iter().map(|&corner| unwrapped.uvs[corner as usize]).collect();
//! assert!(corners.iter().all(|uv| (0.0..=1.0).contains(&uv.x) && (0.0..=1.0).contains(&uv.y)));
//! assert!((corners[1] - corners[0]).perp_dot(corners[2] - corners[0]).abs() > 0.1);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod corners;
mod xatlas;

use crate::mesh::jagged::Index;
use crate::mesh::polygon;
use crate::mesh::surface::Surface;
use crate::progress::{Cancelled, Progress};
use crate::source::model::Model;
use glam::{DVec3, Vec2};
use xatlas::{Packing, Scale, Session, Triangles};

/// Number of free texels between two charts, and between a chart and the border of the map.
pub const GUTTER: u32 = 2;

/// Mean edge length of the mesh that is passed to xatlas. It leaves out triangles below 1e-7 square units; at this scale
/// only triangles without area are as small.
const MEAN_EDGE: f64 = 1000.0;

/// Number of attempts to cut charts such that no polygon lies in two of them.
const MAX_CUTS: u32 = 8;
/// Attempt from which a polygon that is still split, because it is folded sharply for example, becomes a chart of its own.
const FIRST_CUT_WITH_ISOLATED_POLYGONS: u32 = 4;

/// Number of attempts to find the largest scale at which the charts fit.
const MAX_PACKINGS: u32 = 8;
/// Fraction of the side from which on a packing is good enough.
const GOOD_FILL: f64 = 0.95;

/// Reasons why a mesh cannot be unwrapped.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum UnwrapError {
    /// No triangle has an area.
    #[error("no face has an area")]
    NoArea,
    /// Some polygons do not fit into one chart as a whole, and a corner can have only one texture coordinate.
    #[error("{faces} polygons cannot be laid out in one piece; triangulate them first")]
    Split {
        /// Number of such polygons.
        faces: usize,
    },
    /// xatlas stopped without a result.
    #[error("xatlas gave up on this mesh")]
    Failed,
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Charts of a mesh, ready to be packed for maps of any size.
pub struct Charts<'a> {
    model: &'a Model,
    session: Session,
}

/// New texture coordinates for the source of a model.
#[derive(Clone, Debug, PartialEq)]
pub struct Unwrapped {
    /// Texture coordinates in 0..=1, v up. #vt×2
    pub uvs: Vec<Vec2>,
    /// Index of the texture coordinates of each corner of the source, collapsed and repeated faces included. #c
    pub corners: Vec<Index>,
}

impl<'a> Charts<'a> {
    /// Cuts a mesh into charts and flattens them.
    ///
    /// The charts follow the shape of `positions` (#V×3, model units). Noise makes charts small and xatlas slow, so
    /// denoised positions give the better atlas. This function returns soon after the caller cancels; xatlas itself may run
    /// a while longer on its own threads.
    ///
    /// # Errors
    /// If no face has an area, if polygons cannot be laid out as a whole, or if the caller cancels.
    ///
    /// # Panics
    /// If there is not one position for each vertex.
    pub fn cut(model: &'a Model, positions: &[DVec3], progress: &dyn Progress) -> Result<Self, UnwrapError> {
        let surface = model.surface().at(positions.to_vec());
        let [low, high] = surface.bounds();
        let scale = MEAN_EDGE / surface.mean_edge();
        if !scale.is_finite() || surface.area() <= 0.0 {
            return Err(UnwrapError::NoArea);
        }
        let centre = (low + high) / 2.0;
        let surface = surface.at(positions.iter().map(|p| (*p - centre) * scale).collect());
        let faces = surface.topology().faces().len();
        let has_polygons = surface.triangle_corners().len() > faces;
        // Each face has a region, and no chart contains faces of two regions.
        let mut regions = vec![0; faces];
        let mut isolated = vec![false; faces];
        let mut split = Vec::new();
        for cut in 0..MAX_CUTS {
            let session = Session::cut(triangles(&surface, &regions, &isolated), GUTTER, progress)?;
            if !has_polygons {
                return Ok(Self { model, session });
            }
            let packing = session.pack(Scale::About(TRIAL_SIDE), progress)?;
            split = corners::of_surface(model, &packing).1;
            if split.is_empty() {
                return Ok(Self { model, session });
            }
            // Each polygon goes to the chart of its first triangle, so that charts are cut along its edges next time.
            let found = packing.corners.as_chunks::<3>().0;
            for (t, found) in surface.triangle_corners().iter().zip(found).rev() {
                let chart = packing.vertices[found[0] as usize].chart;
                regions[surface.topology().face(t[0]) as usize] = chart.map_or(0, |chart| chart + 1);
            }
            if cut >= FIRST_CUT_WITH_ISOLATED_POLYGONS {
                split.iter().for_each(|&f| isolated[f as usize] = true);
            }
            // Chart numbers are below the number of vertices.
            let free = packing.vertices.len() as u32 + 1;
            let of_faces = regions.iter_mut().zip(&isolated).zip(free..);
            of_faces.filter(|((_, isolated), _)| **isolated).for_each(|((region, _), own)| *region = own);
        }
        Err(UnwrapError::Split { faces: split.len() })
    }

    /// Packs the charts as large as they fit into a square map with a side in texels; `None` if they do not fit because of
    /// the gutters.
    ///
    /// # Errors
    /// If xatlas fails or the caller cancels.
    pub fn pack(&self, side: u32, progress: &dyn Progress) -> Result<Option<Unwrapped>, UnwrapError> {
        let mut best: Option<Packing> = None;
        let mut scale = Scale::About(side);
        // Smallest scale, texels per unit, that is known to be too large.
        let mut too_many = f32::INFINITY;
        for _ in 0..MAX_PACKINGS {
            let packing = self.session.pack(scale, progress)?;
            let (fill, texels) = (f64::from(packing.extent + 2 * GUTTER) / f64::from(side), packing.texels_per_unit);
            if fill <= 1.0 {
                let better = best.as_ref().is_none_or(|b| b.texels_per_unit < texels);
                best = if better { Some(packing) } else { best };
            } else {
                too_many = too_many.min(texels);
            }
            let few = best.as_ref().map_or(0.0, |b| b.texels_per_unit);
            if (GOOD_FILL..=1.0).contains(&fill) || too_many < few * 1.02 {
                break;
            }
            let guess = texels * (0.99 / fill) as f32;
            // Gutters do not shrink with the charts, so a guess may be too large again.
            let guess = if guess < too_many { guess.max(few * 1.01) } else { (few + too_many) / 2.0 };
            scale = Scale::TexelsPerUnit(guess);
        }
        Ok(best.map(|packing| {
            let (uvs, corners) = corners::of_source(self.model, &packing, side);
            Unwrapped { uvs, corners }
        }))
    }
}

/// Triangles as they are passed to xatlas. Isolated faces get vertices of their own, flattened into the plane of the face.
fn triangles(surface: &Surface, regions: &[u32], isolated: &[bool]) -> Triangles {
    let topology = surface.topology();
    let mut positions = surface.positions().to_vec();
    let mut vertices: Vec<Index> = topology.faces().items().to_vec();
    for f in (0..regions.len() as Index).filter(|&f| isolated[f as usize]) {
        let corners = topology.faces().range(f);
        let points: Vec<DVec3> = corners.clone().map(|c| surface.at_corner(c as Index)).collect();
        let normal = polygon::newell(points.iter().copied()).normalize_or_zero();
        for (corner, p) in corners.zip(&points) {
            vertices[corner] = positions.len() as Index;
            positions.push(*p - (*p - points[0]).dot(normal) * normal);
        }
    }
    let triangles = surface.triangle_corners().iter();
    Triangles {
        positions: positions.iter().flat_map(|p| p.as_vec3().to_array()).collect(),
        indices: triangles.clone().flatten().map(|&c| vertices[c as usize]).collect(),
        regions: triangles.map(|t| regions[topology.face(t[0]) as usize]).collect(),
    }
}

/// Side, texels, of the packing that only shows which triangle went to which chart.
const TRIAL_SIDE: u32 = 1024;

#[cfg(test)]
mod tests;
