//! What a ray through a volume sees. Twin of `shaders/volume.wgsl`.
//!
//! Marc Levoy. Display of surfaces from volume data. IEEE CG&A 8(3), 1988. Efficient ray tracing of volume data. TOG 9(3), 1990.

use super::shading::Shader;
use crate::settings::volume::VolumeDisplay;
use crate::volume_rays::VolumeRays;
use glam::{Vec2, Vec3, Vec4, Vec4Swizzles};

/// Fraction of the light that comes through where a ray ends.
const LEAST_THROUGH: f32 = 0.002;

/// A ray with a unit direction, from `start` to `end` along it.
struct Ray {
    origin: Vec3,
    direction: Vec3,
    start: f32,
    end: f32,
}

impl VolumeRays<'_> {
    /// Colour and opacity of a value.
    fn transferred(&self, value: f32) -> Vec4 {
        let t = (value - self.value_low) * self.value_scale;
        let mut below = self.points[0];
        if t <= below.0 {
            return below.1;
        }
        for &above in &self.points[1..] {
            if t < above.0 {
                return below.1.lerp(above.1, (t - below.0) / (above.0 - below.0));
            }
            below = above;
        }
        below.1
    }

    /// Colour of the volume at a position in the scene, linear RGB.
    pub(super) fn solid_colour(&self, position: Vec3) -> Vec3 {
        self.transferred(self.volume.at(position)).xyz()
    }

    /// Change of the value over the scene, in ranges of the transfer function and diagonals of the box.
    fn slope(&self, texel: Vec3) -> Vec3 {
        let along = |axis: Vec3| self.volume.at_texel(texel + axis) - self.volume.at_texel(texel - axis);
        let along = Vec3::new(along(Vec3::X), along(Vec3::Y), along(Vec3::Z));
        let slope = self.texel_from_world.matrix3.transpose() * along;
        0.5 * self.value_scale * self.diagonal * slope
    }
}

impl Shader<'_> {
    /// The volume before a point of a surface that has this colour.
    pub(super) fn over_volume_to(&self, behind: Vec3, position: Vec3) -> Vec3 {
        let direction = -self.to_eye(position);
        self.over_volume(behind, || {
            if self.eye.w > 0.0 {
                let eye = self.eye.truncate();
                Ray { origin: eye, direction, start: 0.0, end: eye.distance(position) }
            } else {
                Ray { origin: position, direction, start: -1e30, end: 0.0 }
            }
        })
    }

    /// The volume before everything, at a position of the picture, −1..1 right and up.
    pub(super) fn over_volume_behind(&self, behind: Vec3, at: Vec2) -> Vec3 {
        let Some(volume) = &self.volume else { return behind };
        let [right, up, ahead, origin] = [0, 1, 2, 3].map(|i| volume.rays.col(i).truncate());
        let offset = at.x * right + at.y * up;
        self.over_volume(behind, || {
            if self.eye.w > 0.0 {
                Ray { origin, direction: (ahead + offset).normalize(), start: 0.0, end: 1e30 }
            } else {
                Ray { origin: origin + offset, direction: ahead, start: -1e30, end: 1e30 }
            }
        })
    }

    /// Colour that a ray sees through the volume, front to back, with another colour at its end.
    fn over_volume(&self, behind: Vec3, ray: impl FnOnce() -> Ray) -> Vec3 {
        let Some(volume) = self.volume.as_ref().filter(|volume| volume.display != VolumeDisplay::Hidden) else {
            return behind;
        };
        let Ray { origin, direction, start, end } = ray();
        let o = volume.texel_from_world.transform_point3(origin);
        let d = volume.texel_from_world.transform_vector3(direction);
        // A ray along a side of the box meets it far away, and not nowhere.
        let least = 1e-6 * d.abs().max_element();
        let divisor = Vec3::select(d.abs().cmplt(Vec3::splat(least)), Vec3::splat(least), d);
        let (a, b) = ((volume.low - o) / divisor, (volume.high - o) / divisor);
        let near = a.min(b).max_element().max(start);
        let mut far = a.max(b).min_element().min(end);
        if near >= far {
            return behind;
        }
        let mut colour = behind;
        for (axis, slice) in volume.slices.into_iter().enumerate() {
            let Some(slice) = slice else { continue };
            let t = (slice - o[axis]) / divisor[axis];
            if near <= t && t <= far {
                far = t;
                colour = volume.transferred(volume.volume.at_texel(o + t * d)).xyz();
            }
        }
        if volume.display == VolumeDisplay::Slices {
            return colour;
        }
        let (mut light, mut through) = (Vec3::ZERO, 1.0);
        let count = ((far - near) / volume.step).ceil() as u32;
        for i in 0..count {
            let begin = near + i as f32 * volume.step;
            // The last step ends where the ray ends.
            let size = volume.step.min(far - begin);
            let t = begin + 0.5 * size;
            let texel = o + t * d;
            let found = volume.transferred(volume.volume.at_texel(texel));
            if found.w > 0.0 && size > 0.0 {
                let opacity = 1.0 - (1.0 - found.w).max(1e-6).powf(size * volume.density);
                light +=
                    through * opacity * self.volume_lit(volume, found.xyz(), texel, origin + t * direction, -direction);
                through *= 1.0 - opacity;
                if through < LEAST_THROUGH {
                    break;
                }
            }
        }
        light + through * colour
    }

    /// Light from a sample to the eye: Blinn-Phong where values change, else the colour as it is. A volume casts no shadow, and lies in
    /// none.
    fn volume_lit(&self, volume: &VolumeRays, base: Vec3, texel: Vec3, position: Vec3, eye: Vec3) -> Vec3 {
        if volume.lighting == 0.0 {
            return base;
        }
        let slope = volume.slope(texel);
        let steepness = slope.length();
        if steepness == 0.0 {
            return base;
        }
        let towards = if slope.dot(eye) < 0.0 { -1.0 } else { 1.0 };
        let normal = towards * slope / steepness;
        let material = &self.settings.material;
        let (mut scattered, mut highlights) = (self.ambient(normal), Vec3::ZERO);
        for light in &self.world_lights {
            let (to_light, radiance) = light.incoming(position);
            let cosine = normal.dot(to_light);
            scattered += cosine.max(0.0) * radiance;
            if cosine > 0.0 {
                let half = (to_light + eye).normalize_or_zero();
                highlights += normal.dot(half).max(0.0).powf(material.exponent) * radiance;
            }
        }
        base.lerp(base * scattered + material.specular * highlights, volume.lighting * (2.0 * steepness).min(1.0))
    }
}

#[cfg(test)]
mod tests {
    use crate::colour::{Colour, pixel_from_linear};
    use crate::mesh::{Mesh, Triangle};
    use crate::scene::Scene;
    use crate::settings::camera::{Camera, Projection};
    use crate::settings::volume::{ControlPoint, Transfer, TransferPreset, VolumeDisplay, VolumeView};
    use crate::settings::{Background, Settings, Shading, Size};
    use crate::software::render;
    use crate::volume::Volume;
    use glam::{Affine3A, Mat3A, Vec3, Vec3A};
    use std::sync::Arc;

    const WHITE: Vec3 = Vec3::ONE;

    /// A box with `f` of texel coordinates in it, scaled about the origin, around a square across the eye's axis.
    fn scene(scale: f32, f: impl Fn(Vec3) -> f32) -> Scene {
        const SIZE: [u32; 3] = [8, 8, 16];
        let voxel = 0.25 * scale;
        let place = Affine3A {
            matrix3: Mat3A::from_diagonal(Vec3::splat(voxel)),
            translation: Vec3A::new(-4.0, -4.0, -8.0) * voxel,
        };
        let at = |i: u32| Vec3::new((i % 8) as f32, (i / 8 % 8) as f32, (i / 64) as f32) + 0.5;
        let volume = Volume::new(SIZE, (0..1024).map(|i| f(at(i))).collect(), place).unwrap();
        // A small square in the middle of the picture and of the box.
        let corners = [(0.2, -0.5), (0.8, -0.5), (0.8, 0.5), (0.2, 0.5)];
        let positions = corners.map(|(x, y)| scale * Vec3::new(x, y, 0.0)).to_vec();
        let triangle = |positions| Triangle { positions, ..Triangle::default() };
        let triangles = vec![triangle([0, 1, 2]), triangle([0, 2, 3])];
        let mut scene = Scene::new(Mesh { positions, normals: vec![Vec3::Z], triangles, ..Mesh::default() }).unwrap();
        scene.set_volume(Some(Arc::new(volume)));
        scene
    }

    /// Parallel rays along the z axis, before a white background.
    fn settings(volume: VolumeView) -> Settings {
        Settings {
            size: Size { width: 41, height: 31 },
            supersampling: 1,
            camera: Camera { yaw: 0.0, pitch: 0.0, projection: Projection::Orthographic, ..Camera::default() },
            background: Background { top: Colour::WHITE, bottom: Colour::WHITE },
            shading: Shading::Normals,
            volume: Some(volume),
            ..Settings::default()
        }
    }

    /// One colour and opacity everywhere.
    fn mist(opacity: f32) -> VolumeView {
        let point = ControlPoint { at: 0.5, colour: Colour::hex(0), opacity };
        VolumeView { transfer: Transfer::Points(vec![point]), ..VolumeView::default() }
    }

    #[test]
    fn opacity_of_a_homogeneous_medium_does_not_depend_on_the_step() {
        let scene = scene(1.0, |_| 1.0);
        // A box of 2 × 2 × 4 has a diagonal of √24, and rays of the length 4.
        let left = |opacity: f32, length: f32| (1.0 - opacity).powf(length * 100.0 / 24f32.sqrt());
        for (opacity, density) in [(0.01, 1.0), (0.005, 3.0), (0.3, 0.01)] {
            for step in [0.05, 0.37, 1.0, 10.0] {
                let image = render(&scene, &settings(VolumeView { density, step, ..mist(opacity) }));
                let expected = pixel_from_linear(left(opacity, 4.0 * density) * WHITE);
                let found = image.get_pixel(5, 15).0;
                assert!(found[0].abs_diff(expected[0]) <= 1, "{opacity} {step}: {found:?} {expected:?}");
                // The square's normal is the colour (½, ½, 1), encoded, half-way through the box.
                let behind = Vec3::new(0.5, 0.5, 1.0).map(crate::colour::linear_from_srgb);
                let expected = pixel_from_linear(left(opacity, 2.0 * density) * behind);
                let found = image.get_pixel(20, 15).0;
                assert!((0..3).all(|c| found[c].abs_diff(expected[c]) <= 1), "{step}: {found:?} {expected:?}");
            }
        }
    }

    #[test]
    fn what_is_clear_leaves_the_picture_as_it_is() {
        let scene = scene(1.0, |p| p.x);
        let clear = render(&scene, &settings(mist(0.0)));
        assert_eq!(clear, render(&scene, &Settings { volume: None, ..settings(mist(0.0)) }));
        assert_ne!(clear, render(&scene, &settings(mist(0.2))));
    }

    #[test]
    fn a_slice_has_the_colours_of_its_values_and_hides_what_is_behind() {
        // The value is the share of the box along z.
        let scene = scene(1.0, |p| p.z / 16.0);
        let point = |at: f32, colour: u32| ControlPoint { at, colour: Colour::hex(colour), opacity: 0.0 };
        let transfer = Transfer::Points(vec![point(0.0, 0xff_00_00), point(1.0, 0x00_00_ff)]);
        for (share, shows_the_square) in [(0.75, false), (0.25, true)] {
            for display in [VolumeDisplay::Slices, VolumeDisplay::Rays] {
                let slices = [None, None, Some(share)];
                let view = VolumeView { transfer: transfer.clone(), slices, display, ..VolumeView::default() };
                let range = crate::settings::Range { low: 0.0, high: 1.0 };
                let image = render(&scene, &settings(VolumeView { range: Some(range), ..view }));
                let expected = pixel_from_linear(Vec3::new(1.0 - share, 0.0, share));
                assert_eq!(image.get_pixel(5, 15).0[..3], expected, "{share} {display:?}");
                assert_eq!(image.get_pixel(20, 15).0[..3] != expected, shows_the_square, "{share} {display:?}");
            }
        }
    }

    #[test]
    fn a_part_of_the_box_is_as_thick_as_it_is() {
        let scene = scene(1.0, |_| 1.0);
        let half = VolumeView { low: [0.0, 0.0, 0.25], high: [1.0, 1.0, 0.75], ..mist(0.02) };
        let found = render(&scene, &settings(half)).get_pixel(5, 15).0;
        assert_eq!(found, render(&scene, &settings(VolumeView { density: 0.5, ..mist(0.02) })).get_pixel(5, 15).0);
    }

    #[test]
    fn same_bits_in_any_unit_and_on_any_number_of_threads() {
        let view = VolumeView { transfer: Transfer::Preset(TransferPreset::Bone), ..VolumeView::default() };
        let draw = |scale: f32, projection| {
            let camera = Camera { projection, ..Camera::default() };
            render(
                &scene(scale, |p| (p.x * 0.9).sin() + (p.y * p.z * 0.1).cos()),
                &Settings { camera, ..settings(view.clone()) },
            )
        };
        for projection in [Projection::default(), Projection::Orthographic] {
            let expected = draw(1.0, projection);
            // Powers of two, with which rounding commutes.
            assert!([-20, 20].iter().all(|&k| draw(2f32.powi(k), projection) == expected), "{projection:?}");
            let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
            assert!(pool.install(|| draw(1.0, projection)) == expected, "{projection:?}");
        }
    }
}
