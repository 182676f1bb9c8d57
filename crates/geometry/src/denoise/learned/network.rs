//! The networks of the learned filter: their file of weights, and their values for blocks of faces.

use super::simd::{LANES, exp, vectorised};
use half::f16;
use serde::Deserialize;
use std::collections::BTreeMap;
use thiserror::Error;

/// Number of faces that a network treats at a time.
pub(super) const BLOCK: usize = 48;
/// Rows of a block whose sums are in registers at the same time.
const ROWS: usize = 6;
/// Largest magnitude of a feature.
const LARGEST: f32 = 20.0;

/// Reasons why bytes are no weights of the learned filter.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum WeightsError {
    /// The bytes are no safetensors file.
    #[error("not a safetensors file: {0}")]
    NotSafetensors(String),
    /// A tensor is missing, or has another shape or type than the filter needs.
    #[error("tensor `{name}`: {problem}")]
    Tensor {
        /// Name of the tensor.
        name: String,
        /// Message of what is wrong with the tensor.
        problem: String,
    },
}

/// One network: a multilayer perceptron with rectifiers.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Network {
    mean: Vec<f32>,
    inverse_deviation: Vec<f32>,
    layers: Vec<Layer>,
}

/// A dense layer.
#[derive(Clone, Debug, PartialEq)]
struct Layer {
    inputs: usize,
    /// Weights of sixteen outputs at a time: block, input, output.
    weights: Vec<[f32; LANES]>,
    bias: Vec<[f32; LANES]>,
}

impl Network {
    /// Number of features.
    pub(super) fn inputs(&self) -> usize {
        self.mean.len()
    }

    /// Number of outputs, rounded up to a multiple of sixteen; those on top are zero.
    pub(super) fn padded_outputs(&self) -> usize {
        self.layers[self.layers.len() - 1].bias.len() * LANES
    }

    /// Computes the outputs of a block of faces from their features ([`BLOCK`]×inputs), which are clamped. The result has
    /// [`BLOCK`]×[`Self::padded_outputs`] numbers. `spare` is room for the layers between.
    pub(super) fn outputs(&self, features: &mut [f32], spare: &mut [Vec<f32>; 2]) -> Vec<f32> {
        vectorised(
            #[inline(always)]
            || {
                for row in features.chunks_exact_mut(self.inputs()) {
                    for ((x, mean), inverse) in row.iter_mut().zip(&self.mean).zip(&self.inverse_deviation) {
                        let clamped = if *x > LARGEST { LARGEST } else { *x };
                        let clamped = if clamped > -LARGEST { clamped } else { -LARGEST };
                        *x = (clamped - mean) * inverse;
                    }
                }
                let [from, to] = spare;
                self.layers[0].apply(features, to);
                for layer in &self.layers[1..] {
                    // Between the layers what is negative is cut off.
                    for x in &mut *to {
                        *x = if *x > 0.0 { *x } else { 0.0 };
                    }
                    std::mem::swap(from, to);
                    layer.apply(from, to);
                }
                to.clone()
            },
        )
    }
}

impl Layer {
    /// Appends nothing and replaces `outputs` by those of [`BLOCK`] rows of `inputs`; rows may be longer than the layer has inputs.
    #[inline(always)]
    fn apply(&self, inputs: &[f32], outputs: &mut Vec<f32>) {
        let stride = inputs.len() / BLOCK;
        let width = self.bias.len() * LANES;
        outputs.clear();
        outputs.resize(BLOCK * width, 0.0);
        for (block, bias) in self.bias.iter().enumerate() {
            let weights = &self.weights[block * self.inputs..(block + 1) * self.inputs];
            for first in (0..BLOCK).step_by(ROWS) {
                let row = |r: usize| &inputs[(first + r) * stride..][..weights.len()];
                let (r0, r1, r2, r3, r4, r5) = (row(0), row(1), row(2), row(3), row(4), row(5));
                let [mut s0, mut s1, mut s2, mut s3, mut s4, mut s5] = [*bias; ROWS];
                // One statement for each row, so that the sums stay in registers.
                for (k, weight) in weights.iter().enumerate() {
                    add_scaled(&mut s0, r0[k], weight);
                    add_scaled(&mut s1, r1[k], weight);
                    add_scaled(&mut s2, r2[k], weight);
                    add_scaled(&mut s3, r3[k], weight);
                    add_scaled(&mut s4, r4[k], weight);
                    add_scaled(&mut s5, r5[k], weight);
                }
                let sums = [s0, s1, s2, s3, s4, s5];
                for (r, sum) in sums.iter().enumerate() {
                    outputs[(first + r) * width + block * LANES..][..LANES].copy_from_slice(sum);
                }
            }
        }
    }
}

/// Adds `factor` times other lanes.
#[inline(always)]
fn add_scaled(sum: &mut [f32; LANES], factor: f32, lanes: &[f32; LANES]) {
    for k in 0..LANES {
        sum[k] += factor * lanes[k];
    }
}

/// Replaces values by their softmax: positive numbers that add up to 1.
pub(super) fn softmax(values: &mut [f32]) {
    let largest = values.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    values.iter_mut().for_each(|x| *x = exp(*x - largest));
    let sum: f32 = values.iter().sum();
    values.iter_mut().for_each(|x| *x /= sum);
}

/// Description of a tensor in the head of a safetensors file.
#[derive(Deserialize)]
struct TensorInfo {
    dtype: String,
    shape: Vec<usize>,
    data_offsets: [usize; 2],
}

/// The tensors of a safetensors file (<https://github.com/huggingface/safetensors>).
pub(super) struct Tensors<'a> {
    infos: BTreeMap<String, TensorInfo>,
    data: &'a [u8],
}

impl<'a> Tensors<'a> {
    pub(super) fn parse(bytes: &'a [u8]) -> Result<Self, WeightsError> {
        let not = |why: &str| WeightsError::NotSafetensors(why.to_owned());
        let (length, rest) = bytes.split_first_chunk::<8>().ok_or_else(|| not("it is shorter than its head"))?;
        let length = usize::try_from(u64::from_le_bytes(*length)).ok().filter(|n| *n <= rest.len());
        let (head, data) = rest.split_at(length.ok_or_else(|| not("its head is longer than the file"))?);
        let mut head: BTreeMap<String, serde_json::Value> =
            serde_json::from_slice(head).map_err(|e| not(&e.to_string()))?;
        head.remove("__metadata__");
        let infos = head.into_iter().map(|(name, value)| Ok((name, serde_json::from_value(value)?)));
        let infos = infos.collect::<Result<_, serde_json::Error>>().map_err(|e| not(&e.to_string()))?;
        Ok(Self { infos, data })
    }

    pub(super) fn contains(&self, name: &str) -> bool {
        self.infos.contains_key(name)
    }

    /// Shape and numbers of a tensor of halves.
    fn halves(&self, name: &str) -> Result<(Vec<usize>, Vec<f32>), WeightsError> {
        let problem = |problem: &str| WeightsError::Tensor { name: name.to_owned(), problem: problem.to_owned() };
        let info = self.infos.get(name).ok_or_else(|| problem("missing"))?;
        if info.dtype != "F16" {
            return Err(problem("not of type F16"));
        }
        let [start, end] = info.data_offsets;
        let bytes = self.data.get(start..end).ok_or_else(|| problem("outside of the file"))?;
        let count = info.shape.iter().try_fold(1usize, |n, side| n.checked_mul(*side));
        if count.and_then(|n| n.checked_mul(2)) != Some(bytes.len()) {
            return Err(problem("another length than its shape says"));
        }
        let numbers: Vec<f32> = bytes.as_chunks().0.iter().map(|half| f16::from_le_bytes(*half).to_f32()).collect();
        if numbers.iter().any(|x| !x.is_finite()) {
            return Err(problem("has numbers that are not finite"));
        }
        Ok((info.shape.clone(), numbers))
    }

    /// Numbers of a tensor with one axis.
    pub(super) fn vector(&self, name: &str) -> Result<Vec<f32>, WeightsError> {
        let (shape, numbers) = self.halves(name)?;
        if shape.len() == 1 {
            return Ok(numbers);
        }
        Err(WeightsError::Tensor { name: name.to_owned(), problem: format!("has {} axes instead of one", shape.len()) })
    }

    /// The network whose tensors begin with `prefix`, with this many features and outputs: `prefix.mean`, `prefix.deviation`, and for
    /// layer k `prefix.k.weight` (outputs×inputs) and `prefix.k.bias`.
    pub(super) fn network(&self, prefix: &str, inputs: usize, outputs: usize) -> Result<Network, WeightsError> {
        let wrong = |name: &str, problem: String| WeightsError::Tensor { name: name.to_owned(), problem };
        let sized = |name: String, size: usize| {
            let numbers = self.vector(&name)?;
            let other = numbers.len();
            if other == size {
                Ok(numbers)
            } else {
                Err(wrong(&name, format!("has {other} numbers instead of {size}")))
            }
        };
        let mean = sized(format!("{prefix}.mean"), inputs)?;
        let deviation = sized(format!("{prefix}.deviation"), inputs)?;
        if deviation.iter().any(|x| *x <= 0.0) {
            return Err(wrong(&format!("{prefix}.deviation"), "has a number that is not above 0".to_owned()));
        }
        let mut layers = Vec::new();
        let mut width = inputs;
        while self.contains(&format!("{prefix}.{}.weight", layers.len())) {
            let name = format!("{prefix}.{}.weight", layers.len());
            let (shape, weights) = self.halves(&name)?;
            let [rows, columns] = shape[..] else { return Err(wrong(&name, "has not two axes".to_owned())) };
            if columns != width || rows == 0 {
                return Err(wrong(&name, format!("is {rows}×{columns}, but there are {width} inputs")));
            }
            let bias = sized(format!("{prefix}.{}.bias", layers.len()), rows)?;
            layers.push(Layer::new(columns, &weights, &bias));
            width = rows;
        }
        if layers.is_empty() || width != outputs {
            return Err(wrong(prefix, format!("the last layer has {width} outputs instead of {outputs}")));
        }
        let inverse_deviation = deviation.iter().map(|x| 1.0 / x).collect();
        Ok(Network { mean, inverse_deviation, layers })
    }
}

impl Layer {
    fn new(inputs: usize, weights: &[f32], bias: &[f32]) -> Self {
        let blocks = bias.len().div_ceil(LANES);
        let at = |output: usize, k: usize| if output < bias.len() { weights[output * inputs + k] } else { 0.0 };
        let lane = |block: usize, k: usize| std::array::from_fn(|l| at(block * LANES + l, k));
        let weights = (0..blocks).flat_map(|block| (0..inputs).map(move |k| lane(block, k))).collect();
        let bias = (0..blocks)
            .map(|block| std::array::from_fn(|l| bias.get(block * LANES + l).copied().unwrap_or(0.0)))
            .collect();
        Self { inputs, weights, bias }
    }
}
