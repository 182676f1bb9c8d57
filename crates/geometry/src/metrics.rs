//! Errors of a denoised mesh against the clean one.
//!
//! Definitions as in the literature's evaluation scripts: Ea is the mean angle between the normals of corresponding
//! faces, distances are from the vertices of one mesh to the surface of the other, in mean edge lengths of the clean
//! mesh, and Ev is the area-weighted L2 vertex error of Sun, Rosin, Martin, Langbein 2007.
//!
//! ```
//! use planish_geometry::metrics::{self, Triangles};
//! use planish_geometry::source::obj::{Obj, ObjError};
//!
//! // Two triangles in a plane, of which the second is tilted by 45 degrees.
//! let obj = Obj::parse(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nf 1 2 3 4\nf 2 5 3\n".to_vec())?;
//! let clean = Triangles::from(obj.data());
//! let bent = clean.at(clean.positions().iter().map(|p| p.with_z((p.x - 1.0).max(0.0))).collect());
//! let found = metrics::compare(&clean, &bent).unwrap();
//! assert!((found.ea - 15.0).abs() < 1e-9, "the mean of 0, 0 and 45");
//! # Ok::<(), ObjError>(())
//! ```

pub mod colormap;
pub mod coloured_mesh;
mod distance;
mod heat;
mod triangles;

pub use heat::{Heat, colours, heat};
pub use triangles::Triangles;

use crate::mesh::jagged::Index;
use crate::mesh::triangle_tree::TriangleTree;
use distance::Distances;
use glam::DVec3;
use serde::Serialize;
use triangles::{Edges, FaceGeometry};

/// Reasons why two meshes cannot be compared.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CompareError {
    /// The meshes have different numbers of vertices or triangles.
    #[error(
        "the clean mesh has {clean_vertices} vertices and {clean_faces} triangles, this one {vertices} and {faces}"
    )]
    Counts {
        /// Number of vertices of the clean mesh.
        clean_vertices: usize,
        /// Number of triangles of the clean mesh.
        clean_faces: usize,
        /// Number of vertices of the other mesh.
        vertices: usize,
        /// Number of triangles of the other mesh.
        faces: usize,
    },
    /// The triangle with this index joins other vertices than in the clean mesh.
    #[error("triangle {0} joins other vertices than in the clean mesh")]
    Connectivity(usize),
    /// No face of the clean mesh has an area in double precision, or coordinates are so large that measures are not finite.
    #[error("cannot be measured: the faces of the clean mesh have no area, or coordinates are too large or too small")]
    NotMeasurable,
}

/// Errors of a mesh; its field names in JSON are the column names of the table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Number of vertices.
    #[serde(rename = "V")]
    pub vertices: usize,
    /// Number of triangles.
    #[serde(rename = "F")]
    pub faces: usize,
    /// True if each edge of the clean mesh has two triangles.
    pub closed: bool,
    /// Mean angle between corresponding face normals, degrees.
    #[serde(rename = "Ea_deg")]
    pub ea: f64,
    /// Mean angle between corresponding face normals, weighted by the clean area, degrees.
    #[serde(rename = "Ea_area_deg")]
    pub ea_area: f64,
    /// Median angle between corresponding face normals, degrees.
    #[serde(rename = "Ea_median_deg")]
    pub ea_median: f64,
    /// Root mean square angle between corresponding face normals, degrees.
    #[serde(rename = "Ea_rms_deg")]
    pub ea_rms: f64,
    /// 95th percentile of the angles between corresponding face normals, degrees.
    #[serde(rename = "Ea_p95_deg")]
    pub ea_p95: f64,
    /// Percentage of the faces whose normals differ by more than 5°.
    pub off5_pct: f64,
    /// Percentage of the faces whose normals differ by more than 15°.
    pub off15_pct: f64,
    /// Mean distance of the vertices to the clean surface, mean edge lengths.
    #[serde(rename = "d_mean_el")]
    pub d_mean: f64,
    /// Largest distance of a vertex to the clean surface, mean edge lengths.
    #[serde(rename = "d_max_el")]
    pub d_max: f64,
    /// Root mean square distance of the vertices to the clean surface, mean edge lengths.
    #[serde(rename = "d_rms_el")]
    pub d_rms: f64,
    /// Mean distance of the clean vertices to the surface of the result, mean edge lengths.
    #[serde(rename = "drev_mean_el")]
    pub drev_mean: f64,
    /// Largest distance of a clean vertex to the surface of the result, mean edge lengths: features that were lost show here.
    #[serde(rename = "drev_max_el")]
    pub drev_max: f64,
    /// Mean distance between corresponding vertices, mean edge lengths.
    #[serde(rename = "vtx_mean_el")]
    pub vertex_mean: f64,
    /// Area-weighted L2 vertex-to-surface error Ev over the diagonal of the bounding box, times 1000.
    #[serde(rename = "Ev_1e-3")]
    pub ev: f64,
    /// Change of the volume against the clean mesh, per cent; `None` for open meshes.
    pub vol_change_pct: Option<f64>,
    /// Number of faces whose normals differ by more than 90°.
    pub flipped: usize,
    /// Number of faces that have become slivers or points: area below 1e-6 of the mean, or an angle below half a degree.
    pub degenerate: usize,
    /// Number of edges that have become folded: more than 150° between their faces.
    pub fold_edges: usize,
    /// Mean edge length of the clean mesh, model units.
    pub mean_edge: f64,
    /// Diagonal of the clean mesh's bounding box, model units.
    pub bbox_diag: f64,
}

/// Measures a result against the clean mesh; both must join the same vertices.
pub fn compare(clean: &Triangles, result: &Triangles) -> Result<Comparison, CompareError> {
    clean.check_connectivity(result)?;
    // From here on with the clean order of faces, whatever that of the result.
    let faces = &clean.triangles;
    let edges = Edges::of(faces);
    let (clean_faces, result_faces) =
        (FaceGeometry::of(&clean.positions, faces), FaceGeometry::of(&result.positions, faces));
    let mean_area = mean(clean_faces.areas.iter().copied());
    let normals = NormalErrors::of(&clean_faces, &result_faces, mean_area);
    let distances = DistanceErrors::of(clean, result, &clean_faces);
    let mean_edge = edges.mean(&clean.positions);
    let diagonal = diagonal(clean);
    let volume = || 100.0 * (volume(&result.positions, faces) / volume(&clean.positions, faces) - 1.0);
    let is_new_sliver = |f: &usize| result_faces.is_sliver(*f, mean_area) && !clean_faces.is_sliver(*f, mean_area);
    let is_new_fold = |pair: &&[usize; 2]| result_faces.is_fold(**pair) && !clean_faces.is_fold(**pair);
    let comparison = Comparison {
        vertices: clean.positions.len(),
        faces: faces.len(),
        closed: edges.closed,
        ea: mean(normals.angles.iter().copied()),
        ea_area: normals.area_weighted_mean,
        ea_median: percentile(&normals.sorted, 0.5),
        ea_rms: mean(normals.angles.iter().map(|a| a * a)).sqrt(),
        ea_p95: percentile(&normals.sorted, 0.95),
        off5_pct: normals.percentage_above(5.0),
        off15_pct: normals.percentage_above(15.0),
        d_mean: distances.to_clean.mean() / mean_edge,
        d_max: distances.to_clean.max() / mean_edge,
        d_rms: distances.to_clean.rms() / mean_edge,
        drev_mean: distances.to_result.mean() / mean_edge,
        drev_max: distances.to_result.max() / mean_edge,
        vertex_mean: distances.vertex_mean / mean_edge,
        ev: 1e3 * distances.area_weighted_rms / diagonal,
        vol_change_pct: edges.closed.then(volume),
        flipped: normals.angles.iter().filter(|a| **a > 90.0).count(),
        degenerate: (0..faces.len()).filter(is_new_sliver).count(),
        fold_edges: edges.pairs.iter().filter(is_new_fold).count(),
        mean_edge,
        bbox_diag: diagonal,
    };
    if comparison.is_finite() { Ok(comparison) } else { Err(CompareError::NotMeasurable) }
}

impl Comparison {
    /// Returns true if all measures are finite.
    fn is_finite(&self) -> bool {
        let angles = [self.ea, self.ea_area, self.ea_median, self.ea_rms, self.ea_p95, self.off5_pct, self.off15_pct];
        let distances = [self.d_mean, self.d_max, self.d_rms, self.drev_mean, self.drev_max, self.vertex_mean, self.ev];
        let others = [self.vol_change_pct.unwrap_or(0.0), self.mean_edge, self.bbox_diag];
        angles.into_iter().chain(distances).chain(others).all(f64::is_finite)
    }
}

/// Angles between the normals of corresponding faces, over the faces that have an area in the clean mesh.
struct NormalErrors {
    /// Angle at each face, degrees.
    angles: Vec<f64>,
    /// Angles in ascending order.
    sorted: Vec<f64>,
    /// Mean angle weighted by the area in the clean mesh, degrees.
    area_weighted_mean: f64,
}

impl NormalErrors {
    fn of(clean: &FaceGeometry, result: &FaceGeometry, mean_area: f64) -> Self {
        let measured: Vec<usize> = (0..clean.areas.len()).filter(|&f| clean.areas[f] > 1e-12 * mean_area).collect();
        let of_faces = result.angles_from(clean);
        let angles: Vec<f64> = measured.iter().map(|&f| of_faces[f]).collect();
        let weighted: f64 = measured.iter().zip(&angles).map(|(&f, a)| a * clean.areas[f]).sum();
        let area: f64 = measured.iter().map(|&f| clean.areas[f]).sum();
        let mut sorted = angles.clone();
        sorted.sort_unstable_by(f64::total_cmp);
        Self { angles, sorted, area_weighted_mean: weighted / area }
    }

    /// Percentage of the faces with a larger angle than `limit`, degrees.
    fn percentage_above(&self, limit: f64) -> f64 {
        100.0 * self.angles.iter().filter(|a| **a > limit).count() as f64 / self.angles.len() as f64
    }
}

/// Distances between two meshes, over the vertices that faces use, model units.
struct DistanceErrors {
    /// Distances from the vertices of the result to the clean surface.
    to_clean: Distances,
    /// Distances from the vertices of the clean mesh to the surface of the result.
    to_result: Distances,
    /// Mean distance between corresponding vertices.
    vertex_mean: f64,
    /// Root mean square of `to_clean`, where a vertex counts by the area of the clean faces around it.
    area_weighted_rms: f64,
}

impl DistanceErrors {
    fn of(clean: &Triangles, result: &Triangles, clean_faces: &FaceGeometry) -> Self {
        let faces = &clean.triangles;
        let mut vertex_areas = vec![0.0; clean.positions.len()];
        let mut is_used = vec![false; clean.positions.len()];
        for (t, area) in faces.iter().zip(&clean_faces.areas) {
            for &v in t {
                vertex_areas[v as usize] += area;
                is_used[v as usize] = true;
            }
        }
        let used: Vec<usize> = (0..is_used.len()).filter(|&v| is_used[v]).collect();
        let at = |mesh: &Triangles| used.iter().map(|&v| mesh.positions[v]).collect::<Vec<_>>();
        let to_clean = clean.distances(&at(result));
        let to_result = TriangleTree::new(&result.positions, faces.iter().copied()).distances(&at(clean));
        let to_result = Distances(to_result);
        let squares = used.iter().zip(&to_clean.0).map(|(&v, d)| vertex_areas[v] * d * d).sum::<f64>();
        let area = used.iter().map(|&v| vertex_areas[v]).sum::<f64>();
        let moved = used.iter().map(|&v| clean.positions[v].distance(result.positions[v]));
        Self { vertex_mean: mean(moved), area_weighted_rms: (squares / area).sqrt(), to_clean, to_result }
    }
}

/// Diagonal of the bounding box of the vertices that triangles use.
fn diagonal(mesh: &Triangles) -> f64 {
    let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let used = mesh.triangles.as_flattened().iter().map(|&v| mesh.positions[v as usize]);
    let (low, high) = used.fold(start, |(low, high), p| (low.min(p), high.max(p)));
    low.distance(high)
}

/// Signed volume about a vertex of the first face, so that only vertices that faces use take part.
fn volume(positions: &[DVec3], faces: &[[Index; 3]]) -> f64 {
    let centre = faces.first().map_or(DVec3::ZERO, |face| positions[face[0] as usize]);
    let corners = faces.iter().map(|t| t.map(|v| positions[v as usize] - centre));
    corners.map(|[a, b, c]| a.dot(b.cross(c))).sum::<f64>() / 6.0
}

fn mean(of: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = of.len();
    of.sum::<f64>() / count as f64
}

/// Percentile of an ascending list, for a fraction 0..=1, by linear interpolation between order statistics, as numpy does it;
/// NaN for an empty list.
pub fn percentile(sorted: &[f64], fraction: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else { return f64::NAN };
    let rank = fraction * last as f64;
    let (low, high) = (rank.floor() as usize, rank.ceil() as usize);
    sorted[low] + (sorted[high] - sorted[low]) * (rank - low as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::source::obj::Obj;

    #[test]
    fn a_mesh_is_at_no_distance_from_itself() {
        let sphere = Triangles::of(&shapes::dented_sphere(2));
        let same = compare(&sphere, &sphere).unwrap();
        assert_eq!((same.ea, same.d_max, same.drev_max, same.flipped, same.fold_edges), (0.0, 0.0, 0.0, 0, 0));
        assert_eq!(same.vol_change_pct, Some(0.0));
    }

    #[test]
    fn a_larger_sphere_is_off_by_the_difference_of_the_radii() {
        let sphere = shapes::sphere(3);
        let larger = sphere.at(sphere.positions().iter().map(|p| *p * 1.1).collect());
        let found = compare(&Triangles::of(&sphere), &Triangles::of(&larger)).unwrap();
        assert!(found.ea < 1e-6);
        assert!((found.d_mean * found.mean_edge - 0.1).abs() < 1e-12);
        assert!((found.vol_change_pct.unwrap() - 33.1).abs() < 1e-9);
    }

    #[test]
    fn the_order_of_the_faces_does_not_matter_but_the_faces_do() {
        let sphere = Triangles::of(&shapes::dented_sphere(1));
        let mut other = sphere.clone();
        other.triangles.reverse();
        other.triangles[3].rotate_left(1);
        assert_eq!(compare(&sphere, &other).unwrap().ea, 0.0);
        other.triangles[3].swap(0, 1);
        assert_eq!(compare(&sphere, &other).unwrap_err(), CompareError::Connectivity(3));
        other.triangles.pop();
        assert!(matches!(compare(&sphere, &other), Err(CompareError::Counts { faces: 79, .. })));
    }

    #[test]
    fn a_polygon_is_compared_by_the_triangles_of_the_clean_mesh() {
        // Two darts, which are cut from the corner that points inwards: the second and the first one.
        let dart = |places: [[f64; 2]; 4]| {
            let lines: String = places.iter().map(|[x, y]| format!("v {x} {y} 0\n")).collect();
            Triangles::from(Obj::parse((lines + "f 1 2 3 4\n").into_bytes()).unwrap().data())
        };
        let wide = dart([[-1.0, 0.0], [0.0, 0.5], [1.0, 0.0], [0.0, 1.0]]);
        let high = dart([[0.5, 0.0], [0.0, -1.0], [1.0, 0.0], [0.0, 1.0]]);
        let diagonals = [&wide, &high].map(|mesh| mesh.triangles().iter().filter(|t| t.contains(&0)).count());
        assert_ne!(diagonals[0], diagonals[1], "otherwise this shows nothing");
        let found = compare(&wide, &high).unwrap();
        assert_eq!(found, compare(&wide, &wide.at(high.positions().to_vec())).unwrap());
    }

    #[test]
    fn percentiles_interpolate() {
        assert_eq!(percentile(&[1.0, 2.0, 4.0], 0.5), 2.0);
        assert_eq!(percentile(&[1.0, 2.0, 4.0, 8.0], 0.5), 3.0);
        assert!(percentile(&[], 0.5).is_nan());
    }
}
