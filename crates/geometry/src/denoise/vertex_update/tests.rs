use super::*;
use crate::denoise::face_geometry::FaceGeometry;
use crate::mesh::shapes;
use crate::mesh::synthetic_noise::{self, Noise};
use crate::mesh::topology::Topology;
use crate::progress::Silent;

const SETTINGS: VertexUpdate = VertexUpdate {
    scheme: VertexScheme::Descent,
    iterations: 100,
    closeness: 0.0,
    boundary: Boundary::Fixed,
    motion: Motion::Free,
    fold_overs: FoldOvers::Prevent,
};

/// A sphere, the same with noise, and its faces.
fn noisy(sigma: f64) -> (Surface, Surface, TriangleMesh) {
    let sphere = shapes::sphere(3);
    let noise = Noise { sigma, direction: synthetic_noise::Direction::Normal, share: 1.0, seed: 3 };
    let noisy = synthetic_noise::noisy(&sphere, &noise);
    let mesh = TriangleMesh::of(&sphere);
    (sphere, noisy, mesh)
}

fn off(mesh: &TriangleMesh, positions: &[DVec3], normals: &[DVec3]) -> f64 {
    let found = FaceGeometry::of(mesh, positions).normals;
    found.iter().zip(normals).map(|(a, b)| a.angle_between(*b).to_degrees()).sum::<f64>() / mesh.face_count() as f64
}

#[test]
fn vertices_reach_normals_that_a_surface_has() {
    let (clean, noisy, mesh) = noisy(0.2);
    let normals = FaceGeometry::of(&mesh, clean.positions()).normals;
    // From 21°. A hundred steps do not come to the end.
    for (scheme, bound) in [(VertexScheme::Descent, 0.2), (VertexScheme::LeastSquares, 1e-3)] {
        let mut updater = Updater::new(&noisy, &mesh, VertexUpdate { scheme, ..SETTINGS });
        updater.follow(&normals, &Silent).unwrap();
        let left = off(&mesh, updater.positions(), &normals);
        assert!(left < bound, "{scheme:?}: {left}");
    }
}

#[test]
fn least_squares_are_where_the_descent_ends() {
    let (clean, noisy, mesh) = noisy(0.2);
    let normals = FaceGeometry::of(&mesh, clean.positions()).normals;
    let end = |scheme| {
        let settings = VertexUpdate { scheme, iterations: 2000, closeness: 0.1, ..SETTINGS };
        let mut updater = Updater::new(&noisy, &mesh, settings);
        updater.follow(&normals, &Silent).unwrap();
        updater.deltas()
    };
    let ends = end(VertexScheme::Descent).into_iter().zip(end(VertexScheme::LeastSquares));
    let gap = ends.map(|(a, b)| a.distance(b)).fold(0.0, f64::max);
    // A step takes a share of w / (6 + w) at least of what is left, and 2000 of them leave 1e-14; conjugate gradients
    // leave 1e-8 of the pull, which is sixty times as much of the way where w alone holds a vertex.
    assert!(gap < 1e-6 * noisy.mean_edge(), "{gap:e}");
}

#[test]
fn a_step_is_that_of_the_formula() {
    let (clean, noisy, mesh) = noisy(0.2);
    let normals = FaceGeometry::of(&mesh, clean.positions()).normals;
    let settings = VertexUpdate { iterations: 1, closeness: 0.3, fold_overs: FoldOvers::Allow, ..SETTINGS };
    let mut updater = Updater::new(&noisy, &mesh, settings);
    // The second step starts away from the input, so that closeness pulls back.
    let mut x = noisy.positions().to_vec();
    for _ in 0..2 {
        updater.follow(&normals, &Silent).unwrap();
        let step = |v: usize| {
            let at = |f: usize| mesh.triangles[f].map(|w| x[w as usize]);
            let around: Vec<usize> =
                (0..mesh.face_count()).filter(|&f| mesh.triangles[f].contains(&(v as Index))).collect();
            let pull = |&f: &usize| normals[f] * normals[f].dot(at(f).iter().sum::<DVec3>() / 3.0 - x[v]);
            let back = 0.3 * (noisy.positions()[v] - x[v]);
            x[v] + (around.iter().map(pull).sum::<DVec3>() + back) / (around.len() as f64 + 0.3)
        };
        x = (0..x.len()).map(step).collect();
        let gap = updater.positions().iter().zip(&x).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
        assert!(gap < 1e-14, "{gap:e}");
    }
}

#[test]
fn closeness_holds_vertices_back() {
    let (clean, noisy, mesh) = noisy(0.2);
    let target = FaceGeometry::of(&mesh, clean.positions()).normals;
    let moved = [0.0, 0.5, 5.0].map(|closeness| {
        let mut updater = Updater::new(&noisy, &mesh, VertexUpdate { closeness, ..SETTINGS });
        updater.follow(&target, &Silent).unwrap();
        updater.deltas().iter().map(|d| d.length()).sum::<f64>()
    });
    assert!(moved[0] > moved[1] && moved[1] > moved[2] && moved[2] > 0.0, "{moved:?}");
}

#[test]
fn no_triangle_is_turned_over_where_that_is_prevented() {
    // Normals that nothing can have, in all directions.
    let (_, noisy, mesh) = noisy(0.4);
    let before = FaceGeometry::of(&mesh, noisy.positions()).normals;
    let target: Vec<DVec3> = before.iter().map(|n| (*n + 0.9 * DVec3::new(n.y, n.z, n.x)).normalize()).collect();
    let turned = |scheme, fold_overs| {
        let mut updater = Updater::new(&noisy, &mesh, VertexUpdate { scheme, fold_overs, ..SETTINGS });
        updater.follow(&target, &Silent).unwrap();
        let after = FaceGeometry::of(&mesh, updater.positions()).normals;
        let turned = |f: &usize| before[*f].dot(target[*f]) > 0.0 && after[*f].dot(target[*f]) <= 0.0;
        (0..mesh.face_count()).filter(turned).count()
    };
    for scheme in [VertexScheme::Descent, VertexScheme::LeastSquares] {
        assert_eq!(turned(scheme, FoldOvers::Prevent), 0, "{scheme:?}");
    }
    assert!(turned(VertexScheme::Descent, FoldOvers::Allow) > 0, "otherwise this shows nothing");
}

#[test]
fn a_vertex_goes_back_by_halves_of_its_step_and_then_all_the_way() {
    let (_, from, mesh) = noisy(0.3);
    let normals = FaceGeometry::of(&mesh, from.positions()).normals;
    // Steps of an edge fold many triangles, some of which no halving unfolds.
    let steps = synthetic_noise::displacements(
        &from,
        &Noise { sigma: 1.0, direction: synthetic_noise::Direction::Random, share: 1.0, seed: 9 },
    );
    const HALVINGS: u8 = 2;
    let mut to: Vec<DVec3> = from.positions().iter().zip(&steps).map(|(p, step)| *p + *step).collect();
    undo_flips(&mesh, &normals, from.positions(), &mut to, HALVINGS);
    let mut found = [0; HALVINGS as usize + 2];
    for ((x, p), step) in to.iter().zip(from.positions()).zip(&steps) {
        // The step, a half of it, a quarter of it, or nothing.
        let left = [1.0, 0.5, 0.25, 0.0].iter().position(|part| (*x - *p).distance(*part * *step) < 1e-14);
        found[left.unwrap_or_else(|| panic!("{x} is {} of a step of {step} away", *x - *p))] += 1;
    }
    assert!(found.iter().all(|count| *count > 0), "otherwise this shows nothing: {found:?}");
    let after = FaceGeometry::of(&mesh, &to).normals;
    assert!(normals.iter().zip(&after).all(|(before, after)| before.dot(*after) > 0.0));
}

#[test]
fn a_step_that_leaves_a_triangle_without_area_is_undone() {
    let from = [DVec3::ZERO, DVec3::X, DVec3::Y];
    let triangle = Surface::new(Topology::new(3, [vec![0, 1, 2]].into_iter().collect()), from.to_vec());
    let mut to = [DVec3::ZERO, DVec3::X, 0.5 * DVec3::X];
    undo_flips(&TriangleMesh::of(&triangle), &[DVec3::Z], &from, &mut to, 0);
    assert_eq!(to, from);
}
