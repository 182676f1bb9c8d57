//! A model as Wavefront OBJ and MTL text.

use crate::model::Model;
use std::fmt::{Error, Write};

/// The `.obj` file.
pub(crate) fn obj(model: &Model) -> Result<String, Error> {
    let mut text = String::new();
    writeln!(text, "# {}", model.title)?;
    writeln!(text, "# Made by planish: cargo run --release -p planish-tests --bin make_data -- data")?;
    writeln!(text, "mtllib {}.mtl", model.name)?;
    writeln!(text, "o {}", model.name)?;
    for p in &model.positions {
        writeln!(text, "v {:.6} {:.6} {:.6}", p.x, p.y, p.z)?;
    }
    for uv in model.charts.iter().flat_map(|chart| &chart.uvs) {
        writeln!(text, "vt {:.6} {:.6}", uv.x, uv.y)?;
    }
    let mut group = None;
    let mut first_uv = 1;
    for chart in &model.charts {
        if group.replace(chart.group) != Some(chart.group) {
            let group = &model.groups[chart.group];
            writeln!(text, "g {}", group.name)?;
            writeln!(text, "usemtl {}", group.material.name)?;
        }
        for triangle in &chart.triangles {
            write!(text, "f")?;
            for k in triangle {
                write!(text, " {}/{}", chart.vertices[*k] + 1, first_uv + k)?;
            }
            writeln!(text)?;
        }
        first_uv += chart.uvs.len();
    }
    Ok(text)
}

/// The `.mtl` file beside it.
pub(crate) fn mtl(model: &Model) -> Result<String, Error> {
    let mut text = String::new();
    let mut written = Vec::new();
    for material in model.groups.iter().map(|group| group.material) {
        if written.contains(&material.name) {
            continue;
        }
        written.push(material.name);
        let [r, g, b] = material.diffuse;
        writeln!(text, "newmtl {}", material.name)?;
        writeln!(text, "Kd {r} {g} {b}")?;
        writeln!(text, "Ks {0} {0} {0}", material.specular)?;
        writeln!(text, "Ns {}", material.shininess)?;
        writeln!(text, "illum 2")?;
    }
    Ok(text)
}
