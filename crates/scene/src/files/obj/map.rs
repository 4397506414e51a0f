//! Texture maps of MTL files: `map_Kd -s 2 2 -clamp on wood.png`.

use super::lines::{is_blank, split_key, text, trim};
use super::number::{Number, number};
use crate::model::{Channel, MAX_COORDINATE, Texture};
use eosphor_core::texture::TextureWrap;

/// A map and its options.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Map {
    pub(super) kind: MapKind,
    pub(super) file: Vec<u8>,
    pub(super) line: u32,
    /// `-clamp`.
    pub(super) wrap: TextureWrap,
    /// `-imfchan`.
    pub(super) channel: Option<Channel>,
    /// `-bm`.
    pub(super) bump_multiplier: f32,
    /// `-s` and `-o`: coordinates are scaled, then moved.
    pub(super) picture_from_mesh_uv: [[f32; 3]; 2],
}

/// What a map varies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum MapKind {
    Color,
    Specular,
    Emission,
    Opacity,
    Roughness,
    Metallic,
    Normal,
}

/// What a key in small letters names.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum MapKey {
    Rendered(MapKind),
    /// A map, but not one that rendering knows.
    NotRendered,
    NoMap,
}

impl MapKey {
    pub(super) fn of(key: &[u8]) -> MapKey {
        MapKey::Rendered(match key {
            b"map_kd" => MapKind::Color,
            b"map_ks" => MapKind::Specular,
            b"map_ke" => MapKind::Emission,
            b"map_d" => MapKind::Opacity,
            b"map_pr" => MapKind::Roughness,
            b"map_pm" => MapKind::Metallic,
            b"norm" | b"map_norm" | b"map_kn" => MapKind::Normal,
            // A switch, not a map.
            b"map_aat" => return MapKey::NoMap,
            b"bump" | b"disp" | b"decal" | b"refl" => return MapKey::NotRendered,
            _ if key.starts_with(b"map_") => return MapKey::NotRendered,
            _ => return MapKey::NoMap,
        })
    }
}

impl Map {
    /// Reads options and the name of a file, which may hold blanks. Options may follow the name too.
    pub(super) fn parse(kind: MapKind, rest: &[u8], line: u32) -> Result<Map, String> {
        // Names with more dashes are not looked through.
        const MAX_TRIES: usize = 16;
        let mut map = Map {
            kind,
            file: Vec::new(),
            line,
            wrap: TextureWrap::Repeat,
            channel: None,
            bump_multiplier: 1.0,
            picture_from_mesh_uv: Texture::IDENTITY_UV,
        };
        let rest = map.options(rest)?;
        let dashes = (1..rest.len()).filter(|&i| rest[i] == b'-' && is_blank(rest[i - 1]));
        let with_options_behind = dashes.take(MAX_TRIES).find_map(|i| {
            let mut map = map.clone();
            let after = map.options(&rest[i..]).ok()?;
            after.is_empty().then_some((map, trim(&rest[..i])))
        });
        let (map, name) = with_options_behind.unwrap_or((map, rest));
        let name = name.strip_prefix(b"\"").and_then(|name| name.strip_suffix(b"\"")).unwrap_or(name);
        if name.is_empty() {
            return Err("the file name is missing; the map is left out".into());
        }
        Ok(Map { file: name.to_vec(), ..map })
    }

    /// Takes options; what follows them.
    fn options<'a>(&mut self, mut rest: &'a [u8]) -> Result<&'a [u8], String> {
        while rest.first() == Some(&b'-') {
            let (option, after) = split_key(rest);
            let (argument, after_argument) = split_key(after);
            rest = match option.to_ascii_lowercase().as_slice() {
                b"-clamp" => {
                    let clamps = argument.eq_ignore_ascii_case(b"on");
                    self.wrap = if clamps { TextureWrap::Clamp } else { TextureWrap::Repeat };
                    after_argument
                }
                b"-s" => {
                    let ([u, v, _], after) = up_to_three_numbers(after, 1.0)?;
                    (self.picture_from_mesh_uv[0][0], self.picture_from_mesh_uv[1][1]) = (u, v);
                    after
                }
                b"-o" => {
                    let ([u, v, _], after) = up_to_three_numbers(after, 0.0)?;
                    (self.picture_from_mesh_uv[0][2], self.picture_from_mesh_uv[1][2]) = (u, v);
                    after
                }
                b"-bm" => {
                    self.bump_multiplier = match number(argument) {
                        Number::Good(x) if x.abs() <= 1e6 => x,
                        _ => {
                            return Err(format!(
                                "-bm \"{}\" is not within 1e6; the map is left out",
                                text(argument)
                            ));
                        }
                    };
                    after_argument
                }
                b"-imfchan" => {
                    self.channel = match argument {
                        b"r" => Some(Channel::Red),
                        b"g" => Some(Channel::Green),
                        b"b" => Some(Channel::Blue),
                        b"m" => Some(Channel::Alpha),
                        // Luminance and depth: pictures of one number are grey.
                        _ => None,
                    };
                    after_argument
                }
                // Turbulence, and base and gain.
                b"-t" => up_to_three_numbers(after, 0.0)?.1,
                b"-mm" => split_key(after_argument).1,
                b"-blendu" | b"-blendv" | b"-boost" | b"-cc" | b"-texres" | b"-type" => after_argument,
                // Not an option: a name that starts with a dash.
                _ => break,
            };
        }
        Ok(rest)
    }
}

fn up_to_three_numbers(mut rest: &[u8], default: f32) -> Result<([f32; 3], &[u8]), String> {
    let mut values = [default; 3];
    for value in &mut values {
        let (word, after) = split_key(rest);
        let Number::Good(x) = number(word) else { break };
        if x.abs() > MAX_COORDINATE {
            return Err(format!("{x:e} is out of range; the map is left out"));
        }
        *value = x;
        rest = after;
    }
    Ok((values, rest))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(rest: &str) -> Map {
        Map::parse(MapKind::Color, rest.as_bytes(), 1).unwrap()
    }

    #[test]
    fn options_before_and_behind_the_name() {
        let all = map(
            "-blendu on -blendv off -boost 2 -cc on -mm 0.1 0.9 -texres 512 -type sphere -t 1 2 3 -imfchan m -clamp ON \
             -bm 0.5 -s 2 3 -o .25 a b.png",
        );
        assert_eq!(all.file, b"a b.png");
        assert_eq!(
            (all.wrap, all.channel, all.bump_multiplier),
            (TextureWrap::Clamp, Some(Channel::Alpha), 0.5)
        );
        assert_eq!(all.picture_from_mesh_uv, [[2.0, 0.0, 0.25], [0.0, 3.0, 0.0]]);
        assert_eq!(map("-imfchan r b.jpg -bm 1.5"), Map { bump_multiplier: 1.5, ..map("-imfchan r b.jpg") });
        assert_eq!(map("-s 0.5 1.png").picture_from_mesh_uv[0][0], 0.5);
    }

    #[test]
    fn names_with_dashes_and_quotes() {
        for (rest, file) in [
            ("-wood.png", "-wood.png"),
            ("wood -s.png", "wood -s.png"),
            ("a -s 2 b.png", "a -s 2 b.png"),
            ("\"my wood.png\"", "my wood.png"),
            ("C:\\a\\b.png", "C:\\a\\b.png"),
        ] {
            assert_eq!(map(rest).file, file.as_bytes(), "{rest}");
        }
    }

    #[test]
    fn what_is_out_of_range_is_said() {
        let problem = |rest: &str| Map::parse(MapKind::Normal, rest.as_bytes(), 1).unwrap_err();
        assert_eq!(problem("-s 1e20 a.png"), "1e20 is out of range; the map is left out");
        assert_eq!(problem("-bm x a.png"), "-bm \"x\" is not within 1e6; the map is left out");
        assert_eq!(problem("-clamp on"), "the file name is missing; the map is left out");
    }

    #[test]
    fn keys() {
        assert_eq!(MapKey::of(b"map_d"), MapKey::Rendered(MapKind::Opacity));
        assert_eq!(MapKey::of(b"map_bump"), MapKey::NotRendered);
        assert_eq!(MapKey::of(b"refl"), MapKey::NotRendered);
        assert_eq!(MapKey::of(b"map_aat"), MapKey::NoMap);
        assert_eq!(MapKey::of(b"sharpness"), MapKey::NoMap);
    }
}
