//! Directions by how bright they are.
//!
//! The picture is interpolated between the middles of its texels. So are cells: their corners are middles of texels, or of groups
//! of them in large pictures. The first and the last row of cells, of half a texel's height, are between such middles and the pole,
//! where the picture is as bright as at the middles.
//!
//! Rows of cells form [`BANDS`] of about the same weight. A band is chosen first, then a column, then a cell of the column in that
//! band. The table begins with running sums of the weights of columns, from 0 to [`TABLE_UNIT`], and an index into them
//! (`index.rs`), for each band; then, column by column, there are those of its cells, of which each band has an equal part, and the
//! brightness of their corners (`cell.rs`). Sums are whole numbers, as random numbers have digits: so the probability of a cell is
//! exactly what is said of it. In a cell, density is that of places in the picture, interpolated between its corners.
//!
//! Both were measured (docs/decisions.md). Were density even in a cell, radiance over density would leap from cell to cell beside
//! what is bright. Were rows chosen first, one by one, points that are well spread would be less so in the picture: what lies at
//! one height differs more from the next height than one side does from the next one. Were columns chosen first, floors under a sky
//! would have more noise: the height of a direction is all that counts for them.

use super::cell::{CellPlace, Corners};
use super::index::{Pick, Sums, target};
use super::{Environment, PicturePlace, TABLE_UNIT, index_length};
use crate::math::{Vec3, Vec3Lanes, elementary, floor, fma, max, sqrt, vec3};
use crate::memory::prefetch;
use crate::sampling::place_within;

/// Groups of rows that are chosen first.
pub const BANDS: usize = 4;

/// A band of rows that was chosen.
#[derive(Clone, Copy)]
struct Band {
    number: u32,
    weight: u32,
    /// The number that chooses among the cells of a column.
    down: f64,
}

/// A direction from which light may come.
#[derive(Clone, Copy, Debug)]
pub struct DirectionSample {
    /// A unit vector of the world.
    pub to_light: Vec3,
    /// Density per steradian.
    pub density: f32,
}

/// Directions in several lanes.
#[derive(Clone, Copy, Debug)]
pub struct DirectionLanes<const W: usize> {
    /// Unit vectors of the world.
    pub to_light: Vec3Lanes<W>,
    /// Densities per steradian.
    pub density: [f32; W],
}

impl Environment {
    /// A direction by its brightness, from two numbers in [0, 1), of which the first one chooses the sun or the table, too. There
    /// must be light: [`Environment::chance`] is above 0.
    #[inline(always)]
    pub fn sample(&self, table: &[u32], u: [f64; 2]) -> DirectionSample {
        match self.share_of_table(u[0]) {
            None => self.sample_of_sun(table, u),
            Some(across) => {
                let band = self.band(u[1]);
                let column = self.columns_of(table, band.number).pick(across);
                let row = self.cells_of(table, column.number).pick(band.down);
                let corners = self.corners(table, row.number, column.number);
                self.sample_at(band.weight, &column, &row, corners)
            }
        }
    }

    /// As [`Environment::sample`] in several lanes.
    #[inline(always)]
    pub fn sample_lanes<const W: usize>(&self, table: &[u32], u: &[[f64; W]; 2]) -> DirectionLanes<W> {
        let mut lanes = DirectionLanes { to_light: Vec3Lanes::ZERO, density: [0.0; W] };
        let mut across = [0.0; W];
        let mut is_sun = [false; W];
        for lane in 0..W {
            let share = self.share_of_table(u[0][lane]);
            (across[lane], is_sun[lane]) = (share.unwrap_or(0.0), share.is_none());
        }
        // Bands and columns are in the caches; what follows is not, and each loop waits for all lanes together.
        let (mut numbers, mut weights, mut down) = ([0; W], [0; W], [0.0; W]);
        for lane in 0..W {
            let band = self.band(u[1][lane]);
            (numbers[lane], weights[lane], down[lane]) = (band.number, band.weight, band.down);
        }
        let mut columns = [Pick::NONE; W];
        for lane in 0..W {
            columns[lane] = self.columns_of(table, numbers[lane]).pick(across[lane]);
            self.cells_of(table, columns[lane].number).prefetch_index(down[lane]);
        }
        for lane in 0..W {
            self.cells_of(table, columns[lane].number).prefetch_sums(down[lane]);
        }
        let mut rows = [Pick::NONE; W];
        for lane in 0..W {
            rows[lane] = self.cells_of(table, columns[lane].number).pick(down[lane]);
            prefetch(table, self.place_of_corners(rows[lane].number, columns[lane].number));
        }
        let mut corners = [0; W];
        for lane in 0..W {
            corners[lane] = self.corners(table, rows[lane].number, columns[lane].number);
        }
        for lane in 0..W {
            let sample = self.sample_at(weights[lane], &columns[lane], &rows[lane], corners[lane]);
            lanes.to_light.set(lane, sample.to_light);
            lanes.density[lane] = sample.density;
        }
        // Few pictures have a sun, and without this all lanes would sample one, to throw it away.
        if self.sun_chance > 0.0 {
            for lane in 0..W {
                if is_sun[lane] {
                    let sample = self.sample_of_sun(table, [u[0][lane], u[1][lane]]);
                    lanes.to_light.set(lane, sample.to_light);
                    lanes.density[lane] = sample.density;
                }
            }
        }
        lanes
    }

    /// Where a number lies that does not go to the sun, among all of these.
    #[inline(always)]
    fn share_of_table(&self, u: f64) -> Option<f64> {
        let to_sun = self.sun_chance as f64;
        if u < to_sun { None } else { Some((u - to_sun) / (1.0 - to_sun)) }
    }

    /// The band that holds a number.
    #[inline(always)]
    fn band(&self, u: f64) -> Band {
        let (exact, target) = target(u);
        let (mut number, mut from, mut to) = (0, 0, TABLE_UNIT);
        for sum in self.band_sums {
            let is_after = sum <= target;
            number += u32::from(is_after);
            from = if is_after { sum } else { from };
            to = if is_after | (sum > to) { to } else { sum };
        }
        let weight = to.wrapping_sub(from);
        // Not the next band's by rounding.
        const LAST: f64 = 1.0 - 1.0 / TABLE_UNIT as f64;
        let rest = (exact - from as f64) / weight as f64;
        let rest = if rest < LAST { rest } else { LAST };
        Band { number, weight, down: (number as f64 + rest) * (1.0 / BANDS as f64) }
    }

    /// The band of a row of cells, and its weight.
    #[inline(always)]
    fn band_of_row(&self, row: u32) -> (u32, u32) {
        let (mut number, mut from, mut to) = (0, 0, self.band_sums[0]);
        for band in 1..BANDS {
            if self.band_rows[band - 1] <= row {
                (number, from, to) = (band as u32, self.band_sums[band - 1], self.band_sums[band]);
            }
        }
        (number, to.wrapping_sub(from))
    }

    /// By the sun, which `u` goes to.
    #[inline(always)]
    fn sample_of_sun(&self, table: &[u32], u: [f64; 2]) -> DirectionSample {
        let within = [u[0] / self.sun_chance as f64, u[1]].map(place_within);
        let to_light = self.in_world(self.sample_sun(within));
        DirectionSample { to_light, density: self.density(table, to_light) }
    }

    /// In a cell with these corners, of a band of this weight.
    #[inline(always)]
    fn sample_at(&self, band_weight: u32, column: &Pick, row: &Pick, corners: u32) -> DirectionSample {
        let corners = Corners::of_word(corners);
        let place = corners.place(row, column);
        // From the nearer pole, where angles are small: they have all their digits there.
        let is_lower = 2 * row.number > self.rows;
        let (from_pole, down) = if is_lower {
            (self.rows.wrapping_sub(row.number), 1.0 - place.down)
        } else {
            (row.number, place.down)
        };
        let border = if from_pole == 0 { 0.0 } else { from_pole as f32 - 0.5 };
        let from_up =
            fma(self.row_height(row.number), down, border) * (core::f32::consts::PI / self.rows as f32);
        let (sine, cosine) = elementary::sin_cos(from_up);
        // The left border of the first column is in the middle of the first texel.
        let x = (column.number as f32 + 0.5 + place.across) / self.columns as f32;
        let (around_sine, around_cosine) = elementary::sin_cos((x - 0.5) * core::f32::consts::TAU);
        let y = if is_lower { -cosine } else { cosine };
        let direction = vec3(sine * around_cosine, y, sine * around_sine);
        let weights = [band_weight, column.weight, row.weight];
        let density = self.density_of(weights, row.number, sine) * corners.density(place);
        DirectionSample { to_light: self.in_world(direction), density: self.with_sun(density, direction) }
    }

    /// How densely [`Environment::sample`] gives a direction, a unit vector of the world, per steradian.
    #[inline(always)]
    pub fn density(&self, table: &[u32], direction: Vec3) -> f32 {
        self.density_at(table, &self.place(direction))
    }

    /// The same at a place of the picture.
    #[inline(always)]
    pub fn density_at(&self, table: &[u32], place: &PicturePlace) -> f32 {
        let (row, column, within) = self.cell(place);
        let weight = |sums: Sums, number: u32| {
            let sum = |at: usize| table.get(at).copied().unwrap_or(0);
            let at = sums.first + number as usize;
            sum(at + 1).wrapping_sub(sum(at))
        };
        let (band, band_weight) = self.band_of_row(row);
        let column_weight = weight(self.columns_of(table, band), column);
        let weights = [band_weight, column_weight, weight(self.cells_of(table, column), row)];
        let direction = place.direction;
        let sine = sqrt(fma(direction.x, direction.x, direction.z * direction.z));
        let density = self.density_of(weights, row, sine)
            * Corners::of_word(self.corners(table, row, column)).density(within);
        self.with_sun(density, direction)
    }

    /// Tells memory that [`Environment::density_at`] will read a place.
    #[inline(always)]
    pub fn prefetch_density(&self, table: &[u32], place: &PicturePlace) {
        let (row, column, _) = self.cell(place);
        prefetch(table, self.cells_of(table, column).first + row as usize);
        prefetch(table, self.place_of_corners(row, column));
    }

    /// The row and the column of a place, and where it lies in their cell.
    #[inline(always)]
    fn cell(&self, place: &PicturePlace) -> (u32, u32, CellPlace) {
        let cell = |place: f32, last: u32| {
            let whole = max(floor(place), 0.0);
            let number = whole as u32;
            (if number < last { number } else { last }, place - whole)
        };
        let [x, y] = place.place;
        let columns = self.columns as f32;
        let from_left = fma(x, columns, -0.5);
        let from_left = if from_left < 0.0 { from_left + columns } else { from_left };
        let (column, across) = cell(from_left, self.columns.wrapping_sub(1));
        let (row, down) = cell(fma(y, self.rows as f32, 0.5), self.rows);
        (row, column, CellPlace { across, down })
    }

    /// The density of all samples in a direction of the picture's frame, where that of those by the table is this.
    #[inline(always)]
    fn with_sun(&self, density: f32, direction: Vec3) -> f32 {
        if !(self.sun_chance > 0.0) {
            return density;
        }
        fma(self.sun_chance, self.sun_density(direction), (1.0 - self.sun_chance) * density)
    }

    /// The sums of the columns in a band.
    #[inline(always)]
    fn columns_of<'a>(&self, table: &'a [u32], band: u32) -> Sums<'a> {
        let first = band as usize * index_length(self.columns as usize);
        Sums { table, first, count: self.columns }
    }

    /// Those of a column's cells.
    #[inline(always)]
    fn cells_of<'a>(&self, table: &'a [u32], column: u32) -> Sums<'a> {
        Sums { table, first: self.first_of_column(column), count: self.cell_rows() }
    }

    #[inline(always)]
    fn first_of_column(&self, column: u32) -> usize {
        BANDS * index_length(self.columns as usize) + column as usize * self.column_length()
    }

    #[inline(always)]
    fn corners(&self, table: &[u32], row: u32, column: u32) -> u32 {
        table.get(self.place_of_corners(row, column)).copied().unwrap_or(0)
    }

    /// Which word of the table says how bright the corners of a cell are.
    #[inline(always)]
    fn place_of_corners(&self, row: u32, column: u32) -> usize {
        self.first_of_column(column) + index_length(self.cell_rows() as usize) + row as usize
    }

    /// In heights of other rows than the first and the last one.
    #[inline(always)]
    fn row_height(&self, row: u32) -> f32 {
        if (row == 0) | (row == self.rows) { 0.5 } else { 1.0 }
    }

    /// The mean density in a cell with these weights: of its band, of its column there, and of itself in that; where the angle from
    /// up has this sine.
    #[inline(always)]
    fn density_of(&self, [band, column, cell]: [u32; 3], row: u32, sine: f32) -> f32 {
        const PART: f32 = 1.0 / TABLE_UNIT as f32;
        // Of a picture as wide as the circle and as high as half of it.
        const PICTURE: f32 = 2.0 * core::f32::consts::PI * core::f32::consts::PI;
        // Of a column's sums, each band has an equal part.
        let of_band = (column as f32 * PART) * (cell as f32 * (PART * BANDS as f32));
        let probability = (band as f32 * PART) * of_band;
        let cells = self.columns as f32 * self.rows as f32;
        probability * cells / (self.row_height(row) * PICTURE * max(sine, f32::MIN_POSITIVE))
    }
}
