//! The list of meshes: all that were opened or dropped, each a click away, and baked together with the same settings.

use super::bake_config::BakeConfig;
use super::document;
use super::{App, MessageKind};
use planish_files::bake_files::{self, Job};
use planish_files::failure::Failure;
use planish_files::input::{self, Trust};
use planish_files::output::Folder;
use planish_files::text::count;
use planish_geometry::progress::Progress;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Mesh of the list.
#[derive(Clone, Debug, PartialEq)]
pub struct ListedMesh {
    /// Path of the mesh.
    pub path: PathBuf,
    /// State of its bake.
    pub state: BakeState,
}

/// State of a mesh of the list.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum BakeState {
    /// The mesh was not baked with the others.
    #[default]
    Untouched,
    /// The mesh waits for its turn.
    Waiting,
    /// The mesh is being baked.
    Baking,
    /// The files of the mesh are in this folder.
    Done(PathBuf),
    /// The reason why it has no files.
    Failed(String),
}

/// List that the thread in the background writes its results to.
#[derive(Clone, Debug, Default)]
pub(super) struct MeshList(Arc<Mutex<Vec<ListedMesh>>>);

impl MeshList {
    fn lock(&self) -> MutexGuard<'_, Vec<ListedMesh>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn set(&self, path: &Path, state: BakeState) {
        if let Some(mesh) = self.lock().iter_mut().find(|mesh| mesh.path == path) {
            mesh.state = state;
        }
    }
}

/// Number of meshes that were baked, and of those that failed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Baked {
    done: usize,
    failed: usize,
}

impl App {
    /// Returns the meshes of the list, in the order in which they came.
    pub fn meshes(&self) -> Vec<ListedMesh> {
        self.meshes.lock().clone()
    }

    /// Puts a file into the list if it is a mesh and not there yet.
    pub fn list_mesh(&self, path: &Path) {
        if document::kind(path) != Some(document::Kind::Mesh) {
            return;
        }
        let mut meshes = self.meshes.lock();
        if meshes.iter().all(|mesh| mesh.path != path) {
            meshes.push(ListedMesh { path: path.to_owned(), state: BakeState::default() });
        }
    }

    /// Takes a mesh off the list.
    pub fn unlist(&mut self, path: &Path) {
        self.meshes.lock().retain(|mesh| mesh.path != path);
    }

    /// Bakes all meshes of the list with the settings of now, each into a folder beside it. A mesh that fails leaves the others alone.
    pub fn bake_all(&mut self) {
        let meshes = self.meshes.clone();
        let paths: Vec<PathBuf> = meshes.lock().iter().map(|mesh| mesh.path.clone()).collect();
        paths.iter().for_each(|path| meshes.set(path, BakeState::Waiting));
        let (config, trust) = (of_any_mesh(&self.choices.bake_config), self.trust);
        self.baking_all.start(move |ticket| {
            let mut baked = Baked::default();
            for path in &paths {
                meshes.set(path, BakeState::Baking);
                let state = match bake_one(path, &config, trust, ticket) {
                    Ok(folder) => {
                        baked.done += 1;
                        BakeState::Done(folder)
                    }
                    // Whoever takes this result puts what was not baked back.
                    Err(Failure::Interrupted) => return Err(Failure::Interrupted),
                    Err(failure) => {
                        baked.failed += 1;
                        BakeState::Failed(failure.to_string())
                    }
                };
                meshes.set(path, state);
            }
            Ok(baked)
        });
    }

    /// Takes the news that all meshes of the list were baked.
    pub(super) fn take_baked_all(&mut self) {
        match self.baking_all.poll() {
            None => {}
            Some(Ok(Baked { done, failed: 0 })) => {
                self.say(MessageKind::Done, format!("baked {}", count(done, "mesh", "meshes")));
            }
            Some(Ok(Baked { done, failed })) => {
                let text = format!("baked {}; {failed} failed: the list says why", count(done, "mesh", "meshes"));
                self.say(MessageKind::Warning, text);
            }
            Some(Err(failure)) => {
                for mesh in self.meshes.lock().iter_mut() {
                    if matches!(mesh.state, BakeState::Waiting | BakeState::Baking) {
                        mesh.state = BakeState::Untouched;
                    }
                }
                self.fail(&failure);
            }
        }
    }
}

/// Settings without what belongs to the vertices of one mesh alone.
fn of_any_mesh(config: &BakeConfig) -> BakeConfig {
    let mut config = config.clone();
    config.target = None;
    (config.limits.fixed_file, config.limits.fixed, config.limits.mask) = <_>::default();
    config
}

/// Bakes a mesh into the folder beside it, and returns that folder.
fn bake_one(path: &Path, config: &BakeConfig, trust: Trust, progress: &dyn Progress) -> Result<PathBuf, Failure> {
    progress.stage("reading");
    let folder = bake_files::folder_beside(path)?;
    let model = input::model(path, config.settings.welding, trust, progress)?;
    let job = Job { input: path, model: &model, folder: &folder, protected: &[], trust };
    let baked = job.run(&config.settings(&job)?, progress)?;
    progress.check()?;
    progress.stage("writing");
    baked.write(Folder::open(&folder)?)?;
    Ok(folder)
}

#[cfg(test)]
mod tests {
    use super::super::tests::Bench;
    use super::super::{App, Work};
    use super::*;
    use planish_geometry::denoise::limits::{WeightMask, Weights};
    use std::fs;

    fn states(app: &App) -> Vec<(String, BakeState)> {
        let name = |path: &Path| path.file_name().unwrap().to_string_lossy().into_owned();
        app.meshes().into_iter().map(|mesh| (name(&mesh.path), mesh.state)).collect()
    }

    #[test]
    fn all_meshes_of_the_list_are_baked_and_a_bad_one_leaves_the_others_alone() {
        let mut bench = Bench::baked();
        fs::write(bench.path("bad.obj"), "v 0 0 0\nf 1 2 3\n").unwrap();
        fs::write(bench.path("notes.txt"), "no mesh").unwrap();
        fs::copy(bench.path("in.obj"), bench.path("other.obj")).unwrap();
        for name in ["bad.obj", "other.obj", "notes.txt", "in.obj"] {
            bench.app.list_mesh(&bench.path(name));
        }
        assert_eq!(
            states(&bench.app).into_iter().map(|(name, _)| name).collect::<Vec<_>>(),
            ["in.obj", "bad.obj", "other.obj"]
        );
        // A mask is of one mesh.
        let weights = Weights::new(&[0.0; 3]);
        bench.app.choices.bake_config.limits.mask = Some(WeightMask { from: "a".to_owned(), weights });
        bench.app.choices.bake_config.settings.lambda.0 = 0.5;
        bench.app.bake_all();
        bench.until("all baked", |app| app.status(Work::BakeAll).is_none());
        let states = states(&bench.app);
        for (at, name) in [(0, "in"), (2, "other")] {
            let folder = bench.path(&format!("{name}-planish"));
            assert_eq!(states[at].1, BakeState::Done(folder.clone()));
            let manifest = fs::read_to_string(folder.join(format!("{name}.planish.json"))).unwrap();
            assert!(manifest.contains("\"lambda\": 0.5") && !manifest.contains("\"mask\""), "{manifest}");
        }
        assert!(matches!(&states[1].1, BakeState::Failed(reason) if reason.contains("bad.obj: line 2")), "{states:?}");
        assert!(bench.app.messages().iter().any(|m| m.text == "baked 2 meshes; 1 failed: the list says why"));
        assert!(!bench.path("bad-planish").exists());
        bench.app.unlist(&bench.path("bad.obj"));
        assert_eq!(bench.app.meshes().len(), 2);
    }

    #[test]
    fn a_stopped_bake_of_all_leaves_no_mesh_half_done() {
        let mut bench = Bench::baked();
        bench.app.bake_all();
        bench.until("begun", |app| app.meshes()[0].state != BakeState::Waiting);
        bench.app.cancel(Work::BakeAll);
        bench.until("stopped", |app| app.status(Work::BakeAll).is_none());
        let folder = bench.path("in-planish");
        match &bench.app.meshes()[0].state {
            BakeState::Untouched => assert!(!folder.exists()),
            BakeState::Done(_) => assert!(folder.join("in.planish.json").exists()),
            state => panic!("{state:?}"),
        }
    }
}
