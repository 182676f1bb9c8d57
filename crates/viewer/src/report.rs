//! A report on a map as one HTML file that opens anywhere: pictures, histograms and figures, without a network.

mod histogram;

pub use histogram::Histogram;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use planish_files::text::{self, measure};
use planish_geometry::denoise::Kind;
use planish_geometry::denoise::auto::DenoiseChoice;
use planish_geometry::map::displacement::{MapKind, Weights};
use planish_geometry::map::manifest::Manifest;
use planish_render::scene::Scene;
use std::fmt::Write as _;

/// Content of a report. Texts are plain: they are escaped where they get into the page.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// Name of the mesh.
    pub name: String,
    /// Sentences about what was found and done.
    pub summary: String,
    /// Mesh before denoising, as a PNG file.
    pub before: Vec<u8>,
    /// Mesh after denoising, as a PNG file of the same size.
    pub after: Vec<u8>,
    /// Heat maps.
    pub heat_maps: Vec<HeatMap>,
    /// Histograms.
    pub histograms: Vec<Histogram>,
    /// Names and values.
    pub figures: Vec<(String, String)>,
    /// Command that makes the map, as it is typed.
    pub command: String,
}

/// A picture whose colours stand for numbers.
#[derive(Clone, Debug)]
pub struct HeatMap {
    /// Heading.
    pub title: String,
    /// Caption that says what the colours mean.
    pub caption: String,
    /// Picture as a PNG file.
    pub picture: Vec<u8>,
}

/// Height of each vertex in the map of a scene, or the length of its displacement, model units; nothing without a map. #V
pub fn moves(scene: &Scene) -> Vec<f32> {
    let Some(binding) = &scene.displacement else { return Vec::new() };
    let map = &binding.map;
    let at = |sample| match map.kind() {
        MapKind::Scalar => map.height_at(sample, Weights::Exact),
        MapKind::VectorObject | MapKind::VectorTangent => map.vector_at(sample, Weights::Exact).length(),
    };
    binding.vertices.iter().map(|v| v.sample_at.map_or(0.0, at)).collect()
}

/// Sentences about what was found in a mesh and what its map, on the scene, does, for people who know nothing of denoising.
pub fn summary_of(scene: &Scene, manifest: &Manifest) -> String {
    let sizes: Vec<f32> = moves(scene).into_iter().map(f32::abs).collect();
    summary(manifest, &sizes)
}

/// Sentences about a map that moves the vertices by these distances at λ = 1, model units.
fn summary(manifest: &Manifest, moves: &[f32]) -> String {
    let found = match &manifest.choice {
        Some(choice) => found(choice),
        None => format!("The method {} was used with its settings.", manifest.method.name()),
    };
    let most = moves.iter().copied().filter(|x| x.is_finite()).fold(0.0, f32::max);
    if most == 0.0 {
        return format!("{found} The mesh stays as it is.");
    }
    let mean = moves.iter().map(|x| f64::from(*x)).sum::<f64>() / moves.len().max(1) as f64;
    format!(
        "{found} The map moves a vertex by {} on average and by {} at most, in units of the model.",
        rounded(mean),
        rounded(most.into())
    )
}

/// Sentence about the noise.
fn found(choice: &DenoiseChoice) -> String {
    let percent = |fraction: f64| format!("{:.0} %", (100.0 * fraction).max(1.0));
    let size = percent(choice.sigma);
    let mut out = match choice.kind {
        Kind::None if choice.unmeasured > 0.5 => {
            "The noise could not be measured, because too few vertices have faces all around them".to_owned()
        }
        Kind::None => "No noise could be told from the surface".to_owned(),
        _ if choice.hit > 0.0 => format!("Noise hits {} of the vertices", percent(choice.hit)),
        Kind::Independent => format!("The mesh has noise of {size} of the distance between neighbouring vertices"),
        Kind::Uneven => {
            format!("The mesh has uneven noise, typically {size} of the distance between neighbouring vertices")
        }
        Kind::Correlated => format!(
            "The mesh has noise of {size} of the distance between neighbouring vertices, alike at neighbours as in many scans"
        ),
    };
    if choice.noisy > 0.0 && choice.noisy < 0.95 {
        let _ = write!(out, ", on {} of its surface", percent(choice.noisy));
    }
    if choice.outliers > 0 {
        let _ = write!(out, ", and {}", text::count(choice.outliers, "spike", "spikes"));
    }
    out + "."
}

/// Number with three significant digits.
pub fn rounded(x: f64) -> String {
    let magnitude = if x == 0.0 { 0.0 } else { x.abs().log10().floor() };
    if !(-5.0..9.0).contains(&magnitude) {
        return format!("{x:.2e}");
    }
    let decimals = (2.0 - magnitude).max(0.0) as usize;
    format!("{x:.decimals$}")
}

/// Figures of a map: names and values.
pub fn figures(manifest: &Manifest) -> Vec<(String, String)> {
    let (map, report) = (&manifest.displacement, &manifest.report);
    let mut all = vec![
        ("Vertices".to_owned(), manifest.source.vertices.to_string()),
        ("Faces".to_owned(), manifest.source.faces.to_string()),
        ("Method".to_owned(), manifest.method.name().to_owned()),
    ];
    let mut add = |name: &str, value: String| all.push((name.to_owned(), value));
    if let Some(choice) = &manifest.choice {
        add("Noise and choice", choice.to_string());
    }
    add("Map", format!("{} × {} texels, {}", map.width, map.height, map.texel));
    add("Strength λ", map.lambda.to_string());
    add("Largest error of the map", format!("{} model units", measure(report.max_error)));
    add("Gap at seams", format!("{} model units", measure(report.seam_gap)));
    all
}

/// Text within HTML: what could end it or change its direction is escaped.
fn html(text: &str) -> String {
    let mut out = String::new();
    for c in text::one_line(text).chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            c => out.push(c),
        }
    }
    out
}

/// A picture within the page.
fn image(class: &str, alt: &str, png: &[u8]) -> String {
    format!("<img class=\"{class}\" alt=\"{}\" src=\"data:image/png;base64,{}\">", html(alt), STANDARD.encode(png))
}

impl Report {
    /// Prints the page.
    pub fn page(&self) -> String {
        let name = html(&self.name);
        let mut out = format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <meta http-equiv=\"Content-Security-Policy\" content=\"{POLICY}\">\n\
             <title>{name}: planish</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n<h1>{name}</h1>\n<p>{}</p>\n",
            html(&self.summary)
        );
        out += "<section>\n<h2>Before and after</h2>\n<figure class=\"compare\">\n";
        let _ = writeln!(out, "{}", image("before", "The mesh before denoising", &self.before));
        let _ = writeln!(out, "{}", image("after", "The mesh after denoising", &self.after));
        out += SLIDER;
        out += "</figure>\n</section>\n";
        self.print_maps(&mut out);
        out += "<section>\n<h2>Figures</h2>\n<table>\n";
        for (name, value) in &self.figures {
            let _ = writeln!(out, "<tr><th scope=\"row\">{}</th><td>{}</td></tr>", html(name), html(value));
        }
        out += "</table>\n</section>\n<section>\n<h2>How to make this map</h2>\n";
        out += "<p>This command writes the map, a mesh that carries it, and a file that says how to use both:</p>\n";
        let _ = writeln!(out, "<pre><code>{}</code></pre>", html(&self.command));
        out += "<p>The mesh file stays as it is. A program that draws it subtracts the map, at any strength λ: 0 is the mesh as it was \
                scanned, 1 is denoised.</p>\n</section>\n</main>\n";
        let _ = writeln!(out, "<footer>Made by planish {}.</footer>\n</body>\n</html>", env!("CARGO_PKG_VERSION"));
        out
    }

    fn print_maps(&self, out: &mut String) {
        if !self.heat_maps.is_empty() {
            *out += "<section>\n<h2>Where</h2>\n<div class=\"side-by-side\">\n";
            for map in &self.heat_maps {
                let picture = image("map", &map.title, &map.picture);
                let (title, caption) = (html(&map.title), html(&map.caption));
                let _ = writeln!(out, "<figure>{picture}<figcaption><b>{title}.</b> {caption}</figcaption></figure>");
            }
            *out += "</div>\n</section>\n";
        }
        if !self.histograms.is_empty() {
            *out += "<section>\n<h2>How much</h2>\n<div class=\"side-by-side\">\n";
            self.histograms.iter().for_each(|histogram| *out += &histogram.figure());
            *out += "</div>\n</section>\n";
        }
    }
}

/// Content security policy of the page, to which the browser holds it: it may only show its own contents.
const POLICY: &str = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'";

/// Slider over the pictures. Without scripts it stays in the middle.
const SLIDER: &str = "<div class=\"line\"></div>\n<span class=\"label left\">before</span><span class=\"label right\">after</span>\n\
    <input type=\"range\" min=\"0\" max=\"100\" step=\"0.1\" value=\"50\" aria-label=\"Share of the picture before denoising\" \
    oninput=\"this.parentNode.style.setProperty('--at', this.value + '%')\">\n";

const STYLE: &str = include_str!("report/report.css");

#[cfg(test)]
mod tests;
