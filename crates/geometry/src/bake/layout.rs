//! Choice of the layout of a map: texture coordinates of the mesh, or one texel for each vertex.

use super::layout_choice::LayoutChoice;
use super::{BakeError, BakeSettings};
use crate::map::displacement;
use crate::map::layout_issues::{self, LayoutIssues};
use crate::map::map_size::{self, MapSizeChoice, MapSizeReason, Spacing};
use crate::map::{Coverage, Exactness, Size, Texels};
use crate::mesh::atlas::Atlas;
use crate::mesh::surface::Surface;
use crate::progress::Progress;

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
    /// A page has no face of the surface: all its faces are backs that share the vertices of their fronts, or have no area.
    NoLayout,
    /// The charts overlap many times.
    Overlap {
        /// Sum of the areas of the faces in the texture, in areas of the whole texture.
        layers: usize,
    },
    /// A page has too little space.
    Page {
        /// Name of the page.
        page: String,
        /// Reason why the page cannot be used.
        reason: Box<Fallback>,
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
            Self::NoLayout => {
                write!(f, "all its faces are backs that share vertices with their fronts, or have no area")
            }
            Self::Overlap { layers } => {
                write!(
                    f,
                    "charts overlap: the faces together have {layers} times the area of the texture; an unwrap without overlaps would help"
                )
            }
            Self::Page { page, reason } => write!(f, "page {page}: {reason}"),
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
    Uv {
        /// Sides of the map, ascending; the first one with room is used.
        sides: Vec<u32>,
        choice: Option<MapSizeChoice>,
        places: Places,
    },
    Vertex {
        fallback: Option<Fallback>,
    },
}

/// Places at which vertices may sample a map in the texture coordinates of the mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Places {
    /// All vertices sample at their own texture coordinates, whatever the error.
    Own,
    /// Vertices that would miss their value there get private texels.
    OwnOrPrivate,
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
        let places = if must_be_exact { Places::OwnOrPrivate } else { Places::Own };
        let layers = Coverage::layers(surface, atlas);
        if must_be_exact && layers > MOST_LAYERS {
            return Ok(Self::Vertex { fallback: Some(Fallback::Overlap { layers: layers as usize }) });
        }
        if let Some(side) = settings.side {
            return Ok(Self::Uv { sides: vec![side], choice: None, places });
        }
        let mut sides = map_size::sides(settings.largest_side.0);
        let exactness = exactness(settings);
        let choice = match settings.texels {
            Texels::Fitted => spacing.choose_exact(atlas, channels, &sides, exactness, progress)?,
            Texels::Interpolated => spacing.choose(&sides),
        };
        let sides = match places {
            Places::Own => vec![choice.side],
            Places::OwnOrPrivate if choice.reason == MapSizeReason::Exact => {
                sides.split_off(sides.partition_point(|side| *side < choice.side))
            }
            Places::OwnOrPrivate => spacing.settled(&sides).to_vec(),
        };
        Ok(Self::Uv { sides, choice: Some(choice), places })
    }

    /// The plan for a map with private texels whose layout has no room for them at any of its sides.
    pub(super) fn without_room(
        self,
        surface: &Surface,
        (atlas, spacing): (&Atlas, &Spacing),
        progress: &dyn Progress,
    ) -> Result<Self, BakeError> {
        let Self::Uv { sides, choice, .. } = self else { return Ok(self) };
        let unmapped = layout_issues::unmapped(surface, atlas);
        if unmapped > 0 {
            return Ok(Self::Vertex { fallback: Some(Fallback::Unmapped { vertices: unmapped }) });
        }
        let choice = choice.unwrap_or_else(|| spacing.choose(&sides));
        let size = Size::square(choice.side.min(OVERLAP_CHECK_SIDE));
        let coverage = Coverage::new(surface, atlas, size, progress)?;
        let findings = LayoutIssues::of(surface, atlas, spacing, &coverage);
        let problems = findings.problems().into_iter().chain(findings.crowding()).collect();
        Ok(Self::Vertex { fallback: Some(Fallback::Layout { choice, problems }) })
    }
}

/// Accuracy that the texels of a bake must have.
pub(super) fn exactness(settings: &BakeSettings) -> Exactness {
    Exactness { quantum: displacement::quantum(settings.texel), tolerance: settings.tolerance.0 }
}

/// Number of layers of charts above which texture coordinates are not used: nearly all vertices would need private texels, and
/// rasterising would take as many times as long.
pub(super) const MOST_LAYERS: f64 = 16.0;

/// Largest side, texels, at which overlaps are counted for a layout that is not used.
const OVERLAP_CHECK_SIDE: u32 = 1024;
