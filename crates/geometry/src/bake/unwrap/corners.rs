//! From corners of triangles to corners of the source, of which each has one place.

use super::GUTTER;
use super::xatlas::Packing;
use crate::mesh::jagged::{Index, Ragged};
use crate::source::model::Model;
use glam::{DVec3, Vec2};

const ABSENT: Index = Index::MAX;

/// Place of each corner of the surface, as an index into the packing; absent where no chart takes its triangles.
/// Second, faces whose corners have several places: a polygon that lies in more than one chart.
pub(super) fn of_surface(model: &Model, packing: &Packing) -> (Vec<Index>, Vec<Index>) {
    let topology = model.surface().topology();
    let mut places = vec![ABSENT; topology.faces().items().len()];
    let mut split = Vec::new();
    for (triangle, found) in model.surface().triangle_corners().iter().zip(packing.corners.as_chunks::<3>().0) {
        for (&corner, &found) in triangle.iter().zip(found) {
            let place = &mut places[corner as usize];
            if packing.vertices[found as usize].chart.is_none() || *place == found {
                continue;
            }
            if *place == ABSENT {
                *place = found;
            } else {
                split.push(topology.face(corner));
            }
        }
    }
    split.dedup();
    (places, split)
}

/// Texture coordinates, and for each corner of the source which one; what is not in the surface (collapsed and repeated
/// faces) and what has no area lies in a chart with its neighbours.
pub(super) fn of_source(model: &Model, packing: &Packing, side: u32) -> (Vec<Vec2>, Vec<Index>) {
    let (places, _) = of_surface(model, packing);
    let topology = model.surface().topology();
    let wedges = (0..).zip(&places).filter(|(_, place)| **place != ABSENT);
    let wedges = Ragged::group(topology.vertex_count(), wedges.map(|(c, &place)| (topology.vertex(c), place)));
    let mut corners = vec![ABSENT; model.data().faces().items().len()];
    for (corner, &place) in (0..).zip(&places) {
        corners[model.source_corner_index(corner) as usize] = place;
    }
    let mut points: Vec<Vec2> = packing.vertices.iter().map(|v| v.at).collect();
    for face in 0..model.data().faces().len() as Index {
        let range = model.data().faces().range(face);
        if corners[range.clone()].contains(&ABSENT) {
            let vertices: Vec<Index> = model.data().faces().get(face).iter().map(|c| vertex(model, *c)).collect();
            complete(model, packing, &wedges, &vertices, &mut corners[range], &mut points);
        }
    }
    // Only what is named, in the order of the source.
    let mut line = vec![ABSENT; points.len()];
    let mut uvs = Vec::new();
    for corner in &mut corners {
        let line = &mut line[*corner as usize];
        if *line == ABSENT {
            *line = uvs.len() as Index;
            uvs.push(((points[*corner as usize] + GUTTER as f32) / side as f32).clamp(Vec2::ZERO, Vec2::ONE));
        }
        *corner = *line;
    }
    (uvs, corners)
}

fn vertex(model: &Model, corner: crate::source::Corner) -> Index {
    model.weld().vertex_of()[corner.position as usize]
}

/// Gives the corners of one face that have no place one: in the chart where most of its vertices are, and where that
/// one lacks a vertex, on the line between its neighbours in the face. A face that knows nobody shrinks to the corner
/// of the map, which is free.
fn complete(
    model: &Model,
    packing: &Packing,
    wedges: &Ragged<Index>,
    vertices: &[Index],
    corners: &mut [Index],
    points: &mut Vec<Vec2>,
) {
    let chart_of = |place: Index| packing.vertices.get(place as usize).and_then(|v| v.chart);
    let in_chart = |v: Index, chart: Index| wedges.get(v).iter().copied().find(|&w| chart_of(w) == Some(chart));
    let known = corners.iter().find_map(|&place| chart_of(place));
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
                let t = along(position(i), position(j), position(k));
                points[at[i] as usize].lerp(points[at[j] as usize], t)
            }
        };
        corners[k] = points.len() as Index;
        points.push(point);
    }
}

/// Where the foot of a point lies on the line from `a` to `b`, 0..=1.
fn along(a: DVec3, b: DVec3, point: DVec3) -> f32 {
    let way = b - a;
    let t = (point - a).dot(way) / way.length_squared();
    if t.is_finite() { t.clamp(0.0, 1.0) as f32 } else { 0.0 }
}
