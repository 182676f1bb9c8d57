//! Bakes of one mesh, one after the other.

use super::*;
use crate::denoise::limits::Limits;
use crate::denoise::{Denoising, LastResult, Taubin};
use crate::progress::Progress;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Counts how often a method was run.
#[derive(Default)]
struct Denoisings(AtomicUsize);

impl Progress for Denoisings {
    fn stage(&self, name: &'static str) {
        if name == "denoising" {
            self.0.fetch_add(1, Ordering::Relaxed);
        }
    }
}

#[test]
fn a_method_is_run_once_for_maps_and_limits_of_all_kinds() {
    let model = Model::new(as_obj(&sheet()), Welding::Exact);
    let names = BundleNames { source: "sheet".to_owned(), stem: "sheet".to_owned(), carrier: "sheet".to_owned() };
    let last_result = LastResult::remembered();
    let laplacian = || Denoiser::Laplacian(Laplacian::default());
    let within = |most| Limits { max_displacement: Some(most), ..Limits::default() };
    let of = |denoiser, limits| BakeSettings { target: BakeTarget::Method(Denoising { denoiser, limits }), ..small() };
    let rounds = [
        (1, of(laplacian(), Limits::default())),
        (0, of(laplacian(), within(0.1))),
        (0, of(laplacian(), within(0.05))),
        (0, BakeSettings { texel: TexelFormat::Png8, ..of(laplacian(), Limits::default()) }),
        (0, BakeSettings { map: MapKind::VectorObject, ..of(laplacian(), Limits::default()) }),
        (1, of(Denoiser::Taubin(Taubin::default()), Limits::default())),
        (1, of(laplacian(), Limits::default())),
    ];
    for (k, (expected, settings)) in rounds.into_iter().enumerate() {
        let denoisings = Denoisings::default();
        let remembering = BakeSettings { last_result: last_result.clone(), ..settings.clone() };
        let again = bake(&model, &names, SideFiles::NONE, &remembering, &denoisings).unwrap();
        assert_eq!(denoisings.0.into_inner(), expected, "bake {k}");
        assert!(again == bake_of(&model, &settings), "bake {k}");
    }
}

#[test]
fn what_is_remembered_of_another_mesh_is_not_used() {
    let model = Model::new(as_obj(&sheet()), Welding::Exact);
    let mut other = sheet();
    other.positions[7].z += 0.125;
    let other = Model::new(as_obj(&other), Welding::Exact);
    let settings = BakeSettings { target: Denoiser::Laplacian(Laplacian::default()).into(), ..small() };
    let remembering = BakeSettings { last_result: LastResult::remembered(), ..settings.clone() };
    for model in [&model, &other, &model] {
        assert!(bake_of(model, &remembering) == bake_of(model, &settings));
    }
}
