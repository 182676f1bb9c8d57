//! Runs denoising methods over pairs of clean and noisy meshes and prints how near each comes to the clean one.
//!
//!     quality FOLDER [--methods a,b] [--pairs x,y] [--input noisy|clean] [--preset paper|default] [--format text|tsv|json]
//!
//! FOLDER has a `MANIFEST.tsv` with columns `name`, `clean`, `noisy`, and for each method the Ea in degrees that another
//! program reached with the same settings; or no such file but pairs NAME_clean.obj and NAME_noisy.obj. `ratio` is Ea
//! over that column, for `map` and `auto` over the least of all columns that are not authors' meshes; distances are in mean
//! edge lengths of the clean mesh. `--input clean` gives the methods the clean mesh: what they change is harm. What `auto`
//! found goes to standard error.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "printing is what it is for")]

use planish_geometry::denoise::{
    Auto, Bilateral, BilateralNormals, Denoiser, GuidedNormals, Hc, Implicit, L0, Laplacian, Map, Sun, Taubin, auto,
};
use planish_geometry::metrics::{self, Triangles};
use planish_geometry::model::Model;
use planish_geometry::obj::Obj;
use planish_geometry::progress::Silent;
use planish_geometry::weld::Welding;
use serde::Serialize;
use std::collections::BTreeMap;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Instant;

type Failure = Box<dyn Error>;

/// A method as it is run, and the column of the manifest that it is measured against.
struct Run {
    method: &'static str,
    column: Option<&'static str>,
    denoiser: Denoiser,
}

/// The best of the other programs, with whatever settings.
const LEAST: &str = "least";

fn paper() -> Vec<Run> {
    let run = |method, column, denoiser| Run { method, column: Some(column), denoiser };
    vec![
        run("laplacian", "Ea_lap_it3", Denoiser::Laplacian(Laplacian::default())),
        run("taubin", "Ea_taubin_it10", Denoiser::Taubin(Taubin::default())),
        Run { method: "hc", column: None, denoiser: Denoiser::Hc(Hc::default()) },
        Run { method: "implicit", column: None, denoiser: Denoiser::Implicit(Implicit::default()) },
        run("bilateral", "Ea_bmd", Denoiser::Bilateral(Bilateral::paper())),
        run("sun", "Ea_sun", Denoiser::Sun(Sun::paper())),
        run("bilateral-normals", "Ea_bnf", Denoiser::BilateralNormals(BilateralNormals::paper())),
        run("guided-normals", "Ea_gnf", Denoiser::GuidedNormals(GuidedNormals::paper())),
        run("l0", "Ea_l0abs", Denoiser::L0(L0::default())),
        run("map", LEAST, Denoiser::Map(Map::default())),
        run("auto", LEAST, Denoiser::Auto(Auto::default())),
    ]
}

fn defaults() -> Vec<Run> {
    let run = |method, denoiser| Run { method, column: None, denoiser };
    vec![
        run("laplacian", Denoiser::Laplacian(Laplacian::default())),
        run("taubin", Denoiser::Taubin(Taubin::default())),
        run("hc", Denoiser::Hc(Hc::default())),
        run("implicit", Denoiser::Implicit(Implicit::default())),
        run("bilateral", Denoiser::Bilateral(Bilateral::default())),
        run("sun", Denoiser::Sun(Sun::default())),
        run("bilateral-normals", Denoiser::BilateralNormals(BilateralNormals::default())),
        run("guided-normals", Denoiser::GuidedNormals(GuidedNormals::default())),
        run("l0", Denoiser::L0(L0::default())),
        run("map", Denoiser::Map(Map::default())),
        run("auto", Denoiser::Auto(Auto::default())),
    ]
}

/// A clean mesh, a noisy one, and the figures of other programs by column.
struct Pair {
    name: String,
    clean: PathBuf,
    noisy: PathBuf,
    columns: BTreeMap<String, f64>,
}

#[derive(Serialize)]
struct Row {
    pair: String,
    method: &'static str,
    #[serde(rename = "Ea_deg")]
    ea: f64,
    reference: Option<f64>,
    ratio: Option<f64>,
    flipped: usize,
    #[serde(rename = "d_mean_el")]
    d_mean: f64,
    #[serde(rename = "d_max_el")]
    d_max: f64,
    seconds: f64,
}

impl Row {
    const HEADS: [&'static str; 9] =
        ["pair", "method", "Ea_deg", "reference", "ratio", "flipped", "d_mean_el", "d_max_el", "seconds"];

    fn cells(&self) -> [String; 9] {
        let optional = |x: Option<f64>| x.map_or_else(|| "-".to_owned(), |x| format!("{x:.3}"));
        [
            self.pair.clone(),
            self.method.to_owned(),
            format!("{:.3}", self.ea),
            optional(self.reference),
            optional(self.ratio),
            self.flipped.to_string(),
            format!("{:.4}", self.d_mean),
            format!("{:.3}", self.d_max),
            format!("{:.2}", self.seconds),
        ]
    }
}

fn main() -> Result<(), Failure> {
    let options = Options::parse(std::env::args().skip(1))?;
    let wanted = |list: &Option<Vec<String>>, name: &str| list.as_ref().is_none_or(|l| l.iter().any(|n| n == name));
    let mut runs = if options.paper { paper() } else { defaults() };
    runs.retain(|run| wanted(&options.methods, run.method));
    let mut rows = Vec::new();
    if options.format != Format::Json {
        print_line(options.format, &Row::HEADS.map(str::to_owned));
    }
    for pair in pairs(&options.folder)?.iter().filter(|pair| wanted(&options.pairs, &pair.name)) {
        let clean = Triangles::from(&Obj::parse(std::fs::read(&pair.clean)?)?);
        let given = if options.clean { &pair.clean } else { &pair.noisy };
        let model = Model::new(Obj::parse(std::fs::read(given)?)?, Welding::Exact);
        for run in &runs {
            let row = measure(pair, run, &clean, &model)?;
            if options.format != Format::Json {
                print_line(options.format, &row.cells());
            }
            rows.push(row);
        }
    }
    if options.format == Format::Json {
        println!("{}", serde_json::to_string_pretty(&rows)?);
    }
    Ok(())
}

fn measure(pair: &Pair, run: &Run, clean: &Triangles, model: &Model) -> Result<Row, Failure> {
    let start = Instant::now();
    let deltas = match &run.denoiser {
        Denoiser::Auto(settings) => {
            let (deltas, choice) = auto::choose(model.surface(), settings, &Silent)?;
            eprintln!("{}: {choice}", pair.name);
            deltas
        }
        denoiser => denoiser.deltas(model.surface(), &Silent)?,
    };
    let seconds = start.elapsed().as_secs_f64();
    let denoised: Vec<_> = model.surface().positions().iter().zip(deltas).map(|(p, delta)| *p - delta).collect();
    let written = model.obj().with_positions(&model.weld().spread(&denoised), None);
    let found = metrics::compare(clean, &Triangles::from(&Obj::parse(written)?))?;
    let reference = run.column.and_then(|column| pair.columns.get(column)).copied();
    Ok(Row {
        pair: pair.name.clone(),
        method: run.method,
        ea: found.ea,
        reference,
        ratio: reference.map(|reference| found.ea / reference),
        flipped: found.flipped,
        d_mean: found.d_mean,
        d_max: found.d_max,
        seconds,
    })
}

/// Pairs of a folder that have a clean mesh.
fn pairs(folder: &Path) -> Result<Vec<Pair>, Failure> {
    let manifest = folder.join("MANIFEST.tsv");
    if !manifest.is_file() {
        return pairs_by_name(folder);
    }
    let text = std::fs::read_to_string(manifest)?;
    let mut lines = text.lines();
    let heads: Vec<&str> = lines.next().unwrap_or("").split('\t').collect();
    let mut pairs = Vec::new();
    for line in lines {
        let row: BTreeMap<&str, &str> = heads.iter().copied().zip(line.split('\t')).collect();
        let cell = |head: &str| row.get(head).copied().ok_or_else(|| format!("MANIFEST.tsv has no column {head}"));
        if cell("clean")? == "-" {
            continue;
        }
        let figures = row.iter().filter_map(|(head, cell)| Some((String::from(*head), cell.parse().ok()?)));
        let mut columns: BTreeMap<String, f64> = figures.collect();
        let others = columns.iter().filter(|(head, _)| head.starts_with("Ea_") && *head != "Ea_noisy");
        if let Some(least) = others.map(|(_, ea)| *ea).min_by(f64::total_cmp) {
            columns.insert(LEAST.to_owned(), least);
        }
        pairs.push(Pair {
            name: cell("name")?.to_owned(),
            clean: folder.join(cell("clean")?),
            noisy: folder.join(cell("noisy")?),
            columns,
        });
    }
    Ok(pairs)
}

fn pairs_by_name(folder: &Path) -> Result<Vec<Pair>, Failure> {
    let mut pairs = Vec::new();
    for entry in folder.read_dir()? {
        let clean = entry?.path();
        let name = clean.file_name().and_then(|name| name.to_str()).and_then(|name| name.strip_suffix("_clean.obj"));
        if let Some(name) = name {
            let (name, noisy) = (name.to_owned(), folder.join(format!("{name}_noisy.obj")));
            if noisy.is_file() {
                pairs.push(Pair { name, clean, noisy, columns: BTreeMap::new() });
            }
        }
    }
    pairs.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(pairs)
}

#[derive(Clone, Copy, PartialEq)]
enum Format {
    Text,
    Tsv,
    Json,
}

fn print_line(format: Format, cells: &[String; 9]) {
    match format {
        Format::Text => {
            let [pair, method, numbers @ ..] = cells;
            let numbers = numbers.each_ref().map(|cell| format!("{cell:>9}"));
            println!("{pair:17} {method:17} {}", numbers.join(" "));
        }
        _ => println!("{}", cells.join("\t")),
    }
}

struct Options {
    folder: PathBuf,
    methods: Option<Vec<String>>,
    pairs: Option<Vec<String>>,
    clean: bool,
    paper: bool,
    format: Format,
}

impl Options {
    fn parse(mut words: impl Iterator<Item = String>) -> Result<Self, Failure> {
        const USAGE: &str = "usage: quality FOLDER [--methods a,b] [--pairs x,y] [--input noisy|clean] [--preset paper|default] [--format text|tsv|json]";
        let folder = words.next().filter(|word| !word.starts_with('-')).ok_or(USAGE)?;
        let mut options =
            Self { folder: folder.into(), methods: None, pairs: None, clean: false, paper: true, format: Format::Text };
        while let Some(word) = words.next() {
            let value = words.next().ok_or(USAGE)?;
            let list = || Some(value.split(',').map(str::to_owned).collect());
            match (word.as_str(), value.as_str()) {
                ("--methods", _) => options.methods = list(),
                ("--pairs", _) => options.pairs = list(),
                ("--input", "noisy") => options.clean = false,
                ("--input", "clean") => options.clean = true,
                ("--preset", "paper") => options.paper = true,
                ("--preset", "default") => options.paper = false,
                ("--format", "text") => options.format = Format::Text,
                ("--format", "tsv") => options.format = Format::Tsv,
                ("--format", "json") => options.format = Format::Json,
                _ => return Err(USAGE.into()),
            }
        }
        Ok(options)
    }
}
