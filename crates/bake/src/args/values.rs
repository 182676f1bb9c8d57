//! Values of options: the choices and the numbers that are allowed.

use clap::ValueEnum;
use planish_geometry::bundle::LayoutChoice;
use planish_geometry::denoise::NormalField;
use planish_geometry::denoise::auto::Candidate;
use planish_geometry::denoise::{
    Boundary, EdgeWeights, FoldOvers, Kind, Motion, Neighbours, Prior, Scheme, Solver, VertexScheme,
};
use planish_geometry::displacement::FileFormat;
use planish_geometry::manifest::LARGEST_SIDE;
use planish_geometry::metrics::Heat;
use planish_geometry::model::NormalSource;
use planish_geometry::texture::normal_map::Convention;
use planish_geometry::texture::{Interpolation, Texels};
use planish_geometry::weld::Welding;

/// An enum that clap lists as choices, and what each stands for in the library.
macro_rules! choice {
    ($(#[$meta:meta])* $name:ident => $target:ty { $($(#[$help:meta])* $variant:ident => $value:expr),+ $(,)? }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
        pub(crate) enum $name { $($(#[$help])* $variant),+ }

        impl From<$name> for $target {
            fn from(choice: $name) -> Self {
                match choice { $($name::$variant => $value),+ }
            }
        }
    };
}

choice!(WeightsArg => EdgeWeights {
    /// All the same
    #[default]
    Uniform => EdgeWeights::Uniform,
    /// Cotangents of the angles opposite
    Cotangent => EdgeWeights::Cotangent,
});

choice!(BoundaryArg => Boundary {
    /// The rim stays
    #[default]
    Fixed => Boundary::Fixed,
    /// The rim moves like the rest, and shrinks
    Free => Boundary::Free,
});

choice!(HeatArg => Heat {
    /// Angle to the clean normals, in degrees, mean over the faces around a vertex
    #[default]
    Angle => Heat::Angle,
    /// Distance to the clean surface, in mean edge lengths
    Distance => Heat::Distance,
});

choice!(SolverArg => Solver {
    /// Conjugate gradients: for meshes of every size
    #[default]
    Iterative => Solver::Iterative,
    /// Sparse Cholesky factors: to the last digit, up to some 100 000 vertices
    Direct => Solver::Direct,
});

choice!(SchemeArg => Scheme {
    /// Step by step
    #[default]
    Local => Scheme::Local,
    /// One linear system
    Global => Scheme::Global,
});

choice!(NeighboursArg => Neighbours {
    /// Those that share a vertex
    #[default]
    Vertex => Neighbours::Vertex,
    /// Those that share an edge
    Edge => Neighbours::Edge,
});

choice!(VertexUpdateArg => VertexScheme {
    /// Steps downhill, as in the papers
    #[default]
    Descent => VertexScheme::Descent,
    /// The best fit itself, by conjugate gradients
    LeastSquares => VertexScheme::LeastSquares,
});

choice!(MotionArg => Motion {
    /// Anywhere
    #[default]
    Free => Motion::Free,
    /// Along one normal for each vertex: all of it fits into a map of heights
    AlongNormal => Motion::AlongNormal,
});

choice!(FoldOversArg => FoldOvers {
    /// They are not taken
    #[default]
    Prevent => FoldOvers::Prevent,
    /// They are taken
    Allow => FoldOvers::Allow,
});

choice!(PriorArg => Prior {
    /// Flat parts with sharp creases
    Flat => Prior::FLAT,
    /// Curved parts with sharp creases
    Sharp => Prior::SHARP,
    /// Parts with creases that need not be sharp
    #[default]
    Creases => Prior::CREASES,
    /// Shapes with some creases
    Mixed => Prior::MIXED,
    /// Smooth shapes with detail
    Detail => Prior::DETAIL,
    /// Smooth shapes
    Smooth => Prior::SMOOTH,
});

choice!(KindArg => Kind {
    /// None: the mesh stays as it is
    None => Kind::None,
    /// Each vertex is off by its own amount
    #[default]
    Independent => Kind::Independent,
    /// The same, much more at some vertices than at others
    Uneven => Kind::Uneven,
    /// Neighbours are off to the same side, as depth cameras err
    Correlated => Kind::Correlated,
});

/// A name of a candidate of `auto`.
pub(super) fn candidate(text: &str) -> Result<Candidate, String> {
    let names = || Candidate::ALL.map(Candidate::name).join(", ");
    Candidate::ALL.into_iter().find(|c| c.name() == text).ok_or_else(|| format!("a candidate is one of {}", names()))
}

choice!(NormalsArg => Option<NormalField> {
    /// With methods that have --motion angle, denoised or leaning, whichever loses least; else angle
    #[default]
    Auto => None,
    /// Those of the file, averaged at each vertex
    File => Some(NormalField::Source(NormalSource::File)),
    /// Mean of the faces' normals
    Uniform => Some(NormalField::Source(NormalSource::Uniform)),
    /// Weighted by area
    Area => Some(NormalField::Source(NormalSource::Area)),
    /// Weighted by angle, as Blender's
    Angle => Some(NormalField::Source(NormalSource::Angle)),
    /// The same on the denoised surface
    Denoised => Some(NormalField::Denoised),
    /// Those, leaning to where vertices go at those whose faces would stay turned; for heights
    Leaning => Some(NormalField::Tilted),
});

choice!(InterpolationArg => Interpolation {
    /// Linear on the triangles of the mesh
    #[default]
    Barycentric => Interpolation::Barycentric,
    /// Natural neighbours of the samples
    Natural => Interpolation::Natural,
    /// Inverse distance to the eight nearest samples
    Idw => Interpolation::Idw,
    /// The nearest sample
    Nearest => Interpolation::Nearest,
});

choice!(TexelsArg => Texels {
    /// Moved until sampling gives each vertex its very height
    #[default]
    Fitted => Texels::Fitted,
    /// Left as interpolated
    Interpolated => Texels::Interpolated,
});

choice!(ConventionArg => Convention {
    /// Green up
    #[default]
    Opengl => Convention::OpenGl,
    /// Green down
    Directx => Convention::DirectX,
});

choice!(DirectionArg => planish_geometry::noise::Direction {
    /// Along the vertex normal
    #[default]
    Normal => planish_geometry::noise::Direction::Normal,
    /// In a random direction
    Random => planish_geometry::noise::Direction::Random,
});

choice!(FormatArg => FileFormat {
    /// 8 or 16 bits
    #[default]
    Png => FileFormat::Png,
    /// Floating point: 16 (half) or 32 bits
    Exr => FileFormat::Exr,
    /// 16 bits, or 32 of floating point
    Tiff => FileFormat::Tiff,
});

choice!(LayoutArg => LayoutChoice {
    /// The mesh's own UVs where these can hold all heights, else one texel for each vertex
    #[default]
    Auto => LayoutChoice::Auto,
    /// The mesh's own UVs
    Uv => LayoutChoice::Uv,
    /// One texel for each vertex: always exact, needs no UVs
    Vertex => LayoutChoice::Vertex,
    /// A new atlas, made by xatlas, instead of the UVs; only in a planish built with --features unwrap
    Unwrap => LayoutChoice::Unwrap,
});

/// What a map holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum MapArg {
    /// Heights along the normals, one channel
    #[default]
    Scalar,
    /// The whole way, three channels
    Vector,
}

/// Axes of a vector map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum SpaceArg {
    /// Those of the model
    #[default]
    Object,
    /// Tangent, bitangent and normal of each vertex; follows a mesh that is bent
    Tangent,
}

/// `--size`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SideArg(pub(crate) Option<u32>);

pub(super) fn side(text: &str) -> Result<SideArg, String> {
    if text == "auto" {
        return Ok(SideArg(None));
    }
    match text.parse() {
        Ok(side) if (1..=LARGEST_SIDE).contains(&side) => Ok(SideArg(Some(side))),
        _ => Err(format!("a size is `auto` or a number from 1 to {LARGEST_SIDE}")),
    }
}

pub(super) fn largest_side(text: &str) -> Result<u32, String> {
    let allowed = text.parse().ok().filter(|side| (1..=LARGEST_SIDE).contains(side));
    allowed.ok_or_else(|| format!("a size is a number from 1 to {LARGEST_SIDE}"))
}

pub(super) fn bits(text: &str) -> Result<u32, String> {
    let allowed = text.parse().ok().filter(|bits| [8, 16, 32].contains(bits));
    allowed.ok_or_else(|| "a texel has 8, 16 or 32 bits".to_owned())
}

pub(super) fn tolerance(text: &str) -> Result<f64, String> {
    number(text, |x| (0.625..=1e6).contains(&x), "not a number from 0.625 on; encoding alone costs half a quantum")
}

/// NAME=VALUE, where VALUE is JSON or a bare word.
pub(super) fn setting(text: &str) -> Result<(String, serde_json::Value), String> {
    let (name, value) = text.split_once('=').ok_or("a setting is NAME=VALUE")?;
    Ok((name.to_owned(), serde_json::from_str(value).unwrap_or_else(|_| value.into())))
}

pub(super) fn welding(text: &str) -> Result<Welding, String> {
    match text {
        "exact" => Ok(Welding::Exact),
        "none" => Ok(Welding::None),
        _ => match text.parse() {
            Ok(epsilon) if f64::is_finite(epsilon) && epsilon > 0.0 => Ok(Welding::Epsilon(epsilon)),
            _ => Err("welding is `exact`, `none` or a distance greater than 0".to_owned()),
        },
    }
}

fn number(text: &str, fine: impl Fn(f64) -> bool, rule: &str) -> Result<f64, String> {
    let parsed: Result<f64, _> = text.parse();
    parsed.ok().filter(|x| x.is_finite() && fine(*x)).ok_or_else(|| rule.to_owned())
}

pub(super) fn finite(text: &str) -> Result<f64, String> {
    number(text, |x| x.abs() <= 1e6, "not a number between −1000000 and 1000000")
}

pub(super) fn not_negative(text: &str) -> Result<f64, String> {
    number(text, |x| (0.0..=1e6).contains(&x), "not a number between 0 and 1000000")
}

pub(super) fn inflation(text: &str) -> Result<f64, String> {
    number(text, |x| (-1.5..=0.0).contains(&x), "not a number between −1.5 and 0")
}

pub(super) fn above_zero(text: &str) -> Result<f64, String> {
    number(text, |x| (1e-6..=1e6).contains(&x), "not a number between 0.000001 and 1000000")
}

pub(super) fn share_above_zero(text: &str) -> Result<f64, String> {
    number(text, |x| (1e-6..=1.0).contains(&x), "not a number between 0.000001 and 1")
}

pub(super) fn in_unit_interval(text: &str) -> Result<f64, String> {
    number(text, |x| (0.0..=1.0).contains(&x), "not a number between 0 and 1")
}
