//! The files of a displacement map that was baked before.

use crate::failure::Failure;
use crate::input;
use planish_geometry::map::displace::{self, MeshError, ShaderVertex};
use planish_geometry::map::displacement::Displacement;
use planish_geometry::map::manifest::Manifest;
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

    /// Path of a file by its name in the manifest, which is seen from the manifest's folder.
    pub fn beside(&self, name: &str) -> PathBuf {
        self.path.parent().unwrap_or(Path::new("")).join(name)
    }

    /// Path of the mesh that was baked.
    pub fn source(&self) -> PathBuf {
        self.beside(&self.manifest.source.file)
    }

    /// Path of the mesh that carries the map.
    pub fn carrier(&self) -> PathBuf {
        self.beside(&self.manifest.carrier.obj)
    }

    /// Path of the image with the heights or vectors.
    pub fn image(&self) -> PathBuf {
        self.beside(&self.manifest.displacement.file)
    }

    /// Reads and decodes the image.
    pub fn displacement(&self) -> Result<Displacement, Failure> {
        let (path, entry) = (self.image(), &self.manifest.displacement);
        let bytes = input::read(&path)?;
        Displacement::decode(&bytes, entry.map, entry.size(), entry.encoding()).map_err(|e| Failure::at(&path, e))
    }

    /// Vertices of a mesh that was read from `path`, as the map displaces them: one for each `v` line (#v). The mesh must be
    /// the one that was baked, or its carrier, byte for byte.
    pub fn vertices(&self, mesh: &Source, path: &Path) -> Result<Vec<ShaderVertex>, Failure> {
        let carrier = || input::obj(&self.carrier()).ok();
        displace::baked_vertices(mesh, &self.manifest, &carrier).map_err(|e| self.explain(e, path))
    }

    /// Says what is wrong with a mesh in the words of somebody who gave it together with the manifest.
    fn explain(&self, error: MeshError, mesh: &Path) -> Failure {
        let (manifest, path) = (&self.manifest, self.path.display());
        match error {
            MeshError::Foreign => {
                let reason = format!(
                    "is not the mesh that {path} belongs to: neither {} nor its carrier {}, byte for byte",
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
                let reason = format!("has the normals of the map, and is not the file that {path} names");
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
