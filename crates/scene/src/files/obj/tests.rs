//! Known answers of OBJ files given inline, awkward ones above all.

use crate::error::SceneError;
use crate::files::source::Source;
use crate::files::{LoadOptions, LoadedScene, load_from};
use crate::model::{
    AlphaMode, Channel, MaterialKind, Mtl, NO_INDEX, Scene, TexelLayout, Texels, TextureChannel,
    TextureContent,
};
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::texture::TextureWrap;
use std::borrow::Cow;
use std::path::{Path, PathBuf};

fn read(files: &[(&str, &str)]) -> Result<LoadedScene, SceneError> {
    read_bytes(&files.iter().map(|(name, text)| (*name, text.as_bytes())).collect::<Vec<_>>())
}

fn read_bytes(files: &[(&str, &[u8])]) -> Result<LoadedScene, SceneError> {
    let files: Vec<(PathBuf, Cow<'static, [u8]>)> =
        files.iter().map(|(name, bytes)| (PathBuf::from(name), Cow::Owned(bytes.to_vec()))).collect();
    let first = files[0].0.clone();
    load_from(Source::Memory(files), Path::new(&first), &LoadOptions::default())
}

fn scene(text: &str) -> Scene {
    read(&[("a.obj", text)]).unwrap().scene
}

fn warnings(files: &[(&str, &str)]) -> Vec<String> {
    read(files).unwrap().warnings.iter().map(|w| w.to_string()).collect()
}

fn error(text: &str) -> String {
    read(&[("a.obj", text)]).unwrap_err().to_string()
}

const FOUR: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 1\n";

#[test]
fn all_corner_forms() {
    let s = scene(&format!(
        "{FOUR}f 1 2 3\nf 1/1 2/2 3/3\nf 1//1 2//1 3//1\nf 1/1/1 2/2/1 -2/-1/-1\nf 1/ 2/ 3//"
    ));
    let t = &s.meshes[0].triangles;
    let none = [NO_INDEX; 3];
    assert!(t.iter().all(|t| t.positions == [0, 1, 2]));
    assert_eq!([t[0].uvs, t[1].uvs, t[2].uvs, t[3].uvs, t[4].uvs], [none, [0, 1, 2], none, [0, 1, 2], none]);
    assert_eq!([t[0].normals, t[2].normals, t[3].normals, t[4].normals], [none, [0; 3], [0; 3], none]);
}

#[test]
fn polygons_are_fans_and_continuations_join() {
    let s = scene(&format!("{FOUR}f 1 2 \\\r\n 3 4\r\n"));
    let corners: Vec<[u32; 3]> = s.meshes[0].triangles.iter().map(|t| t.positions).collect();
    assert_eq!(corners, [[0, 1, 2], [0, 2, 3]]);
}

#[test]
fn negative_indices_count_back_and_faces_may_come_first() {
    let s = scene("v 9 9 9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 5 5 5\nf 4 3 -1");
    let corners: Vec<[u32; 3]> = s.meshes[0].triangles.iter().map(|t| t.positions).collect();
    assert_eq!(corners, [[1, 2, 3], [3, 2, 4]]);
    assert_eq!(scene("f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0").meshes[0].triangles.len(), 1);
}

#[test]
fn vertices_with_weights_colours_and_odd_numbers() {
    let s = scene("v 1 2 3 1.0\nv +1 2.e1 -.5 0.1 0.2 nan\nv\t0  0\u{b} 0 # end\nf 1 2 3");
    assert_eq!(s.meshes[0].positions, [vec3(1.0, 2.0, 3.0), vec3(1.0, 20.0, -0.5), Vec3::ZERO]);
}

#[test]
fn stray_characters_warn_and_load() {
    let list = warnings(&[("a.obj", "v 0.23 1.99 -0.2200.\nv 1 0 0\nv 0 1 0\nf 1 2 3")]);
    assert_eq!(list, ["a.obj:1: stray characters after a number: \"-0.2200.\", read as -0.22"]);
}

#[test]
fn short_faces_are_left_out_and_counted() {
    let list = warnings(&[("a.obj", &format!("{FOUR}f 1 2\nf 3\nf\nf 1 2 3"))]);
    assert_eq!(list, ["a.obj:9: a face with fewer than 3 corners is left out (3 times in this file)"]);
    assert_eq!(
        warnings(&[("a.obj", "v 0 0 0\np 1\nl 1 1")]),
        ["a.obj: there is nothing to see: the file has no faces"]
    );
}

#[test]
fn bad_input_names_file_and_line() {
    for (text, expected) in [
        ("v 0 0", "a.obj:1: \"v\" needs 3 numbers, found 2"),
        ("# x\nv 0 a 0", "a.obj:2: \"a\" is not a number"),
        ("\nv nan 0 0", "a.obj:2: \"nan\" is not a finite number; mend the file"),
        ("v 0 -inf 0", "a.obj:1: \"-inf\" is not a finite number; mend the file"),
        ("v 0 1.#IND 0", "a.obj:1: \"1.#IND\" is not a finite number; mend the file"),
        ("v 0 0 2e12", "a.obj:1: 2e12 is out of range; numbers must be within 1e12"),
        ("v 0 0 1e39", "a.obj:1: \"1e39\" is not a finite number; mend the file"),
        ("vn 0 1", "a.obj:1: \"vn\" needs 3 numbers, found 2"),
        ("vt", "a.obj:1: \"vt\" needs 1 numbers, found 0"),
        ("v 0 0 0\nf 1 1 0", "a.obj:2: vertex index 0; indices count from 1"),
        ("v 0 0 0\nf 1 1 2\n", "a.obj:2: vertex index 2 is out of range; the file has 1"),
        ("v 0 0 0\nf 1 -1 -2", "a.obj:2: vertex index -2 is out of range; there are 1"),
        ("v 0 0 0\nf 1 1 1.5", "a.obj:2: \"1.5\" is not a corner; write v, v/vt, v//vn or v/vt/vn"),
        ("v 0 0 0\nf 1 1 1////", "a.obj:2: \"1////\" is not a corner; write v, v/vt, v//vn or v/vt/vn"),
        ("v 0 0 0\nf 1 1 /1", "a.obj:2: \"/1\" is not a corner; write v, v/vt, v//vn or v/vt/vn"),
        (
            "v 0 0 0\nf 1 1 99999999999999999999",
            "a.obj:2: vertex index 9223372036854775807 is out of range; there are 1",
        ),
    ] {
        let message = error(text);
        assert_eq!(message, expected, "{text:?}");
    }
}

#[test]
fn normals_and_texture_coordinates_that_do_not_exist_are_done_without() {
    let files = [("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1/7/1 2/0/9 3/-1/-1")];
    assert_eq!(
        warnings(&files),
        [
            "a.obj:5: texture coordinate index 0; indices count from 1; the corner goes without",
            "a.obj:5: texture coordinate index -1 is out of range; there are 0; the corner goes without",
            "a.obj:5: texture coordinate index 7 is out of range; the file has 0; such corners go without",
            "a.obj:5: normal index 9 is out of range; the file has 1; such corners go without",
        ]
    );
    let triangle = read(&files).unwrap().scene.meshes[0].triangles[0];
    assert_eq!((triangle.uvs, triangle.normals), ([NO_INDEX; 3], [0, NO_INDEX, 0]));
}

#[test]
fn faces_without_material_get_the_default() {
    let s = scene(&format!("{FOUR}f 1 2 3"));
    assert_eq!((s.materials.len(), s.materials[0].name.as_str()), (1, "default"));
    assert!(s.materials[0].is_default());
    // No default where every face has a material.
    let files =
        [("a.obj", &*format!("mtllib m.mtl\n{FOUR}usemtl x\nf 1 2 3")), ("m.mtl", "newmtl x\nKd 1 0 0")];
    assert_eq!(read(&files).unwrap().scene.materials.len(), 1);
}

#[test]
fn missing_materials_warn() {
    let text = format!("mtllib no.mtl\n{FOUR}usemtl red\nf 1 2 3\nusemtl \nf 1 2 3\nusemtl red\nf 1 2 3");
    assert_eq!(
        warnings(&[("a.obj", &text)]),
        [
            "a.obj:1: material file \"no.mtl\" is missing",
            "a.obj:10: unknown material \"red\"; the default is taken",
        ]
    );
}

#[test]
fn several_libraries_with_blanks_in_names_and_late_definitions() {
    let obj = format!(
        "usemtl a b\n{FOUR}f 1 2 3\nusemtl c#1\nf 1 2 3\nmtllib no.mtl my\\ own.mtl  one more.mtl x\\y.mtl"
    );
    let loaded = read(&[
        ("dir/a.obj", &obj),
        ("dir/my own.mtl", "newmtl a b\nKd 1 0 0\nnewmtl twice"),
        ("dir/one more.mtl", "newmtl c#1\nKd 0 1 0\nnewmtl twice"),
        ("dir/x/y.mtl", "newmtl e"),
    ])
    .unwrap();
    let names: Vec<&str> = loaded.scene.materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["a b", "twice", "c#1", "e"]);
    let used: Vec<u32> = loaded.scene.meshes[0].triangles.iter().map(|t| t.material).collect();
    assert_eq!(used, [0, 2]);
    let list: Vec<String> = loaded.warnings.iter().map(|w| w.to_string()).collect();
    assert_eq!(
        list,
        [
            "dir/a.obj:13: material file \"no.mtl\" is missing",
            "dir/one more.mtl:3: material \"twice\" is given twice; the first counts",
        ]
    );
}

#[test]
fn textures_are_read_once_and_broken_ones_warn() {
    let obj = format!("mtllib m.mtl\n{FOUR}usemtl a\nf 1/1 2/2 3/3");
    let mtl = "newmtl a\nmap_Kd C:\\old\\t.ppm\nnewmtl b\nmap_Kd t.ppm\nnewmtl c\nmap_Kd no.png\nnewmtl d\nmap_Kd m.mtl";
    let loaded = read(&[("a.obj", &obj), ("m.mtl", mtl), ("t.ppm", "P3\n1 1\n255\n255 0 0\n")]).unwrap();
    let textures: Vec<Option<u32>> = loaded.scene.materials.iter().map(|m| m.textures.color).collect();
    assert_eq!(textures, [Some(0), Some(0), None, None]);
    assert_eq!(loaded.scene.images[0].texels, Texels::new(TexelLayout::Bytes(3), 1, vec![0x0000_00ff]));
    let list: Vec<String> = loaded.warnings.iter().map(|w| w.to_string()).collect();
    assert_eq!(
        list,
        [
            "m.mtl:6: texture \"no.png\" is missing; the surface is untextured",
            "m.mtl:8: texture: m.mtl: this is no picture of a kind that is read: PNG, JPEG, PPM, HDR, EXR, BMP, TGA and .data; the surface is untextured",
        ]
    );
}

#[test]
fn what_is_no_obj_file_is_one_error() {
    let error = |bytes: &[u8]| read_bytes(&[("a.obj", bytes)]).unwrap_err().to_string();
    let zeros = "this is not an OBJ text file: it has zero bytes; is it a binary model, or compressed?";
    assert_eq!(error(b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR v 1 2 3"), format!("a.obj: {zeros}"));
    // Behind the bytes that are looked at first.
    let mut late = b"v 1 2 3\n".repeat(10_000);
    late.extend(b"f 1 2 3\nv 1 2 3\0\n");
    assert_eq!(error(&late), format!("a.obj:10002: {zeros}"));
    let utf16 = "a.obj: this is not an OBJ text file but UTF-16 text; save it as UTF-8";
    assert_eq!(error(b"\xFF\xFEv\0 \x001\0"), utf16);
    assert_eq!(error(b"\xFE\xFF\0v\0 "), utf16);
    let nothing = "a.obj: there are no vertices and no faces; is this an OBJ file?";
    for text in ["", "Dear Sir,\nvn 0 0 1\n", "# v 1 2 3\n"] {
        assert_eq!(error(text.as_bytes()), nothing, "{text:?}");
    }
}

#[test]
fn colours_of_vertices() {
    let colors = |text: &str| scene(text).meshes[0].colors.clone();
    let half = 0.214_041_14;
    // Three numbers more are a colour, four a weight and a colour, one a weight alone.
    let text = "v 0 0 0\nv 1 0 0 1 0.5 0\nv 1 1 0 2 0 0 0.5\nv 0 1 0 0.5\nf 1 2 3";
    let white = [1.0; 4];
    assert_eq!(colors(text), [white, [1.0, half, 0.0, 1.0], [0.0, 0.0, half, 1.0], white]);
    assert!(colors("v 0 0 0 1\nv 1 0 0 0.5\nv 0 1 0 1 1\nf 1 2 3").is_empty());
    assert_eq!(
        warnings(&[("a.obj", "v 0 0 0 1 nan 1\nv 1 0 0 255 0 -1\nv 0 1 0 1 1 1 x\nf 1 2 3")]),
        [
            "a.obj:1: a vertex colour is not a finite number; the vertex is white",
            "a.obj:2: a vertex colour is not within 0 to 1; it is cut to that",
        ]
    );
}

#[test]
fn colours_of_vertices_show_on_white_where_there_is_no_material() {
    let obj = "mtllib m.mtl\nv 0 0 0 1 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nusemtl a\nf 1 2 3\nusemtl b\nf 1 2 3";
    let loaded = read(&[("a.obj", obj), ("m.mtl", "newmtl a\nKd 0 1 0")]).unwrap();
    let s = &loaded.scene;
    let names: Vec<&str> =
        s.meshes[0].triangles.iter().map(|t| s.materials[t.material as usize].name.as_str()).collect();
    assert_eq!(names, ["vertex colors", "a", "vertex colors"]);
    let MaterialKind::Mtl(mtl) = s.materials[1].kind else { panic!() };
    assert_eq!(mtl, Mtl { Kd: Vec3::ONE, ..Mtl::default() });
}

#[test]
fn smoothing_groups() {
    let roof = "v 0 0 0\nv 1 0 0\nv 1 1 1\nv 0 1 1\nv 1 2 0\nv 0 2 0\n";
    let s = scene(&format!("{roof}s 1\nf 1 2 3 4\nf 4 3 5 6\ns off\nf 1 4 6\n"));
    let mesh = &s.meshes[0];
    let normal = |t: usize, corner: usize| mesh.normals[mesh.triangles[t].normals[corner] as usize];
    let half = std::f32::consts::FRAC_1_SQRT_2;
    // At the eaves the first slope's own, at the ridge the mean of both.
    assert_eq!(normal(0, 0), vec3(0.0, -half, half));
    assert!((normal(1, 1) - vec3(0.0, 0.0, 1.0)).length() < 0.5 && normal(1, 1) != normal(1, 0));
    assert_eq!(normal(4, 1), vec3(-1.0, 0.0, 0.0));
    for text in ["", "s off\n", "s 0\n"] {
        assert!(scene(&format!("{roof}{text}f 1 2 3 4\n")).meshes[0].normals.is_empty(), "{text}");
    }
    assert_eq!(
        warnings(&[("a.obj", &format!("{roof}s soft\nf 1 2 3"))]),
        ["a.obj:7: \"s soft\" is passed over; write s and a group's number, or s off"]
    );
}

#[test]
fn concave_faces_are_cut_where_vertices_come_late() {
    let s = scene("f 1/1 2/2 3/3 4/4\nv 4 0 0\nv 0 1 0\nv -4 0 0\nv 0 4 0\nvt 0\nvt 1\nvt 2\nvt 3");
    let corners: Vec<[u32; 3]> = s.meshes[0].triangles.iter().map(|t| t.positions).collect();
    assert_eq!(corners, [[3, 0, 1], [1, 2, 3]]);
    assert!(s.meshes[0].triangles.iter().all(|t| t.uvs == t.positions));
}

/// A PNG of two texels.
fn png(texels: [[u8; 4]; 2]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
    encoder.set_color(png::ColorType::Rgba);
    encoder.write_header().unwrap().write_image_data(&texels.concat()).unwrap();
    bytes
}

#[test]
fn all_maps() {
    let obj = format!("mtllib m.mtl\n{FOUR}usemtl a\nf 1/1 2/2 3/3");
    let mtl = "newmtl a\nmap_Kd -s 2 3 -o 0.5 -clamp on g.png\nmap_Ks g.png\nmap_Ke g.png\nmap_d g.png\nmap_Pr g.png\n\
               map_Pm -imfchan b g.png\nnorm -bm 0.5 g.png\nnewmtl b\nmap_d leaf.png\nnewmtl c\nmap_d -imfchan g leaf.png\n\
               newmtl d\nmap_d no.png\nmap_Bump -bm 2 g.png\nrefl -type sphere g.png\nmap_Ns g.png\nmap_bump g.png";
    let grey = png([[0, 0, 0, 255], [9, 9, 9, 255]]);
    let leaf = png([[0, 0, 0, 255], [9, 9, 9, 0]]);
    let files = [
        ("a.obj", obj.as_bytes()),
        ("m.mtl", mtl.as_bytes()),
        ("g.png", grey.as_slice()),
        ("leaf.png", leaf.as_slice()),
    ];
    let loaded = read_bytes(&files).unwrap();
    let s = &loaded.scene;
    assert_eq!(s.images.len(), 2);
    let t = s.materials[0].textures;
    let texture = |number: u32| s.textures[number as usize];
    let data = |c: Option<TextureChannel>| {
        let c = c.unwrap();
        assert_eq!(texture(c.texture).content, TextureContent::Data);
        c.channel
    };
    let color = texture(t.color.unwrap());
    assert_eq!((color.content, color.wrap_u), (TextureContent::Color, TextureWrap::Clamp));
    assert_eq!(color.picture_from_mesh_uv, [[2.0, 0.0, 0.5], [0.0, 3.0, 0.0]]);
    assert_eq!([t.specular, t.emission].map(|n| texture(n.unwrap()).content), [TextureContent::Color; 2]);
    assert_eq!([t.opacity, t.roughness, t.metallic].map(data), [Channel::Red, Channel::Red, Channel::Blue]);
    assert_eq!((texture(t.normal.unwrap()).content, t.normal_scale), (TextureContent::Data, 0.5));
    assert_eq!(s.materials[0].emission(), Vec3::ONE);

    let opacity = [1, 2].map(|m| s.materials[m].textures.opacity.unwrap().channel);
    assert_eq!(opacity, [Channel::Alpha, Channel::Green]);
    let alpha: Vec<AlphaMode> = s.materials.iter().map(|m| m.alpha).collect();
    assert_eq!(alpha, [AlphaMode::Blend, AlphaMode::Blend, AlphaMode::Blend, AlphaMode::Opaque]);
    let list: Vec<String> = loaded.warnings.iter().map(|w| w.to_string()).collect();
    assert_eq!(
        list,
        [
            "m.mtl:15: map_Bump is not rendered",
            "m.mtl:16: refl is not rendered",
            "m.mtl:17: map_Ns is not rendered",
            "m.mtl:18: map_bump is not rendered",
            "m.mtl:14: texture \"no.png\" is missing; the surface goes without",
        ]
    );
}

#[test]
fn the_built_in_box_is_the_published_one() {
    let loaded = crate::files::load("builtin:cornell", &LoadOptions::default()).unwrap();
    assert!(loaded.warnings.is_empty() && loaded.files_read.is_empty());
    let s = &loaded.scene;
    assert_eq!((s.meshes[0].triangles.len(), s.meshes[0].positions.len()), (2188, 1116));
    let light = s.materials.iter().find(|m| m.name == "light").unwrap();
    assert!(matches!(light.kind, MaterialKind::Mtl(Mtl { illum: 2, .. })));
    assert_eq!(light.emission(), Vec3::splat(10.0));
}
