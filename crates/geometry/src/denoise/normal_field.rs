//! Normals that a displacement map may go along: those of the mesh, or those of the denoised surface.

use crate::mesh::normals::{self, FaceWeight};
use crate::mesh::surface::Surface;
use crate::named;
use crate::named::Named;
use crate::source::model::{Model, NoFileNormals, NormalSource};
use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

/// Normals along which a displacement map displaces; in JSON one word.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(from = "NormalFieldName", into = "NormalFieldName")]
pub enum NormalField {
    /// Normals of the mesh that is denoised.
    Source(NormalSource),
    /// Angle-weighted normals of the denoised surface, as it is before heights leave anything out of it.
    Denoised,
    /// Normals of the denoised surface, tilted towards the displacement of those vertices around which heights along
    /// untilted normals would leave faces rotated: [`HeightField::tilted`](super::HeightField::tilted).
    Tilted,
}

impl Default for NormalField {
    fn default() -> Self {
        NormalSource::default().into()
    }
}

impl From<NormalSource> for NormalField {
    fn from(source: NormalSource) -> Self {
        Self::Source(source)
    }
}

impl NormalField {
    /// Name of the field, as in JSON and on the command line.
    pub fn name(self) -> &'static str {
        self.word().name
    }
    /// Unit normal of each vertex in single precision, as baker, carrier and shader use it; zero where there is none.
    /// δ (#V×3, model units) says where the denoised surface is. For [`Self::Tilted`] these are the untilted normals,
    /// because the tilt is found together with the heights. #V×3
    pub fn normals(self, model: &Model, deltas: &[DVec3]) -> Result<Vec<Vec3>, NoFileNormals> {
        match self {
            Self::Source(source) => model.displacement_normals(source),
            Self::Denoised | Self::Tilted => Ok(of_denoised(model.surface(), deltas)),
        }
    }

    /// Directions in which heights of a model's surface are measured.
    pub fn directions(self, model: &Model) -> Result<HeightDirections, NoFileNormals> {
        Ok(match self {
            Self::Source(source) => HeightDirections::Given(model.displacement_normals(source)?, source),
            Self::Denoised => HeightDirections::Denoised,
            Self::Tilted => HeightDirections::Tilted,
        })
    }
}

/// Directions in which heights are measured, one for each vertex.
#[derive(Clone, Debug, PartialEq)]
pub enum HeightDirections {
    /// Unit normals of the input (#V×3; zero where a vertex has none) and the source they were taken from.
    Given(Vec<Vec3>, NormalSource),
    /// Those of [`NormalField::Denoised`], which follow from the displacements.
    Denoised,
    /// Those of [`NormalField::Tilted`], which are found together with the heights.
    Tilted,
}

/// Angle-weighted normals of p − δ (#V×3, model units) in single precision. #V×3
pub(super) fn of_denoised(surface: &Surface, deltas: &[DVec3]) -> Vec<Vec3> {
    in_single_precision(&surface.at(surface.moved_by(deltas)))
}

/// Angle-weighted normals of a surface in single precision. #V×3
pub(super) fn in_single_precision(surface: &Surface) -> Vec<Vec3> {
    normals::vertex_normals(surface, FaceWeight::Angle).into_iter().map(DVec3::as_vec3).collect()
}

named! {
    /// Names of the values of [`NormalField`], as JSON and the command line spell them.
    pub enum NormalFieldName {
        /// Normals of the file, averaged at each vertex; angle-weighted where a vertex has none.
        File = "file",
        /// Mean of the normals of the faces.
        Uniform = "uniform",
        /// Mean of the normals of the faces, weighted by area.
        Area = "area",
        /// Mean of the normals of the faces, weighted by angle, as Blender's.
        Angle = "angle",
        /// Angle-weighted normals of the denoised surface.
        Denoised = "denoised",
        /// Angle-weighted normals of the denoised surface, tilted towards the displacement where its faces need it; for heights.
        Tilted = "leaning",
    }
}

impl Named for NormalField {
    const VALUES: &'static [Self] = &[
        Self::Source(NormalSource::File),
        Self::Source(NormalSource::Uniform),
        Self::Source(NormalSource::Area),
        Self::Source(NormalSource::Angle),
        Self::Denoised,
        Self::Tilted,
    ];
    const WORDS: &'static [named::Word] = NormalFieldName::WORDS;

    fn word(self) -> named::Word {
        NormalFieldName::from(self).word()
    }
}

impl From<NormalFieldName> for NormalField {
    fn from(word: NormalFieldName) -> Self {
        match word {
            NormalFieldName::File => Self::Source(NormalSource::File),
            NormalFieldName::Uniform => Self::Source(NormalSource::Uniform),
            NormalFieldName::Area => Self::Source(NormalSource::Area),
            NormalFieldName::Angle => Self::Source(NormalSource::Angle),
            NormalFieldName::Denoised => Self::Denoised,
            NormalFieldName::Tilted => Self::Tilted,
        }
    }
}

impl From<NormalField> for NormalFieldName {
    fn from(field: NormalField) -> Self {
        match field {
            NormalField::Source(NormalSource::File) => Self::File,
            NormalField::Source(NormalSource::Uniform) => Self::Uniform,
            NormalField::Source(NormalSource::Area) => Self::Area,
            NormalField::Source(NormalSource::Angle) => Self::Angle,
            NormalField::Denoised => Self::Denoised,
            NormalField::Tilted => Self::Tilted,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn in_json_a_field_is_one_word() {
        for (field, word) in [
            (NormalField::Source(NormalSource::File), "file"),
            (NormalField::Source(NormalSource::Uniform), "uniform"),
            (NormalField::Source(NormalSource::Area), "area"),
            (NormalField::Source(NormalSource::Angle), "angle"),
            (NormalField::Denoised, "denoised"),
            (NormalField::Tilted, "leaning"),
        ] {
            assert_eq!(serde_json::to_value(field).unwrap(), word);
            assert_eq!(serde_json::from_value::<NormalField>(word.into()).unwrap(), field);
        }
        let error = serde_json::from_str::<NormalField>("\"angel\"").unwrap_err().to_string();
        assert!(error.contains("unknown variant `angel`") && error.contains("`angle`"), "{error}");
    }
}
