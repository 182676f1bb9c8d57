//! The command `planish compare`.

use super::one_line;
use crate::args::CompareArgs;
use crate::console::Console;
use crate::csv::{self, Csv};
use crate::failure::Failure;
use crate::heat_map;
use crate::input;
use crate::output::{self, Output};
use planish_geometry::metrics::{self, Comparison, Heat, Triangles};
use planish_geometry::progress::Progress as _;
use serde::Serialize;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Report of the command.
#[derive(Serialize)]
struct Compared {
    clean: String,
    results: Vec<Row>,
    #[serde(skip_serializing_if = "Option::is_none")]
    heatmap: Option<Scale>,
}

/// Measures of one result.
#[derive(Serialize)]
struct Row {
    file: String,
    #[serde(flatten)]
    comparison: Comparison,
}

/// Colour scale of the heat maps.
#[derive(Serialize)]
struct Scale {
    heat: Heat,
    unit: &'static str,
    /// Error of the last colour; the first colour is 0.
    max: f64,
    files: Vec<String>,
}

pub(crate) fn run(args: &CompareArgs, console: &Console) -> Result<(), Failure> {
    let inputs: Vec<&Path> = args.results.iter().chain([&args.clean]).map(PathBuf::as_path).collect();
    let maps = args.heatmap.as_deref().map(|path| heatmap_paths(path, &args.results)).transpose()?.unwrap_or_default();
    if let Some(csv) = args.csv.as_ref().filter(|csv| maps.contains(csv)) {
        return Err(Failure::at(csv, "is named for the heat map and for --csv"));
    }
    let csv = args.csv.as_ref().map(|path| Csv::open(path, &inputs, console)).transpose()?;
    let outputs = maps.iter().map(|path| Output::open(path, &inputs)).collect::<Result<Vec<_>, _>>()?;
    console.reserve_stdout(&outputs)?;

    console.stage("reading");
    let clean = Triangles::from(input::source(&args.clean, args.trust.rule())?.data());
    let (mut rows, mut heat_maps) = (Vec::new(), Vec::new());
    for path in &args.results {
        console.stage("comparing");
        let result = Triangles::from(input::source(path, args.trust.rule())?.data());
        let comparison = metrics::compare(&clean, &result).map_err(|e| Failure::at(path, e))?;
        if args.heatmap.is_some() {
            let heat = metrics::heat(&clean, &result, args.heat).map_err(|e| Failure::at(path, e))?;
            // Errors were measured on the triangles of the clean mesh.
            heat_maps.push((clean.at(result.positions().to_vec()), heat));
        }
        rows.push(Row { file: path.display().to_string(), comparison });
        console.done(rows.len() as f64 / args.results.len() as f64);
        console.check()?;
    }
    let scale = args.heatmap.is_some().then(|| Scale {
        heat: args.heat,
        unit: if args.heat == Heat::Angle { "°" } else { " mean edge lengths" },
        max: args.heat_max.unwrap_or_else(|| percentile_99(&heat_maps)),
        files: maps.iter().map(|path| path.display().to_string()).collect(),
    });
    let mut files = Vec::new();
    if let Some(scale) = &scale {
        console.stage("writing");
        let painted = maps
            .iter()
            .zip(&heat_maps)
            .map(|(path, (mesh, heat))| heat_map::paint(path, mesh, heat, scale.max, &legend(scale)));
        files.extend(outputs.into_iter().zip(painted));
    }
    let table = csv.is_some().then(|| csv::table(&rows)).transpose()?.unwrap_or_default();
    let mut on_stdout = None;
    match csv {
        Some(Csv::File(output)) => files.push((output, table)),
        Some(Csv::Stdout) => on_stdout = Some(table),
        None => {}
    }
    console.check()?;
    output::write_all(files)?;
    let report = Compared { clean: args.clean.display().to_string(), results: rows, heatmap: scale };
    match on_stdout {
        Some(table) => console.print_bytes(&table),
        None => console.report(&report, || text(&report)),
    }
}

/// Returns the path of the heat map for one result, or for several results one path each, with the name of the result in it.
fn heatmap_paths(path: &Path, results: &[PathBuf]) -> Result<Vec<PathBuf>, Failure> {
    let extension = heat_map::extension(path, "--heatmap")?;
    if results.len() == 1 {
        return Ok(vec![path.to_path_buf()]);
    }
    let stem = |path: &Path| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let mut paths: Vec<PathBuf> = Vec::new();
    for result in results {
        let own = path.with_file_name(format!("{}-{}.{extension}", stem(path), stem(result)));
        if paths.contains(&own) {
            return Err(Failure::at(&own, "would be the heat map of two results; compare them one by one"));
        }
        paths.push(own);
    }
    Ok(paths)
}

/// Returns the largest 99th percentile of the heat maps.
fn percentile_99(heat_maps: &[(Triangles, Vec<f64>)]) -> f64 {
    heat_maps.iter().map(|(_, heat)| heat_map::percentile_99(heat)).fold(0.0, f64::max)
}

/// Describes the colour scale.
fn legend(Scale { heat, unit, max, .. }: &Scale) -> String {
    let name = if *heat == Heat::Angle { "angle" } else { "distance" };
    format!("{name} to the clean surface: violet 0, teal {:.4}, yellow {max:.4}{unit} and more", max / 2.0)
}

/// Formats the report as a table for people.
fn text(report: &Compared) -> String {
    let name = |row: &Row| one_line(&row.file);
    let width = report.results.iter().map(|row| name(row).chars().count()).max().unwrap_or(0).max(4);
    let mut out = format!("against {}\n", one_line(&report.clean));
    let heads = [
        "Ea °",
        "by area",
        "median",
        "95 %",
        "d mean",
        "d max",
        "back mean",
        "back max",
        "volume %",
        "flipped",
        "slivers",
        "folds",
    ];
    let _ = write!(out, "{:width$}", "mesh");
    for head in heads {
        let _ = write!(out, " {head:>9}");
    }
    out.push('\n');
    for row in &report.results {
        let (file, c) = (name(row), &row.comparison);
        let _ = write!(out, "{file:width$} {:9.3} {:9.3} {:9.3} {:9.3}", c.ea, c.ea_area, c.ea_median, c.ea_p95);
        let _ = write!(out, " {:9.4} {:9.4} {:9.4} {:9.4}", c.d_mean, c.d_max, c.drev_mean, c.drev_max);
        match c.vol_change_pct {
            Some(volume) => _ = write!(out, " {volume:+9.3}"),
            None => _ = write!(out, " {:>9}", "open"),
        }
        let _ = writeln!(out, " {:9} {:9} {:9}", c.flipped, c.degenerate, c.fold_edges);
    }
    out.push_str(
        "Ea: mean angle between face normals; d: distance to the clean surface in mean edge lengths, back: from it\n",
    );
    if let Some(scale) = &report.heatmap {
        let _ = writeln!(out, "{}\nwrote {}", legend(scale), one_line(&scale.files.join(", ")));
    }
    out
}
