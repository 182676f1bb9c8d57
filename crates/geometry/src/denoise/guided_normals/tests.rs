use super::*;
use crate::mesh::shapes;
use crate::progress::Silent;

#[test]
fn the_widest_pair_is_found_in_lists_of_any_length() {
    let along = |k: u32| DVec3::new(f64::from(k), 0.0, 1.0);
    for count in 1..8 {
        for first in 0..count {
            let mut normals = PatchNormals::default();
            // Numbers go round, so that the widest pair is at all places in turn.
            (0..count).for_each(|k| normals.push(along((first + k) % count)));
            assert_eq!(normals.widest(), f64::from(count - 1), "{count} {first}");
        }
    }
}

/// Guidance as the module documents it, for all pairs of triangles. #T×3
fn slow_guidance(surface: &Surface) -> Vec<DVec3> {
    let triangles: Vec<_> = surface.triangles().collect();
    let FaceGeometry { normals, areas, .. } = FaceGeometry::of(&TriangleMesh::of(surface), surface.positions());
    let shared = |i: usize, j: usize| triangles[i].iter().filter(|v| triangles[j].contains(v)).count();
    let patch = |i: usize| (0..triangles.len()).filter(|&j| shared(i, j) > 0).collect::<Vec<_>>();
    let inconsistency = |i: usize| {
        let pairs: Vec<_> = patch(i).iter().flat_map(|&j| patch(i).into_iter().map(move |k| (j, k))).collect();
        let apart = |&(j, k): &(usize, usize)| normals[j].distance(normals[k]);
        let widest = pairs.iter().map(apart).fold(0.0, f64::max);
        let edges: Vec<f64> = pairs.iter().filter(|(j, k)| j < k && shared(*j, *k) == 2).map(apart).collect();
        widest * edges.iter().copied().fold(0.0, f64::max) / edges.iter().sum::<f64>()
    };
    let guidance = |i: usize| {
        let best = patch(i).into_iter().min_by(|&j, &k| inconsistency(j).total_cmp(&inconsistency(k))).unwrap();
        patch(best).into_iter().map(|j| normals[j] * areas[j]).sum::<DVec3>().normalize()
    };
    (0..triangles.len()).map(guidance).collect()
}

#[test]
fn the_guidance_is_the_mean_of_the_most_consistent_patch() {
    let surface = shapes::dented_sphere(1);
    let mesh = TriangleMesh::of(&surface);
    let patches = Patches::of(&mesh, &FaceGeometry::of(&mesh, surface.positions()).centroids);
    let mut guidance = Guidance::new(&patches);
    guidance.update(&patches, &FaceGeometry::of(&mesh, surface.positions()));
    for (fast, slow) in guidance.normals.iter().zip(slow_guidance(&surface)) {
        assert!(fast.distance(slow) < 1e-14, "{fast} {slow}");
    }
}

#[test]
fn a_round_is_that_of_the_formula() {
    let surface = shapes::dented_sphere(2);
    let points = surface.positions();
    let triangles: Vec<_> = surface.triangles().collect();
    let mesh = TriangleMesh::of(&surface);
    let FaceGeometry { normals, areas, centroids } = FaceGeometry::of(&mesh, points);
    let spacing = FaceGeometry::of(&mesh, points).mean_centroid_distance(&mesh);
    let guidance = slow_guidance(&surface);
    let settings = GuidedNormals {
        iterations: 1,
        sigma_spatial: 0.8,
        sigma_range: 0.3,
        vertex_update: VertexUpdate::paper(1, Boundary::Free),
        ..GuidedNormals::paper()
    };
    let gaussian = |distance: f64, sigma: f64| (-distance.powi(2) / (2.0 * sigma.powi(2))).exp();
    let near = |i: usize, j: usize| centroids[i].distance(centroids[j]) <= settings.radius * spacing;
    let weight = |i: usize, j: usize| {
        let spatial = gaussian(centroids[i].distance(centroids[j]), settings.sigma_spatial * spacing);
        areas[j] * spatial * gaussian(guidance[i].distance(guidance[j]), settings.sigma_range)
    };
    let all = 0..triangles.len();
    let filtered = |i: usize| {
        let within = all.clone().filter(|&j| near(i, j));
        within.map(|j| normals[j] * weight(i, j)).sum::<DVec3>().normalize()
    };
    let filtered: Vec<DVec3> = all.clone().map(filtered).collect();
    // The vertices take one step of eq. 12 of Sun et al.
    for (v, delta) in deltas(&surface, &settings, &Silent).unwrap().into_iter().enumerate() {
        let around: Vec<usize> = all.clone().filter(|&f| triangles[f].contains(&(v as Index))).collect();
        let pull = |&f: &usize| filtered[f] * filtered[f].dot(centroids[f] - points[v]);
        let step = around.iter().map(pull).sum::<DVec3>() / around.len() as f64;
        assert!(delta.distance(-step) < 1e-14, "{delta} {step}");
    }
}

#[test]
fn a_box_is_a_fixed_point_but_for_triangles_with_three_vertices_on_its_edges() {
    let surface = shapes::gridded_box(6);
    let mesh = TriangleMesh::of(&surface);
    let patches = Patches::of(&mesh, &FaceGeometry::of(&mesh, surface.positions()).centroids);
    let exact = FaceGeometry::of(&mesh, surface.positions());
    let mut guidance = Guidance::new(&patches);
    guidance.update(&patches, &exact);
    // Each patch that such a triangle is in has two sides of the box in it.
    let size = DVec3::new(1.0, 2.0, 3.0);
    let on_edge = |v: &Index| {
        let p = surface.positions()[*v as usize];
        (0..3).filter(|&k| p[k] == 0.0 || p[k] == size[k]).count() > 1
    };
    let mut excepted = 0;
    for (f, n) in guidance.normals.iter().enumerate() {
        if mesh.triangles[f].iter().all(on_edge) {
            excepted += 1;
        } else {
            assert!(n.distance(exact.normals[f]) < 1e-14, "{f}: {n}");
        }
    }
    // There are two on each side.
    assert_eq!(excepted, 12);
}

#[test]
fn an_edge_with_thousands_of_faces_is_filtered_like_any_other() {
    // Pages of a book, each in its plane, which hardly differs from the next. The cube of their number would be too many steps.
    let count = 4000;
    let tip = |k: u32| glam::DVec2::from_angle(f64::from(k) * std::f64::consts::TAU / f64::from(count)).extend(0.5);
    let positions: Vec<DVec3> = [DVec3::ZERO, DVec3::Z].into_iter().chain((0..count).map(tip)).collect();
    let pages = (0..count).map(|k| vec![0, 1, 2 + k]).collect();
    let book = Surface::new(crate::mesh::topology::Topology::new(positions.len(), pages), positions);
    let settings = GuidedNormals { iterations: 3, ..GuidedNormals::default() };
    let found = deltas(&book, &settings, &Silent).unwrap();
    // Pages are a step of 0.0016 apart at their tips, and some look at one page more on one side.
    assert!(found.iter().all(|delta| delta.length() < 0.01), "{found:?}");
}
