//! Cuts a patch out of a baked mesh as a client displaces it that samples each wedge at its own texture coordinate, so that
//! cracks show: an OBJ without shared vertices, and for each of them how far off it is, in hundredths of the range.

use glam::{DVec3, Vec3};
use planish_geometry::bake::BakeTarget;
use planish_geometry::map::displace::{self, SamplingRule, ShaderVertex};
use planish_geometry::map::displacement::{Displacement, SampleAt};
use planish_geometry::map::manifest::{Manifest, Method};
use planish_geometry::progress::Silent;
use planish_geometry::source::model::Model;
use planish_geometry::source::obj::Obj;
use std::error::Error;
use std::fmt::Write as _;
use std::path::PathBuf;

const USAGE: &str = "usage: seam_patch NAME.planish.json V RADIUS OUT.obj OUT.txt (around the V-th vertex)";

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let mut next = || arguments.next().ok_or(USAGE);
    let path = PathBuf::from(next()?);
    let (centre, radius): (usize, f64) = (next()?.parse()?, next()?.parse()?);
    let [mesh, numbers] = [next()?, next()?];

    let manifest = Manifest::from_json(&std::fs::read(&path)?)?;
    let beside = |name: &str| std::fs::read(path.with_file_name(name));
    let entry = &manifest.displacement;
    let map = Displacement::decode(&beside(&entry.file)?, entry.map, entry.size(), entry.encoding())?;
    let carrier = Obj::parse(beside(&manifest.carrier.obj)?)?;
    let carrier = carrier.data();
    let vertices = displace::carrier_vertices(carrier, &SamplingRule::of(&manifest), entry.origin);
    let model = Model::new(Obj::parse(beside(&manifest.source.file)?)?, manifest.welding);
    let expected = model.weld().spread(&expected(&model, &manifest)?);
    let middle = *carrier.positions().get(centre.wrapping_sub(1)).ok_or(USAGE)?;

    let (mut obj, mut off, mut count) = (String::new(), String::new(), 0);
    for face in carrier.faces().iter() {
        let near = |p: usize| carrier.positions()[p].distance(middle) < radius;
        if !face.iter().all(|corner| near(corner.position as usize)) {
            continue;
        }
        for corner in face {
            let line = corner.position as usize;
            let own = corner.uv().map(|uv| SampleAt::Uv(carrier.uvs()[uv as usize].as_vec2()));
            let place: Vec3 = ShaderVertex { sample_at: own, ..vertices[line] }.displaced(&map, 1.0);
            writeln!(obj, "v {} {} {}", place.x, place.y, place.z)?;
            writeln!(off, "{}", 100.0 * (place.as_dvec3() + entry.origin).distance(expected[line]) / entry.scale)?;
        }
        let corners: Vec<String> = (count + 1..=count + face.len()).map(|k| k.to_string()).collect();
        writeln!(obj, "f {}", corners.join(" "))?;
        count += face.len();
    }
    std::fs::write(mesh, obj)?;
    std::fs::write(numbers, off)?;
    Ok(())
}

/// p − h·n of each vertex.
fn expected(model: &Model, manifest: &Manifest) -> Result<Vec<DVec3>, Box<dyn Error>> {
    let Method::Denoiser(denoising) = &manifest.method else { return Err("baked with --target".into()) };
    let target = BakeTarget::Method(denoising.clone());
    let displacements = target.displacements(model, manifest.displacement.map, Some(manifest.normals), &Silent)?;
    Ok(model.surface().moved_by(&displacements.deltas))
}
