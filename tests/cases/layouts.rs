//! How exact each layout is, on the meshes of the repository and on those that `PLANISH_MESHES` names.

use crate::support::{Read, bake, heights, keeps_its_promises, meshes_from_outside, meshes_in, model, root};
use planish_geometry::bake::{BakeSettings, Carriers, LayoutChoice};
use planish_geometry::denoise::{Denoiser, Laplacian};
use planish_geometry::map::displacement::{TexelFormat, Weights};
use planish_geometry::map::manifest::Layout;
use planish_geometry::mesh::weld::Welding;
use planish_geometry::source::model::Model;
use std::path::Path;

fn settings(layout: LayoutChoice, texel: TexelFormat) -> BakeSettings {
    // How the heights came about does not matter here; these take no time.
    let target = Denoiser::Laplacian(Laplacian::default()).into();
    BakeSettings { target, layout, texel, carriers: Carriers::Obj, ..BakeSettings::default() }
}

/// Largest difference between the texel of a `v` line, found by its number, and the height of its vertex.
fn off_by(read: &Read, model: &Model, heights: &[f64]) -> f64 {
    let entry = &read.manifest.displacement;
    let texels = &read.map.planes()[0];
    let off = model.weld().vertex_of().iter().enumerate().map(|(line, &v)| {
        let (column, row) = (line % entry.width as usize, line / entry.width as usize);
        let texel = f64::from(texels[row * entry.width as usize + column]);
        (entry.bias + entry.scale * texel - heights[v as usize]).abs()
    });
    off.fold(0.0, f64::max)
}

#[test]
fn a_texel_for_each_vertex_is_exact_on_own_meshes() {
    a_texel_for_each_vertex_is_exact(&root().join("data"));
}

#[test]
#[ignore = "needs PLANISH_MESHES"]
fn a_texel_for_each_vertex_is_exact_on_external_meshes() {
    a_texel_for_each_vertex_is_exact(&meshes_from_outside());
}

/// Asserts it for every mesh of a folder that is not clean.
#[track_caller]
fn a_texel_for_each_vertex_is_exact(folder: &Path) {
    let meshes = meshes_in(folder);
    let noisy: Vec<_> = meshes.iter().filter(|path| !path.to_string_lossy().contains("clean")).collect();
    assert!(!noisy.is_empty(), "{} has no meshes", folder.display());
    for path in noisy {
        let model = model(std::fs::read(path).unwrap(), Welding::Exact);
        for texel in [TexelFormat::Png8, TexelFormat::Png16, TexelFormat::Exr32] {
            let settings = settings(LayoutChoice::Vertex, texel);
            let read = keeps_its_promises(&model, &settings, &bake(&model, &settings));
            let entry = &read.manifest.displacement;
            let (lines, side) = (model.data().positions().len(), entry.width);
            assert!(side == entry.height && side.is_power_of_two());
            assert!((side / 2).pow(2) < lines as u32 && lines as u32 <= side.pow(2));

            let (heights, _) = heights(&model, &settings);
            // Half a quantum, and what rounding the texel and its height to single precision costs.
            let ulp = f64::from(f32::EPSILON) / 2.0 * (entry.scale + heights.iter().fold(0.0, |m, h| h.abs().max(m)));
            let bound = entry.encoding().quantum() / 2.0 + ulp;
            let off = off_by(&read, &model, &heights);
            assert!(off <= bound, "{}, {texel}: {off:e} > {bound:e}", path.display());

            // Of the places as well: p and the sum are rounded, by half a unit in the last place along each axis.
            let report = &read.manifest.report;
            let coordinate = report.error_bound - report.max_error;
            let bound = bound + 3f64.sqrt() * coordinate;
            assert!(report.max_error <= bound, "{}, {texel}: {:e} > {bound:e}", path.display(), report.max_error);
            assert_eq!((report.seam_gap, report.unresolved_vertices), (0.0, 0));
            assert_eq!(report.eight_bit_weights.max_error, report.max_error, "{}", path.display());
        }
    }
}

#[test]
#[ignore = "needs PLANISH_MESHES"]
fn the_texture_coordinates_of_spot_hold_all_its_heights() {
    let folder = meshes_from_outside();
    let model = model(std::fs::read(folder.join("spot_n0.2_noisy.obj")).unwrap(), Welding::Exact);
    for side in [512, 1024, 2048] {
        let settings = BakeSettings { side: Some(side), ..settings(LayoutChoice::Uv, TexelFormat::Png16) };
        let read = keeps_its_promises(&model, &settings, &bake(&model, &settings));
        let report = &read.manifest.report;
        assert!(report.max_error_quanta <= Some(1.0), "{report:?}");
        assert!(report.p99_error_quanta <= Some(0.75), "{report:?}");
        let own = report.own_uvs.as_ref().unwrap();
        assert_eq!(own.seam_vertices, 277);
        assert!(side < 1024 || own.bit_equal_seam_vertices >= 250, "{own:?}");
    }
    let chosen = bake(&model, &settings(LayoutChoice::Auto, TexelFormat::Png16));
    assert_eq!((chosen.manifest.displacement.layout, chosen.fallback), (Layout::Uv, None));
    // 512 holds all vertices, but not at each of their texture coordinates: clients that know no others would tear it.
    assert_eq!(chosen.manifest.displacement.width, 2048);
    let gap = chosen.manifest.report.own_uvs.as_ref().unwrap().seam_gap;
    assert!(gap <= 2.0 * chosen.manifest.report.quantum, "{gap:e}");
    let smaller = BakeSettings { side: Some(256), ..settings(LayoutChoice::Uv, TexelFormat::Png16) };
    assert!(bake(&model, &smaller).manifest.report.unresolved_vertices > 0);
}

#[test]
#[ignore = "needs PLANISH_MESHES"]
fn layouts_that_cannot_hold_the_heights_have_private_texels() {
    let folder = meshes_from_outside();
    for name in ["boat_n0.2_noisy.obj", "scans/leeperrysmith.obj", "scans/esp32cam_meshroom.obj"] {
        let model = model(std::fs::read(folder.join(name)).unwrap(), Welding::Exact);
        let automatic = settings(LayoutChoice::Auto, TexelFormat::Png16);
        let bundle = bake(&model, &automatic);
        assert_eq!((bundle.manifest.displacement.layout, &bundle.fallback), (Layout::Uv, &None), "{name}");
        let report = keeps_its_promises(&model, &automatic, &bundle).manifest.report;
        assert_eq!(report.unresolved_vertices, 0, "{name}");
        // Where charts overlap, vertices that are not crowded read the texels of other charts.
        let layout = &report.layout;
        let most = if layout.overlapping_texels > 0 { usize::MAX } else { layout.crowded_vertices };
        assert!((1..=most).contains(&report.private_vertices), "{name}: {report:?}");

        let insisted = BakeSettings { side: Some(512), ..settings(LayoutChoice::Uv, TexelFormat::Png16) };
        let read = keeps_its_promises(&model, &insisted, &bake(&model, &insisted));
        let report = &read.manifest.report;
        assert!(report.unresolved_vertices > 0 && report.map_errors.max_quanta > Some(100.0), "{name}: {report:?}");
        assert!(report.suggestion.is_some(), "{name}");
    }
}

#[test]
fn sampling_a_texel_and_its_number_are_the_same() {
    let path = root().join("data/flange_noisy.obj");
    let model = model(std::fs::read(path).unwrap(), Welding::Exact);
    let read = Read::new(&bake(&model, &settings(LayoutChoice::Vertex, TexelFormat::Tiff16)));
    let size = read.map.size();
    for line in 0..model.data().positions().len() as u32 {
        use planish_geometry::map::displacement::SampleAt;
        use planish_geometry::map::per_vertex;
        let height = |place| read.map.height_at(place, Weights::Exact).to_bits();
        assert_eq!(height(SampleAt::Texel(line)), height(SampleAt::Uv(per_vertex::uv(line, size))));
    }
}
