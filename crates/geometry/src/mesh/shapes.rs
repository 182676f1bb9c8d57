//! Small meshes with known properties, for tests, examples and experiments.
//!
//! ```
//! use planish_geometry::mesh::shapes;
//!
//! assert_eq!((shapes::cube().volume(), shapes::gridded_box(2).volume()), (1.0, 6.0));
//! assert_eq!(shapes::sphere(2).positions().len(), 10 * 4usize.pow(2) + 2);
//! assert!(shapes::sphere(2).positions().iter().all(|p| (p.length() - 1.0).abs() < 1e-12));
//! ```

use crate::mesh::jagged::{Index, Ragged};
use crate::mesh::surface::Surface;
use crate::mesh::topology::Topology;
use glam::DVec3;
use rustc_hash::FxHashMap;

fn surface(positions: Vec<DVec3>, faces: impl IntoIterator<Item = Vec<Index>>) -> Surface {
    let faces: Ragged<Index> = faces.into_iter().collect();
    Surface::new(Topology::new(positions.len(), faces), positions)
}

/// Builds a unit sphere from an icosahedron whose triangles are cut in four `levels` times: 10·4ˡ + 2 vertices.
pub fn sphere(levels: u32) -> Surface {
    let phi = (1.0 + 5f64.sqrt()) / 2.0;
    let mut points: Vec<DVec3> = Vec::new();
    for (a, b) in [(1.0, phi), (-1.0, phi), (1.0, -phi), (-1.0, -phi)] {
        points.extend([DVec3::new(0.0, a, b), DVec3::new(a, b, 0.0), DVec3::new(b, 0.0, a)]);
    }
    let mut faces: Vec<[Index; 3]> = Vec::new();
    let are_neighbours = |i: usize, j: usize| (points[i].distance(points[j]) - 2.0).abs() < 1e-9;
    for i in 0..12 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                if are_neighbours(i, j) && are_neighbours(j, k) && are_neighbours(k, i) {
                    let outward = points[i].dot(points[j].cross(points[k])) > 0.0;
                    let t = if outward { [i, j, k] } else { [i, k, j] };
                    faces.push(t.map(|i| i as Index));
                }
            }
        }
    }
    for p in &mut points {
        *p = p.normalize();
    }
    for _ in 0..levels {
        let mut middles = FxHashMap::default();
        let mut middle = |a: Index, b: Index| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                points.push((points[a as usize] + points[b as usize]).normalize());
                points.len() as Index - 1
            })
        };
        let quarters = faces.iter().flat_map(|&[a, b, c]| {
            let [d, e, f] = [middle(a, b), middle(b, c), middle(c, a)];
            [[a, d, f], [d, b, e], [f, e, c], [d, e, f]]
        });
        faces = quarters.collect();
    }
    surface(points, faces.into_iter().map(Vec::from))
}

/// Builds the unit square in the plane z = 0 from `cells` × `cells` squares, each cut into two triangles.
pub fn grid(cells: u32) -> Surface {
    let at = |i: u32, j: u32| j * (cells + 1) + i;
    let corner = |i: u32| f64::from(i) / f64::from(cells);
    let points = (0..=cells).flat_map(|j| (0..=cells).map(move |i| DVec3::new(corner(i), corner(j), 0.0)));
    let faces = (0..cells).flat_map(|j| {
        (0..cells).flat_map(move |i| {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [vec![a, b, c], vec![a, c, d]]
        })
    });
    surface(points.collect(), faces)
}

/// Builds the cube [0, 1]³ from six squares.
pub fn cube() -> Surface {
    let points = (0..8).map(|i| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)));
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    surface(points.collect(), faces.map(Vec::from))
}

/// Builds the box [0, 1] × [0, 2] × [0, 3], whose sides are `cells` × `cells` rectangles, each cut in two.
pub fn gridded_box(cells: u32) -> Surface {
    let mut points = Vec::new();
    let mut seen = FxHashMap::default();
    let mut faces = Vec::new();
    for (axis, side) in (0..3).flat_map(|axis| [(axis, 0), (axis, cells)]) {
        for (i, j) in (0..cells).flat_map(|i| (0..cells).map(move |j| (i, j))) {
            let mut corner = |i: u32, j: u32| {
                let mut p = [side; 3];
                [p[(axis + 1) % 3], p[(axis + 2) % 3]] = [i, j];
                *seen.entry(p).or_insert_with(|| {
                    let size = DVec3::new(1.0, 2.0, 3.0) / f64::from(cells);
                    points.push(DVec3::from_array(p.map(f64::from)) * size);
                    points.len() as Index - 1
                })
            };
            let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
            faces.extend([[a, b, c], [a, c, d]].map(|[a, b, c]| if side == 0 { vec![a, c, b] } else { vec![a, b, c] }));
        }
    }
    surface(points, faces)
}

/// Builds the grid of [`grid`] lifted by 0.08 sin 6x cos 5y, which bends up to 2.9 radians in a unit of length.
pub fn bumpy_sheet(cells: u32) -> Surface {
    let flat = grid(cells);
    let lifted = flat.positions().iter().map(|p| *p + DVec3::Z * 0.08 * (p.x * 6.0).sin() * (p.y * 5.0).cos());
    flat.at(lifted.collect())
}

/// Builds a bumpy sphere without any symmetry: radii are pseudo-random in 1..=1.05.
pub fn dented_sphere(levels: u32) -> Surface {
    let sphere = sphere(levels);
    let dent = |i: u32| f64::from(i.wrapping_mul(2_654_435_761) >> 16 & 0xff) / 255.0;
    let positions = (0..).zip(sphere.positions()).map(|(i, p)| *p * (1.0 + 0.05 * dent(i)));
    sphere.at(positions.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_shapes_are_closed_and_face_outwards() {
        for (shape, volume) in [(sphere(0), 2.5361507101204093), (cube(), 1.0), (gridded_box(3), 6.0)] {
            let topology = shape.topology();
            assert!((0..topology.vertex_count() as Index).all(|v| !topology.is_boundary(v)));
            // Icosahedron in the unit sphere: (5/12)(3 + √5)·a³ with a = 1/sin 72°… = 2.536.
            assert!((shape.volume() - volume).abs() < 1e-12, "{}", shape.volume());
        }
        assert_eq!(sphere(2).topology().vertex_count(), 162);
    }
}
