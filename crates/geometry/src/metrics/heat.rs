//! Errors of the vertices of a mesh, and their colours in a heat map.

use super::triangles::{Edges, FaceGeometry};
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

/// Error of each vertex of a result, in the unit of the quantity; NaN at vertices whose faces have no area in the clean mesh.
/// #V
pub fn heat(clean: &Triangles, result: &Triangles, quantity: Heat) -> Result<Vec<f64>, CompareError> {
    clean.check_connectivity(result)?;
    let (positions, faces) = (&clean.positions, &clean.triangles);
    let geometry = FaceGeometry::of(positions, faces);
    let mut weights = vec![0.0; positions.len()];
    let mut sums = vec![0.0; positions.len()];
    let angles = match quantity {
        Heat::Angle => FaceGeometry::of(&result.positions, faces).angles_from(&geometry),
        Heat::Distance => vec![0.0; faces.len()],
    };
    for ((face, area), angle) in faces.iter().zip(&geometry.areas).zip(angles) {
        for &v in face {
            weights[v as usize] += area;
            sums[v as usize] += area * angle;
        }
    }
    if quantity == Heat::Distance {
        let mean_edge = Edges::of(faces).mean(positions);
        let distances = clean.distances(&result.positions).0;
        sums = distances.iter().zip(&weights).map(|(d, w)| w * d / mean_edge).collect();
    }
    // Vertices without an area get 0/0, which is NaN.
    Ok(sums.iter().zip(&weights).map(|(sum, weight)| sum / weight).collect())
}

/// Colour of each vertex in encoded sRGB: the sequential colour map from an error of 0 to one of `top`, and grey for NaN. #V×3
pub fn colours(heat: &[f64], top: f64) -> Vec<[u8; 3]> {
    const NONE: [u8; 3] = [0x80; 3];
    // If no vertex has an error, all get the colour of 0.
    let fraction = |x: f64| if top > 0.0 { x / top } else { 0.0 };
    let colour = |&x: &f64| if x.is_finite() { Colormap::Sequential.bytes(fraction(x) as f32) } else { NONE };
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
