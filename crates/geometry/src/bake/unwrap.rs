//! A new texture atlas for a mesh, by xatlas (Jonathan Young, after thekla_atlas by Ignacio Castaño).
//!
//! Only with the feature `unwrap`. Charts are cut and flattened once; then they are packed for maps of any size, with
//! a gutter in texels of that size.
//!
//! xatlas checks itself with C++ assertions, and a failed one ends the program. This repository switches them off in
//! `.cargo/config.toml` (`CXXFLAGS=-DNDEBUG`). Cargo reads that file inside the repository only: set the same variable
//! wherever else this feature is built.

mod corners;
mod xatlas;

use crate::mesh::jagged::Index;
use crate::mesh::polygon;
use crate::mesh::surface::Surface;
use crate::progress::{Cancelled, Progress};
use crate::source::model::Model;
use glam::{DVec3, Vec2};
use xatlas::{Packing, Scale, Session, Triangles};

/// Free texels between two charts, and between a chart and the border of the map.
pub const GUTTER: u32 = 2;

/// Mean edge length that xatlas gets: it leaves out triangles of less than 1e-7 square units, which are none at this
/// scale.
const MEAN_EDGE: f64 = 1000.0;

/// Times that charts are cut anew so that no polygon lies in two of them.
const CUTS: u32 = 8;
/// From this time on a polygon that is still cut (folded sharply, say) becomes a chart of its own.
const CUTS_TOGETHER: u32 = 4;

/// Times that charts are packed to find the largest scale that fits.
const PACKINGS: u32 = 8;
/// A packing that takes this share of the side is good enough.
const FULL: f64 = 0.95;

/// Why there is no atlas.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum UnwrapError {
    /// No triangle has an area.
    #[error("no face has an area")]
    NoArea,
    /// Polygons that no chart takes as a whole; a corner has one texture coordinate only.
    #[error("{faces} polygons cannot be laid out in one piece; triangulate them first")]
    Split {
        /// Number of them.
        faces: usize,
    },
    /// xatlas stopped without an answer.
    #[error("xatlas gave up on this mesh")]
    Failed,
    /// As asked.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// The charts of a mesh.
pub struct Charts<'a> {
    model: &'a Model,
    session: Session,
}

/// Texture coordinates for a mesh as it was given.
#[derive(Clone, Debug, PartialEq)]
pub struct Unwrapped {
    /// Texture coordinates in 0..=1, v up. #vt×2
    pub uvs: Vec<Vec2>,
    /// For each corner of the source which one, collapsed and repeated faces included.
    pub corners: Vec<Index>,
}

impl<'a> Charts<'a> {
    /// Cuts a mesh into charts and flattens them. The shape is that of `positions` (#V×3, model units): noise makes
    /// charts small and xatlas slow, so a denoised mesh gives the better atlas.
    ///
    /// Stops soon after it was asked to; xatlas itself may take a while longer, on its own threads.
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
        // The region of each face: no chart may leave it.
        let mut regions = vec![0; faces];
        let mut alone = vec![false; faces];
        let mut split = Vec::new();
        for cut in 0..CUTS {
            let session = Session::cut(triangles(&surface, &regions, &alone), GUTTER, progress)?;
            if !has_polygons {
                return Ok(Self { model, session });
            }
            let packing = session.pack(Scale::About(COARSE), progress)?;
            split = corners::of_surface(model, &packing).1;
            if split.is_empty() {
                return Ok(Self { model, session });
            }
            // Each polygon goes where its first triangle went; the chart next to it ends at its edge then.
            let found = packing.corners.as_chunks::<3>().0;
            for (t, found) in surface.triangle_corners().iter().zip(found).rev() {
                let chart = packing.vertices[found[0] as usize].chart;
                regions[surface.topology().face(t[0]) as usize] = chart.map_or(0, |chart| chart + 1);
            }
            if cut >= CUTS_TOGETHER {
                split.iter().for_each(|&f| alone[f as usize] = true);
            }
            // Chart numbers are below the number of vertices.
            let free = packing.vertices.len() as u32 + 1;
            let of_faces = regions.iter_mut().zip(&alone).zip(free..);
            of_faces.filter(|((_, alone), _)| **alone).for_each(|((region, _), own)| *region = own);
        }
        Err(UnwrapError::Split { faces: split.len() })
    }

    /// Packs the charts for a square map, as large as they fit in; none where they do not, for all the gutters.
    pub fn pack(&self, side: u32, progress: &dyn Progress) -> Result<Option<Unwrapped>, UnwrapError> {
        let mut best: Option<Packing> = None;
        let mut scale = Scale::About(side);
        // Texels per unit that are known to be too many.
        let mut too_many = f32::INFINITY;
        for _ in 0..PACKINGS {
            let packing = self.session.pack(scale, progress)?;
            let (share, texels) = (f64::from(packing.extent + 2 * GUTTER) / f64::from(side), packing.texels_per_unit);
            if share <= 1.0 {
                let better = best.as_ref().is_none_or(|b| b.texels_per_unit < texels);
                best = if better { Some(packing) } else { best };
            } else {
                too_many = too_many.min(texels);
            }
            let few = best.as_ref().map_or(0.0, |b| b.texels_per_unit);
            if (FULL..=1.0).contains(&share) || too_many < few * 1.02 {
                break;
            }
            let guess = texels * (0.99 / share) as f32;
            // A gutter does not shrink with the charts, so a guess may stay too large.
            let guess = if guess < too_many { guess.max(few * 1.01) } else { (few + too_many) / 2.0 };
            scale = Scale::TexelsPerUnit(guess);
        }
        Ok(best.map(|packing| {
            let (uvs, corners) = corners::of_source(self.model, &packing, side);
            Unwrapped { uvs, corners }
        }))
    }
}

/// What xatlas gets. Faces that stand alone have vertices of their own, in their own plane.
fn triangles(surface: &Surface, regions: &[u32], alone: &[bool]) -> Triangles {
    let topology = surface.topology();
    let mut positions = surface.positions().to_vec();
    let mut vertices: Vec<Index> = topology.faces().items().to_vec();
    for f in (0..regions.len() as Index).filter(|&f| alone[f as usize]) {
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

/// Side of the packing that only asks which chart took which triangle.
const COARSE: u32 = 1024;

#[cfg(test)]
mod tests;
