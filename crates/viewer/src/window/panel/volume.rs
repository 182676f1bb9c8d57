//! Part of the section on view and light that is about the volume.

use super::super::dialog::FilePurpose;
use super::super::ui_state::UiState;
use super::{choose, name};
use egui::Ui;
use planish_render::settings::Settings;
use planish_render::settings::environment::Part;
use planish_render::settings::volume::{Transfer, TransferPreset, VolumeDisplay, VolumeSource, VolumeView};

/// Chooses the volume, which is computed from the mesh or comes from a file, and how it is drawn.
pub(super) fn show(ui: &mut Ui, settings: &mut Settings, ui_state: &mut UiState) {
    let mut source = settings.volume.as_ref().map(|view| view.source.clone());
    let distance = match &source {
        Some(source @ VolumeSource::Distance { .. }) => source.clone(),
        _ => VolumeSource::default(),
    };
    let mut all = vec![("none".to_owned(), None), ("distance to the mesh".to_owned(), Some(distance))];
    if let Some(VolumeSource::File(path)) = &source {
        all.push((path.file_name().unwrap_or_default().to_string_lossy().into_owned(), source.clone()));
    }
    if let Some(VolumeSource::Raw(raw)) = &source {
        all.push((raw.file.file_name().unwrap_or_default().to_string_lossy().into_owned(), source.clone()));
    }
    ui.horizontal(|ui| {
        choose(ui, "volume", &mut source, all);
        if ui.small_button("…").on_hover_text("a volume in an NRRD file").clicked() {
            ui_state.ask(FilePurpose::Volume);
        }
    });
    match source {
        None => settings.volume = None,
        Some(source) => settings.volume.get_or_insert_default().source = source,
    }
    let Some(view) = &mut settings.volume else { return };
    choose(ui, "shown", &mut view.display, VolumeDisplay::ALL.iter().map(|d| (name(d), *d)));
    let presets = TransferPreset::ALL.iter().map(|p| (name(p), Transfer::Preset(*p)));
    let own =
        Some(("of the settings".to_owned(), view.transfer.clone())).filter(|(_, t)| matches!(t, Transfer::Points(_)));
    choose(ui, "colours", &mut view.transfer, presets.chain(own));
    let mut is_alone = view.mesh == Part::Hidden;
    if ui.checkbox(&mut is_alone, "without the mesh").changed() {
        view.mesh = if is_alone { Part::Hidden } else { Part::Shown };
    }
    ui.add(egui::Slider::new(&mut view.density, 0.01..=100.0).logarithmic(true).text("density"));
    ui.add(egui::Slider::new(&mut view.lighting, 0.0..=1.0).text("light inside"));
    planes(ui, view);
}

/// Slice planes, and the part of the box that is drawn.
fn planes(ui: &mut Ui, view: &mut VolumeView) {
    for (axis, words) in ["x", "y", "z"].into_iter().enumerate() {
        ui.horizontal(|ui| {
            let mut is_cut = view.slices[axis].is_some();
            let toggle = ui.checkbox(&mut is_cut, format!("slice {words}"));
            if toggle.changed() {
                view.slices[axis] = is_cut.then_some(0.5);
            }
            if let Some(share) = &mut view.slices[axis] {
                ui.add(egui::Slider::new(share, 0.0..=1.0)).labelled_by(toggle.id);
            }
        });
    }
    for (axis, words) in ["x", "y", "z"].into_iter().enumerate() {
        ui.horizontal(|ui| {
            let (low, high) = (view.low[axis], view.high[axis]);
            let label = ui.label(format!("part of {words}")).id;
            ui.add(egui::DragValue::new(&mut view.low[axis]).speed(0.005).range(0.0..=high - 0.01)).labelled_by(label);
            ui.label("to");
            ui.add(egui::DragValue::new(&mut view.high[axis]).speed(0.005).range(low + 0.01..=1.0)).labelled_by(label);
        });
    }
}
