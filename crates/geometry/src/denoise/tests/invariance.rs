//! Laws of invariance: what the result must not depend on.

use super::*;

#[test]
fn deltas_follow_a_similarity_of_the_surface() {
    let (turn, scale, shift) = (DQuat::from_rotation_y(0.7), 3.0, DVec3::new(5.0, -2.0, 1.0));
    for surface in families() {
        let moved = surface.at(surface.positions().iter().map(|p| turn * *p * scale + shift).collect());
        for denoiser in every() {
            let expected: Vec<_> = deltas(&denoiser, &surface).iter().map(|d| turn * *d * scale).collect();
            let gap = largest_gap(&deltas(&denoiser, &moved), &expected);
            assert!(gap < rounding(&denoiser), "{denoiser:?}: {gap:e}");
            let [here, there] = [&surface, &moved].map(|surface| limited(&denoiser, &limits(), surface).0);
            let expected: Vec<_> = here.iter().map(|d| turn * *d * scale).collect();
            let gap = largest_gap(&there, &expected);
            // The volume is restored to 1e-13 of the sum over the triangles.
            assert!(gap < rounding(&denoiser).max(1e-11), "{denoiser:?}: {gap:e}");
        }
    }
}

#[test]
fn a_plane_stays_a_plane_and_its_fixed_boundary_stays_where_it_is() {
    let plane = shapes::grid(8);
    for denoiser in every() {
        for (v, delta) in (0..).zip(deltas(&denoiser, &plane)) {
            assert!(delta.z.abs() < 1e-14, "{denoiser:?}: {delta}");
            if boundary(&denoiser) == Some(Boundary::Fixed) && plane.topology().is_boundary(v) {
                assert_eq!(delta, DVec3::ZERO, "{denoiser:?}");
            }
        }
    }
}

#[test]
fn the_same_surface_gives_the_same_bits_on_any_number_of_threads() {
    let [.., noisy] = families();
    let large = shapes::dented_sphere(4);
    for denoiser in every() {
        // A clean mesh is nothing to choose for.
        let surface = if matches!(denoiser, Denoiser::Auto(_)) { &noisy } else { &large };
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| (deltas(&denoiser, surface), limited(&denoiser, &limits(), surface)))
        };
        let alone = on(1);
        assert!(alone == on(2) && alone == on(7), "{denoiser:?}");
    }
}

/// Mirror image of a surface, with its faces reversed so that they face outwards again.
fn mirrored(surface: &Surface) -> Surface {
    // The first corner stays the first, so that polygons fall into the same triangles.
    let reversed = |face: &[Index]| {
        let mut face = face.to_vec();
        face[1..].reverse();
        face
    };
    let faces = surface.topology().faces().iter().map(reversed).collect();
    let topology = Topology::new(surface.positions().len(), faces);
    Surface::new(topology, surface.positions().iter().map(|p| mirror(*p)).collect())
}

fn mirror(v: DVec3) -> DVec3 {
    DVec3::new(-v.x, v.y, v.z)
}

#[test]
fn a_mirror_image_has_mirrored_deltas() {
    // Noise makes sure that no two patches are equally consistent: between those the order of the triangles decides.
    for clean in families() {
        let surface = displaced(&clean, &white_noise(&clean, 0.1, 5));
        let image = mirrored(&surface);
        for denoiser in every() {
            let expected: Vec<_> = deltas(&denoiser, &surface).into_iter().map(mirror).collect();
            let gap = largest_gap(&deltas(&denoiser, &image), &expected);
            assert!(gap < rounding(&denoiser), "{denoiser:?}: {gap:e}");
        }
    }
}

/// Indices below `count` in a well mixed order, which does not depend on chance.
fn shuffled(count: usize) -> Vec<Index> {
    let mut order: Vec<Index> = (0..count as Index).collect();
    order.sort_by_key(|i| i.wrapping_mul(2_654_435_761));
    order
}

#[test]
fn other_numbers_of_vertices_and_faces_give_the_same_deltas() {
    // There are no polygons, which may fall into other triangles, and there is noise: between patches that are equally
    // consistent and edges that are equally flat the order of the faces may decide.
    for clean in [shapes::dented_sphere(2), shapes::bumpy_sheet(8)] {
        let surface = displaced(&clean, &white_noise(&clean, 0.2, 1));
        let count = surface.positions().len();
        let old_of_new = shuffled(count);
        let mut new_of_old = vec![0; count];
        (0..).zip(&old_of_new).for_each(|(new, &old)| new_of_old[old as usize] = new);
        let faces = surface.topology().faces();
        let renumbered = |f: &Index| {
            let mut face: Vec<Index> = faces.get(*f).iter().map(|&v| new_of_old[v as usize]).collect();
            face.rotate_left(*f as usize % 3);
            face
        };
        let topology = Topology::new(count, shuffled(faces.len()).iter().map(renumbered).collect());
        let permute = |of: &[DVec3]| -> Vec<DVec3> { old_of_new.iter().map(|&old| of[old as usize]).collect() };
        let other = Surface::new(topology, permute(surface.positions()));
        for denoiser in every() {
            let expected = permute(&deltas(&denoiser, &surface));
            let gap = largest_gap(&deltas(&denoiser, &other), &expected);
            let near = match denoiser {
                // Probes are drawn by the numbers of the vertices, so that the shares of the candidates are others.
                Denoiser::Auto(_) => 0.2 * surface.mean_edge(),
                // Clusters begin at the faces with the lowest numbers.
                Denoiser::Learned(_) => 0.2 * surface.mean_edge(),
                _ => rounding(&denoiser),
            };
            assert!(gap < near, "{denoiser:?}: {gap:e}");
        }
    }
}
