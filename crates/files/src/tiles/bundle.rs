//! The bundle of a mesh in tiles: the pages of its map, its carrier, and the manifest.

use super::heights::{MapJob, TileHeights, encoding};
use super::page::{self, Errors, TilePage};
use super::plan::{self, Plan};
use super::records::{Numbers, NumbersOut, read_json};
use super::write::Pieces;
use super::{PIECE, merge};
use crate::bake_files;
use crate::failure::Failure;
use crate::output::{self, Folder, Staged};
use glam::{DVec3, IVec2, Vec3};
use planish_geometry::denoise::limits::Mask;
use planish_geometry::map::displace;
use planish_geometry::map::displacement::Encoding;
use planish_geometry::map::layout_issues::LayoutIssues;
use planish_geometry::map::manifest::{
    BitsError, Carrier, Clients, FileEntry, Filtered, HeightsLoss, Layout, Manifest, MapEntry, MapErrors, Method,
    PageEntry, PagesEntry, Report, SourceEntry, Target, UvSource, sha256,
};
use planish_geometry::map::pages::{Division, Part};
use planish_geometry::mesh::jagged::Index;
use planish_geometry::progress::Progress;
use planish_geometry::source::materials::{self, MapStatements};
use planish_geometry::source::model::NormalSource;
use planish_geometry::source::obj::{CarrierLines, Obj};
use planish_geometry::source::stream::{Piece, Receiver};
use sha2::{Digest as _, Sha256};
use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};

/// How a mesh in tiles was denoised, as its manifest says it.
#[derive(Clone, Debug)]
pub enum TilesMethod {
    /// A method whose result in tiles is that for the whole mesh, so that whoever checks the map can run it again.
    Method(Box<Method>),
    /// Any other: the denoised mesh becomes a file of the bundle.
    Mesh {
        /// File with the denoised mesh, in the format of the mesh.
        path: PathBuf,
        /// SHA-256 of its bytes, hexadecimal.
        sha256: String,
    },
}

/// Version of the format of manifests that have parts of a mesh that was cut.
const VERSION: u64 = 6;

/// Rule by which a vertex has its page, as it is written to manifests.
const RULE: &str = "part-of-vertex";

/// Writes the bundle of the mesh file at `path` to the folder `out`, when [`page`](super::page()) is done for all tiles: whole or not
/// at all. `source_sha256` is the SHA-256 of the mesh file. Returns the manifest and its name.
pub fn bundle(
    path: &Path,
    (folder, out): (&Path, &Path),
    job: &MapJob,
    method: &TilesMethod,
    source_sha256: &str,
    progress: &dyn Progress,
) -> Result<(Manifest, PathBuf), Failure> {
    progress.stage("writing");
    let plan = Plan::of(folder)?;
    let tiles: Vec<usize> = (0..plan.tiles.len()).filter(|tile| plan.tiles[*tile] > 0).collect();
    let pages: Vec<TilePage> = tiles.iter().map(|tile| page::page_of(folder, *tile, job)).collect::<Result<_, _>>()?;
    let target = Folder::open(out)?;
    let names = bake_files::names(path, out, bake_files::stem(path)?);
    let encoding = encoding(folder, job)?;
    let entries = PagesEntry {
        by: Division::Cut,
        rule: RULE.to_owned(),
        maps: tiles.iter().zip(&pages).map(|(tile, page)| page_entry(&names.stem, *tile, page, job)).collect(),
    };
    let extension = path.extension().map_or_else(|| "ply".into(), |e| e.to_string_lossy().to_lowercase());
    let denoised = format!("{}.denoised.{extension}", names.stem);
    let first = entries.maps.first().ok_or_else(|| Failure::at(path, "has no vertices"))?;
    let mut manifest = Manifest {
        planish: VERSION,
        source: SourceEntry {
            file: names.source,
            sha256: source_sha256.to_owned(),
            vertices: plan.vertices,
            faces: plan.faces,
        },
        method: match method {
            TilesMethod::Method(method) => (**method).clone(),
            TilesMethod::Mesh { sha256, .. } => Method::Target(Target::new(denoised.clone(), sha256.clone())),
        },
        choice: None,
        welding: plan.welding,
        normals: NormalSource::Angle.into(),
        displacement: map_entry(first, job, encoding, displace::origin(plan.bounds)),
        dominant_uv: None,
        private_texels: Vec::new(),
        backs: Mask::default(),
        pages: Some(entries),
        normal_map: None,
        occlusion: None,
        curvature: None,
        carrier: Carrier {
            obj: format!("{}.obj", names.carrier),
            mtl: format!("{}.mtl", names.carrier),
            glb: None,
            sha256: String::new(),
        },
        files: Vec::new(),
        report: report(folder, &plan, &pages, job, encoding)?,
        clients: Clients::new(job.map, NormalSource::Angle.into(), encoding, job.lambda),
    };
    let mut new: Vec<PathBuf> = manifest.page_entries().iter().map(|page| PathBuf::from(&page.file)).collect();
    if let TilesMethod::Mesh { .. } = method {
        new.push(denoised.clone().into());
    }
    let of_manifest = PathBuf::from(format!("{}.planish.json", names.stem));
    new.extend([manifest.carrier.obj.clone().into(), manifest.carrier.mtl.clone().into(), of_manifest.clone()]);
    let new: Vec<&Path> = new.iter().map(PathBuf::as_path).collect();
    new.iter().try_for_each(|name| output::refuse_overwrite(&out.join(name), &[path]))?;
    let earlier =
        || bake_files::earlier(&out.join(&of_manifest), out, |name| new.iter().any(|new| *new == Path::new(name)));
    let stage = |out: &Path| {
        let mut staged = Vec::new();
        let files: Vec<String> = manifest.page_entries().iter().map(|page| page.file.clone()).collect();
        for ((tile, page), name) in tiles.iter().zip(&pages).zip(files) {
            staged.push(copy(&job.file(folder, *tile, "page"), &out.join(&name))?);
            manifest.files.push(FileEntry { file: name, sha256: page.sha256.clone() });
        }
        if let TilesMethod::Mesh { path, sha256 } = method {
            staged.push(copy(path, &out.join(&denoised))?);
            manifest.files.push(FileEntry { file: denoised.clone(), sha256: sha256.clone() });
        }
        let (obj, mtl) = (manifest.carrier.obj.clone(), manifest.carrier.mtl.clone());
        let (carrier, digest) = carrier(path, folder, &plan, job, (&out.join(&obj), &mtl), progress)?;
        staged.push(carrier);
        manifest.carrier.sha256.clone_from(&digest);
        manifest.files.push(FileEntry { file: obj, sha256: digest });
        let library = library()?;
        staged.push(Staged::new(&out.join(&mtl), [library.as_slice()])?);
        manifest.files.push(FileEntry { file: mtl, sha256: sha256(&library) });
        let json = manifest.to_json();
        Manifest::from_json(json.as_bytes()).map_err(|e| Failure::at(path, format!("cannot be measured: {e}")))?;
        staged.push(Staged::new(&out.join(&of_manifest), [json.as_bytes()])?);
        Ok(staged)
    };
    target.write_staged(&new, earlier, |_, _| false, stage)?;
    Ok((manifest, of_manifest))
}

fn page_entry(stem: &str, tile: usize, page: &TilePage, job: &MapJob) -> PageEntry {
    let [width, height] = page.size;
    PageEntry {
        part: Part::Cut(tile as u32),
        file: format!("{stem}.displacement.{tile}.{}", job.texel.file().extension()),
        width,
        height,
        normal_map: None,
        vertices: page.vertices.clone(),
        texels: page.texels.clone(),
        seam_vertices: Vec::new(),
        private_texels: Vec::new(),
    }
}

fn map_entry(first: &PageEntry, job: &MapJob, encoding: Encoding, origin: DVec3) -> MapEntry {
    MapEntry {
        file: first.file.clone(),
        map: job.map,
        layout: Layout::Vertex,
        interpolation: None,
        texels: None,
        uvs: UvSource::Mesh,
        tile: IVec2::ZERO,
        width: first.width,
        height: first.height,
        texel: job.texel,
        bias: encoding.bias.into(),
        scale: encoding.scale.into(),
        lambda: job.lambda,
        origin,
    }
}

/// Report on all pages. A percentile is the largest of those of the pages, of which it is an upper bound.
fn report(folder: &Path, plan: &Plan, pages: &[TilePage], job: &MapJob, encoding: Encoding) -> Result<Report, Failure> {
    let heights = (0..plan.tiles.len()).map(|tile| read_json(&job.file(folder, tile, "heights.json")));
    let heights: Vec<TileHeights> = heights.collect::<Result<_, _>>()?;
    let most = |of: &dyn Fn(&TilePage) -> f64| pages.iter().map(of).fold(0.0, f64::max);
    let all = |errors: &dyn Fn(&TilePage) -> Errors| Errors {
        max: most(&|page| errors(page).max),
        p99: most(&|page| errors(page).p99),
        sum: pages.iter().map(|page| errors(page).sum).sum(),
    };
    let (errors, of_map, filtered) =
        (all(&|page| page.errors), all(&|page| page.of_map), all(&|page| page.eight_bit_weights));
    let drawn = pages.iter().map(|page| page.drawn).sum::<usize>().max(1) as f64;
    let largest = pages.iter().map(|page| page.largest).fold(0.0, f32::max);
    let gap = page::border_gap(folder, plan.tiles.len(), job)?;
    let (quantum, range) = (encoding.quantum(), f64::from(encoding.scale));
    let relative = |unit: f64| move |error: f64| (unit > 0.0).then(|| error / unit);
    let (in_quanta, of_range) = (relative(quantum), relative(range));
    let mean = errors.sum / drawn;
    let sum = |of: &dyn Fn(&TileHeights) -> f64| heights.iter().map(of).sum::<f64>();
    let triangles = sum(&|tile| tile.triangles as f64).max(1.0);
    let is_scalar = job.map.planes() == 1;
    let loss = is_scalar.then(|| HeightsLoss {
        rotation_deg: sum(&|tile| tile.turned) / triangles,
        lost_deg: sum(&|tile| tile.lost) / triangles,
        tilted: 0.0,
    });
    let texels: f64 = pages.iter().map(|page| f64::from(page.size[0]) * f64::from(page.size[1])).sum();
    let by_bits = pages.first().map_or(&[][..], |page| &page.by_bits).iter().enumerate();
    Ok(Report {
        max_error: errors.max,
        p99_error: errors.p99,
        mean_error: mean,
        error_bound: errors.max + f64::from(largest.next_up() - largest),
        quantum,
        max_error_quanta: in_quanta(errors.max),
        p99_error_quanta: in_quanta(errors.p99),
        mean_error_quanta: in_quanta(mean),
        max_error_range: of_range(errors.max),
        p99_error_range: of_range(errors.p99),
        mean_error_range: of_range(mean),
        seam_gap: gap,
        map_errors: MapErrors {
            max: of_map.max,
            p99: of_map.p99,
            max_quanta: in_quanta(of_map.max),
            p99_quanta: in_quanta(of_map.p99),
        },
        tolerance_quanta: page::TOLERANCE,
        unresolved_vertices: pages.iter().map(|page| page.unresolved).sum(),
        eight_bit_weights: Filtered { max_error: filtered.max, p99_error: filtered.p99, seam_gap: gap },
        by_bits: by_bits
            .map(|(k, (bits, _))| BitsError { bits: *bits, max_error: most(&|page| page.by_bits[k].1) })
            .collect(),
        layout: LayoutIssues { coverage: plan.vertices as f64 / texels, ..LayoutIssues::default() },
        left_out_rms: if is_scalar {
            (sum(&|tile| tile.left_out) / sum(&|tile| tile.vertices as f64).max(1.0)).sqrt()
        } else {
            0.0
        },
        heights: loss,
        vertices_without_normal: heights.iter().map(|tile| tile.without_normal).sum(),
        suggestion: loss.filter(HeightsLoss::is_much).map(|loss| loss.to_string()),
        ..Report::default()
    })
}

/// Copies a file piece by piece under a temporary name.
fn copy(from: &Path, to: &Path) -> Result<Staged, Failure> {
    let failed = |e: std::io::Error| Failure::internal(format!("{}: {e}", from.display()));
    let (file, mut staged, mut bytes) = (File::open(from).map_err(failed)?, Staged::begin(to)?, Vec::new());
    loop {
        bytes.clear();
        if (&file).take(PIECE as u64).read_to_end(&mut bytes).map_err(failed)? == 0 {
            staged.settle()?;
            return Ok(staged);
        }
        staged.append(&bytes)?;
    }
}

/// A carrier that is written piece by piece.
struct CarrierFile {
    lines: CarrierLines,
    staged: Staged,
    digest: Sha256,
    failure: Option<Failure>,
}

impl CarrierFile {
    /// Hands on what has been printed, once there is a piece of it.
    fn flush(&mut self, at: usize) -> Result<(), Failure> {
        if self.lines.len() < at {
            return Ok(());
        }
        let bytes = self.lines.take();
        self.digest.update(&bytes);
        self.staged.append(&bytes)
    }
}

impl Receiver for CarrierFile {
    fn vertex(&mut self, _: DVec3) {}

    fn face(&mut self, vertices: &[Index]) {
        self.lines.face(vertices);
        if let Err(e) = self.flush(PIECE) {
            self.failure.get_or_insert(e);
        }
    }
}

/// Writes the carrier under a temporary name, and returns it with its SHA-256, hexadecimal.
fn carrier(
    path: &Path,
    folder: &Path,
    plan: &Plan,
    job: &MapJob,
    (to, library): (&Path, &str),
    progress: &dyn Progress,
) -> Result<(Staged, String), Failure> {
    let mut out = CarrierFile {
        lines: CarrierLines::begin(library),
        staged: Staged::begin(to)?,
        digest: Sha256::new(),
        failure: None,
    };
    let mut positions = Numbers::open(plan::positions(folder))?;
    for _ in 0..plan.vertices {
        out.lines.position(positions.position()?);
        out.flush(PIECE)?;
    }
    progress.check()?;
    page::each_normal(folder, plan, job, |n| {
        // A vertex without a normal has height 0, and client programs would normalise a zero vector to NaN.
        out.lines.normal(if n == Vec3::ZERO { Vec3::Z } else { n });
        out.flush(PIECE)
    })?;
    let mut pieces = Pieces::open(path)?;
    pieces.each(progress, |stream, bytes, is_last| {
        let taken = stream.read(Piece { bytes, is_last }, &mut out).map_err(|e| Failure::at(path, e))?;
        out.failure.take().map_or(Ok(taken), Err)
    })?;
    out.flush(0)?;
    out.staged.settle()?;
    Ok((out.staged, out.digest.finalize().iter().map(|byte| format!("{byte:02x}")).collect()))
}

/// Material library of the carrier. A material has one texture, so it names no page.
fn library() -> Result<Vec<u8>, Failure> {
    let triangle = Obj::parse(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".to_vec()).map_err(Failure::internal)?;
    Ok(materials::carrier_library(triangle.data(), &[], |_| MapStatements::default(), str::to_owned))
}

/// Takes the denoised positions from a mesh file that [`write`](super::write()) has written, rounded as they are there, so that a map
/// leads to them.
pub fn take_positions(path: &Path, folder: &Path, progress: &dyn Progress) -> Result<(), Failure> {
    struct Positions {
        out: NumbersOut,
        count: usize,
        failure: Option<Failure>,
    }
    impl Receiver for Positions {
        fn vertex(&mut self, position: DVec3) {
            self.count += 1;
            if let Err(e) = self.out.position(position) {
                self.failure.get_or_insert(e);
            }
        }
        fn face(&mut self, _: &[Index]) {}
    }
    let vertices = Plan::of(folder)?.vertices;
    let mut to = Positions { out: NumbersOut::create(merge::positions(folder))?, count: 0, failure: None };
    let mut pieces = Pieces::open(path)?;
    pieces.each(progress, |stream, bytes, is_last| {
        let taken = stream.read(Piece { bytes, is_last }, &mut to).map_err(|e| Failure::at(path, e))?;
        to.failure.take().map_or(Ok(taken), Err)
    })?;
    if to.count != vertices {
        return Err(Failure::Internal(format!("{} has {} vertices, not {vertices}", path.display(), to.count)));
    }
    to.out.finish()
}
