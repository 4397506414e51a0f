//! Textures of the file → textures of the model.

use super::Part;
use super::document::{Document, MagFilter, NormalTexture, TextureInfo, TextureTransform, Wrap};
use super::images::Images;
use crate::files::loader::Loader;
use crate::model::{Texture, TextureContent};
use eosphor_core::math::elementary64;
use eosphor_core::texture::{TextureFilter, TextureWrap};
use std::path::Path;

/// A texture as a material uses it.
#[derive(Clone, Debug)]
pub(super) struct Map {
    /// Into the file's textures.
    texture: usize,
    uv_set: u32,
    transform: Option<TextureTransform>,
    content: TextureContent,
}

impl Map {
    pub(super) fn new(info: &TextureInfo, content: TextureContent) -> Map {
        let transform = info.extensions.as_ref().and_then(|e| e.transform.clone());
        Map { texture: info.index.value(), uv_set: info.tex_coord, transform, content }
    }

    pub(super) fn of_normals(info: &NormalTexture) -> Map {
        let transform = info.extensions.as_ref().and_then(|e| e.transform.clone());
        Map { texture: info.index.value(), uv_set: info.tex_coord, transform, content: TextureContent::Data }
    }

    /// The image, where there is one.
    pub(super) fn image(&self, root: &Document) -> Option<usize> {
        let image = root.textures.get(self.texture)?.source?.value();
        (image < root.images.len()).then_some(image)
    }

    /// The number of the model's texture; what is missing or broken has warned and gives none.
    pub(super) fn resolve(
        &self,
        loader: &mut Loader,
        path: &Path,
        root: &Document,
        images: &Images,
    ) -> Option<u32> {
        if !loader.wants_textures() {
            return None;
        }
        let Some(texture) = root.textures.get(self.texture) else {
            let message = format!("texture {} does not exist; the surface is untextured", self.texture);
            loader.warnings.add(path, None, message);
            return None;
        };
        let name = Part::new("texture", self.texture, texture.name.as_deref());
        let Some(image) = self.image(root) else {
            let others = texture.extensions.iter().flat_map(|e| e.keys());
            let kinds: Vec<&str> = others.filter(|key| key.contains("texture")).map(String::as_str).collect();
            let message = if kinds.is_empty() {
                format!("{name} has no picture; the surface is untextured")
            } else {
                let kinds: String = super::clean(&kinds.join(" and ")).chars().take(100).collect();
                format!(
                    "{name} is there as {kinds} only, which is not read; the surface is untextured; export it as PNG \
                     or JPEG"
                )
            };
            loader.warnings.add(path, None, message);
            return None;
        };
        let image = images.number(image)?;
        let sampler = texture.sampler.and_then(|index| root.samplers.get(index.value()));
        let mut uv_set = self.transform.as_ref().and_then(|t| t.tex_coord).unwrap_or(self.uv_set);
        if uv_set > 1 {
            let message = format!("texture coordinates {uv_set} are not read, only 0 and 1; {name} takes 0");
            loader.warnings.add(path, None, message);
            uv_set = 0;
        }
        let mut picture_from_mesh_uv =
            self.transform.as_ref().map_or(Texture::IDENTITY_UV, flipped_transform);
        if picture_from_mesh_uv.iter().flatten().any(|x| !x.is_finite()) {
            let message = format!("the transform of {name} is out of range and left out");
            loader.warnings.add(path, None, message);
            picture_from_mesh_uv = Texture::IDENTITY_UV;
        }
        let wrap = |wrap: Option<Wrap>| match wrap {
            Some(Wrap::ClampToEdge) => TextureWrap::Clamp,
            Some(Wrap::MirroredRepeat) => TextureWrap::Mirror,
            Some(Wrap::Repeat) | None => TextureWrap::Repeat,
        };
        let is_nearest = sampler.and_then(|s| s.mag_filter) == Some(MagFilter::Nearest);
        Some(loader.texture(Texture {
            image,
            content: self.content,
            filter: if is_nearest { TextureFilter::Nearest } else { TextureFilter::Bilinear },
            wrap_u: wrap(sampler.and_then(|s| s.wrap_s)),
            wrap_v: wrap(sampler.and_then(|s| s.wrap_t)),
            uv_set,
            picture_from_mesh_uv,
        }))
    }
}

/// KHR_texture_transform between our coordinates, whose v runs up: w = 1 - v runs down in glTF.
///
/// The extension maps (u, w) to offset + rotation · (scale · (u, w)). It turns counter-clockwise as seen on the
/// picture, that is, from u towards -w: the rotation is (cos, sin; -sin, cos). (Early texts of the extension print the
/// other sign; its test model and the viewers agree on this one.)
fn flipped_transform(transform: &TextureTransform) -> [[f32; 3]; 2] {
    let [offset_u, offset_w] = transform.offset.map(f64::from);
    let [scale_u, scale_w] = transform.scale.map(f64::from);
    let (sin, cos) = elementary64::sin_cos(f64::from(transform.rotation));
    let u_from_uw = [cos * scale_u, sin * scale_w];
    let w_from_uw = [-sin * scale_u, cos * scale_w];
    // Put w = 1 - v on both sides.
    [
        [u_from_uw[0], -u_from_uw[1], u_from_uw[1] + offset_u],
        [-w_from_uw[0], w_from_uw[1], 1.0 - w_from_uw[1] - offset_w],
    ]
    .map(|row| row.map(|x| x as f32))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where the extension takes a point of glTF's coordinates, by way of ours.
    fn transformed(json: &str, [u, w]: [f32; 2]) -> [f32; 2] {
        let [of_u, of_v] = flipped_transform(&serde_json::from_str(json).unwrap());
        let v = 1.0 - w;
        let mapped = |row: [f32; 3]| row[0] * u + row[1] * v + row[2];
        [mapped(of_u), 1.0 - mapped(of_v)]
    }

    #[test]
    fn transforms_mean_what_the_extension_says() {
        let near = |got: [f32; 2], want: [f32; 2]| {
            assert!((got[0] - want[0]).abs() + (got[1] - want[1]).abs() < 1e-6, "{got:?}, not {want:?}");
        };
        let p = [0.25, 0.125];
        assert_eq!(flipped_transform(&TextureTransform::default()), Texture::IDENTITY_UV);
        near(transformed(r#"{"offset": [0.5, 0.25]}"#, p), [0.75, 0.375]);
        near(transformed(r#"{"scale": [2, 4]}"#, p), [0.5, 0.5]);
        // A quarter turn counter-clockwise, with w down: right goes to up.
        near(transformed(r#"{"rotation": 1.5707964}"#, [1.0, 0.0]), [0.0, -1.0]);
        near(transformed(r#"{"rotation": 1.5707964}"#, [0.0, 1.0]), [1.0, 0.0]);
        // Scale first, offset last.
        let all = r#"{"offset": [10, 20], "rotation": 1.5707964, "scale": [2, 3]}"#;
        near(transformed(all, [1.0, 1.0]), [13.0, 18.0]);
    }
}
