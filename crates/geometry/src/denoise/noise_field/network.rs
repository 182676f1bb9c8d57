//! Small networks that read the statistics of a region: how much noise there is, and what it is like.
//!
//! They were fitted to clean meshes with synthetic noise of many kinds by the commands in `training/README.md` of this crate.
//! Their weights are in `network.json`.

use super::statistics::COUNT;
use serde::Deserialize;
use std::sync::OnceLock;

/// Reading of one region: the mean of what the networks say.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reading {
    /// Natural logarithm of the standard deviation along the normal over what the finest band alone says.
    pub(super) log_excess: f64,
    /// Correlation of the noise of neighbours.
    pub(super) correlation: f64,
}

/// Networks of two hidden layers, fitted from different starts.
#[derive(Deserialize)]
pub(super) struct Network {
    mean: Vec<f64>,
    deviation: Vec<f64>,
    members: Vec<Vec<Layer>>,
}

#[derive(Deserialize)]
struct Layer {
    /// Weights of each output. outputs×inputs
    weights: Vec<Vec<f64>>,
    bias: Vec<f64>,
}

impl Network {
    /// The networks that are a part of this crate.
    pub(super) fn built_in() -> &'static Self {
        static NETWORK: OnceLock<Network> = OnceLock::new();
        NETWORK.get_or_init(|| serde_json::from_str(include_str!("network.json")).expect("a test reads it"))
    }

    /// Reads the statistics of a region.
    pub(super) fn read(&self, statistics: &[f64; COUNT]) -> Reading {
        /// Statistics that are farther from their mean than this many deviations are unlike all that was trained on.
        const FARTHEST: f64 = 4.0;
        let scaled = statistics.iter().zip(&self.mean).zip(&self.deviation);
        let scaled: Vec<f64> = scaled.map(|((x, mean), sd)| ((x - mean) / sd).clamp(-FARTHEST, FARTHEST)).collect();
        let mut mean = [0.0; 2];
        for layers in &self.members {
            let outputs = layers.iter().enumerate().fold(scaled.clone(), |values, (k, layer)| {
                let outputs = layer.outputs(&values);
                if k + 1 == layers.len() { outputs } else { outputs.into_iter().map(rectified).collect() }
            });
            mean.iter_mut().zip(outputs).for_each(|(mean, output)| *mean += output / self.members.len() as f64);
        }
        let [log_excess, correlation] = mean;
        Reading { log_excess, correlation }
    }
}

impl Layer {
    fn outputs(&self, values: &[f64]) -> Vec<f64> {
        let output =
            |(weights, bias): (&Vec<f64>, &f64)| weights.iter().zip(values).map(|(w, x)| w * x).sum::<f64>() + bias;
        self.weights.iter().zip(&self.bias).map(output).collect()
    }
}

/// Activation of the hidden layers (leaky rectifier).
fn rectified(x: f64) -> f64 {
    const SLOPE: f64 = 0.1;
    if x > 0.0 { x } else { SLOPE * x }
}
