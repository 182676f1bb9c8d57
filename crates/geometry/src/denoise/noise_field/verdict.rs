//! Whether a mesh has noise, and in which regions.

use super::forest::Forest;
use super::regions::Regions;
use super::statistics::{self, Statistics};
use super::{LEAST_REGION, RINGS};
use crate::mesh::jagged::Index;
use crate::mesh::topology::Topology;
use rayon::prelude::*;

/// Who says whether a mesh has noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::denoise) enum Verdict {
    /// The finest band of the mesh says that it has noise all over, and each vertex its own; the evidence may contradict.
    White,
    /// The mesh has noise all over, and each vertex its own.
    SurelyWhite,
    /// The mesh has noise all over, of whatever kind.
    Noisy,
    /// The evidence decides, region by region.
    ByEvidence,
}

/// Statistics of a region, where anything can be measured.
type OfRegion = Option<[f64; statistics::COUNT]>;

/// Number of partitions into regions from which it is judged whether there is noise: a few regions may lie by chance where little
/// can be told. Of 291 noisy meshes of the training set, the networks that judged before the trees called 30 clean by one partition, 28 by
/// two and 27 by four.
const PARTITIONS: usize = 4;

/// The partition of a mesh into regions that is found from this vertex.
pub(super) fn partition(topology: &Topology, start: Index) -> Regions {
    Regions::of(topology, start, RINGS, LEAST_REGION)
}

/// Whether each region of the first partition (`regions`, with the statistics `of_regions`) has noise.
pub(super) fn noisy_regions(
    verdict: Verdict,
    topology: &Topology,
    statistics: &Statistics,
    regions: &Regions,
    of_regions: &[OfRegion],
) -> Vec<bool> {
    if !matches!(verdict, Verdict::White | Verdict::ByEvidence) {
        return vec![true; of_regions.len()];
    }
    let own = evidence(of_regions);
    if verdict == Verdict::White {
        return vec![!contradicts(&own); of_regions.len()];
    }
    let mut of_components = by_component(regions, &own);
    for k in 1..PARTITIONS {
        let regions = partition(topology, (topology.vertex_count() * k / PARTITIONS) as Index);
        let more = by_component(&regions, &evidence(&statistics.of_regions(&regions)));
        of_components.iter_mut().zip(more).for_each(|(all, more)| all.extend(more));
    }
    judged(regions, of_regions, &own, of_components)
}

/// Evidence for noise in each region.
fn evidence(of_regions: &[OfRegion]) -> Vec<Option<f64>> {
    /// Evidence beyond which one region is as good as another.
    const CERTAIN: f64 = 6.0;
    let forest = Forest::built_in();
    let of = |statistics: &OfRegion| statistics.as_ref().map(|s| forest.evidence(s).clamp(-CERTAIN, CERTAIN));
    of_regions.par_iter().map(of).collect()
}

/// Whether the regions say all in all that what looks like white noise is the surface, as knurls are that have the spacing of the
/// vertices.
///
/// Evidence is a logarithm of odds, so 0 is where neither is likelier. Of 1,149 noisy versions of training shapes whose noise is even and
/// white, 6 are below by trees that were fitted without these shapes, all of them reliefs.
fn contradicts(evidence: &[Option<f64>]) -> bool {
    let (sum, count) = evidence.iter().flatten().fold((0.0, 0.0), |(sum, count), e| (sum + e, count + 1.0));
    count > 0.0 && sum / count < 0.0
}

/// Evidence for noise in the regions of each component.
fn by_component(regions: &Regions, evidence: &[Option<f64>]) -> Vec<Vec<f64>> {
    let components = regions.component.iter().max().map_or(0, |c| *c as usize + 1);
    let mut of_components = vec![Vec::new(); components];
    for (evidence, component) in evidence.iter().zip(&regions.component) {
        of_components[*component as usize].extend(evidence);
    }
    of_components
}

/// Whether each region has noise, by the evidence of all partitions for each component. A component is noisy as a whole where its
/// regions say so on average, and in parts where a quarter of them is sure; regions of which nothing is known go with their component.
fn judged(
    regions: &Regions,
    of_regions: &[OfRegion],
    evidence: &[Option<f64>],
    of_components: Vec<Vec<f64>>,
) -> Vec<bool> {
    /// Number of regions as which the whole mesh counts beside those of a component: a few regions alone err together.
    const WHOLE: f64 = 3.0;
    /// Evidence from which a region has noise more likely than not, where there is noise for sure in some.
    const EVEN: f64 = 0.0;
    if is_one_sided(of_regions) {
        return vec![false; evidence.len()];
    }
    let forest = Forest::built_in();
    let all: Vec<f64> = of_components.iter().flatten().copied().collect();
    let whole = WHOLE * all.iter().sum::<f64>() / all.len().max(1) as f64;
    let mean = |values: &[f64]| (values.iter().sum::<f64>() + whole) / (values.len() as f64 + WHOLE);
    let least = |mut evidence: Vec<f64>| {
        evidence.sort_unstable_by(|a, b| b.total_cmp(a));
        let quarter = &evidence[..evidence.len().div_ceil(4)];
        if evidence.is_empty() {
            f64::INFINITY
        } else if mean(&evidence) > forest.component_threshold {
            f64::NEG_INFINITY
        } else if mean(quarter) > forest.quarter_threshold {
            EVEN
        } else {
            f64::INFINITY
        }
    };
    let least: Vec<f64> = of_components.into_iter().map(least).collect();
    let is_noisy = |(evidence, component): (&Option<f64>, &Index)| {
        let least = least[*component as usize];
        evidence.map_or(least == f64::NEG_INFINITY, |evidence| evidence > least)
    };
    evidence.iter().zip(&regions.component).map(is_noisy).collect()
}

/// True for roughness that has bumps or pits all over, but not both alike, as no sensor errs: the pores of a sponge.
fn is_one_sided(of_regions: &[OfRegion]) -> bool {
    /// Fraction of the regions that lean to the same side. Noisy machine parts have creases on one side in some of them.
    const MOST: f64 = 0.75;
    /// Difference of the two numbers in its standard deviations by chance.
    const CERTAIN: f64 = 3.0;
    let to_side =
        |side: f64| of_regions.iter().flatten().filter(|s| side * s[statistics::SKEWNESS] > 0.0).count() as f64;
    let (outwards, inwards) = (to_side(1.0), to_side(-1.0));
    let count = outwards + inwards;
    outwards.max(inwards) >= MOST * count && (outwards - inwards).abs() > CERTAIN * count.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn evidence_against_noise_contradicts_and_a_lack_of_it_does_not() {
        let cases: [(&[Option<f64>], bool); 4] = [
            (&[Some(-1.5), None, Some(1.0)], true),
            (&[Some(2.0), None, Some(-1.0)], false),
            (&[None, None], false),
            (&[], false),
        ];
        for (evidence, expected) in cases {
            assert_eq!(contradicts(evidence), expected, "{evidence:?}");
        }
    }
}
