use super::reach;
use super::*;
use glam::DVec3;
use planish_geometry::denoise::limits::{Limits, WeightMask, Weights};
use planish_geometry::denoise::{BilateralNormals, Denoiser, Denoising, GuidedNormals, Hc, Laplacian, Sun, Taubin};
use planish_geometry::mesh::shapes;
use planish_geometry::mesh::synthetic_noise::{self, Direction, Noise};
use planish_geometry::mesh::weld::Welding;
use planish_geometry::progress::Silent;
use planish_geometry::source::model::Model;
use planish_geometry::source::obj::Obj;
use std::path::Path;

/// A noisy torus as an OBJ file whose vertices are shuffled, with seams where two source vertices have one place, a quad, and a vertex
/// that no face uses.
fn file() -> Vec<u8> {
    let clean = shapes::sphere(4);
    let noise = Noise { sigma: 0.2, direction: Direction::Random, share: 1.0, seed: 4 };
    let noisy = synthetic_noise::noisy(&clean, &noise);
    let count = noisy.positions().len();
    let shuffled = |v: usize| (v * 1009) % count;
    let mut lines = vec![String::new(); count];
    for (v, p) in noisy.positions().iter().enumerate() {
        lines[shuffled(v)] = format!("v {} {} {}\n", p.x, p.y, p.z);
    }
    let mut out = String::from("# head\n") + &lines.concat() + "v 9 9 9\n";
    let doubled = shuffled(7);
    out += &lines[doubled];
    for (f, face) in noisy.topology().faces().iter().enumerate() {
        let corner = |v: u32| match shuffled(v as usize) {
            v if v == doubled && f % 2 == 0 => count + 2,
            v => v + 1,
        };
        out += &format!("f {} {} {}\n", corner(face[0]), corner(face[1]), corner(face[2]));
    }
    out.into_bytes()
}

/// Takes all rounds of a job on all tiles, and returns the number of results in which tiles differ.
fn take_rounds(folder: &Path, tiles: usize, job: &Job) -> usize {
    let Some(rounds) = job.rounds() else { return 0 };
    let mut last = last_round(folder, job).unwrap();
    while last.round < rounds {
        for tile in (0..tiles).rev() {
            round(folder, tile, job, last, &Silent).unwrap();
        }
        assert_eq!(last_round(folder, job).unwrap(), last);
        last = end_round(folder, job, last, &Silent).unwrap();
    }
    last.different
}

/// Denoises a file in tiles, and returns the file that is written, and how well the tiles agree.
fn tiled(file: &[u8], tiles: usize, method: &Denoising, weights: Option<&[f32]>) -> (Vec<u8>, Borders) {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("mesh.obj"), file).unwrap();
    let cut = Cut { key: "a".to_owned(), tiles, welding: Welding::Exact };
    let plan = spread(&at("mesh.obj"), folder.path(), &cut, &Silent).unwrap();
    assert_eq!((plan.tiles.len(), plan.tiles.iter().sum::<usize>()), (tiles, plan.vertices));
    let mut job = Job {
        key: "b".to_owned(),
        method: method.clone(),
        halo: reach::rounds(method, None).map_or_else(|| reach::halo(method, None), |(halo, _)| halo),
        lengths: None,
        weights: weights.map(|weights| {
            std::fs::write(at("weights"), weights.iter().flat_map(|w| w.to_le_bytes()).collect::<Vec<u8>>()).unwrap();
            at("weights")
        }),
    };
    if job.needs_lengths() {
        (0..tiles).for_each(|tile| lengths(folder.path(), tile, &Silent).unwrap());
        job.lengths = Some(measure(folder.path()).unwrap());
    }
    assert_eq!(take_rounds(folder.path(), tiles, &job), 0);
    // The last tile first: they do not depend on each other.
    for tile in (0..tiles).rev() {
        let report = denoise(folder.path(), tile, &job, &Silent).unwrap();
        assert_eq!(denoise(folder.path(), tile, &job, &Silent).unwrap(), report);
    }
    let borders = merge(folder.path(), &job, &Silent).unwrap();
    write(&at("mesh.obj"), &at("out.obj"), folder.path(), &Silent).unwrap();
    (std::fs::read(at("out.obj")).unwrap(), borders)
}

fn whole(file: &[u8], method: &Denoising) -> Vec<u8> {
    let model = Model::new(Obj::parse(file.to_vec()).unwrap(), Welding::Exact);
    let moved = method.run(model.surface(), model.weld(), method.output(), &Silent).unwrap();
    let positions = model.weld().spread(&model.surface().moved_by(&moved.deltas));
    model.source().with_positions(&positions, None).unwrap()
}

#[test]
fn tiles_of_a_bounded_method_give_the_bits_of_the_whole_mesh() {
    let file = file();
    let short = |mut settings: Sun| {
        settings.vertex_update.iterations = 3;
        Denoiser::Sun(Sun { iterations: 3, ..settings })
    };
    let mut normals = BilateralNormals { iterations: 4, ..BilateralNormals::default() };
    normals.vertex_update.iterations = 3;
    let mut guided = GuidedNormals { iterations: 4, ..GuidedNormals::default() };
    guided.vertex_update.iterations = 3;
    for denoiser in [
        Denoiser::Laplacian(Laplacian::default()),
        Denoiser::Taubin(Taubin { iterations: 3, ..Taubin::default() }),
        Denoiser::Hc(Hc { iterations: 3, ..Hc::default() }),
        short(Sun::default()),
        Denoiser::BilateralNormals(normals),
        Denoiser::GuidedNormals(guided),
    ] {
        let method = Denoising::from(denoiser);
        let expected = whole(&file, &method);
        assert!(expected != file);
        for tiles in [1, 2, 9] {
            let (found, borders) = tiled(&file, tiles, &method, None);
            assert!(found == expected, "{} in {tiles} tiles: {borders:?}", method.denoiser.name());
            assert_eq!((borders.different, borders.vertices > 0), (0, tiles > 1));
        }
    }
}

#[test]
fn a_halo_that_is_too_narrow_shows_at_the_borders() {
    let file = file();
    let method = Denoising::from(Denoiser::Laplacian(Laplacian { iterations: 9, ..Laplacian::default() }));
    let narrow = Denoising::from(Denoiser::Laplacian(Laplacian { iterations: 1, ..Laplacian::default() }));
    let folder = tempfile::tempdir().unwrap();
    let mesh = folder.path().join("mesh.obj");
    std::fs::write(&mesh, file).unwrap();
    let cut = Cut { key: String::new(), tiles: 4, welding: Welding::Exact };
    spread(&mesh, folder.path(), &cut, &Silent).unwrap();
    let halo = reach::halo(&narrow, None);
    let job = Job { key: "b".to_owned(), method, halo, lengths: None, weights: None };
    assert!(merge(folder.path(), &job, &Silent).unwrap_err().to_string().contains("has not been denoised"));
    (0..4).for_each(|tile| drop(denoise(folder.path(), tile, &job, &Silent).unwrap()));
    let borders = merge(folder.path(), &job, &Silent).unwrap();
    assert!(borders.different > 0 && borders.gap > 0.0 && borders.jump == borders.gap, "{borders:?}");
}

#[test]
fn a_halo_that_is_too_narrow_for_a_round_shows_after_it() {
    let file = file();
    let method = Denoising::from(Denoiser::GuidedNormals(GuidedNormals { iterations: 2, ..GuidedNormals::default() }));
    let folder = tempfile::tempdir().unwrap();
    let mesh = folder.path().join("mesh.obj");
    std::fs::write(&mesh, file).unwrap();
    spread(&mesh, folder.path(), &Cut { key: String::new(), tiles: 4, welding: Welding::Exact }, &Silent).unwrap();
    (0..4).for_each(|tile| lengths(folder.path(), tile, &Silent).unwrap());
    let lengths = Some(measure(folder.path()).unwrap());
    let halo = reach::Halo { rings: 4, ..reach::rounds(&method, None).unwrap().0 };
    let job = Job { key: "b".to_owned(), method, halo, lengths, weights: None };
    assert!(take_rounds(folder.path(), 4, &job) > 0);
}

#[test]
fn limits_hold_in_tiles_as_in_the_whole_mesh() {
    let file = file();
    let count = Obj::parse(file.clone()).unwrap().data().positions().len();
    let weights: Vec<f32> = (0..count).map(|v| (v % 5) as f32 / 4.0).collect();
    let mut method = Denoising::from(Denoiser::Laplacian(Laplacian::default()));
    method.limits =
        Limits { max_displacement: Some(0.1), direction: Some("0,1,2".parse().unwrap()), ..Limits::default() };
    let mask = WeightMask { from: String::new(), weights: Weights::new(&weights) };
    let with_mask = Denoising { limits: Limits { mask: Some(mask), ..method.limits.clone() }, ..method.clone() };
    let (found, borders) = tiled(&file, 5, &method, Some(&weights));
    assert!(found == whole(&file, &with_mask) && found != whole(&file, &method), "{borders:?}");
}

#[test]
fn methods_that_look_far_are_blended_over_the_border() {
    let file = file();
    let method = Denoising::from(Denoiser::named("tgv-normals").unwrap());
    let halo = reach::halo(&method, None);
    assert!(!halo.is_bounded && reach::rounds(&method, None).is_none());
    let (found, borders) = tiled(&file, 4, &method, None);
    let positions = |file: &[u8]| Obj::parse(file.to_vec()).unwrap().data().positions().to_vec();
    let [found, expected] = [found, whole(&file, &method)].map(|file| positions(&file));
    let far = found.iter().zip(&expected).map(|(a, b): (&DVec3, &DVec3)| a.distance(*b)).fold(0.0, f64::max);
    let moved = positions(&file).iter().zip(&expected).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
    assert!(far < 0.2 * moved && borders.jump < 0.02 * moved, "{far} {moved} {borders:?}");
}

#[test]
fn what_is_wrong_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = folder.path().join("mesh.obj");
    std::fs::write(&mesh, "v 0 0 0\nv 1 0 0\nv 0 1 x\nf 1 2 3\n").unwrap();
    let cut = |tiles| Cut { key: String::new(), tiles, welding: Welding::Exact };
    let message = |path: &Path, cut: &Cut| spread(path, folder.path(), cut, &Silent).unwrap_err().to_string();
    assert!(message(&mesh, &cut(2)).ends_with("mesh.obj: line 3: `x` is not a number"));
    assert!(message(&mesh, &cut(0)).contains("1 to 400 tiles, not 0"));
    let near = Cut { welding: Welding::Epsilon(0.1), ..cut(1) };
    assert!(message(&mesh, &near).contains("are not welded across tiles"));
    assert!(Plan::read(folder.path()).unwrap().is_none());
}
