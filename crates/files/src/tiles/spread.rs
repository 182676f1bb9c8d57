//! Spreads a mesh file into tiles.

use super::plan::{self, Plan, Split, of_tile};
use super::records::{Numbers, NumbersOut, failed};
use super::write::Pieces;
use crate::failure::Failure;
use glam::DVec3;
use planish_geometry::mesh::jagged::Index;
use planish_geometry::mesh::weld::Welding;
use planish_geometry::progress::Progress;
use planish_geometry::source::stream::{Piece, Receiver};
use std::path::Path;

/// How a mesh is cut.
#[derive(Clone, Debug)]
pub struct Cut {
    /// Name by which the caller knows the mesh and its cut.
    pub key: String,
    /// Number of tiles.
    pub tiles: usize,
    /// Rule of welding; by no distance, because that may chain vertices of several tiles.
    pub welding: Welding,
}

/// Number of tiles that a mesh can have: each has two files that are open at a time.
const MOST: usize = 400;
/// Number of positions that the cuts are found by.
const SAMPLE: usize = 1 << 18;
/// Largest absolute coordinate, model units. Lengths and areas of the anchor of a tile are far above those of the mesh.
const LARGEST_COORDINATE: f64 = 1e30;

/// Reads a mesh file piece by piece and spreads it into tiles in a folder, which exists. Memory is needed for two bytes for each
/// source vertex, and for what is read at a time.
pub fn spread(path: &Path, folder: &Path, cut: &Cut, progress: &dyn Progress) -> Result<Plan, Failure> {
    if !(1..=MOST).contains(&cut.tiles) {
        return Err(Failure::Input(format!("a mesh is cut into 1 to {MOST} tiles, not {}", cut.tiles)));
    }
    if let Welding::Epsilon(_) = cut.welding {
        return Err(Failure::Input(
            "vertices within a distance are not welded across tiles: weld by \"exact\"".to_owned(),
        ));
    }
    forget(folder)?;
    let raw = folder.join("faces");
    progress.stage("reading");
    let mut pieces = Pieces::open(path)?;
    let mut out = Raw {
        positions: NumbersOut::create(plan::positions(folder))?,
        faces: NumbersOut::create(raw.clone())?,
        vertices: 0,
        count: 0,
        bounds: [DVec3::INFINITY, DVec3::NEG_INFINITY],
        failure: None,
    };
    pieces.each(progress, |stream, bytes, is_last| {
        let taken = stream.read(Piece { bytes, is_last }, &mut out).map_err(|e| Failure::at(path, e))?;
        out.failure.take().map_or(Ok(taken), Err)
    })?;
    pieces.stream.finish().map_err(|e| Failure::at(path, e))?;
    let Raw { positions, faces, vertices, count, bounds, .. } = out;
    positions.finish()?;
    faces.finish()?;
    if bounds.iter().any(|corner| corner.abs().max_element() > LARGEST_COORDINATE) {
        return Err(Failure::at(path, format!("a coordinate is larger than {LARGEST_COORDINATE:e}; scale the mesh")));
    }
    progress.stage("spreading");
    let split = Split::of(&mut sample(folder, vertices)?, cut.tiles);
    let (tile_of, tiles) = spread_vertices(folder, &split, vertices, cut.tiles)?;
    progress.check()?;
    spread_faces(folder, &raw, &tile_of, count, progress)?;
    std::fs::remove_file(&raw).map_err(failed(&raw))?;
    let plan = Plan { key: cut.key.clone(), vertices, faces: count, tiles, welding: cut.welding, bounds };
    plan.write(folder)?;
    Ok(plan)
}

/// Removes the tiles of another mesh or cut, and what was made of them.
fn forget(folder: &Path) -> Result<(), Failure> {
    let entries = std::fs::read_dir(folder).map_err(failed(folder))?;
    let ours = |name: &str| name.starts_with("tile-") || name == "plan.json";
    for entry in entries.filter_map(Result::ok).filter(|entry| entry.file_name().to_str().is_some_and(ours)) {
        std::fs::remove_file(entry.path()).map_err(failed(&entry.path()))?;
    }
    Ok(())
}

/// Elements of a mesh on their way to files.
struct Raw {
    positions: NumbersOut,
    faces: NumbersOut,
    vertices: usize,
    count: usize,
    bounds: [DVec3; 2],
    failure: Option<Failure>,
}

impl Receiver for Raw {
    fn vertex(&mut self, position: DVec3) {
        self.vertices += 1;
        self.bounds = [self.bounds[0].min(position), self.bounds[1].max(position)];
        if let Err(e) = self.positions.position(position) {
            self.failure.get_or_insert(e);
        }
    }
    fn face(&mut self, vertices: &[Index]) {
        self.count += 1;
        let mut numbers = [vertices.len() as u32].into_iter().chain(vertices.iter().copied());
        if let Err(e) = numbers.try_for_each(|n| self.faces.index(n)) {
            self.failure.get_or_insert(e);
        }
    }
}

/// Positions of every so many vertices.
fn sample(folder: &Path, vertices: usize) -> Result<Vec<DVec3>, Failure> {
    let mut positions = Numbers::open(plan::positions(folder))?;
    let every = vertices.div_ceil(SAMPLE).max(1);
    let mut sample = Vec::with_capacity(vertices / every + 1);
    for v in 0..vertices {
        let position = positions.position()?;
        sample.extend((v % every == 0).then_some(position));
    }
    Ok(sample)
}

/// Writes the vertices of each tile, ascending, and returns the tile of each vertex and the number of vertices of each tile.
fn spread_vertices(
    folder: &Path,
    split: &Split,
    vertices: usize,
    tiles: usize,
) -> Result<(Vec<u16>, Vec<usize>), Failure> {
    let mut positions = Numbers::open(plan::positions(folder))?;
    let mut files = files(folder, tiles, "vertices")?;
    let (mut tile_of, mut counts) = (Vec::with_capacity(vertices), vec![0; tiles]);
    for v in 0..vertices {
        let position = positions.position()?;
        let tile = split.tile(position);
        tile_of.push(tile);
        counts[usize::from(tile)] += 1;
        let file = &mut files[usize::from(tile)];
        file.index(v as u32)?;
        file.position(position)?;
    }
    files.into_iter().try_for_each(NumbersOut::finish)?;
    Ok((tile_of, counts))
}

/// Writes the faces at the vertices of each tile, ascending: index, number of corners, and the vertex and tile of each corner.
fn spread_faces(
    folder: &Path,
    raw: &Path,
    tile_of: &[u16],
    count: usize,
    progress: &dyn Progress,
) -> Result<(), Failure> {
    let mut faces = Numbers::open(raw.to_path_buf())?;
    let tiles = tile_of.iter().max().map_or(0, |highest| usize::from(*highest) + 1);
    let mut files = files(folder, tiles, "faces")?;
    let (mut corners, mut to) = (Vec::new(), Vec::new());
    for f in 0..count {
        corners.clear();
        for _ in 0..faces.index()? {
            let v = faces.index()?;
            corners.push((v, tile_of[v as usize]));
        }
        to.clear();
        to.extend(corners.iter().map(|(_, tile)| *tile));
        to.sort_unstable();
        to.dedup();
        for tile in &to {
            let file = &mut files[usize::from(*tile)];
            file.index(f as u32)?;
            file.index(corners.len() as u32)?;
            for (v, tile) in &corners {
                file.index(*v)?;
                file.index((*tile).into())?;
            }
        }
        if f % (1 << 20) == 0 {
            progress.check()?;
            progress.done(f as f64 / count as f64);
        }
    }
    files.into_iter().try_for_each(NumbersOut::finish)
}

fn files(folder: &Path, tiles: usize, what: &str) -> Result<Vec<NumbersOut>, Failure> {
    (0..tiles).map(|tile| NumbersOut::create(of_tile(folder, tile, what))).collect()
}
