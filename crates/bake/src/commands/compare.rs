//! `planish compare`

use crate::args::CompareArgs;
use crate::console::Console;
use crate::failure::Failure;
use crate::input;
use planish_geometry::metrics::{self, Comparison, Triangles};
use planish_geometry::progress::Progress as _;
use serde::Serialize;
use std::fmt::Write as _;

#[derive(Serialize)]
struct Compared {
    clean: String,
    results: Vec<Row>,
}

#[derive(Serialize)]
struct Row {
    file: String,
    #[serde(flatten)]
    comparison: Comparison,
}

pub(crate) fn run(args: &CompareArgs, console: &Console) -> Result<(), Failure> {
    console.stage("reading");
    let clean = Triangles::from(&input::obj(&args.clean)?);
    let mut results = Vec::new();
    for path in &args.results {
        console.stage("comparing");
        let result = Triangles::from(&input::obj(path)?);
        let comparison = metrics::compare(&clean, &result).map_err(|e| Failure::at(path, e))?;
        results.push(Row { file: path.display().to_string(), comparison });
        console.done(results.len() as f64 / args.results.len() as f64);
        console.check()?;
    }
    let report = Compared { clean: args.clean.display().to_string(), results };
    console.report(&report, || table(&report));
    Ok(())
}

fn table(report: &Compared) -> String {
    let width = report.results.iter().map(|r| r.file.chars().count()).max().unwrap_or(0).max(4);
    let mut out = format!("against {}\n", report.clean);
    let heads = ["Ea °", "median", "95 %", "d mean", "d max", "back max", "volume %", "flipped", "slivers", "folds"];
    let _ = write!(out, "{:width$}", "mesh");
    for head in heads {
        let _ = write!(out, " {head:>9}");
    }
    out.push('\n');
    for Row { file, comparison: c } in &report.results {
        let _ = write!(
            out,
            "{file:width$} {:9.3} {:9.3} {:9.3} {:9.4} {:9.4} {:9.4}",
            c.ea, c.ea_median, c.ea_p95, c.d_mean, c.d_max, c.drev_max
        );
        match c.vol_change_pct {
            Some(volume) => _ = write!(out, " {volume:+9.3}"),
            None => _ = write!(out, " {:>9}", "open"),
        }
        let _ = writeln!(out, " {:9} {:9} {:9}", c.flipped, c.degenerate, c.fold_edges);
    }
    out.push_str(
        "Ea: mean angle between face normals; d: distance to the clean surface in mean edge lengths, back: from it\n",
    );
    out
}
