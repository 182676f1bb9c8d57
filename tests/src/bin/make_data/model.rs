//! What a file holds: a mesh cut into charts, with groups and materials.

use crate::chart::Chart;
use crate::mesh::Mesh;
use glam::{DVec2, DVec3};

/// A surface finish, as `.mtl` files describe it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Material {
    pub(crate) name: &'static str,
    pub(crate) diffuse: [f64; 3],
    pub(crate) specular: f64,
    pub(crate) shininess: f64,
}

/// A named part of the mesh.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Group {
    pub(crate) name: &'static str,
    pub(crate) material: Material,
}

/// A textured mesh; charts are sorted by group and hold all of its triangles.
#[derive(Debug)]
pub(crate) struct Model {
    pub(crate) name: &'static str,
    pub(crate) title: &'static str,
    pub(crate) groups: Vec<Group>,
    pub(crate) positions: Vec<DVec3>,
    pub(crate) charts: Vec<Chart>,
}

impl Model {
    /// The model as a reader of the file will see it: six decimals everywhere.
    pub(crate) fn rounded(mut self) -> Self {
        // Adding zero turns −0 into 0.
        let round = |x: f64| (x * 1e6).round() / 1e6 + 0.0;
        self.positions = self.positions.iter().map(|p: &DVec3| p.map(round)).collect();
        for chart in &mut self.charts {
            chart.uvs = chart.uvs.iter().map(|uv: &DVec2| uv.map(round)).collect();
        }
        self
    }

    /// The closed surface, across all seams.
    pub(crate) fn mesh(&self) -> Mesh {
        let of_chart = |chart: &Chart| -> Vec<[usize; 3]> {
            chart.triangles.iter().map(|t| t.map(|k| chart.vertices[k])).collect()
        };
        let triangles = self.charts.iter().flat_map(of_chart).collect();
        Mesh { positions: self.positions.clone(), triangles }
    }
}
