//! Handling of the results of work in the background.

use super::bake_config::BakeConfig;
use super::document::{Document, Map, Origin};
use super::history::History;
use super::measurement::Clean;
use super::schedule::without_camera;
use super::{App, MessageKind, jobs};
use planish_files::failure::Failure;
use planish_geometry::denoise::limits::WeightMask;
use planish_render::settings::Shading;
use planish_render::settings::camera::Camera;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Files that were read.
pub(super) enum Loaded {
    /// A mesh from this path, or the manifest of its map.
    Document(PathBuf, Box<Document>, Option<Box<Map>>),
    /// A clean mesh to compare with.
    Clean(Clean),
    /// A mask for the mesh of this path.
    Mask(PathBuf, WeightMask),
}

/// Files that were written.
pub(super) struct Saved {
    pub(super) files: Vec<PathBuf>,
    /// The map, where it had to be baked again for another folder.
    pub(super) map: Option<Map>,
}

impl App {
    /// Takes what the threads in the background have finished.
    pub(super) fn take_results(&mut self) {
        self.take_loaded();
        self.take_baked();
        self.take_saved();
        self.take_drawn();
        self.take_canvas();
        self.take_baked_all();
    }

    fn take_loaded(&mut self) {
        let Some(outcome) = self.loading.poll() else { return };
        match outcome {
            Ok(Loaded::Document(path, document, map)) => self.show(path, *document, map.map(|map| *map)),
            Ok(Loaded::Clean(clean)) => {
                self.forget_clean();
                self.clean = Some(Arc::new(clean));
            }
            Ok(Loaded::Mask(mesh, mask)) => self.take_mask(&mesh, mask),
            Err(failure) => {
                // What is open stays, as it is welded.
                if let Some(document) = &self.document {
                    self.choices.bake_config.settings.welding = document.welding;
                }
                self.fail(&failure);
            }
        }
    }

    fn show(&mut self, path: PathBuf, document: Document, map: Option<Map>) {
        let again = self.source.as_deref() == Some(&*path);
        self.baking.drop_running();
        self.measuring.drop_running();
        self.forget_painting(again);
        (self.measured, self.measured_for, self.due) = (None, None, None);
        if !again {
            self.messages.clear();
        }
        let mut watched = vec![document.mesh.clone()];
        if path != document.mesh {
            watched.push(path.clone());
        }
        self.watch.these(&watched);
        self.window_state.opened(&path);
        self.list_mesh(&path);
        if let Some(map) = &map {
            self.choices.bake_config = BakeConfig::of(&map.manifest, &path);
            self.choices.view.displace.lambda = map.manifest.displacement.lambda as f32;
        } else {
            self.choices.bake_config.settings.welding = document.welding;
        }
        if !again && map.is_none() {
            self.choices.bake_config.target = None;
            // They are of vertices of the other mesh.
            let limits = &mut self.choices.bake_config.limits;
            (limits.fixed_file, limits.fixed, limits.mask) = <_>::default();
        }
        if !again {
            self.choices.view.shading = shading_of(&document, self.choices.view.shading);
            self.choices.view.camera = Camera { up: self.choices.view.camera.up, ..<_>::default() };
        }
        (self.choices.view.displace.bias, self.choices.view.displace.scale) = (None, None);
        jobs::drop_in_background(self.document.replace(Arc::new(document)));
        self.source = Some(path);
        let bake_config = self.choices.bake_config.clone();
        (self.begun, self.shown) =
            if map.is_some() { (Some(bake_config.clone()), Some(bake_config)) } else { (None, None) };
        self.seen = self.choices.bake_config.clone();
        jobs::drop_in_background(std::mem::replace(&mut self.map, map.map(Arc::new)));
        if !again {
            let mut now = self.choices.clone();
            without_camera(&mut now);
            self.history = History::new(now);
        }
        if self.map.is_none() {
            self.bake();
        }
    }

    fn take_baked(&mut self) {
        match self.baking.poll() {
            None => {}
            // Its warnings stand in the panel.
            Some(Ok(map)) => self.put(map),
            Some(Err(Failure::Interrupted)) => self.say(MessageKind::Warning, "stopped; the last result stays"),
            Some(Err(failure)) => self.fail(&failure),
        }
    }

    fn put(&mut self, map: Map) {
        if let Origin::Baked { bake_config, .. } = &map.origin {
            self.shown = Some((**bake_config).clone());
        }
        jobs::drop_in_background(self.map.replace(Arc::new(map)));
    }

    fn take_saved(&mut self) {
        match self.saving.poll() {
            None => {}
            Some(Ok(Saved { files, map })) => {
                if let Some(map) = map {
                    self.put(map);
                }
                self.say(MessageKind::Done, format!("wrote {}", listed(&files)));
            }
            Some(Err(Failure::Interrupted)) => self.say(MessageKind::Warning, Failure::Interrupted.to_string()),
            Some(Err(failure)) => self.fail(&failure),
        }
    }

    fn take_drawn(&mut self) {
        match self.drawing.poll() {
            None => {}
            Some(Ok(files)) => self.say(MessageKind::Done, format!("wrote {}", listed(&files))),
            Some(Err(Failure::Interrupted)) => self.say(MessageKind::Warning, Failure::Interrupted.to_string()),
            Some(Err(failure)) => self.fail(&failure),
        }
    }
}

/// Shading in which a mesh is shown first: with its textures where it has some, unless another one than the usual was chosen.
fn shading_of(document: &Document, chosen: Shading) -> Shading {
    let is_textured = !document.scene.textures.all().is_empty();
    match chosen {
        Shading::Phong if is_textured => Shading::Texture,
        Shading::Texture if !is_textured => Shading::Phong,
        other => other,
    }
}

/// A few files by name, many by the first and their number.
fn listed(files: &[PathBuf]) -> String {
    match files {
        [] => "nothing".to_owned(),
        [one] => one.display().to_string(),
        [first, ..] => {
            let folder = first.parent().unwrap_or(Path::new("")).display();
            format!("{} files to {folder}", files.len())
        }
    }
}
