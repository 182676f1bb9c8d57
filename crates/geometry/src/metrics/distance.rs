//! Distances from points to a surface.

/// Distances of points to a surface. #P, model units
pub(super) struct Distances(pub(super) Vec<f64>);

impl Distances {
    pub(super) fn mean(&self) -> f64 {
        self.0.iter().sum::<f64>() / self.0.len() as f64
    }
    pub(super) fn rms(&self) -> f64 {
        (self.0.iter().map(|d| d * d).sum::<f64>() / self.0.len() as f64).sqrt()
    }
    pub(super) fn max(&self) -> f64 {
        self.0.iter().copied().fold(0.0, f64::max)
    }
}
