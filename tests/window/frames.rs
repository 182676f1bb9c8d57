//! How long the window's thread is busy with a frame while a large mesh is read and baked, against frames while nothing
//! happens. A measurement, not a test:
//!
//! `cargo build --release -p planish-viewer && cargo test --release -p planish-tests --test window -- --ignored --nocapture`

use crate::desk::Desk;
use serde_json::{Value, json};
use std::fmt::Write as _;

/// Vertices along a side.
const SIDE: usize = 1000;

/// A wavy sheet of a million vertices with noise and texture coordinates.
fn sheet() -> String {
    let mut text = String::new();
    let unit = |i: usize| i as f64 / (SIDE - 1) as f64;
    for (x, y) in (0..SIDE * SIDE).map(|i| (i % SIDE, i / SIDE)) {
        let [u, v] = [unit(x), unit(y)];
        // Noise from the digits of a sine, a third of an edge high.
        let noise = (((x * 7919 + y * 104_729) as f64).sin() * 43_758.545).fract() * 0.3 / SIDE as f64;
        let z = 0.1 * (9.0 * u).sin() * (7.0 * v).cos() + noise;
        let _ = writeln!(text, "v {u:.6} {v:.6} {z:.6}\nvt {u:.6} {v:.6}");
    }
    for (x, y) in (0..(SIDE - 1) * (SIDE - 1)).map(|i| (i % (SIDE - 1), i / (SIDE - 1))) {
        let [a, b] = [y * SIDE + x + 1, (y + 1) * SIDE + x + 1];
        let (c, d) = (a + 1, b + 1);
        let _ = writeln!(text, "f {a}/{a} {c}/{c} {d}/{d}\nf {a}/{a} {d}/{d} {b}/{b}");
    }
    text
}

/// Median, 99th percentile and longest of the frames that fit, milliseconds.
fn summary(frames: &[Value], fits: impl Fn(&Value) -> bool) -> Value {
    let mut ms: Vec<f64> = frames.iter().filter(|f| fits(f)).filter_map(|f| f["ms"].as_f64()).collect();
    ms.sort_by(f64::total_cmp);
    let at = |share: f64| ms.get(((ms.len() as f64 - 1.0) * share).round() as usize).copied();
    json!({ "frames": ms.len(), "median": at(0.5), "p99": at(0.99), "longest": at(1.0) })
}

#[test]
#[ignore = "a measurement that takes minutes"]
fn frames_while_a_million_vertices_are_read_and_baked() {
    let mut desk = Desk::new();
    std::fs::write(desk.path("sheet.obj"), sheet()).unwrap();
    desk.start();
    let path = desk.path("sheet.obj");
    desk.wave_until("idle", 200, |_| false);
    let idle = desk.frames();
    // Quick, so that most of the bake is the map.
    desk.choose_method("taubin");
    desk.open(&path);
    desk.wave_until("baked", usize::MAX, |s| s["baked"] == true && s["showing"] == false);
    let all = desk.frames();
    let during = &all[idle.len()..];
    desk.wave_until("idle again", 200, |_| false);
    let after = &desk.frames()[all.len()..];
    let is_drawn = |f: &Value| f["drawn"] != 0;
    let busy = |f: &Value, work: &str| f["busy"].as_array().is_some_and(|b| b.contains(&work.into()));
    let report = json!({
        "vertices": SIDE * SIDE,
        "idle": summary(&idle, |_| true),
        "reading": summary(during, |f| busy(f, "load") && !is_drawn(f)),
        "baking": summary(during, |f| busy(f, "bake") && !is_drawn(f)),
        "all of it, frames that draw the model left out": summary(during, |f| !is_drawn(f)),
        "frames that draw the model": summary(&all, is_drawn),
        "idle with the model": summary(after, |f| !is_drawn(f)),
    });
    println!("{report:#}");
}
