//! Makes the samples to which a network of the learned filter is fitted (see `training/README.md`).
//!
//! ```text
//! cargo run --release -p planish-geometry --example learned_samples -- FOLDER OUTPUT [--weights FILE]
//!     [--draws N] [--rows N] [--seed N] [--others FOLDER [--make-others]]
//! ```
//!
//! FOLDER holds clean meshes, OBJ. Pieces of each are disturbed by noise of all kinds. `OUTPUT.features.npy` has the features of their
//! faces as the network after those of the weights sees them, `OUTPUT.targets.npy` the true normals in the frames of the faces, and the
//! number of the piece, and `OUTPUT.pieces.txt` the name and the noise of each piece.
//!
//! With `--others`, the samples are those of the network that mixes in what `auto` finds without it. The displacements that it finds
//! are read from that folder, where `--make-others` writes them; pieces without any are left out.

mod npy;

use glam::{DVec3, Vec3};
use planish_geometry::denoise::auto::without_learned;
use planish_geometry::denoise::{Auto, FaceSamples, LearnedWeights, learned_samples};
use planish_geometry::mesh::jagged::{Index, Ragged};
use planish_geometry::mesh::surface::Surface;
use planish_geometry::mesh::synthetic_noise::{Direction, Disturbed, SyntheticKind, SyntheticNoise, disturb};
use planish_geometry::mesh::topology::Topology;
use planish_geometry::mesh::weld::Welding;
use planish_geometry::progress::Silent;
use planish_geometry::source::model::Model;
use planish_geometry::source::obj::Obj;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::error::Error;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Number of faces of a piece.
const PIECE: usize = 3500;

/// How often each kind of noise is drawn; none stands for a clean surface.
const KINDS: [(Option<SyntheticKind>, f64); 13] = [
    (None, 0.12),
    (Some(SyntheticKind::White), 0.28),
    (Some(SyntheticKind::Impulsive), 0.07),
    (Some(SyntheticKind::Correlated), 0.16),
    (Some(SyntheticKind::Rounded), 0.06),
    (Some(SyntheticKind::Camera), 0.06),
    (Some(SyntheticKind::Fade), 0.04),
    (Some(SyntheticKind::Partial), 0.05),
    (Some(SyntheticKind::Local), 0.05),
    (Some(SyntheticKind::Spikes), 0.01),
    (Some(SyntheticKind::RangeImage), 0.05),
    (Some(SyntheticKind::Fusion), 0.03),
    (Some(SyntheticKind::Voxels), 0.02),
];

struct Options {
    folder: PathBuf,
    output: PathBuf,
    weights: LearnedWeights,
    others: Option<PathBuf>,
    make_others: bool,
    draws: u64,
    rows: usize,
    seed: u64,
}

fn main() -> Result<(), Box<dyn Error>> {
    let options = options()?;
    let files = std::fs::read_dir(&options.folder)?.map(|entry| Ok(entry?.path()));
    let files = files.collect::<std::io::Result<Vec<_>>>()?;
    let mut files: Vec<PathBuf> = files.into_iter().filter(|p| p.extension().is_some_and(|e| e == "obj")).collect();
    files.sort();
    let meshes: Vec<(String, Surface)> = files.par_iter().filter_map(|path| read(path).ok()).collect();
    let jobs: Vec<(usize, u64)> = (0..options.draws).flat_map(|d| (0..meshes.len()).map(move |m| (m, d))).collect();
    let pieces: Vec<Option<Piece>> = jobs
        .par_iter()
        .with_max_len(1)
        .map(|&(mesh, draw)| piece(&meshes[mesh], options.seed + 1_000_003 * (mesh as u64) + draw, &options))
        .collect();
    if options.make_others {
        return Ok(());
    }
    let pieces: Vec<Piece> = pieces.into_iter().flatten().collect();
    let named = |extension: &str| {
        let mut name = options.output.clone().into_os_string();
        name.push(extension);
        PathBuf::from(name)
    };
    let rows: usize = pieces.iter().map(|piece| piece.samples.normals.len()).sum();
    let width = pieces.first().map_or(0, |piece| piece.samples.features.len() / piece.samples.normals.len().max(1));
    let mut file = std::io::BufWriter::new(std::fs::File::create(named(".features.npy"))?);
    file.write_all(&npy::head("<f2", rows, width))?;
    for piece in &pieces {
        let mut bytes = vec![0; 2 * piece.samples.features.len()];
        for (bytes, x) in bytes.as_chunks_mut().0.iter_mut().zip(&piece.samples.features) {
            *bytes = x.to_le_bytes();
        }
        file.write_all(&bytes)?;
    }
    file.flush()?;
    let mut file = std::io::BufWriter::new(std::fs::File::create(named(".targets.npy"))?);
    file.write_all(&npy::head("<f4", rows, 4))?;
    for (number, piece) in pieces.iter().enumerate() {
        for normal in &piece.samples.normals {
            let [x, y, z] = normal;
            let bytes: Vec<u8> = [*x, *y, *z, number as f32].iter().flat_map(|x| x.to_le_bytes()).collect();
            file.write_all(&bytes)?;
        }
    }
    file.flush()?;
    let names: String = pieces.iter().map(|piece| format!("{} {}\n", piece.name, piece.kind)).collect();
    std::fs::write(named(".pieces.txt"), names)?;
    Ok(())
}

fn options() -> Result<Options, Box<dyn Error>> {
    const USAGE: &str = "usage: learned_samples FOLDER OUTPUT [--weights FILE] [--draws N] [--rows N] [--seed N] [--others FOLDER [--make-others]]";
    let mut arguments = std::env::args().skip(1);
    let (Some(folder), Some(output)) = (arguments.next(), arguments.next()) else { return Err(USAGE.into()) };
    let (folder, output) = (folder.into(), output.into());
    let weights = LearnedWeights::none();
    let mut options =
        Options { folder, output, weights, others: None, make_others: false, draws: 12, rows: 2000, seed: 0 };
    while let Some(argument) = arguments.next() {
        if argument == "--make-others" {
            options.make_others = true;
            continue;
        }
        let value = arguments.next().ok_or(USAGE)?;
        match argument.as_str() {
            "--weights" => options.weights = LearnedWeights::parse(&std::fs::read(value)?)?,
            "--draws" => options.draws = value.parse()?,
            "--rows" => options.rows = value.parse()?,
            "--others" => options.others = Some(value.into()),
            "--seed" => options.seed = value.parse()?,
            _ => return Err(USAGE.into()),
        }
    }
    Ok(options)
}

fn read(path: &Path) -> Result<(String, Surface), Box<dyn Error>> {
    let model = Model::new(Obj::parse(std::fs::read(path)?)?, Welding::Exact);
    let name = path.file_stem().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    Ok((name, model.surface().clone()))
}

/// A piece of a mesh with noise, as samples.
struct Piece {
    name: String,
    kind: &'static str,
    samples: FaceSamples,
}

/// Samples of a random piece with random noise; none if there is nothing to learn from it.
fn piece((name, surface): &(String, Surface), seed: u64, options: &Options) -> Option<Piece> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut choice = random.random::<f64>();
    let kind = KINDS.iter().find(|(_, share)| {
        choice -= share;
        choice < 0.0
    });
    let kind = kind.and_then(|(kind, _)| *kind);
    let stretched = stretched(surface, &mut random);
    let (clean, noisy, kind) = match kind {
        None => {
            let clean = cropped(&stretched, &stretched, &mut random).0;
            (clean.clone(), clean, "none")
        }
        Some(kind) => {
            let noise = drawn(kind, seed, &mut random);
            if kind.keeps_connectivity() {
                let (clean, _) = cropped(&stretched, &stretched, &mut random);
                let mut noisy = moved(&clean, &noise)?;
                if random.random::<f64>() < 0.12 {
                    let white = drawn(SyntheticKind::White, seed ^ 1, &mut random);
                    noisy = moved(&noisy, &SyntheticNoise { sigma: white.sigma * 0.5, ..white })?;
                }
                (clean, noisy, kind.name())
            } else {
                let Ok(Disturbed::Remeshed(pair)) = disturb(&stretched, &noise) else { return None };
                let (clean, noisy) = cropped(&pair.clean, &pair.noisy, &mut random);
                (clean, noisy, kind.name())
            }
        }
    };
    let faces = noisy.topology().faces().len();
    if faces < 60 {
        return None;
    }
    let other = match &options.others {
        None => None,
        Some(folder) => {
            let file = folder.join(format!("{seed}.f32"));
            if options.make_others {
                if !file.exists() {
                    write_vectors(&file, &without_learned(&noisy, &Auto::default(), &Silent).ok()?.0).ok()?;
                }
                return None;
            }
            // Where `auto` leaves everything alone, it does not ask the network.
            let deltas = read_vectors(&file, noisy.positions().len())?;
            if deltas.iter().all(|delta| *delta == DVec3::ZERO) {
                return None;
            }
            Some(deltas)
        }
    };
    let share = options.rows as f64 / faces as f64;
    let wanted: Vec<bool> = (0..faces).map(|_| random.random::<f64>() < share).collect();
    let samples = learned_samples(&clean, &noisy, &options.weights, other.as_deref(), |f| wanted[f], &Silent).ok()?;
    (!samples.normals.is_empty()).then(|| Piece { name: name.clone(), kind, samples })
}

/// Writes vectors in single precision, under its name when it is whole.
fn write_vectors(path: &Path, vectors: &[DVec3]) -> std::io::Result<()> {
    let bytes: Vec<u8> = vectors.iter().flat_map(|v| v.as_vec3().to_array().map(f32::to_le_bytes)).flatten().collect();
    let part = path.with_extension("part");
    std::fs::write(&part, bytes)?;
    std::fs::rename(part, path)
}

/// Reads `count` vectors; none if the file has others or is missing.
fn read_vectors(path: &Path, count: usize) -> Option<Vec<DVec3>> {
    let bytes = std::fs::read(path).ok()?;
    let numbers: Vec<f32> = bytes.as_chunks().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
    let vectors: Vec<DVec3> = numbers.as_chunks().0.iter().map(|[x, y, z]| Vec3::new(*x, *y, *z).as_dvec3()).collect();
    (vectors.len() == count).then_some(vectors)
}

/// The surface, sometimes stretched along a random axis.
fn stretched(surface: &Surface, random: &mut ChaCha8Rng) -> Surface {
    if random.random::<f64>() > 0.3 {
        return surface.clone();
    }
    let axis = between(random, [-1.0, 1.0]) * DVec3::X + between(random, [-1.0, 1.0]) * DVec3::Y;
    let axis = (axis + between(random, [-1.0, 1.0]) * DVec3::Z).normalize_or(DVec3::X);
    let factor = between(random, [-0.4, 0.4]).exp() - 1.0;
    surface.at(surface.positions().iter().map(|p| *p + axis * (axis.dot(*p) * factor)).collect())
}

/// The triangles nearest to a random vertex, of both surfaces.
fn cropped(clean: &Surface, noisy: &Surface, random: &mut ChaCha8Rng) -> (Surface, Surface) {
    let positions = clean.positions();
    let sound = noisy.triangles().filter(|[a, b, c]| a != b && b != c && c != a);
    let mut triangles: Vec<[Index; 3]> = sound.collect();
    if triangles.len() > PIECE && random.random::<f64>() < 0.97 {
        let [a, ..] = triangles[random.random_range(0..triangles.len())];
        let seed = positions[a as usize];
        let distance = |t: &[Index; 3]| t.iter().map(|&v| positions[v as usize].distance_squared(seed)).sum::<f64>();
        triangles.select_nth_unstable_by(PIECE - 1, |s, t| distance(s).total_cmp(&distance(t)));
        triangles.truncate(PIECE);
        triangles.sort_unstable();
    }
    let mut used: Vec<Index> = triangles.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    let new = |v: Index| used.binary_search(&v).map_or(0, |k| k as Index);
    let faces: Ragged<Index> = triangles.iter().map(|t| t.map(new).to_vec()).collect();
    let at = |positions: &[DVec3]| used.iter().map(|&v| positions[v as usize]).collect::<Vec<_>>();
    let cropped = Surface::new(Topology::new(used.len(), faces), at(positions));
    let noisy = cropped.at(at(noisy.positions()));
    (cropped, noisy)
}

/// Noise of a kind with random settings.
fn drawn(kind: SyntheticKind, seed: u64, random: &mut ChaCha8Rng) -> SyntheticNoise {
    let usual = SyntheticNoise::of_kind(kind, seed);
    let share = if kind == SyntheticKind::Impulsive { [0.05, 0.6] } else { [0.1, 0.9] };
    let levels = match kind {
        // Neighbours that move together turn the faces less.
        SyntheticKind::Correlated | SyntheticKind::Impulsive => [0.06f64, 0.9],
        SyntheticKind::Rounded => [0.01, 0.25],
        _ => [0.02, 0.7],
    };
    // One in eight is so light that hardly anything is to be done.
    let levels = if random.random::<f64>() < 0.12 { [0.002, levels[0]] } else { levels };
    SyntheticNoise {
        sigma: between(random, levels.map(f64::ln)).exp(),
        direction: if random.random() { Direction::Normal } else { Direction::Random },
        share: if kind == SyntheticKind::Spikes { between(random, [0.0005, 0.01]) } else { between(random, share) },
        length: between(random, [2.0, 8.0]),
        correlation: match kind {
            SyntheticKind::Correlated => between(random, [0.0, 7f64.ln()]).exp(),
            _ => between(random, [0.0, 3.0]),
        },
        distance: between(random, [1.6, 4.0]),
        step: between(random, [0.7f64.ln(), 2f64.ln()]).exp(),
        ..usual
    }
}

fn between(random: &mut impl Rng, [low, high]: [f64; 2]) -> f64 {
    low + (high - low) * random.random::<f64>()
}

fn moved(clean: &Surface, noise: &SyntheticNoise) -> Option<Surface> {
    match disturb(clean, noise).ok()? {
        Disturbed::Moved(offsets) => {
            Some(clean.at(clean.positions().iter().zip(offsets).map(|(p, d)| *p + d).collect()))
        }
        Disturbed::Remeshed(_) => None,
    }
}
