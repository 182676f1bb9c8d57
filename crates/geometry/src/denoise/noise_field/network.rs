//! A small network that reads the statistics of a region: how much noise there is, and what it is like.
//!
//! The network was fitted to clean meshes with synthetic noise of many kinds by the commands in `training/README.md` of this crate.
//! Its weights are in `network.json`.

use super::statistics::COUNT;
use serde::Deserialize;
use std::sync::OnceLock;

/// Reading of one region by the network.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reading {
    /// Natural logarithm of the standard deviation along the normal over what the finest band alone says.
    pub(super) log_excess: f64,
    /// Correlation of the noise of neighbours.
    pub(super) correlation: f64,
    /// Log-odds that there is noise at all.
    pub(super) evidence: f64,
}

/// A network of two hidden layers and its calibration.
#[derive(Deserialize)]
pub(super) struct Network {
    /// Mean evidence of the regions of a connected component from which it is noisy.
    pub(super) component_threshold: f64,
    /// Mean evidence of the quarter of the regions with the most of it, from which a component is noisy in parts. Of a hundred
    /// clean shapes three are above one of the two thresholds.
    pub(super) quarter_threshold: f64,
    mean: Vec<f64>,
    deviation: Vec<f64>,
    layers: Vec<Layer>,
}

#[derive(Deserialize)]
struct Layer {
    /// Weights of each output. outputs×inputs
    weights: Vec<Vec<f64>>,
    bias: Vec<f64>,
}

impl Network {
    /// The network that is a part of this crate.
    pub(super) fn built_in() -> &'static Self {
        static NETWORK: OnceLock<Network> = OnceLock::new();
        NETWORK.get_or_init(|| serde_json::from_str(include_str!("network.json")).expect("a test reads it"))
    }

    /// Reads the statistics of a region.
    pub(super) fn read(&self, statistics: &[f64; COUNT]) -> Reading {
        /// Statistics that are farther from their mean than this many deviations are unlike all that was trained on.
        const FARTHEST: f64 = 4.0;
        /// Slope of the activation for negative values (leaky rectifier).
        const SLOPE: f64 = 0.1;
        let scaled = statistics.iter().zip(&self.mean).zip(&self.deviation);
        let mut values: Vec<f64> = scaled.map(|((x, mean), sd)| ((x - mean) / sd).clamp(-FARTHEST, FARTHEST)).collect();
        for (k, layer) in self.layers.iter().enumerate() {
            let is_last = k + 1 == self.layers.len();
            let output = |(weights, bias): (&Vec<f64>, &f64)| {
                let sum = weights.iter().zip(&values).map(|(w, x)| w * x).sum::<f64>() + bias;
                if is_last || sum > 0.0 { sum } else { SLOPE * sum }
            };
            values = layer.weights.iter().zip(&layer.bias).map(output).collect();
        }
        let [log_excess, correlation, evidence] = values[..] else { unreachable!("a test reads the network") };
        Reading { log_excess, correlation, evidence }
    }
}
