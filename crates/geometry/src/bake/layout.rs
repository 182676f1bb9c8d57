//! Choice of the layout of a map: texture coordinates of the mesh, or one texel for each vertex.

use super::{BakeError, BakeSettings};
use crate::map::displacement;
use crate::map::layout_issues::{self, LayoutIssues};
use crate::map::map_size::{self, MapSizeChoice, MapSizeReason, Spacing};
use crate::map::{Coverage, Exactness, Size, Texels};
use crate::mesh::atlas::Atlas;
use crate::mesh::surface::Surface;
use crate::named;
use crate::progress::Progress;

named! {
    /// Layout of the texels that vertices sample.
    #[derive(Default)]
    pub enum LayoutChoice {
        /// The mesh's own UVs where these can hold all heights, else one texel for each vertex.
        #[default]
        Auto = "auto",
        /// The mesh's own UVs.
        Uv = "uv",
        /// One texel for each vertex: always exact, needs no UVs.
        Vertex = "vertex",
        /// New UVs, made by xatlas; only in a planish built with --features unwrap.
        Unwrap = "unwrap",
    }
}

/// Reasons why the texture coordinates of a mesh were not used.
#[derive(Clone, Debug, PartialEq)]
pub enum Fallback {
    /// The mesh has no texture coordinates.
    NoUvs,
    /// Some vertices have no texture coordinates.
    Unmapped {
        /// Number of vertices without texture coordinates.
        vertices: usize,
    },
    /// The charts overlap many times.
    Overlap {
        /// Sum of the areas of the faces in the texture, in areas of the whole texture.
        layers: usize,
    },
    /// The texture coordinates leave too little space for the heights of all vertices.
    Layout {
        /// Largest size that was tried, and how many vertices it left unresolved.
        choice: MapSizeChoice,
        /// Problems of the layout as sentences, the worst one first.
        problems: Vec<String>,
    },
}

impl std::fmt::Display for Fallback {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NoUvs => write!(f, "the mesh has no texture coordinates"),
            Self::Unmapped { vertices } => {
                write!(f, "{vertices} vertices have no texture coordinates; unwrapping all faces would help")
            }
            Self::Overlap { layers } => {
                write!(
                    f,
                    "charts overlap: the faces together have {layers} times the area of the texture; an unwrap without overlaps would help"
                )
            }
            Self::Layout { choice, problems } => {
                write!(f, "in the texture coordinates of the mesh ")?;
                match choice.reason {
                    MapSizeReason::Crowded => {
                        let percentage = 100.0 * choice.left as f64 / choice.vertices.max(1) as f64;
                        write!(f, "{percentage:.1} % of the vertices share texels even at {}", choice.side)?;
                    }
                    _ => write!(
                        f,
                        "{} of {} vertices miss their height at {}",
                        choice.left, choice.vertices, choice.side
                    )?,
                }
                if let Some(worst) = problems.first() {
                    write!(f, " ({worst})")?;
                }
                write!(f, "; an unwrap without overlaps and with more space would help")
            }
        }
    }
}

/// Layout that a map will have.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Plan {
    Uv { side: u32, choice: Option<MapSizeChoice> },
    Vertex { fallback: Option<Fallback> },
}

impl Plan {
    pub(super) fn is_uv(&self) -> bool {
        matches!(self, Self::Uv { .. })
    }
    pub(super) fn into_reasons(self) -> (Option<MapSizeChoice>, Option<Fallback>) {
        match self {
            Self::Uv { choice, .. } => (choice, None),
            Self::Vertex { fallback } => (None, fallback),
        }
    }

    /// Decides on the layout for the channels of a map (#V each, model units). `layout` is `None` if the mesh has no texture
    /// coordinates.
    pub(super) fn make(
        surface: &Surface,
        layout: Option<(&Atlas, &Spacing)>,
        channels: &[Vec<f64>],
        settings: &BakeSettings,
        progress: &dyn Progress,
    ) -> Result<Self, BakeError> {
        let (atlas, spacing) = match (settings.layout, layout) {
            (LayoutChoice::Vertex, _) => return Ok(Self::Vertex { fallback: None }),
            (_, None) => return Ok(Self::Vertex { fallback: Some(Fallback::NoUvs) }),
            (_, Some(layout)) => layout,
        };
        // Interpolated texels are never exact, so whoever asks for them accepts the errors of the texture's layout.
        let must_be_exact = settings.layout == LayoutChoice::Auto && settings.texels == Texels::Fitted;
        let unmapped = layout_issues::unmapped(surface, atlas);
        if must_be_exact && unmapped > 0 {
            return Ok(Self::Vertex { fallback: Some(Fallback::Unmapped { vertices: unmapped }) });
        }
        let layers = Coverage::layers(surface, atlas);
        if must_be_exact && layers > MOST_LAYERS {
            return Ok(Self::Vertex { fallback: Some(Fallback::Overlap { layers: layers as usize }) });
        }
        let quantum = displacement::quantum(settings.texel);
        let exactness = Exactness { quantum, tolerance: settings.tolerance.0 };
        let sides = map_size::sides(settings.largest_side.0);
        let choice = match (settings.side, settings.texels) {
            (Some(side), _) if !must_be_exact => return Ok(Self::Uv { side, choice: None }),
            // Measuring the written map later is as quick as a prediction, and more accurate.
            (Some(side), _) if !spacing.is_hopeless(side) => return Ok(Self::Uv { side, choice: None }),
            (Some(side), _) => spacing.choose(&[side]),
            (None, Texels::Fitted) => spacing.choose_exact(atlas, channels, &sides, exactness, progress)?,
            (None, Texels::Interpolated) => spacing.choose(&sides),
        };
        if must_be_exact && choice.reason != MapSizeReason::Exact {
            let size = Size::square(choice.side.min(OVERLAP_CHECK_SIDE));
            let coverage = Coverage::new(surface, atlas, size, progress)?;
            let findings = LayoutIssues::of(surface, atlas, spacing, &coverage);
            let problems = findings.problems().into_iter().chain(findings.crowding()).collect();
            return Ok(Self::Vertex { fallback: Some(Fallback::Layout { choice, problems }) });
        }
        Ok(Self::Uv { side: choice.side, choice: Some(choice).filter(|_| settings.side.is_none()) })
    }
}

/// Number of layers of charts above which no fit is tried: vertices then share their texels with many others, and rasterising
/// would take as many times as long.
const MOST_LAYERS: f64 = 16.0;

/// Largest side, texels, at which overlaps are counted for a layout that is not used.
const OVERLAP_CHECK_SIDE: u32 = 1024;
