//! The command line, as clap reads it. Doc comments here are the texts of `--help`; the settings of methods come from the
//! library.

mod limits;
mod method;
mod noise;
mod values;

pub(crate) use method::{MethodArgs, PresetArg};
pub(crate) use noise::{NoiseArgs, NoiseRequest};
pub(crate) use values::{MapArg, OrAuto, Shard, SpaceArg};

use crate::method_table;
use clap::builder::ValueParser;
use clap::{Args, Parser, Subcommand};
use planish_files::input::Trust;
use planish_geometry::bake::LayoutChoice;
use planish_geometry::denoise::Denoiser;
use planish_geometry::denoise::NormalField;
use planish_geometry::map::displacement::FileFormat;
use planish_geometry::map::normal_map::Convention;
use planish_geometry::map::occlusion::Occlusion;
use planish_geometry::map::pages::PageRule;
use planish_geometry::map::{Interpolation, Texels};
use planish_geometry::mesh::weld::Welding;
use planish_geometry::metrics::Heat;
use std::path::PathBuf;
use values::{
    above_zero, bits, finite, largest_side, length, named, named_or_auto, rays, setting, side, tolerance, welding,
};

/// Denoise a mesh with a displacement map.
///
/// planish computes how far noise lifted each vertex of a mesh, h = ⟨p − p*, n⟩, and bakes that into a displacement map.
/// A vertex shader subtracts it again: p' = p − λ · (bias + scale · texel) · n. The mesh file stays untouched, and λ can
/// be changed at run time from 0 (noisy) to 1 (denoised) and beyond.
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

/// Options for what a command prints.
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
    /// Measure the files of a map again and compare with its manifest
    ///
    /// Denoises the source again with the method in the manifest, decodes the map, displaces the carrier in single
    /// precision, and prints the errors. The exit code is 1 if the files are worse than the manifest says.
    #[command(after_help = "Example:\n  planish check out/scan.planish.json")]
    Check(CheckArgs),
    /// Write the denoised mesh itself
    ///
    /// Only the numbers of the `v` lines change; order, UVs, groups, materials, comments and spacing stay the same byte for byte.
    #[command(after_help = "Example:\n  planish denoise scan.obj -o smooth.obj --update-normals")]
    Denoise(DenoiseArgs),
    /// Denoise or bake many meshes, each whole or not at all
    ///
    /// Prints one line of JSON for each mesh, and keeps these lines in a journal in the folder of the results. A mesh that fails is
    /// named and the others are done; the exit code is then 1. Memory is bounded by the meshes that are being worked on.
    #[command(after_help = "Example:\n  planish batch scans -o clean --jobs 4 --resume")]
    Batch(BatchArgs),
    /// Measure results against the clean mesh
    ///
    /// Ea is the mean angle between corresponding face normals; distances are in mean edge lengths of the clean mesh.
    #[command(after_help = "Example:\n  planish compare clean.obj noisy.obj smooth.obj")]
    Compare(CompareArgs),
    /// Run methods on a folder of clean and noisy meshes and measure each result
    ///
    /// DIR has a table MANIFEST.tsv with the columns name, clean and noisy (rows with `-` for clean are skipped), or files NAME_clean.obj and
    /// NAME_noisy.obj. Columns Ea_* have the angles that other programs reached: results are also printed as ratios to the best
    /// of them and, where the settings are the same, to the program of the method's authors.
    ///
    /// With --noise, DIR has clean meshes, which are any files *.obj. Each gets noise of the kinds that are named, and the first
    /// method is measured against the best of the others, by kind and by group of shapes. The groups are in the column group of
    /// a table MANIFEST.tsv, whose column name or file names the mesh; a mesh may be in several, with commas between them.
    ///
    /// If a mesh cannot be measured, it is named and the others are measured; the exit code is then 2.
    #[command(
        after_help = "Example:\n  planish bench-quality meshes --methods laplacian,guided-normals --csv quality.csv"
    )]
    BenchQuality(BenchQualityArgs),
    /// Add synthetic noise to a clean mesh
    ///
    /// docs/noise.md has the formula of each kind and says which settings it has.
    #[command(after_help = "Example:\n  planish noise clean.obj -o noisy.obj --kind correlated --sigma 0.2 --seed 7")]
    Noise(NoiseArgs),
    /// Show what is in a mesh file and what is wrong with it
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
        /// Shell to write the script for
        shell: clap_complete::Shell,
    },
}

/// Option for welding.
#[derive(Args, Debug)]
pub(crate) struct WeldArgs {
    /// Which `v` lines count as one vertex: exact (equal coordinates), none, or a distance in model units
    ///
    /// Exporters split vertices at UV seams; without welding the mesh would be cut open there.
    #[arg(long, value_name = "exact|none|EPS", default_value = "exact", allow_negative_numbers = true, value_parser = welding)]
    pub(crate) weld: Welding,
}

/// Option for the files that another file names.
#[derive(Args, Debug)]
pub(crate) struct TrustArgs {
    /// Read files that the mesh or the manifest names wherever they are, not only in its own folder and below
    ///
    /// A mesh names material libraries, textures or buffers, and libraries name textures; their contents get into the results. A
    /// manifest names its maps and meshes. Give this option only if you know where the file comes from.
    #[arg(long)]
    pub(crate) trust: bool,
}

impl TrustArgs {
    /// Returns the rule that was chosen.
    pub(crate) fn rule(&self) -> Trust {
        if self.trust { Trust::Anywhere } else { Trust::Folder }
    }
}

/// Meaning of `--normals auto`.
const NORMALS: &str =
    "angle, denoised or leaning, whichever loses least, for methods that have --motion; angle for other methods";

/// Options for the map.
#[derive(Args, Debug)]
pub(crate) struct MapArgs {
    /// Strength λ for the normal map and for the settings of other programs: 0 is noisy, 1 is denoised
    #[arg(long, value_name = "L", default_value_t = 1.0, allow_negative_numbers = true, value_parser = finite, help_heading = "Map")]
    pub(crate) lambda: f64,
    /// Normals to displace along; the carrier has them in its `vn` lines
    #[arg(long, value_parser = named_or_auto::<NormalField>(NORMALS), default_value = "auto", help_heading = "Map")]
    pub(crate) normals: OrAuto<NormalField>,
    /// Heights along the normals, or the whole displacement of each vertex
    ///
    /// With scalar, methods that have --motion move vertices only as heights can express; the report says what that costs.
    #[arg(long, value_enum, default_value_t, help_heading = "Map")]
    pub(crate) map: MapArg,
    /// Axes of --map vector [default: object]
    #[arg(long, value_enum, help_heading = "Map")]
    pub(crate) space: Option<SpaceArg>,
    /// Where a vertex has its texel
    #[arg(long, value_parser = named::<LayoutChoice>(), default_value = LayoutChoice::default().name(), help_heading = "Map")]
    pub(crate) layout: LayoutChoice,
    /// Whether the map has an image for each UDIM tile or material of the mesh; not with --layout vertex or unwrap
    #[arg(long, value_parser = named::<PageRule>(), default_value = PageRule::default().name(), help_heading = "Map")]
    pub(crate) pages: PageRule,
    /// Largest error of a vertex at which --layout auto still uses the mesh's own UVs, in steps of the map
    #[arg(long, value_name = "Q", default_value_t = 1.0, allow_negative_numbers = true, value_parser = tolerance, help_heading = "Map")]
    pub(crate) tolerance: f64,
    /// Largest size that --size auto may choose
    #[arg(long, value_name = "N", default_value_t = planish_geometry::map::map_size::LARGEST_SIDE, allow_negative_numbers = true, value_parser = largest_side, help_heading = "Map")]
    pub(crate) max_size: u32,
    /// Side of the map in texels, or auto: the smallest power of two at which each vertex gets its height
    #[arg(long, value_name = "auto|N", default_value = "auto", allow_negative_numbers = true, value_parser = side, help_heading = "Map")]
    pub(crate) size: OrAuto<u32>,
    /// How texels between vertices are filled
    #[arg(long, value_parser = named::<Interpolation>(), default_value = Interpolation::default().name(), help_heading = "Map")]
    pub(crate) interpolation: Interpolation,
    /// Whether texels are adjusted until each vertex samples its own height
    #[arg(long, value_parser = named::<Texels>(), default_value = Texels::default().name(), help_heading = "Map")]
    pub(crate) texels: Texels,
    /// Bits per channel: 8, 16 or 32 [default: 16, with --format exr 32]
    #[arg(long, value_name = "8|16|32", value_parser = bits, help_heading = "Map")]
    pub(crate) bits: Option<u32>,
    /// File format of the displacement map [default: png, with --bits 32 exr]
    #[arg(long, value_parser = named::<FileFormat>(), help_heading = "Map")]
    pub(crate) format: Option<FileFormat>,
    /// Green channel of the normal map: opengl points up (Blender, glTF, three.js, Unity), directx down (Unreal)
    #[arg(long, value_parser = named::<Convention>(), default_value = Convention::default().name(), help_heading = "Map")]
    pub(crate) normal_convention: Convention,
    /// Bake NAME.occlusion.png too: how much of the light from all around reaches each place of the denoised surface
    #[arg(long, help_heading = "Shading")]
    pub(crate) ao: bool,
    /// Number of rays of --ao for each texel or vertex, from 1 to 65536
    #[arg(long, value_name = "N", requires = "ao", default_value_t = Occlusion::default().rays, allow_negative_numbers = true, value_parser = rays, help_heading = "Shading")]
    pub(crate) ao_rays: u32,
    /// Distance beyond which nothing blocks the light of --ao, model units [default: none]
    #[arg(long, value_name = "D", requires = "ao", allow_negative_numbers = true, value_parser = length, help_heading = "Shading")]
    pub(crate) ao_distance: Option<f64>,
    /// Bake NAME.curvature.png too: grey where the denoised surface is flat, bright where it bulges, dark in cavities
    #[arg(long, help_heading = "Shading")]
    pub(crate) curvature: bool,
    /// Do not write NAME.glb, the carrier as binary glTF with the denoised surface as a morph target
    #[arg(long, help_heading = "Map")]
    pub(crate) no_glb: bool,
}

#[derive(Args, Debug)]
pub(crate) struct BakeArgs {
    /// The noisy mesh
    #[arg(value_name = "MESH")]
    pub(crate) input: PathBuf,
    /// Folder for the results; created if missing [default: ./NAME-planish]
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) method: MethodArgs,
    #[command(flatten, next_help_heading = "Denoising")]
    pub(crate) welding: WeldArgs,
    /// Bake the displacement to this mesh instead: the result of any other denoiser, with the same vertices in the same order
    #[arg(long, value_name = "DENOISED", help_heading = "Denoising")]
    #[arg(conflicts_with_all = method::options())]
    pub(crate) target: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) map: MapArgs,
    #[command(flatten)]
    pub(crate) trust: TrustArgs,
}

#[derive(Args, Debug)]
pub(crate) struct ApplyArgs {
    /// The manifest that `bake` wrote
    #[arg(value_name = "MAP.planish.json")]
    pub(crate) manifest: PathBuf,
    /// The mesh that was baked, or its carrier [default: the carrier beside the manifest, or the mesh if OUT is in its format and the carrier is not]
    #[arg(long, value_name = "MESH")]
    pub(crate) mesh: Option<PathBuf>,
    /// Strength λ: 0 is noisy, 1 is denoised [default: from the manifest]
    #[arg(long, value_name = "L", allow_negative_numbers = true, value_parser = finite)]
    pub(crate) lambda: Option<f64>,
    /// Output file for the displaced mesh; `-` for stdout
    #[arg(short, long, value_name = "OUT|-")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) trust: TrustArgs,
}

#[derive(Args, Debug)]
pub(crate) struct CheckArgs {
    /// The manifest that `bake` wrote
    #[arg(value_name = "MAP.planish.json")]
    pub(crate) manifest: PathBuf,
    /// The mesh that was baked [default: the file that the manifest names]
    #[arg(long, value_name = "MESH")]
    pub(crate) mesh: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) trust: TrustArgs,
}

#[derive(Args, Debug)]
pub(crate) struct DenoiseArgs {
    /// The noisy mesh
    #[arg(value_name = "MESH")]
    pub(crate) input: PathBuf,
    /// Output file for the denoised mesh; `-` for stdout
    #[arg(short, long, value_name = "OUT|-")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) method: MethodArgs,
    #[command(flatten, next_help_heading = "Denoising")]
    pub(crate) welding: WeldArgs,
    /// Update the numbers of the `vn` lines too, so that shading follows the new shape; hard edges stay hard
    #[arg(long)]
    pub(crate) update_normals: bool,
    /// Write where the noise is, as the method `auto` measured it: the input with σ of each vertex as its colour, violet for 0, yellow for the
    /// 99th percentile; the quality of the vertices of a .ply is σ in the unit of the mesh
    #[arg(long, value_name = "OUT.ply|.obj")]
    pub(crate) noise_map: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) trust: TrustArgs,
}

#[derive(Args, Debug)]
// An option of a map that is not made would be ignored.
#[command(mut_group("MapArgs", |group| group.requires("bake")))]
pub(crate) struct BatchArgs {
    /// Meshes, folders with meshes in them and below, or patterns such as "scans/**/*.ply"
    #[arg(value_name = "MESH|DIR|PATTERN", required_unless_present = "list")]
    pub(crate) inputs: Vec<PathBuf>,
    /// Read meshes from a text file as well, one path in each line; `-` for stdin
    #[arg(long, value_name = "FILE|-")]
    pub(crate) list: Option<PathBuf>,
    /// Folder for the results; a mesh that was found in a folder or by a pattern keeps its place below it
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: PathBuf,
    /// Bake displacement maps, each into a folder NAME-planish, instead of writing denoised meshes
    #[arg(long)]
    pub(crate) bake: bool,
    /// Number of meshes that are worked on at the same time [default: the number of processors]
    ///
    /// Each of them gets an equal part of the processors, and needs memory.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub(crate) jobs: Option<u32>,
    /// Do only part I of N parts of all meshes, counted from 1; the parts can run on different machines
    #[arg(long, value_name = "I/N", value_parser = values::shard)]
    pub(crate) shard: Option<Shard>,
    /// Leave out meshes that a journal in DIR says are done with the same settings, and have not changed since
    #[arg(long)]
    pub(crate) resume: bool,
    #[command(flatten)]
    pub(crate) method: MethodArgs,
    #[command(flatten, next_help_heading = "Denoising")]
    pub(crate) welding: WeldArgs,
    /// Update the numbers of the `vn` lines too, as for `planish denoise`
    #[arg(long, conflicts_with = "bake")]
    pub(crate) update_normals: bool,
    /// Options for the maps of --bake
    #[command(flatten)]
    pub(crate) map: MapArgs,
    #[command(flatten)]
    pub(crate) trust: TrustArgs,
}

#[derive(Args, Debug)]
pub(crate) struct CompareArgs {
    /// The clean mesh
    #[arg(value_name = "CLEAN")]
    pub(crate) clean: PathBuf,
    /// Meshes with the same vertices and faces
    #[arg(value_name = "RESULT", required = true)]
    pub(crate) results: Vec<PathBuf>,
    /// Write a table with one row for each result; `-` for stdout
    #[arg(long, value_name = "FILE|-")]
    pub(crate) csv: Option<PathBuf>,
    /// Write the result as a heat map: the error of each vertex as its colour, violet for 0, yellow for the 99th percentile
    ///
    /// With more than one result, planish writes OUT-NAME.ply for each NAME.obj, all with the same scale.
    #[arg(long, value_name = "OUT.ply|.obj")]
    pub(crate) heatmap: Option<PathBuf>,
    /// Error that the heat map shows
    #[arg(long, value_parser = named::<Heat>(), default_value = Heat::default().name(), requires = "heatmap")]
    pub(crate) heat: Heat,
    /// Error that is drawn yellow: degrees with --heat angle, mean edge lengths with --heat distance
    #[arg(long, value_name = "X", requires = "heatmap", allow_negative_numbers = true, value_parser = above_zero)]
    pub(crate) heat_max: Option<f64>,
    #[command(flatten)]
    pub(crate) trust: TrustArgs,
}

#[derive(Args, Debug)]
pub(crate) struct BenchQualityArgs {
    /// Folder with clean and noisy meshes
    #[arg(value_name = "DIR")]
    pub(crate) folder: PathBuf,
    /// Methods, separated by commas [default: all; with --noise auto and seven classical ones]
    #[arg(long, value_name = "A,B", value_parser = method::denoiser(), value_delimiter = ',')]
    pub(crate) methods: Vec<Denoiser>,
    /// Names of pairs, with --noise of clean meshes, separated by commas [default: all]
    #[arg(long, value_name = "X,Y", value_delimiter = ',')]
    pub(crate) pairs: Vec<String>,
    /// Settings to start from; paper has those of the methods' authors, where they differ
    #[arg(long, value_enum, default_value_t)]
    pub(crate) preset: PresetArg,
    /// A setting by its name in manifests, for the methods that have it
    #[arg(long, value_name = "NAME=VALUE", value_delimiter = ',', value_parser = setting)]
    pub(crate) set: Vec<(String, serde_json::Value)>,
    /// Denoise the clean meshes too, and report the mean angle by which that rotates their faces
    #[arg(long)]
    pub(crate) harm: bool,
    /// Make noise of these kinds from clean meshes: all, clean, or a kind of `planish noise` with its standard deviation in mean
    /// edge lengths, separated by commas
    #[arg(long, value_name = "KIND[:SIGMA],…", conflicts_with = "harm", value_delimiter = ',')]
    #[arg(value_parser = ValueParser::new(noise::noise_requests))]
    pub(crate) noise: Vec<Vec<NoiseRequest>>,
    /// With --noise, give each mesh only this many of the kinds, in turn, so that all kinds are met
    #[arg(long, value_name = "N", requires = "noise", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) per_mesh: Option<u32>,
    /// With --noise, leave out meshes with more triangles
    #[arg(long, value_name = "N", requires = "noise")]
    pub(crate) max_faces: Option<usize>,
    /// Write a table with one row for each pair and method; `-` for stdout
    #[arg(long, value_name = "FILE|-")]
    pub(crate) csv: Option<PathBuf>,
}

#[derive(Args, Debug)]
pub(crate) struct InfoArgs {
    /// The mesh
    #[arg(value_name = "MESH")]
    pub(crate) input: PathBuf,
    #[command(flatten)]
    pub(crate) welding: WeldArgs,
    #[command(flatten)]
    pub(crate) trust: TrustArgs,
}

#[derive(Args, Debug)]
pub(crate) struct MethodsArgs {
    /// The method to list [default: all]
    #[arg(value_name = "METHOD", value_parser = method::denoiser())]
    pub(crate) method: Option<Denoiser>,
    /// Print the methods as a page of the documentation, in Markdown
    #[arg(long, conflicts_with_all = ["json", "method"])]
    pub(crate) markdown: bool,
}
