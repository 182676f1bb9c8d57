//! Samples to which networks and trees are fitted: statistics of regions, and the noise that they have in truth.

use super::regions::Regions;
use super::statistics::Statistics;
use super::{LEAST_REGION, RINGS};
use crate::denoise::connectivity::Connectivity;
use crate::mesh::jagged::Index;
use crate::mesh::surface::Surface;
use crate::progress::{Cancelled, Progress};

/// Statistics of one region of a noisy mesh, and the truth.
#[derive(Clone, Debug, PartialEq)]
pub struct RegionSample {
    /// Statistics of the region, in the order in which networks and trees read them.
    pub statistics: Vec<f64>,
    /// Standard deviation of the noise along the normals (root mean square), local edges.
    pub sigma: f64,
    /// Correlation of the noise along the normals between neighbours; 0 without noise.
    pub correlation: f64,
}

/// Samples from a noisy surface whose clean counterpart is known; both have the same topology.
pub fn samples(clean: &Surface, noisy: &Surface, progress: &dyn Progress) -> Result<Vec<RegionSample>, Cancelled> {
    let connectivity = Connectivity::of(noisy);
    let regions = Regions::of(noisy.topology(), 0, RINGS, LEAST_REGION);
    let statistics = Statistics::of(noisy, &connectivity, progress)?;
    let of_regions = statistics.of_regions(&regions);
    let normals = connectivity.vertex_normals(clean.positions());
    let height = |v: usize| (noisy.positions()[v] - clean.positions()[v]).dot(normals[v]);
    let sample = |region: usize| {
        let members = regions.vertices.get(region as Index);
        let mut along = 0.0;
        let (mut product, mut square) = (0.0, 0.0);
        for v in members.iter().map(|&v| v as usize) {
            let edge = statistics.local_edge[v];
            along += (height(v) / edge).powi(2);
            for w in noisy.topology().rings().get(v as Index).iter().map(|&w| w as usize) {
                product += height(v) * height(w);
                square += 0.5 * (height(v).powi(2) + height(w).powi(2));
            }
        }
        let count = members.len() as f64;
        of_regions[region].map(|statistics| RegionSample {
            statistics: statistics.to_vec(),
            sigma: (along / count).sqrt(),
            correlation: if square > 0.0 { product / square } else { 0.0 },
        })
    };
    Ok((0..regions.vertices.len()).filter_map(sample).collect())
}
