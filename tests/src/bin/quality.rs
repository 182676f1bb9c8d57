//! Runs denoising methods over pairs of clean and noisy meshes and prints how near each comes to the clean one.
//!
//! ```text
//! quality FOLDER [--methods a,b] [--pairs x,y] [--preset paper|default] [--set name=value] [--format text|tsv|json]
//! ```
//!
//! FOLDER has a `MANIFEST.tsv` with columns `name`, `clean`, `noisy`, and for each method the Ea in degrees that another
//! program reached with the same settings; or no such file but pairs NAME_clean.obj and NAME_noisy.obj. `ratio` is Ea
//! over that column, where settings are those of the papers, distances are in mean edge lengths of the clean mesh.
#![allow(clippy::print_stdout, reason = "printing is what it is for")]

use planish_geometry::denoise::Denoiser;
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

/// Columns whose figures were made with the settings of the papers, by method.
const COLUMNS: [(&str, &str); 7] = [
    ("laplacian", "Ea_lap_it3"),
    ("taubin", "Ea_taubin_it10"),
    ("bilateral", "Ea_bmd"),
    ("sun", "Ea_sun"),
    ("bilateral-normals", "Ea_bnf"),
    ("guided-normals", "Ea_gnf"),
    ("l0", "Ea_l0abs"),
];

fn runs(paper: bool) -> Vec<Run> {
    let run = |default: Denoiser| {
        let column = COLUMNS.iter().find(|c| paper && c.0 == default.name()).map(|c| c.1);
        let denoiser = default.paper().filter(|_| paper).unwrap_or(default);
        Run { method: denoiser.name(), column, denoiser }
    };
    Denoiser::every().map(run).into()
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
    let mut runs = runs(options.paper);
    runs.retain(|run| wanted(&options.methods, run.method));
    for run in &mut runs {
        run.denoiser = with(&run.denoiser, &options.settings)?;
    }
    let mut rows = Vec::new();
    if options.format != Format::Json {
        print_line(options.format, &Row::HEADS.map(str::to_owned));
    }
    for pair in pairs(&options.folder)?.iter().filter(|pair| wanted(&options.pairs, &pair.name)) {
        let clean = Triangles::from(&Obj::parse(std::fs::read(&pair.clean)?)?);
        let model = Model::new(Obj::parse(std::fs::read(&pair.noisy)?)?, Welding::Exact);
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
    let denoised = run.denoiser.denoised(model.surface(), &Silent)?;
    let seconds = start.elapsed().as_secs_f64();
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

/// The method with some settings replaced; those that it does not have are passed over.
fn with(denoiser: &Denoiser, settings: &[(String, serde_json::Value)]) -> Result<Denoiser, Failure> {
    let mut json = serde_json::to_value(denoiser)?;
    for (name, value) in settings {
        let places = [format!("/{name}"), format!("/vertex_update/{name}")];
        let place = places.iter().find(|place| json.pointer(place).is_some());
        if let Some(slot) = place.and_then(|place| json.pointer_mut(place)) {
            *slot = value.clone();
        }
    }
    Ok(serde_json::from_value(json)?)
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
        pairs.push(Pair {
            name: cell("name")?.to_owned(),
            clean: folder.join(cell("clean")?),
            noisy: folder.join(cell("noisy")?),
            columns: figures.collect(),
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
    paper: bool,
    settings: Vec<(String, serde_json::Value)>,
    format: Format,
}

impl Options {
    fn parse(mut words: impl Iterator<Item = String>) -> Result<Self, Failure> {
        const USAGE: &str = "usage: quality FOLDER [--methods a,b] [--pairs x,y] [--preset paper|default] [--set name=value] \
             [--format text|tsv|json]";
        let folder = words.next().filter(|word| !word.starts_with('-')).ok_or(USAGE)?;
        let mut options = Self {
            folder: folder.into(),
            methods: None,
            pairs: None,
            paper: true,
            settings: Vec::new(),
            format: Format::Text,
        };
        while let Some(word) = words.next() {
            let value = words.next().ok_or(USAGE)?;
            let list = || Some(value.split(',').map(str::to_owned).collect());
            match (word.as_str(), value.as_str()) {
                ("--methods", _) => options.methods = list(),
                ("--pairs", _) => options.pairs = list(),
                ("--set", _) => {
                    for setting in value.split(',') {
                        let (name, value) = setting.split_once('=').ok_or(USAGE)?;
                        let json = serde_json::from_str(value).unwrap_or_else(|_| value.into());
                        options.settings.push((name.to_owned(), json));
                    }
                }
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
