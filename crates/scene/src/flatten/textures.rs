//! Textures: one array of words for all texels, and the table that decodes sRGB.

use crate::error::{Problem, SceneError};
use crate::model::{EnvironmentSource, Image, Scene, Sky, TexelLayout, Texels, TextureContent};
use crate::sky::{SkyPicture, WIDTH};
use eosphor_core::math::elementary64;
use eosphor_core::texture::{TexelFormat, Texture, TextureWrap};
use std::sync::Arc;

/// All textures of a scene.
pub(super) struct Textures {
    pub(super) headers: Vec<Texture>,
    pub(super) words: Arc<Vec<u32>>,
}

pub(super) fn build(scene: &Scene) -> Result<Textures, SceneError> {
    let sky = scene.environment.and_then(|map| match map.source {
        EnvironmentSource::Sky(sky) => Some(sky_image(&sky)),
        EnvironmentSource::Image(_) => None,
    });
    let images: Vec<&Image> = scene.images.iter().chain(&sky).collect();
    let (first_words, words) = words(&images);
    if words.len() as u64 > u64::from(u32::MAX) {
        let message = format!(
            "{} bytes of texels are too many; the limit is 16 GiB. Use smaller pictures",
            words.len() as u64 * 4
        );
        return Err(Problem::new("textures", message).into());
    }
    let header = |t: &crate::model::Texture| {
        let image = images[t.image as usize];
        Texture {
            first_word: first_words[t.image as usize] as u32,
            width: image.width,
            height: image.height,
            format: match (image.texels.layout(), t.content) {
                (TexelLayout::Halves(_), _) => TexelFormat::Half,
                (TexelLayout::Floats(_), _) => TexelFormat::Float,
                (TexelLayout::Rgbe, _) => TexelFormat::Rgbe,
                (_, TextureContent::Color) if scene.settings.srgb_textures => TexelFormat::Srgb8,
                _ => TexelFormat::Linear8,
            },
            channels: image.texels.layout().channels(),
            filter: t.filter,
            wrap_u: t.wrap_u,
            wrap_v: t.wrap_v,
            uv_set: t.uv_set,
            picture_from_mesh_uv: t.picture_from_mesh_uv,
        }
    };
    // The environment's comes last.
    let environment = scene.environment.map(|map| {
        let (image, picture_from_mesh_uv) = match map.source {
            EnvironmentSource::Image(image) => (image, crate::model::Texture::IDENTITY_UV),
            EnvironmentSource::Sky(_) => (scene.images.len() as u32, SkyPicture::texels_from_picture()),
        };
        crate::model::Texture {
            wrap_v: TextureWrap::Clamp,
            picture_from_mesh_uv,
            ..crate::model::Texture::of_image(image)
        }
    });
    Ok(Textures { headers: scene.textures.iter().chain(&environment).map(header).collect(), words })
}

/// The words of all images, and where each begins. Those of a loaded scene are one array, which is shared; only images
/// from elsewhere are copied.
fn words(images: &[&Image]) -> (Vec<usize>, Arc<Vec<u32>>) {
    let Some(shared) = images.first().map(|image| image.texels.shared()) else { return Default::default() };
    if images.iter().all(|image| Arc::ptr_eq(image.texels.shared(), shared)) {
        return (images.iter().map(|image| image.texels.first_word()).collect(), Arc::clone(shared));
    }
    let total = images.iter().map(|image| image.texels.words().len()).sum();
    let mut words = Vec::with_capacity(total);
    let mut first_words = Vec::with_capacity(images.len());
    for image in images {
        first_words.push(words.len());
        words.extend_from_slice(image.texels.words());
    }
    (first_words, Arc::new(words))
}

/// The picture that an environment shows.
fn sky_image(sky: &Sky) -> Image {
    let (width, height) = (WIDTH, SkyPicture::HEIGHT);
    let texels = Texels::new(TexelLayout::Floats(3), (width * height) as usize, SkyPicture::new(sky).words);
    Image { name: "sky".into(), width, height, texels }
}

/// The linear value of each sRGB byte.
pub(super) fn srgb_decode() -> [f32; 256] {
    let mut table = [0.0; 256];
    for (byte, linear) in table.iter_mut().enumerate() {
        *linear = elementary64::srgb_to_linear(byte as f64 / 255.0) as f32;
    }
    table
}

/// Shared words, written and read as if they were not.
pub(super) mod words_of_its_own {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};
    use std::sync::Arc;

    pub(crate) fn serialize<S: Serializer>(words: &Arc<Vec<u32>>, to: S) -> Result<S::Ok, S::Error> {
        words.as_slice().serialize(to)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Arc<Vec<u32>>, D::Error> {
        Vec::deserialize(from).map(Arc::new)
    }
}
