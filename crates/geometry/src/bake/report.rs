//! Measures what the written bytes do.

use super::VertexDisplacements;
use super::maps::Offsets;
use crate::map::displace::{self, Places, ShaderVertex};
use crate::map::displacement::{DecodeError, Displacement, Encoding, Place, TexelFormat, Weights};
use crate::map::layout_issues::Findings;
use crate::map::manifest::{BitsError, Filtered, HeightsLoss, Layout, Manifest, MapErrors, OwnUvs, Report};
use crate::map::tangents::Tangent;
use crate::map::{HeightMap, per_vertex};
use crate::mesh::jagged::Index;
use crate::metrics::percentile;
use crate::source::MeshData;
use crate::source::model::Model;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// What is measured.
pub(super) struct Verification<'a> {
    pub(super) model: &'a Model,
    /// Displacements that the map encodes.
    pub(super) displacements: &'a VertexDisplacements,
    /// Frames of the vertices; empty unless the map needs them. #V
    pub(super) frames: &'a [Tangent],
    /// Where the vertices should be, and the numbers that take them there.
    pub(super) offsets: &'a Offsets,
    pub(super) findings: Findings,
    /// Before encoding; where there are none the report keeps what it said about other numbers of bits.
    pub(super) channels: &'a [HeightMap],
    /// The image file.
    pub(super) displacement: &'a [u8],
    /// As read back.
    pub(super) carrier: &'a MeshData,
}

/// Decodes the map and compares what a shader makes of it and the carrier with where the vertices should be.
pub(super) fn measure(verification: &Verification, manifest: &Manifest) -> Result<Report, DecodeError> {
    let entry = &manifest.displacement;
    let map = Displacement::decode(verification.displacement, entry.map, entry.size(), entry.encoding())?;
    let mesh = Mesh::new(verification, manifest);
    let exact = mesh.errors(&map, Weights::Exact);
    let filtered = match entry.layout {
        Layout::Uv => mesh.errors(&map, Weights::EightBits),
        // By the second way to that texel: the sampler at its centre.
        Layout::Vertex => mesh.at_texel_centres(&map).errors(&map, Weights::EightBits),
    };
    let map_errors = mesh.map_errors(&map, &verification.offsets.channels);
    let Encoding { scale, .. } = entry.encoding();
    let (quantum, range) = (entry.encoding().quantum(), f64::from(scale));
    let relative = |unit: f64| move |error: f64| (unit > 0.0).then(|| error / unit);
    let (in_quanta, of_range) = (relative(quantum), relative(range));
    let tolerance_quanta = manifest.report.tolerance_quanta;
    // What blending four texels in single precision may cost.
    let rounding = 4.0 * f64::from(f32::EPSILON) * range;
    let resolved = |error: &f64| *error <= tolerance_quanta * quantum + rounding;
    let Errors { max, p99, mean, seam_gap, largest } = exact;
    let displacements = verification.displacements;
    let loss = displacements.heights.as_ref().map(|heights| heights.1);
    let mut report = Report {
        max_error: max,
        p99_error: p99,
        mean_error: mean,
        error_bound: max + f64::from(largest.next_up() - largest),
        quantum,
        max_error_quanta: in_quanta(max),
        p99_error_quanta: in_quanta(p99),
        mean_error_quanta: in_quanta(mean),
        max_error_range: of_range(max),
        p99_error_range: of_range(p99),
        mean_error_range: of_range(mean),
        seam_gap,
        tolerance_quanta,
        unresolved_vertices: map_errors.len() - map_errors.partition_point(resolved),
        map_errors: summary(&map_errors, in_quanta),
        eight_bit_weights: Filtered { max_error: filtered.max, p99_error: filtered.p99, seam_gap: filtered.seam_gap },
        by_bits: by_bits(verification, manifest, &mesh, max),
        own_uvs: (entry.layout == Layout::Uv).then(|| mesh.own_uvs(verification.carrier, &map)),
        layout: verification.findings.clone(),
        left_out_rms: loss.map_or(0.0, |loss| loss.rms),
        heights: loss.map(HeightsLoss::from),
        limits: displacements.limits,
        vertices_without_normal: mesh
            .used
            .iter()
            .filter(|(v, _)| displacements.normals[*v as usize] == Vec3::ZERO)
            .count(),
        suggestion: None,
    };
    report.suggestion = suggestion(manifest, &report);
    Ok(report)
}

/// Largest error and 99th percentile of ascending errors, model units.
fn summary(errors: &[f64], in_quanta: impl Fn(f64) -> Option<f64>) -> MapErrors {
    let (max, p99) = (errors.last().copied().unwrap_or(0.0), percentile(errors, 0.99));
    MapErrors { max, p99, max_quanta: in_quanta(max), p99_quanta: in_quanta(p99) }
}

/// Errors that maps with other numbers of bits would have, where the unencoded map is there; else what the manifest says
/// of them. `max` is the error of the map as it is, model units.
fn by_bits(verification: &Verification, manifest: &Manifest, mesh: &Mesh, max: f64) -> Vec<BitsError> {
    if verification.channels.is_empty() {
        return manifest.report.by_bits.clone();
    }
    let entry = &manifest.displacement;
    let error = |texel: TexelFormat| {
        let other = Encoding { texel, ..entry.encoding() };
        let max_error = if other == entry.encoding() {
            max
        } else {
            mesh.errors(&Displacement::encode(verification.channels, entry.map, other), Weights::Exact).max
        };
        BitsError { bits: texel.bits(), max_error }
    };
    [TexelFormat::Png8, TexelFormat::Png16, TexelFormat::Exr32].map(error).to_vec()
}

/// What would make the map better, in words.
fn suggestion(manifest: &Manifest, report: &Report) -> Option<String> {
    if report.unresolved_vertices > 0 {
        let layout = &report.layout;
        let cure = if layout.out_of_range_vertices > 0 || layout.overlapping_texels > 0 || layout.unmapped_vertices > 0
        {
            "an unwrap without overlaps inside [0, 1]"
        } else {
            "a larger size, or an unwrap with more room"
        };
        return Some(format!("use the layout `vertex`, which is exact; {cure} would help the layout `uv`"));
    }
    if let Some(heights) = report.heights.filter(HeightsLoss::is_much) {
        return Some(heights.to_string());
    }
    let fine = report.max_error <= report.quantum;
    let coarse = manifest.displacement.texel == TexelFormat::Png8 && fine;
    coarse.then(|| "16 bits a texel would make errors 257 times smaller".to_owned())
}

/// The vertices of the carrier and what is expected of them.
struct Mesh<'a> {
    model: &'a Model,
    /// #v
    vertices: Vec<ShaderVertex>,
    /// Whether some face names the source vertex; of the others a shader hears nothing. #v
    drawn: Vec<bool>,
    /// Vertices of the surface that are drawn, and the first source vertex of each.
    used: Vec<(Index, usize)>,
    /// #V×3, model units
    expected: &'a [DVec3],
    origin: DVec3,
}

/// How far off the vertices are, model units.
struct Errors {
    max: f64,
    p99: f64,
    mean: f64,
    seam_gap: f64,
    /// Largest coordinate.
    largest: f32,
}

impl<'a> Mesh<'a> {
    fn new(verification: &Verification<'a>, manifest: &Manifest) -> Self {
        let Verification { model, carrier, offsets, frames, .. } = *verification;
        let entry = &manifest.displacement;
        let dominant = manifest.dominant_pairs();
        let mut vertices = displace::carrier_vertices(carrier, Places::new(entry.layout, &dominant), entry.origin);
        if !frames.is_empty() {
            for (vertex, frame) in vertices.iter_mut().zip(model.weld().spread(frames)) {
                vertex.tangent = frame;
            }
        }
        let mut drawn = vec![false; vertices.len()];
        for corner in carrier.faces().items() {
            drawn[corner.position as usize] = true;
        }
        let topology = model.surface().topology();
        let mut first = vec![None; topology.vertex_count()];
        for (source, &v) in model.weld().vertex_of().iter().enumerate().filter(|(source, _)| drawn[*source]) {
            first[v as usize].get_or_insert(source);
        }
        let used = (0..topology.vertex_count() as Index).filter(|&v| !topology.is_isolated(v));
        let used = used.filter_map(|v| Some((v, first[v as usize]?))).collect();
        Self { model, vertices, drawn, used, expected: &offsets.places, origin: entry.origin }
    }

    /// The same, sampled at the centres of the texels.
    fn at_texel_centres(&self, map: &Displacement) -> Self {
        let at_centre = |vertex: &ShaderVertex| match vertex.place {
            Some(Place::Texel(texel)) => {
                ShaderVertex { place: Some(Place::Uv(per_vertex::uv(texel, map.size()))), ..*vertex }
            }
            _ => *vertex,
        };
        let vertices = self.vertices.iter().map(at_centre).collect();
        Self { model: self.model, vertices, drawn: self.drawn.clone(), used: self.used.clone(), ..*self }
    }

    fn errors(&self, map: &Displacement, weights: Weights) -> Errors {
        let displaced: Vec<Vec3> = self.vertices.par_iter().map(|v| v.displaced_with(map, 1.0, weights)).collect();
        let mut first = vec![usize::MAX; self.expected.len()];
        for &(v, source) in &self.used {
            first[v as usize] = source;
        }
        let mut seam_gap = 0.0f32;
        for (source, &v) in self.model.weld().vertex_of().iter().enumerate() {
            // Wedges of one source vertex differ in nothing that the shader uses.
            if self.drawn[source] && first[v as usize] < displaced.len() {
                seam_gap = seam_gap.max(displaced[source].distance(displaced[first[v as usize]]));
            }
        }
        let error = |&(v, source): &(Index, usize)| {
            (displaced[source].as_dvec3() + self.origin).distance(self.expected[v as usize])
        };
        let mut sorted: Vec<f64> = self.used.iter().map(error).collect();
        let mean = sorted.iter().sum::<f64>() / sorted.len().max(1) as f64;
        sorted.sort_unstable_by(f64::total_cmp);
        Errors {
            max: sorted.last().copied().unwrap_or(0.0),
            p99: percentile(&sorted, 0.99),
            mean,
            seam_gap: seam_gap.into(),
            largest: displaced.iter().fold(0.0, |m: f32, p| m.max(p.abs().max_element())),
        }
    }

    /// How far the numbers in the map are from those that it was made of (#V for each channel), ascending, model units.
    fn map_errors(&self, map: &Displacement, channels: &[Vec<f64>]) -> Vec<f64> {
        let error = |&(v, source): &(Index, usize)| {
            let off = (0..channels.len()).map(|k| {
                // A vertex that samples nowhere stays.
                let sampled = self.vertices[source].place.map_or(0.0, |place| map.channel_at(k, place, Weights::Exact));
                (f64::from(sampled) - channels[k][v as usize]).abs()
            });
            off.fold(0.0, f64::max)
        };
        let mut errors: Vec<f64> = self.used.iter().map(error).collect();
        errors.sort_unstable_by(f64::total_cmp);
        errors
    }

    /// Lets each wedge sample at its own texture coordinate.
    fn own_uvs(&self, carrier: &MeshData, map: &Displacement) -> OwnUvs {
        let vertex_of = self.model.weld().vertex_of();
        let mut wedges: Vec<(Index, Index, Index)> = carrier
            .faces()
            .items()
            .iter()
            .filter_map(|corner| Some((vertex_of[corner.position as usize], corner.uv()?, corner.position)))
            .collect();
        wedges.par_sort_unstable();
        wedges.dedup_by_key(|wedge| (wedge.0, wedge.1));
        let mut found = OwnUvs::default();
        for same in wedges.chunk_by(|a, b| a.0 == b.0) {
            let landed = same.iter().map(|&(_, uv, source)| {
                let place = Some(Place::Uv(carrier.uvs()[uv as usize].as_vec2()));
                (place, ShaderVertex { place, ..self.vertices[source as usize] }.displaced(map, 1.0))
            });
            let landed: Vec<_> = landed.collect();
            let (place, first) = landed[0];
            if landed.iter().all(|wedge| wedge.0 == place) {
                continue;
            }
            let gap = landed.iter().map(|wedge| wedge.1.distance(first)).fold(0.0, f32::max);
            found.seam_vertices += 1;
            found.bit_equal_seam_vertices += usize::from(landed.iter().all(|wedge| wedge.1 == first));
            found.seam_gap = found.seam_gap.max(gap.into());
        }
        found
    }
}
