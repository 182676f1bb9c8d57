//! Twins of the structures in `shaders/`, byte for byte.

use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Vec2, Vec3, Vec4};

/// Twin of `struct Light`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Light {
    pub(crate) place: Vec4,
    pub(crate) radiance: Vec3,
    pub(crate) cos_outer: f32,
    pub(crate) axis: Vec3,
    pub(crate) cos_inner: f32,
}

/// Twin of `struct Frame`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Frame {
    pub(crate) clip_from_world: Mat4,
    pub(crate) world_from_view: Mat4,
    pub(crate) eye_in_world: Vec4,
    pub(crate) up_in_world: Vec3,
    pub(crate) light_count: u32,
    pub(crate) sky: Vec3,
    pub(crate) specular: f32,
    pub(crate) ground: Vec3,
    pub(crate) exponent: f32,
    pub(crate) base_colour: Vec3,
    pub(crate) line_width: f32,
    pub(crate) checker_light: Vec3,
    pub(crate) checker_squares: f32,
    pub(crate) checker_dark: Vec3,
    pub(crate) normal_strength: f32,
    pub(crate) background_top: Vec3,
    pub(crate) has_heat: u32,
    pub(crate) background_bottom: Vec3,
    pub(crate) has: u32,
    pub(crate) heat_low: f32,
    pub(crate) heat_high: f32,
    pub(crate) heat_relief: f32,
    pub(crate) vein_frequency: f32,
    pub(crate) vein_colour: Vec3,
    pub(crate) occlusion: f32,
    pub(crate) lights: [Light; crate::settings::lights::MAX_LIGHTS],
}

/// Twin of `struct Displacement`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Displacement {
    pub(crate) bias: f32,
    pub(crate) scale: f32,
    pub(crate) lambda: f32,
    pub(crate) kind: u32,
}

/// Twin of `struct Vertex`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Vertex {
    pub(crate) position: Vec3,
    pub(crate) place: u32,
    pub(crate) normal: Vec3,
    pub(crate) texel: u32,
}

/// Twin of `struct Extra`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Extra {
    pub(crate) tangent: Vec4,
    pub(crate) uv: Vec2,
    pub(crate) number: f32,
    pub(crate) has_number: f32,
}

/// Twin of `struct Wedge`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct Wedge {
    pub(crate) normal: Vec3,
    pub(crate) vertex: u32,
    pub(crate) tangent: Vec4,
    pub(crate) uv: Vec2,
    pub(crate) has_uv: f32,
    pub(crate) open: f32,
}

/// Twin of `struct Eye`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Eye {
    pub(crate) clip_from_world: Mat4,
    pub(crate) world_from_clip: Mat4,
    pub(crate) near: f32,
    pub(crate) far: f32,
    pub(crate) half_width: f32,
    pub(crate) light_size: f32,
    pub(crate) parallel: f32,
    pub(crate) _pad_a: f32,
    pub(crate) _pad_b: f32,
    pub(crate) _pad_c: f32,
}

/// Twin of `struct Shadows`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Shadows {
    pub(crate) first_eye: [u32; 4],
    pub(crate) eye_count: [u32; 4],
    pub(crate) kernel: i32,
    pub(crate) slope_bias: f32,
    pub(crate) least_bias: f32,
    pub(crate) shown: u32,
    pub(crate) eyes: [Eye; crate::shadow::MAX_SHADOW_VIEWS],
}

/// Twin of `struct Caster`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Caster {
    pub(crate) clip_from_world: Mat4,
    pub(crate) moves: u32,
    pub(crate) _pad_a: u32,
    pub(crate) _pad_b: u32,
    pub(crate) _pad_c: u32,
}

/// Twin of `struct Environment`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Environment {
    pub(crate) environment_from_world: Mat4,
    pub(crate) rays: Mat4,
    pub(crate) irradiance: [Vec4; 9],
    pub(crate) intensity: f32,
    pub(crate) reflectance: f32,
    pub(crate) roughness: f32,
    pub(crate) roughest: f32,
    pub(crate) background: f32,
    pub(crate) blur: f32,
    pub(crate) ambient: f32,
    pub(crate) _pad: f32,
}

/// Twin of `struct Ground`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Ground {
    pub(crate) centre: Vec3,
    pub(crate) radius: f32,
    pub(crate) right: Vec3,
    pub(crate) catches: f32,
    pub(crate) ahead: Vec3,
    pub(crate) _pad: f32,
    pub(crate) colour: Vec3,
    pub(crate) _pad_b: f32,
}

/// Twin of `struct ControlPoint`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct ControlPoint {
    pub(crate) colour: Vec3,
    pub(crate) opacity: f32,
    pub(crate) at: f32,
    pub(crate) _pad_a: f32,
    pub(crate) _pad_b: f32,
    pub(crate) _pad_c: f32,
}

/// Twin of `struct Volume`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Volume {
    pub(crate) texel_from_world: Mat4,
    pub(crate) rays: Mat4,
    pub(crate) low: Vec3,
    pub(crate) step: f32,
    pub(crate) high: Vec3,
    pub(crate) density: f32,
    pub(crate) slices: Vec3,
    pub(crate) has_slices: u32,
    pub(crate) value_low: f32,
    pub(crate) value_scale: f32,
    pub(crate) lighting: f32,
    pub(crate) diagonal: f32,
    pub(crate) point_count: u32,
    pub(crate) _pad_a: u32,
    pub(crate) _pad_b: u32,
    pub(crate) _pad_c: u32,
    pub(crate) points: [ControlPoint; crate::settings::volume::MAX_POINTS],
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::shaders::{Program, Variant, source};
    use std::mem::offset_of;

    /// Asserts that the structure of a program has these members at these offsets, and this size.
    macro_rules! assert_layout {
        ($module:expr, $ty:ident { $($field:ident),+ $(,)? }) => {{
            let found = $module.types.iter().find_map(|(_, t)| match (&t.name, &t.inner) {
                (Some(name), naga::TypeInner::Struct { members, span }) if name == stringify!($ty) => {
                    Some((members.iter().map(|m| (m.name.clone().unwrap(), m.offset)).collect::<Vec<_>>(), *span))
                }
                _ => None,
            });
            let expected = vec![$((stringify!($field).to_owned(), offset_of!($ty, $field) as u32)),+];
            assert_eq!(found, Some((expected, size_of::<$ty>() as u32)), "layout of {}", stringify!($ty));
        }};
    }

    #[test]
    fn structures_are_those_of_the_shaders() {
        let module = naga::front::wgsl::parse_str(&source(Program::Mesh, Variant::default())).unwrap();
        assert_layout!(module, Light { place, radiance, cos_outer, axis, cos_inner });
        assert_layout!(module, Displacement { bias, scale, lambda, kind });
        assert_layout!(module, Vertex { position, place, normal, texel });
        assert_layout!(module, Extra { tangent, uv, number, has_number });
        assert_layout!(module, Wedge { normal, vertex, tangent, uv, has_uv, open });
        assert_layout!(
            module,
            Frame {
                clip_from_world,
                world_from_view,
                eye_in_world,
                up_in_world,
                light_count,
                sky,
                specular,
                ground,
                exponent,
                base_colour,
                line_width,
                checker_light,
                checker_squares,
                checker_dark,
                normal_strength,
                background_top,
                has_heat,
                background_bottom,
                has,
                heat_low,
                heat_high,
                heat_relief,
                vein_frequency,
                vein_colour,
                occlusion,
                lights
            }
        );
    }

    #[test]
    fn structures_of_light_are_those_of_the_shaders() {
        let parsed = |program| naga::front::wgsl::parse_str(&source(program, Variant::default())).unwrap();
        let ground = parsed(Program::Ground);
        assert_layout!(
            ground,
            Eye {
                clip_from_world,
                world_from_clip,
                near,
                far,
                half_width,
                light_size,
                parallel,
                _pad_a,
                _pad_b,
                _pad_c
            }
        );
        assert_layout!(ground, Shadows { first_eye, eye_count, kernel, slope_bias, least_bias, shown, eyes });
        assert_layout!(
            ground,
            Environment {
                environment_from_world,
                rays,
                irradiance,
                intensity,
                reflectance,
                roughness,
                roughest,
                background,
                blur,
                ambient,
                _pad
            }
        );
        assert_layout!(ground, Ground { centre, radius, right, catches, ahead, _pad, colour, _pad_b });
        assert_layout!(ground, ControlPoint { colour, opacity, at, _pad_a, _pad_b, _pad_c });
        assert_layout!(
            ground,
            Volume {
                texel_from_world,
                rays,
                low,
                step,
                high,
                density,
                slices,
                has_slices,
                value_low,
                value_scale,
                lighting,
                diagonal,
                point_count,
                _pad_a,
                _pad_b,
                _pad_c,
                points
            }
        );
        assert_layout!(parsed(Program::Shadow), Caster { clip_from_world, moves, _pad_a, _pad_b, _pad_c });
    }
}
