//! Where on a mesh the error is.

use super::triangles::{Edges, Shapes};
use super::{CompareError, Triangles};
use crate::metrics::colormap::Colormap;
use crate::named;

named! {
    /// Error of a vertex that a heat map shows.
    #[derive(Default)]
    pub enum Heat {
        /// Angle to the clean face normals, degrees, averaged by area over the faces around the vertex.
        #[default]
        Angle = "angle",
        /// Distance to the clean surface, in mean edge lengths of the clean mesh.
        Distance = "distance",
    }
}

/// The error of each vertex of a result, #V; NaN at vertices without a face that has an area in the clean mesh.
pub fn heat(clean: &Triangles, result: &Triangles, what: Heat) -> Result<Vec<f64>, CompareError> {
    clean.check_connectivity(result)?;
    let (positions, faces) = (&clean.positions, &clean.triangles);
    let shapes = Shapes::of(positions, faces);
    let mut weights = vec![0.0; positions.len()];
    let mut sums = vec![0.0; positions.len()];
    let angles = match what {
        Heat::Angle => Shapes::of(&result.positions, faces).angles_from(&shapes),
        Heat::Distance => vec![0.0; faces.len()],
    };
    for ((face, area), angle) in faces.iter().zip(&shapes.areas).zip(angles) {
        for &v in face {
            weights[v as usize] += area;
            sums[v as usize] += area * angle;
        }
    }
    if what == Heat::Distance {
        let mean_edge = Edges::of(faces).mean(positions);
        let distances = clean.distances(&result.positions).0;
        sums = distances.iter().zip(&weights).map(|(d, w)| w * d / mean_edge).collect();
    }
    // 0/0 is the NaN that is promised.
    Ok(sums.iter().zip(&weights).map(|(sum, weight)| sum / weight).collect())
}

/// A colour for each vertex: that of 0 at 0, that of 1 from `top` on, grey where there is no error to show.
pub fn colours(heat: &[f64], top: f64) -> Vec<[u8; 3]> {
    const NONE: [u8; 3] = [0x80; 3];
    // Where no vertex is off at all, none is hot.
    let share = |x: f64| if top > 0.0 { x / top } else { 0.0 };
    let colour = |&x: &f64| if x.is_finite() { Colormap::Sequential.bytes(share(x) as f32) } else { NONE };
    heat.iter().map(colour).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn one_lifted_vertex_is_the_hottest_and_only_its_ring_is_warm() {
        let grid = shapes::grid(8);
        let middle = 40;
        let mut lifted = grid.positions().to_vec();
        lifted[middle].z += 0.05;
        let (clean, result) = (Triangles::of(&grid), Triangles::of(&grid.at(lifted)));
        let angles = heat(&clean, &result, Heat::Angle).unwrap();
        let distances = heat(&clean, &result, Heat::Distance).unwrap();
        let mean_edge = super::super::compare(&clean, &result).unwrap().mean_edge;
        for v in 0..grid.positions().len() {
            let near = clean.triangles.iter().any(|t| t.contains(&(v as u32)) && t.contains(&(middle as u32)));
            assert_eq!(angles[v] > 0.0, near, "{v}");
            assert!(angles[v] <= angles[middle], "{v}");
            let expected = if v == middle { 0.05 / mean_edge } else { 0.0 };
            assert!((distances[v] - expected).abs() < 1e-12, "{v}");
        }
    }

    #[test]
    fn a_vertex_of_no_face_has_no_error_and_is_grey() {
        let mut clean = Triangles::of(&shapes::sphere(1));
        clean.positions.push(glam::DVec3::splat(9.0));
        for what in [Heat::Angle, Heat::Distance] {
            let heat = heat(&clean, &clean, what).unwrap();
            assert!(heat.last().unwrap().is_nan());
            let colours = colours(&heat, 0.0);
            let (last, others) = colours.split_last().unwrap();
            assert_eq!(*last, [0x80; 3]);
            assert!(others.iter().all(|c| *c == Colormap::Sequential.bytes(0.0)));
        }
    }
}
