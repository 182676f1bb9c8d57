//! Cuts a closed surface into flat charts: few, and each a disk that neither folds nor overlaps.

use crate::chart::Chart;
use crate::flatten::flatten;
use crate::mesh::Mesh;
use crate::segment::Faces;
use std::cmp::Reverse;
use std::collections::BTreeMap;

/// A patch below this share of the aimed area should join a neighbour.
const CRUMB: f64 = 0.6;

/// A set of faces and how they lie flat.
struct Patch {
    faces: Vec<usize>,
    chart: Chart,
}

/// Charts of `mesh`, sorted by group. A chart never crosses from one group of faces to another.
///
/// Patches of about `chart_area` are halved until they lie flat; what that leaves in crumbs is
/// then given back to the neighbours.
pub(crate) fn unwrap(mesh: &Mesh, group_of: &[usize], chart_area: f64) -> Vec<Chart> {
    let faces = Faces::new(mesh);
    let all: Vec<usize> = (0..mesh.triangles.len()).collect();
    let mut patches = Vec::new();
    for region in faces.components(&all, |f| group_of[f]) {
        let count = (faces.area(&region) / chart_area).round().max(1.0) as usize;
        let mut waiting = faces.partition(&region, count);
        while let Some(patch) = waiting.pop() {
            // A lone triangle is always flat, so that halving comes to an end.
            match flatten(mesh, &patch, group_of[patch[0]]) {
                Some(chart) => patches.push(Patch { faces: patch, chart }),
                None => waiting.extend(faces.partition(&patch, 2)),
            }
        }
    }
    while merge_a_crumb(mesh, &faces, &mut patches, CRUMB * chart_area) {}
    let mut charts: Vec<Chart> = patches.into_iter().map(|patch| patch.chart).collect();
    charts.sort_by_key(|chart| chart.group);
    charts
}

/// Joins the smallest patch that can be joined with the neighbour that it shares most edges with.
fn merge_a_crumb(mesh: &Mesh, faces: &Faces, patches: &mut Vec<Patch>, crumb_area: f64) -> bool {
    let mut patch_of = vec![0; mesh.triangles.len()];
    for (k, patch) in patches.iter().enumerate() {
        for &f in &patch.faces {
            patch_of[f] = k;
        }
    }
    let areas: Vec<f64> = patches.iter().map(|patch| faces.area(&patch.faces)).collect();
    let mut crumbs: Vec<usize> = (0..patches.len()).filter(|&k| areas[k] < crumb_area).collect();
    crumbs.sort_by(|&a, &b| areas[a].total_cmp(&areas[b]));
    for k in crumbs {
        let group = patches[k].chart.group;
        let mut shared: BTreeMap<usize, usize> = BTreeMap::new();
        for g in patches[k].faces.iter().flat_map(|&f| faces.across(f)) {
            if patch_of[g] != k && patches[patch_of[g]].chart.group == group {
                *shared.entry(patch_of[g]).or_default() += 1;
            }
        }
        let mut neighbours: Vec<_> = shared.into_iter().collect();
        neighbours.sort_by_key(|&(neighbour, edges)| (Reverse(edges), neighbour));
        for (neighbour, _) in neighbours {
            let mut union = [&patches[k].faces[..], &patches[neighbour].faces].concat();
            union.sort_unstable();
            if let Some(chart) = flatten(mesh, &union, group) {
                patches[neighbour] = Patch { faces: union, chart };
                patches.remove(k);
                return true;
            }
        }
    }
    false
}
