//! Draft of a bundle: maps, carrier and manifest, which are measured before they are handed out and may be discarded.

use super::carrier::{self, CarrierFile};
use super::describe::{manifest_of, statements};
use super::glb;
use super::maps::Maps;
use super::report::{self, Verification};
use super::shading_maps::ShadingMaps;
use super::{BakeError, Bundle, BundleFile, Carriers, Fallback, LayoutChoice, Request, VertexDisplacements};
use crate::map::Texels;
use crate::map::displace::DisplacementDirections;
use crate::map::manifest::{self, Carrier, FileEntry, Layout, Manifest, UvSource};
use crate::map::map_size::{MapSizeChoice, MapSizeReason};
use crate::mesh::atlas::Atlas;
use crate::source::materials;
use crate::source::model::Model;
use glam::IVec2;
use rayon::prelude::*;

/// Maps, carrier and manifest of a bake whose report decides whether they are kept.
pub(super) struct Draft {
    atlas: Option<Atlas>,
    pub(super) carrier: CarrierFile,
    pub(super) maps: Maps,
    /// Maps of shading, which are baked last, because other drafts may be discarded.
    pub(super) shading: ShadingMaps,
    pub(super) manifest: Manifest,
}

impl Draft {
    /// Makes maps, carrier and a manifest without a report. `original` is the model before unwrapping, if it was
    /// unwrapped.
    pub(super) fn new(
        request: &Request,
        displacements: &VertexDisplacements,
        original: Option<&Model>,
    ) -> Result<Self, BakeError> {
        let Request { model, names, settings, progress, .. } = *request;
        progress.stage("layout");
        let atlas = request.atlas()?;
        let tile = if atlas.is_some() { request.tile()? } else { IVec2::ZERO };
        let library_file = format!("{}.mtl", names.carrier);
        // Writing and reading a text file keeps one thread as busy as the maps keep the others.
        let ((source_sha256, carrier), maps) = rayon::join(
            || {
                let uvs = atlas.is_none().then(|| carrier::texel_uvs(model));
                let carrier = CarrierFile::make(model, &displacements.normals, uvs.as_deref(), &library_file);
                (manifest::sha256(&original.unwrap_or(model).source().bytes()), carrier)
            },
            || Maps::bake(request, atlas.as_ref(), displacements),
        );
        let (carrier, maps) = (carrier?, maps?);
        progress.check()?;
        let mut manifest = manifest_of(request, displacements, atlas.as_ref(), tile, &maps);
        manifest.source.sha256 = source_sha256;
        if manifest.displacement.layout == Layout::Uv {
            manifest.displacement.uvs = if original.is_some() { UvSource::Unwrapped } else { UvSource::Mesh };
        }
        let glb = (settings.carriers == Carriers::ObjAndGlb).then(|| format!("{}.glb", names.carrier));
        manifest.carrier =
            Carrier { obj: format!("{}.obj", names.carrier), mtl: library_file, glb, sha256: carrier.sha256.clone() };
        Ok(Self { atlas, carrier, maps, shading: ShadingMaps::default(), manifest })
    }

    /// Measures the errors of the files and puts the report into the manifest.
    pub(super) fn measure(&mut self, request: &Request, displacements: &VertexDisplacements) -> Result<(), BakeError> {
        request.progress.stage("verifying");
        let verification = Verification {
            model: request.model,
            displacements,
            frames: &self.maps.frames,
            offsets: &self.maps.offsets,
            findings: self.maps.findings.clone(),
            pages: self.maps.paging.as_ref().map(|paging| &paging.pages),
            channels: self.maps.images.iter().map(|image| image.channels.as_slice()).collect(),
            images: self.maps.images.iter().map(|image| image.displacement.as_slice()).collect(),
            carrier: self.carrier.obj.data(),
        };
        self.manifest.report = report::measure(&verification, &self.manifest)?;
        Ok(())
    }

    /// Reason to give each vertex a texel of its own after all, if vertices miss their height. The errors measured on the
    /// written bytes decide, not the prediction of the plan.
    pub(super) fn fallback(&self, request: &Request) -> Option<Fallback> {
        let settings = request.settings;
        let unresolved = self.manifest.report.unresolved_vertices;
        let must_be_exact = settings.layout == LayoutChoice::Auto && settings.texels == Texels::Fitted;
        if !must_be_exact || unresolved == 0 || !self.maps.plan.is_uv() {
            return None;
        }
        let side = self.maps.images.iter().map(|image| image.size.width).max().unwrap_or(0);
        let vertices = request.model.surface().positions().len();
        let choice =
            MapSizeChoice { side, vertices, left: unresolved, reason: MapSizeReason::AlmostExact, largest: side };
        let problems = self.maps.findings.problems().into_iter().chain(self.maps.findings.crowding()).collect();
        Some(Fallback::Layout { choice, problems })
    }

    /// Makes the remaining files that the manifest names and returns all of them. `original` is the model before unwrapping, if it was
    /// unwrapped.
    pub(super) fn into_bundle(
        mut self,
        request: &Request,
        displacements: &VertexDisplacements,
        original: Option<&Model>,
    ) -> Result<Bundle, BakeError> {
        let Request { model, names, side_files, progress, backs, .. } = *request;
        self.shading = ShadingMaps::bake(request, self.atlas.as_ref(), &self.maps)?;
        self.manifest.occlusion = self.shading.occlusion.as_ref().map(|map| map.entry.clone());
        self.manifest.curvature = self.shading.curvature.as_ref().map(|map| map.entry.clone());
        let has_uvs = self.atlas.is_some();
        let statements = |material: &str| statements(&self.manifest, has_uvs, material);
        let library = materials::carrier_library(model.data(), side_files.libraries, statements, side_files.relocate);
        let binary = self.manifest.carrier.glb.as_ref().map(|_| {
            progress.stage("glTF");
            let Self { manifest, maps, shading, carrier, .. } = &self;
            let (carrier, normals) = (carrier.obj.data(), &displacements.normals[..]);
            glb::make(request, glb::Parts { manifest, maps, shading, carrier, normals, original })
        });
        let glb = binary.transpose()?;
        progress.check()?;
        let Self { carrier, maps, shading, mut manifest, .. } = self;
        let file = |name: &str, bytes| BundleFile { name: name.to_owned(), bytes };
        let mut files = Vec::new();
        for (page, image) in maps.images.into_iter().enumerate() {
            let (name, normal_map) = match manifest.page_entries().get(page) {
                Some(entry) => (&entry.file, &entry.normal_map),
                None => (&manifest.displacement.file, &manifest.normal_map),
            };
            files.push(file(name, image.displacement));
            files.extend(normal_map.as_ref().zip(image.normal_map).map(|(entry, map)| file(&entry.file, map.0)));
        }
        files.extend(shading.occlusion.map(|map| file(&map.entry.map.file, map.image)));
        files.extend(shading.curvature.map(|map| file(&map.entry.map.file, map.image)));
        files.push(file(&manifest.carrier.obj, carrier.obj.into_bytes()));
        files.push(file(&manifest.carrier.mtl, library));
        files.extend(manifest.carrier.glb.as_ref().zip(glb).map(|(name, bytes)| file(name, bytes)));
        files.extend_from_slice(side_files.within);
        let entry = |file: &BundleFile| FileEntry { file: file.name.clone(), sha256: manifest::sha256(&file.bytes) };
        manifest.files = files.par_iter().map(entry).collect();
        let json = manifest.to_json().into_bytes();
        // JSON has no word for NaN and infinity; a manifest with one could not be read. What is not written may differ.
        if Manifest::from_json(&json).map(|read| read.to_json().into_bytes()).as_ref() != Ok(&json) {
            return Err(BakeError::NotMeasurable);
        }
        files.push(file(&format!("{}.planish.json", names.stem), json));
        let (choice, fallback) = maps.plan.into_reasons();
        let weld = model.weld();
        let frames = if maps.frames.is_empty() { Vec::new() } else { weld.spread(&maps.frames) };
        let along = DisplacementDirections { normals: weld.spread(&displacements.normals), frames };
        let deviations = displacements.choice.as_ref().map_or_else(Vec::new, |choice| choice.deviations.clone());
        let shared_backs = backs.pairs().iter().filter(|pair| !backs.has_own_side(model, pair[0])).count();
        Ok(Bundle { files, manifest, choice, fallback, along, deviations, shared_backs })
    }
}
