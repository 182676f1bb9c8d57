//! What the method `auto` makes of pairs of clean and noisy meshes, and of scans.
//!
//! ```text
//! auto FOLDER [--pairs x,y] [--noise SIGMA] [--candidates] [--no-clean] [--write FOLDER]
//! ```
//!
//! FOLDER as for `planish bench-quality`. One line a pair: Ea in degrees of the noisy mesh, the least of the manifest's columns that are
//! not authors' meshes, Ea of `auto` and its ratio to that and to the authors' mesh; mean distance to the clean surface in
//! mean edges, of `auto` and of `taubin`; flipped faces before and after; the Ea that `auto` brings into the clean mesh; and
//! seconds of all cores together. `--noise` makes its own noise of that deviation along the normals of the clean mesh.
//! `--candidates` runs each candidate alone as well, `--no-clean` spares the clean mesh, `--write` keeps the results. Meshes
//! without a clean one say only how far normals turned. What was found and chosen goes to standard error.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "printing is what it is for")]

use glam::{DMat3, DVec3};
use planish_geometry::denoise::auto::{self, Candidate};
use planish_geometry::denoise::{Auto, Denoiser, Kind, Taubin};
use planish_geometry::metrics::{self, Comparison, Triangles};
use planish_geometry::model::Model;
use planish_geometry::noise::{self, Noise};
use planish_geometry::obj::Obj;
use planish_geometry::progress::Silent;
use planish_geometry::weld::Welding;
use std::collections::BTreeMap;
use std::error::Error;
use std::path::{Path, PathBuf};

type Failure = Box<dyn Error>;

struct Pair {
    name: String,
    clean: Option<PathBuf>,
    noisy: PathBuf,
    /// The least of the classical methods, and of the authors.
    least: Option<f64>,
    published: Option<f64>,
    /// Triangles that ought to lie in one plane.
    plane: Option<Vec<usize>>,
}

fn main() -> Result<(), Failure> {
    let mut words = std::env::args().skip(1);
    let folder = PathBuf::from(
        words
            .next()
            .ok_or("usage: auto FOLDER [--pairs x,y] [--noise SIGMA] [--candidates] [--no-clean] [--write FOLDER]")?,
    );
    let (mut wanted, mut sigma, mut candidates, mut harmed, mut write) = (None, None, false, true, None);
    while let Some(word) = words.next() {
        match word.as_str() {
            "--pairs" => wanted = words.next(),
            "--noise" => sigma = words.next().map(|s| s.parse::<f64>()).transpose()?,
            "--candidates" => candidates = true,
            "--no-clean" => harmed = false,
            "--write" => write = words.next(),
            _ => return Err(format!("unknown option {word}").into()),
        }
    }
    let wanted: Option<Vec<&str>> = wanted.as_ref().map(|list| list.split(',').collect());
    println!(
        "{:17} {:>6} {:>6} {:>6} {:>6} {:>6}  {:>6} {:>6}  {:>4} {:>4}  {:>6} {:>6}",
        "pair", "noisy", "least", "auto", "ratio", "publ", "d", "taubin", "flip", "auto", "clean", "CPU s"
    );
    let (mut ratios, mut published) = (Vec::new(), Vec::new());
    for pair in pairs(&folder)? {
        if wanted.as_ref().is_some_and(|list| !list.iter().any(|n| *n == pair.name)) {
            continue;
        }
        let model = |path: &Path| -> Result<Model, Failure> {
            Ok(Model::new(Obj::parse(std::fs::read(path)?)?, Welding::Exact))
        };
        let Some(clean) = &pair.clean else {
            let scan = model(&pair.noisy)?;
            let (result, seconds) = run(&pair.name, &scan)?;
            save(&write, &pair.name, &scan, &result)?;
            let turned = compare(&scan, &scan, &result)?;
            println!(
                "{:17} turned {:.2} on average, {:.2} at the 95th percentile; moved {:.3} mean edges, {:.3} at most; {seconds:.1} s",
                pair.name, turned.ea, turned.ea_p95, turned.vertex_mean, turned.d_max
            );
            if let Some(faces) = &pair.plane {
                for (what, positions) in [("before", scan.surface().positions()), ("after", &result)] {
                    let (angle, rms) = off_plane(&scan, positions, faces)?;
                    println!("  flat part, {what}: {angle:.2} off the plane, {rms:.3} mean edges");
                }
                for method in Denoiser::every().iter().filter(|_| candidates) {
                    let result = method.denoised(scan.surface(), &Silent)?;
                    let (angle, rms) = off_plane(&scan, &result, faces)?;
                    println!("  {:15} {angle:.2} off the plane, {rms:.3} mean edges", method.name());
                }
                for candidate in Candidate::ALL.into_iter().filter(|_| candidates) {
                    let sigma = sigma.into_iter().chain([0.05, 0.1, 0.2, 0.4]).next();
                    let alone = Auto {
                        candidates: Some(vec![candidate]),
                        noise: sigma,
                        kind: Some(Kind::Independent),
                        ..Auto::default()
                    };
                    let result = Denoiser::Auto(alone).denoised(scan.surface(), &Silent)?;
                    let (angle, rms) = off_plane(&scan, &result, faces)?;
                    println!("  {candidate:15} {angle:.2} off the plane, {rms:.3} mean edges");
                }
            }
            continue;
        };
        let clean = model(clean)?;
        let noisy = match sigma {
            None => model(&pair.noisy)?,
            Some(sigma) => {
                let noise = Noise { sigma, direction: noise::Direction::Normal, share: 1.0, seed: 11 };
                let lifted = noise::displacements(clean.surface(), &noise);
                let moved: Vec<DVec3> = clean.surface().positions().iter().zip(lifted).map(|(p, d)| *p + d).collect();
                let written = clean.source().with_positions(&clean.weld().spread(&moved), None)?;
                Model::new(Obj::parse(written)?, Welding::Exact)
            }
        };
        let before = compare(&clean, &noisy, noisy.surface().positions())?;
        let (result, seconds) = run(&pair.name, &noisy)?;
        save(&write, &pair.name, &noisy, &result)?;
        let after = compare(&clean, &noisy, &result)?;
        let taubin = Denoiser::Taubin(Taubin::default()).denoised(noisy.surface(), &Silent)?;
        let taubin = compare(&clean, &noisy, &taubin)?;
        let least = if sigma.is_some() { Some(taubin.ea) } else { pair.least };
        let kept = if harmed { run("  clean", &clean)?.0 } else { clean.surface().positions().to_vec() };
        let harm = compare(&clean, &clean, &kept)?;
        let ratio = least.map(|least| after.ea / least);
        let to_published = pair.published.filter(|_| sigma.is_none()).map(|ea| after.ea / ea);
        ratios.extend(ratio);
        published.extend(to_published);
        let optional = |x: Option<f64>| x.map_or_else(|| "-".to_owned(), |x| format!("{x:.3}"));
        println!(
            "{:17} {:6.2} {:>6} {:6.3} {:>6} {:>6}  {:6.4} {:6.4}  {:4} {:4}  {:6.3} {seconds:6.1}",
            pair.name,
            before.ea,
            optional(least),
            after.ea,
            optional(ratio),
            optional(to_published),
            after.d_mean,
            taubin.d_mean,
            before.flipped,
            after.flipped,
            harm.ea
        );
        if candidates {
            let (_, choice) = auto::choose(noisy.surface(), &Auto::default(), &Silent)?;
            for candidate in Candidate::ALL.into_iter() {
                let alone = Auto { candidates: Some(vec![candidate]), kind: Some(choice.kind), ..Auto::default() };
                let result = Denoiser::Auto(alone).denoised(noisy.surface(), &Silent)?;
                let alone = compare(&clean, &noisy, &result)?;
                let found = choice.candidates.iter().find(|share| share.candidate == candidate);
                println!(
                    "  {candidate:15} {:6.3} rms {:6.3} behind {:>8} share {:>5} d {:.4} flipped {}",
                    alone.ea,
                    alone.ea_rms,
                    optional(found.and_then(|share| share.behind)),
                    optional(found.map(|share| share.share)),
                    alone.d_mean,
                    alone.flipped
                );
            }
        }
    }
    let geomean = |x: &[f64]| (x.iter().map(|x| x.ln()).sum::<f64>() / x.len() as f64).exp();
    if !ratios.is_empty() {
        let worst = ratios.iter().copied().fold(0.0, f64::max);
        println!(
            "geometric means: {:.4} (worst {worst:.3}), to published {:.4}",
            geomean(&ratios),
            geomean(&published)
        );
    }
    Ok(())
}

fn run(name: &str, model: &Model) -> Result<(Vec<DVec3>, f64), Failure> {
    let before = cpu_seconds();
    let (deltas, choice) = auto::choose(model.surface(), &Auto::default(), &Silent)?;
    let seconds = cpu_seconds() - before;
    eprintln!("{name}: {choice}");
    Ok((model.surface().positions().iter().zip(deltas).map(|(p, delta)| *p - delta).collect(), seconds))
}

fn save(folder: &Option<String>, name: &str, model: &Model, positions: &[DVec3]) -> Result<(), Failure> {
    let Some(folder) = folder else { return Ok(()) };
    let written = model.source().with_positions(&model.weld().spread(positions), None)?;
    Ok(std::fs::write(Path::new(folder).join(format!("{name}_auto.obj")), written)?)
}

fn compare(clean: &Model, model: &Model, positions: &[DVec3]) -> Result<Comparison, Failure> {
    let written = model.source().with_positions(&model.weld().spread(positions), None)?;
    Ok(metrics::compare(&Triangles::from(clean.data()), &Triangles::from(Obj::parse(written)?.data()))?)
}

/// Mean angle of these triangles to the plane that fits them, degrees, and root mean square of the distance of their
/// vertices from it, mean edges.
fn off_plane(scan: &Model, positions: &[DVec3], faces: &[usize]) -> Result<(f64, f64), Failure> {
    let written = Obj::parse(scan.source().with_positions(&scan.weld().spread(positions), None)?)?;
    let written = written.data();
    let all: Vec<[u32; 3]> = written.faces().iter().map(|f| [f[0], f[1], f[2]].map(|c| c.position)).collect();
    let at = |v: u32| written.positions()[v as usize];
    let mut vertices: Vec<u32> = faces.iter().flat_map(|&f| all[f]).collect();
    vertices.sort_unstable();
    vertices.dedup();
    let centre = vertices.iter().map(|&v| at(v)).sum::<DVec3>() / vertices.len() as f64;
    let column = |k: usize| vertices.iter().map(|&v| (at(v) - centre) * (at(v) - centre)[k]).sum::<DVec3>();
    let spread = DMat3::from_cols(column(0), column(1), column(2));
    // Power iteration on the adjugate finds the direction in which they are spread least.
    let least = DMat3::from_cols(
        spread.y_axis.cross(spread.z_axis),
        spread.z_axis.cross(spread.x_axis),
        spread.x_axis.cross(spread.y_axis),
    );
    let normal = (0..50).fold(DVec3::ONE, |n, _| (least * n).normalize());
    let angle = |&f: &usize| {
        let [a, b, c] = all[f].map(at);
        (b - a).cross(c - a).normalize_or_zero().dot(normal).abs().min(1.0).acos().to_degrees()
    };
    let angles = faces.iter().map(angle).sum::<f64>() / faces.len() as f64;
    let squares = vertices.iter().map(|&v| (at(v) - centre).dot(normal).powi(2)).sum::<f64>() / vertices.len() as f64;
    Ok((angles, squares.sqrt() / scan.surface().mean_edge()))
}

/// User and system time of this process so far; 0 where there is no /proc.
fn cpu_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields: Vec<f64> =
        stat.rsplit(')').next().unwrap_or("").split_whitespace().map(|x| x.parse().unwrap_or(0.0)).collect();
    // Ticks of a hundredth of a second on every Linux that we know.
    fields.get(11..13).map_or(0.0, |ticks| ticks.iter().sum::<f64>() / 100.0)
}

fn pairs(folder: &Path) -> Result<Vec<Pair>, Failure> {
    let text = std::fs::read_to_string(folder.join("MANIFEST.tsv"))?;
    let mut lines = text.lines();
    let heads: Vec<&str> = lines.next().unwrap_or("").split('\t').collect();
    let mut pairs = Vec::new();
    for line in lines {
        let row: BTreeMap<&str, &str> = heads.iter().copied().zip(line.split('\t')).collect();
        let cell = |head: &str| row.get(head).copied().unwrap_or("-");
        let others = row.iter().filter(|(h, _)| h.starts_with("Ea_") && !["Ea_noisy", "Ea_PUB"].contains(*h));
        let least = others.filter_map(|(_, x)| x.parse::<f64>().ok()).min_by(f64::total_cmp);
        let published = cell("Ea_PUB").rsplit('=').next().and_then(|x| x.parse().ok());
        let clean = Some(cell("clean")).filter(|c| *c != "-").map(|c| folder.join(c));
        let plane = std::fs::read_to_string(folder.join(format!("{}_plane.txt", cell("name")))).ok();
        let plane = plane.map(|text| text.split_whitespace().filter_map(|f| f.parse().ok()).collect());
        pairs.push(Pair {
            plane,
            name: cell("name").to_owned(),
            clean,
            noisy: folder.join(cell("noisy")),
            least,
            published,
        });
    }
    Ok(pairs)
}
