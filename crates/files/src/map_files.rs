//! The files of a displacement map that was baked before.
//!
//! ```
//! use planish_files::{bake_files, input::Trust, map_files::MapFiles, output::Folder};
//! use planish_geometry::bake::BakeSettings;
//! use planish_geometry::denoise::Denoiser;
//! use planish_geometry::mesh::weld::Welding;
//! use planish_geometry::progress::Silent;
//! use planish_geometry::source::{model::Model, obj::Obj};
//!
//! # let folder = tempfile::tempdir()?;
//! # let text = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 1\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n";
//! # let model = Model::new(Obj::parse(text.into())?, Welding::Exact);
//! # let settings = BakeSettings { target: Denoiser::named("laplacian").unwrap().into(), ..BakeSettings::default() };
//! bake_files::bake_arrays(&model, "tent", &settings, &Silent)?.write(Folder::open(folder.path())?)?;
//!
//! let map = MapFiles::read(&folder.path().join("tent.planish.json"), Trust::Folder)?;
//! map.check_all()?;
//! let mesh = map.source_mesh(None)?;
//! // The last vertex is the top of a tent: 1 with the noise, and lower as λ grows.
//! let top = |lambda| map.displaced(&mesh, &map.source(), lambda).map(|positions| positions[4].z);
//! assert!((top(0.0)? - 1.0).abs() < 1e-6);
//! assert!(top(0.5)? < 0.9 && top(1.0)? < top(0.5)? - 0.1);
//!
//! // A file of another bake is refused.
//! std::fs::write(map.carrier(), "v 0 0 0\n")?;
//! assert!(map.check_all().unwrap_err().to_string().contains("is not the file that"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use crate::failure::Failure;
use crate::input::{self, LARGEST_MESH, LARGEST_PICTURE, NamedFile, Trust};
use crate::text::shown;
use glam::DVec3;
use planish_geometry::map::displace::{self, MeshError, ShaderVertex};
use planish_geometry::map::displacement::Displacement;
use planish_geometry::map::manifest::{self, Manifest, PageEntry, Target, UvSource};
use planish_geometry::source::Source;
use std::path::{Path, PathBuf};

/// A manifest that was read, and the paths of the files that it names.
#[derive(Clone, Debug)]
pub struct MapFiles {
    /// Path of the manifest.
    pub path: PathBuf,
    /// Content of the manifest.
    pub manifest: Manifest,
    /// Rule on the files that the manifest names; the mesh that was baked may lie anywhere.
    pub trust: Trust,
}

impl MapFiles {
    /// Reads the manifest, and none of the files that it names.
    pub fn read(path: &Path, trust: Trust) -> Result<Self, Failure> {
        Ok(Self { path: path.to_owned(), manifest: input::manifest(path)?, trust })
    }

    /// Path of a file that the manifest names; such names are relative to the manifest's folder.
    pub fn path_of(&self, name: &str) -> PathBuf {
        input::folder_of(&self.path).join(name)
    }

    /// Paths of all files of the bundle and of the mesh that was baked, none of which an output may overwrite.
    pub fn paths(&self) -> Vec<PathBuf> {
        let named = self.manifest.file_names().into_iter().map(|name| self.path_of(name));
        named.chain([self.path.clone(), self.source()]).collect()
    }

    /// Reads a file of the bundle. Fails if it is not the one that was written with the manifest.
    pub fn bytes_of(&self, name: &str, largest: u64) -> Result<Vec<u8>, Failure> {
        let path = self.path_of(name);
        let bytes = self.named(&path, self.trust, largest).read()?;
        match self.manifest.sha256_of(name) {
            Some(sha256) if sha256 != manifest::sha256(&bytes) => Err(self.foreign(&path)),
            _ => Ok(bytes),
        }
    }

    /// Checks that every file of the bundle is there and was written with the manifest.
    pub fn check_all(&self) -> Result<(), Failure> {
        self.manifest.file_names().into_iter().try_for_each(|name| self.bytes_of(name, LARGEST_MESH).map(drop))
    }

    /// Reads the mesh that was baked, from `path` or, without it, from where the manifest says. A name in a manifest leads to a
    /// plain file, which may lie outside of the folder, because a bundle lies beside its mesh.
    pub fn source_mesh(&self, path: Option<&Path>) -> Result<Source, Failure> {
        match path {
            Some(path) => input::source(path, self.trust),
            None => {
                let path = self.source();
                input::parse(self.named(&path, Trust::Anywhere, LARGEST_MESH).read()?, &path, self.trust)
            }
        }
    }

    /// Returns true if the mesh that was baked is still where the manifest says, byte for byte.
    pub fn has_source(&self) -> bool {
        let path = self.source();
        let bytes = self.named(&path, Trust::Anywhere, LARGEST_MESH).read();
        let identity = bytes.and_then(|bytes| input::identity(bytes, &path, self.trust));
        identity.is_ok_and(|bytes| manifest::sha256(&bytes) == self.manifest.source.sha256)
    }

    /// Reads the mesh that carries the map.
    pub fn carrier_mesh(&self) -> Result<Source, Failure> {
        input::parse(self.bytes_of(&self.manifest.carrier.obj, LARGEST_MESH)?, &self.carrier(), self.trust)
    }

    /// Reads the mesh that other means denoised, which may lie anywhere, as the mesh that was baked may.
    pub fn target_mesh(&self, target: &Target) -> Result<Source, Failure> {
        let path = self.path_of(&target.file);
        let bytes = self.named(&path, Trust::Anywhere, LARGEST_MESH).read()?;
        let mesh = input::parse(bytes, &path, self.trust)?;
        if manifest::sha256(&mesh.bytes()) == target.sha256 { Ok(mesh) } else { Err(self.foreign(&path)) }
    }

    fn named<'a>(&'a self, path: &'a Path, trust: Trust, largest: u64) -> NamedFile<'a> {
        NamedFile { path, folder: input::folder_of(&self.path), trust, largest }
    }

    /// Makes the error of a file that is not the one of the manifest.
    pub fn foreign(&self, path: &Path) -> Failure {
        Failure::at(path, format!("is not the file that {} was made with, byte for byte", shown(&self.path)))
    }

    /// Path of the mesh that was baked.
    pub fn source(&self) -> PathBuf {
        self.path_of(&self.manifest.source.file)
    }

    /// Path of the mesh that carries the map.
    pub fn carrier(&self) -> PathBuf {
        self.path_of(&self.manifest.carrier.obj)
    }

    /// Path of the mesh to displace for an output: the mesh that was baked if the output is in its format, so that the file keeps
    /// all it has, and the carrier is not; else the carrier.
    pub fn mesh_for(&self, output: &Path) -> PathBuf {
        let (source, carrier, format) = (self.source(), self.carrier(), input::format_of(output));
        let is_kept = format.is_some() && format == input::format_of(&source) && format != input::format_of(&carrier);
        let needs_carrier = self.manifest.displacement.uvs != UvSource::Mesh;
        if is_kept && !needs_carrier && self.has_source() { source } else { carrier }
    }

    /// Reads the mesh at a path that [`Self::mesh_for`] gave.
    pub fn mesh_at(&self, path: &Path) -> Result<Source, Failure> {
        if path == self.carrier() { self.carrier_mesh() } else { self.source_mesh(None) }
    }

    /// Names of the images with the heights or vectors: one, or one for each page.
    pub fn images(&self) -> Vec<&str> {
        match self.manifest.page_entries() {
            [] => vec![&self.manifest.displacement.file],
            pages => pages.iter().map(|page| page.file.as_str()).collect(),
        }
    }

    /// Reads and decodes the images: one, or one for each page.
    pub fn decoded_images(&self) -> Result<Vec<Displacement>, Failure> {
        let entry = &self.manifest.displacement;
        let pages = self.manifest.page_entries();
        let decode = |(i, name): (usize, &str)| {
            let page = pages.get(i);
            let path = self.path_of(name);
            let of_page = |reason: String| page.map_or(reason.clone(), |page| format!("page {}: {reason}", page.part));
            let bytes = self.bytes_of(name, LARGEST_PICTURE)?;
            let size = page.map_or(entry.size(), PageEntry::size);
            Displacement::decode(&bytes, entry.map, size, entry.encoding())
                .map_err(|e| Failure::at(&path, of_page(e.to_string())))
        };
        self.images().into_iter().enumerate().map(decode).collect()
    }

    /// Reads and decodes the map for a mesh that was read from `path`, and returns it with the vertices of the mesh as the map displaces
    /// them, one for each `v` line (#v). A map with pages becomes one with a texel for each of these vertices. Fails if the mesh is
    /// not, byte for byte, the one that was baked or its carrier.
    pub fn map_for(&self, mesh: &Source, path: &Path) -> Result<(Displacement, Vec<ShaderVertex>), Failure> {
        let mut images = self.decoded_images()?;
        let mut vertices = self.vertices(mesh, path)?;
        let map = if self.manifest.pages.is_some() {
            displace::gather(&images, mesh.data(), &self.manifest, &mut vertices)
        } else {
            images.swap_remove(0)
        };
        Ok((map, vertices))
    }

    /// Vertices of a mesh that was read from `path`, as the map displaces them: one for each `v` line (#v). Fails if the mesh is
    /// not, byte for byte, the one that was baked or its carrier.
    fn vertices(&self, mesh: &Source, path: &Path) -> Result<Vec<ShaderVertex>, Failure> {
        let carrier = || self.carrier_mesh().ok()?.into_obj();
        displace::baked_vertices(mesh, &self.manifest, &carrier).map_err(|e| self.explain(e, path))
    }

    /// Positions of the source vertices of a mesh that was read from `path`, displaced by the map with the strength λ. #v×3, model
    /// units. Fails as [`Self::map_for`] does, or if a vertex goes to infinity.
    pub fn displaced(&self, mesh: &Source, path: &Path, lambda: f64) -> Result<Vec<DVec3>, Failure> {
        let (map, vertices) = self.map_for(mesh, path)?;
        let displaced = displace::displaced(&vertices, &map, lambda as f32, self.manifest.displacement.origin);
        match displaced.iter().position(|p| !p.is_finite()) {
            Some(v) => {
                let place = input::vertex_place(mesh, v as u32);
                Err(Failure::at(path, format!("{place}the map displaces this vertex to infinity")))
            }
            None => Ok(displaced),
        }
    }

    /// Says why a mesh does not go with the manifest.
    pub fn explain(&self, error: MeshError, mesh: &Path) -> Failure {
        let (manifest, path) = (&self.manifest, shown(&self.path));
        match error {
            MeshError::Foreign => {
                let reason = format!(
                    "is not the mesh that {path} belongs to: it is neither {} nor its carrier {}, byte for byte",
                    manifest.source.file, manifest.carrier.obj
                );
                Failure::at(mesh, reason)
            }
            MeshError::NeedsCarrier => {
                let carrier = self.carrier();
                let reason = format!(
                    "lacks the texture coordinates of the map, which the bake made; use the carrier {}",
                    shown(&carrier)
                );
                Failure::at(mesh, reason)
            }
            MeshError::NeedsCarrierNormals => {
                let reason =
                    format!("is not the file that {path} names, and only that file has the normals of the map");
                Failure::at(&self.carrier(), reason)
            }
            MeshError::NoSuchElement { vertex, uv } => {
                let (v, vt) = (vertex + 1, uv + 1);
                let reason = format!("field `dominant_uv.seam_vertices`: the mesh has no vertex {v} or no `vt` {vt}");
                Failure::at(&self.path, reason)
            }
            MeshError::NoSuchInPage { page, vertex, uv } => {
                let (v, vt) = (vertex + 1, uv + 1);
                let reason = format!("page {page}: `seam_vertices`: the mesh has no vertex {v} or no `vt` {vt}");
                Failure::at(&self.path, reason)
            }
            e => Failure::at(mesh, e),
        }
    }
}
