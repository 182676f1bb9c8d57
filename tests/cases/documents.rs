//! The documents speak of what is there: their links lead somewhere, the book has every page, the page on the manifest has every
//! field, and the page on noise every kind.

use crate::support::root;
use planish_geometry::bake::{self, BakeSettings, BundleNames, CurvatureMap, SideFiles};
use planish_geometry::map::occlusion::Occlusion;
use planish_geometry::mesh::synthetic_noise::{NoiseSetting, SyntheticKind};
use planish_geometry::mesh::weld::Welding;
use planish_geometry::progress::Silent;
use planish_geometry::source::model::Model;
use planish_geometry::source::obj::Obj;
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Every document of the repository that people read.
fn documents() -> Vec<PathBuf> {
    let mut folders = vec![root(), root().join("docs"), root().join("data"), root().join("tests/python")];
    folders.extend(root().join("crates").read_dir().unwrap().map(|entry| entry.unwrap().path()));
    let files = folders.iter().flat_map(|folder| folder.read_dir().unwrap()).map(|entry| entry.unwrap().path());
    files.filter(|path| path.extension().is_some_and(|extension| extension == "md")).collect()
}

/// The text without blocks of code.
fn prose(path: &Path) -> String {
    let text = fs::read_to_string(path).unwrap();
    text.split("\n```").step_by(2).collect::<Vec<_>>().join("\n")
}

/// Targets of the links and pictures of a document.
fn links(text: &str) -> impl Iterator<Item = &str> {
    text.split("](").skip(1).filter_map(|after| after.split_once(')')).map(|(target, _)| target)
}

/// The anchors that GitHub and mdBook give to the headings of a document.
fn anchors(path: &Path) -> BTreeSet<String> {
    let text = prose(path);
    let headings = text.lines().filter(|line| line.starts_with('#')).map(|line| line.trim_start_matches('#').trim());
    let kept = |c: char| (c.is_alphanumeric() || "-_ ".contains(c)).then_some(if c == ' ' { '-' } else { c });
    headings.map(|heading| heading.to_lowercase().chars().filter_map(kept).collect()).collect()
}

#[test]
fn every_link_leads_somewhere() {
    let mut count = 0;
    for document in documents() {
        let text = prose(&document);
        for link in links(&text).filter(|link| !link.contains("://") && !link.starts_with("mailto:")) {
            let (file, anchor) = link.split_once('#').map_or((link, None), |(file, anchor)| (file, Some(anchor)));
            let target = if file.is_empty() { document.clone() } else { document.parent().unwrap().join(file) };
            assert!(target.exists(), "{}: there is no {link}", document.display());
            let found = anchor.is_none_or(|anchor| anchors(&target).contains(anchor));
            assert!(found, "{}: {link} has no such heading", document.display());
            count += 1;
        }
    }
    assert!(count > 80, "{count} links");
}

#[test]
fn the_book_has_every_page() {
    let summary = fs::read_to_string(root().join("docs/SUMMARY.md")).unwrap();
    let listed: BTreeSet<_> = links(&summary).map(str::to_owned).collect();
    let pages = root().join("docs").read_dir().unwrap().map(|entry| entry.unwrap().file_name());
    let pages = pages.map(|name| name.into_string().unwrap());
    let pages: BTreeSet<_> = pages.filter(|name| name.ends_with(".md") && name != "SUMMARY.md").collect();
    assert_eq!(listed, pages);
}

/// Names of all fields of an object, and of objects inside it.
fn fields(value: &Value, out: &mut BTreeSet<String>) {
    match value {
        Value::Object(map) => {
            for (key, value) in map {
                out.insert(key.clone());
                fields(value, out);
            }
        }
        Value::Array(list) => list.iter().for_each(|value| fields(value, out)),
        _ => {}
    }
}

#[test]
fn every_field_of_a_manifest_is_documented() {
    let mesh = fs::read(root().join("data/duck_noisy.obj")).unwrap();
    let model = Model::new(Obj::parse(mesh).unwrap(), Welding::Exact);
    let names =
        BundleNames { source: "duck_noisy.obj".into(), stem: "duck_noisy".into(), carrier: "duck_noisy".into() };
    let occlusion = Some(Occlusion { rays: 1, distance: Some(1.0) });
    let settings = BakeSettings { side: Some(64), occlusion, curvature: CurvatureMap::Mean, ..BakeSettings::default() };
    let bundle = bake::bake(&model, &names, SideFiles::NONE, &settings, &Silent).unwrap();
    let json: Value = serde_json::from_slice(&bundle.files.last().unwrap().bytes).unwrap();
    let page = fs::read_to_string(root().join("docs/manifest.md")).unwrap();
    let (top, sections) = page.split_once("## `").unwrap();
    let mut count = 0;
    for (key, value) in json.as_object().unwrap() {
        assert!(top.contains(&format!("| `{key}`")), "docs/manifest.md does not mention {key}");
        let mut names = BTreeSet::new();
        fields(value, &mut names);
        let section = sections.split("## `").find(|section| section.starts_with(&format!("{key}`")));
        for name in names {
            let spelled = [format!("`{name}`"), format!(".{name}`"), format!("`{name}.")];
            let found = section.is_some_and(|section| spelled.iter().any(|spelling| section.contains(spelling)));
            assert!(found, "docs/manifest.md does not mention {key}.{name}");
            count += 1;
        }
    }
    assert!(count > 50);
}

#[test]
fn the_page_on_noise_has_every_kind_with_its_settings_and_no_other() {
    let page = fs::read_to_string(root().join("docs/noise.md")).unwrap();
    for kind in SyntheticKind::ALL {
        let row = page.lines().find(|line| line.starts_with(&format!("| `{}`", kind.name())));
        let settings =
            row.and_then(|row| row.rsplit('|').nth(1)).unwrap_or_else(|| panic!("no row of {}", kind.name()));
        for setting in NoiseSetting::ALL {
            let is_named = settings.contains(&format!("`--{}`", setting.name()));
            assert_eq!(is_named, kind.settings().contains(&setting), "{}: {}", kind.name(), setting.name());
        }
    }
}
