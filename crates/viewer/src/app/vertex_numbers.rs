//! Numbers of the vertices that the model can be coloured by.

use super::App;
use crate::vertex_error;
use planish_geometry::metrics::colormap::Colormap;
use planish_render::settings::{Range, Settings, Shading};
use std::sync::Arc;

/// Meaning of the numbers of the vertices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quantity {
    /// Standard deviation of the noise that `auto` measured, mean edge lengths.
    #[default]
    Noise,
    /// Angle between the normals of the clean mesh and of the mesh as it is displaced, degrees.
    Error,
    /// Weight of the mask, by which displacements are multiplied.
    Mask,
}

/// A number for each vertex of the scene, and how it is shown. Vertices whose number is not finite have no colour.
#[derive(Clone, Debug)]
pub struct VertexNumbers {
    /// Numbers of the vertices. #V
    pub numbers: Arc<Vec<f32>>,
    /// Numbers at the ends of the colour bar.
    pub range: Range,
    /// Title of the colour bar.
    pub title: &'static str,
}

impl VertexNumbers {
    /// Colours of all numbers that have no sign.
    pub const COLORMAP: Colormap = Colormap::Sequential;

    /// Standard deviations of the noise (#V, model units) in mean edge lengths; `None` if the method measured none.
    pub fn of_noise(deviations: &[f64], mean_edge: f64) -> Option<Self> {
        let numbers: Vec<f32> = deviations.iter().map(|sigma| (sigma / mean_edge) as f32).collect();
        let range = vertex_error::range(&numbers);
        let title = "noise, mean edges";
        (!numbers.is_empty()).then(|| Self { numbers: Arc::new(numbers), range, title })
    }
}

impl App {
    /// Returns the settings of what is shown: those that are chosen, or the mask as colours while the brush is in hand.
    pub fn shown_view(&self) -> Settings {
        let mut view = self.choices.view.clone();
        if self.has_brush() {
            view.shading = Shading::Heat;
        }
        view
    }

    /// Returns the numbers that the model is to be coloured by; `None` where they are not known.
    pub fn vertex_numbers(&self) -> Option<VertexNumbers> {
        match if self.has_brush() { Quantity::Mask } else { self.quantity } {
            Quantity::Noise => self.map.as_ref()?.noise.clone(),
            Quantity::Error => self.measured.as_ref()?.errors.clone(),
            Quantity::Mask => Some(VertexNumbers {
                numbers: Arc::clone(self.mask_weights()?),
                range: Range { low: 0.0, high: 1.0 },
                title: "mask: 0 stays, 1 is denoised",
            }),
        }
    }
}
