//! A display without a screen, the window on it, and hands for mouse and keyboard.

use image::RgbaImage;
use serde_json::Value;
use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Nothing takes longer, on a slow machine without a GPU either.
const PATIENCE: Duration = Duration::from_secs(120);

/// Programs that the tests of the window need.
const PROGRAMS: [&str; 3] = ["Xvfb", "xdotool", "import"];

/// A display with the window.
pub(crate) struct Desk {
    folder: tempfile::TempDir,
    display: String,
    server: Child,
    window: Option<Child>,
    /// Windows that are drawn by the processor would wait for one another, and lose clicks.
    _alone: MutexGuard<'static, ()>,
}

/// Held by the desk that there is.
static ALONE: Mutex<()> = Mutex::new(());

/// What the view shows.
pub(crate) struct Seen(RgbaImage);

impl Desk {
    /// A new display.
    pub(crate) fn new() -> Self {
        let missing = |program: &&&str| Command::new(program).arg("-help").output().is_err();
        if let Some(program) = PROGRAMS.iter().find(missing) {
            panic!("the test of the window needs {program}");
        }
        // A test that failed leaves nothing behind.
        let alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "1280x800x24", "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut number = String::new();
        BufReader::new(server.stdout.take().unwrap()).read_line(&mut number).unwrap();
        let display = format!(":{}", number.trim());
        Self { folder: tempfile::tempdir().unwrap(), display, server, window: None, _alone: alone }
    }

    pub(crate) fn folder(&self) -> &Path {
        self.folder.path()
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder().join(name)
    }

    /// Opens the window with nothing in it.
    pub(crate) fn start(&mut self) {
        self.start_with(&[]);
    }

    /// Opens the window.
    pub(crate) fn start_with(&mut self, arguments: &[&str]) {
        // Tests lie in `target/PROFILE/deps`, programs one up.
        let tests = std::env::current_exe().unwrap();
        let program = tests.ancestors().nth(2).unwrap().join("planish-viewer");
        assert!(program.is_file(), "build the window first: cargo build -p planish-viewer");
        let child = Command::new(program)
            .args([Path::new("--log"), &self.path("log.jsonl")])
            .args(arguments)
            .current_dir(self.folder())
            .env("DISPLAY", &self.display)
            .env("XDG_RUNTIME_DIR", self.folder())
            .env("XDG_CONFIG_HOME", self.path("config"))
            // Dialogs of the desktop would open there instead of here.
            .env_remove("DBUS_SESSION_BUS_ADDRESS")
            .env_remove("WAYLAND_DISPLAY")
            .env_remove("WAYLAND_SOCKET")
            .spawn()
            .unwrap();
        self.window = Some(child);
        self.until("shown", |s| s["widgets"]["open"].is_array());
        // Without a window manager nobody gives the window the keyboard.
        self.hands(&["search", "--sync", "--name", "planish", "windowfocus", "--sync"]);
    }

    /// The state as the log last told.
    pub(crate) fn state(&self) -> Value {
        let log = std::fs::read_to_string(self.path("log.jsonl")).unwrap_or_default();
        let lines = log.lines().rev().filter_map(|line| serde_json::from_str::<Value>(line).ok());
        lines.filter_map(|mut line| Some(line.get_mut("state")?.take())).next().unwrap_or_default()
    }

    /// Waits.
    #[track_caller]
    pub(crate) fn until(&mut self, what: &str, holds: impl Fn(&Value) -> bool) {
        let start = Instant::now();
        while !holds(&self.state()) {
            if let Some(window) = &mut self.window {
                assert_eq!(window.try_wait().unwrap(), None, "the window is gone, and was never {what}");
            }
            assert!(start.elapsed() < PATIENCE, "never {what}: {:#}", self.state());
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    #[track_caller]
    fn hands(&self, line: &[&str]) {
        let done = Command::new("xdotool").args(line).env("DISPLAY", &self.display).output().unwrap();
        assert!(done.status.success(), "xdotool {line:?}: {}", String::from_utf8_lossy(&done.stderr));
    }

    /// A place in a widget, 0..=1 from its upper left corner.
    #[track_caller]
    fn place(&mut self, widget: &str, [x, y]: [f64; 2]) -> [String; 2] {
        let name = widget.to_owned();
        self.until(widget, move |s| s["widgets"][&name].is_array());
        let rect: [f64; 4] = serde_json::from_value(self.state()["widgets"][widget].clone()).unwrap();
        [rect[0] + x * (rect[2] - rect[0]), rect[1] + y * (rect[3] - rect[1])].map(|p| format!("{p:.0}"))
    }

    #[track_caller]
    pub(crate) fn click(&mut self, widget: &str) {
        let [x, y] = self.place(widget, [0.5, 0.5]);
        // A hand rests between moving and clicking; the window needs a frame to see what is under the mouse.
        self.hands(&["mousemove", &x, &y, "sleep", "0.3", "click", "1", "sleep", "0.3"]);
    }

    #[track_caller]
    pub(crate) fn drag(&mut self, widget: &str, from: [f64; 2], to: [f64; 2]) {
        let [a, b] = [self.place(widget, from), self.place(widget, to)];
        self.hands(&["mousemove", &a[0], &a[1], "sleep", "0.3", "mousedown", "1", "sleep", "0.3"]);
        self.hands(&["mousemove", &b[0], &b[1], "sleep", "0.3", "mouseup", "1", "sleep", "0.3"]);
    }

    #[track_caller]
    pub(crate) fn key(&self, key: &str) {
        self.hands(&["key", key, "sleep", "0.2"]);
    }

    /// Turns the wheel away from the hand.
    #[track_caller]
    pub(crate) fn scroll(&mut self, widget: &str, at: [f64; 2], clicks: u32) {
        let [x, y] = self.place(widget, at);
        self.hands(&[
            "mousemove",
            &x,
            &y,
            "sleep",
            "0.3",
            "click",
            "--repeat",
            &clicks.to_string(),
            "4",
            "sleep",
            "0.3",
        ]);
    }

    /// Types a path into the dialog.
    #[track_caller]
    pub(crate) fn answer(&mut self, path: &Path) {
        self.until("asking", |s| s["widgets"]["path"].is_array());
        std::thread::sleep(Duration::from_millis(300));
        self.key("ctrl+a");
        self.hands(&["type", "--delay", "5", &path.to_string_lossy()]);
        self.key("Return");
        self.until("answered", |s| s["widgets"]["path"].is_null());
    }

    #[track_caller]
    pub(crate) fn open(&mut self, path: &Path) {
        self.key("ctrl+o");
        self.answer(path);
    }

    #[track_caller]
    pub(crate) fn save(&mut self, folder: &Path) {
        self.key("ctrl+s");
        self.answer(folder);
    }

    #[track_caller]
    pub(crate) fn choose_method(&mut self, name: &str) {
        self.click("method");
        self.click(name);
    }

    /// Puts the first message away.
    #[track_caller]
    pub(crate) fn dismiss(&mut self) {
        let gone = |desk: &Self| desk.state()["messages"] == serde_json::json!([]);
        // Where a frame takes long, a click may come to nothing, and a hand clicks again.
        for _ in 0..5 {
            self.click("dismiss");
            let start = Instant::now();
            while start.elapsed() < Duration::from_secs(20) {
                if gone(self) {
                    return;
                }
                std::thread::sleep(Duration::from_millis(50));
            }
        }
        panic!("a message stays: {:#}", self.state());
    }

    /// Moves the mouse over the panel, so that there are frames, until `holds` or so often.
    #[track_caller]
    pub(crate) fn wave_until(&mut self, what: &str, most: usize, holds: impl Fn(&Value) -> bool) {
        let start = Instant::now();
        let mut waves = 0;
        while waves < most && !holds(&self.state()) {
            let at = |y: usize| (100 + 5 * (y % 100)).to_string();
            self.hands(&[
                "mousemove",
                "1100",
                &at(waves),
                "sleep",
                "0.03",
                "mousemove",
                "1200",
                &at(waves),
                "sleep",
                "0.03",
            ]);
            waves += 1;
            assert!(start.elapsed() < 5 * PATIENCE, "never {what}");
        }
    }

    /// All frames so far, as the log tells.
    pub(crate) fn frames(&self) -> Vec<Value> {
        let log = std::fs::read_to_string(self.path("log.jsonl")).unwrap_or_default();
        let lines = log.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
        lines.filter_map(|mut line| Some(line.get_mut("frame")?.take())).collect()
    }

    /// The view, once it does not change any more.
    #[track_caller]
    pub(crate) fn settled_view(&mut self) -> Seen {
        // Away from what lights up under the mouse.
        let [x, y] = self.place("view", [0.02, 0.02]);
        self.hands(&["mousemove", &x, &y]);
        let start = Instant::now();
        let (mut last, mut same) = (self.view(), 0);
        // Once is not enough where the machine is busy with something else.
        while same < 3 {
            std::thread::sleep(Duration::from_millis(400));
            let now = self.view();
            same = if now.0 == last.0 { same + 1 } else { 0 };
            assert!(start.elapsed() < PATIENCE, "the view never rests");
            last = now;
        }
        last
    }

    /// A picture of the whole display, PNG.
    pub(crate) fn screen(&self) -> Vec<u8> {
        let mut shot = Command::new("import");
        shot.args(["-silent", "-window", "root", "png:-"]).env("DISPLAY", &self.display).output().unwrap().stdout
    }

    /// Keeps a picture of the display where pictures are wanted.
    pub(crate) fn keep(&self, name: &str) {
        if let Some(folder) = std::env::var_os("PLANISH_PICTURES") {
            std::fs::write(Path::new(&folder).join(format!("{name}.png")), self.screen()).unwrap();
        }
    }

    fn view(&self) -> Seen {
        let screen = image::load_from_memory(&self.screen()).unwrap().into_rgba8();
        let rect: [f64; 4] = serde_json::from_value(self.state()["widgets"]["view"].clone()).unwrap();
        let [x, y, right, bottom] = rect.map(|p| p as u32);
        Seen(image::imageops::crop_imm(&screen, x, y, right - x, bottom - y).to_image())
    }

    /// Waits for the window to end well.
    #[track_caller]
    pub(crate) fn ended(&mut self) {
        let mut window = self.window.take().unwrap();
        let start = Instant::now();
        loop {
            if let Some(status) = window.try_wait().unwrap() {
                assert!(status.success(), "{status}");
                return;
            }
            assert!(start.elapsed() < PATIENCE, "the window does not close");
            std::thread::sleep(Duration::from_millis(50));
        }
    }
}

impl Seen {
    /// Share of the pixels that differ visibly.
    pub(crate) fn differs(&self, other: &Self) -> f64 {
        assert_eq!(self.0.dimensions(), other.0.dimensions());
        let visibly =
            |(a, b): &(&image::Rgba<u8>, &image::Rgba<u8>)| a.0.iter().zip(b.0).any(|(a, b)| a.abs_diff(b) > 3);
        let pixels = self.0.pixels().zip(other.0.pixels());
        pixels.filter(visibly).count() as f64 / self.0.pixels().len() as f64
    }

    pub(crate) fn left(&self) -> Self {
        self.part(0)
    }

    pub(crate) fn right(&self) -> Self {
        self.part(1)
    }

    fn part(&self, half: u32) -> Self {
        let (width, height) = (self.0.width() / 2, self.0.height());
        Self(image::imageops::crop_imm(&self.0, half * width, 0, width, height).to_image())
    }
}

impl Drop for Desk {
    fn drop(&mut self) {
        if std::thread::panicking() {
            let place = Path::new(env!("CARGO_TARGET_TMPDIR")).join("window.png");
            let _ = std::fs::write(&place, self.screen());
            eprintln!("the display as it was then: {}", place.display());
        }
        for child in self.window.iter_mut().chain([&mut self.server]) {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}
