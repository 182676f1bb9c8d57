//! Targets that read files by their path.

use planish_files::failure::Failure;
use planish_files::input::Trust;
use planish_files::mask::{self, MaskOption};
use planish_geometry::mesh::weld::Welding;
use planish_geometry::progress::Silent;
use planish_geometry::source::model::Model;
use planish_geometry::source::obj::Obj;
use planish_render::settings::volume::{Placement, VolumeSource};
use planish_viewer::volume;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// Writes the bytes to a file and returns its path. The folder is that of the process, and stays until it ends.
fn file(name: &str, data: &[u8]) -> PathBuf {
    static FOLDER: OnceLock<tempfile::TempDir> = OnceLock::new();
    let path = FOLDER.get_or_init(|| tempfile::tempdir().expect("a folder can be made")).path().join(name);
    std::fs::write(&path, data).expect("a file can be written");
    path
}

/// Fails if the message of a refusal is not one line, because the names and words in it are those of a stranger.
fn check_message(failure: &Failure) {
    let message = failure.to_string();
    assert!(!message.contains(char::is_control), "{message:?}");
}

/// Reads a volume in an NRRD file.
pub(super) fn nrrd(data: &[u8]) {
    let source = VolumeSource::File(file("volume.nrrd", data));
    match volume::load(&source, Placement::File, None, Trust::Folder, &Silent) {
        Ok(volume) => assert!(volume.range().low <= volume.range().high),
        Err(failure) => check_message(&failure),
    }
}

/// Reads a list of weights for a mesh of four vertices, and writes it again.
pub(super) fn weights(data: &[u8]) {
    let text = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\n".to_vec();
    let model = Model::new(Obj::parse(text).expect("a mesh"), Welding::Exact);
    let read = |data: &[u8]| {
        let path = file("weights.txt", data);
        let option: MaskOption = format!("weights:{}", path.display()).parse().expect("a mask");
        option.weights(model.source(), Path::new("mesh.obj"))
    };
    match read(data) {
        Err(failure) => check_message(&failure),
        Ok(known) => {
            let mut weights: Vec<f32> = known.weights.of(4, model.weld()).iter().map(|weight| *weight as f32).collect();
            weights.resize(4, 1.0);
            assert!(weights.iter().all(|weight| (0.0..=1.0).contains(weight)));
            let again = read(mask::list(&weights).as_bytes()).expect("a written list can be read");
            assert_eq!(again.weights, known.weights);
        }
    }
}
