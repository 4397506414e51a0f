//! Pictures and how surfaces read them.

use eosphor_core::texture::{TextureFilter, TextureWrap};
use std::fmt;
use std::sync::Arc;

/// A decoded picture; several textures may read one.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Name for messages.
    pub name: String,
    /// Texels a row, 1 to 65,535.
    pub width: u32,
    /// Rows, 1 to 65,535.
    pub height: u32,
    /// `width * height` of them, top row first.
    pub texels: Texels,
}

/// What a texel of a picture is. Textures hold pictures as files have them: 1 channel is grey, 2 are grey and alpha, 3 are
/// red, green and blue, 4 are these and alpha.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TexelLayout {
    /// 1 to 4 channels of 8 bits.
    Bytes(u32),
    /// 1 to 4 channels of half-precision floats, as OpenEXR files have them: linear, not negative, colours multiplied by
    /// alpha; infinity stands for 1e12.
    Halves(u32),
    /// 1 to 4 channels of single-precision floats: linear and finite.
    Floats(u32),
    /// Red, green and blue with a shared exponent, a byte each, as Radiance files have them: linear.
    Rgbe,
}

impl TexelLayout {
    /// The number of channels of a texel.
    pub fn channels(self) -> u32 {
        match self {
            TexelLayout::Bytes(channels) | TexelLayout::Halves(channels) | TexelLayout::Floats(channels) => {
                channels
            }
            TexelLayout::Rgbe => 3,
        }
    }

    /// Bytes that so many texels take: whole words.
    pub fn bytes(self, texels: u64) -> u64 {
        let texel = match self {
            TexelLayout::Bytes(channels) => u64::from(channels),
            TexelLayout::Halves(channels) => 2 * u64::from(channels),
            TexelLayout::Floats(channels) => 4 * u64::from(channels),
            TexelLayout::Rgbe => 4,
        };
        (texels * texel).next_multiple_of(4)
    }
}

/// The texels of a picture, in words that clones share, and that the pictures of a loaded scene share.
#[derive(Clone)]
pub struct Texels {
    layout: TexelLayout,
    len: usize,
    first_word: usize,
    /// Words of this picture, and maybe of others.
    words: Arc<Vec<u32>>,
}

impl Texels {
    /// So many texels, without gaps between them, from the low end of each word up.
    ///
    /// # Panics
    /// Where there are not 1 to 4 channels, or the texels do not fill just so many words.
    pub fn new(layout: TexelLayout, len: usize, words: Vec<u32>) -> Texels {
        assert!((1..=4).contains(&layout.channels()), "{layout:?}: texels have 1 to 4 channels");
        let needed = layout.bytes(len as u64) / 4;
        assert_eq!(words.len() as u64, needed, "words of {len} texels, {layout:?}");
        Texels { layout, len, first_word: 0, words: Arc::new(words) }
    }

    /// 8 bits a channel: R, G, B, A from the low byte up.
    pub fn rgba8(texels: Vec<u32>) -> Texels {
        Texels::new(TexelLayout::Bytes(4), texels.len(), texels)
    }

    /// Linear R, G, B, A, finite.
    pub fn rgba_floats(texels: &[[f32; 4]]) -> Texels {
        let words = texels.as_flattened().iter().map(|x| x.to_bits()).collect();
        Texels::new(TexelLayout::Floats(4), texels.len(), words)
    }

    /// The layout of each texel.
    pub fn layout(&self) -> TexelLayout {
        self.layout
    }

    /// The number of texels.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there are no texels.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The number of bytes that the texels take.
    pub fn bytes(&self) -> u64 {
        self.layout.bytes(self.len as u64)
    }

    /// The words that hold the texels, without gaps between them, from the low end of each word up.
    pub fn words(&self) -> &[u32] {
        &self.words[self.first_word..][..(self.bytes() / 4) as usize]
    }

    /// Number of the first word within [`Texels::shared`].
    pub(crate) fn first_word(&self) -> usize {
        self.first_word
    }

    /// Their words, and those of the pictures beside them.
    pub(crate) fn shared(&self) -> &Arc<Vec<u32>> {
        &self.words
    }

    /// Bytes, channel after channel, texel after texel; whatever else the words hold, for the last to be whole.
    pub(crate) fn channel_bytes(&self) -> impl Iterator<Item = u8> {
        self.words().iter().flat_map(|word| word.to_le_bytes())
    }
}

impl PartialEq for Texels {
    fn eq(&self, other: &Texels) -> bool {
        let is_same = Arc::ptr_eq(&self.words, &other.words) && self.first_word == other.first_word;
        (self.layout, self.len) == (other.layout, other.len) && (is_same || self.words() == other.words())
    }
}

impl fmt::Debug for Texels {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} texels, {:?}", self.len, self.layout)
    }
}

/// Puts the texels of all pictures into words that they share, so that flattening copies none. The largest picture stays
/// where it is, if nothing else holds it; the others are copied and freed one by one.
pub(crate) fn share_words(images: &mut [Image]) {
    let words = |image: &Image| image.texels.words().len();
    let total: usize = images.iter().map(words).sum();
    let Some(largest) = (0..images.len()).max_by_key(|&i| words(&images[i])) else { return };
    let take = |texels: &mut Texels| match Arc::try_unwrap(std::mem::take(&mut texels.words)) {
        Ok(words) if texels.first_word == 0 && words.len() as u64 == texels.bytes() / 4 => words,
        Ok(words) => words[texels.first_word..][..(texels.bytes() / 4) as usize].to_vec(),
        Err(words) => words[texels.first_word..][..(texels.bytes() / 4) as usize].to_vec(),
    };
    let mut all = take(&mut images[largest].texels);
    images[largest].texels.first_word = 0;
    all.reserve_exact(total - all.len());
    for (number, image) in images.iter_mut().enumerate() {
        if number != largest {
            let own = take(&mut image.texels);
            image.texels.first_word = all.len();
            all.extend_from_slice(&own);
        }
    }
    let all = Arc::new(all);
    images.iter_mut().for_each(|image| image.texels.words = Arc::clone(&all));
}

/// A picture as a surface reads it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Texture {
    /// Index into [`super::Scene::images`].
    pub image: u32,
    /// What the numbers of the image stand for.
    pub content: TextureContent,
    /// How colours between texels are found.
    pub filter: TextureFilter,
    /// Outside the unit square, along u.
    pub wrap_u: TextureWrap,
    /// Outside the unit square, along v.
    pub wrap_v: TextureWrap,
    /// Which texture coordinates of the mesh it takes: 0 for [`super::Mesh::uvs`], 1 for [`super::Mesh::uvs1`].
    pub uv_set: u32,
    /// Takes the mesh's (u, v, 1) to the picture's (u, v), row by row. v runs up.
    pub picture_from_mesh_uv: [[f32; 3]; 2],
}

impl Texture {
    /// The map that changes nothing.
    pub const IDENTITY_UV: [[f32; 3]; 2] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

    /// An image of colours read by the mesh's own coordinates, bilinear and repeated.
    pub fn of_image(image: u32) -> Texture {
        Texture {
            image,
            content: TextureContent::Color,
            filter: TextureFilter::Bilinear,
            wrap_u: TextureWrap::Repeat,
            wrap_v: TextureWrap::Repeat,
            uv_set: 0,
            picture_from_mesh_uv: Texture::IDENTITY_UV,
        }
    }
}

/// What the 8-bit numbers of a picture are; floats are always linear.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TextureContent {
    /// Colours: sRGB-coded, unless [`super::RenderSettings::srgb_textures`] is off.
    Color,
    /// Roughness, normals, opacity: linear always.
    Data,
}
