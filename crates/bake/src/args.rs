//! The command line, as clap reads it; the doc comments are the help. Settings of the methods come from the library.

mod limits;
mod method;
mod values;

pub(crate) use method::{MethodArgs, PresetArg};
pub(crate) use values::{MapArg, OrAuto, SpaceArg};

use crate::method_table;
use clap::{Args, Parser, Subcommand};
use planish_geometry::bake::LayoutChoice;
use planish_geometry::denoise::Denoiser;
use planish_geometry::denoise::NormalField;
use planish_geometry::map::displacement::FileFormat;
use planish_geometry::map::normal_map::Convention;
use planish_geometry::map::{Interpolation, Texels};
use planish_geometry::mesh::synthetic_noise::Direction;
use planish_geometry::mesh::weld::Welding;
use planish_geometry::metrics::Heat;
use std::path::PathBuf;
use values::{
    above_zero, bits, finite, in_unit_interval, largest_side, named, named_or_auto, not_negative, setting, side,
    tolerance, welding,
};

/// Denoise a mesh with a displacement map.
///
/// planish computes how far noise lifted each vertex of a mesh, h = ⟨p − p*, n⟩, and bakes that into a displacement map.
/// A vertex shader takes it off again: p' = p − λ · (bias + scale · texel) · n. The mesh file stays untouched, and λ can
/// be turned at run time from 0 (noisy) to 1 (denoised) and beyond.
#[derive(Debug, Parser)]
#[command(name = "planish", version, arg_required_else_help = true)]
#[command(
    after_help = "Exit codes: 0 done, 1 failed, 2 bad input or usage.\n\nStart with: planish info scan.obj, then planish bake scan.obj -o out"
)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
    #[command(flatten)]
    pub(crate) output: OutputArgs,
}

/// What every command prints.
#[derive(Args, Debug)]
pub(crate) struct OutputArgs {
    /// Print the result as JSON
    #[arg(long, global = true, help_heading = "Output")]
    pub(crate) json: bool,
    /// Print nothing but errors
    #[arg(short, long, global = true, conflicts_with = "json", help_heading = "Output")]
    pub(crate) quiet: bool,
    /// Print the time of each stage as well
    #[arg(short, long, global = true, conflicts_with = "quiet", help_heading = "Output")]
    pub(crate) verbose: bool,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Bake a mesh into a displacement map
    ///
    /// Writes NAME.displacement.png (or .exr, .tif), NAME.normal.png, NAME.planish.json, and a carrier, which is the mesh with the
    /// normals that the map displaces along: NAME.obj with NAME.mtl, and NAME.glb, where λ is a morph target.
    #[command(after_help = "Example:\n  planish bake scan.obj -o out --size 2048")]
    Bake(BakeArgs),
    /// Displace a mesh by its map, as the vertex shader would
    #[command(after_help = "Example:\n  planish apply out/scan.planish.json --lambda 0.5 -o half.obj")]
    Apply(ApplyArgs),
    /// Measure the files of a map once more and compare with what its manifest says
    ///
    /// Denoises the source again with the method in the manifest, decodes the map, displaces the carrier in single
    /// precision, and prints the errors. Ends with exit code 1 where the files do not do what the manifest says.
    #[command(after_help = "Example:\n  planish check out/scan.planish.json")]
    Check(CheckArgs),
    /// Write the denoised mesh itself
    ///
    /// Only the numbers of the `v` lines change; order, UVs, groups, materials, comments and spacing stay byte for byte.
    #[command(after_help = "Example:\n  planish denoise scan.obj -o smooth.obj --update-normals")]
    Denoise(DenoiseArgs),
    /// Measure results against the clean mesh
    ///
    /// Ea is the mean angle between corresponding face normals; distances are in mean edge lengths of the clean mesh.
    #[command(after_help = "Example:\n  planish compare clean.obj noisy.obj smooth.obj")]
    Compare(CompareArgs),
    /// Run methods over a folder of pairs of meshes and measure each result
    ///
    /// DIR has a table MANIFEST.tsv with the columns name, clean and noisy (clean `-`: left out), or files NAME_clean.obj and
    /// NAME_noisy.obj. Columns Ea_* hold the angles that other programs reached: results are also printed in units of the best
    /// of them, and, where the settings are the same, in units of the program of the method.
    /// A mesh that cannot be measured is named, and the rest goes on; the exit code is then 2.
    #[command(
        after_help = "Example:\n  planish bench-quality meshes --methods laplacian,guided-normals --csv quality.csv"
    )]
    BenchQuality(BenchQualityArgs),
    /// Add synthetic noise to a clean mesh
    #[command(after_help = "Example:\n  planish noise clean.obj -o noisy.obj --sigma 0.2 --seed 7")]
    Noise(NoiseArgs),
    /// Say what is in a mesh file and what is wrong with it
    #[command(after_help = "Example:\n  planish info scan.obj --json")]
    Info(InfoArgs),
    /// List the denoising methods and their settings
    #[command(after_help = "Example:\n  planish methods guided-normals")]
    #[command(after_long_help = format!(
        "{}\nExample:\n  planish methods guided-normals", method_table::text(&Denoiser::every())
    ))]
    Methods(MethodsArgs),
    /// Print a completion script for a shell
    #[command(after_help = "Example:\n  planish completions bash > ~/.local/share/bash-completion/completions/planish")]
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
}

/// Which vertices of a file are one.
#[derive(Args, Debug)]
pub(crate) struct WeldArgs {
    /// Which `v` lines are one vertex: exact (equal coordinates), none, or a distance in model units
    ///
    /// Exporters split vertices at UV seams; without welding the mesh would be cut open there.
    #[arg(long, value_name = "exact|none|EPS", default_value = "exact", allow_negative_numbers = true, value_parser = welding)]
    pub(crate) weld: Welding,
}

/// Meaning of `--normals auto`.
const NORMALS: &str = "With methods that have --motion angle, denoised or leaning, whichever loses least; else angle";

#[derive(Args, Debug)]
pub(crate) struct BakeArgs {
    /// The noisy mesh
    #[arg(value_name = "IN.obj")]
    pub(crate) input: PathBuf,
    /// Folder for the results; made if missing [default: ./NAME-planish]
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) method: MethodArgs,
    #[command(flatten, next_help_heading = "Denoising")]
    pub(crate) welding: WeldArgs,
    /// Bake the way to this mesh instead: the result of any other denoiser, same vertices in the same order
    #[arg(long, value_name = "DENOISED.obj", help_heading = "Denoising")]
    #[arg(conflicts_with_all = method::options())]
    pub(crate) target: Option<PathBuf>,
    /// Strength λ for the normal map and the client settings: 0 leaves the noise, 1 is denoised
    #[arg(long, value_name = "L", default_value_t = 1.0, allow_negative_numbers = true, value_parser = finite, help_heading = "Map")]
    pub(crate) lambda: f64,
    /// Normals to displace along; the carrier has them as its `vn` lines
    #[arg(long, value_parser = named_or_auto::<NormalField>(NORMALS), default_value = "auto", help_heading = "Map")]
    pub(crate) normals: OrAuto<NormalField>,
    /// Heights along the normals, or the whole way of each vertex
    ///
    /// Methods that have --motion are held to what heights can express; the report says what that costs.
    #[arg(long, value_enum, default_value_t, help_heading = "Map")]
    pub(crate) map: MapArg,
    /// Axes of --map vector [default: object]
    #[arg(long, value_enum, help_heading = "Map")]
    pub(crate) space: Option<SpaceArg>,
    /// Where a vertex has its texels
    #[arg(long, value_parser = named::<LayoutChoice>(), default_value = LayoutChoice::default().name(), help_heading = "Map")]
    pub(crate) layout: LayoutChoice,
    /// How far off a vertex may be for --layout auto to use the mesh's own UVs, in quanta
    #[arg(long, value_name = "Q", default_value_t = 1.0, allow_negative_numbers = true, value_parser = tolerance, help_heading = "Map")]
    pub(crate) tolerance: f64,
    /// The largest size that --size auto may take
    #[arg(long, value_name = "N", default_value_t = planish_geometry::map::map_size::LARGEST_SIDE, allow_negative_numbers = true, value_parser = largest_side, help_heading = "Map")]
    pub(crate) max_size: u32,
    /// Texels on a side, or auto: the smallest power of two at which each vertex gets its height
    #[arg(long, value_name = "auto|N", default_value = "auto", allow_negative_numbers = true, value_parser = side, help_heading = "Map")]
    pub(crate) size: OrAuto<u32>,
    /// How texels between vertices are filled
    #[arg(long, value_parser = named::<Interpolation>(), default_value = Interpolation::default().name(), help_heading = "Map")]
    pub(crate) interpolation: Interpolation,
    /// What is done to the texels that vertices sample
    #[arg(long, value_parser = named::<Texels>(), default_value = Texels::default().name(), help_heading = "Map")]
    pub(crate) texels: Texels,
    /// Bits of a texel and channel: 8, 16 or 32 [default: 16, with --format exr 32]
    #[arg(long, value_name = "8|16|32", value_parser = bits, help_heading = "Map")]
    pub(crate) bits: Option<u32>,
    /// File format of the displacement map [default: png, with --bits 32 exr]
    #[arg(long, value_parser = named::<FileFormat>(), help_heading = "Map")]
    pub(crate) format: Option<FileFormat>,
    /// Green channel of the normal map: opengl points up (Blender, glTF, three.js, Unity), directx down (Unreal)
    #[arg(long, value_parser = named::<Convention>(), default_value = Convention::default().name(), help_heading = "Map")]
    pub(crate) normal_convention: Convention,
    /// Write no NAME.glb, the carrier as binary glTF with the denoised surface as a morph target
    #[arg(long, help_heading = "Map")]
    pub(crate) no_glb: bool,
}

#[derive(Args, Debug)]
pub(crate) struct ApplyArgs {
    /// The manifest that `bake` wrote
    #[arg(value_name = "MAP.planish.json")]
    pub(crate) manifest: PathBuf,
    /// The mesh that was baked, or its carrier [default: the carrier beside the manifest]
    #[arg(long, value_name = "IN.obj")]
    pub(crate) mesh: Option<PathBuf>,
    /// Strength λ: 0 leaves the noise, 1 is denoised [default: that of the manifest]
    #[arg(long, value_name = "L", allow_negative_numbers = true, value_parser = finite)]
    pub(crate) lambda: Option<f64>,
    /// The displaced mesh
    #[arg(short, long, value_name = "OUT.obj")]
    pub(crate) output: PathBuf,
}

#[derive(Args, Debug)]
pub(crate) struct CheckArgs {
    /// The manifest that `bake` wrote
    #[arg(value_name = "MAP.planish.json")]
    pub(crate) manifest: PathBuf,
    /// The mesh that was baked [default: where the manifest says]
    #[arg(long, value_name = "IN.obj")]
    pub(crate) mesh: Option<PathBuf>,
}

#[derive(Args, Debug)]
pub(crate) struct DenoiseArgs {
    /// The noisy mesh
    #[arg(value_name = "IN.obj")]
    pub(crate) input: PathBuf,
    /// The denoised mesh
    #[arg(short, long, value_name = "OUT.obj")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) method: MethodArgs,
    #[command(flatten, next_help_heading = "Denoising")]
    pub(crate) welding: WeldArgs,
    /// Give the `vn` lines new numbers too, so that the shading follows; hard edges stay hard
    #[arg(long)]
    pub(crate) update_normals: bool,
}

#[derive(Args, Debug)]
pub(crate) struct CompareArgs {
    /// The clean mesh
    #[arg(value_name = "CLEAN.obj")]
    pub(crate) clean: PathBuf,
    /// Meshes with the same vertices and faces
    #[arg(value_name = "RESULT.obj", required = true)]
    pub(crate) results: Vec<PathBuf>,
    /// Write one row for each result, with all that is measured; `-` for stdout
    #[arg(long, value_name = "FILE|-")]
    pub(crate) csv: Option<PathBuf>,
    /// Write the result with the error of each vertex as its colour, from violet (none) to yellow (the 99th percentile)
    ///
    /// With more than one result, OUT-NAME.ply for each NAME.obj, all with the same scale.
    #[arg(long, value_name = "OUT.ply|.obj")]
    pub(crate) heatmap: Option<PathBuf>,
    /// What the colours show
    #[arg(long, value_parser = named::<Heat>(), default_value = Heat::default().name(), requires = "heatmap")]
    pub(crate) heat: Heat,
    /// The error that is yellow: degrees with --heat angle, mean edge lengths with --heat distance
    #[arg(long, value_name = "X", requires = "heatmap", allow_negative_numbers = true, value_parser = above_zero)]
    pub(crate) heat_max: Option<f64>,
}

#[derive(Args, Debug)]
pub(crate) struct BenchQualityArgs {
    /// The folder of pairs
    #[arg(value_name = "DIR")]
    pub(crate) folder: PathBuf,
    /// Methods, separated by commas [default: all]
    #[arg(long, value_name = "A,B", value_parser = method::denoiser(), value_delimiter = ',')]
    pub(crate) methods: Vec<Denoiser>,
    /// Names of pairs, separated by commas [default: all]
    #[arg(long, value_name = "X,Y", value_delimiter = ',')]
    pub(crate) pairs: Vec<String>,
    /// Settings: paper for those of the methods' authors, where they differ
    #[arg(long, value_enum, default_value_t)]
    pub(crate) preset: PresetArg,
    /// A setting as it stands in manifests, for the methods that have it
    #[arg(long, value_name = "NAME=VALUE", value_delimiter = ',', value_parser = setting)]
    pub(crate) set: Vec<(String, serde_json::Value)>,
    /// Denoise the clean meshes too, and report by how many degrees that rotates their faces
    #[arg(long)]
    pub(crate) harm: bool,
    /// Write one row for each pair and method, with all that is measured; `-` for stdout
    #[arg(long, value_name = "FILE|-")]
    pub(crate) csv: Option<PathBuf>,
}

#[derive(Args, Debug)]
pub(crate) struct NoiseArgs {
    /// The clean mesh
    #[arg(value_name = "CLEAN.obj")]
    pub(crate) input: PathBuf,
    /// The noisy mesh
    #[arg(short, long, value_name = "NOISY.obj")]
    pub(crate) output: PathBuf,
    /// Standard deviation of the Gaussian noise, in mean edge lengths
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = not_negative)]
    pub(crate) sigma: f64,
    /// Where vertices go
    #[arg(long, value_parser = named::<Direction>(), default_value = Direction::default().name())]
    pub(crate) direction: Direction,
    /// Hit only this share of the vertices, 0 to 1
    #[arg(long, value_name = "P", allow_negative_numbers = true, value_parser = in_unit_interval)]
    pub(crate) impulsive: Option<f64>,
    /// The same seed gives the same noise
    #[arg(long, value_name = "N", default_value_t = 1, allow_negative_numbers = true)]
    pub(crate) seed: u64,
    #[command(flatten)]
    pub(crate) welding: WeldArgs,
}

#[derive(Args, Debug)]
pub(crate) struct InfoArgs {
    /// The mesh
    #[arg(value_name = "IN.obj")]
    pub(crate) input: PathBuf,
    #[command(flatten)]
    pub(crate) welding: WeldArgs,
}

#[derive(Args, Debug)]
pub(crate) struct MethodsArgs {
    /// The method to list [default: all]
    #[arg(value_name = "METHOD", value_parser = method::denoiser())]
    pub(crate) method: Option<Denoiser>,
    /// Print the page of the documentation
    #[arg(long, conflicts_with_all = ["json", "method"])]
    pub(crate) markdown: bool,
}
