//! The panel as it looks and as it answers, without a window; Debian's mesa-vulkan-drivers draw it where there is no GPU.
//!
//! `UPDATE_SNAPSHOTS=1 cargo test -p planish-viewer --test panel` draws the pictures anew: look at them.

use egui::{Theme, vec2};
use egui_kittest::kittest::Queryable as _;
use egui_kittest::{Harness, SnapshotOptions};
use planish_geometry::denoise::Denoiser;
use planish_render::settings::environment::Part;
use planish_render::settings::volume::VolumeView;
use planish_render::settings::{Overlay, Shading};
use planish_viewer::app::jobs::Wake;
use planish_viewer::app::window_state::WindowState;
use planish_viewer::app::{App, Gesture, MessageKind, Work};
use planish_viewer::window::{UiState, panel};
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

const MESH: &str = "../../data/duck_noisy.obj";
const CLEAN: &str = "../../data/duck_clean.obj";

struct Window {
    app: App,
    ui_state: UiState,
}

type Panel = Harness<'static, Window>;

/// No work of these tests takes so long.
const LONGEST: Duration = Duration::from_secs(120);

/// Lets frames pass until the state is as expected. Where nothing goes on in the background it is at once as late as the
/// app wants to be looked at again.
#[track_caller]
fn until(app: &mut App, holds: impl Fn(&App) -> bool) {
    let (start, mut now) = (Instant::now(), Instant::now());
    loop {
        let again = app.tick(now, Gesture::None);
        if holds(app) {
            return;
        }
        let is_busy = Work::ALL.iter().any(|&work| app.status(work).is_some());
        match again.filter(|_| !is_busy) {
            Some(later) => now = later,
            None => std::thread::park_timeout(LONGEST),
        }
        assert!(start.elapsed() < LONGEST, "{:?}", app.messages());
    }
}

fn app() -> App {
    let test = std::thread::current();
    let wake: Wake = Arc::new(move || test.unpark());
    App::new(&wake, WindowState::default())
}

/// A mesh with a map that only changes with the method that made it.
fn baked(method: &str) -> App {
    let mut app = app();
    app.choices.bake_config.denoiser = Denoiser::named(method).expect("a method of the library");
    app.open(Path::new(MESH));
    until(&mut app, App::is_baked);
    app
}

fn show(app: App, theme: Theme, height: f32) -> Panel {
    let window = Window { app, ui_state: UiState::default() };
    let draw = |ui: &mut egui::Ui, window: &mut Window| panel::show(ui, &mut window.app, &mut window.ui_state);
    let builder = Harness::builder().with_size(vec2(760.0, height)).with_theme(theme).wgpu();
    let mut panel = builder.with_context_setup(panel::style).build_ui_state(draw, window);
    panel.run();
    panel
}

/// Compares with the picture of that name. Drivers differ a little in how they blend letters.
#[track_caller]
fn looks_like(panel: &mut Panel, name: &str) {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/panel");
    panel.snapshot_options(name, &SnapshotOptions::new().threshold(2.0).max_failed_pixels(60).output_path(folder));
}

#[test]
fn at_the_start_there_is_one_thing_to_do() {
    looks_like(&mut show(app(), Theme::Dark, 420.0), "start");
}

#[test]
fn a_mesh_and_its_map() {
    looks_like(&mut show(baked("taubin"), Theme::Dark, 1250.0), "baked");
}

#[test]
fn light_like_the_desktop() {
    looks_like(&mut show(baked("guided-normals"), Theme::Light, 1250.0), "light");
}

#[test]
fn what_is_drawn_how() {
    let mut panel = show(baked("taubin"), Theme::Dark, 900.0);
    for section in ["Denoise", "Compare", "Map", "Mesh", "View and light"] {
        panel.get_by_label(section).click();
        panel.run();
    }
    looks_like(&mut panel, "view");
}

#[test]
fn a_volume_has_its_settings_where_one_is_chosen() {
    let mut app = baked("taubin");
    app.choices.view.volume = Some(VolumeView { slices: [None, Some(0.4), None], ..VolumeView::default() });
    let mut panel = show(app, Theme::Dark, 1150.0);
    for section in ["Denoise", "Compare", "Map", "Mesh", "View and light"] {
        panel.get_by_label(section).click();
        panel.run();
    }
    looks_like(&mut panel, "volume");
    panel.get_by_label("slice z").click();
    panel.get_by_label("without the mesh").click();
    panel.run();
    let view = panel.state().app.choices.view.volume.clone().unwrap();
    assert_eq!((view.slices, view.mesh), ([None, Some(0.4), Some(0.5)], Part::Hidden));
}

#[test]
fn what_is_said_stays_until_it_is_put_away() {
    let mut app = app();
    app.say(MessageKind::Error, "scan.obj: line 7: `x` is not a number");
    app.say(MessageKind::Done, "wrote 6 files to scan-planish");
    let mut panel = show(app, Theme::Dark, 420.0);
    looks_like(&mut panel, "messages");
    panel.get_all_by_label("✖").next().unwrap().click();
    panel.run();
    let left: Vec<_> = panel.state().app.messages().iter().map(|m| m.text.as_str()).collect();
    assert_eq!(left, ["wrote 6 files to scan-planish"]);
}

#[test]
fn keys_are_listed_and_do_what_is_said() {
    let mut panel = show(baked("taubin"), Theme::Dark, 700.0);
    panel.key_press(egui::Key::F1);
    panel.run();
    looks_like(&mut panel, "keys");
    panel.key_press(egui::Key::Escape);
    panel.key_press(egui::Key::Num0);
    panel.key_press(egui::Key::ArrowUp);
    panel.key_press(egui::Key::W);
    panel.key_press(egui::Key::H);
    panel.run();
    let view = &panel.state().app.choices.view;
    assert_eq!((view.displace.lambda, view.overlay, view.shading), (0.05, Overlay::Wireframe, Shading::Height));
}

#[test]
fn what_auto_found_is_said_in_words() {
    let panel = show(baked("auto"), Theme::Dark, 900.0);
    let map = panel.state().app.map().unwrap();
    let choice = map.manifest.choice.as_ref().unwrap();
    assert!(choice.sigma > 0.0 && !choice.candidates.is_empty(), "{choice:?}");
    panel.get_by_label(&choice.to_string());
}

#[test]
fn the_clean_mesh_is_measured_against() {
    let mut app = baked("taubin");
    app.compare_with(Path::new(CLEAN));
    until(&mut app, |app| app.measured().is_some_and(|m| m.displaced.is_some()));
    let panel = show(app, Theme::Dark, 900.0);
    let measured = panel.state().app.measured().unwrap();
    let (_, displaced) = measured.displaced.as_ref().unwrap();
    assert!(displaced.ea < 0.4 * measured.noisy().ea, "{measured:?}");
    for ea in [measured.noisy().ea, displaced.ea] {
        panel.get_by_label(&format!("{ea:.3}°"));
    }
}

#[test]
fn a_method_is_chosen_from_the_list_and_baked() {
    let mut panel = show(baked("taubin"), Theme::Dark, 900.0);
    panel.get_by_value("taubin").click();
    panel.run();
    panel.get_by_label("hc").click();
    panel.run();
    let app = &mut panel.state_mut().app;
    assert_eq!(app.choices.bake_config.denoiser.name(), "hc");
    until(app, |app| app.status(Work::Bake).is_some());
    until(app, App::is_baked);
    assert!(app.command().unwrap().contains("--method hc"));
}
