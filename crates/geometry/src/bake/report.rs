//! Report of a bake: errors of the encoded map on the printed carrier.

use super::offsets::Offsets;
use super::{BakeError, VertexDisplacements};
use crate::map::displace::{self, SamplingRule, ShaderVertex};
use crate::map::displacement::{Displacement, Encoding, PageSample, SampleAt, TexelFormat, Weights};
use crate::map::layout_issues::LayoutIssues;
use crate::map::manifest::{
    BitsError, Filtered, HeightsLoss, Layout, Manifest, MapErrors, OwnUvErrors, OwnUvs, PageEntry, Report,
};
use crate::map::pages::Pages;
use crate::map::tangents::Tangent;
use crate::map::{HeightMap, per_vertex};
use crate::mesh::atlas;
use crate::mesh::jagged::Index;
use crate::metrics::percentile;
use crate::source::model::Model;
use crate::source::{Corner, MeshData};
use glam::{DVec3, IVec2, Vec3};
use rayon::prelude::*;
use std::borrow::Cow;

/// Encoded map and printed carrier, with the values that they are compared with.
pub(super) struct Verification<'a> {
    pub(super) model: &'a Model,
    /// Displacements that the map encodes.
    pub(super) displacements: &'a VertexDisplacements,
    /// Tangent frame of each vertex; empty unless the map is in tangent space. #V
    pub(super) frames: &'a [Tangent],
    /// Expected positions of the vertices and expected values of the channels.
    pub(super) offsets: &'a Offsets,
    pub(super) findings: LayoutIssues,
    /// Pages of the map; `None` if it has one image.
    pub(super) pages: Option<&'a Pages>,
    /// Texels of each image before encoding, to compare other numbers of bits. If this is empty, the report keeps the earlier
    /// comparison.
    pub(super) channels: Vec<&'a [HeightMap]>,
    /// Image file of the displacement map, or of each page.
    pub(super) images: Vec<&'a [u8]>,
    /// Carrier, parsed from its printed bytes.
    pub(super) carrier: &'a MeshData,
}

/// Decodes the map, displaces the carrier as a shader does, and compares the result with the expected positions.
pub(super) fn measure(verification: &Verification, manifest: &Manifest) -> Result<Report, BakeError> {
    let entry = &manifest.displacement;
    let map = decode(verification, manifest)?;
    let mesh = Mesh::new(verification, manifest);
    let exact = mesh.errors(&map, Weights::Exact);
    // Clients without texel fetches sample the centre of a texel, so this is what eight-bit weights act on.
    let filtered = mesh.at_texel_centres(&map).errors(&map, Weights::EightBits);
    let map_errors = mesh.map_errors(&map, &verification.offsets.channels);
    let Encoding { scale, .. } = entry.encoding();
    let (quantum, range) = (entry.encoding().quantum(), f64::from(scale));
    let relative = |unit: f64| move |error: f64| (unit > 0.0).then(|| error / unit);
    let (in_quanta, of_range) = (relative(quantum), relative(range));
    let tolerance_quanta = manifest.report.tolerance_quanta;
    // Largest rounding error of blending four texels in single precision.
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
        private_vertices: mesh.private_vertices(manifest),
        own_uvs: (entry.layout == Layout::Uv).then(|| OwnUvs {
            errors: (mesh.private_vertices(manifest) > 0)
                .then(|| mesh.own_uv_errors(verification.carrier, &map, |error| !resolved(&error))),
            ..mesh.own_uvs(verification.carrier, &map)
        }),
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

/// Reads the images back.
fn decode(verification: &Verification, manifest: &Manifest) -> Result<Vec<Displacement>, BakeError> {
    let entry = &manifest.displacement;
    let Some(pages) = &manifest.pages else {
        return Ok(vec![Displacement::decode(verification.images[0], entry.map, entry.size(), entry.encoding())?]);
    };
    let decode = |(page, bytes): (&PageEntry, &&[u8])| {
        Displacement::decode(bytes, entry.map, page.size(), entry.encoding())
            .map_err(|error| BakeError::DecodePage { page: page.part.to_string(), error })
    };
    pages.maps.iter().zip(&verification.images).map(decode).collect()
}

/// Largest error and 99th percentile of ascending errors, model units.
fn summary(errors: &[f64], in_quanta: impl Fn(f64) -> Option<f64>) -> MapErrors {
    let (max, p99) = (errors.last().copied().unwrap_or(0.0), percentile(errors, 0.99));
    MapErrors { max, p99, max_quanta: in_quanta(max), p99_quanta: in_quanta(p99) }
}

/// Largest errors of maps with other numbers of bits. Without texels before encoding these are the errors in the manifest.
/// `max` is the largest error of the map itself, model units.
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
            let encode = |channels: &&[HeightMap]| Displacement::encode(channels, entry.map, other);
            mesh.errors(&verification.channels.iter().map(encode).collect::<Vec<_>>(), Weights::Exact).max
        };
        BitsError { bits: texel.bits(), max_error }
    };
    [TexelFormat::Png8, TexelFormat::Png16, TexelFormat::Exr32].map(error).to_vec()
}

/// Advice that would reduce the errors of the map; `None` if there is nothing to improve.
fn suggestion(manifest: &Manifest, report: &Report) -> Option<String> {
    if report.unresolved_vertices > 0 {
        let layout = &report.layout;
        let remedy =
            if layout.out_of_range_vertices > 0 || layout.overlapping_texels > 0 || layout.unmapped_vertices > 0 {
                "an unwrap without overlaps inside [0, 1]"
            } else {
                "a larger size, or an unwrap with more room"
            };
        return Some(format!("use the layout `vertex`, which is exact; {remedy} would help the layout `uv`"));
    }
    if let Some(heights) = report.heights.filter(HeightsLoss::is_much) {
        return Some(heights.to_string());
    }
    let fine = report.max_error <= report.quantum;
    let coarse = manifest.displacement.texel == TexelFormat::Png8 && fine;
    coarse.then(|| "16 bits a texel would make errors 257 times smaller".to_owned())
}

/// Vertices of the carrier with their expected positions.
#[derive(Clone)]
struct Mesh<'a> {
    model: &'a Model,
    /// Vertices as a shader reads them from the carrier. #v
    vertices: Vec<ShaderVertex>,
    /// Pages that the vertices sample, and where, and the page of each corner of the carrier; `None` if the map has one image.
    paged: Option<Paged<'a>>,
    /// True for each source vertex that some face names; a shader never processes the others. #v
    drawn: Vec<bool>,
    /// Vertices of the surface that are drawn, and the first source vertex of each.
    used: Vec<(Index, usize)>,
    /// Expected position of each vertex. #V×3, model units
    expected: &'a [DVec3],
    origin: DVec3,
    /// Lower left corner of the tile of the texture coordinates.
    tile: IVec2,
}

/// Samples of a map with pages.
#[derive(Clone)]
struct Paged<'a> {
    entries: &'a [PageEntry],
    /// Sample of each source vertex. #v
    samples: Vec<Option<PageSample>>,
    /// Page of each corner of the carrier. #c
    of_corners: Vec<Index>,
}

/// Distances of the displaced vertices from their expected positions, model units.
struct Errors {
    max: f64,
    p99: f64,
    mean: f64,
    /// Largest distance between displaced source vertices of one vertex.
    seam_gap: f64,
    /// Largest absolute coordinate, relative to the origin of the manifest.
    largest: f32,
}

impl<'a> Mesh<'a> {
    fn new(verification: &Verification<'a>, manifest: &'a Manifest) -> Self {
        let Verification { model, carrier, offsets, frames, .. } = *verification;
        let entry = &manifest.displacement;
        let mut vertices = displace::carrier_vertices(carrier, &SamplingRule::of(manifest), entry.origin);
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
        let paged = verification.pages.map(|pages| Paged {
            entries: manifest.page_entries(),
            samples: displace::page_samples(carrier, manifest),
            of_corners: pages.of_corners(carrier),
        });
        for (vertex, sample) in vertices.iter_mut().zip(paged.iter().flat_map(|paged| &paged.samples)) {
            vertex.sample_at = vertex.sample_at.filter(|_| sample.is_some());
        }
        Self {
            model,
            vertices,
            paged,
            drawn,
            used,
            expected: &offsets.positions,
            origin: entry.origin,
            tile: entry.tile,
        }
    }

    /// Copy of these vertices that samples texels by texture coordinates at their centres, not by index.
    fn at_texel_centres(&self, map: &[Displacement]) -> Self {
        if let Some(paged) = &self.paged {
            let at_centre = |PageSample { page, at }: PageSample| match at {
                SampleAt::Texel(texel) => {
                    PageSample { page, at: SampleAt::Uv(per_vertex::uv(texel, map[page as usize].size())) }
                }
                at => PageSample { page, at },
            };
            let samples = paged.samples.iter().map(|sample| sample.map(at_centre)).collect();
            return Self { paged: Some(Paged { samples, ..paged.clone() }), ..self.clone() };
        }
        let at_centre = |vertex: &ShaderVertex| match vertex.sample_at {
            Some(SampleAt::Texel(texel)) => {
                ShaderVertex { sample_at: Some(SampleAt::Uv(per_vertex::uv(texel, map[0].size()))), ..*vertex }
            }
            _ => *vertex,
        };
        let vertices = self.vertices.iter().map(at_centre).collect();
        Self { vertices, ..self.clone() }
    }

    /// The map that the vertices sample: its one image, or the texels that they sample in its pages.
    fn sampled<'b>(&self, map: &'b [Displacement], weights: Weights) -> Cow<'b, Displacement> {
        match &self.paged {
            Some(paged) => Cow::Owned(Displacement::gathered(map, &paged.samples, weights)),
            None => Cow::Borrowed(&map[0]),
        }
    }

    /// Errors of the vertices displaced by a map.
    fn errors(&self, map: &[Displacement], weights: Weights) -> Errors {
        let map = self.sampled(map, weights);
        let displaced: Vec<Vec3> = self.vertices.par_iter().map(|v| v.displaced_with(&map, 1.0, weights)).collect();
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
            largest: displaced
                .iter()
                .zip(&self.drawn)
                .filter(|(_, drawn)| **drawn)
                .fold(0.0, |m: f32, (p, _)| m.max(p.abs().max_element())),
        }
    }

    /// Differences between sampled and expected values of the channels (#V each), ascending, model units.
    fn map_errors(&self, map: &[Displacement], channels: &[Vec<f64>]) -> Vec<f64> {
        let map = self.sampled(map, Weights::Exact);
        let error = |&(v, source): &(Index, usize)| {
            let differences = (0..channels.len()).map(|k| {
                // A vertex without texture coordinates is not displaced.
                let sampled =
                    self.vertices[source].sample_at.map_or(0.0, |place| map.channel_at(k, place, Weights::Exact));
                (f64::from(sampled) - channels[k][v as usize]).abs()
            });
            differences.fold(0.0, f64::max)
        };
        let mut errors: Vec<f64> = self.used.iter().map(error).collect();
        errors.sort_unstable_by(f64::total_cmp);
        errors
    }

    /// Number of vertices of the surface with private texels.
    fn private_vertices(&self, manifest: &Manifest) -> usize {
        let vertex_of = self.model.weld().vertex_of();
        let of_pages = manifest.page_entries().iter().flat_map(|page| &page.private_texels);
        let mut vertices: Vec<Index> =
            of_pages.chain(manifest.private_texels.iter()).map(|texel| vertex_of[texel.vertex as usize - 1]).collect();
        vertices.sort_unstable();
        vertices.dedup();
        vertices.len()
    }

    /// Wedges of the carrier, ascending: a vertex of the surface, page and texture coordinates, and one of the source vertices.
    fn wedges(&self, carrier: &MeshData) -> Vec<(Index, [Index; 2], Index)> {
        let vertex_of = self.model.weld().vertex_of();
        let wedge = |(c, corner): (usize, &Corner)| {
            let page = match &self.paged {
                Some(paged) => paged.of_corners[c],
                None => 0,
            };
            Some((vertex_of[corner.position as usize], [page, corner.uv()?], corner.position))
        };
        let corners = carrier.faces().items().iter().enumerate();
        let mut wedges: Vec<(Index, [Index; 2], Index)> = corners.filter_map(wedge).collect();
        wedges.par_sort_unstable();
        wedges.dedup_by_key(|wedge| (wedge.0, wedge.1));
        wedges
    }

    /// Position of a wedge that samples at its own texture coordinate on the page of its face.
    fn at_own_uv(
        &self,
        carrier: &MeshData,
        map: &[Displacement],
        &(_, [page, uv], source): &(Index, [Index; 2], Index),
    ) -> Vec3 {
        let uv = carrier.uvs()[uv as usize];
        let uv = match &self.paged {
            Some(paged) => paged.entries[page as usize].part.uv_in_image(uv),
            None => atlas::in_tile(uv, self.tile),
        };
        let vertex = ShaderVertex { sample_at: Some(SampleAt::Uv(uv)), ..self.vertices[source as usize] };
        vertex.displaced(&map[page as usize], 1.0)
    }

    /// Errors of wedges that sample at their own texture coordinates.
    fn own_uv_errors(&self, carrier: &MeshData, map: &[Displacement], is_off: impl Fn(f64) -> bool) -> OwnUvErrors {
        let error = |wedge: &(Index, [Index; 2], Index)| {
            let displaced = self.at_own_uv(carrier, map, wedge);
            (wedge.0, (displaced.as_dvec3() + self.origin).distance(self.expected[wedge.0 as usize]))
        };
        let errors: Vec<(Index, f64)> = self.wedges(carrier).par_iter().map(error).collect();
        OwnUvErrors {
            max: errors.iter().fold(0.0, |max, (_, error)| max.max(*error)),
            mean: errors.iter().map(|(_, error)| error).sum::<f64>() / errors.len().max(1) as f64,
            vertices: errors
                .chunk_by(|a, b| a.0 == b.0)
                .filter(|same| same.iter().any(|(_, error)| is_off(*error)))
                .count(),
        }
    }

    /// Gaps that arise at seams if each wedge samples at its own texture coordinates, not at the dominant ones.
    fn own_uvs(&self, carrier: &MeshData, map: &[Displacement]) -> OwnUvs {
        let wedges = self.wedges(carrier);
        let mut found = OwnUvs::default();
        for same in wedges.chunk_by(|a, b| a.0 == b.0) {
            // Equal coordinates are one place, whatever their index.
            let place = |wedge: &(Index, [Index; 2], Index)| {
                let [page, uv] = wedge.1;
                (page, carrier.uvs()[uv as usize].as_vec2())
            };
            if same.iter().all(|wedge| place(wedge) == place(&same[0])) {
                continue;
            }
            let displaced: Vec<Vec3> = same.iter().map(|wedge| self.at_own_uv(carrier, map, wedge)).collect();
            let first = displaced[0];
            let gap = displaced.iter().map(|p| p.distance(first)).fold(0.0, f32::max);
            found.seam_vertices += 1;
            found.bit_equal_seam_vertices += usize::from(displaced.iter().all(|p| *p == first));
            found.seam_gap = found.seam_gap.max(gap.into());
        }
        found
    }
}
