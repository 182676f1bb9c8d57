//! Paints on a ball as the window does.

use super::super::tests::Bench;
use super::super::vertex_numbers::Quantity;
use super::super::{App, MessageKind, Work};
use super::Effect;
use glam::DVec3;
use planish_files::mask::MaskOption;
use planish_geometry::denoise::Denoiser;
use std::fs;

/// A ball with its map that can be painted on.
fn prepared() -> Bench {
    let mut bench = Bench::baked();
    bench.app.switch_brush();
    bench.tick();
    bench.until("prepared", |app| app.status(Work::Prepare).is_none());
    bench.app.brush.radius = 0.5;
    bench
}

/// Paints from one side of the ball to another, as seen from above.
fn stroke(app: &mut App, ends: [[f64; 2]; 2], effect: Effect) {
    for [x, y] in ends {
        let hit = app.pick(DVec3::new(x, y, 9.0), DVec3::NEG_Z).unwrap();
        assert!(hit.point.z > 0.0 && hit.normal.z > 0.0, "the side that is seen");
        app.paint(&hit, effect);
    }
    app.end_stroke();
}

fn weights(app: &App) -> Vec<f32> {
    app.mask_weights().unwrap().to_vec()
}

#[test]
fn a_stroke_protects_what_is_near_it_and_can_be_undone() {
    let mut bench = prepared();
    stroke(&mut bench.app, [[-0.4, 0.1], [0.4, 0.1]], Effect::Protect);
    let document = bench.app.document().unwrap().clone();
    let radius = bench.app.brush.radius_on(&document);
    let painted = weights(&bench.app);
    let [mut core, mut free] = [0, 0];
    for (p, weight) in document.model.surface().positions().iter().zip(&painted) {
        // The two ends lie on the ball, and the line between them a little below it.
        let distance = (*p - DVec3::new(p.x.clamp(-0.4, 0.4), 0.1, p.z)).length();
        if p.z > 0.9 && distance < 0.3 * radius {
            core += 1;
            assert_eq!(*weight, 0.0, "{p}");
        } else if p.z < 0.0 || distance > radius {
            free += 1;
            assert_eq!(*weight, 1.0, "{p}");
        }
    }
    assert!(core > 5 && free > 100, "{core}, {free}");
    bench.tick();
    // The inner half of a brush twice as wide covers the rim of the stroke before.
    bench.app.brush.radius = 1.0;
    stroke(&mut bench.app, [[-0.4, 0.1], [0.4, 0.1]], Effect::Release);
    bench.tick();
    assert!(weights(&bench.app).iter().all(|weight| *weight == 1.0));
    assert_eq!(bench.app.choices.bake_config.limits.mask, None, "a mask that holds nothing is none");
    bench.app.undo();
    bench.tick();
    let again = weights(&bench.app);
    assert!(again.iter().zip(&painted).all(|(a, b)| (a - b).abs() <= 0.5 / 255.0 + 1e-6));
}

#[test]
fn a_stroke_that_crosses_itself_is_as_strong_as_one_that_does_not() {
    let mut bench = prepared();
    bench.app.brush.strength = 0.5;
    let there_and_back = |app: &mut App, times: usize| {
        for _ in 0..times {
            for x in [-0.3, 0.0, 0.3, 0.0] {
                let hit = app.pick(DVec3::new(x, 0.0, 9.0), DVec3::NEG_Z).unwrap();
                app.paint(&hit, Effect::Protect);
            }
        }
        app.end_stroke();
    };
    there_and_back(&mut bench.app, 1);
    let once = weights(&bench.app);
    assert!(once.iter().any(|weight| (*weight - 0.5).abs() < 0.01) && once.iter().all(|weight| *weight > 0.49));
    bench.app.change_mask(|_| 1.0);
    there_and_back(&mut bench.app, 3);
    assert_eq!(weights(&bench.app), once);
}

#[test]
fn what_is_painted_is_what_the_command_line_reads_and_what_the_bake_obeys() {
    let mut bench = prepared();
    stroke(&mut bench.app, [[-0.4, 0.1], [0.4, 0.1]], Effect::Protect);
    bench.app.save_mask();
    bench.until("saved", |app| app.messages().iter().any(|m| m.kind == MessageKind::Done));
    let file = bench.path("in-mask.txt");
    let chosen = bench.app.choices.bake_config.limits.mask.clone().unwrap();
    let command = bench.app.command().unwrap();
    assert!(command.contains(&format!("--mask weights:{}", file.display())), "{command}");
    let option: MaskOption = chosen.from.parse().unwrap();
    let document = bench.app.document().unwrap().clone();
    assert_eq!(option.weights(document.model.source(), &document.mesh).unwrap(), chosen);

    bench.until("baked", App::is_baked);
    let map = bench.app.map().unwrap();
    let quantum = map.manifest.displacement.scale as f32 / 65535.0;
    let held = weights(&bench.app);
    let moved: Vec<f32> = map.vertices.iter().map(|vertex| vertex.height(map.displacement().unwrap())).collect();
    assert!(held.iter().zip(&moved).all(|(weight, height)| *weight > 0.0 || height.abs() <= quantum));
    assert!(moved.iter().any(|height| height.abs() > 100.0 * quantum));

    // Read again, by another name, in a window that has painted nothing.
    fs::copy(&file, bench.path("other.txt")).unwrap();
    bench.app.change_mask(|_| 1.0);
    let other = bench.path("other.txt");
    bench.app.open_mask(&other);
    bench.until("read", |app| app.choices.bake_config.limits.mask.is_some());
    assert_eq!(bench.app.choices.bake_config.limits.mask.as_ref().unwrap().weights, chosen.weights);
}

#[test]
fn a_mask_is_of_one_mesh() {
    let mut bench = prepared();
    stroke(&mut bench.app, [[0.0, 0.0], [0.1, 0.0]], Effect::Protect);
    fs::write(bench.path("small.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    fs::write(bench.path("in-mask.txt"), "somebody else's").unwrap();
    bench.open("small.obj");
    assert_eq!(bench.app.choices.bake_config.limits.mask, None);
    assert!(bench.app.mask_weights().is_none_or(|weights| weights.len() == 3));
    bench.until("baked", App::is_baked);
    bench.open("in.obj");
    assert!(bench.app.has_brush(), "the brush stays in hand");
    bench.app.change_mask(|_| 0.0);
    let from = &bench.app.choices.bake_config.limits.mask.as_ref().unwrap().from;
    assert!(from.ends_with("in-mask-2.txt"), "a file that is there stays: {from}");
}

#[test]
fn the_noise_is_known_where_it_was_measured() {
    let mut bench = Bench::baked();
    bench.app.quantity = Quantity::Noise;
    let vertices = bench.app.document().unwrap().model.surface().positions().len();
    assert_eq!(bench.app.vertex_numbers().unwrap().numbers.len(), vertices);
    bench.app.choices.bake_config.denoiser = Denoiser::named("taubin").unwrap();
    bench.until("baked", App::is_baked);
    assert!(bench.app.vertex_numbers().is_none(), "taubin measures nothing");
}
