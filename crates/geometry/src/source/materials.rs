//! Material libraries: reading their materials, and adding the maps to those of a carrier.
//!
//! ```
//! use planish_geometry::source::materials::{self, MapStatements};
//! use planish_geometry::source::obj::{Obj, ObjError};
//!
//! let mesh = Obj::parse(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl skin\nf 1 2 3\n".to_vec())?;
//! let library = b"newmtl skin\nmap_Kd skin.png\n".to_vec();
//! assert_eq!(materials::read(&library).unwrap()[0].diffuse_texture.as_deref(), Some("skin.png"));
//! // The carrier is in a folder below, and has a normal map.
//! let maps = |_: &str| MapStatements { normal: Some("scan.normal.png"), ..MapStatements::default() };
//! let carrier = materials::carrier_library(mesh.data(), &[library], maps, |file| format!("../{file}"));
//! let text = String::from_utf8_lossy(&carrier);
//! assert!(text.starts_with("newmtl skin\nnorm scan.normal.png\nmap_Kd ../skin.png\n"), "{text}");
//! # Ok::<(), ObjError>(())
//! ```

mod spelling;

pub use spelling::usual_spelling;

use crate::source::MeshData;
use glam::IVec2;
use rustc_hash::FxHashSet;

/// Name of the material that carrier faces without a material get.
pub const CARRIER_MATERIAL: &str = "planish";

/// The properties of a material that planish uses.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Material {
    /// Name (`newmtl`).
    pub name: String,
    /// Diffuse colour (`Kd`): linear red, green and blue.
    pub diffuse: Option<[f32; 3]>,
    /// File of the diffuse texture (`map_Kd`), like all files without its options.
    pub diffuse_texture: Option<String>,
    /// File of the opacity (`map_d`).
    pub opacity_texture: Option<String>,
    /// Colour of the light that the material gives off (`Ke`): linear red, green and blue.
    pub emission: Option<[f32; 3]>,
    /// File of the colours of that light (`map_Ke`).
    pub emission_texture: Option<String>,
    /// Roughness (`Pr`), 0..=1.
    pub roughness: Option<f32>,
    /// File of the roughness (`map_Pr`).
    pub roughness_texture: Option<String>,
    /// Metalness (`Pm`), 0..=1.
    pub metallic: Option<f32>,
    /// File of the metalness (`map_Pm`).
    pub metallic_texture: Option<String>,
    /// File of the normals in tangent space (`norm`).
    pub normal_texture: Option<String>,
}

/// The material library cannot be read; the text says why.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the material library cannot be read: {0}")]
pub struct MaterialError(String);

/// Reads the materials of a library.
pub fn read(bytes: &[u8]) -> Result<Vec<Material>, MaterialError> {
    let plain = plain_colours(bytes);
    let (materials, _) = tobj::load_mtl_buf(&mut plain.as_slice()).map_err(|e| MaterialError(e.to_string()))?;
    let convert = |m: tobj::Material| {
        let others = m.unknown_param;
        let file = |arguments: &String| Some(file_name(arguments).to_owned()).filter(|name| !name.is_empty());
        let other = |keyword: &str| others.get(keyword).and_then(file);
        let number = |keyword: &str| others.get(keyword)?.split_whitespace().next()?.parse().ok();
        Material {
            name: m.name,
            diffuse: m.diffuse,
            diffuse_texture: m.diffuse_texture.as_ref().and_then(file),
            opacity_texture: m.dissolve_texture.as_ref().and_then(file),
            emission: m.emissive,
            emission_texture: other("map_Ke"),
            roughness: number("Pr"),
            roughness_texture: other("map_Pr"),
            metallic: number("Pm"),
            metallic_texture: other("map_Pm"),
            normal_texture: other("norm"),
        }
    };
    Ok(materials.into_iter().map(convert).collect())
}

/// Rewrites a library in UTF-8 with all colours as three numbers, because `tobj` panics at the legal `Kd 0.5` (grey) and
/// fails at `Kd spectral FILE` and `Kd xyz …`, which are left out.
fn plain_colours(bytes: &[u8]) -> Vec<u8> {
    let text = String::from_utf8_lossy(bytes);
    let mut out = String::with_capacity(text.len());
    for line in text.lines() {
        let mut words = line.split_whitespace();
        let keyword = words.next().unwrap_or("");
        if is_numeric(keyword) {
            let numbers: Vec<f32> = words.map_while(|w| w.parse().ok()).collect();
            let kept = match (numbers.as_slice(), keyword.starts_with('K')) {
                (&[], _) => continue,
                (&[r, g, b, ..], true) => format!("{keyword} {r} {g} {b}"),
                (&[grey, ..], true) => format!("{keyword} {grey} {grey} {grey}"),
                (&[x, ..], false) => format!("{keyword} {x}"),
            };
            out.push_str(&kept);
        } else {
            out.push_str(line);
        }
        out.push('\n');
    }
    out.into_bytes()
}

fn is_numeric(keyword: &str) -> bool {
    matches!(keyword, "Ka" | "Kd" | "Ks" | "Ke" | "Ns" | "Ni" | "d" | "Tr" | "illum")
}

/// Largest number of arguments of an option of a texture statement; `None` if the word is no option.
fn option_arguments(word: &str) -> Option<usize> {
    match word {
        "-blendu" | "-blendv" | "-bm" | "-boost" | "-cc" | "-clamp" | "-imfchan" | "-texres" | "-type" => Some(1),
        "-mm" => Some(2),
        // One to three numbers: the caller stops at the first word that is no number.
        "-o" | "-s" | "-t" => Some(3),
        _ => None,
    }
}

/// Finds the file name behind the options of a texture statement; the name may contain blanks.
pub fn file_name(arguments: &str) -> &str {
    let mut rest = arguments.trim();
    loop {
        let word = rest.split_whitespace().next().unwrap_or("");
        let Some(count) = option_arguments(word) else { return rest };
        rest = rest[word.len()..].trim_start();
        for _ in 0..count {
            let argument = rest.split_whitespace().next().unwrap_or("");
            let optional = matches!(word, "-o" | "-s" | "-t");
            if optional && argument.parse::<f32>().is_err() {
                break;
            }
            rest = rest[argument.len()..].trim_start();
        }
    }
}

/// Returns true if a statement names a texture file.
fn names_texture(keyword: &str) -> bool {
    is_texture_keyword(keyword.as_bytes())
}

fn is_texture_keyword(keyword: &[u8]) -> bool {
    keyword.starts_with(b"map_") || matches!(keyword, b"disp" | b"norm" | b"bump" | b"decal" | b"refl")
}

/// Returns true if a statement is left out of the library of a carrier, which has maps of its own.
fn is_replaced(keyword: &str) -> bool {
    matches!(keyword, "disp" | "norm" | "bump" | "map_bump" | "map_Bump")
}

/// Finds the files of the bump, normal and displacement maps that a library names, which the library of a carrier has no more.
pub fn replaced_maps(library: &[u8]) -> Vec<String> {
    let text = String::from_utf8_lossy(library);
    let statement = |line: &str| {
        let (keyword, arguments) = line.trim().split_once(char::is_whitespace)?;
        is_replaced(keyword).then(|| file_name(arguments).to_owned())
    };
    text.lines().filter_map(statement).collect()
}

/// Finds the files of all textures that a library names.
pub fn textures(library: &[u8]) -> Vec<String> {
    let text = String::from_utf8_lossy(library);
    let statement = |line: &str| {
        let (keyword, arguments) = line.trim().split_once(char::is_whitespace)?;
        names_texture(keyword).then(|| file_name(arguments).to_owned())
    };
    text.lines().filter_map(statement).collect()
}

/// Returns true if bytes are a material library: text with a `newmtl` statement. Any other file that a mesh names is none of ours,
/// and its content must not get into results.
pub fn is_library(bytes: &[u8]) -> bool {
    !bytes.contains(&0) && lines(bytes).any(|line| keyword(line) == b"newmtl")
}

/// Lines of a library, without the byte order mark at its start.
fn lines(library: &[u8]) -> impl Iterator<Item = &[u8]> {
    library.strip_prefix(b"\xef\xbb\xbf").unwrap_or(library).split(|&b| b == b'\n').map(<[u8]>::trim_ascii)
}

/// First word of a line.
fn keyword(line: &[u8]) -> &[u8] {
    line.split(u8::is_ascii_whitespace).next().unwrap_or_default()
}

/// Returns true if a statement belongs to the format, with its extensions for physically based shading, or is a comment.
fn is_statement(keyword: &str) -> bool {
    let is_known = spelling::KEYWORDS.iter().any(|known| known.eq_ignore_ascii_case(keyword));
    keyword.is_empty() || keyword.starts_with('#') || names_texture(keyword) || is_known
}

/// Statements that refer to the baked maps in the materials of a carrier.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MapStatements<'a> {
    /// Displacement map (`disp`).
    pub displacement: Option<DisplacementStatement<'a>>,
    /// File of the normal map (`norm`).
    pub normal: Option<&'a str>,
    /// Lower left corner of the tile of the texture coordinates, which clients take off by an offset of the image (`-o`).
    pub tile: IVec2,
}

/// The statement `disp -mm base gain file`, with which a client computes p + (base + gain · texel) · n.
#[derive(Clone, Debug, PartialEq)]
pub struct DisplacementStatement<'a> {
    /// File of the displacement map.
    pub file: &'a str,
    /// Height at texel 0, model units: −λ · bias, because clients add where planish subtracts.
    pub base: f64,
    /// Height at texel 1 minus that at texel 0, model units: −λ · scale.
    pub gain: f64,
}

/// Names of the materials that libraries define.
pub fn defined<'a>(libraries: &[&'a [u8]]) -> FxHashSet<&'a [u8]> {
    let statements = libraries.iter().flat_map(|library| lines(library)).filter(|line| keyword(line) == b"newmtl");
    statements.map(|line| line[b"newmtl".len()..].trim_ascii()).collect()
}

/// Writes the material library of a carrier: the user's libraries one after the other, with `disp -mm` and `norm` statements
/// for the maps in each material, which `maps` gives by the name of the material.
///
/// Earlier `disp`, `norm` and `bump` statements are left out, and names of texture files are passed through `relocate`,
/// because the carrier may be in another folder. What is no statement of the format is left out. Materials that no library defines
/// follow in grey, and [`CARRIER_MATERIAL`] if some faces have no material.
pub fn carrier_library<'a>(
    mesh: &MeshData,
    libraries: &[Vec<u8>],
    maps: impl Fn(&str) -> MapStatements<'a>,
    relocate: impl Fn(&str) -> String,
) -> Vec<u8> {
    let added = |material: &[u8]| {
        let MapStatements { displacement, normal, tile } = maps(&String::from_utf8_lossy(material));
        let offset = if tile == IVec2::ZERO { String::new() } else { format!("-o {} {} 0 ", -tile.x, -tile.y) };
        let displacement = displacement.map(|d| format!("disp -mm {:?} {:?} {offset}{}\n", d.base, d.gain, d.file));
        let normal = normal.map(|file| format!("norm {offset}{file}\n"));
        displacement.unwrap_or_default() + &normal.unwrap_or_default()
    };
    let mut out = Vec::new();
    for library in libraries {
        for line in library.strip_prefix(b"\xef\xbb\xbf").unwrap_or(library).split(|&b| b == b'\n') {
            let line = line.trim_ascii_end();
            // Names in any encoding are copied as bytes; only statements about textures are parsed.
            let text = String::from_utf8_lossy(line);
            let mut words = text.split_whitespace();
            match words.next().unwrap_or("") {
                keyword if is_replaced(keyword) => continue,
                // A library may be a file that was never meant to be one, with a `newmtl` somewhere.
                keyword if !is_statement(keyword) => continue,
                "newmtl" => {
                    out.extend_from_slice(line);
                    out.push(b'\n');
                    let name = line.trim_ascii_start()["newmtl".len()..].trim_ascii();
                    out.extend_from_slice(added(name).as_bytes());
                }
                keyword if names_texture(keyword) => {
                    let arguments = text.trim_start()[keyword.len()..].trim();
                    let name = file_name(arguments);
                    let options = &arguments[..arguments.len() - name.len()];
                    out.extend_from_slice(format!("{keyword} {options}{}\n", relocate(name)).as_bytes());
                }
                _ => {
                    out.extend_from_slice(line);
                    out.push(b'\n');
                }
            }
        }
    }
    let defined = defined(&libraries.iter().map(Vec::as_slice).collect::<Vec<_>>());
    // Clients displace by a material only, so each face needs one, even if its library is missing.
    let missing = mesh.materials().iter().map(Vec::as_slice).filter(|name| !defined.contains(*name));
    let unnamed = mesh.has_faces_without_material().then_some(CARRIER_MATERIAL.as_bytes());
    for name in missing.chain(unnamed) {
        out.extend_from_slice(b"newmtl ");
        out.extend_from_slice(name);
        let added = added(name);
        out.extend_from_slice(format!("\n{added}Kd 0.8 0.8 0.8\nKs 0.1 0.1 0.1\nNs 20\nillum 2\n").as_bytes());
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::obj::Obj;

    #[test]
    fn greys_and_spectra_do_not_stop_the_reader() {
        let library =
            b"newmtl a\nKd 0.5\nKs spectral x.rfl\nmap_Kd -s 2 2 -clamp on my skin.png\nnewmtl b\xff\nKd 1 0 0\n";
        let materials = read(library).unwrap();
        assert_eq!(materials[0].diffuse, Some([0.5; 3]));
        assert_eq!(materials[0].diffuse_texture.as_deref(), Some("my skin.png"));
        assert_eq!(materials[1].name, "b\u{fffd}");
    }

    #[test]
    fn every_texture_is_found() {
        let library = b"newmtl a\r\nmap_Ks -o 1 0 0 s.png\r\n\tbump -bm 0.3 b c.png \r\nKd 1 1 1\nnorm\n";
        assert_eq!(textures(library), ["s.png", "b c.png"]);
    }

    #[test]
    fn a_carrier_keeps_the_materials_and_adds_the_maps() {
        let library = b"# scan\r\nnewmtl skin\r\nKd 1 1 1\r\nmap_Kd -bm 1 old dir/t.png\r\nbump old.png\r\n".to_vec();
        let displacement = |file| Some(DisplacementStatement { file, base: 0.5, gain: -1.0 });
        let maps = |material: &str| match material {
            "skin" => MapStatements { displacement: displacement("a.png"), normal: Some("n.png"), tile: IVec2::ZERO },
            _ => MapStatements { displacement: displacement("b.png"), normal: None, tile: IVec2::new(1, -2) },
        };
        let obj = Obj::parse(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nusemtl skin\nf 3 2 1\n".to_vec()).unwrap();
        let out = carrier_library(obj.data(), &[library], maps, |name| format!("../{name}"));
        let text = String::from_utf8(out).unwrap();
        let first =
            "# scan\nnewmtl skin\ndisp -mm 0.5 -1.0 a.png\nnorm n.png\nKd 1 1 1\nmap_Kd -bm 1 ../old dir/t.png\n";
        assert!(text.starts_with(first), "{text}");
        assert!(text.contains("newmtl planish\ndisp -mm 0.5 -1.0 -o -1 2 0 b.png\nKd") && !text.contains("bump"));
    }
}
