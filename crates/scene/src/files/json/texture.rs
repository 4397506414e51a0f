//! Textures in JSON: a file name, alone or with how the picture is read.

use crate::model::{Channel, Texture, TextureContent};
use eosphor_core::math::elementary64;
use eosphor_core::texture::{TextureFilter, TextureWrap};
use schemars::JsonSchema;
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// A file name, or a file and how it is read.
#[derive(Deserialize, JsonSchema)]
#[serde(untagged)]
#[schemars(rename = "Texture", extend("examples" = [
    "wood.png",
    { "file": "wood.png", "filter": "nearest", "scale": [4, 4], "rotate-degrees": 45 }
]))]
pub(super) enum TextureEntry {
    File(PathBuf),
    Fields(TextureFields),
}

/// A texture of which one channel is taken: a file name, or a file and how it is read.
#[derive(Deserialize, JsonSchema)]
#[serde(untagged)]
#[schemars(rename = "ChannelTexture", extend("examples" = ["wood.png", { "file": "wood.png", "channel": "red" }]))]
pub(super) enum ChannelTextureEntry {
    File(PathBuf),
    Fields(ChannelTextureFields),
}

/// A texture by file. Its coordinates are those of the mesh: scaled, then rotated, then moved.
#[derive(Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[schemars(inline, extend("allOf" = [
    { "not": { "required": ["wrap", "wrap-u"] } },
    { "not": { "required": ["wrap", "wrap-v"] } },
]))]
pub(super) struct TextureFields {
    /// PNG, JPEG, PPM, HDR, EXR, BMP, TGA or `.data`, beside the scene file; or `builtin:parquet`.
    #[schemars(extend("examples" = ["wood.png"]))]
    file: PathBuf,
    /// What lies between texels.
    #[serde(default = "bilinear")]
    filter: TextureFilter,
    /// What lies outside the unit square.
    #[serde(default)]
    #[schemars(with = "TextureWrap", extend("default" = "repeat"))]
    wrap: Option<TextureWrap>,
    /// The same along u alone.
    #[serde(default)]
    #[schemars(with = "TextureWrap", extend("default" = "repeat"))]
    wrap_u: Option<TextureWrap>,
    /// The same along v alone.
    #[serde(default)]
    #[schemars(with = "TextureWrap", extend("default" = "repeat"))]
    wrap_v: Option<TextureWrap>,
    /// Which texture coordinates of the mesh it takes: the first (0) or the second (1).
    #[serde(default)]
    #[schemars(range(min = 0, max = 1))]
    uv_set: u32,
    /// Multiplies u and v: at 2 the picture is half as large and stands there twice.
    #[serde(default = "ones")]
    scale: [f32; 2],
    /// Turns the coordinates counter-clockwise about (0, 0), and so the picture clockwise.
    #[serde(default)]
    rotate_degrees: f32,
    /// Is added to u and v.
    #[serde(default)]
    offset: [f32; 2],
}

/// A texture by file of which one channel is taken.
#[derive(Deserialize, JsonSchema)]
#[schemars(inline)]
pub(super) struct ChannelTextureFields {
    #[serde(flatten)]
    texture: TextureFields,
    /// The channel that is taken; where not given it depends on what the texture is for.
    #[serde(default)]
    channel: Option<Channel>,
}

fn bilinear() -> TextureFilter {
    TextureFilter::Bilinear
}

fn ones() -> [f32; 2] {
    [1.0; 2]
}

impl TextureEntry {
    pub(super) fn file(&self) -> &Path {
        match self {
            TextureEntry::File(file) => file,
            TextureEntry::Fields(fields) => &fields.file,
        }
    }

    /// The texture that reads this image.
    pub(super) fn of_image(&self, image: u32, content: TextureContent) -> Texture {
        let texture = Texture { content, ..Texture::of_image(image) };
        match self {
            TextureEntry::File(_) => texture,
            TextureEntry::Fields(fields) => fields.apply(texture),
        }
    }
}

impl ChannelTextureEntry {
    /// The texture without the channel, and that.
    pub(super) fn split(self) -> (TextureEntry, Option<Channel>) {
        match self {
            ChannelTextureEntry::File(file) => (TextureEntry::File(file), None),
            ChannelTextureEntry::Fields(fields) => (TextureEntry::Fields(fields.texture), fields.channel),
        }
    }
}

impl TextureFields {
    fn apply(&self, texture: Texture) -> Texture {
        Texture {
            filter: self.filter,
            wrap_u: self.wrap_u.or(self.wrap).unwrap_or(texture.wrap_u),
            wrap_v: self.wrap_v.or(self.wrap).unwrap_or(texture.wrap_v),
            uv_set: self.uv_set,
            picture_from_mesh_uv: self.picture_from_mesh_uv(),
            ..texture
        }
    }

    /// Scale, then rotation, then offset, in double precision.
    fn picture_from_mesh_uv(&self) -> [[f32; 3]; 2] {
        let [scale_u, scale_v] = self.scale.map(f64::from);
        let (sin, cos) = match self.rotate_degrees {
            0.0 => (0.0, 1.0),
            degrees => elementary64::sin_cos(f64::from(degrees) * (std::f64::consts::PI / 180.0)),
        };
        let [offset_u, offset_v] = self.offset;
        [
            [(cos * scale_u) as f32, (-sin * scale_v) as f32, offset_u],
            [(sin * scale_u) as f32, (cos * scale_v) as f32, offset_v],
        ]
    }
}
