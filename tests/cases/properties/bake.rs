//! What is baked comes back.

use super::{cases, finite};
use crate::support::{bake, heights, keeps_its_promises, model, obj_text, sampled};
use glam::{DVec2, DVec3};
use planish_geometry::bake::{BakeSettings, Lambda, LayoutChoice};
use planish_geometry::denoise::{Denoiser, Laplacian, NormalField};
use planish_geometry::map::displacement::{Encoding, TexelFormat};
use planish_geometry::map::{Interpolation, Texels};
use planish_geometry::mesh::weld::Welding;
use planish_geometry::source::model::NormalSource;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;

/// A rough sheet of squares, its layout shaken but not folded, with a margin all around. Where it is `cut`, its columns
/// lie apart in the texture.
fn sheet() -> impl Strategy<Value = String> {
    (2..7_usize, 2..7_usize, any::<bool>(), any::<bool>()).prop_flat_map(|(columns, rows, cut, far)| {
        let points = (columns + 1) * (rows + 1);
        let shake = || vec([-0.3..0.3, -0.3..0.3, -0.3..0.3].prop_map(DVec3::from), points);
        (shake(), shake()).prop_map(move |(bumps, shifts)| {
            let at = |i: usize, j: usize| j * (columns + 1) + i;
            let origin = if far { DVec3::new(500_000.0, 4_500_000.0, 120.0) } else { DVec3::ZERO };
            let mut positions = Vec::new();
            for (k, bump) in bumps.iter().enumerate() {
                positions
                    .push(origin + DVec3::new((k % (columns + 1)) as f64, (k / (columns + 1)) as f64, 0.0) + *bump);
            }
            let (mut uvs, mut faces) = (Vec::new(), Vec::new());
            for j in 0..rows {
                for i in 0..columns {
                    let first = uvs.len();
                    let square = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
                    for (x, y) in square {
                        let gap = if cut { i as f64 } else { 0.0 };
                        let place = DVec2::new(x as f64 + gap, y as f64) + shifts[at(x, y)].truncate();
                        let room = DVec2::new(if cut { 2 * columns - 1 } else { columns } as f64, rows as f64);
                        uvs.push(0.1 + 0.8 * (place + 0.3) / (room + 0.6));
                    }
                    faces.push((0..4).map(|k| (at(square[k].0, square[k].1), Some(first + k))).collect());
                }
            }
            obj_text(&positions, &uvs, &faces)
        })
    })
}

fn settings() -> impl Strategy<Value = BakeSettings> {
    let interpolations =
        vec![Interpolation::Barycentric, Interpolation::Natural, Interpolation::Idw, Interpolation::Nearest];
    let formats = TexelFormat::ALL.to_vec();
    let layouts = vec![LayoutChoice::Auto, LayoutChoice::Uv, LayoutChoice::Vertex];
    let normals = vec![
        NormalField::Source(NormalSource::Uniform),
        NormalField::Source(NormalSource::Area),
        NormalField::Source(NormalSource::Angle),
        NormalField::Denoised,
        NormalField::Tilted,
    ];
    let texels = vec![Texels::Fitted, Texels::Interpolated];
    (1..70_u32, select(interpolations), select(texels), select(formats), select(layouts), select(normals), 1..4_u32)
        .prop_map(|(side, interpolation, texels, texel, layout, normals, iterations)| BakeSettings {
            target: Denoiser::Laplacian(Laplacian { iterations, step: 1.0, ..Laplacian::default() }).into(),
            lambda: Lambda(0.7),
            side: Some(side),
            interpolation,
            texels,
            texel,
            layout,
            normals: Some(normals),
            ..BakeSettings::default()
        })
}

/// The exact sum of two numbers as its nearest f64 and what is missing to it (Knuth 1969).
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_part = sum - a;
    (sum, (a - (sum - b_part)) + (b - b_part))
}

proptest! {
    #![proptest_config(cases(60))]

    #[test]
    fn no_vertex_is_farther_off_than_the_report_says(text in sheet(), settings in settings()) {
        let model = model(text, Welding::Exact);
        let read = keeps_its_promises(&model, &settings, &bake(&model, &settings));
        let (heights, _) = heights(&model, &settings);
        let low = heights.iter().copied().fold(f64::INFINITY, f64::min);
        let high = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        // A fit may leave the range of the heights by a quarter of it, so that samples between texels can reach it.
        let headroom = if settings.texels == Texels::Fitted { 0.25 * (high - low) } else { 0.0 };
        // Bias and scale are rounded outwards by an ulp each, and three mixes and a product and a sum follow, each
        // good to half an ulp of what is not larger than |bias| + scale.
        let rounding = 8.0 * f64::from(f32::EPSILON) * (low.abs() + (high - low)) + headroom;
        for height in sampled(&read).map(f64::from) {
            prop_assert!((low - rounding..=high + rounding).contains(&height), "{height} not in {low}..={high}");
        }
    }
}

proptest! {
    #![proptest_config(cases(2000))]

    #[test]
    fn an_encoding_covers_its_range_and_little_more(a in finite(), b in finite(), near in 0.0..1.0, mode in 0..3) {
        // Of the size of meshes, squeezed from all of f64; ends alike, or far apart in magnitude.
        let tame = |x: f64| x.signum() * x.abs().powf(0.05);
        let (a, b) = match mode {
            0 => (tame(a), tame(b)),
            1 => (tame(a), tame(a) * (1.0 + 1e-9 * near)),
            _ => (tame(a), tame(b) * 1e-30),
        };
        let (low, high) = (a.min(b), a.max(b));
        let Encoding { bias, scale, .. } = Encoding::covering(low, high, TexelFormat::Png16);
        let (bias, scale) = (f64::from(bias), f64::from(scale));
        let (top, missing) = two_sum(bias, scale);
        prop_assert!(bias <= low && (top > high || top == high && missing >= 0.0), "{bias:e} {scale:e}");
        // Two ulps of single precision for bias, two for scale; below 1e-38 steps are no longer relative.
        let ulp = f64::from(f32::EPSILON);
        prop_assert!(scale <= (high - low) * (1.0 + 2.0 * ulp) + 2.0 * ulp * low.abs() + 1e-44);
    }
}

#[test]
fn a_face_that_is_left_out_stays_with_its_neighbours() {
    // The third face is a second layer and the fourth one has no area; both name places of their own in the texture.
    let text = "\
v 0 0 0\nv 1 0 .3\nv 1 1 0\nv 0 1 .2\nv .5 .5 .4
vt .1 .1\nvt .9 .1\nvt .9 .9\nvt .1 .9\nvt .5 .5\nvt .2 .3\nvt .7 .4\nvt .4 .8
f 1/1 2/2 5/5\nf 2/2 3/3 5/5\nf 5/6 2/7 3/8\nf 5/8 5/7 1/6\nf 3/3 4/4 5/5\nf 4/4 1/1 5/5
";
    let model = model(text, Welding::Exact);
    assert_eq!((model.defects().duplicate_faces, model.defects().degenerate_faces), (1, 1));
    let settings = BakeSettings { side: Some(16), ..BakeSettings::default() };
    keeps_its_promises(&model, &settings, &bake(&model, &settings));
}
