//! Wavefront MTL: materials of OBJ files.

use super::lines::{Lines, Number, number, split_key, text, words};
use crate::files::warnings::Warnings;
use crate::model::Mtl;
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::texture::TextureWrap;
use std::path::Path;

/// One material of an MTL file.
pub(super) struct MtlEntry {
    pub(super) name: Vec<u8>,
    pub(super) line: u32,
    pub(super) mtl: Mtl,
    pub(super) texture: Option<MapKd>,
}

/// The picture that multiplies the diffuse colour.
#[derive(Clone)]
pub(super) struct MapKd {
    pub(super) file: Vec<u8>,
    pub(super) line: u32,
    pub(super) wrap: TextureWrap,
}

/// Reads an MTL file. It never fails: unknown keys are passed over, malformed values warn and keep the default.
pub(super) fn parse(bytes: &[u8], path: &Path, warnings: &mut Warnings) -> Vec<MtlEntry> {
    let mut entries: Vec<MtlEntry> = Vec::new();
    let mut has = Given::default();
    for (line, contents) in Lines::new(bytes) {
        let (key, rest) = split_key(&contents);
        if key.eq_ignore_ascii_case(b"newmtl") {
            close(entries.last_mut(), &has);
            has = Given::default();
            entries.push(MtlEntry { name: rest.to_vec(), line, mtl: Mtl::default(), texture: None });
            continue;
        }
        let Some(entry) = entries.last_mut() else { continue };
        if let Err(problem) = set(entry, &mut has, key, rest, line) {
            warnings.add(path, Some(line), format!("{}: {problem}", text(key)));
        }
    }
    close(entries.last_mut(), &has);
    entries
}

/// Which keys a material has given, where one decides about another.
#[derive(Default)]
struct Given {
    kd: bool,
    d: bool,
}

/// A picture without a colour is shown as it is.
fn close(entry: Option<&mut MtlEntry>, has: &Given) {
    if let Some(entry) = entry.filter(|e| e.texture.is_some() && !has.kd) {
        entry.mtl.Kd = Vec3::ONE;
    }
}

fn set(entry: &mut MtlEntry, has: &mut Given, key: &[u8], rest: &[u8], line: u32) -> Result<(), String> {
    let mtl = &mut entry.mtl;
    match key.to_ascii_lowercase().as_slice() {
        b"kd" => {
            mtl.Kd = color(rest)?;
            has.kd = true;
        }
        b"ks" => mtl.Ks = color(rest)?,
        b"ke" => mtl.Ke = color(rest)?,
        b"tf" => mtl.Tf = Some(color(rest)?),
        b"ns" => mtl.Ns = in_range(rest, 0.0, 1e6)?,
        b"ni" => mtl.Ni = Some(in_range(rest, 0.01, 100.0)?),
        b"d" => {
            let rest = rest.strip_prefix(b"-halo").unwrap_or(rest);
            mtl.d = in_range(rest, 0.0, 1.0)?;
            has.d = true;
        }
        // Tr is 1 - d; where a file gives both, d counts.
        b"tr" => {
            let transparency = in_range(rest, 0.0, 1.0)?;
            if !has.d {
                mtl.d = 1.0 - transparency;
            }
        }
        b"illum" => {
            let value = in_range(rest, 0.0, 10.0)?;
            mtl.illum = value as u32;
        }
        b"map_kd" => entry.texture = Some(map_kd(rest, line)?),
        _ => {}
    }
    Ok(())
}

fn first_number(word: Option<&[u8]>) -> Result<f32, String> {
    let word = word.ok_or("a number is missing; the default is taken")?;
    match number(word) {
        Number::Good(x) | Number::Stray(x) => Ok(x),
        _ => Err(format!("\"{}\" is not a finite number; the default is taken", text(word))),
    }
}

fn in_range(rest: &[u8], low: f32, high: f32) -> Result<f32, String> {
    let x = first_number(words(rest).next())?;
    if (low..=high).contains(&x) {
        return Ok(x);
    }
    Err(format!("{x} is not {low} to {high}; the default is taken"))
}

/// One number is grey, three are a colour. Spectral curves and CIE XYZ are not read.
fn color(rest: &[u8]) -> Result<Vec3, String> {
    let mut list = words(rest);
    let first = list.next();
    if let Some(form @ (b"spectral" | b"xyz")) = first {
        return Err(format!("\"{}\" colours are not read; the default is taken", text(form)));
    }
    let r = first_number(first)?;
    let c = match list.next() {
        None => Vec3::splat(r),
        second => vec3(r, first_number(second)?, first_number(list.next())?),
    };
    if c.min_component() < 0.0 || c.max_component() > 1e12 {
        return Err("a colour is negative or huge; the default is taken".into());
    }
    Ok(c)
}

/// The options of a texture map, of which only `-clamp` matters here, and the file name, which may hold blanks.
fn map_kd(rest: &[u8], line: u32) -> Result<MapKd, String> {
    let mut wrap = TextureWrap::Repeat;
    let mut rest = rest;
    while rest.first() == Some(&b'-') {
        let (option, after) = split_key(rest);
        let (first, after_first) = split_key(after);
        rest = match option {
            b"-clamp" => {
                if first == b"on" {
                    wrap = TextureWrap::Clamp;
                }
                after_first
            }
            b"-o" | b"-s" | b"-t" => up_to_three_numbers(after),
            b"-mm" => split_key(after_first).1,
            b"-blendu" | b"-blendv" | b"-bm" | b"-boost" | b"-cc" | b"-imfchan" | b"-texres" | b"-type" => {
                after_first
            }
            // Not an option: a name that starts with a dash.
            _ => break,
        };
    }
    if rest.is_empty() {
        return Err("the file name is missing; the surface is untextured".into());
    }
    Ok(MapKd { file: rest.to_vec(), line, wrap })
}

fn up_to_three_numbers(mut rest: &[u8]) -> &[u8] {
    for _ in 0..3 {
        let (word, after) = split_key(rest);
        if !matches!(number(word), Number::Good(_)) {
            break;
        }
        rest = after;
    }
    rest
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> (Vec<MtlEntry>, Vec<String>) {
        let mut warnings = Warnings::default();
        let path = Path::new("m.mtl");
        let entries = parse(text.as_bytes(), path, &mut warnings);
        (entries, warnings.finish(path).iter().map(|w| w.to_string()).collect())
    }

    #[test]
    fn all_keys() {
        let (entries, warnings) = read(
            "newmtl red  brick\r\n\tKd 0.1 0.2 0.3 # comment\n Ks .5\nKe 17 12 4\nTf 1 1 1\nNs 1000\nNi 1.6\nd 0.25\n\
             Tr 0.5\nillum 7\nKa 1 1 1\nsharpness 60\nmap_Kd -s 1 1 1 -clamp on -o 0.1 my wood.png\n",
        );
        assert!(warnings.is_empty(), "{warnings:?}");
        assert_eq!(entries[0].name, b"red  brick");
        let expected = Mtl {
            Kd: vec3(0.1, 0.2, 0.3),
            Ks: Vec3::splat(0.5),
            Ke: vec3(17.0, 12.0, 4.0),
            Tf: Some(Vec3::ONE),
            Ns: 1000.0,
            Ni: Some(1.6),
            d: 0.25,
            illum: 7,
            ..Mtl::default()
        };
        assert_eq!(entries[0].mtl, expected);
        let map = entries[0].texture.clone().unwrap();
        assert_eq!((map.file.as_slice(), map.wrap, map.line), (&b"my wood.png"[..], TextureWrap::Clamp, 13));
    }

    #[test]
    fn malformed_values_warn_and_keep_the_default() {
        let (entries, warnings) =
            read("Kd 1 1 1\nnewmtl a\nKd 1 x 1\nNs nan\nd 2\nKs xyz 1 1 1\nNi\nmap_Kd -clamp on");
        assert_eq!(entries.len(), 1);
        assert_eq!(entries[0].mtl, Mtl::default());
        assert_eq!(
            warnings,
            [
                "m.mtl:3: Kd: \"x\" is not a finite number; the default is taken",
                "m.mtl:4: Ns: \"nan\" is not a finite number; the default is taken",
                "m.mtl:5: d: 2 is not 0 to 1; the default is taken",
                "m.mtl:6: Ks: \"xyz\" colours are not read; the default is taken",
                "m.mtl:7: Ni: a number is missing; the default is taken",
                "m.mtl:8: map_Kd: the file name is missing; the surface is untextured",
            ]
        );
    }

    #[test]
    fn a_texture_without_colour_is_shown_as_it_is() {
        let (entries, _) = read("newmtl a\nmap_Kd x.png\nnewmtl b\nTr 0.25\nmap_Kd y.png\nKd 0 0 0");
        assert_eq!(entries[0].mtl.Kd, Vec3::ONE);
        assert_eq!((entries[1].mtl.Kd, entries[1].mtl.d), (Vec3::ZERO, 0.75));
    }
}
