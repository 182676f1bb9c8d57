//! What is baked, as the window chooses it, and the command line that does the same.

use super::options;
use planish_files::bake::{self, Job};
use planish_files::failure::Failure;
use planish_files::input;
use planish_geometry::bundle::{Carriers, Goal, LayoutChoice, Settings};
use planish_geometry::denoise::limits::{Limits, Mask, Volume};
use planish_geometry::denoise::{Denoiser, Denoising, NormalField};
use planish_geometry::displacement::{FileFormat, MapKind, TexelFormat};
use planish_geometry::manifest::{Layout, Manifest, Method, UvSource};
use planish_geometry::model::NormalSource;
use planish_geometry::texture::normal_map::Convention;
use planish_geometry::texture::{Interpolation, Texels};
use planish_geometry::weld::Welding;
use std::path::{Path, PathBuf};

/// Everything that `planish bake` has options for.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recipe {
    /// The method, unless there is a target.
    pub denoiser: Denoiser,
    /// What it may not do.
    pub limits: Holds,
    /// The result of another denoiser.
    pub target: Option<PathBuf>,
    /// All else; its goal is not looked at.
    pub settings: Settings,
}

/// Limits, as the command line has them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Holds {
    /// Whether the rim stays.
    pub boundary: bool,
    /// A text with the `v` lines that stay.
    pub mask: Option<PathBuf>,
    /// `v` lines that stay, of a manifest.
    pub lines: Mask,
    /// How far a vertex may go, mean edge lengths.
    pub max_displacement: Option<f64>,
    /// Whether the enclosed volume is restored.
    pub preserve_volume: bool,
}

impl Holds {
    fn of(limits: &Limits) -> Self {
        let boundary = limits.fixed == Mask::boundary();
        Self {
            boundary,
            mask: None,
            lines: if boundary { Mask::default() } else { limits.fixed.clone() },
            max_displacement: limits.max_displacement,
            preserve_volume: limits.volume == Volume::Preserve,
        }
    }

    fn limits(&self, v_lines: usize) -> Result<Limits, Failure> {
        let mut fixed = self.lines.clone();
        if self.boundary {
            fixed = fixed.and(Mask::boundary());
        }
        if let Some(path) = &self.mask {
            fixed = fixed.and(input::mask(path, v_lines)?);
        }
        let volume = if self.preserve_volume { Volume::Preserve } else { Volume::Free };
        Ok(Limits { fixed, max_displacement: self.max_displacement, volume })
    }
}

impl Recipe {
    /// What a manifest says, as far as it says it.
    pub fn of(manifest: &Manifest, path: &Path) -> Self {
        let mut recipe = Self::default();
        match &manifest.method {
            Method::Denoiser(Denoising { denoiser, limits }) => {
                // Maps of heights are along normals whatever the method says.
                let is_scalar = manifest.displacement.map == MapKind::Scalar;
                recipe.denoiser = if is_scalar { denoiser.freed() } else { denoiser.clone() };
                recipe.limits = Holds::of(limits);
            }
            Method::Target(target) => recipe.target = Some(path.with_file_name(&target.file)),
            Method::Other(_) => {}
        }
        let map = &manifest.displacement;
        let settings = &mut recipe.settings;
        settings.welding = manifest.welding;
        settings.normals = Some(manifest.normals);
        settings.lambda.0 = map.lambda;
        settings.map = map.map;
        settings.texel = map.texel;
        settings.layout = match (map.layout, map.uvs) {
            (Layout::Vertex, _) => LayoutChoice::Vertex,
            (Layout::Uv, UvSource::Mesh) => LayoutChoice::Uv,
            (Layout::Uv, UvSource::Unwrapped) => LayoutChoice::Unwrap,
        };
        // Only where the side was chosen the normal map may have another one.
        let is_given = manifest.normal_map.as_ref().is_none_or(|normals| normals.width == map.width);
        settings.side = Some(map.width).filter(|_| is_given && map.layout == Layout::Uv);
        settings.interpolation = map.interpolation.unwrap_or_default();
        settings.texels = map.texels.unwrap_or_default();
        if let Some(entry) = &manifest.normal_map {
            settings.convention = entry.convention;
        }
        if manifest.carrier.glb.is_none() {
            settings.carriers = Carriers::Obj;
        }
        recipe
    }

    /// Settings with their goal, for a mesh and a folder.
    pub fn settings(&self, job: &Job) -> Result<Settings, Failure> {
        let goal = match &self.target {
            Some(path) => job.target(path)?,
            None => {
                let limits = self.limits.limits(job.model.data().positions().len())?;
                Goal::Denoiser(Denoising { denoiser: self.denoiser.clone(), limits })
            }
        };
        Ok(Settings { goal, ..self.settings.clone() })
    }

    /// The arguments of `planish` that bake the same files; what is as by default is left out.
    pub fn arguments(&self, input: &Path, folder: &Path) -> Vec<String> {
        let mut out = vec!["bake".to_owned(), input.display().to_string()];
        let mut add = |option: &str, value: String| out.extend([format!("--{option}"), value]);
        if bake::default_folder(input).ok().as_deref() != Some(folder) {
            add("output", folder.display().to_string());
        }
        match &self.target {
            Some(target) => add("target", target.display().to_string()),
            None => {
                options::arguments(&self.denoiser, &mut add);
                if self.limits.boundary {
                    add("fix", "boundary".to_owned());
                }
                if let Some(mask) = &self.limits.mask {
                    add("fix", mask.display().to_string());
                }
                if let Some(d) = self.limits.max_displacement {
                    add("max-displacement", d.to_string());
                }
            }
        }
        let (chosen, default) = (&self.settings, Settings::default());
        match chosen.welding {
            Welding::Exact => {}
            Welding::None => add("weld", "none".to_owned()),
            Welding::Epsilon(epsilon) => add("weld", epsilon.to_string()),
        }
        if chosen.lambda != default.lambda {
            add("lambda", chosen.lambda.0.to_string());
        }
        if chosen.normals != default.normals {
            add("normals", word(normals(), chosen.normals));
        }
        match chosen.map {
            MapKind::Scalar => {}
            MapKind::VectorObject => add("map", "vector".to_owned()),
            MapKind::VectorTangent => {
                add("map", "vector".to_owned());
                add("space", "tangent".to_owned());
            }
        }
        if chosen.layout != default.layout {
            add("layout", word(layouts(), chosen.layout));
        }
        if chosen.tolerance != default.tolerance {
            add("tolerance", chosen.tolerance.0.to_string());
        }
        if chosen.largest_side != default.largest_side {
            add("max-size", chosen.largest_side.0.to_string());
        }
        // One texel for each vertex has the size that it needs.
        if let Some(side) = chosen.side.filter(|_| chosen.layout != LayoutChoice::Vertex) {
            add("size", side.to_string());
        }
        if chosen.interpolation != default.interpolation {
            add("interpolation", word(interpolations(), chosen.interpolation));
        }
        if chosen.texels != default.texels {
            add("texels", word(texels(), chosen.texels));
        }
        if chosen.texel != default.texel {
            add("format", file_word(chosen.texel.file()).to_owned());
            add("bits", chosen.texel.bits().to_string());
        }
        if chosen.convention != default.convention {
            add("normal-convention", word(conventions(), chosen.convention));
        }
        if self.target.is_none() && self.limits.preserve_volume {
            out.push("--preserve-volume".to_owned());
        }
        if chosen.carriers == Carriers::Obj {
            out.push("--no-glb".to_owned());
        }
        out
    }

    /// The same as one line for a shell.
    pub fn command(&self, input: &Path, folder: &Path) -> String {
        let words = self.arguments(input, folder);
        let mut all: Vec<String> = vec!["planish".to_owned()];
        all.extend(words.iter().map(|word| quoted(word)));
        if self.target.is_none() && !self.limits.lines.is_empty() {
            // The command line takes them from a file, which a shell can make on the way.
            all.push(format!("--fix <(echo {})", quoted(&String::from(self.limits.lines.clone()))));
        }
        all.join(" ")
    }
}

/// A word that a shell takes as it is.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=+,:@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

/// Choices with their words on the command line.
pub type Choices<T> = &'static [(&'static str, T)];

fn word<T: Copy + PartialEq + 'static>(choices: Choices<T>, chosen: T) -> String {
    choices.iter().find(|(_, choice)| *choice == chosen).map_or_else(String::new, |(word, _)| (*word).to_owned())
}

/// `--normals`
pub fn normals() -> Choices<Option<NormalField>> {
    &[
        ("auto", None),
        ("angle", Some(NormalField::Source(NormalSource::Angle))),
        ("denoised", Some(NormalField::Denoised)),
        ("leaning", Some(NormalField::Tilted)),
        ("area", Some(NormalField::Source(NormalSource::Area))),
        ("uniform", Some(NormalField::Source(NormalSource::Uniform))),
        ("file", Some(NormalField::Source(NormalSource::File))),
    ]
}

/// `--layout`
pub fn layouts() -> Choices<LayoutChoice> {
    const ALL: [(&str, LayoutChoice); 4] = [
        ("auto", LayoutChoice::Auto),
        ("uv", LayoutChoice::Uv),
        ("vertex", LayoutChoice::Vertex),
        ("unwrap", LayoutChoice::Unwrap),
    ];
    if planish_geometry::bundle::CAN_UNWRAP { &ALL } else { ALL.split_at(3).0 }
}

/// `--interpolation`
pub fn interpolations() -> Choices<Interpolation> {
    &[
        ("barycentric", Interpolation::Barycentric),
        ("natural", Interpolation::Natural),
        ("idw", Interpolation::Idw),
        ("nearest", Interpolation::Nearest),
    ]
}

/// `--texels`
pub fn texels() -> Choices<Texels> {
    &[("fitted", Texels::Fitted), ("interpolated", Texels::Interpolated)]
}

/// `--normal-convention`
pub fn conventions() -> Choices<Convention> {
    &[("opengl", Convention::OpenGl), ("directx", Convention::DirectX)]
}

/// `--map` and `--space`
pub fn maps() -> Choices<MapKind> {
    &[
        ("heights", MapKind::Scalar),
        ("vectors, object space", MapKind::VectorObject),
        ("vectors, tangent space", MapKind::VectorTangent),
    ]
}

fn file_word(format: FileFormat) -> &'static str {
    match format {
        FileFormat::Png => "png",
        FileFormat::Exr => "exr",
        FileFormat::Tiff => "tiff",
    }
}

/// `--format` and `--bits` in words.
pub fn texel_words(texel: TexelFormat) -> String {
    format!("{}, {} bits", file_word(texel.file()).to_uppercase(), texel.bits())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_left_out() {
        let recipe = Recipe::default();
        assert_eq!(recipe.command(Path::new("a/b c.obj"), Path::new("b c-planish")), "planish bake 'a/b c.obj'");
        let folder = Path::new("it's");
        assert_eq!(recipe.command(Path::new("a.obj"), folder), r"planish bake a.obj --output 'it'\''s'");
    }

    #[test]
    fn what_is_chosen_is_said() {
        let mut recipe = Recipe { denoiser: Denoiser::every()[1].clone(), ..Recipe::default() };
        recipe.settings.map = MapKind::VectorTangent;
        recipe.settings.texel = TexelFormat::Exr16;
        recipe.settings.carriers = Carriers::Obj;
        let words = recipe.command(Path::new("a.obj"), Path::new("a-planish"));
        let expected =
            "planish bake a.obj --method taubin --map vector --space tangent --format exr --bits 16 --no-glb";
        assert_eq!(words, expected);
    }
}
