//! How far a method looks: the halo of rings with which its results in a tile are those of the whole mesh.
//!
//! ```
//! use planish_files::tiles::reach;
//! use planish_geometry::denoise::{Denoiser, Laplacian};
//!
//! // Each step looks one ring farther. Two more rings say where data is missing, and two are there to compare tiles by.
//! let smoothing = Denoiser::Laplacian(Laplacian { iterations: 10, ..Laplacian::default() });
//! assert_eq!(reach::rings(&smoothing), Some(12));
//! let halo = reach::halo(&smoothing.into(), None);
//! assert_eq!((halo.rings, halo.is_bounded), (14, true));
//!
//! // Equations for all vertices look everywhere.
//! let map = Denoiser::named("map").unwrap();
//! assert_eq!(reach::rings(&map), None);
//! assert!(!reach::halo(&map.into(), None).is_bounded);
//! ```

use planish_geometry::denoise::{Denoiser, Denoising, FoldOvers, Motion, Scheme, VertexScheme, VertexUpdate};

/// Rings that marks of missing data take: whether a vertex is one depends on two rings around it.
const MARKS: u64 = 2;
/// Rings around a tile in which its results are compared with those of other tiles.
const CHECKED: u16 = 2;
/// Rings of the halo of methods that solve for all vertices at once, or measure the noise. Far away data has little weight.
const SOLVERS: u16 = 48;
/// Rings of the band in which the results of such methods go over into each other.
const BAND: u16 = 24;

/// Width of a halo, and of the band within it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Halo {
    /// Rings around a tile with which it is denoised.
    pub rings: u16,
    /// Rings next to the tile whose results are kept beside those of the tiles that they belong to: to be blended with these or, where
    /// the method is bounded, to be compared with these.
    pub band: u16,
    /// Whether the method looks no farther than the halo goes, so that its results are those of the whole mesh.
    pub is_bounded: bool,
}

/// Halo of one round of a method that measures the whole mesh before each of its rounds, and the number of these; `None` for other
/// methods, and for settings with which a round looks farther than is known.
pub fn rounds(method: &Denoising, width: Option<u16>) -> Option<(Halo, u32)> {
    let Denoiser::GuidedNormals(s) = &method.denoiser else { return None };
    // A step of the normals averages over a radius, and looks for the best of the patches around each of those triangles. Where triangles
    // are so narrow that more of them lie within the radius, that is what the band finds out.
    let of_normals = s.radius.ceil() as u64 + 2 + 2 + 1;
    let rings = u16::try_from(of_normals + update(&s.vertex_update)? + MARKS).ok()?.checked_add(CHECKED)?;
    let is_free = method.limits.is_none() && s.iterations > 0;
    is_free.then(|| (Halo { rings: rings.max(width.unwrap_or(0)), band: CHECKED, is_bounded: true }, s.iterations))
}

/// Number of rings that a method looks around a vertex, for the input that the result there depends on; `None` if that is the whole
/// mesh, or depends on it.
pub fn rings(method: &Denoiser) -> Option<u64> {
    let rings = match method {
        Denoiser::Laplacian(s) => u64::from(s.iterations),
        Denoiser::Taubin(s) => 2 * u64::from(s.iterations),
        // A mean, and a mean of the corrections.
        Denoiser::Hc(s) => 2 * u64::from(s.iterations),
        Denoiser::Sun(s) => u64::from(s.iterations) + 1 + update(&s.vertex_update)?,
        Denoiser::BilateralNormals(s) if s.scheme == Scheme::Local => {
            u64::from(s.iterations) + 1 + update(&s.vertex_update)?
        }
        _ => return None,
    };
    Some(rings + MARKS)
}

/// Rings that the vertices look while they follow the normals.
fn update(settings: &VertexUpdate) -> Option<u64> {
    if settings.scheme != VertexScheme::Descent || settings.motion == Motion::AlongNormal {
        return None;
    }
    // A step back of one vertex may cause that of a neighbour, and so on; that more than one follows in one step is what the band finds
    // out.
    let of_step = if settings.fold_overs == FoldOvers::Prevent { 2 } else { 1 };
    Some(of_step * u64::from(settings.iterations))
}

/// Halo for a method. `width` is that of a caller, in rings; the halo of a bounded method is no narrower than it looks.
pub fn halo(method: &Denoising, width: Option<u16>) -> Halo {
    // Motion along a direction looks at the normals of the result.
    let turned = u64::from(method.limits.direction.is_some());
    match rings(&method.denoiser)
        .map(|rings| rings + turned)
        .and_then(|rings| u16::try_from(rings).ok()?.checked_add(CHECKED))
    {
        Some(rings) => Halo { rings: rings.max(width.unwrap_or(0)), band: CHECKED, is_bounded: true },
        None => {
            let rings = width.unwrap_or(SOLVERS).max(2);
            Halo { rings, band: BAND.min(rings / 2), is_bounded: false }
        }
    }
}

/// Whether a method takes the mean distance of neighbouring faces from the whole mesh, once.
pub(super) fn needs_centroid_distance(method: &Denoiser) -> bool {
    matches!(method, Denoiser::BilateralNormals(s) if s.scheme == Scheme::Local) && rings(method).is_some()
}
