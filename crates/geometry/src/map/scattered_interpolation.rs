//! Scattered data interpolation of heights over the texture.

use super::Interpolation;
use crate::mesh::atlas::Atlas;
use crate::mesh::jagged::Index;
use glam::DVec2;
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use spade::handles::{FixedDirectedEdgeHandle, FixedFaceHandle, FixedVertexHandle, InnerTag};
use spade::{
    DelaunayTriangulation, HasPosition, HintGenerator, NaturalNeighbor, Point2, PositionInTriangulation, Triangulation,
};
use std::cell::Cell;
use std::num::NonZero;

/// Number of neighbours in inverse distance weighting.
const NEIGHBOURS: NonZero<usize> = NonZero::new(8).expect("eight is not zero");

/// A height at a texture coordinate.
#[derive(Clone, Copy, Debug)]
struct Site {
    uv: DVec2,
    height: f64,
}

impl HasPosition for Site {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        Point2::new(self.uv.x, self.uv.y)
    }
}

type Delaunay = DelaunayTriangulation<Site, (), (), (), GridHint>;

/// Scattered samples with their triangulation and search tree.
pub(super) struct ScatteredInterpolation {
    sites: Vec<Site>,
    tree: ImmutableKdTree<f64, 2>,
    delaunay: Delaunay,
}

impl ScatteredInterpolation {
    /// Takes the heights (#V) of the vertices behind the given uv vertices. Where several vertices share a uv vertex
    /// the first one wins.
    pub(super) fn new(atlas: &Atlas, heights: &[f64], uv_vertices: &[Index], interpolation: Interpolation) -> Self {
        let mut height_of = vec![None; atlas.uvs().len()];
        for (vertex, wedges) in atlas.wedges().iter().enumerate() {
            for &uv in wedges {
                height_of[uv as usize].get_or_insert(heights[vertex]);
            }
        }
        let site =
            |&uv: &Index| Some(Site { uv: representable(atlas.uvs()[uv as usize]), height: height_of[uv as usize]? });
        let sites: Vec<Site> = uv_vertices.iter().filter_map(site).collect();
        let points: Vec<[f64; 2]> = sites.iter().map(|s| s.uv.to_array()).collect();
        let needs_triangles = matches!(interpolation, Interpolation::Barycentric | Interpolation::Natural);
        let delaunay = if needs_triangles { Delaunay::bulk_load(sites.clone()) } else { Ok(Delaunay::new()) };
        Self {
            // Both fail only for coordinates that are not finite, or too small or large; there are none left.
            delaunay: delaunay.unwrap_or_default(),
            tree: ImmutableKdTree::new_from_slice(&points).unwrap_or_default(),
            sites,
        }
    }

    /// Makes a sampler with buffers of its own; each thread needs one.
    pub(super) fn sampler(&self) -> Sampler<'_> {
        Sampler { interpolation: self, natural: self.delaunay.natural_neighbor(), last: Cell::new(Last::Nowhere) }
    }

    /// Height of the nearest sample; 0 without any samples.
    pub(super) fn nearest(&self, uv: DVec2) -> f64 {
        if self.sites.is_empty() {
            return 0.0;
        }
        let found = self.tree.query(&uv.to_array()).nearest_one::<SquaredEuclidean<f64>>().execute();
        self.sites[found.item as usize].height
    }

    /// Mean of the nearest samples, weighted by 1/distance²; at a sample, its height.
    pub(super) fn inverse_distance(&self, uv: DVec2) -> f64 {
        if self.sites.is_empty() {
            return 0.0;
        }
        let near = self.tree.query(&uv.to_array()).nearest_n::<SquaredEuclidean<f64>>(NEIGHBOURS).execute();
        let (mut sum, mut total) = (0.0, 0.0);
        for neighbour in near {
            let height = self.sites[neighbour.item as usize].height;
            if neighbour.distance == 0.0 {
                return height;
            }
            sum += height / neighbour.distance;
            total += 1.0 / neighbour.distance;
        }
        sum / total
    }
}

/// Interpolates within one [`ScatteredInterpolation`]; successive queries near each other are the fastest.
pub(super) struct Sampler<'a> {
    interpolation: &'a ScatteredInterpolation,
    natural: NaturalNeighbor<'a, Delaunay>,
    /// Triangle or hull edge of the last query, which is tried first. An answer depends on its query alone: an interior point
    /// of a triangle, or of the strip outside a hull edge, is in no other.
    last: Cell<Last>,
}

#[derive(Clone, Copy)]
enum Last {
    Nowhere,
    Inside(FixedFaceHandle<InnerTag>),
    Outside(FixedDirectedEdgeHandle),
}

impl Sampler<'_> {
    /// Linear interpolation on the Delaunay triangulation, constant away from its hull.
    pub(super) fn linear(&self, uv: DVec2) -> f64 {
        let delaunay = &self.interpolation.delaunay;
        match self.last.get() {
            Last::Inside(face) => {
                let weights = self.weights(face, uv);
                if weights.iter().all(|&w| w > 1e-9) {
                    return self.in_face(face, weights);
                }
            }
            Last::Outside(edge) => {
                let (projection, height) = self.project_to_hull(edge, uv);
                if projection.is_some() {
                    return height;
                }
            }
            Last::Nowhere => {}
        }
        match delaunay.locate(Point2::new(uv.x, uv.y)) {
            PositionInTriangulation::OnFace(face) => {
                self.last.set(Last::Inside(face));
                self.in_face(face, self.weights(face, uv))
            }
            PositionInTriangulation::OnVertex(vertex) => delaunay.vertex(vertex).data().height,
            PositionInTriangulation::OnEdge(edge) => self.on_edge(edge, uv).1,
            PositionInTriangulation::OutsideOfConvexHull(seen) => self.outside(seen, uv),
            // Fewer than three samples, or all on a line.
            PositionInTriangulation::NoTriangulation => self.interpolation.nearest(uv),
        }
    }
    /// Natural neighbour interpolation (Sibson), constant away from the hull.
    pub(super) fn natural(&self, uv: DVec2) -> f64 {
        let height = self.natural.interpolate(|site| site.data().height, Point2::new(uv.x, uv.y));
        height.unwrap_or_else(|| self.linear(uv))
    }
    fn weights(&self, face: FixedFaceHandle<InnerTag>, uv: DVec2) -> [f64; 3] {
        self.interpolation.delaunay.face(face).barycentric_interpolation(Point2::new(uv.x, uv.y))
    }
    fn in_face(&self, face: FixedFaceHandle<InnerTag>, weights: [f64; 3]) -> f64 {
        let heights = self.interpolation.delaunay.face(face).vertices().map(|v| v.data().height);
        heights.iter().zip(weights).map(|(h, w)| h * w).sum()
    }
    /// Height at the point of the hull nearest to a point outside, given an edge that is visible from there.
    fn outside(&self, seen: FixedDirectedEdgeHandle, uv: DVec2) -> f64 {
        let delaunay = &self.interpolation.delaunay;
        // The hull is convex, so the distance falls along it towards the nearest edge and rises behind.
        let (mut edge, mut best) = (seen, self.on_edge(seen, uv));
        for forwards in [true, false] {
            loop {
                let here = delaunay.directed_edge(edge);
                let next = if forwards { here.next() } else { here.prev() }.fix();
                let there = self.on_edge(next, uv);
                if there.0 >= best.0 {
                    break;
                }
                (edge, best) = (next, there);
            }
        }
        self.last.set(Last::Outside(edge));
        best.1
    }
    /// Squared distance to an edge, and the height at the nearest point of it.
    fn on_edge(&self, edge: FixedDirectedEdgeHandle, uv: DVec2) -> (f64, f64) {
        let [a, b] = self.ends(edge);
        let direction = b.uv - a.uv;
        let t = ((uv - a.uv).dot(direction) / direction.length_squared()).clamp(0.0, 1.0);
        ((a.uv + direction * t).distance_squared(uv), a.height + (b.height - a.height) * t)
    }
    /// Parameter of the projection of a point onto a hull edge, and the height there; `None` unless the projection is well
    /// between the ends and the point well outside the hull.
    fn project_to_hull(&self, edge: FixedDirectedEdgeHandle, uv: DVec2) -> (Option<f64>, f64) {
        let [a, b] = self.ends(edge);
        let direction = b.uv - a.uv;
        let t = (uv - a.uv).dot(direction) / direction.length_squared();
        // The outer face is on the left of a hull edge.
        let outside = direction.perp_dot(uv - a.uv) > 1e-9 * direction.length_squared();
        ((outside && 1e-9 < t && t < 1.0 - 1e-9).then_some(t), a.height + (b.height - a.height) * t)
    }
    fn ends(&self, edge: FixedDirectedEdgeHandle) -> [Site; 2] {
        self.interpolation.delaunay.directed_edge(edge).vertices().map(|v| *v.data())
    }
}

/// Coordinates that the triangulation takes: it refuses tiny and huge ones, which mean 0 and "far away".
fn representable(uv: DVec2) -> DVec2 {
    let tame = |x: f64| if x.abs() < 1e-30 { 0.0 } else { x.clamp(-1e30, 1e30) };
    DVec2::new(tame(uv.x), tame(uv.y))
}

/// Starting points for walks through the triangulation, from a grid over its bounds.
///
/// spade's own hints remember the last query, and then what a query rounds to would depend on what other threads ask.
#[derive(Clone, Debug, Default)]
struct GridHint {
    low: DVec2,
    cells_per_unit: DVec2,
    side: usize,
    nearest: Vec<u32>,
}

impl GridHint {
    fn cell(&self, p: Point2<f64>) -> [usize; 2] {
        let at = (DVec2::new(p.x, p.y) - self.low) * self.cells_per_unit;
        // `as` saturates, so that points outside get the hint at the border.
        [at.x, at.y].map(|x| (x as usize).min(self.side - 1))
    }
}

impl HintGenerator<f64> for GridHint {
    fn get_hint(&self, position: Point2<f64>) -> FixedVertexHandle {
        if self.side == 0 {
            return FixedVertexHandle::from_index(0);
        }
        let [x, y] = self.cell(position);
        FixedVertexHandle::from_index(self.nearest[y * self.side + x] as usize)
    }
    fn notify_vertex_lookup(&self, _: FixedVertexHandle) {}
    fn notify_vertex_inserted(&mut self, _: FixedVertexHandle, _: Point2<f64>) {}
    fn notify_vertex_removed(&mut self, _: Option<Point2<f64>>, _: FixedVertexHandle, _: Point2<f64>) {}

    fn initialize_from_triangulation<TR, V>(triangulation: &TR) -> Self
    where
        TR: Triangulation<Vertex = V>,
        V: HasPosition<Scalar = f64>,
    {
        const EMPTY: u32 = u32::MAX;
        let points = || triangulation.vertices().map(|v| (v.fix().index() as u32, v.position()));
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for (_, p) in points() {
            low = low.min(DVec2::new(p.x, p.y));
            high = high.max(DVec2::new(p.x, p.y));
        }
        let side = (triangulation.num_vertices() as f64).sqrt().ceil() as usize;
        let cells_per_unit = DVec2::splat(side as f64) / (high - low).max(DVec2::splat(f64::MIN_POSITIVE));
        let mut hint = Self { low, cells_per_unit, side, nearest: vec![EMPTY; side * side] };
        for (vertex, p) in points() {
            let [x, y] = hint.cell(p);
            hint.nearest[y * side + x] = vertex;
        }
        // Empty cells get the vertex of a neighbour in their row, empty rows those of the row before.
        let mut last_row = vec![0; side];
        for row in hint.nearest.chunks_mut(side.max(1)) {
            match row.iter().copied().find(|&vertex| vertex != EMPTY) {
                None => row.copy_from_slice(&last_row),
                Some(mut last) => {
                    for cell in row.iter_mut() {
                        if *cell == EMPTY {
                            *cell = last;
                        }
                        last = *cell;
                    }
                }
            }
            last_row.copy_from_slice(row);
        }
        hint
    }
}
