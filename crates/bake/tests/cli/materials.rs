//! Libraries and textures as other programs write their names.

use crate::folder::Folder;
use serde_json::Value;

/// A picture of one pixel.
fn pixel() -> Vec<u8> {
    let mut png = Vec::new();
    let image = image::DynamicImage::ImageRgb8(image::RgbImage::from_pixel(1, 1, image::Rgb([200, 100, 50])));
    image.write_to(&mut std::io::Cursor::new(&mut png), image::ImageFormat::Png).unwrap();
    png
}

/// A mesh that names a library and a material, the library under the name that it really has, and a texture `skin.png`.
fn scan(named: &str, file: &str, library: impl AsRef<[u8]>, used: &str) -> Folder {
    let folder = Folder::new();
    let mut obj = format!("mtllib {named}\nusemtl {used}\n");
    for i in 0..25 {
        let [x, y] = [i % 5, i / 5].map(|x| f64::from(x) / 4.0);
        obj += &format!("v {x} {y} {}\nvt {x} {y}\n", 0.05 * f64::from(i * i % 7));
    }
    for i in (0..24).filter(|i| i % 5 < 4 && *i < 20) {
        obj += &format!("f {0}/{0} {1}/{1} {2}/{2} {3}/{3}\n", i + 1, i + 2, i + 7, i + 6);
    }
    folder.write("in.obj", obj);
    folder.write(file, library);
    folder.write("skin.png", pixel());
    folder
}

const BAKE: &str = "bake in.obj -o out --method laplacian";

/// Bakes, and asserts that the material of the mesh has its texture, in the .glb and for the readers of the carrier. Returns what was
/// said on the way.
#[track_caller]
fn keeps_its_texture(folder: &Folder) -> String {
    let said = folder.succeeds(BAKE).err;
    let glb = folder.bytes("out/in.glb");
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let document: Value = serde_json::from_slice(&glb[20..20 + length]).unwrap();
    let shading = &document["materials"][0]["pbrMetallicRoughness"];
    assert!(shading["baseColorTexture"]["index"].is_number(), "{shading}; {said}");
    let (library, carrier) = (folder.text("out/in.mtl"), folder.text("out/in.obj"));
    let line = |text: &str, keyword: &str| {
        let found: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix(keyword)).collect();
        assert_eq!(found.len(), 1, "{keyword}: {text}");
        found[0].to_owned()
    };
    assert_eq!(line(&library, "newmtl "), line(&carrier, "usemtl "));
    let texture = line(&library, "map_Kd ");
    assert_eq!(folder.bytes(&format!("out/{texture}")), pixel());
    let info = folder.succeeds_with_json("info in.obj");
    assert_eq!(info["materials"][0]["texture_found"], true, "{info}");
    said
}

#[test]
fn libraries_are_read_however_they_are_written() {
    let plain = "newmtl skin\nKd 1 1 1\nmap_Kd skin.png\n";
    let utf16: Vec<u8> = "\u{feff}".encode_utf16().chain(plain.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    let spellings: [(&[u8], &str); 6] = [
        (plain.as_bytes(), "skin"),
        (b"\xef\xbb\xbfnewmtl skin\r\nmap_Kd skin.png\r\n", "skin"),
        (&utf16, "skin"),
        (b"NEWMTL skin\nKD 1 1 1\nmap_kd skin.png\n", "skin"),
        (b"newmtl \"skin\"\nmap_Kd \"skin.png\"\n", "skin"),
        (b"newmtl skin\nmap_Kd skin.png\n", "\"skin\""),
    ];
    for (library, used) in spellings {
        let said = keeps_its_texture(&scan("in.mtl", "in.mtl", library, used));
        assert!(!said.contains("material"), "{said}");
    }
}

#[test]
fn libraries_and_textures_of_another_machine_are_found_beside_the_mesh_with_a_note() {
    for (named, file, texture) in [
        ("meshes\\in.mtl", "in.mtl", "skin.png"),
        ("C:\\Users\\me\\in.mtl", "in.mtl", "D:\\textures\\skin.png"),
        ("IN.MTL", "in.mtl", "Skin.PNG"),
        ("\"my in.mtl\"", "my in.mtl", "/home/me/skin.png"),
        ("/data/My In.mtl", "my in.mtl", "textures/skin.png"),
    ] {
        let folder = scan(named, file, format!("newmtl skin\nmap_Kd {texture}\n"), "skin");
        let said = keeps_its_texture(&folder);
        let notes = said.lines().filter(|line| line.contains("beside the mesh is used")).count();
        let moved = usize::from(named.trim_matches('"') != file) + usize::from(texture != "skin.png");
        assert_eq!(notes, moved, "{said}");
        let info = folder.succeeds_with_json("info in.obj");
        let noted = info["notes"].as_array().unwrap().iter();
        assert_eq!(noted.filter(|note| note.as_str().unwrap().contains("beside the mesh")).count(), moved, "{info}");
    }
}

#[test]
fn materials_that_no_library_defines_are_told() {
    let folder = scan("in.mtl", "in.mtl", "newmtl other\n", "skin");
    let said = folder.succeeds(BAKE).err;
    assert!(said.contains("materials without a definition: skin; no library defines them"), "{said}");
    let info = folder.succeeds_with_json("info in.obj");
    assert!(info["notes"].to_string().contains("without a definition: skin"), "{info}");
    // A library that is not there is told already.
    std::fs::remove_file(folder.path("in.mtl")).unwrap();
    let said = folder.succeeds(BAKE).err;
    assert!(said.contains("in.mtl: ") && !said.contains("without a definition"), "{said}");
}

#[test]
fn maps_that_the_carrier_replaces_are_told() {
    let folder =
        scan("in.mtl", "in.mtl", "newmtl skin\nmap_Bump -bm 0.5 my bumps.png\nnorm n.png\nmap_Kd skin.png\n", "skin");
    let said = keeps_its_texture(&folder);
    assert!(said.contains("the carrier has maps of its own instead of my bumps.png, n.png"), "{said}");
}

#[test]
fn what_a_gltf_file_has_no_place_for_is_named() {
    let library = "newmtl skin\nmap_Kd skin.png\nmap_Ke skin.png\nmap_Ks skin.png\nrefl r.png\nmap_Bump bump.png\n";
    let folder = scan("in.mtl", "in.mtl", library, "skin");
    let said = keeps_its_texture(&folder);
    assert!(said.contains("in.glb lacks map_Ks, refl of the materials, for which glTF has no place"), "{said}");
    let said = folder.succeeds(&format!("{BAKE} --no-glb")).err;
    assert!(!said.contains("map_Ks"), "{said}");

    // The carrier keeps a picture that cannot be read.
    let folder = scan("in.mtl", "in.mtl", "newmtl skin\nmap_Kd skin.gif\n", "skin");
    folder.write("skin.gif", b"GIF89a");
    let said = folder.succeeds(BAKE).err;
    assert!(
        said.contains("skin.gif: is neither a PNG, a JPEG, a TGA nor a BMP file; the glTF file will lack this texture"),
        "{said}"
    );
    assert!(folder.text("out/in.mtl").contains("map_Kd ../skin.gif"));
}

#[test]
fn pictures_that_gltf_does_not_take_are_converted() {
    let library = "newmtl skin\nmap_Kd skin.tga\nmap_Ke glow.bmp\nmap_Pr rough.png\nmap_Pm skin.tga\nmap_d holes.png\n\
                   norm skin.png\n";
    let folder = scan("in.mtl", "in.mtl", library, "skin");
    folder.write("skin.tga", [0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 1, 0, 24, 0, 1, 2, 3]);
    let dib =
        [&b"BM\x3a\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0\x01\0\0\0\x01\0\0\0\x01\0\x18\0"[..], &[0; 24], &[4, 5, 6, 0]];
    folder.write("glow.bmp", dib.concat());
    folder.write("rough.png", pixel());
    folder.write("holes.png", pixel());
    let said = folder.succeeds(BAKE).err;
    assert!(!said.contains("lack"), "{said}");
    let glb = folder.bytes("out/in.glb");
    let length = |at: usize| u32::from_le_bytes(glb[at..at + 4].try_into().unwrap()) as usize;
    let (json, binary) = (&glb[20..20 + length(12)], &glb[28 + length(12)..]);
    let document: Value = serde_json::from_slice(json).unwrap();
    let texel = |texture: &Value| {
        let index = |value: &Value| value.as_u64().unwrap_or(0) as usize;
        let image = &document["images"][index(&document["textures"][index(&texture["index"])]["source"])];
        assert_eq!(image["mimeType"], "image/png");
        let view = &document["bufferViews"][index(&image["bufferView"])];
        let first = index(&view["byteOffset"]);
        let bytes = &binary[first..first + index(&view["byteLength"])];
        image::load_from_memory(bytes).unwrap().into_rgba8().get_pixel(0, 0).0
    };
    let material = &document["materials"][0];
    let shading = &material["pbrMetallicRoughness"];
    // Luma of (200, 100, 50) is 118, and of (3, 2, 1) it is 2.
    assert_eq!((texel(&shading["baseColorTexture"]), &material["alphaMode"]), ([3, 2, 1, 118], &"MASK".into()));
    assert_eq!(texel(&shading["metallicRoughnessTexture"]), [255, 118, 2, 255]);
    assert_eq!(texel(&material["emissiveTexture"]), [6, 5, 4, 255]);
    assert_eq!(texel(&material["normalTexture"]), [200, 100, 50, 255]);
}
