//! The page of a map that belongs to one tile.

use super::heights::{MapJob, encoding};
use super::measure::surface_of;
use super::part::Part;
use super::plan::Plan;
use super::records::{Numbers, NumbersOut, read_json, write_json};
use crate::failure::Failure;
use glam::{DVec3, Vec3};
use planish_geometry::denoise::limits::Mask;
use planish_geometry::map::displace::{self, ShaderVertex};
use planish_geometry::map::displacement::{Displacement, Encoding, MapKind, SampleAt, TexelFormat, Weights};
use planish_geometry::map::manifest::sha256;
use planish_geometry::map::{HeightMap, per_vertex};
use planish_geometry::mesh::jagged::Index;
use planish_geometry::metrics::percentile;
use planish_geometry::progress::Progress;
use planish_geometry::source::model::WeldedSurface;
use serde::{Deserialize, Serialize};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};
use std::path::Path;

/// Error of a vertex above which it counts as unresolved, quanta.
pub(super) const TOLERANCE: f64 = 1.0;

/// Formats whose errors a report compares.
const COMPARED: [TexelFormat; 3] = [TexelFormat::Png8, TexelFormat::Png16, TexelFormat::Exr32];

/// Description of a page, with the errors of the vertices that sample it. Lengths are in model units.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct TilePage {
    /// Width and height, texels.
    pub(super) size: [u32; 2],
    pub(super) sha256: String,
    /// Source vertices that sample the page.
    pub(super) vertices: Mask,
    /// Source vertices that have a texel in the page.
    pub(super) texels: Mask,
    /// Number of vertices that are drawn.
    pub(super) drawn: usize,
    /// Largest, 99th percentile and sum of the distances from the exact positions.
    pub(super) errors: Errors,
    /// These distances with weights of 8 bits.
    pub(super) eight_bit_weights: Errors,
    /// Errors of the numbers that vertices sample.
    pub(super) of_map: Errors,
    /// Number of vertices whose numbers are off by more than [`TOLERANCE`].
    pub(super) unresolved: usize,
    /// Largest absolute coordinate after displacement.
    pub(super) largest: f32,
    /// Numbers of bits, and the largest error that each would give.
    pub(super) by_bits: Vec<(u32, f64)>,
}

/// Errors of some vertices.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(super) struct Errors {
    pub(super) max: f64,
    pub(super) p99: f64,
    pub(super) sum: f64,
}

impl Errors {
    fn of(mut errors: Vec<f64>) -> Self {
        errors.sort_unstable_by(f64::total_cmp);
        let Some(max) = errors.last().copied() else { return Self::default() };
        Self { max, p99: percentile(&errors, 0.99), sum: errors.iter().sum() }
    }
}

/// Normal of a source vertex and the numbers that the map holds for it, one for each channel.
struct Record {
    normal: Vec3,
    channels: [f64; 3],
}

fn record(file: &mut Numbers, channels: usize) -> Result<(Index, Record), Failure> {
    let id = file.index()?;
    let mut normal = Vec3::ZERO;
    for axis in 0..3 {
        normal[axis] = f32::from_bits(file.index()?);
    }
    let mut record = Record { normal, channels: [0.0; 3] };
    record.channels[..channels].iter_mut().try_for_each(|x| file.number().map(|number| *x = number))?;
    Ok((id, record))
}

/// Normals of all source vertices in their order, from the files that [`heights`](super::heights()) has written.
pub(super) fn each_normal(
    folder: &Path,
    plan: &Plan,
    job: &MapJob,
    mut take: impl FnMut(Vec3) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let mut files = Vec::with_capacity(plan.tiles.len());
    let mut next = BinaryHeap::new();
    let read = |files: &mut Vec<Numbers>, tile: usize| -> Result<Option<(Index, Record)>, Failure> {
        let file: &mut Numbers = &mut files[tile];
        if file.is_at_end()? { Ok(None) } else { record(file, job.map.planes()).map(Some) }
    };
    let mut found = Vec::with_capacity(plan.tiles.len());
    for tile in 0..plan.tiles.len() {
        files.push(Numbers::open(job.file(folder, tile, "heights"))?);
        found.push(read(&mut files, tile)?);
        next.extend(found[tile].as_ref().map(|(id, _)| Reverse((*id, tile))));
    }
    for v in 0..plan.vertices as Index {
        let this = match next.pop() {
            Some(Reverse((id, tile))) if id == v => {
                let this = std::mem::replace(&mut found[tile], read(&mut files, tile)?);
                next.extend(found[tile].as_ref().map(|(id, _)| Reverse((*id, tile))));
                this
            }
            _ => None,
        };
        let (_, record) = this.ok_or_else(|| Failure::Internal(format!("no tile has vertex {v}")))?;
        take(record.normal)?;
    }
    Ok(())
}

/// Reads the records of the source vertices of a part from the files of their tiles. #v
fn records(folder: &Path, part: &Part, job: &MapJob) -> Result<Vec<Record>, Failure> {
    let mut records: Vec<Option<Record>> = part.ids.iter().map(|_| None).collect();
    for (tile, sources) in part.sources_by_tile() {
        let mut file = Numbers::open(job.file(folder, tile.into(), "heights"))?;
        let mut sources = sources.into_iter().peekable();
        while sources.peek().is_some() && !file.is_at_end()? {
            let (id, record) = record(&mut file, job.map.planes())?;
            if let Some(source) = sources.next_if(|source| part.ids[*source] == id) {
                records[source] = Some(record);
            }
        }
    }
    let missing = |id: Index| Failure::Internal(format!("no tile has vertex {id}"));
    records.into_iter().zip(&part.ids).map(|(record, id)| record.ok_or_else(|| missing(*id))).collect()
}

/// Writes the page of a tile, when [`heights`](super::heights()) is done for all tiles, and measures its errors: with a texel for each
/// vertex of the tile, and for the other vertices of its faces, so that a program can draw the tile with this page alone.
pub fn page(folder: &Path, tile: usize, job: &MapJob, progress: &dyn Progress) -> Result<(), Failure> {
    let path = job.file(folder, tile, "page.json");
    if path.exists() {
        return Ok(());
    }
    let plan = Plan::of(folder)?;
    let encoding = encoding(folder, job)?;
    let part = Part::read(folder, &plan, tile, 1, progress)?;
    let records = records(folder, &part, job)?;
    progress.check()?;
    let texels: Vec<Index> = (0..part.ids.len() as Index).collect();
    let channels: Vec<Vec<f64>> =
        (0..job.map.planes()).map(|k| records.iter().map(|record| record.channels[k]).collect()).collect();
    let maps: Vec<HeightMap> = channels.iter().map(|channel| per_vertex::bake(channel, &texels)).collect();
    let bytes = Displacement::encode(&maps, job.map, encoding).to_bytes().map_err(Failure::internal)?;
    let size = maps[0].size;
    let written = Displacement::decode(&bytes, job.map, size, encoding).map_err(Failure::internal)?;
    let mut file = NumbersOut::create(job.file(folder, tile, "page"))?;
    file.bytes(&bytes)?;
    file.finish()?;

    let check = Check::new(&part, &plan, &records, job.map);
    let displaced = check.displaced(&written, Weights::Exact);
    check.write_border(&displaced, NumbersOut::create(job.file(folder, tile, "border"))?)?;
    let quantum = encoding.quantum();
    let rounding = 4.0 * f64::from(f32::EPSILON) * f64::from(encoding.scale);
    let off = |v: &usize| {
        let number = |k: usize| f64::from(written.channel_at(k, SampleAt::Texel(*v as Index), Weights::Exact));
        (0..channels.len()).map(|k| (number(k) - channels[k][*v]).abs()).fold(0.0, f64::max)
    };
    let of_map: Vec<f64> = check.drawn.iter().map(off).collect();
    let error_with = |texel: TexelFormat| {
        let other = Encoding { texel, ..encoding };
        let max = if other == encoding {
            check.errors(&displaced).max
        } else {
            check.errors(&check.displaced(&Displacement::encode(&maps, job.map, other), Weights::Exact)).max
        };
        (texel.bits(), max)
    };
    let own = || part.ids.iter().zip(&part.rings).filter(|(_, ring)| **ring == 0);
    let page = TilePage {
        size: [size.width, size.height],
        sha256: sha256(&bytes),
        vertices: Mask::of_indices(own().map(|(id, _)| *id)),
        texels: Mask::of_indices(part.ids.iter().copied()),
        drawn: check.drawn.len(),
        errors: check.errors(&displaced),
        eight_bit_weights: check.errors(&check.displaced(&written, Weights::EightBits)),
        unresolved: of_map.iter().filter(|off| **off > TOLERANCE * quantum + rounding).count(),
        of_map: Errors::of(of_map),
        largest: check.drawn.iter().fold(0.0, |most, v| displaced[*v].abs().max_element().max(most)),
        by_bits: COMPARED.map(error_with).to_vec(),
    };
    write_json(&path, &page)
}

/// Source vertices of a part as a shader draws them, and where they should go.
struct Check<'a> {
    part: &'a Part,
    /// Vertices without what they sample. #v
    vertices: Vec<ShaderVertex>,
    /// Exact positions. #v×3
    expected: Vec<DVec3>,
    /// First source vertex of each vertex of the tile that has faces.
    drawn: Vec<usize>,
    origin: DVec3,
}

impl<'a> Check<'a> {
    fn new(part: &'a Part, plan: &Plan, records: &[Record], map: MapKind) -> Self {
        let WeldedSurface { weld, surface, .. } = surface_of(part, plan.welding);
        let origin = displace::origin(plan.bounds);
        let vertices = part.positions.iter().zip(records).map(|(p, record)| ShaderVertex {
            position: (*p - origin).as_vec3(),
            normal: record.normal,
            ..ShaderVertex::default()
        });
        let expected = part.positions.iter().zip(records).map(|(p, record)| match map {
            MapKind::Scalar => *p - record.channels[0] * record.normal.as_dvec3(),
            _ => *p - DVec3::from_array(record.channels),
        });
        let first = weld.first().iter().enumerate();
        let drawn = first.filter(|(v, _)| !surface.topology().is_isolated(*v as Index)).map(|(_, v)| *v as usize);
        Self {
            part,
            vertices: vertices.collect(),
            expected: expected.collect(),
            drawn: drawn.filter(|v| part.rings[*v] == 0).collect(),
            origin,
        }
    }

    /// Positions after displacement, relative to the origin. #v×3
    fn displaced(&self, map: &Displacement, weights: Weights) -> Vec<Vec3> {
        let displaced = |(texel, vertex): (Index, &ShaderVertex)| {
            let at = match weights {
                Weights::Exact => SampleAt::Texel(texel),
                Weights::EightBits => SampleAt::Uv(per_vertex::uv(texel, map.size())),
            };
            ShaderVertex { sample_at: Some(at), ..*vertex }.displaced_with(map, 1.0, weights)
        };
        (0..).zip(&self.vertices).map(displaced).collect()
    }

    fn errors(&self, displaced: &[Vec3]) -> Errors {
        let error = |v: &usize| (displaced[*v].as_dvec3() + self.origin).distance(self.expected[*v]);
        Errors::of(self.drawn.iter().map(error).collect())
    }

    /// Writes where the page puts the vertices that other pages have, too.
    fn write_border(&self, displaced: &[Vec3], mut out: NumbersOut) -> Result<(), Failure> {
        let mut is_shared: Vec<bool> = self.part.rings.iter().map(|ring| *ring > 0).collect();
        for face in self.part.faces.iter() {
            if face.iter().any(|v| self.part.rings[*v as usize] > 0) {
                face.iter().for_each(|v| is_shared[*v as usize] = true);
            }
        }
        for (source, p) in displaced.iter().enumerate().filter(|(source, _)| is_shared[*source]) {
            out.index(self.part.ids[source])?;
            p.to_array().into_iter().try_for_each(|x| out.index(x.to_bits()))?;
        }
        out.finish()
    }
}

/// Largest distance between the places to which two pages put one vertex, model units.
pub(super) fn border_gap(folder: &Path, tiles: usize, job: &MapJob) -> Result<f64, Failure> {
    let mut places: BTreeMap<Index, Vec<Vec3>> = BTreeMap::new();
    for tile in 0..tiles {
        let mut file = Numbers::open(job.file(folder, tile, "border"))?;
        while !file.is_at_end()? {
            let id = file.index()?;
            let mut p = Vec3::ZERO;
            for axis in 0..3 {
                p[axis] = f32::from_bits(file.index()?);
            }
            places.entry(id).or_default().push(p);
        }
    }
    let pairs =
        |places: Vec<Vec3>| places.iter().flat_map(|p| places.iter().map(|q| p.distance(*q))).fold(0.0, f32::max);
    Ok(places.into_values().map(pairs).fold(0.0, f32::max).into())
}

/// Reads the description of the page of a tile.
pub(super) fn page_of(folder: &Path, tile: usize, job: &MapJob) -> Result<TilePage, Failure> {
    read_json(&job.file(folder, tile, "page.json"))
}
