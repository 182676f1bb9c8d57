//! The report of `planish bench-quality --noise`.

use super::Contender;
use super::meshes::CleanMesh;
use crate::args::NoiseRequest;
use crate::failure::Failure;
use planish_geometry::metrics::Comparison;
use serde::Serialize;
use std::fmt::Write as _;
use std::path::Path;

/// Change of Ea, degrees, below which a method has left a mesh alone.
const LEFT_ALONE: f64 = 1e-3;
/// Number of pairs in the list of the worst.
const WORST: usize = 10;

/// Results of all methods on all meshes with all kinds of noise.
#[derive(Serialize)]
pub(super) struct Report {
    folder: String,
    /// Kinds of noise, as they were asked for.
    kinds: Vec<String>,
    /// Methods with all their settings; the first is measured against the best of the others.
    pub(super) methods: Vec<Contender>,
    pub(super) pairs: Vec<Pair>,
    pub(super) rows: Vec<Row>,
    by_kind: Vec<Summary>,
    by_group: Vec<Summary>,
    all: Option<Summary>,
    /// Pairs with the largest ratios, the worst first.
    worst: Vec<Pair>,
    /// Meshes with too many triangles, and kinds of noise that a mesh cannot have.
    pub(super) skipped: Vec<Unmeasured>,
    /// Meshes and results with errors.
    pub(super) broken: Vec<Unmeasured>,
}

/// The first method on a mesh with noise of one kind.
#[derive(Clone, Serialize)]
pub(super) struct Pair {
    mesh: String,
    groups: Vec<String>,
    kind: String,
    /// Seed of the noise: `planish noise` makes the same with it.
    seed: u64,
    /// True for a clean mesh: there is nothing to denoise, and no other method is run.
    clean: bool,
    #[serde(rename = "Ea_noisy_deg")]
    noisy: f64,
    /// Ea of the first method.
    #[serde(rename = "Ea_first_deg")]
    first: f64,
    /// Smallest Ea of the other methods; `None` if there is none.
    #[serde(rename = "Ea_best_deg")]
    best: Option<f64>,
    best_method: Option<String>,
    /// Ea of the first method over the smallest of the others.
    ratio: Option<f64>,
    left_alone: bool,
    worse_than_input: bool,
}

/// Result of a method on a mesh with noise of one kind.
#[derive(Serialize)]
pub(super) struct Row {
    mesh: String,
    group: String,
    kind: String,
    method: String,
    seconds: f64,
    #[serde(rename = "Ea_noisy_deg")]
    noisy: f64,
    #[serde(flatten)]
    comparison: Comparison,
}

/// Summary of the first method over some pairs.
#[derive(Serialize)]
struct Summary {
    name: String,
    /// Number of pairs with noise.
    pairs: usize,
    /// Geometric mean of the ratios.
    mean_ratio: Option<f64>,
    worst_ratio: Option<f64>,
    /// Fraction of the pairs whose ratio is above 1.05.
    share_above_1_05: Option<f64>,
    /// Fraction of the pairs whose ratio is above 1.10.
    share_above_1_10: Option<f64>,
    /// Fraction of the pairs that the first method left alone.
    share_left_alone: Option<f64>,
    worse_than_input: usize,
    clean_meshes: usize,
    /// Largest angle by which the first method rotates the faces of a clean mesh in the mean, degrees.
    worst_on_clean_deg: Option<f64>,
}

/// A mesh, a kind of noise on it, or a method on that, that was not measured.
#[derive(Serialize)]
pub(super) struct Unmeasured {
    pub(super) mesh: String,
    pub(super) kind: Option<String>,
    pub(super) method: Option<String>,
    pub(super) error: String,
}

impl Row {
    pub(super) fn new(
        mesh: &CleanMesh,
        kind: &str,
        method: &str,
        (seconds, before): (f64, &Comparison),
        found: Comparison,
    ) -> Self {
        Self {
            mesh: mesh.name.clone(),
            group: mesh.groups.join(","),
            kind: kind.to_owned(),
            method: method.to_owned(),
            seconds,
            noisy: before.ea,
            comparison: found,
        }
    }
}

impl Pair {
    /// Returns the summary of the rows of one mesh and kind; `None` if the first method has no result.
    pub(super) fn new(mesh: &CleanMesh, request: &NoiseRequest, methods: &[Contender], rows: &[Row]) -> Option<Self> {
        let (first, others): (Vec<&Row>, Vec<&Row>) = rows.iter().partition(|row| row.method == methods[0].name);
        let first = first.first()?;
        let best = others.into_iter().min_by(|a, b| a.comparison.ea.total_cmp(&b.comparison.ea));
        let ea = first.comparison.ea;
        Some(Self {
            mesh: mesh.name.clone(),
            groups: mesh.groups.clone(),
            kind: request.name(),
            seed: mesh.seed(&request.name()),
            clean: request.kind.is_none(),
            noisy: first.noisy,
            first: ea,
            best: best.map(|row| row.comparison.ea),
            best_method: best.map(|row| row.method.clone()),
            ratio: best.map(|row| ea / row.comparison.ea).filter(|ratio| ratio.is_finite() && *ratio > 0.0),
            left_alone: (ea - first.noisy).abs() < LEFT_ALONE,
            worse_than_input: ea > first.noisy,
        })
    }

    fn line(&self) -> String {
        let number = |x: Option<f64>| x.map_or_else(|| "-".to_owned(), |x| format!("{x:.3}"));
        let note = match (self.clean, self.left_alone, self.worse_than_input) {
            (_, true, _) => "  left alone",
            (false, _, true) => "  worse than the input",
            _ => "",
        };
        let Self { mesh, kind, noisy, first, best_method, .. } = self;
        format!(
            "  {mesh:32} {kind:16} {noisy:8.3} {:>8} {:18} {first:8.3} {:>7}{note}\n",
            number(self.best),
            best_method.as_deref().unwrap_or("-"),
            number(self.ratio)
        )
    }
}

impl Summary {
    fn of<'a>(name: &str, pairs: impl Iterator<Item = &'a Pair>) -> Self {
        let (clean, noisy): (Vec<&Pair>, Vec<&Pair>) = pairs.partition(|pair| pair.clean);
        let ratios: Vec<f64> = noisy.iter().filter_map(|pair| pair.ratio).collect();
        let fraction = |count: usize, of: usize| (of > 0).then(|| count as f64 / of as f64);
        let above = |limit: f64| fraction(ratios.iter().filter(|ratio| **ratio > limit).count(), ratios.len());
        let mean = || (ratios.iter().map(|ratio| ratio.ln()).sum::<f64>() / ratios.len() as f64).exp();
        Self {
            name: name.to_owned(),
            pairs: noisy.len(),
            mean_ratio: (!ratios.is_empty()).then(mean),
            worst_ratio: ratios.iter().copied().max_by(f64::total_cmp),
            share_above_1_05: above(1.05),
            share_above_1_10: above(1.10),
            share_left_alone: fraction(noisy.iter().filter(|pair| pair.left_alone).count(), noisy.len()),
            worse_than_input: noisy.iter().filter(|pair| pair.worse_than_input && !pair.left_alone).count(),
            clean_meshes: clean.len(),
            worst_on_clean_deg: clean.iter().map(|pair| pair.first).max_by(f64::total_cmp),
        }
    }

    fn line(&self) -> String {
        let number = |x: Option<f64>, digits: usize| x.map_or_else(|| "-".to_owned(), |x| format!("{x:.digits$}"));
        let shares = [self.share_above_1_05, self.share_above_1_10, self.share_left_alone];
        let [above_5, above_10, alone] =
            shares.map(|share| share.map_or_else(|| "-".to_owned(), |share| format!("{:.1} %", 100.0 * share)));
        format!(
            "  {:20} {:>5} {:>8} {:>8} {above_5:>8} {above_10:>8} {alone:>8} {:>7} {:>6} {:>9}\n",
            self.name,
            self.pairs,
            number(self.mean_ratio, 3),
            number(self.worst_ratio, 2),
            self.worse_than_input,
            self.clean_meshes,
            number(self.worst_on_clean_deg, 3),
        )
    }
}

/// Values in the order of their first appearance.
fn distinct<'a>(names: impl Iterator<Item = &'a String>) -> Vec<&'a String> {
    let mut found: Vec<&String> = Vec::new();
    names.for_each(|name| {
        if !found.contains(&name) {
            found.push(name);
        }
    });
    found
}

impl Report {
    pub(super) fn new(folder: &Path, methods: Vec<Contender>, requests: &[NoiseRequest]) -> Self {
        Self {
            folder: folder.display().to_string(),
            kinds: requests.iter().map(NoiseRequest::name).collect(),
            methods,
            pairs: Vec::new(),
            rows: Vec::new(),
            by_kind: Vec::new(),
            by_group: Vec::new(),
            all: None,
            worst: Vec::new(),
            skipped: Vec::new(),
            broken: Vec::new(),
        }
    }

    /// Sums up.
    pub(super) fn finish(&mut self) {
        let pairs = &self.pairs;
        let of_kind = |kind: &&String| Summary::of(kind, pairs.iter().filter(|pair| pair.kind == **kind));
        self.by_kind = distinct(self.kinds.iter()).iter().map(of_kind).collect();
        let mut groups = distinct(pairs.iter().flat_map(|pair| &pair.groups));
        groups.sort();
        let of_group = |group: &&String| Summary::of(group, pairs.iter().filter(|pair| pair.groups.contains(group)));
        self.by_group = groups.iter().map(of_group).collect();
        self.all = Some(Summary::of("all", pairs.iter()));
        let mut worst: Vec<&Pair> = pairs.iter().filter(|pair| pair.ratio.is_some()).collect();
        worst.sort_by(|a, b| b.ratio.unwrap_or_default().total_cmp(&a.ratio.unwrap_or_default()));
        self.worst = worst.into_iter().take(WORST).cloned().collect();
    }

    /// Fails if something could not be measured.
    pub(super) fn verdict(&self) -> Result<(), Failure> {
        let Some(first) = self.broken.first() else { return Ok(()) };
        let others = match self.broken.len() - 1 {
            0 => String::new(),
            n => format!(" (and {n} more)"),
        };
        Err(Failure::Input(format!("{}{others}", first.line())))
    }

    /// Formats the report as tables for people.
    pub(super) fn text(&self) -> String {
        let first = &self.methods[0].name;
        let mut out = format!(
            "  {:32} {:16} {:>8} {:>8} {:18} {first:>8} {:>7}\n",
            "mesh", "noise", "noisy", "best", "by", "/ best"
        );
        self.pairs.iter().for_each(|pair| out.push_str(&pair.line()));
        let mut table = |title: &str, summaries: &[Summary]| {
            let _ = writeln!(
                out,
                "\n  {title:20} {:>5} {:>8} {:>8} {:>8} {:>8} {:>8} {:>7} {:>6} {:>9}",
                "pairs", "mean", "worst", "> 1.05", "> 1.10", "alone", "worse", "clean", "worst °"
            );
            summaries.iter().for_each(|summary| out.push_str(&summary.line()));
        };
        table("by kind", &self.by_kind);
        table("by group", &self.by_group);
        if let Some(all) = &self.all {
            out.push_str(&all.line());
        }
        if !self.worst.is_empty() {
            let _ = writeln!(out, "\nthe worst {}:", self.worst.len());
            self.worst.iter().for_each(|pair| out.push_str(&pair.line()));
        }
        for skipped in &self.skipped {
            let _ = writeln!(out, "left out: {}", skipped.line());
        }
        for broken in &self.broken {
            let _ = writeln!(out, "not measured: {}", broken.line());
        }
        let _ = writeln!(
            out,
            "\nEa in degrees; mean, worst, > 1.05, > 1.10: ratios of {first} to the best of the other methods; alone: left as it \
             was; worse: than the input; worst °: Ea of {first} on clean meshes"
        );
        out
    }
}

impl Unmeasured {
    fn line(&self) -> String {
        let parts = [Some(&self.mesh), self.kind.as_ref(), self.method.as_ref()];
        let names: Vec<&str> = parts.into_iter().flatten().map(String::as_str).collect();
        format!("{}: {}", names.join(", "), self.error)
    }
}
