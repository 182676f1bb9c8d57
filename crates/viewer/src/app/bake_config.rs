//! Configuration of the bake that the window has chosen, and the command line that bakes the same files.

use planish_files::bake_files::{self, Job};
use planish_files::failure::Failure;
use planish_files::input;
use planish_geometry::bake::{
    BakeSettings, BakeTarget, Carriers, CurvatureMap, Lambda, LargestSide, LayoutChoice, Quanta,
};
use planish_geometry::denoise::limits::{Direction, Limits, Mask, Volume, WeightMask};
use planish_geometry::denoise::{Denoiser, Denoising, LastResult, NormalField};
use planish_geometry::map::displacement::{MapKind, TexelFormat};
use planish_geometry::map::manifest::{Layout, Manifest, Method, UvSource};
use planish_geometry::map::normal_map::Convention;
use planish_geometry::map::occlusion::Occlusion;
use planish_geometry::mesh::weld::Welding;
use planish_geometry::named::Named;
use std::path::{Path, PathBuf};

/// Configuration of a bake: everything that `planish bake` has options for.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BakeConfig {
    /// Denoising method; not used while there is a target.
    pub denoiser: Denoiser,
    /// Limits of the method.
    pub limits: LimitOptions,
    /// Mesh that another denoiser has made, which the map leads to.
    pub target: Option<PathBuf>,
    /// All else; its goal is not looked at.
    pub settings: BakeSettings,
}

/// Limits of the method, as the command line has them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LimitOptions {
    /// Whether vertices on the boundary are fixed.
    pub boundary: bool,
    /// Text file that lists the `v` lines of fixed vertices.
    pub fixed_file: Option<PathBuf>,
    /// Fixed vertices that a manifest lists, as `v` lines.
    pub fixed: Mask,
    /// Largest displacement of a vertex, mean edge lengths; none without a limit.
    pub max_displacement: Option<f64>,
    /// Whether the enclosed volume is restored.
    pub preserve_volume: bool,
    /// How far each vertex may go, as a manifest says.
    pub mask: Option<WeightMask>,
    /// Direction along which vertices move, as a manifest says.
    pub direction: Option<Direction>,
}

impl LimitOptions {
    fn of(limits: &Limits) -> Self {
        let boundary = limits.fixed == Mask::boundary();
        Self {
            boundary,
            fixed_file: None,
            fixed: if boundary { Mask::default() } else { limits.fixed.clone() },
            max_displacement: limits.max_displacement,
            preserve_volume: limits.volume == Volume::Preserve,
            mask: limits.mask.clone(),
            direction: limits.direction,
        }
    }

    fn limits(&self, v_lines: usize) -> Result<Limits, Failure> {
        let mut fixed = self.fixed.clone();
        if self.boundary {
            fixed = fixed.and(Mask::boundary());
        }
        if let Some(path) = &self.fixed_file {
            fixed = fixed.and(input::fixed_vertices(path, v_lines)?);
        }
        let volume = if self.preserve_volume { Volume::Preserve } else { Volume::Free };
        let (mask, direction) = (self.mask.clone(), self.direction);
        Ok(Limits { fixed, max_displacement: self.max_displacement, volume, mask, direction })
    }
}

impl BakeConfig {
    /// Restores the configuration from a manifest, as far as it is in there.
    pub fn of(manifest: &Manifest, path: &Path) -> Self {
        let map = &manifest.displacement;
        let of_pages = manifest.page_entries().iter().find_map(|page| page.normal_map.as_ref());
        let normal_map = manifest.normal_map.as_ref().or(of_pages);
        let (mut denoiser, mut limits, mut target) = <_>::default();
        match &manifest.method {
            Method::Denoiser(denoising) => {
                // Maps of heights are along normals whatever the method says.
                let free = map.map == MapKind::Scalar;
                denoiser = if free { denoising.denoiser.freed() } else { denoising.denoiser.clone() };
                limits = LimitOptions::of(&denoising.limits);
            }
            Method::Target(of) => target = Some(path.with_file_name(&of.file)),
            Method::Other(_) => {}
        }
        // Only where the side was chosen the normal map may have another one.
        let is_given = normal_map.is_none_or(|normals| normals.width == map.width) && manifest.pages.is_none();
        let settings = BakeSettings {
            target: BakeTarget::default(),
            welding: manifest.welding,
            normals: Some(manifest.normals),
            lambda: Lambda(map.lambda),
            map: map.map,
            layout: match (map.layout, map.uvs) {
                (Layout::Vertex, _) => LayoutChoice::Vertex,
                (Layout::Uv, UvSource::Mesh) if manifest.private_texels.is_empty() && manifest.pages.is_none() => {
                    LayoutChoice::Uv
                }
                (Layout::Uv, UvSource::Mesh) => LayoutChoice::Auto,
                (Layout::Uv, UvSource::Unwrapped) => LayoutChoice::Unwrap,
            },
            pages: manifest.pages.as_ref().and_then(|pages| pages.by.rule()).unwrap_or_default(),
            side: Some(map.width).filter(|_| is_given && map.layout == Layout::Uv),
            largest_side: LargestSide::default(),
            tolerance: Quanta::default(),
            interpolation: map.interpolation.unwrap_or_default(),
            texels: map.texels.unwrap_or_default(),
            texel: map.texel,
            convention: normal_map.map_or_else(Convention::default, |entry| entry.convention),
            carriers: if manifest.carrier.glb.is_none() { Carriers::Obj } else { Carriers::ObjAndGlb },
            occlusion: manifest.occlusion.as_ref().map(|o| Occlusion { rays: o.rays, distance: o.distance }),
            curvature: if manifest.curvature.is_none() { CurvatureMap::None } else { CurvatureMap::Mean },
            last_result: LastResult::default(),
        };
        Self { denoiser, limits, target, settings }
    }

    /// Settings with their goal, for a mesh and a folder.
    pub fn settings(&self, job: &Job) -> Result<BakeSettings, Failure> {
        let target = match &self.target {
            Some(path) => job.target(path)?,
            None => {
                let limits = self.limits.limits(job.model.data().positions().len())?;
                job.method(Denoising { denoiser: self.denoiser.clone(), limits })?
            }
        };
        Ok(BakeSettings { target, ..self.settings.clone() })
    }

    /// Returns the arguments of `planish` that bake the same files; defaults are left out.
    pub fn arguments(&self, input: &Path, folder: &Path) -> Vec<String> {
        let mut out = vec!["bake".to_owned(), input.display().to_string()];
        let mut add = |option: &str, value: String| out.extend([format!("--{option}"), value]);
        if bake_files::default_folder(input).ok().as_deref() != Some(folder) {
            add("output", folder.display().to_string());
        }
        match &self.target {
            Some(target) => add("target", target.display().to_string()),
            None => self.add_method(&mut add),
        }
        add_settings(&self.settings, &mut add);
        if self.target.is_none() && self.limits.preserve_volume {
            out.push("--preserve-volume".to_owned());
        }
        if self.settings.occlusion.is_some() {
            out.push("--ao".to_owned());
        }
        if self.settings.curvature == CurvatureMap::Mean {
            out.push("--curvature".to_owned());
        }
        if self.settings.carriers == Carriers::Obj {
            out.push("--no-glb".to_owned());
        }
        out
    }

    /// Adds the options of the method and its limits.
    fn add_method(&self, add: &mut impl FnMut(&str, String)) {
        if self.denoiser.name() != Denoiser::default().name() {
            add("method", self.denoiser.name().to_owned());
        }
        for (parameter, value) in self.denoiser.changes() {
            add(parameter.name, parameter.text(&value));
        }
        if self.limits.boundary {
            add("fix", "boundary".to_owned());
        }
        if let Some(path) = &self.limits.fixed_file {
            add("fix", path.display().to_string());
        }
        if let Some(d) = self.limits.max_displacement {
            add("max-displacement", d.to_string());
        }
        if let Some(mask) = &self.limits.mask {
            add("mask", mask.from.clone());
        }
        if let Some(direction) = self.limits.direction {
            add("direction", direction.to_string());
        }
    }

    /// Returns the command line that bakes the same files, quoted for a shell.
    pub fn command(&self, input: &Path, folder: &Path) -> String {
        let words = self.arguments(input, folder);
        let mut all: Vec<String> = vec!["planish".to_owned()];
        all.extend(words.iter().map(|word| quoted(word)));
        if self.target.is_none() && !self.limits.fixed.is_empty() {
            // The command line takes them from a file, which a shell can make on the way.
            all.push(format!("--fix <(echo {})", quoted(&String::from(self.limits.fixed.clone()))));
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

/// Options of all settings that have a value and are not the default.
fn add_settings(settings: &BakeSettings, add: &mut impl FnMut(&str, String)) {
    let default = BakeSettings::default();
    let BakeSettings {
        // The configuration has a method or a target instead, and results are remembered by the document.
        target: _,
        last_result: _,
        welding,
        normals,
        lambda,
        map,
        layout,
        pages,
        side,
        largest_side,
        tolerance,
        interpolation,
        texels,
        texel,
        convention,
        occlusion,
        // Flags, which have no value.
        carriers: _,
        curvature: _,
    } = settings;
    match welding {
        Welding::Exact => {}
        Welding::None => add("weld", "none".to_owned()),
        Welding::Epsilon(epsilon) => add("weld", epsilon.to_string()),
    }
    let mut unless = |is_default: bool, option: &str, value: String| {
        if !is_default {
            add(option, value);
        }
    };
    unless(*lambda == default.lambda, "lambda", lambda.0.to_string());
    unless(*normals == default.normals, "normals", normals.map_or("auto", NormalField::name).to_owned());
    unless(*map == MapKind::Scalar, "map", "vector".to_owned());
    unless(*map != MapKind::VectorTangent, "space", "tangent".to_owned());
    unless(*layout == default.layout, "layout", layout.name().to_owned());
    unless(*pages == default.pages, "pages", pages.name().to_owned());
    unless(*tolerance == default.tolerance, "tolerance", tolerance.0.to_string());
    unless(*largest_side == default.largest_side, "max-size", largest_side.0.to_string());
    // One texel for each vertex has the size that it needs.
    if let Some(side) = side.filter(|_| *layout != LayoutChoice::Vertex) {
        unless(false, "size", side.to_string());
    }
    unless(*interpolation == default.interpolation, "interpolation", interpolation.name().to_owned());
    unless(*texels == default.texels, "texels", texels.name().to_owned());
    unless(*texel == default.texel, "format", texel.file().name().to_owned());
    unless(*texel == default.texel, "bits", texel.bits().to_string());
    unless(*convention == default.convention, "normal-convention", convention.name().to_owned());
    if let Some(Occlusion { rays, distance }) = occlusion {
        unless(*rays == Occlusion::default().rays, "ao-rays", rays.to_string());
        unless(distance.is_none(), "ao-distance", distance.unwrap_or_default().to_string());
    }
}

/// Lists all values of an enum with their names.
pub fn choices<T: Named>() -> impl Iterator<Item = (String, T)> {
    T::VALUES.iter().map(|value| (value.word().name.to_owned(), *value))
}

/// Choices of the normals; none is automatic.
pub fn normals() -> impl Iterator<Item = (String, Option<NormalField>)> {
    std::iter::once(("auto".to_owned(), None)).chain(choices().map(|(name, source)| (name, Some(source))))
}

/// Choices of the layout that this build has.
pub fn layouts() -> impl Iterator<Item = (String, LayoutChoice)> {
    choices().filter(|(_, layout)| *layout != LayoutChoice::Unwrap || planish_geometry::bake::CAN_UNWRAP)
}

/// Choices of what a map holds.
pub fn maps() -> [(String, MapKind); 3] {
    MapKind::ALL.map(|map| {
        let words = match map {
            MapKind::Scalar => "heights",
            MapKind::VectorObject => "vectors, object space",
            MapKind::VectorTangent => "vectors, tangent space",
        };
        (words.to_owned(), map)
    })
}

/// Format of a map in words.
pub fn texel_words(texel: TexelFormat) -> String {
    format!("{}, {} bits", texel.file(), texel.bits())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_left_out() {
        let bake_config = BakeConfig::default();
        assert_eq!(bake_config.command(Path::new("a/b c.obj"), Path::new("b c-planish")), "planish bake 'a/b c.obj'");
        let folder = Path::new("it's");
        assert_eq!(bake_config.command(Path::new("a.obj"), folder), r"planish bake a.obj --output 'it'\''s'");
    }

    #[test]
    fn what_is_chosen_is_said() {
        let mut bake_config = BakeConfig { denoiser: Denoiser::every()[1].clone(), ..BakeConfig::default() };
        bake_config.settings.map = MapKind::VectorTangent;
        bake_config.settings.texel = TexelFormat::Exr16;
        bake_config.settings.carriers = Carriers::Obj;
        bake_config.settings.occlusion = Some(Occlusion { rays: 64, distance: Some(0.5) });
        bake_config.settings.curvature = CurvatureMap::Mean;
        let words = bake_config.command(Path::new("a.obj"), Path::new("a-planish"));
        let expected = "planish bake a.obj --method taubin --map vector --space tangent --format exr --bits 16 --ao-rays 64 --ao-distance 0.5 --ao --curvature --no-glb";
        assert_eq!(words, expected);
    }
}
