//! A clear sky with its sun.

/// A clear sky with its sun and the ground below it, by the model of Hosek and Wilkie (2012, 2013). Flattening makes a picture of
/// it. A radiance of 1 stands for [`Sky::UNIT`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sky {
    /// How high the sun's middle stands over the horizon, 0 to 90.
    pub sun_elevation_degrees: f32,
    /// Where it stands: clockwise from north, seen from above. With +y up, north is -z and east +x; with +z up, north is +y.
    pub sun_azimuth_degrees: f32,
    /// How hazy the air is, 1 to 10: 2 is very clear, 3 clear, 6 hazy.
    pub turbidity: f32,
    /// The share of light that the ground reflects, 0 to 1: it brightens the sky, and what is below the horizon is ground.
    pub albedo: f32,
    /// The radiance of the sun's disk over what the model says, 0 to 1e6; 0: no disk.
    pub sun_strength: f32,
}

impl Sky {
    /// The luminance that a radiance of 1 stands for, in cd/m².
    pub const UNIT: f64 = 30_000.0;
}

impl Default for Sky {
    fn default() -> Sky {
        Sky {
            sun_elevation_degrees: 45.0,
            sun_azimuth_degrees: 135.0,
            turbidity: 3.0,
            albedo: 0.3,
            sun_strength: 1.0,
        }
    }
}
