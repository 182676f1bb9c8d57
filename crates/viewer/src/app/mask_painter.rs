//! Masks that are painted: weights of the vertices, changed under a round brush.

use super::document::Document;
use super::results::{Loaded, Saved};
use super::{App, MessageKind};
use glam::DVec3;
use planish_files::failure::Failure;
use planish_files::mask::{self, MaskOption};
use planish_files::output::Output;
use planish_geometry::denoise::limits::{WeightMask, Weights};
use planish_geometry::mesh::normals::{FaceWeight, vertex_normals};
use planish_geometry::mesh::ray_tree::{Hit, RayTree};
use planish_geometry::progress::Progress as _;
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Effect of the brush on the weights of the vertices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Effect {
    /// Weights go to 0: vertices stay as they are.
    #[default]
    Protect,
    /// Weights go to 1: vertices are denoised.
    Release,
}

impl Effect {
    /// Returns the other effect.
    pub fn opposite(self) -> Self {
        match self {
            Self::Protect => Self::Release,
            Self::Release => Self::Protect,
        }
    }

    /// Weight that the brush leads to.
    fn weight(self) -> f32 {
        match self {
            Self::Protect => 0.0,
            Self::Release => 1.0,
        }
    }
}

/// A round, soft brush.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Brush {
    /// Effect on the weights.
    pub effect: Effect,
    /// Radius, in radii of the model's bounding sphere.
    pub radius: f32,
    /// Fraction of the way to the goal that one stroke goes in the middle of the brush, 0..=1.
    pub strength: f32,
}

impl Default for Brush {
    fn default() -> Self {
        Self { effect: Effect::default(), radius: 0.1, strength: 1.0 }
    }
}

impl Brush {
    /// Radii that the brush may have.
    pub const RADII: std::ops::RangeInclusive<f32> = 0.005..=1.0;

    /// Makes the brush larger or smaller.
    pub fn scale(&mut self, factor: f32) {
        self.radius = (self.radius * factor).clamp(*Self::RADII.start(), *Self::RADII.end());
    }

    /// Radius on a model, model units.
    pub fn radius_on(&self, document: &Document) -> f64 {
        f64::from(self.radius) * f64::from(document.scene.bounds().radius)
    }
}

/// Facts about a mesh that painting needs.
pub(super) struct Canvas {
    tree: RayTree,
    /// Unit normals of the vertices. #V
    normals: Vec<DVec3>,
}

/// Stroke that is being painted.
struct Stroke {
    effect: Effect,
    /// Weights before the stroke. #V
    before: Arc<Vec<f32>>,
    /// Fraction of the way to the goal that the stroke has gone at each vertex: a stroke that crosses itself does not add up. #V
    covered: Vec<f32>,
    /// Point of the stroke that was painted last.
    last: DVec3,
}

/// Weights of the open mesh, and the stroke that changes them.
#[derive(Default)]
pub(super) struct MaskPainter {
    canvas: Option<Arc<Canvas>>,
    /// Whether the brush is in hand.
    has_brush: bool,
    /// Weights that are shown; `None` before they are needed. #V
    weights: Option<Arc<Vec<f32>>>,
    /// Mask that the weights were made from.
    of: Option<WeightMask>,
    stroke: Option<Stroke>,
    /// File that painted masks are saved to.
    file: Option<PathBuf>,
}

/// Weights of the vertices of a mesh under a mask. #V
fn weights_of(document: &Document, mask: Option<&WeightMask>) -> Vec<f32> {
    let (weld, count) = (document.model.weld(), document.model.surface().positions().len());
    let weights = mask.map(|mask| mask.weights.of(count, weld)).unwrap_or_default();
    if weights.is_empty() { vec![1.0; count] } else { weights.into_iter().map(|weight| weight as f32).collect() }
}

/// Fraction of the brush's effect at a distance from its middle, in radii: full in the inner half, then smoothly to 0.
fn falloff(distance: f64) -> f64 {
    let t = (2.0 * distance - 1.0).clamp(0.0, 1.0);
    1.0 - t * t * (3.0 - 2.0 * t)
}

/// Cosine of the angle to the face that was hit from which a vertex counts as one of the other side, so that a thin sheet is painted on one
/// side alone. It is a little beyond a right angle, because noise tilts normals.
const OTHER_SIDE: f64 = -0.2;

impl Stroke {
    /// Paints on all vertices near a line from where the stroke was to `hit`, on the side of the surface that was hit.
    fn paint(&mut self, document: &Document, canvas: &Canvas, hit: &Hit, brush: &Brush) -> Vec<f32> {
        let radius = brush.radius_on(document);
        let along = hit.point - self.last;
        let length = along.length_squared();
        let cover = |p: DVec3, n: DVec3| {
            let t = if length > 0.0 { ((p - self.last).dot(along) / length).clamp(0.0, 1.0) } else { 0.0 };
            let near = (p - self.last - t * along).length_squared() / (radius * radius);
            if near < 1.0 && n.dot(hit.normal) > OTHER_SIDE {
                brush.strength * falloff(near.sqrt()) as f32
            } else {
                0.0
            }
        };
        let positions = document.model.surface().positions();
        let vertices = (positions, &canvas.normals).into_par_iter();
        self.covered.par_iter_mut().zip(vertices).for_each(|(covered, (p, n))| *covered = covered.max(cover(*p, *n)));
        self.last = hit.point;
        let goal = self.effect.weight();
        self.before.iter().zip(&self.covered).map(|(before, covered)| before + covered * (goal - before)).collect()
    }
}

impl App {
    /// Takes the brush in hand, or puts it down. With the brush in hand the model is coloured by its mask.
    pub fn switch_brush(&mut self) {
        self.end_stroke();
        self.painter.has_brush = !self.painter.has_brush && self.document.is_some();
    }

    /// Returns true while the brush is in hand.
    pub fn has_brush(&self) -> bool {
        self.painter.has_brush
    }

    /// Makes the open mesh ready for the brush, in the background, if it is not yet.
    fn prepare_painting(&mut self) {
        let Some(document) = self.document.clone() else { return };
        if self.painter.canvas.is_some() || self.preparing.is_busy() {
            return;
        }
        self.preparing.start(move |ticket| {
            ticket.stage("preparing the brush");
            let surface = document.model.surface();
            let canvas = Canvas { tree: RayTree::new(surface), normals: vertex_normals(surface, FaceWeight::Angle) };
            ticket.check()?;
            Ok((Arc::clone(&document), Arc::new(canvas)))
        });
    }

    /// Returns the point of the mesh that a ray meets first; `None` before the mesh is prepared, too.
    pub fn pick(&self, origin: DVec3, direction: DVec3) -> Option<Hit> {
        self.painter.canvas.as_ref()?.tree.first_hit(origin, direction)
    }

    /// Returns true while a stroke is being painted.
    pub fn is_painting(&self) -> bool {
        self.painter.stroke.is_some()
    }

    /// Paints to a point of the mesh, in a straight line from where the stroke was, or begins one.
    pub fn paint(&mut self, hit: &Hit, effect: Effect) {
        let (Some(document), Some(canvas)) = (self.document.clone(), self.painter.canvas.clone()) else { return };
        self.follow_mask();
        let Some(weights) = self.painter.weights.clone() else { return };
        let stroke = self.painter.stroke.get_or_insert_with(|| Stroke {
            effect,
            covered: vec![0.0; weights.len()],
            before: weights,
            last: hit.point,
        });
        self.painter.weights = Some(Arc::new(stroke.paint(&document, &canvas, hit, &self.brush)));
    }

    /// Ends a stroke: its mask becomes a choice, which is baked and can be undone.
    pub fn end_stroke(&mut self) {
        if self.painter.stroke.take().is_some()
            && let Some(weights) = self.painter.weights.clone()
        {
            self.choose_mask(&weights);
        }
    }

    /// Replaces the weights of all vertices.
    pub fn change_mask(&mut self, change: impl Fn(f32) -> f32) {
        self.follow_mask();
        if let Some(weights) = &self.painter.weights {
            let weights: Vec<f32> = weights.iter().map(|weight| change(*weight)).collect();
            self.choose_mask(&weights);
        }
    }

    fn choose_mask(&mut self, weights: &[f32]) {
        let Some(document) = self.document.clone() else { return };
        let file = self.painter.file.get_or_insert_with(|| file_for(&document.mesh));
        let weights = Weights::new(&document.model.weld().spread(weights));
        let mask = WeightMask { from: format!("weights:{}", file.display()), weights };
        self.choices.bake_config.limits.mask = Some(mask).filter(|mask| !mask.weights.is_empty());
        // Masks are kept in steps.
        self.painter.weights = None;
        self.follow_mask();
    }

    /// Keeps the mask that is shown up to date.
    pub(super) fn tend_mask(&mut self) {
        if self.painter.has_brush {
            self.prepare_painting();
        }
        if self.painter.has_brush || self.painter.weights.is_some() {
            self.follow_mask();
        }
    }

    /// Brings the weights that are shown up to date with the mask that is chosen, which undo may have changed.
    fn follow_mask(&mut self) {
        let Some(document) = &self.document else { return };
        let mask = &self.choices.bake_config.limits.mask;
        let painter = &mut self.painter;
        if painter.stroke.is_none() && (painter.weights.is_none() || painter.of != *mask) {
            painter.weights = Some(Arc::new(weights_of(document, mask.as_ref())));
            painter.of.clone_from(mask);
        }
    }

    /// Returns the weights of the vertices of the open mesh; `None` before they were needed. #V
    pub fn mask_weights(&self) -> Option<&Arc<Vec<f32>>> {
        self.painter.weights.as_ref()
    }

    /// Reads a mask from a grey picture or from a text with weights.
    pub fn open_mask(&mut self, path: &Path) {
        let Some(document) = self.document.clone() else { return };
        let text = path.display().to_string();
        let is_list = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("txt"));
        let text = if is_list { format!("weights:{text}") } else { text };
        self.loading.start(move |_| {
            let option: MaskOption = text.parse().map_err(Failure::Input)?;
            Ok(Loaded::Mask(document.mesh.clone(), option.weights(document.model.source(), &document.mesh)?))
        });
    }

    /// Writes the painted mask beside the mesh, as a text that `--mask weights:FILE` takes.
    pub fn save_mask(&mut self) {
        let Some(document) = self.document.clone() else { return };
        self.follow_mask();
        let Some(weights) = self.painter.weights.clone() else { return };
        let file = self.painter.file.get_or_insert_with(|| file_for(&document.mesh)).clone();
        self.saving.start(move |_| {
            let text = mask::list(&document.model.weld().spread(&weights));
            let output = Output::open(&file, &[&document.mesh])?;
            Ok(Saved { files: vec![output.write(text.as_bytes())?], map: None })
        });
    }

    /// Takes the mesh that was prepared for painting.
    pub(super) fn take_canvas(&mut self) {
        match self.preparing.poll() {
            None => {}
            // One that comes too late is of another mesh.
            Some(Ok((of, canvas))) if self.document.as_ref().is_some_and(|open| Arc::ptr_eq(open, &of)) => {
                self.painter.canvas = Some(canvas);
            }
            Some(Ok(_)) => {}
            Some(Err(failure)) => {
                // With the brush in hand it would be tried again at once.
                self.painter.has_brush = false;
                self.fail(&failure);
            }
        }
    }

    /// Takes a mask that was read, if it is for the mesh that is open.
    pub(super) fn take_mask(&mut self, mesh: &Path, mask: WeightMask) {
        if self.document.as_ref().is_some_and(|document| document.mesh == mesh) {
            self.say(MessageKind::Done, format!("the mask is {}", mask.from));
            self.choices.bake_config.limits.mask = Some(mask);
        }
    }

    /// Forgets what belonged to another mesh. One that was read again keeps the file of its mask.
    pub(super) fn forget_painting(&mut self, is_same_file: bool) {
        let file = self.painter.file.take().filter(|_| is_same_file);
        let has_brush = self.painter.has_brush;
        self.preparing.drop_running();
        self.painter = MaskPainter { has_brush, file, ..MaskPainter::default() };
    }
}

/// File for the painted mask of a mesh: the first name `NAME-mask.txt`, `NAME-mask-2.txt`, … beside it that no file has.
fn file_for(mesh: &Path) -> PathBuf {
    let stem = mesh.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let named = |end: String| mesh.with_file_name(format!("{stem}-mask{end}.txt"));
    let numbered = (2..10_000).map(|n: u32| named(format!("-{n}")));
    let mut names = std::iter::once(named(String::new())).chain(numbered);
    names.find(|path| !path.exists()).unwrap_or_else(|| named(String::new()))
}

#[cfg(test)]
mod tests;
