//! The report of `planish bench-quality`.

use super::pairs::Pair;
use crate::failure::Failure;
use planish_geometry::denoise::Denoiser;
use planish_geometry::metrics::Comparison;
use serde::Serialize;
use std::fmt::Write as _;
use std::path::Path;

/// Results of all methods on all pairs.
#[derive(Serialize)]
pub(super) struct Report {
    folder: String,
    /// Methods with all their settings.
    pub(super) methods: Vec<Denoiser>,
    pub(super) pairs: Vec<Measured>,
    pub(super) rows: Vec<Row>,
    means: Vec<Mean>,
    pub(super) broken: Vec<Broken>,
}

/// A pair before denoising.
#[derive(Serialize)]
pub(super) struct Measured {
    pair: String,
    vertices: usize,
    faces: usize,
    #[serde(rename = "Ea_noisy_deg")]
    noisy: f64,
    /// Best result of a program without learning.
    best: Option<Figure>,
    published: Option<Figure>,
}

/// Result of another program.
#[derive(Serialize)]
struct Figure {
    of: String,
    #[serde(rename = "Ea_deg")]
    ea: f64,
}

/// Result of a method for a pair.
#[derive(Serialize)]
pub(super) struct Row {
    pair: String,
    method: &'static str,
    seconds: f64,
    #[serde(flatten)]
    ratios: Ratios,
    /// Mean angle by which the method rotates the faces of the clean mesh, in degrees; `None` without `--harm`.
    #[serde(rename = "Ea_harm_deg", skip_serializing_if = "Option::is_none")]
    harm: Option<f64>,
    #[serde(flatten)]
    comparison: Comparison,
}

/// Ratios of an Ea to those of the noisy mesh, of the best program without learning, and of the program of the method's
/// authors.
#[derive(Clone, Copy, Serialize)]
struct Ratios {
    #[serde(rename = "Ea_over_noisy")]
    noisy: Option<f64>,
    #[serde(rename = "Ea_over_best")]
    best: Option<f64>,
    #[serde(rename = "Ea_over_reference")]
    reference: Option<f64>,
}

/// Summary of a method over all pairs: geometric means of the ratios, sums of the rest.
#[derive(Serialize)]
struct Mean {
    method: &'static str,
    pairs: usize,
    #[serde(flatten)]
    ratios: Ratios,
    flipped: usize,
    seconds: f64,
}

/// A pair, or a method on a pair, that could not be measured.
#[derive(Serialize)]
pub(super) struct Broken {
    pub(super) pair: String,
    /// Name of the method; `None` if a mesh is at fault.
    pub(super) method: Option<&'static str>,
    pub(super) error: String,
}

impl Measured {
    pub(super) fn new(pair: &Pair, before: &Comparison) -> Self {
        let figure = |(of, ea): (&str, f64)| Figure { of: of.to_owned(), ea };
        Self {
            pair: pair.name.clone(),
            vertices: before.vertices,
            faces: before.faces,
            noisy: before.ea,
            best: pair.best().map(figure),
            published: pair.published().map(figure),
        }
    }
}

impl Row {
    pub(super) fn new(pair: &Pair, denoiser: &Denoiser, before: &Comparison, found: Comparison, seconds: f64) -> Self {
        let over = |ea: f64| Some(found.ea / ea).filter(|ratio| ratio.is_finite());
        let ratios = Ratios {
            noisy: over(before.ea),
            best: pair.best().and_then(|(_, ea)| over(ea)),
            reference: pair.reference(denoiser).and_then(over),
        };
        Self { pair: pair.name.clone(), method: denoiser.name(), seconds, ratios, harm: None, comparison: found }
    }

    /// Returns the row with the mean angle by which the method rotates the faces of the clean mesh, in degrees.
    pub(super) fn with_harm(self, harm: Option<f64>) -> Self {
        Self { harm, ..self }
    }
}

impl Report {
    pub(super) fn new(folder: &Path, methods: Vec<Denoiser>) -> Self {
        let folder = folder.display().to_string();
        Self { folder, methods, pairs: Vec::new(), rows: Vec::new(), means: Vec::new(), broken: Vec::new() }
    }

    /// Sums up.
    pub(super) fn finish(&mut self) {
        let mean = |denoiser: &Denoiser| {
            let rows: Vec<&Row> = self.rows.iter().filter(|row| row.method == denoiser.name()).collect();
            let geometric = |ratio: fn(&Ratios) -> Option<f64>| {
                let logarithms: Vec<f64> = rows.iter().filter_map(|row| ratio(&row.ratios)).map(f64::ln).collect();
                (!logarithms.is_empty()).then(|| (logarithms.iter().sum::<f64>() / logarithms.len() as f64).exp())
            };
            Mean {
                method: denoiser.name(),
                pairs: rows.len(),
                ratios: Ratios {
                    noisy: geometric(|r| r.noisy),
                    best: geometric(|r| r.best),
                    reference: geometric(|r| r.reference),
                },
                flipped: rows.iter().map(|row| row.comparison.flipped).sum(),
                seconds: rows.iter().map(|row| row.seconds).sum(),
            }
        };
        self.means = self.methods.iter().map(mean).collect();
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

    /// Formats the report as a table for people.
    pub(super) fn text(&self) -> String {
        let mut out = String::new();
        let line =
            |out: &mut String, method: &str, ea: &str, ratios: &Ratios, d: &str, flipped: usize, seconds: f64| {
                let [noisy, best, reference] = [ratios.noisy, ratios.best, ratios.reference]
                    .map(|x| x.map_or_else(|| "-".to_owned(), |x| format!("{x:.3}")));
                let _ = writeln!(
                    out,
                    "  {method:17} {ea:>8} {noisy:>8} {best:>8} {reference:>10} {d:>8} {flipped:>8} {seconds:>8.2}"
                );
            };
        let _ = writeln!(
            out,
            "  {:17} {:>8} {:>8} {:>8} {:>10} {:>8} {:>8} {:>8}",
            "method", "Ea °", "/ noisy", "/ best", "/ its own", "d mean", "flipped", "seconds"
        );
        for pair in &self.pairs {
            let _ = write!(out, "{}: {} vertices, Ea {:.2}° noisy", pair.pair, pair.vertices, pair.noisy);
            if let Some(Figure { of, ea }) = &pair.best {
                let _ = write!(out, ", {ea:.2}° best of other programs ({of})");
            }
            if let Some(Figure { of, ea }) = &pair.published {
                let _ = write!(out, ", {ea:.2}° published ({of})");
            }
            out.push('\n');
            for row in self.rows.iter().filter(|row| row.pair == pair.pair) {
                let Row { method, seconds, ratios, comparison: c, .. } = row;
                let [ea, d] = [format!("{:.3}", c.ea), format!("{:.4}", c.d_mean)];
                line(&mut out, method, &ea, ratios, &d, c.flipped, *seconds);
                if let Some(harm) = row.harm {
                    let _ = writeln!(out, "  {:17} {harm:8.3} on the clean mesh", "");
                }
            }
        }
        if self.pairs.len() > 1 {
            let _ = writeln!(out, "{} pairs: geometric means, sums of flipped faces and seconds", self.pairs.len());
            for Mean { method, ratios, flipped, seconds, .. } in &self.means {
                line(&mut out, method, "", ratios, "", *flipped, *seconds);
            }
        }
        for broken in &self.broken {
            let _ = writeln!(out, "not measured: {}", broken.line());
        }
        out.push_str("Ea: mean angle between face normals; d: distance to the clean surface in mean edge lengths; ");
        out.push_str("/ its own: over another program with the same settings\n");
        out
    }
}

impl Broken {
    fn line(&self) -> String {
        match self.method {
            Some(method) => format!("{}, {method}: {}", self.pair, self.error),
            None => format!("{}: {}", self.pair, self.error),
        }
    }
}
