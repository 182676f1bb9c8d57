//! Rust twins of the structs in `shaders/`: the same names, fields and order, which a test holds together.

use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Vec2, Vec3, Vec4};

/// Twin of `struct Frame`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Frame {
    pub(crate) clip_from_world: Mat4,
    pub(crate) world_from_clip: Mat4,
    pub(crate) world_from_view: Mat4,
    pub(crate) eye: Vec4,
    pub(crate) up: Vec3,
    pub(crate) radius: f32,
    pub(crate) centre: Vec3,
    pub(crate) shading: u32,
    pub(crate) viewport: Vec2,
    pub(crate) supersampling: f32,
    pub(crate) normals: u32,
}

/// Twin of `struct Light`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Light {
    pub(crate) place: Vec4,
    pub(crate) radiance: Vec3,
    pub(crate) nominal: f32,
    pub(crate) axis: Vec3,
    pub(crate) cone_inner: f32,
    pub(crate) cone_outer: f32,
    pub(crate) shadow: i32,
    pub(crate) _pad: Vec2,
}

/// Twin of `struct Lights`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Lights {
    pub(crate) lights: [Light; crate::lights::MAX_LIGHTS],
    pub(crate) sky: Vec3,
    pub(crate) count: u32,
    pub(crate) ground: Vec3,
    pub(crate) _pad: f32,
}

/// Twin of `struct Material`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Material {
    pub(crate) colour: Vec3,
    pub(crate) specular: f32,
    pub(crate) vein: Vec3,
    pub(crate) exponent: f32,
    pub(crate) checker_light: Vec3,
    pub(crate) checker_squares: f32,
    pub(crate) checker_dark: Vec3,
    pub(crate) noise_frequency: f32,
    pub(crate) relief_lambda: f32,
    pub(crate) relief_bias: f32,
    pub(crate) relief_scale: f32,
    pub(crate) relief_bump: f32,
    pub(crate) heat_low: f32,
    pub(crate) heat_high: f32,
    pub(crate) heat_relief: f32,
    pub(crate) heat_samples: u32,
    pub(crate) heat_colours: [Vec4; 17],
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

/// Twin of `struct Pictures`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Pictures {
    pub(crate) has_colour: u32,
    pub(crate) has_normals: u32,
    pub(crate) has_relief: u32,
    pub(crate) filter_mode: u32,
}

/// Twin of `struct Background`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Background {
    pub(crate) top: Vec4,
    pub(crate) bottom: Vec4,
}

/// Twin of `struct Resolve`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Resolve {
    pub(crate) supersampling: u32,
    pub(crate) encode: u32,
    pub(crate) _pad0: u32,
    pub(crate) _pad1: u32,
}

/// Twin of `struct Overlay`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Overlay {
    pub(crate) wireframe: Vec4,
    pub(crate) seams: Vec4,
    pub(crate) width: f32,
    pub(crate) _pad0: f32,
    pub(crate) _pad1: f32,
    pub(crate) _pad2: f32,
}

/// Twin of `struct Legend`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Legend {
    pub(crate) width: f32,
    pub(crate) height: f32,
    pub(crate) decode: u32,
    pub(crate) _pad: u32,
}

/// Twin of `struct Wedge`: a vertex of the GPU, as far as displacing needs it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct Wedge {
    pub(crate) position: Vec3,
    pub(crate) texel: u32,
    pub(crate) normal: Vec3,
    pub(crate) vertex: u32,
    pub(crate) dominant_uv: Vec2,
    pub(crate) uv: Vec2,
    pub(crate) axis: Vec4,
}

/// Twin of `struct Surfel`: what only shading needs.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct Surfel {
    pub(crate) tangent: Vec4,
    pub(crate) stretch: Vec2,
    pub(crate) scalar: Vec2,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shaders::{Program, tests::module};

    /// Asserts that the WGSL struct has these members at these offsets, and this size.
    macro_rules! assert_layout {
        ($program:expr, $ty:ident { $($field:ident),+ $(,)? }) => {{
            let module = module($program);
            let found = module.types.iter().find_map(|(_, t)| match (&t.name, &t.inner) {
                (Some(name), naga::TypeInner::Struct { members, span }) if name == stringify!($ty) => {
                    let members = members.iter().map(|m| (m.name.clone().unwrap(), m.offset));
                    Some((members.collect::<Vec<_>>(), *span))
                }
                _ => None,
            });
            let expected = vec![$((stringify!($field).to_owned(), std::mem::offset_of!($ty, $field) as u32)),+];
            assert_eq!(found, Some((expected, size_of::<$ty>() as u32)), "layout of {}", stringify!($ty));
        }};
    }

    #[test]
    fn layouts_are_those_of_the_shaders() {
        assert_layout!(
            Program::Mesh,
            Frame {
                clip_from_world,
                world_from_clip,
                world_from_view,
                eye,
                up,
                radius,
                centre,
                shading,
                viewport,
                supersampling,
                normals
            }
        );
        assert_layout!(
            Program::Mesh,
            Light { place, radiance, nominal, axis, cone_inner, cone_outer, shadow, _pad }
        );
        assert_layout!(Program::Mesh, Lights { lights, sky, count, ground, _pad });
        assert_layout!(
            Program::Mesh,
            Material {
                colour,
                specular,
                vein,
                exponent,
                checker_light,
                checker_squares,
                checker_dark,
                noise_frequency,
                relief_lambda,
                relief_bias,
                relief_scale,
                relief_bump,
                heat_low,
                heat_high,
                heat_relief,
                heat_samples,
                heat_colours
            }
        );
        assert_layout!(Program::Mesh, Displacement { bias, scale, lambda, kind });
        assert_layout!(Program::Mesh, Pictures { has_colour, has_normals, has_relief, filter_mode });
        assert_layout!(Program::Mesh, Wedge { position, texel, normal, vertex, dominant_uv, uv, axis });
        assert_layout!(Program::Mesh, Surfel { tangent, stretch, scalar });
        assert_layout!(Program::Background, Background { top, bottom });
        assert_layout!(Program::Overlay, Overlay { wireframe, seams, width, _pad0, _pad1, _pad2 });
        assert_layout!(Program::Legend, Legend { width, height, decode, _pad });
        assert_layout!(Program::Resolve, Resolve { supersampling, encode, _pad0, _pad1 });
    }
}
