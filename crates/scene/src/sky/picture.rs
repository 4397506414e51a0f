//! The picture of a sky: rows of the sky, and one of the ground, which stands for all below it.
//!
//! It is made in double precision, row by row, so that it has the same bytes on all machines and with any number of threads.

use super::angles::atan2;
use super::hosek_wilkie::{Rgb, SUN_RADIUS, SkyDome, SunDisk};
use crate::model::Sky;
use eosphor_core::math::elementary64::{sin, sin_cos};
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Texels a row.
pub(crate) const WIDTH: u32 = 4096;

/// Rows of a picture of all directions.
pub(crate) const PICTURE_ROWS: u32 = WIDTH / 2;

/// Samples of a texel by the sun's disk along one axis.
const SUN_SAMPLES: u32 = 8;

/// Rings and spokes of the sum over the disk.
const DISK: [u32; 2] = [64, 128];

/// How a sky is divided into texels.
#[derive(Clone, Copy)]
pub(super) struct Grid {
    /// Texels a row; a multiple of 4, and more than 1344, so that a row is lower than the sun's radius.
    pub(super) width: u32,
}

impl Grid {
    fn sky_rows(self) -> u32 {
        self.width / 4
    }

    /// The angle between two rows, and between two columns at the horizon.
    fn step(self) -> f64 {
        TAU / f64::from(self.width)
    }

    /// The angle about the vertical of a place among the columns, in the picture's frame: from +x towards +z.
    fn around(self, place: f64) -> f64 {
        place * self.step() - PI
    }

    /// The integral of a texel's tent over the sphere above the horizon, times a function of the angle from up that has the sine of
    /// that angle as a factor.
    fn row_weight(self, row: u32, function: impl Fn(f64) -> f64) -> f64 {
        const STEPS: u32 = 64;
        let middle = f64::from(row) + 0.5;
        let mut sum = 0.0;
        for k in 0..2 * STEPS {
            let place = middle - 1.0 + (f64::from(k) + 0.5) / f64::from(STEPS);
            // Nothing is above the middle of the first row: it goes on.
            let tent = if row == 0 && place < middle { 1.0 } else { 1.0 - (place - middle).abs() };
            if place > 0.0 && place < f64::from(self.sky_rows()) {
                sum += tent * function(place * self.step());
            }
        }
        sum / f64::from(STEPS) * self.step() * self.step()
    }
}

/// Where light samples look for the sun.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DiskOfSun {
    /// A unit vector to its middle, in the picture's frame.
    pub(crate) middle: [f64; 3],
    /// The sine of the angle from there to its edge.
    pub(crate) radius: f64,
}

/// A sky in texels.
pub(crate) struct SkyPicture {
    /// Red, green and blue of each, as words of single precision.
    pub(crate) words: Vec<u32>,
}

impl SkyPicture {
    /// The height of the texels: the sky and a row of ground.
    pub(crate) const HEIGHT: u32 = PICTURE_ROWS / 2 + 1;

    /// Takes places of a picture of all directions to places among the texels, where v runs up.
    pub(crate) fn texels_from_picture() -> [[f32; 3]; 2] {
        let (all, own) = (f64::from(PICTURE_ROWS), f64::from(SkyPicture::HEIGHT));
        [[1.0, 0.0, 0.0], [0.0, (all / own) as f32, (1.0 - all / own) as f32]]
    }

    /// The sun's disk, if it shines, as large as interpolation spreads it.
    pub(crate) fn sun_disk(sky: &Sky) -> Option<DiskOfSun> {
        let radius = sin(1.65 * SUN_RADIUS);
        (sky.sun_strength > 0.0).then(|| DiskOfSun { middle: Sun::new(sky).middle, radius })
    }

    /// The sky, whose numbers are within their ranges.
    pub(crate) fn new(sky: &Sky) -> SkyPicture {
        SkyPicture::of_grid(sky, Grid { width: WIDTH })
    }

    pub(super) fn of_grid(sky: &Sky, grid: Grid) -> SkyPicture {
        let sun = Sun::new(sky);
        let elevation = f64::from(sky.sun_elevation_degrees) * (PI / 180.0);
        let dome = SkyDome::new(f64::from(sky.turbidity), f64::from(sky.albedo), elevation);
        let disk = sun.texels(grid, &SunDisk::new(f64::from(sky.turbidity)), f64::from(sky.sun_strength));
        let columns: Vec<(f64, f64)> =
            (0..grid.width).map(|column| sin_cos(grid.around(f64::from(column) + 0.5))).collect();
        let rows: Vec<(Vec<u32>, Rgb)> = (0..grid.sky_rows())
            .into_par_iter()
            .map(|row| {
                let mut colors = sky_row(&dome, &sun, (f64::from(row) + 0.5) * grid.step(), &columns);
                for (_, column, radiance) in disk.iter().filter(|(of, ..)| *of == row) {
                    colors[*column as usize].add(*radiance);
                }
                let mut sum = Rgb::default();
                let mut words = Vec::with_capacity(3 * colors.len());
                for color in colors {
                    // Colours that the picture cannot show lose what is below 0.
                    let texel = color.0.map(|x| (x / Sky::UNIT).max(0.0) as f32);
                    words.extend(texel.map(f32::to_bits));
                    sum.add(Rgb(texel.map(f64::from)));
                }
                (words, sum * grid.row_weight(row, |angle| 0.5 * sin(2.0 * angle)))
            })
            .collect();
        // Lambert's law, of what arrives at the ground.
        let mut irradiance = Rgb::default();
        let mut words = Vec::with_capacity(3 * grid.width as usize * (grid.sky_rows() as usize + 1));
        for (row, arriving) in rows {
            words.extend(row);
            irradiance.add(arriving);
        }
        let ground = (irradiance * (f64::from(sky.albedo) / PI)).0.map(|x| (x as f32).to_bits());
        words.extend((0..grid.width).flat_map(|_| ground));
        SkyPicture { words }
    }
}

/// The colours of a row of the sky without its sun.
fn sky_row(dome: &SkyDome, sun: &Sun, from_up: f64, columns: &[(f64, f64)]) -> Vec<Rgb> {
    let (level, up) = sin_cos(from_up);
    let ring = dome.ring(up);
    let color = |&(sine, cosine): &(f64, f64)| {
        let direction = [level * cosine, up, level * sine];
        let ([x, y, z], [a, b, c]) = (direction, sun.middle);
        let cross = [y * c - z * b, z * a - x * c, x * b - y * a];
        let cosine = dot(direction, sun.middle);
        ring.radiance(atan2(dot(cross, cross).sqrt(), cosine), cosine)
    };
    columns.iter().map(color).collect()
}

fn dot([x, y, z]: [f64; 3], [a, b, c]: [f64; 3]) -> f64 {
    x * a + y * b + z * c
}

/// The place of the sun.
struct Sun {
    /// A unit vector to its middle, in the picture's frame.
    middle: [f64; 3],
    /// Unit vectors at a right angle to that: away from the horizon, and level.
    upward: [f64; 3],
    sideward: [f64; 3],
    /// The angle about the vertical, as [`Grid::around`], and from up.
    angles: [f64; 2],
}

impl Sun {
    fn new(sky: &Sky) -> Sun {
        let radians = |degrees: f32| f64::from(degrees) * (PI / 180.0);
        let (sine, cosine) = sin_cos(radians(sky.sun_elevation_degrees));
        // North is -z, a fourth of the picture left of +x.
        let azimuth = radians(sky.sun_azimuth_degrees % 360.0) - FRAC_PI_2;
        let (z, x) = sin_cos(azimuth);
        Sun {
            middle: [x * cosine, sine, z * cosine],
            upward: [-x * sine, cosine, -z * sine],
            sideward: [-z, 0.0, x],
            angles: [azimuth, FRAC_PI_2 - radians(sky.sun_elevation_degrees)],
        }
    }

    /// The texels of the disk: row, column and radiance in cd/m².
    ///
    /// A texel is the mean of the disk over it, and the picture is interpolated between texels. Both together widen the disk: they
    /// add a fourth of the squared step to the variance along each axis, which is a fourth of the squared radius for an even disk.
    /// So the disk is drawn smaller by just that much, and penumbras have the width that they should have. All texels are then
    /// scaled for the light of the whole disk.
    fn texels(&self, grid: Grid, disk: &SunDisk, strength: f64) -> Vec<(u32, u32, Rgb)> {
        if strength == 0.0 {
            return Vec::new();
        }
        let step = grid.step();
        let middle = [(self.angles[0] + PI) / step, self.angles[1] / step];
        let shrink = |step: f64| (1.0 - (step / SUN_RADIUS) * (step / SUN_RADIUS)).sqrt();
        let level = (self.middle[0] * self.middle[0] + self.middle[2] * self.middle[2]).sqrt();
        let [side_scale, up_scale] = [step * level, step].map(|step| 1.0 / (shrink(step) * sin(SUN_RADIUS)));
        // Of a direction in places of the picture.
        let radiance = |x: f64, y: f64| {
            let (sine, cosine) = sin_cos(grid.around(x));
            let (down, up) = sin_cos(y * step);
            let direction = [down * cosine, up, down * sine];
            if dot(direction, self.middle) < 0.9 {
                return Rgb::default();
            }
            self.disk_radiance(
                disk,
                dot(direction, self.sideward) * side_scale,
                dot(direction, self.upward) * up_scale,
            )
        };
        let mut texels = Vec::new();
        let mut drawn = Rgb::default();
        let reach = SUN_RADIUS / step + 1.0;
        let rows = (middle[1] - reach).floor().max(0.0) as u32..=(middle[1] + reach) as u32;
        for row in rows.filter(|&row| row < grid.sky_rows()) {
            // Columns lie closer the higher the row; about the zenith all of them may meet the disk.
            let narrowest = sin((f64::from(row) - 1.0).max(0.0) * step);
            let columns = (reach / narrowest.max(1e-9)).min(f64::from(grid.width / 2)) as i64 + 1;
            let first = middle[0] as i64 - columns;
            let weight = grid.row_weight(row, sin);
            let all = (first..=first + 2 * columns).take(grid.width as usize);
            for column in all {
                let mut sum = Rgb::default();
                for k in 0..SUN_SAMPLES * SUN_SAMPLES {
                    let place = |k: u32| (f64::from(k) + 0.5) / f64::from(SUN_SAMPLES);
                    let (x, y) = (place(k % SUN_SAMPLES), place(k / SUN_SAMPLES));
                    sum.add(radiance(column as f64 + x, f64::from(row) + y));
                }
                let mean = sum * (1.0 / f64::from(SUN_SAMPLES * SUN_SAMPLES));
                if mean != Rgb::default() {
                    drawn.add(mean * weight);
                    texels.push((row, column.rem_euclid(i64::from(grid.width)) as u32, mean));
                }
            }
        }
        let whole = self.irradiance(disk) * strength;
        let scale = |channel: usize| match drawn.0[channel] > 0.0 {
            true => whole.0[channel] / drawn.0[channel],
            false => 0.0,
        };
        let scale = [0, 1, 2].map(scale);
        for (.., radiance) in &mut texels {
            radiance.0.iter_mut().zip(scale).for_each(|(x, scale)| *x *= scale);
        }
        texels
    }

    /// The radiance at a place of the disk, level and upward from its middle over its radius; nothing beyond it and below the
    /// horizon.
    fn disk_radiance(&self, disk: &SunDisk, side: f64, up: f64) -> Rgb {
        let squared = side * side + up * up;
        let radius = sin(SUN_RADIUS);
        let elevation_sine =
            self.middle[1] * (1.0 - squared * radius * radius).max(0.0).sqrt() + self.upward[1] * up * radius;
        if squared > 1.0 || elevation_sine < 0.0 {
            return Rgb::default();
        }
        Rgb(disk.radiance(elevation_sine, squared.sqrt()).0.map(|x| x.max(0.0)))
    }

    /// What the disk sends to a surface that faces it, of what is over the horizon, in lux.
    fn irradiance(&self, disk: &SunDisk) -> Rgb {
        let [rings, spokes] = DISK;
        let mut sum = Rgb::default();
        for ring in 0..rings {
            let from_middle = ((f64::from(ring) + 0.5) / f64::from(rings)).sqrt();
            for spoke in 0..spokes {
                let (s, c) = sin_cos(TAU * (f64::from(spoke) + 0.5) / f64::from(spokes));
                sum.add(self.disk_radiance(disk, from_middle * c, from_middle * s));
            }
        }
        // The solid angle of a cap, by the square of the sine of half its angle.
        let half = sin(0.5 * SUN_RADIUS);
        sum * (4.0 * PI * half * half / f64::from(rings * spokes))
    }
}
