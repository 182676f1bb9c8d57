//! The window: an event loop, a surface, and what is drawn on it. What it shows is decided in [`crate::app`].

mod dialog;
mod keys;
mod log;
mod orbit;
mod paint;
pub mod panel;
mod pointer;
mod surface;
mod ui_state;
mod viewport;
mod viewport_targets;

pub use ui_state::UiState;

use crate::app::jobs::{self, Wake};
use crate::app::window_state::{self, WindowState};
use crate::app::{App, Gesture, MessageKind, capture, document};
use dialog::FilePurpose;
use egui_winit::accesskit_winit;
use log::Log;
use planish_files::failure::Failure;
use planish_files::input::Trust;
use planish_files::output::Output;
use planish_geometry::progress::Progress as _;
use planish_render::gpu::{Backend, NoGpu};
use planish_render::settings::volume::VolumeSource;
use planish_render::settings::{Settings, Shading};
use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};
use surface::WindowSurface;
use ui_state::Action;
use viewport_targets::ViewportTargets;
use winit::application::ApplicationHandler;
use winit::dpi::LogicalSize;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop, EventLoopProxy};
use winit::window::{Window, WindowId};

/// A display that allows no window, with the way out.
fn no_window(reason: impl Display) -> Failure {
    Failure::Internal(format!("no window can be opened: {reason}; draw into a file with --headless OUT.png"))
}

/// Options of the window, from the command line.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// File to open first.
    pub open: Option<PathBuf>,
    /// Rule on the files that a mesh or a manifest names.
    pub trust: Trust,
    /// Backend that draws.
    pub backend: Backend,
    /// Settings of the view at the start.
    pub settings: Settings,
    /// Write what happens, one JSON object a line.
    pub log: Option<PathBuf>,
}

/// Event that wakes the window.
#[derive(Debug)]
enum UserEvent {
    /// Something happened in the background.
    Background,
    /// A screen reader asks for something.
    Accessibility(accesskit_winit::Event),
}

impl From<accesskit_winit::Event> for UserEvent {
    fn from(event: accesskit_winit::Event) -> Self {
        Self::Accessibility(event)
    }
}

/// Opens the window and runs until it is closed.
pub fn run(options: Options) -> Result<(), Failure> {
    // Work in the background shares the cores with the window, which comes first.
    let _ = rayon::ThreadPoolBuilder::new().start_handler(|_| jobs::lower_priority()).build_global();
    let event_loop = EventLoop::<UserEvent>::with_user_event().build().map_err(no_window)?;
    let mut window_app = WindowApp::new(options, event_loop.create_proxy())?;
    event_loop.run_app(&mut window_app).map_err(no_window)?;
    window_app.failed.map_or(Ok(()), Err)
}

struct WindowApp {
    options: Options,
    app: App,
    ui_state: UiState,
    log: Log,
    proxy: EventLoopProxy<UserEvent>,
    open: Option<Open>,
    failed: Option<Failure>,
}

/// Resources that exist while the window is open.
struct Open {
    window: Arc<Window>,
    context: egui::Context,
    input: egui_winit::State,
    surface: WindowSurface,
    targets: ViewportTargets,
    /// Time at which to draw again although nothing happens.
    again: Option<Instant>,
}

impl WindowApp {
    fn new(options: Options, proxy: EventLoopProxy<UserEvent>) -> Result<Self, Failure> {
        let log = Log::open(options.log.as_deref())?;
        let window_state = window_state::path().map(|path| WindowState::load(&path)).unwrap_or_default();
        let mut app = App::new(&wake(&proxy), window_state);
        app.choices.view = options.settings.clone();
        app.trust = options.trust;
        let ui_state = UiState { panel_hidden: app.window_state.panel_hidden, ..UiState::default() };
        Ok(Self { options, app, ui_state, log, proxy, open: None, failed: None })
    }

    fn open_window(&self, event_loop: &ActiveEventLoop) -> Result<Open, Failure> {
        let [width, height] = self.app.window_state.size.unwrap_or([1280.0, 800.0]);
        let attributes = Window::default_attributes()
            .with_title("planish")
            .with_inner_size(LogicalSize::new(width, height))
            .with_min_inner_size(LogicalSize::new(480.0, 320.0))
            .with_maximized(self.app.window_state.maximised)
            // Screen readers are told of a window before it is seen.
            .with_visible(false);
        let window = event_loop.create_window(attributes).map_err(no_window)?;
        let mut open = self.open_on(Arc::new(window), event_loop)?;
        open.input.init_accesskit(event_loop, &open.window, self.proxy.clone());
        open.window.set_visible(true);
        Ok(open)
    }

    /// Opens everything that draws in a window. None of it outlives its graphics device.
    fn open_on(&self, window: Arc<Window>, event_loop: &ActiveEventLoop) -> Result<Open, Failure> {
        let (surface, gpu) = WindowSurface::new(&window, event_loop, self.options.backend)?;
        let targets = ViewportTargets::new(gpu, &wake(&self.proxy));
        let context = egui::Context::default();
        panel::style(&context);
        let side = targets.largest_texture();
        let theme = window.theme();
        let input = egui_winit::State::new(context.clone(), egui::ViewportId::ROOT, &*window, None, theme, Some(side));
        Ok(Open { window, context, input, surface, targets, again: None })
    }

    /// Begins anew on another device: drivers are updated, cards are pulled out and notebooks wake up.
    fn replace_device(&mut self, event_loop: &ActiveEventLoop) {
        let Some(Open { window, surface, mut input, .. }) = self.open.take() else { return };
        // A window has one surface at a time.
        drop(surface);
        match self.open_on(Arc::clone(&window), event_loop) {
            Ok(mut open) if !open.targets.is_lost() => {
                // It is of the window, which stays.
                open.input.accesskit = input.accesskit.take();
                open.context.enable_accesskit();
                self.app.say(MessageKind::Warning, "the graphics device was lost and has been replaced");
                self.ui_state.forget_device();
                self.open = Some(open);
                window.request_redraw();
            }
            Ok(open) => self.fail(event_loop, Failure::internal(NoGpu::Lost { adapter: open.targets.adapter() })),
            Err(e) => self.fail(event_loop, e),
        }
    }

    fn fail(&mut self, event_loop: &ActiveEventLoop, failure: Failure) {
        self.failed = Some(failure);
        event_loop.exit();
    }

    /// Draws one frame.
    fn draw(&mut self, event_loop: &ActiveEventLoop) {
        if self.open.as_ref().is_some_and(|open| open.targets.is_lost()) {
            return self.replace_device(event_loop);
        }
        let Self { app, ui_state, log, open: Some(open), .. } = self else { return };
        let start = Instant::now();
        let is_pressed = open.context.input(|i| i.pointer.any_down());
        open.again = app.tick(start, if is_pressed { Gesture::Ongoing } else { Gesture::None });
        let input = open.input.take_egui_input(&open.window);
        open.targets.follow(app);
        ui_state.pictures = open.targets.pictures();
        ui_state.showing = open.targets.status();
        let output = open.context.run_ui(input, |ui| panel::show(ui, app, ui_state));
        open.input.handle_platform_output_with_event_loop(&open.window, event_loop, output.platform_output);
        let drawn = ui_state
            .view
            .map_or(0, |view| open.targets.draw(&mut open.surface, app, ui_state, view, output.pixels_per_point));
        let triangles = open.context.tessellate(output.shapes, output.pixels_per_point);
        let waited = open.surface.paint(&triangles, output.textures_delta, output.pixels_per_point);
        for error in open.targets.validation_errors() {
            app.say(MessageKind::Error, format!("the graphics driver: {error}"));
        }
        let delay = output.viewport_output.get(&egui::ViewportId::ROOT).map_or(Duration::MAX, |v| v.repaint_delay);
        if let Some(then) = start.checked_add(delay) {
            open.again = Some(open.again.map_or(then, |other| other.min(then)));
        }
        log.frame(start.elapsed(), waited, drawn, app);
        log.state(app, ui_state, output.pixels_per_point);
        self.act(event_loop);
    }

    /// Does what the panel asked for and cannot do itself.
    fn act(&mut self, event_loop: &ActiveEventLoop) {
        let Self { app, ui_state, open: Some(open), .. } = self else { return };
        for action in std::mem::take(&mut ui_state.actions) {
            match action {
                Action::Quit => event_loop.exit(),
                Action::Copy(text) => open.context.copy_text(text),
                Action::Screenshot => {
                    let (Some(document), Some(draw)) = (app.document(), open.targets.drawer(app)) else { continue };
                    let (path, settings) = (capture::screenshot(&document.mesh), for_file(&app.shown_view()));
                    app.draw(move |_| Ok(vec![capture::save(&draw(&settings)?, &path)?]));
                }
                Action::BeforeAfter => {
                    let (Some(document), Some(draw)) = (app.document(), open.targets.drawer(app)) else { continue };
                    let (path, settings) = (capture::before_after_file(&document.mesh), for_file(&app.shown_view()));
                    app.draw(move |_| Ok(vec![capture::save(&capture::before_after(&settings, draw)?, &path)?]));
                }
                Action::Animation => {
                    let (Some(document), Some(draw)) = (app.document(), open.targets.drawer(app)) else { continue };
                    let (path, settings) = (capture::animation_file(&document.mesh), for_file(&app.shown_view()));
                    app.draw(move |ticket| {
                        let bytes = capture::animation(&settings, draw, ticket)?;
                        ticket.check()?;
                        Ok(vec![Output::open(&path, &[])?.write(&bytes)?])
                    });
                }
                Action::Turntable(count) => {
                    let (Some(document), Some(draw)) = (app.document(), open.targets.drawer(app)) else { continue };
                    let folder = capture::turntable_folder(&document.mesh);
                    let settings = for_file(&app.shown_view());
                    app.draw(move |ticket| capture::turntable(&settings, count, &folder, draw, ticket));
                }
            }
            open.window.request_redraw();
        }
    }

    fn remember(&mut self) {
        let Some(open) = &self.open else { return };
        let size: LogicalSize<f32> = open.window.inner_size().to_logical(open.window.scale_factor());
        let window_state = &mut self.app.window_state;
        window_state.maximised = open.window.is_maximized();
        if !window_state.maximised {
            window_state.size = Some([size.width, size.height]);
        }
        window_state.panel_hidden = self.ui_state.panel_hidden;
        if let Some(path) = window_state::path() {
            // The window is closing: nobody would read a complaint, and nothing of the user's is lost.
            let _ = window_state.save(&path);
        }
    }
}

/// Pictures in files are smoother than those in the window, where time is short.
fn for_file(view: &Settings) -> Settings {
    let supersampling = if view.shading == Shading::Flat { 3 } else { 2 };
    Settings { supersampling, ..view.clone() }
}

fn wake(proxy: &EventLoopProxy<UserEvent>) -> Wake {
    let proxy = proxy.clone();
    Arc::new(move || {
        // A loop that has ended needs no news.
        let _ = proxy.send_event(UserEvent::Background);
    })
}

/// Opens whatever was dropped or chosen: what a file is decides what is done with it.
fn take(app: &mut App, purpose: FilePurpose, path: &Path) {
    let is_mesh = document::kind(path) == Some(document::Kind::Mesh);
    match purpose {
        FilePurpose::Clean if is_mesh => app.compare_with(path),
        FilePurpose::Target if is_mesh => app.choices.bake_config.target = Some(path.to_owned()),
        FilePurpose::FixedVertices if !is_mesh => app.choices.bake_config.limits.fixed_file = Some(path.to_owned()),
        FilePurpose::Mask => app.open_mask(path),
        FilePurpose::Environment => {
            let Ok(source) = crate::environment::parse_source(&path.to_string_lossy());
            app.choices.view.environment.get_or_insert_default().source = source;
        }
        FilePurpose::Volume => {
            app.choices.view.volume.get_or_insert_default().source = VolumeSource::File(path.to_owned());
        }
        _ => app.open(path),
    }
}

impl ApplicationHandler<UserEvent> for WindowApp {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.open.is_some() {
            return;
        }
        match self.open_window(event_loop) {
            Ok(open) => {
                open.window.request_redraw();
                self.open = Some(open);
                if let Some(path) = self.options.open.take() {
                    self.app.open(&path);
                }
            }
            Err(e) => self.fail(event_loop, e),
        }
    }

    fn user_event(&mut self, _: &ActiveEventLoop, event: UserEvent) {
        use accesskit_winit::WindowEvent as Asked;
        let Some(open) = &mut self.open else { return };
        match event {
            UserEvent::Background => {}
            UserEvent::Accessibility(event) => match event.window_event {
                // What is on screen is described only while somebody reads it.
                Asked::InitialTreeRequested => open.context.enable_accesskit(),
                Asked::ActionRequested(request) => open.input.on_accesskit_action_request(request),
                Asked::AccessibilityDeactivated => open.context.disable_accesskit(),
            },
        }
        open.window.request_redraw();
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        if event == WindowEvent::RedrawRequested {
            // egui would ask for the next frame, and so on for ever.
            return self.draw(event_loop);
        }
        let Some(open) = &mut self.open else { return };
        let response = open.input.on_window_event(&open.window, &event);
        if response.repaint {
            open.window.request_redraw();
        }
        match event {
            WindowEvent::CloseRequested => event_loop.exit(),
            WindowEvent::Resized(size) => open.surface.resize(size),
            WindowEvent::DroppedFile(path) => {
                // Several files come one by one: the last is shown, and all meshes are in the list.
                self.app.list_mesh(&path);
                take(&mut self.app, FilePurpose::Open, &path);
            }
            _ => {}
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        let Some(open) = &mut self.open else { return };
        match open.again {
            Some(then) if then <= Instant::now() => {
                open.again = None;
                open.window.request_redraw();
                event_loop.set_control_flow(ControlFlow::Wait);
            }
            Some(then) => event_loop.set_control_flow(ControlFlow::WaitUntil(then)),
            None => event_loop.set_control_flow(ControlFlow::Wait),
        }
    }

    fn exiting(&mut self, _: &ActiveEventLoop) {
        self.app.close();
        self.remember();
        // The surface goes before the window that it is of.
        self.open = None;
    }
}
