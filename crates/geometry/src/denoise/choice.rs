//! Report of what a method chose by itself, as plain data: the noise it found and the candidates it mixed.

use super::noise_level::{Kind, NoiseLevel};
use crate::named;
use serde::{Deserialize, Serialize};
use std::fmt;

named! {
    /// A way to denoise that `auto` may try; all that it needs beside is the noise.
    pub enum Candidate {
        /// `map` with the prior for flat parts with sharp creases; also stands noise that is alike between neighbours.
        Flat = "flat",
        /// `map` with the prior for curved parts with sharp creases.
        Sharp = "sharp",
        /// `map` with the prior for parts whose creases need not be sharp.
        Creases = "creases",
        /// `map` with the prior for shapes with some creases.
        Mixed = "mixed",
        /// `map` with the prior for smooth shapes with detail.
        Detail = "detail",
        /// `map` with the prior for smooth shapes.
        Smooth = "smooth",
        /// `map` with the prior for flat parts, five times as strong: for noise that neighbours share.
        FlatStrong = "flat-strong",
        /// `map` with the prior for parts with creases, five times as strong.
        CreasesStrong = "creases-strong",
        /// `map` with the prior for smooth shapes, five times as strong.
        SmoothStrong = "smooth-strong",
        /// `bilateral-normals`: for noise that neighbours share, on machine parts.
        Bilateral = "bilateral",
        /// Linear smoothing, very little.
        LinearFaint = "linear-faint",
        /// Linear smoothing, little.
        LinearLight = "linear-light",
        /// Linear smoothing.
        Linear = "linear",
        /// Linear smoothing, much.
        LinearStrong = "linear-strong",
        /// Linear smoothing over wide neighbourhoods: for noise that neighbours share.
        LinearWide = "linear-wide",
        /// The learned filter. By default it has the last word on the mixture of the others; told by name, it is one of them.
        Learned = "learned",
        /// The mesh as it is.
        Stay = "stay",
    }
}

/// Report of the automatic method: the noise it measured and the candidates it chose.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DenoiseChoice {
    /// Noise as measured on the mesh.
    pub measured: NoiseLevel,
    /// Kind of noise that was assumed.
    pub kind: Kind,
    /// Standard deviation σ of the noise that was assumed, the median over the noisy vertices, local edges; 0 where there is none.
    pub sigma: f64,
    /// Upper bound of the standard deviation in tangential directions that was assumed, local edges.
    #[serde(default, rename = "across")]
    pub tangential_sigma: f64,
    /// Fraction of the vertices that are noisy, 0..=1.
    #[serde(default)]
    pub noisy: f64,
    /// Fraction of the vertices in places where nothing can be measured, 0..=1: too few vertices have faces all around them.
    #[serde(default)]
    pub unmeasured: f64,
    /// Fraction of the noisy vertices that have nearly all of the noise, 0..=1; 0 where all have about the same. `sigma` is that of
    /// the others then.
    #[serde(default)]
    pub hit: f64,
    /// Number of vertices that are spikes or craters beside their neighbours; they went to the surface of these.
    #[serde(default)]
    pub outliers: usize,
    /// Number of vertices that stand for "no data", tens of edges away from all that is around them; they stay.
    #[serde(default)]
    pub no_data: usize,
    /// Number of vertices that went as far as their noise can have pushed them.
    #[serde(default)]
    pub bounded: usize,
    /// Candidates with their shares, which add up to 1; the largest share comes first.
    pub candidates: Vec<CandidateShare>,
    /// Standard deviation σ of the noise that was assumed at each vertex, model units; 0 where a vertex has none or it could not be
    /// measured. Not a part of manifests and reports. #V
    #[serde(skip)]
    pub deviations: Vec<f64>,
}

/// A candidate and its share of the result.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CandidateShare {
    /// The candidate.
    pub candidate: Candidate,
    /// Share of the candidate in the result, 0..=1.
    pub share: f64,
    /// Estimated mean squared error of the normals beyond that of the best pair, square degrees; `None` where it was not
    /// estimated.
    #[serde(rename = "behind")]
    pub risk_gap: Option<f64>,
}

impl CandidateShare {
    pub(super) fn all_of(candidate: Candidate) -> Self {
        Self { candidate, share: 1.0, risk_gap: None }
    }
}

impl fmt::Display for Candidate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl fmt::Display for DenoiseChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.kind {
            Kind::None if self.unmeasured > 0.5 => {
                write!(f, "noise that cannot be measured, since too few vertices have faces all around them")?;
            }
            Kind::None => write!(f, "no noise that could be told from the surface")?,
            _ if self.hit > 0.0 => {
                let percent = (100.0 * self.hit).max(1.0);
                write!(
                    f,
                    "noise that hits {percent:.0} % of the vertices, and {:.3} local edges at the others",
                    self.sigma
                )?;
            }
            Kind::Independent => write!(f, "noise of {:.3} local edges", self.sigma)?,
            Kind::Uneven => write!(f, "noise of about {:.3} local edges, uneven", self.sigma)?,
            Kind::Correlated => write!(f, "noise alike between neighbours, of {:.3} local edges", self.sigma)?,
        }
        if self.noisy > 0.0 && self.noisy < 0.95 {
            write!(f, " on {:.0} % of the surface", 100.0 * self.noisy)?;
        }
        if self.unmeasured > 0.0 && (self.kind != Kind::None || self.unmeasured <= 0.5) {
            // Less than one per cent is still something that nothing is known of.
            write!(f, ", not measured on {:.0} % of the surface", (100.0 * self.unmeasured).max(1.0))?;
        }
        if matches!(self.kind, Kind::Independent | Kind::Uneven) && self.tangential_sigma < self.sigma {
            write!(f, ", at most {:.3} within the surface", self.tangential_sigma)?;
        }
        match self.no_data {
            0 => {}
            1 => write!(f, ", one vertex without data")?,
            n => write!(f, ", {n} vertices without data")?,
        }
        let spikes = match self.outliers {
            1 => "one spike".to_owned(),
            n => format!("{n} spikes"),
        };
        if let [CandidateShare { candidate: Candidate::Stay, .. }] = self.candidates[..] {
            return match self.outliers {
                0 => write!(f, ": left alone"),
                _ => write!(f, ": {spikes} removed, all else left alone"),
            };
        }
        if self.outliers > 0 {
            write!(f, ", {spikes}")?;
        }
        let mut separator = ": ";
        // Smaller shares would be printed as 0 %.
        for CandidateShare { candidate, share, .. } in self.candidates.iter().filter(|share| share.share >= 0.005) {
            write!(f, "{separator}{:.0} % {candidate}", 100.0 * share)?;
            separator = ", ";
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A choice for noise of a fifth of an edge all over.
    fn choice() -> DenoiseChoice {
        DenoiseChoice {
            measured: NoiseLevel::default(),
            kind: Kind::Independent,
            sigma: 0.2,
            tangential_sigma: 0.2,
            noisy: 1.0,
            unmeasured: 0.0,
            hit: 0.0,
            outliers: 0,
            no_data: 0,
            bounded: 0,
            candidates: vec![CandidateShare::all_of(Candidate::Smooth)],
            deviations: Vec::new(),
        }
    }

    #[test]
    fn what_was_not_measured_is_said_once() {
        let said = |kind, unmeasured| {
            let candidates =
                vec![CandidateShare::all_of(if kind == Kind::None { Candidate::Stay } else { Candidate::Smooth })];
            DenoiseChoice { kind, unmeasured, candidates, ..choice() }.to_string()
        };
        assert_eq!(said(Kind::Independent, 0.0), "noise of 0.200 local edges: 100 % smooth");
        assert_eq!(said(Kind::None, 0.0), "no noise that could be told from the surface: left alone");
        // Nothing was found in the half that could be measured, or too little could be.
        for (unmeasured, percent) in [(0.5, 50), (0.25, 25), (0.001, 1)] {
            let rest = format!(", not measured on {percent} % of the surface");
            assert_eq!(
                said(Kind::None, unmeasured),
                format!("no noise that could be told from the surface{rest}: left alone")
            );
            assert!(said(Kind::Independent, unmeasured).contains(&rest));
        }
        let little = said(Kind::None, 0.51);
        assert!(little.starts_with("noise that cannot be measured") && !little.contains("not measured on"), "{little}");
        assert!(said(Kind::Independent, 0.51).contains(", not measured on 51 % of the surface"));
    }

    #[test]
    fn noise_that_is_nearly_everywhere_is_said_to_be_no_part_of_the_surface() {
        let said = |noisy| DenoiseChoice { noisy, ..choice() }.to_string();
        assert_eq!(said(0.4), "noise of 0.200 local edges on 40 % of the surface: 100 % smooth");
        assert!([1.0, 0.95].iter().all(|noisy| !said(*noisy).contains("on ")), "{}", said(0.95));
        let across = DenoiseChoice { tangential_sigma: 0.05, ..choice() }.to_string();
        assert_eq!(across, "noise of 0.200 local edges, at most 0.050 within the surface: 100 % smooth");
        let hit = DenoiseChoice { hit: 0.2, ..choice() }.to_string();
        assert_eq!(hit, "noise that hits 20 % of the vertices, and 0.200 local edges at the others: 100 % smooth");
    }
}
