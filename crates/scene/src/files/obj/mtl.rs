//! Wavefront MTL: materials of OBJ files.

use super::lines::{Lines, split_key, text, words};
use super::map::{Map, MapKey, MapKind};
use super::number::{Number, number};
use crate::files::warnings::Warnings;
use crate::model::Mtl;
use eosphor_core::math::{Vec3, vec3};
use std::path::Path;

/// One material of an MTL file.
pub(super) struct MtlEntry {
    pub(super) name: Vec<u8>,
    pub(super) line: u32,
    pub(super) mtl: Mtl,
    /// At most one of a kind.
    pub(super) maps: Vec<Map>,
    given: Given,
}

/// Which keys a material has given, where one decides about another.
#[derive(Default)]
struct Given {
    kd: bool,
    ks: bool,
    ke: bool,
    d: bool,
}

/// Reads an MTL file. It never fails: unknown keys are passed over, malformed values warn and keep the default.
pub(super) fn parse(bytes: &[u8], path: &Path, warnings: &mut Warnings) -> Vec<MtlEntry> {
    let mut entries: Vec<MtlEntry> = Vec::new();
    for (line, contents) in Lines::new(bytes) {
        let (key, rest) = split_key(&contents);
        let small = key.to_ascii_lowercase();
        if small == b"newmtl" {
            entries.push(MtlEntry::new(rest, line));
            continue;
        }
        let Some(entry) = entries.last_mut() else { continue };
        let done = match MapKey::of(&small) {
            MapKey::NoMap => entry.set(&small, rest),
            MapKey::Rendered(kind) => entry.set_map(kind, rest, line),
            MapKey::NotRendered => {
                warnings.add(path, Some(line), format!("{} is not rendered", text(key)));
                continue;
            }
        };
        if let Err(problem) = done {
            warnings.add(path, Some(line), format!("{}: {problem}", text(key)));
        }
    }
    entries.iter_mut().for_each(MtlEntry::close);
    entries
}

impl MtlEntry {
    fn new(name: &[u8], line: u32) -> MtlEntry {
        let (mtl, maps, given) = (Mtl::default(), Vec::new(), Given::default());
        MtlEntry { name: name.to_vec(), line, mtl, maps, given }
    }

    /// Takes a key in small letters.
    fn set(&mut self, key: &[u8], rest: &[u8]) -> Result<(), String> {
        let (mtl, given) = (&mut self.mtl, &mut self.given);
        match key {
            b"kd" => {
                mtl.Kd = color(rest)?;
                given.kd = true;
            }
            b"ks" => {
                mtl.Ks = color(rest)?;
                given.ks = true;
            }
            b"ke" => {
                mtl.Ke = color(rest)?;
                given.ke = true;
            }
            b"tf" => mtl.Tf = Some(color(rest)?),
            b"ns" => mtl.Ns = in_range(rest, 0.0, 1e6)?,
            b"ni" => mtl.Ni = Some(in_range(rest, 0.01, 100.0)?),
            b"d" => {
                let rest = rest.strip_prefix(b"-halo").unwrap_or(rest);
                mtl.d = in_range(rest, 0.0, 1.0)?;
                given.d = true;
            }
            // Tr is 1 - d; where a file gives both, d counts.
            b"tr" => {
                let transparency = in_range(rest, 0.0, 1.0)?;
                if !given.d {
                    mtl.d = 1.0 - transparency;
                }
            }
            b"illum" => mtl.illum = in_range(rest, 0.0, 10.0)? as u32,
            b"pr" => mtl.Pr = Some(in_range(rest, 0.0, 1.0)?),
            b"pm" => mtl.Pm = Some(in_range(rest, 0.0, 1.0)?),
            b"ps" => mtl.Ps = Some(in_range(rest, 0.0, 1.0)?),
            b"pc" => mtl.Pc = Some(in_range(rest, 0.0, 1.0)?),
            b"pcr" => mtl.Pcr = Some(in_range(rest, 0.0, 1.0)?),
            b"aniso" => mtl.aniso = Some(in_range(rest, -1.0, 1.0)?),
            b"anisor" => mtl.anisor = Some(in_range(rest, -360.0, 360.0)?),
            _ => {}
        }
        Ok(())
    }

    fn set_map(&mut self, kind: MapKind, rest: &[u8], line: u32) -> Result<(), String> {
        let map = Map::parse(kind, rest, line)?;
        self.maps.retain(|m| m.kind != kind);
        self.maps.push(map);
        Ok(())
    }

    /// Maps multiply: a picture without the number that it varies is shown as it is.
    fn close(&mut self) {
        let (mtl, given) = (&mut self.mtl, &self.given);
        for map in &self.maps {
            match map.kind {
                MapKind::Color if !given.kd => mtl.Kd = Vec3::ONE,
                MapKind::Specular if !given.ks => mtl.Ks = Vec3::ONE,
                MapKind::Emission if !given.ke => mtl.Ke = Vec3::ONE,
                MapKind::Roughness => mtl.Pr = mtl.Pr.or(Some(1.0)),
                MapKind::Metallic => mtl.Pm = mtl.Pm.or(Some(1.0)),
                _ => {}
            }
        }
    }
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
        let map = &entries[0].maps[0];
        assert_eq!((map.kind, map.file.as_slice(), map.line), (MapKind::Color, &b"my wood.png"[..], 13));
    }

    #[test]
    fn the_pbr_extension() {
        let (entries, warnings) = read(
            "newmtl a\nPr 0.2\nPm 0.3\nPs 0.4\nPc 0.5\nPcr 0.6\naniso 0.7\nANISOR 0.8\nmap_Pr r.png\nmap_Pm -imfchan b m.png\n\
             map_Ps s.png\nnorm -bm 2 n.png\nmap_Bump b.png\nnewmtl b\nmap_Pr r.png\nmap_Pr q.png\nmap_Bump b.png\nmap_Ke e.png",
        );
        assert_eq!(
            warnings,
            ["m.mtl:11: map_Ps is not rendered", "m.mtl:13: map_Bump is not rendered (2 times in this file)"]
        );
        let expected = Mtl {
            Pr: Some(0.2),
            Pm: Some(0.3),
            Ps: Some(0.4),
            Pc: Some(0.5),
            Pcr: Some(0.6),
            aniso: Some(0.7),
            anisor: Some(0.8),
            ..Mtl::default()
        };
        assert_eq!(entries[0].mtl, expected);
        let kinds: Vec<MapKind> = entries[0].maps.iter().map(|m| m.kind).collect();
        assert_eq!(kinds, [MapKind::Roughness, MapKind::Metallic, MapKind::Normal]);
        // What a map varies is 1 where the file does not say; a second map of a kind replaces the first.
        assert_eq!(entries[1].mtl, Mtl { Pr: Some(1.0), Ke: Vec3::ONE, ..Mtl::default() });
        assert_eq!((entries[1].maps.len(), entries[1].maps[0].file.as_slice()), (2, &b"q.png"[..]));
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
                "m.mtl:8: map_Kd: the file name is missing; the map is left out",
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
