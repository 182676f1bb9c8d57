//! Settings as the shaders get them.

use crate::camera::View;
use crate::displaced_mesh::DisplacementBinding;
use crate::draw_parameters::{LINE_WIDTH, derives_normals, heat_range, marble_frequency, normal_map_strength};
use crate::gpu::shaders::Variant;
use crate::gpu::types::{ControlPoint, Displacement, Frame, Light, Volume};
use crate::ground;
use crate::lights::{WorldLight, world_lights};
use crate::scene::Scene;
use crate::settings::volume::VolumeDisplay;
use crate::settings::{Displace, Normals, Settings, Shading, Size};
use crate::volume_rays::VolumeRays;
use bytemuck::Zeroable as _;
use glam::Mat4;
use planish_geometry::map::displacement::MapKind;

/// A scene as one picture shows it.
pub(super) struct Picture<'a> {
    pub(super) scene: &'a Scene,
    pub(super) settings: &'a Settings,
    pub(super) view: View,
    /// Aspect ratio, width / height.
    pub(super) aspect: f32,
}

impl<'a> Picture<'a> {
    pub(super) fn new(scene: &'a Scene, settings: &'a Settings, size: Size) -> Self {
        let aspect = size.width as f32 / size.height as f32;
        Self { scene, settings, view: ground::view(scene, settings, aspect), aspect }
    }
}

/// Uniforms of a picture. `scale`: pixels drawn for each pixel of the picture.
pub(super) fn frame(picture: &Picture, scale: f32) -> Frame {
    let Picture { scene, settings, ref view, .. } = *picture;
    let mut frame = Frame {
        clip_from_world: view.clip_from_world,
        world_from_view: Mat4::from_mat3(view.world_from_view),
        eye_in_world: view.eye_in_world,
        up_in_world: view.up_in_world,
        light_count: settings.lights.len() as u32,
        sky: settings.ambient.intensity * settings.ambient.sky.linear(),
        specular: settings.material.specular,
        ground: settings.ambient.intensity * settings.ambient.ground.linear(),
        exponent: settings.material.exponent,
        base_colour: settings.material.colour.linear(),
        checker_light: settings.checker.light.linear(),
        checker_squares: settings.checker.squares,
        checker_dark: settings.checker.dark.linear(),
        background_top: settings.background.top.encoded(),
        background_bottom: settings.background.bottom.encoded(),
        vein_colour: settings.marble.colour.linear(),
        vein_frequency: marble_frequency(scene, settings),
        heat_relief: settings.heat.relief,
        line_width: LINE_WIDTH * scale,
        occlusion: settings.ambient.occlusion,
        normal_strength: normal_map_strength(scene, settings).unwrap_or(0.0),
        ..Frame::default()
    };
    if matches!(settings.shading, Shading::Height | Shading::Heat)
        && let Some(range) = heat_range(scene, settings)
    {
        (frame.heat_low, frame.heat_high, frame.has_heat) = (range.low, range.high, 1);
    }
    // HAS_NORMAL_MAP, HAS_HEIGHTS_IN_UV, HAS_OCCLUSION_MAP, HAS_VOLUME
    let has = [
        !scene.normal_maps.all().is_empty(),
        scene.displacement.as_ref().is_some_and(DisplacementBinding::in_uv),
        scene.occlusion_map().is_some(),
        scene.volume().is_some(),
    ];
    frame.has = (0..).zip(has).map(|(bit, has)| u32::from(has) << bit).sum();
    for (slot, world_light) in frame.lights.iter_mut().zip(world_lights(scene, settings, view)) {
        let WorldLight { position, radiance, axis, cos_outer, cos_inner } = world_light;
        *slot = Light { place: position, radiance, cos_outer, axis, cos_inner };
    }
    frame
}

/// Choices that the shaders are compiled for.
pub(super) fn variant(scene: &Scene, settings: &Settings) -> Variant {
    let Settings { shading, overlay, sampling, shadow, .. } = *settings;
    Variant {
        shading,
        normals: normals(scene, settings),
        overlay,
        sampling,
        filter: shadow.filter,
        outside: shadow.outside,
        volume: volume_display(scene, settings),
    }
}

/// Display of the volume of a scene: hidden where the scene has no volume.
pub(super) fn volume_display(scene: &Scene, settings: &Settings) -> VolumeDisplay {
    match &settings.volume {
        Some(wanted) if scene.volume().is_some() => wanted.display,
        _ => VolumeDisplay::Hidden,
    }
}

/// Uniforms of the volume; zero without one.
pub(super) fn volume(picture: &Picture) -> Volume {
    let Some(rays) = VolumeRays::new(picture.scene, picture.settings, &picture.view) else { return Volume::zeroed() };
    let mut points = [ControlPoint::default(); crate::settings::volume::MAX_POINTS];
    for (slot, (at, colour)) in points.iter_mut().zip(&rays.points) {
        *slot = ControlPoint { colour: colour.truncate(), opacity: colour.w, at: *at, ..ControlPoint::default() };
    }
    Volume {
        texel_from_world: rays.texel_from_world.into(),
        rays: rays.rays,
        low: rays.low,
        step: rays.step,
        high: rays.high,
        density: rays.density,
        slices: rays.slices.map(|slice| slice.unwrap_or(0.0)).into(),
        has_slices: (0..).zip(rays.slices).map(|(bit, slice)| u32::from(slice.is_some()) << bit).sum(),
        value_low: rays.value_low,
        value_scale: rays.value_scale,
        lighting: rays.lighting,
        diagonal: rays.diagonal,
        point_count: rays.points.len() as u32,
        points,
        ..Volume::zeroed()
    }
}

/// Replaces normals that a scene does not have by those that it has.
fn normals(scene: &Scene, settings: &Settings) -> Normals {
    match settings.displace.normals {
        Normals::Derived if !derives_normals(scene, settings) => Normals::Base,
        normals => normals,
    }
}

pub(super) fn displacement(scene: &Scene, displace: &Displace) -> Displacement {
    let Some(binding) = &scene.displacement else { return Displacement::default() };
    let [bias, scale] = binding.bias_and_scale(displace);
    let kind = match binding.map.kind() {
        MapKind::Scalar => 0,
        MapKind::VectorObject => 1,
        MapKind::VectorTangent => 2,
    };
    Displacement { bias, scale, lambda: binding.signed_lambda(displace), kind }
}
