//! Issues of a texture layout that make it hard to bake a map.
//!
//! ```
//! use glam::DVec2;
//! use planish_geometry::map::{Coverage, Size, layout_issues::LayoutIssues, map_size::Spacing};
//! use planish_geometry::mesh::{atlas::Atlas, shapes};
//! use planish_geometry::progress::Silent;
//!
//! // The last vertex of a square lies outside of the texture.
//! let square = shapes::grid(1);
//! let uvs = [[0.0, 0.0], [0.9, 0.0], [0.0, 0.9], [1.5, 0.9]].map(DVec2::from_array);
//! let atlas = Atlas::new(&square, &uvs, square.topology().faces().items().iter().map(|&v| Some(v)))?;
//! let coverage = Coverage::new(&square, &atlas, Size::square(64), &Silent)?;
//! let issues = LayoutIssues::of(&square, &atlas, &Spacing::new(&atlas), &coverage);
//! assert_eq!(issues.problems(), ["1 vertex is outside [0, 1], where the texture repeats: a map is clamped at its border"]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use super::Coverage;
use super::map_size::Spacing;
use crate::mesh::atlas::{self, Atlas};
use crate::mesh::jagged::Index;
use crate::mesh::surface::Surface;
use glam::DVec2;
use serde::{Deserialize, Serialize};

/// Issues of a layout at one size of the map.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LayoutIssues {
    /// Fraction of the texels inside charts, 0..=1.
    pub coverage: f64,
    /// Number of vertices that sample less than two texels from another one, so that they share texels.
    pub crowded_vertices: usize,
    /// Smallest distance between the texture coordinates of two vertices, texels.
    pub smallest_distance: Option<f64>,
    /// Number of vertices that sample outside [0, 1]².
    pub out_of_range_vertices: usize,
    /// Kind of the faces outside [0, 1]²; `None` if no vertex lies there.
    pub out_of_range: Option<OutOfRange>,
    /// Number of texels that lie in more than one triangle, counted once for each further triangle.
    pub overlapping_texels: usize,
    /// Number of faces that are mirrored in the texture.
    pub mirrored_faces: usize,
    /// Number of vertices of faces without texture coordinates; they are not displaced.
    pub unmapped_vertices: usize,
}

/// Kind of a layout that leaves the unit square.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum OutOfRange {
    /// Each face lies in one square of the integer grid: there is one texture for each square (UDIM).
    Tiles,
    /// Some faces cross the lines of the integer grid: the texture repeats.
    Wrap,
}

impl LayoutIssues {
    /// Finds the issues of a layout in a square map.
    pub fn of(surface: &Surface, atlas: &Atlas, spacing: &Spacing, coverage: &Coverage) -> Self {
        let side = coverage.size().width;
        let out_of_range_vertices = out_of_range(atlas);
        Self {
            coverage: coverage.covered_fraction(),
            crowded_vertices: spacing.crowded(side),
            smallest_distance: Some(spacing.smallest(side)).filter(|d| d.is_finite()),
            out_of_range_vertices,
            out_of_range: (out_of_range_vertices > 0).then(|| kind(surface, atlas)),
            overlapping_texels: coverage.overlaps(),
            mirrored_faces: atlas.mirrored_faces(surface),
            unmapped_vertices: unmapped(surface, atlas),
        }
    }

    /// Sums up the issues of pages, each with the number of texels of its image. Vertices without texture coordinates, which are on no
    /// page, are those of `unmapped_vertices`.
    pub fn of_pages(pages: &[(Self, usize)], unmapped_vertices: usize) -> Self {
        let count = |of: fn(&Self) -> usize| pages.iter().map(|page| of(&page.0)).sum();
        let texels: usize = pages.iter().map(|page| page.1).sum();
        let covered: f64 = pages.iter().map(|(issues, texels)| issues.coverage * *texels as f64).sum();
        let kinds = || pages.iter().filter_map(|page| page.0.out_of_range);
        Self {
            coverage: covered / texels.max(1) as f64,
            crowded_vertices: count(|page| page.crowded_vertices),
            smallest_distance: pages.iter().filter_map(|page| page.0.smallest_distance).min_by(f64::total_cmp),
            out_of_range_vertices: count(|page| page.out_of_range_vertices),
            out_of_range: kinds().find(|kind| *kind == OutOfRange::Wrap).or(kinds().next()),
            overlapping_texels: count(|page| page.overlapping_texels),
            mirrored_faces: count(|page| page.mirrored_faces),
            unmapped_vertices,
        }
    }

    /// Describes the issues that no size of the map can solve, the worst first.
    pub fn problems(&self) -> Vec<String> {
        let mut out = Vec::new();
        let mut add = |n: usize, text: String| {
            if n > 0 {
                out.push(text);
            }
        };
        let outside = match self.out_of_range {
            Some(OutOfRange::Tiles) => "in other UDIM tiles: an image without pages has one tile only",
            _ => "where the texture repeats: a map is clamped at its border",
        };
        let vertices_are = |n: usize| format!("{n} {}", if n == 1 { "vertex is" } else { "vertices are" });
        add(self.unmapped_vertices, format!("{} without texture coordinates", vertices_are(self.unmapped_vertices)));
        add(
            self.out_of_range_vertices,
            format!("{} outside [0, 1], {outside}", vertices_are(self.out_of_range_vertices)),
        );
        let mirrored = if self.mirrored_faces > 0 { " (some faces are mirrored)" } else { "" };
        let texels = self.overlapping_texels;
        add(
            texels,
            format!("charts overlap in {texels} texels{mirrored}: faces that share texels share their heights"),
        );
        out
    }

    /// Describes the issue that a larger map may solve; `None` without it.
    pub fn crowding(&self) -> Option<String> {
        let n = self.crowded_vertices;
        let vertices_are = if n == 1 { "vertex is" } else { "vertices are" };
        (n > 0).then(|| format!("{n} {vertices_are} less than two texels from another one"))
    }
}

/// Number of vertices whose texture coordinate lies outside the unit square, where a map that does not repeat has no texels.
pub fn out_of_range(atlas: &Atlas) -> usize {
    let dominant_uv = |v| atlas.dominant(v).map(|uv| atlas.uvs()[uv as usize]);
    let outside = |uv: &DVec2| !atlas::in_unit_square(*uv);
    (0..atlas.wedges().len() as Index).filter_map(dominant_uv).filter(outside).count()
}

/// Number of vertices with faces none of which gives them a texture coordinate.
pub fn unmapped(surface: &Surface, atlas: &Atlas) -> usize {
    let vertices = 0..atlas.wedges().len() as Index;
    vertices.filter(|&v| !surface.topology().is_isolated(v) && atlas.dominant(v).is_none()).count()
}

/// Kind of the faces outside the unit square, of which there are some.
fn kind(surface: &Surface, atlas: &Atlas) -> OutOfRange {
    let in_one_square = |corners: &[Index; 3]| {
        let uvs = corners.map(|c| atlas.at_corner(c).unwrap_or_default());
        let [low, high] = [uvs[0].min(uvs[1]).min(uvs[2]), uvs[0].max(uvs[1]).max(uvs[2])];
        // A face may end on a line of the grid from either side.
        high.cmple(low.floor() + 1.0).all()
    };
    if surface.triangle_corners().iter().all(in_one_square) { OutOfRange::Tiles } else { OutOfRange::Wrap }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::Size;
    use crate::mesh::shapes;
    use crate::progress::Silent;

    fn found(uv: impl Fn(DVec2) -> DVec2) -> LayoutIssues {
        let grid = shapes::grid(8);
        let corners = 0..grid.topology().faces().items().len() as Index;
        let uvs: Vec<_> = grid.positions().iter().map(|p| uv(p.truncate())).collect();
        let atlas = Atlas::new(&grid, &uvs, corners.map(|c| Some(grid.topology().vertex(c)))).unwrap();
        let coverage = Coverage::new(&grid, &atlas, Size::square(64), &Silent).unwrap();
        LayoutIssues::of(&grid, &atlas, &Spacing::new(&atlas), &coverage)
    }

    #[test]
    fn a_plain_layout_has_no_problem() {
        let plain = found(|p| p * 0.9 + 0.05);
        assert_eq!(plain.problems(), Vec::<String>::new());
        assert_eq!((plain.mirrored_faces, plain.out_of_range), (0, None));
    }

    #[test]
    fn tiles_are_told_from_repetition() {
        assert_eq!(found(|p| p + DVec2::X).out_of_range, Some(OutOfRange::Tiles));
        assert_eq!(found(|p| p * 3.0 - 0.4).out_of_range, Some(OutOfRange::Wrap));
    }

    #[test]
    fn overlaps_mirrors_and_crowds_are_named() {
        // Folded along the middle: the right half lies on the left one, mirrored.
        let folded = found(|p| DVec2::new((p.x - 0.5).abs(), p.y));
        assert_eq!(folded.mirrored_faces, 64);
        assert!(folded.problems().iter().any(|p| p.contains("overlap") && p.contains("mirrored")), "{folded:?}");
        let crowded = found(|p| p * 0.1);
        assert_eq!(crowded.crowded_vertices, 81);
        assert_eq!(crowded.crowding().as_deref(), Some("81 vertices are less than two texels from another one"));
        assert_eq!(crowded.problems(), Vec::<String>::new());
    }
}
