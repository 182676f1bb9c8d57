//! The quantities that are compared with libigl, trimesh and scipy. The schema is that of `tests/python/freeze.py`.

use glam::DVec3;
use planish_geometry::denoise::{Boundary, Denoiser, EdgeWeights, Laplacian};
use planish_geometry::mesh::jagged::Index;
use planish_geometry::mesh::laplacian;
use planish_geometry::mesh::normals::{self, FaceWeight};
use planish_geometry::mesh::topology::EdgeKind;
use planish_geometry::mesh::weld::Welding;
use planish_geometry::progress::Silent;
use planish_geometry::source::model::Model;
use planish_geometry::source::obj::{Obj, ObjError};
use serde_json::{Value, json};

fn vectors(of: &[DVec3]) -> Value {
    json!(of.iter().map(glam::DVec3::to_array).collect::<Vec<_>>())
}

/// Everything about a triangle mesh; indices count from 0.
pub fn of(bytes: Vec<u8>) -> Result<Value, ObjError> {
    let model = Model::new(Obj::parse(bytes)?, Welding::None);
    let surface = model.surface();
    let topology = surface.topology();
    let vertices = 0..topology.vertex_count() as Index;
    let edges = |kind| {
        let all = (0..).zip(topology.edges());
        all.filter(|(e, _)| topology.edge_kind(*e) == kind).map(|(_, e)| *e).collect::<Vec<_>>()
    };
    let normals = |weight| vectors(&normals::vertex_normals(surface, weight));
    let smoothed = |weights, iterations| {
        let settings = Laplacian { iterations, step: 0.5, weights, boundary: Boundary::Fixed };
        // Nobody asks a silent computation to stop.
        let denoised = Denoiser::Laplacian(settings).denoised(surface, &Silent).unwrap_or_default();
        vectors(&denoised)
    };
    let steps = |weights| json!({ "1": smoothed(weights, 1), "10": smoothed(weights, 10) });
    let cotangent = laplacian::cotangent(surface);
    let entries = (0..).zip(cotangent.rows()).flat_map(|(i, row)| row.iter().map(move |&(j, w)| (i, j, w)));
    Ok(json!({
        "vertices": topology.vertex_count(),
        "faces": topology.faces().len(),
        "rings": topology.rings().iter().collect::<Vec<_>>(),
        "boundary_vertices": vertices.filter(|&v| topology.is_boundary(v)).collect::<Vec<_>>(),
        "boundary_edges": edges(EdgeKind::Boundary),
        "non_manifold_edges": edges(EdgeKind::NonManifold),
        "non_manifold_vertices": topology.non_manifold_vertices(),
        "face_normals": vectors(&normals::face_normals(surface)),
        "vertex_normals": {
            "uniform": normals(FaceWeight::Uniform),
            "area": normals(FaceWeight::Area),
            "angle": normals(FaceWeight::Angle),
        },
        "uniform_laplacian": vectors(&laplacian::uniform(topology, surface.positions())),
        "cotangent_laplacian": entries.collect::<Vec<(Index, Index, f64)>>(),
        "mass": laplacian::mass(surface),
        "smoothed_uniform": steps(EdgeWeights::Uniform),
        "smoothed_cotangent": steps(EdgeWeights::Cotangent),
        "mean_edge": surface.mean_edge(),
        "area": surface.area(),
        "volume": surface.volume(),
    }))
}
