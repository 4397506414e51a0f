//! What a picture depends on besides the scene: the settings that reach a pixel.

use crate::math::Vec3;

/// How a surface point is lit (reference systems: EOS, PG1, PLATO). `I` is what arrives of a light, over pi where light is
/// physical.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[repr(u32)]
pub enum LightingModel {
    /// Grey by distance from the camera: `1 - min(t, 1.5 D) / (1.5 D)` with `D` = [`Settings::max_distance`].
    Distance,
    /// The diffuse colour alone, unlit.
    Diffuse,
    /// `I Kd max(0, N.L)`.
    Lambert,
    /// Lambert plus `I Ks max(0, V.R)^Ns`.
    Phong,
    /// Lambert plus `I Ks max(0, N.H)^Ns`.
    BlinnPhong,
}

impl LightingModel {
    /// Whether surfaces are lit at all: then rays go on to lights and further surfaces.
    #[inline(always)]
    pub fn is_lit(self) -> bool {
        match self {
            LightingModel::Distance | LightingModel::Diffuse => false,
            LightingModel::Lambert | LightingModel::Phong | LightingModel::BlinnPhong => true,
        }
    }
}

/// What a surface between a point and a light does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[repr(u32)]
pub enum ShadowMode {
    /// Nothing: no shadow rays are traced.
    None,
    /// It takes all light.
    Opaque,
    /// It multiplies the light by its shadow filter, once for every surface crossed.
    Coloured,
}

/// How the Fresnel factor of mirrors and glass is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[repr(u32)]
pub enum FresnelMode {
    /// The equations for unpolarised light at a dielectric.
    Exact,
    /// Schlick's approximation (1994).
    Schlick,
    /// The value at normal incidence, whatever the angle; total internal reflection stays total.
    Constant,
}

/// How the rays of a sample find what a pixel shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[repr(u32)]
pub enum Integrator {
    /// Whitted's ray tracing: mirrors and glass, and light that comes from lights straight or through them.
    Whitted,
    /// Path tracing: light that bounces from everything, by chance, more exact with more samples.
    Path,
}

/// Where the samples of a pixel lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
#[repr(u32)]
pub enum PixelSampling {
    /// All in the middle.
    Center,
    /// Owen-scrambled Sobol points over the pixel.
    Random,
    /// A regular `k x k` grid (SSAA); the number of samples is `k * k`.
    Grid,
}

/// Settings that a pixel depends on. Everything about devices, threads and hierarchies is elsewhere, because
/// no pixel may depend on it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Settings {
    /// Picture width in pixels, 1 to 65,535.
    pub width: u32,
    /// Picture height in pixels, 1 to 65,535.
    pub height: u32,
    /// Samples a pixel, 1 to 65,536; a square number with [`PixelSampling::Grid`].
    pub samples: u32,
    /// Side of the sample grid: the root of `samples` with [`PixelSampling::Grid`], else 1.
    pub grid_side: u32,
    /// Where the samples of a pixel lie.
    pub pixel_sampling: PixelSampling,
    /// How rays go on; path tracing reads neither energy threshold, lighting model and Fresnel mode nor what is said of Whitted's
    /// lights.
    pub integrator: Integrator,
    /// In path tracing: after so many bounces paths that carry little end by chance.
    pub roulette_depth: u32,
    /// In path tracing: light that has bounced before it met the first surface is cut to this, its hue kept;
    /// [`crate::sums::MAX_RADIANCE`] and more: not at all.
    pub clamp_indirect: f32,
    /// Bounces after the camera ray, 0 to [`crate::integrator::MAX_DEPTH`].
    pub max_depth: u32,
    /// A ray dies when the largest component of its weight is below this.
    pub energy_threshold: f32,
    /// How a surface point is lit.
    pub lighting_model: LightingModel,
    /// What stands between a point and a light does this.
    pub shadow_mode: ShadowMode,
    /// How the Fresnel factor is computed.
    pub fresnel: FresnelMode,
    /// Camera and mirror rays pass through triangles seen from behind; rays inside a body do not.
    pub cull_back_faces: bool,
    /// Transparent surfaces also receive light from their far side, times their transmission.
    pub light_from_behind: bool,
    /// Point and spot lights fall off with the square of the distance.
    pub light_falloff: bool,
    /// Points that are sampled on each triangle that is a light.
    pub lamp_samples: u32,
    /// A lamp's radiance over the colour of its light ([`crate::light::Light`]): pi where light is physical, else 1.
    pub lamp_radiance: f32,
    /// Radiance of uniform surroundings that surfaces are lit by: the ambient term is this times the diffuse colour.
    pub ambient: f32,
    /// `D` of [`LightingModel::Distance`], in world units.
    pub max_distance: f32,
    /// Colour of rays that hit nothing, linear.
    pub background: Vec3,
    /// Key of all random numbers.
    pub seed: u32,
}

impl Default for Settings {
    fn default() -> Settings {
        Settings {
            width: 800,
            height: 800,
            samples: 1,
            grid_side: 1,
            pixel_sampling: PixelSampling::Random,
            integrator: Integrator::Whitted,
            roulette_depth: 4,
            clamp_indirect: crate::sums::MAX_RADIANCE,
            max_depth: 8,
            energy_threshold: 0.002,
            lighting_model: LightingModel::BlinnPhong,
            shadow_mode: ShadowMode::Opaque,
            fresnel: FresnelMode::Exact,
            cull_back_faces: false,
            light_from_behind: false,
            light_falloff: true,
            lamp_samples: 1,
            lamp_radiance: 1.0,
            ambient: 0.0,
            max_distance: 6.0,
            background: Vec3::ZERO,
            seed: 0,
        }
    }
}
