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

    /// Colour of the volume at a place in the scene, linear RGB.
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

    /// What a ray sees of the volume before a colour at its end, front to back.
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
