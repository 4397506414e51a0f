//! How to render a scene.

use super::schema_types::Color;
use eosphor_core::develop::{ToneCurve, Transfer};
use eosphor_core::math::Vec3;
use eosphor_core::settings::{FresnelMode, Integrator, LightingModel, ShadowMode};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Everything that a scene file can say about rendering. All of it can be overridden by a flag.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields, default)]
pub struct RenderSettings {
    /// Width and height in pixels, 1 to 65,535 each.
    #[schemars(inner(range(min = 1, max = 65_535)))]
    pub size: [u32; 2],
    /// Samples a pixel; ignored with a sample grid.
    #[schemars(range(min = 1, max = 65_536))]
    pub samples: u32,
    /// Where the samples of a pixel lie.
    pub pixel_sampling: PixelSampling,
    /// How the rays of a sample find what a pixel shows.
    pub integrator: Integrator,
    /// Path tracing: from so many bounces on paths that carry little end by chance, which changes no mean.
    #[schemars(range(min = 0, max = 64))]
    pub roulette: u32,
    /// Path tracing: light that has bounced before it reaches the first surface is cut to this radiance, its hue kept. That takes
    /// bright dots away, and some light with them; where not given, nothing is cut.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub clamp_indirect: Option<f32>,
    /// How lights are chosen for a point. Where not given, path tracing takes the tree, and Whitted's ray tracing all of them up to
    /// 64 triangles that are lights, for more the tree.
    pub lights: Option<LightSelection>,
    /// Points a shading point samples on each triangle that is a light; where one of these is chosen at a time, on all of them
    /// together.
    #[schemars(range(min = 1, max = 65_536))]
    pub light_samples: u32,
    /// Bounces after the camera ray, at most 64.
    #[schemars(range(min = 0, max = 64))]
    pub depth: u32,
    /// A ray dies when the largest component of its weight is below this.
    #[schemars(range(min = 0, max = 1))]
    pub energy_threshold: f32,
    /// How surface points are lit.
    pub lighting: LightingModel,
    /// What stands between a point and a light does this.
    pub shadows: ShadowMode,
    /// How the Fresnel factor is computed.
    pub fresnel: FresnelMode,
    /// How normals vary over a triangle.
    pub normals: NormalMode,
    /// With generated normals: neighbours that meet at more than this many degrees keep a crease.
    #[schemars(range(min = 0, max = 180))]
    pub crease_degrees: f32,
    /// Triangles are seen from the front only.
    pub cull_back_faces: bool,
    /// Transparent surfaces also receive light from their far side.
    pub light_from_behind: bool,
    /// What the colours of lights and lamps mean to the surfaces that they light.
    pub light_units: LightUnits,
    /// Point and spot lights fall off with the square of the distance.
    pub light_falloff: bool,
    /// A scene without any light has one at the camera (with the preset `eos` that system's two lights instead), and a glTF file
    /// without lights grey surroundings. An empty list of `lights` turns that off.
    pub headlight: bool,
    /// Radiance of uniform surroundings that surfaces are lit by: the ambient term is this times the diffuse colour.
    #[schemars(range(min = 0, max = 1_000_000))]
    pub ambient: f32,
    /// `D` of the lighting model `distance`, in world units; where not given, the distance from the camera to the far side of
    /// the scene over 1.5.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub max_distance: Option<f32>,
    /// Radiance of rays that hit nothing.
    #[schemars(with = "Color")]
    pub background: Vec3,
    /// What reflects and transmits in MTL materials.
    pub composition: Composition,
    /// Colour textures are sRGB-coded; otherwise linear.
    pub srgb_textures: bool,
    /// What becomes of light that is brighter than a screen. Linear files (EXR, HDR) keep it as it is.
    pub tone_curve: ToneCurve,
    /// How linear colours become bytes.
    pub transfer: Transfer,
    /// Stops: colours are multiplied by 2 to this power before anything else.
    #[schemars(range(min = -64, max = 64))]
    pub exposure: f32,
    /// Key of all random numbers.
    #[schemars(range(min = 0, max = 4_294_967_295u32))]
    pub seed: u32,
}

/// Where the samples of a pixel lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum PixelSampling {
    /// All in the middle.
    Center,
    /// Well-distributed random points over the pixel.
    Random,
    /// A regular grid of this many by this many samples (SSAA).
    Grid(#[schemars(range(min = 1, max = 256))] u32),
}

/// How lights are chosen for a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LightSelection {
    /// Each of them, at every point. Not for path tracing.
    All,
    /// One at a time, by how much it may give to the point, as a tree over lights estimates it.
    Tree,
    /// One at a time, by how much light it sends out.
    Power,
    /// One at a time, all with the same chance.
    Uniform,
}

/// How normals vary over a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum NormalMode {
    /// One normal a triangle.
    Flat,
    /// The file's normals, interpolated; triangles without any are flat.
    Smooth,
    /// The file's normals; generated ones (by crease angle) for triangles without any.
    Auto,
    /// Generated for all triangles, whatever the file says.
    Generated,
}

/// What reflects and transmits in MTL materials.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Composition {
    /// By `illum`, with Fresnel.
    Native,
    /// `kr = Ks` whatever illum says, `kt = Tf` (0 when the file has none), no Fresnel.
    Pg1,
    /// `kr = 0.4` where the material is reflective.
    Eos,
}

/// What the colours of lights and lamps mean to the surfaces that they light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LightUnits {
    /// Intensity, irradiance and radiance: a matte surface of colour rho reflects rho over pi of its irradiance.
    Physical,
    /// The formula of the reference systems, without the pi: a matte surface reflects rho times what arrives.
    Plain,
}

impl RenderSettings {
    /// Radiance of the uniform surroundings that path tracing gives a scene without any light.
    pub const SURROUNDINGS: f32 = 0.5;

    /// Keys of settings that an integrator does not read: those of the other one.
    pub fn keys_not_read(integrator: Integrator) -> &'static [&'static str] {
        match integrator {
            Integrator::Whitted => &["roulette", "clamp-indirect"],
            Integrator::Path => &[
                "light-samples",
                "energy-threshold",
                "lighting",
                "shadows",
                "fresnel",
                "cull-back-faces",
                "light-from-behind",
                "light-units",
                "light-falloff",
                "composition",
                "max-distance",
            ],
        }
    }
}

impl Default for RenderSettings {
    fn default() -> RenderSettings {
        RenderSettings {
            size: [800, 600],
            samples: 1,
            pixel_sampling: PixelSampling::Random,
            integrator: Integrator::Whitted,
            roulette: 4,
            clamp_indirect: None,
            lights: None,
            light_samples: 16,
            depth: 8,
            energy_threshold: 0.002,
            lighting: LightingModel::BlinnPhong,
            shadows: ShadowMode::Opaque,
            fresnel: FresnelMode::Exact,
            normals: NormalMode::Auto,
            crease_degrees: 40.0,
            cull_back_faces: false,
            light_from_behind: false,
            light_units: LightUnits::Physical,
            light_falloff: true,
            headlight: true,
            ambient: 0.0,
            max_distance: None,
            background: Vec3::ZERO,
            composition: Composition::Native,
            srgb_textures: true,
            tone_curve: ToneCurve::None,
            transfer: Transfer::Srgb,
            exposure: 0.0,
            seed: 0,
        }
    }
}
