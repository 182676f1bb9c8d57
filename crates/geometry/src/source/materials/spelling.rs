//! Libraries as exporters write them: with a byte order mark, in UTF-16, with keywords in any case and names in quotes.

use super::{is_texture_keyword, keyword};
use crate::source::MeshData;
use rustc_hash::FxHashMap;
use std::borrow::Cow;

/// Keywords in the spelling of the format and of the extensions that clients read.
pub(super) const KEYWORDS: &[&str] = &[
    "newmtl",
    "Ka",
    "Kd",
    "Ks",
    "Ke",
    "Km",
    "Tf",
    "Ns",
    "Ni",
    "d",
    "Tr",
    "illum",
    "sharpness",
    "aniso",
    "anisor",
    "Pr",
    "Pm",
    "Ps",
    "Pc",
    "Pcr",
    "bump",
    "disp",
    "decal",
    "refl",
    "norm",
    "map_Ka",
    "map_Kd",
    "map_Ks",
    "map_Ke",
    "map_Ns",
    "map_d",
    "map_bump",
    "map_Bump",
    "map_Pr",
    "map_Pm",
    "map_Ps",
    "map_refl",
];

/// Returns a material library in the usual spelling: UTF-8 without byte order mark, keywords in their usual case, files without
/// quotes, and materials with or without quotes as `mesh` names them. All else stays as it is.
pub fn usual_spelling(library: &[u8], mesh: &MeshData) -> Vec<u8> {
    let mut names: FxHashMap<&[u8], &[u8]> = FxHashMap::default();
    for name in mesh.materials() {
        let name = name.as_slice();
        match unquoted(name) {
            // A name without quotes counts more than the same one in quotes.
            bare if bare == name => _ = names.insert(bare, name),
            bare => _ = names.entry(bare).or_insert(name),
        }
    }
    let text = utf8(library);
    let mut out = Vec::with_capacity(text.len());
    for line in text.split_inclusive(|&b| b == b'\n') {
        let statement = line.trim_ascii();
        match respelt(statement, &names) {
            Some(respelt) => {
                let start = line.len() - line.trim_ascii_start().len();
                out.extend_from_slice(&line[..start]);
                out.extend_from_slice(&respelt);
                out.extend_from_slice(&line[start + statement.len()..]);
            }
            None => out.extend_from_slice(line),
        }
    }
    out
}

/// The statement in its usual spelling; `None` if it has that.
fn respelt(statement: &[u8], names: &FxHashMap<&[u8], &[u8]>) -> Option<Vec<u8>> {
    let written = keyword(statement);
    let arguments = statement[written.len()..].trim_ascii();
    let usual = usual_keyword(written);
    let (options, name) = match &*usual {
        b"newmtl" => {
            let bare = unquoted(arguments);
            (&[][..], names.get(bare).copied().unwrap_or(bare))
        }
        keyword if is_texture_keyword(keyword) => file_in_quotes(arguments).unwrap_or((&[][..], arguments)),
        _ => (&[][..], arguments),
    };
    let space: &[u8] = if arguments.is_empty() { b"" } else { b" " };
    let respelt = [&*usual, space, options, name].concat();
    let differs = *usual != *written || options.len() + name.len() != arguments.len() || !arguments.ends_with(name);
    differs.then_some(respelt)
}

/// Splits arguments that end with a name in quotes into what stands before it and the name.
fn file_in_quotes(arguments: &[u8]) -> Option<(&[u8], &[u8])> {
    let start = arguments.iter().position(|&b| b == b'"')?;
    let is_word = start == 0 || arguments[start - 1].is_ascii_whitespace();
    let name = unquoted(&arguments[start..]);
    (is_word && name.len() + 2 == arguments.len() - start).then_some((&arguments[..start], name))
}

/// A name without the double quotes around it.
pub(super) fn unquoted(name: &[u8]) -> &[u8] {
    match name {
        [b'"', name @ .., b'"'] if !name.contains(&b'"') => name,
        _ => name,
    }
}

/// The usual spelling of a keyword: the one in the list that differs in case only, where it is not in the list itself.
fn usual_keyword(written: &[u8]) -> Cow<'_, [u8]> {
    let spelling =
        |same: &dyn Fn(&[u8]) -> bool| KEYWORDS.iter().map(|known| known.as_bytes()).find(|known| same(known));
    if spelling(&|known| known == written).is_some() {
        return written.into();
    }
    match spelling(&|known| known.eq_ignore_ascii_case(written)) {
        Some(known) => known.into(),
        None if written.len() > 4 && written[..4].eq_ignore_ascii_case(b"map_") => {
            [&b"map_"[..], &written[4..]].concat().into()
        }
        None => written.into(),
    }
}

/// Text without a byte order mark, and in UTF-8 if the mark says UTF-16.
fn utf8(library: &[u8]) -> Cow<'_, [u8]> {
    let utf16 = |bytes: &[u8], number: fn([u8; 2]) -> u16| -> Vec<u8> {
        let units = bytes.as_chunks::<2>().0.iter().map(|pair| number(*pair));
        char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect::<String>().into_bytes()
    };
    match library {
        [0xef, 0xbb, 0xbf, text @ ..] => text.into(),
        [0xff, 0xfe, text @ ..] => utf16(text, u16::from_le_bytes).into(),
        [0xfe, 0xff, text @ ..] => utf16(text, u16::from_be_bytes).into(),
        text => text.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::materials;
    use crate::source::obj::Obj;

    /// A library as a mesh sees it that uses a material.
    fn spelt(library: &[u8], uses: &str) -> String {
        let mesh = Obj::parse(format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl {uses}\nf 1 2 3\n").into_bytes()).unwrap();
        String::from_utf8(usual_spelling(library, mesh.data())).unwrap()
    }

    #[test]
    fn a_usual_library_stays_byte_for_byte() {
        let library = "# \"scan\"\r\n\nnewmtl a b\r\n  Kd 1 1 1\t\nmap_Kd -s 2 2 2 my \"own\" skin.png\nmap_Bump b\nmap_bump c\nfoo Bar\nd 1";
        assert_eq!(spelt(library.as_bytes(), "a b"), library);
    }

    #[test]
    fn marks_case_and_quotes_make_no_difference() {
        let usual = "newmtl my skin\nKd 1 0 0\n\tmap_Kd -s 2 2 2 my skin.png\r\nmap_foo a\nmap_Bump b.png\n";
        let odd = "NewMtl \"my skin\"\nKD 1 0 0\n\tmap_kd -s 2 2 2 \"my skin.png\"\r\nMAP_foo a\nMap_BUMP b.png\n";
        // Of two usual spellings that differ in case the first one stands for all others.
        assert_eq!(spelt(odd.as_bytes(), "my skin"), usual.replace("map_Bump", "map_bump"));
        let utf16: Vec<u16> = usual.encode_utf16().collect();
        let little = [vec![0xff, 0xfe], utf16.iter().flat_map(|unit| unit.to_le_bytes()).collect()].concat();
        let big = [vec![0xfe, 0xff], utf16.iter().flat_map(|unit| unit.to_be_bytes()).collect()].concat();
        for library in [[&b"\xef\xbb\xbf"[..], usual.as_bytes()].concat(), little, big] {
            assert_eq!(spelt(&library, "my skin"), usual);
        }
        let materials = materials::read(spelt(odd.as_bytes(), "my skin").as_bytes()).unwrap();
        assert_eq!(materials[0].name, "my skin");
        assert_eq!(materials[0].diffuse_texture.as_deref(), Some("my skin.png"));
    }

    #[test]
    fn materials_are_spelt_as_the_mesh_spells_them() {
        assert_eq!(spelt(b"newmtl skin\n", "\"skin\""), "newmtl \"skin\"\n");
        assert_eq!(spelt(b"newmtl \"skin\"\n", "skin"), "newmtl skin\n");
        assert_eq!(spelt(b"newmtl \"skin\"\n", "\"skin\""), "newmtl \"skin\"\n");
        assert_eq!(spelt(b"newmtl Skin\n", "skin"), "newmtl Skin\n");
        assert_eq!(spelt(b"newmtl\nnewmtl \"\n", "skin"), "newmtl\nnewmtl \"\n");
    }
}
