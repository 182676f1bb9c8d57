//! Manifests as JSON.

use super::{cases, finite};
use crate::support::{bake, model};
use glam::DVec3;
use planish_geometry::bake::BakeSettings;
use planish_geometry::denoise::{Boundary, Denoiser, EdgeWeights, Laplacian};
use planish_geometry::map::Interpolation;
use planish_geometry::map::displacement::TexelFormat;
use planish_geometry::map::manifest::{FileEntry, LARGEST_SIDE, Manifest, Method, Target};
use planish_geometry::mesh::weld::Welding;
use planish_geometry::source::model::NormalSource;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;

/// One that was baked.
fn baked() -> Manifest {
    let square = "v 0 0 0\nv 1 0 0\nv 1 1 1\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n";
    bake(&model(square, Welding::Exact), &BakeSettings { side: Some(4), ..BakeSettings::default() }).manifest
}

fn welding() -> impl Strategy<Value = Welding> {
    prop_oneof![Just(Welding::Exact), Just(Welding::None), finite().prop_map(Welding::Epsilon)]
}

fn method() -> impl Strategy<Value = Method> {
    let weights = select(&[EdgeWeights::Uniform, EdgeWeights::Cotangent][..]);
    let boundary = select(&[Boundary::Fixed, Boundary::Free][..]);
    let denoiser = (0..=100_000_u32, 0.0..=1.0, weights, boundary).prop_map(|(iterations, step, weights, boundary)| {
        Method::Denoiser(Denoiser::Laplacian(Laplacian { iterations, step, weights, boundary }).into())
    });
    let target = (".*", ".*").prop_map(|(file, sha256)| Method::Target(Target::new(file, sha256)));
    prop_oneof![denoiser, target]
}

proptest! {
    #![proptest_config(cases(300))]

    #[test]
    fn a_manifest_survives_json(
        names in vec(".*", 6),
        numbers in vec(finite(), 6),
        single in vec(any::<f32>(), 5),
        lambda in -1e3..1e3,
        [width, height] in [1..=LARGEST_SIDE, 1..=LARGEST_SIDE],
        pairs in vec([1..=u32::MAX, 1..=u32::MAX], 0..5),
        (method, welding) in (method(), welding()),
        texel in select(&TexelFormat::ALL[..]),
        normals in select(&[NormalSource::File, NormalSource::Uniform, NormalSource::Angle][..]),
        interpolation in select(&[Interpolation::Barycentric, Interpolation::Natural, Interpolation::Idw][..]),
    ) {
        // What a shader gets must fit its precision.
        let single: Vec<f64> = single.into_iter().map(|x| if x.is_finite() { x.into() } else { 1.5 }).collect();
        let mut manifest = baked();
        let Manifest { source, displacement, normal_map, carrier, report, clients, .. } = &mut manifest;
        let mut name = names.into_iter();
        let normal_map = normal_map.as_mut().expect("it has one");
        for field in [&mut source.file, &mut displacement.file, &mut normal_map.file, &mut carrier.obj, &mut carrier.mtl] {
            *field = name.next().expect("there are six");
        }
        source.vertices = u32::MAX as usize;
        (displacement.width, displacement.height, displacement.texel) = (width, height, texel);
        (displacement.bias, displacement.scale, displacement.lambda) = (single[0], single[1].abs(), lambda);
        displacement.origin = DVec3::from_slice(&single[2..]);
        displacement.interpolation = Some(interpolation);
        (report.max_error, report.p99_error, report.mean_error) = (numbers[0], numbers[1], numbers[2]);
        report.layout.smallest_distance = (numbers[3] > 0.0).then_some(numbers[3]);
        clients.blender.as_mut().expect("heights").mid_level = numbers[4];
        clients.mtl.as_mut().expect("heights").base = numbers[5];
        let dominant_uv = manifest.dominant_uv.as_mut().expect("it has the layout of the texture");
        dominant_uv.rule = name.next().expect("there are six");
        dominant_uv.seam_vertices = pairs;
        (manifest.method, manifest.welding, manifest.normals) = (method, welding, normals.into());
        let entry = |file: &str| FileEntry { file: file.to_owned(), sha256: file.to_owned() };
        manifest.files = manifest.file_names().into_iter().map(entry).collect();
        let json = manifest.to_json();
        let read = Manifest::from_json(json.as_bytes());
        prop_assert_eq!(read.as_ref(), Ok(&manifest), "{}", json);
        // Equal numbers may still differ in the sign of a zero; equal text may not.
        prop_assert_eq!(read.expect("it just did").to_json(), json);
    }
}
