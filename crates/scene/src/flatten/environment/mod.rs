//! The environment: its header, and the table by which bright directions are chosen.

mod corners;
mod table;

use super::textures::Textures;
use crate::model::{EnvironmentSource, Scene};
use crate::sky::{DiskOfSun, PICTURE_ROWS, SkyPicture};
use eosphor_core::environment::Environment;
use eosphor_core::math::vec3;
use eosphor_core::texture::{Texture, TextureFilter, Textures as TextureView};
use table::{Cells, Table};

/// The most corners of cells of a table, across and down. In larger pictures each stands for several texels.
const MOST_CELLS: [u32; 2] = [2048, 1024];

/// The same of skies, which are smooth but for their sun: few enough for the caches.
const CELLS_OF_SKY: [u32; 2] = [256, 128];

/// The environment of a scene and its table. Its texture comes after all others.
pub(super) fn build(scene: &Scene, textures: &Textures, srgb_decode: &[f32; 256]) -> (Environment, Vec<u32>) {
    let Some(map) = &scene.environment else { return (Environment::NOWHERE, Vec::new()) };
    let number = scene.textures.len() as u32;
    let header = Texture { filter: TextureFilter::Nearest, ..textures.headers[number as usize] };
    let view = TextureView { textures: &[header], words: &textures.words, srgb_decode };
    let environment = Environment {
        texture: number,
        strength: map.strength,
        picture_from_world: map.picture_from_world(),
        is_seen: map.is_seen,
        ..Environment::NOWHERE
    };
    let rows = match map.source {
        EnvironmentSource::Image(_) => header.height,
        // Its texels are those of the upper half.
        EnvironmentSource::Sky(_) => PICTURE_ROWS,
    };
    let sun = match &map.source {
        EnvironmentSource::Image(_) => None,
        EnvironmentSource::Sky(sky) => SkyPicture::sun_disk(sky),
    };
    let most_cells = match map.source {
        EnvironmentSource::Image(_) => MOST_CELLS,
        EnvironmentSource::Sky(_) => CELLS_OF_SKY,
    };
    let (corners, of_sun) = corners::corners(&view, rows, most_cells, sun);
    match table::table(&corners).filter(|_| map.strength > 0.0) {
        Some(Table { weight, words, cells }) => {
            let environment = match sun {
                Some(DiskOfSun { middle, radius }) => Environment {
                    sun_chance: (of_sun / (of_sun + weight)).min(MOST_OF_SUN) as f32,
                    to_sun: vec3(middle[0] as f32, middle[1] as f32, middle[2] as f32),
                    sun_radius: radius as f32,
                    ..environment
                },
                None => environment,
            };
            let Cells { columns, rows, band_rows, band_sums } = cells;
            // Alone; lights take their share ([`chance`]).
            (Environment { chance: 1.0, columns, rows, band_rows, band_sums, ..environment }, words)
        }
        None => (environment, Vec::new()),
    }
}

/// The share of light samples that go to an environment with light, beside other lights.
pub(super) fn chance(has_lights: bool) -> f32 {
    if has_lights { 0.5 } else { 1.0 }
}

/// The most samples that go to the sun: the shade has the sky alone.
const MOST_OF_SUN: f64 = 0.5;
