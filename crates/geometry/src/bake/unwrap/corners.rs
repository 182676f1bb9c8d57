//! From packed corners of triangles to corners of the source, each with one texture coordinate.

use super::GUTTER;
use super::xatlas::Packing;
use crate::mesh::jagged::{Index, Ragged};
use crate::source::model::Model;
use glam::{DVec3, Vec2};

/// Index of a corner that no chart contains.
const ABSENT: Index = Index::MAX;

/// Packed vertex of each corner of the surface, [`ABSENT`] where no chart contains its triangles, and the polygons that lie
/// in several charts, so that some corner has several packed vertices.
pub(super) fn of_surface(model: &Model, packing: &Packing) -> (Vec<Index>, Vec<Index>) {
    let topology = model.surface().topology();
    let mut packed = vec![ABSENT; topology.faces().items().len()];
    let mut split = Vec::new();
    for (triangle, found) in model.surface().triangle_corners().iter().zip(packing.corners.as_chunks::<3>().0) {
        for (&corner, &found) in triangle.iter().zip(found) {
            let packed = &mut packed[corner as usize];
            if packing.vertices[found as usize].chart.is_none() || *packed == found {
                continue;
            }
            if *packed == ABSENT {
                *packed = found;
            } else {
                split.push(topology.face(corner));
            }
        }
    }
    split.dedup();
    (packed, split)
}

/// Texture coordinates (#vt×2, v up) and the index of those of each corner of the source (#c).
///
/// Faces that the surface leaves out (collapsed and repeated ones) and faces without area get coordinates in a chart of
/// their neighbours.
pub(super) fn of_source(model: &Model, packing: &Packing, side: u32) -> (Vec<Vec2>, Vec<Index>) {
    let (packed, _) = of_surface(model, packing);
    let topology = model.surface().topology();
    let wedges = (0..).zip(&packed).filter(|(_, packed)| **packed != ABSENT);
    let wedges = Ragged::group(topology.vertex_count(), wedges.map(|(c, &packed)| (topology.vertex(c), packed)));
    let mut corners = vec![ABSENT; model.data().faces().items().len()];
    for (corner, &packed) in (0..).zip(&packed) {
        corners[model.source_corner_index(corner) as usize] = packed;
    }
    let mut points: Vec<Vec2> = packing.vertices.iter().map(|v| v.position).collect();
    for face in 0..model.data().faces().len() as Index {
        let range = model.data().faces().range(face);
        if corners[range.clone()].contains(&ABSENT) {
            let vertices: Vec<Index> = model.data().faces().get(face).iter().map(|c| vertex(model, *c)).collect();
            complete(model, packing, &wedges, &vertices, &mut corners[range], &mut points);
        }
    }
    // Points that some corner uses become texture coordinates, in the order of the source.
    let mut uv_of_point = vec![ABSENT; points.len()];
    let mut uvs = Vec::new();
    for corner in &mut corners {
        let uv = &mut uv_of_point[*corner as usize];
        if *uv == ABSENT {
            *uv = uvs.len() as Index;
            uvs.push(((points[*corner as usize] + GUTTER as f32) / side as f32).clamp(Vec2::ZERO, Vec2::ONE));
        }
        *corner = *uv;
    }
    (uvs, corners)
}

/// Vertex of the surface at a corner of the source.
fn vertex(model: &Model, corner: crate::source::Corner) -> Index {
    model.weld().vertex_of()[corner.position as usize]
}

/// Gives each absent corner of one face a point: that of its vertex in the chart with most vertices of the face, or one on
/// the line between the nearest present corners of the face. A face without any present corner shrinks to the corner of
/// the map, which the gutter keeps free.
fn complete(
    model: &Model,
    packing: &Packing,
    wedges: &Ragged<Index>,
    vertices: &[Index],
    corners: &mut [Index],
    points: &mut Vec<Vec2>,
) {
    let chart_of = |point: Index| packing.vertices.get(point as usize).and_then(|v| v.chart);
    let in_chart = |v: Index, chart: Index| wedges.get(v).iter().copied().find(|&w| chart_of(w) == Some(chart));
    let known = corners.iter().find_map(|&point| chart_of(point));
    let charts = || vertices.iter().flat_map(|&v| wedges.get(v)).filter_map(|&w| chart_of(w));
    let members = |chart: &Index| vertices.iter().filter(|&&v| in_chart(v, *chart).is_some()).count();
    let chart = known.or_else(|| charts().max_by_key(|c| (members(c), std::cmp::Reverse(*c))));
    if let Some(chart) = chart {
        for (corner, &v) in corners.iter_mut().zip(vertices).filter(|(corner, _)| **corner == ABSENT) {
            *corner = in_chart(v, chart).unwrap_or(ABSENT);
        }
    }
    let n = corners.len();
    let at: Vec<Index> = corners.to_vec();
    let position = |k: usize| model.surface().positions()[vertices[k] as usize];
    for k in (0..n).filter(|&k| at[k] == ABSENT) {
        let before = (1..n).map(|d| (k + n - d) % n).find(|&j| at[j] != ABSENT);
        let after = (1..n).map(|d| (k + d) % n).find(|&j| at[j] != ABSENT);
        let point = match before.zip(after) {
            None => Vec2::splat(-(GUTTER as f32)),
            Some((i, j)) => {
                let t = fraction_along(position(i), position(j), position(k));
                points[at[i] as usize].lerp(points[at[j] as usize], t)
            }
        };
        corners[k] = points.len() as Index;
        points.push(point);
    }
}

/// Position of a point's projection on the segment from `a` to `b`, from 0 at `a` to 1 at `b`.
fn fraction_along(a: DVec3, b: DVec3, point: DVec3) -> f32 {
    let direction = b - a;
    let t = (point - a).dot(direction) / direction.length_squared();
    if t.is_finite() { t.clamp(0.0, 1.0) as f32 } else { 0.0 }
}
