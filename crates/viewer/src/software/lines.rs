//! Wires and seams, as `shaders/overlay.wgsl` draws them.

use crate::settings::{Overlay, Settings};
use crate::wedges::Wedges;
use glam::Vec3;

/// What lines are drawn.
pub(super) struct Lines {
    overlay: Overlay,
    /// Of the lines, samples.
    width: f32,
    /// For each triangle bit k is set if the texture is cut along the edge opposite to corner k. #T
    cuts: Vec<u32>,
}

impl Lines {
    /// None if there are none.
    pub(super) fn new(settings: &Settings, wedges: &Wedges) -> Option<Self> {
        let overlay = settings.overlay;
        let cuts = overlay.seams.map_or_else(Vec::new, |_| wedges.cuts());
        (overlay.wireframe.is_some() || overlay.seams.is_some()).then(|| {
            let width = overlay.width * settings.supersampling as f32;
            Self { overlay, width, cuts }
        })
    }

    /// Draws over a colour. `weights` are those of a sample of a triangle, and `dx` and `dy` how they change to the next.
    pub(super) fn over(&self, colour: Vec3, triangle: usize, weights: Vec3, dx: Vec3, dy: Vec3) -> Vec3 {
        let pixels = weights / (dx * dx + dy * dy).max(Vec3::splat(1e-30)).map(f32::sqrt);
        let covered = |pixels: f32| (0.5 * self.width + 0.5 - pixels).clamp(0.0, 1.0);
        let mut colour = colour;
        if let Some(wire) = self.overlay.wireframe {
            colour = colour.lerp(wire.linear(), covered(pixels.min_element()));
        }
        if let Some(seam) = self.overlay.seams {
            let cut = self.cuts[triangle];
            let at_cut = (0..3).filter(|k| cut >> k & 1 == 1).map(|k| pixels[k]);
            colour = colour.lerp(seam.linear(), covered(at_cut.fold(f32::INFINITY, f32::min)));
        }
        colour
    }
}
