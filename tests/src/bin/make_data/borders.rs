//! Bends a mesh's edges onto the borders between the parts of a solid, so that materials change
//! along a smooth line instead of a saw.
//!
//! François Labelle, Jonathan Shewchuk. Isosurface stuffing. SIGGRAPH 2007: where a border crosses
//! an edge, the nearer end is warped onto it; afterwards no edge is crossed any more.

use crate::editable::EditableMesh;
use crate::remesh::{move_unless_folding, quadrilateral_is_convex, tangential_centroid};
use crate::sdf;
use glam::DVec3;

/// Rounds of flipping and relaxing that give the triangles beside a border their shape back.
const ROUNDS: usize = 8;

/// A solid with parts: the zero set of `whole`, coloured by the smallest of `parts`.
pub(crate) struct Solid<Whole, Parts> {
    pub(crate) whole: Whole,
    pub(crate) parts: Parts,
}

impl<const N: usize, Whole: Fn(DVec3) -> f64, Parts: Fn(DVec3) -> [f64; N]> Solid<Whole, Parts> {
    /// The part that a point belongs to.
    pub(crate) fn part_at(&self, p: DVec3) -> usize {
        let distances = (self.parts)(p);
        (1..N).fold(0, |best, k| if distances[k] < distances[best] { k } else { best })
    }

    /// The part that a triangle belongs to: that of its centroid.
    pub(crate) fn part_of(&self, [a, b, c]: [DVec3; 3]) -> usize {
        self.part_at((a + b + c) / 3.0)
    }

    /// Nearby point on the surface and on the border between two parts.
    fn project_to_border(&self, mut p: DVec3, parts: [usize; 2], reach: f64) -> DVec3 {
        let difference = |q: DVec3| {
            let distances = (self.parts)(q);
            distances[parts[0]] - distances[parts[1]]
        };
        for _ in 0..4 {
            p = sdf::project(&difference, p, reach);
            p = sdf::project(&self.whole, p, reach);
        }
        p
    }
}

/// Moves vertices so that no edge joins two parts, except at vertices on their border.
pub(crate) fn fit_borders<const N: usize>(
    mesh: &mut EditableMesh,
    solid: &Solid<impl Fn(DVec3) -> f64, impl Fn(DVec3) -> [f64; N]>,
) {
    let border = warp_onto_borders(mesh, solid);
    for _ in 0..ROUNDS {
        restore_delaunay(mesh, solid);
        for v in mesh.vertices() {
            let place = match border[v] {
                None => tangential_centroid(mesh, &solid.whole, v),
                Some(_) => slide_along_border(mesh, solid, v),
            };
            let reach = mesh.positions[v].distance(place);
            let place = match border[v] {
                None => sdf::project(&solid.whole, place, reach),
                Some(parts) => solid.project_to_border(place, parts, reach),
            };
            move_unless_folding(mesh, v, place);
        }
    }
}

/// Returns the two parts that meet at each vertex, where the vertex was put onto a border.
fn warp_onto_borders<const N: usize>(
    mesh: &mut EditableMesh,
    solid: &Solid<impl Fn(DVec3) -> f64, impl Fn(DVec3) -> [f64; N]>,
) -> Vec<Option<[usize; 2]>> {
    let mut crossings = Vec::new();
    for [a, b] in mesh.edges() {
        let ends = [a, b].map(|v| mesh.positions[v]);
        let parts = ends.map(|p| solid.part_at(p));
        if parts[0] != parts[1] {
            let at = crossing(solid, ends);
            let nearer = if at < 0.5 { a } else { b };
            crossings.push((at.min(1.0 - at), nearer, a + b - nearer, ends[0].lerp(ends[1], at), parts));
        }
    }
    // Nearest first: most of the other crossings are gone before their turn.
    crossings.sort_by(|x, y| x.0.total_cmp(&y.0));
    let mut border = vec![None; mesh.positions.len()];
    for (_, nearer, farther, place, parts) in crossings {
        if border[nearer].is_none() && border[farther].is_none() {
            let reach = mesh.positions[nearer].distance(mesh.positions[farther]);
            mesh.positions[nearer] = solid.project_to_border(place, parts, 0.5 * reach);
            border[nearer] = Some(parts);
        }
    }
    border
}

/// Where along an edge between two parts, 0..1, the first part ends.
fn crossing<const N: usize>(
    solid: &Solid<impl Fn(DVec3) -> f64, impl Fn(DVec3) -> [f64; N]>,
    [a, b]: [DVec3; 2],
) -> f64 {
    let first = solid.part_at(a);
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..30 {
        let middle = 0.5 * (low + high);
        if solid.part_at(a.lerp(b, middle)) == first { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Flips edges inside a part towards larger smallest angles.
fn restore_delaunay<const N: usize>(
    mesh: &mut EditableMesh,
    solid: &Solid<impl Fn(DVec3) -> f64, impl Fn(DVec3) -> [f64; N]>,
) {
    for [a, b] in mesh.edges() {
        let Some([c, d]) = mesh.facing(a, b) else { continue };
        let place = |v: usize| mesh.positions[v];
        let part = |t: [usize; 3]| solid.part_of(t.map(place));
        let parts = [[a, b, c], [b, a, d], [a, d, c], [d, b, c]].map(part);
        let cotangent = |apex: usize| {
            let [u, v] = [place(a) - place(apex), place(b) - place(apex)];
            u.dot(v) / u.cross(v).length().max(1e-12)
        };
        let is_delaunay = cotangent(c) + cotangent(d) >= 0.0;
        if !is_delaunay
            && parts.iter().all(|&p| p == parts[0])
            && mesh.valence(a).min(mesh.valence(b)) > 4
            && quadrilateral_is_convex(mesh, [a, b, c, d])
        {
            mesh.flip([a, b]);
        }
    }
}

/// Mean of the two neighbours along the border; the vertex itself where borders end or fork.
fn slide_along_border<const N: usize>(
    mesh: &EditableMesh,
    solid: &Solid<impl Fn(DVec3) -> f64, impl Fn(DVec3) -> [f64; N]>,
    v: usize,
) -> DVec3 {
    let part = |t: [usize; 3]| solid.part_of(t.map(|v| mesh.positions[v]));
    let is_border = |w: &usize| mesh.facing(v, *w).is_some_and(|[c, d]| part([v, *w, c]) != part([*w, v, d]));
    let along: Vec<_> = mesh.neighbours(v).filter(is_border).collect();
    match along[..] {
        [a, b] => mesh.positions[a].midpoint(mesh.positions[b]),
        _ => mesh.positions[v],
    }
}
