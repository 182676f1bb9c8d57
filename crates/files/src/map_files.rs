//! The files of a displacement map that was baked before.

use crate::failure::Failure;
use crate::input;
use planish_geometry::map::displace::{self, MeshError, ShaderVertex};
use planish_geometry::map::displacement::Displacement;
use planish_geometry::map::manifest::{self, Manifest, UvSource};
use planish_geometry::source::Source;
use std::path::{Path, PathBuf};

/// A manifest that was read, and the paths of the files that it names.
#[derive(Clone, Debug)]
pub struct MapFiles {
    /// Path of the manifest.
    pub path: PathBuf,
    /// Content of the manifest.
    pub manifest: Manifest,
}

impl MapFiles {
    /// Reads the manifest, and none of the files that it names.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        Ok(Self { path: path.to_owned(), manifest: input::manifest(path)? })
    }

    /// Path of a file that the manifest names; such names are relative to the manifest's folder.
    pub fn path_of(&self, name: &str) -> PathBuf {
        self.path.parent().unwrap_or(Path::new("")).join(name)
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
        let is_unchanged =
            || input::identity(&source).is_ok_and(|bytes| manifest::sha256(&bytes) == self.manifest.source.sha256);
        let needs_carrier = self.manifest.displacement.uvs != UvSource::Mesh;
        if is_kept && !needs_carrier && is_unchanged() { source } else { carrier }
    }

    /// Path of the image with the heights or vectors.
    pub fn image(&self) -> PathBuf {
        self.path_of(&self.manifest.displacement.file)
    }

    /// Reads and decodes the image.
    pub fn displacement(&self) -> Result<Displacement, Failure> {
        let (path, entry) = (self.image(), &self.manifest.displacement);
        let bytes = input::read(&path)?;
        Displacement::decode(&bytes, entry.map, entry.size(), entry.encoding()).map_err(|e| Failure::at(&path, e))
    }

    /// Vertices of a mesh that was read from `path`, as the map displaces them: one for each `v` line (#v). Fails if the mesh is
    /// not, byte for byte, the one that was baked or its carrier.
    pub fn vertices(&self, mesh: &Source, path: &Path) -> Result<Vec<ShaderVertex>, Failure> {
        let carrier = || input::obj(&self.carrier()).ok();
        displace::baked_vertices(mesh, &self.manifest, &carrier).map_err(|e| self.explain(e, path))
    }

    /// Says why a mesh does not go with the manifest.
    fn explain(&self, error: MeshError, mesh: &Path) -> Failure {
        let (manifest, path) = (&self.manifest, self.path.display());
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
                    carrier.display()
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
            e @ (MeshError::Normals(_) | MeshError::Atlas(_)) => Failure::at(mesh, e),
        }
    }
}
