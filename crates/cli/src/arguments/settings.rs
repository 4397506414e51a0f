//! Flags that override the scene's render settings.

use super::values::{OVER_0, color, named, size, whole, within};
use super::{Need, PictureFlags, TextureFlags, check};
use crate::failure::Failure;
use clap::Args;
use clap::builder::TypedValueParser;
use eosphor::math::Vec3;
use eosphor::settings::{FresnelMode, Integrator, LightingModel, ShadowMode};
use eosphor::{
    Composition, LightSelection, LightUnits, LoadOptions, NormalMode, PixelSampling, RenderSettings,
    ToneCurve, Transfer,
};

/// Each wins over the preset, which wins over the scene.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Settings (flags override the preset, which overrides the scene)")]
pub(crate) struct SettingsFlags {
    /// Picture size in pixels, each side 1 to 65535 [default: 800x600]
    #[arg(long, value_name = "WxH", value_parser = size, allow_hyphen_values = true)]
    size: Option<[u32; 2]>,
    /// Samples per pixel, 1 to 65536 [default: 1, but 32 for path-traced glTF]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..=65_536), allow_hyphen_values = true, conflicts_with = "ssaa")]
    samples: Option<u32>,
    /// K x K samples per pixel in a regular grid, 1 to 256; replaces --samples
    #[arg(long, value_name = "K", value_parser = whole::<u32>(1..=256), allow_hyphen_values = true)]
    ssaa: Option<u32>,
    /// Where the samples of a pixel lie: all in its centre, or spread over it at random [default: random]
    #[arg(long, value_name = "WHERE", value_parser = pixel_samplings(), conflicts_with = "ssaa")]
    pixel_sampling: Option<PixelSampling>,
    /// How rays go on. whitted: mirrors, glass and light straight from lights, without noise but that of lamps; path: light that
    /// bounces from everything, noisy with few samples [default: whitted, but path for glTF]
    #[arg(long, value_name = "NAME", value_parser = integrators())]
    integrator: Option<Integrator>,
    /// Path tracing: from so many bounces on end paths that carry little by chance, 0 to 64; changes no mean [default: 4]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(0..=64), allow_hyphen_values = true)]
    roulette: Option<u32>,
    /// Path tracing: cut light that bounces before it reaches the first surface to this radiance, over 0 and at most 1e12: fewer
    /// bright dots, and less light [default: no cut]
    #[arg(long, value_name = "X", value_parser = within(OVER_0), allow_hyphen_values = true)]
    clamp_indirect: Option<f32>,
    /// Which lights are sampled at a point. all: each of them (not with --integrator path); or one at a time: tree, by how much it
    /// may give to the point; power, by how much it sends out; uniform, any [default: tree, but all for whitted up to 64
    /// triangles that are lights]
    #[arg(long, value_name = "WAY", value_parser = light_selections())]
    lights: Option<LightSelection>,
    /// Points to sample on each triangle that is a light, per shaded point, 1 to 65536; where one of these is chosen at a time, on
    /// all of them together [default: 16]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..=65_536), allow_hyphen_values = true)]
    light_samples: Option<u32>,
    /// Largest number of bounces after the camera ray, 0 to 64 [default: 8]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(0..=64), allow_hyphen_values = true)]
    depth: Option<u32>,
    /// Do not trace rays whose share of the pixel's colour is below this, 0 to 1 [default: 0.002]
    #[arg(long, value_name = "X", value_parser = within(0.0..=1.0), allow_hyphen_values = true)]
    energy_threshold: Option<f32>,
    /// Lighting model. distance: grey by distance; diffuse: the diffuse colour alone (neither has lights, and neither
    /// exposure nor tone curve unless they are given); lambert, phong, blinn-phong: lit by lights [default: blinn-phong]
    #[arg(long, value_name = "MODEL", value_parser = lighting_models())]
    lighting: Option<LightingModel>,
    /// What surfaces between a point and a light do: nothing, block the light, or colour it if they are transparent [default:
    /// opaque]
    #[arg(long, value_name = "MODE", value_parser = shadow_modes())]
    shadows: Option<ShadowMode>,
    /// Fresnel factor: by the exact equations, by Schlick's approximation, or constant as at normal incidence [default: exact]
    #[arg(long, value_name = "MODE", value_parser = fresnel_modes())]
    fresnel: Option<FresnelMode>,
    /// Normals of triangles: flat; smooth, from the file; auto, from the file or generated where it has none; or generated for
    /// all [default: auto]
    #[arg(long, value_name = "MODE", value_parser = normal_modes())]
    normals: Option<NormalMode>,
    /// For generated normals: edges sharper than this angle stay sharp, 0 to 180 [default: 40]
    #[arg(long, value_name = "DEGREES", value_parser = within(0.0..=180.0), allow_hyphen_values = true)]
    crease: Option<f32>,
    /// Show triangles from the front only
    #[arg(long, overrides_with = "no_cull")]
    cull: bool,
    /// Show triangles from both sides [default]
    #[arg(long, overrides_with = "cull")]
    no_cull: bool,
    /// Transparent surfaces also receive light from their far side
    #[arg(long, overrides_with = "no_light_from_behind")]
    light_from_behind: bool,
    /// Transparent surfaces receive no light from their far side [default]
    #[arg(long, overrides_with = "light_from_behind")]
    no_light_from_behind: bool,
    /// Units of lights. physical: a matte surface reflects colour/pi of its irradiance, as in glTF; plain: without pi, as in
    /// the reference systems [default: physical]
    #[arg(long, value_name = "UNITS", value_parser = light_units())]
    light_units: Option<LightUnits>,
    /// Point and spot lights fall off with the square of the distance [default]
    #[arg(long, overrides_with = "no_light_falloff")]
    light_falloff: bool,
    /// Point and spot lights are equally strong at any distance
    #[arg(long, overrides_with = "light_falloff")]
    no_light_falloff: bool,
    /// Add a light at the camera to a scene without lights (with --preset eos: that system's two lights), and uniform grey
    /// surroundings to a glTF file without lights [default: on]
    #[arg(long, value_name = "ON", value_parser = named([("on", true), ("off", false)]))]
    headlight: Option<bool>,
    /// Radiance of uniform surroundings: adds this times the diffuse colour to every surface, 0 to 1e6 [default: 0]
    #[arg(long, value_name = "X", value_parser = within(0.0..=1e6), allow_hyphen_values = true)]
    ambient: Option<f32>,
    /// D of --lighting distance, whose grey is 1 - min(t, 1.5 D) / (1.5 D) at distance t: in world units, over 0 and at most
    /// 1e12 [default: the distance from the camera to the farthest corner of the scene's box, divided by 1.5]
    #[arg(long, value_name = "X", value_parser = within(OVER_0), allow_hyphen_values = true)]
    max_distance: Option<f32>,
    /// Radiance of rays that hit nothing: linear red, green and blue, each 0 or more [default: 0,0,0]
    #[arg(long, value_name = "R,G,B", value_parser = color, allow_hyphen_values = true)]
    background: Option<Vec3>,
    /// What reflects and transmits in MTL materials. native: by illum, with Fresnel; pg1: reflection is Ks, transmission Tf,
    /// no Fresnel; eos: reflection is 0.4 where the material reflects [default: native]
    #[arg(long, value_name = "WAY", value_parser = compositions())]
    composition: Option<Composition>,
    /// Decode colour textures from sRGB [default]
    #[arg(long, overrides_with = "linear_textures")]
    srgb_textures: bool,
    /// Read colour textures as linear
    #[arg(long, overrides_with = "srgb_textures")]
    linear_textures: bool,
    /// Tone curve, which keeps some detail of what is brighter than white. none: it is cut; neutral: Khronos PBR Neutral, colours
    /// as they are up to 0.8 and compressed above; agx: AgX, soft contrast; aces: ACES by Hill's fit, strong contrast [default:
    /// none, but neutral for path-traced glTF]
    #[arg(long, value_name = "CURVE", value_parser = tone_curves())]
    tone_curve: Option<ToneCurve>,
    /// Transfer curve from linear colours to bytes [default: srgb]
    #[arg(long, value_name = "CURVE", value_parser = transfers())]
    transfer: Option<Transfer>,
    /// Exposure in stops, -64 to 64: colours are multiplied by 2 to this power [default: 0]
    #[arg(long, value_name = "STOPS", value_parser = within(-64.0..=64.0), allow_hyphen_values = true)]
    exposure: Option<f32>,
    /// Seed of all random numbers, 0 to 4294967295 [default: 0]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(0..=u32::MAX), allow_hyphen_values = true)]
    seed: Option<u32>,
}

impl SettingsFlags {
    /// Fails where one of these does nothing beside the others and what the scene says, which have been applied.
    pub(crate) fn check(&self, settings: &RenderSettings) -> Result<(), Failure> {
        let (whitted, path) = (Integrator::Whitted, Integrator::Path);
        let of = |integrator, flag, is_given| Need {
            flag,
            is_given,
            is_met: settings.integrator == integrator,
            needs: if integrator == path { "--integrator path" } else { "--integrator whitted" },
        };
        check(&[
            of(path, "--roulette", self.roulette.is_some()),
            of(path, "--clamp-indirect", self.clamp_indirect.is_some()),
            of(whitted, "--lights all", self.lights == Some(LightSelection::All)),
            of(whitted, "--light-samples", self.light_samples.is_some()),
            of(whitted, "--energy-threshold", self.energy_threshold.is_some()),
            of(whitted, "--lighting", self.lighting.is_some()),
            of(whitted, "--shadows", self.shadows.is_some()),
            of(whitted, "--fresnel", self.fresnel.is_some()),
            of(whitted, "--cull", self.cull),
            of(whitted, "--no-cull", self.no_cull),
            of(whitted, "--light-from-behind", self.light_from_behind),
            of(whitted, "--no-light-from-behind", self.no_light_from_behind),
            of(whitted, "--no-light-falloff", self.no_light_falloff),
            of(whitted, "--composition", self.composition.is_some()),
            Need {
                flag: "--max-distance",
                is_given: self.max_distance.is_some(),
                is_met: settings.lighting == LightingModel::Distance,
                needs: "--lighting distance",
            },
            Need {
                flag: "--crease",
                is_given: self.crease.is_some(),
                is_met: matches!(settings.normals, NormalMode::Auto | NormalMode::Generated),
                needs: "--normals auto or generated",
            },
        ])
    }

    /// Fails where one of these does nothing, as nothing is developed: linear files keep colours as they are, and other pictures
    /// of the scene have theirs.
    pub(crate) fn check_development(&self, is_developed: bool) -> Result<(), Failure> {
        let need = |flag, is_given| Need {
            flag,
            is_given,
            is_met: is_developed,
            needs: "a picture of the scene in bytes (.png, .jpg, .ppm, .data, .mp4), as .exr and .hdr stay linear",
        };
        check(&[
            need("--exposure", self.exposure.is_some()),
            need("--tone-curve", self.tone_curve.is_some()),
            need("--transfer", self.transfer.is_some()),
        ])
    }

    /// Whether they say the size.
    #[cfg(feature = "video")]
    pub(crate) fn has_size(&self) -> bool {
        self.size.is_some()
    }

    /// How a file is read; `camera` is the one to take. Where flags bring light, files without any need none. A preset has all
    /// settings, and they are Whitted's.
    pub(crate) fn load_options(
        &self,
        camera: Option<String>,
        picture: &PictureFlags,
        textures: &TextureFlags,
    ) -> LoadOptions {
        let mut options = LoadOptions::default();
        (options.camera, options.headlight) = (camera, self.headlight.unwrap_or(!picture.are_lit()));
        options.integrator = picture.preset.map(|_| Integrator::Whitted).or(self.integrator);
        options.texture_memory_bytes = textures.memory_bytes();
        options
    }

    /// Overrides what was given.
    pub(crate) fn apply(&self, settings: &mut RenderSettings) {
        set(&mut settings.size, self.size);
        set(&mut settings.samples, self.samples);
        // Samples by number make sense only where the scene's own grid goes.
        if let (PixelSampling::Grid(_), Some(_)) = (settings.pixel_sampling, self.samples) {
            settings.pixel_sampling = PixelSampling::Random;
        }
        set(&mut settings.pixel_sampling, self.ssaa.map(PixelSampling::Grid).or(self.pixel_sampling));
        set(&mut settings.integrator, self.integrator);
        set(&mut settings.roulette, self.roulette);
        set(&mut settings.clamp_indirect, self.clamp_indirect.map(Some));
        set(&mut settings.lights, self.lights.map(Some));
        set(&mut settings.light_samples, self.light_samples);
        set(&mut settings.depth, self.depth);
        set(&mut settings.energy_threshold, self.energy_threshold);
        set(&mut settings.lighting, self.lighting);
        set(&mut settings.shadows, self.shadows);
        set(&mut settings.fresnel, self.fresnel);
        set(&mut settings.normals, self.normals);
        set(&mut settings.crease_degrees, self.crease);
        set(&mut settings.cull_back_faces, switch(self.cull, self.no_cull));
        set(&mut settings.light_from_behind, switch(self.light_from_behind, self.no_light_from_behind));
        set(&mut settings.light_units, self.light_units);
        set(&mut settings.light_falloff, switch(self.light_falloff, self.no_light_falloff));
        set(&mut settings.headlight, self.headlight);
        set(&mut settings.ambient, self.ambient);
        set(&mut settings.max_distance, self.max_distance.map(Some));
        set(&mut settings.background, self.background);
        set(&mut settings.composition, self.composition);
        set(&mut settings.srgb_textures, switch(self.srgb_textures, self.linear_textures));
        set(&mut settings.transfer, self.transfer);
        // Unlit models show colours, which need neither.
        let is_unlit = self.lighting.is_some_and(|model| !model.is_lit());
        set(&mut settings.exposure, self.exposure.or(is_unlit.then_some(0.0)));
        set(&mut settings.tone_curve, self.tone_curve.or(is_unlit.then_some(ToneCurve::None)));
        set(&mut settings.seed, self.seed);
    }
}

fn set<T>(setting: &mut T, flag: Option<T>) {
    if let Some(value) = flag {
        *setting = value;
    }
}

fn switch(on: bool, off: bool) -> Option<bool> {
    (on || off).then_some(on)
}

fn pixel_samplings() -> impl TypedValueParser<Value = PixelSampling> {
    named([("center", PixelSampling::Center), ("random", PixelSampling::Random)])
}

fn integrators() -> impl TypedValueParser<Value = Integrator> {
    named([("whitted", Integrator::Whitted), ("path", Integrator::Path)])
}

fn light_selections() -> impl TypedValueParser<Value = LightSelection> {
    named([
        ("all", LightSelection::All),
        ("tree", LightSelection::Tree),
        ("power", LightSelection::Power),
        ("uniform", LightSelection::Uniform),
    ])
}

fn lighting_models() -> impl TypedValueParser<Value = LightingModel> {
    named([
        ("distance", LightingModel::Distance),
        ("diffuse", LightingModel::Diffuse),
        ("lambert", LightingModel::Lambert),
        ("phong", LightingModel::Phong),
        ("blinn-phong", LightingModel::BlinnPhong),
    ])
}

fn shadow_modes() -> impl TypedValueParser<Value = ShadowMode> {
    named([("none", ShadowMode::None), ("opaque", ShadowMode::Opaque), ("coloured", ShadowMode::Coloured)])
}

fn fresnel_modes() -> impl TypedValueParser<Value = FresnelMode> {
    named([
        ("exact", FresnelMode::Exact),
        ("schlick", FresnelMode::Schlick),
        ("constant", FresnelMode::Constant),
    ])
}

fn normal_modes() -> impl TypedValueParser<Value = NormalMode> {
    named([
        ("flat", NormalMode::Flat),
        ("smooth", NormalMode::Smooth),
        ("auto", NormalMode::Auto),
        ("generated", NormalMode::Generated),
    ])
}

fn light_units() -> impl TypedValueParser<Value = LightUnits> {
    named([("physical", LightUnits::Physical), ("plain", LightUnits::Plain)])
}

fn compositions() -> impl TypedValueParser<Value = Composition> {
    named([("native", Composition::Native), ("pg1", Composition::Pg1), ("eos", Composition::Eos)])
}

fn tone_curves() -> impl TypedValueParser<Value = ToneCurve> {
    named([
        ("none", ToneCurve::None),
        ("neutral", ToneCurve::Neutral),
        ("agx", ToneCurve::Agx),
        ("aces", ToneCurve::Aces),
    ])
}

fn transfers() -> impl TypedValueParser<Value = Transfer> {
    named([("srgb", Transfer::Srgb), ("linear", Transfer::Linear)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Only {
        #[command(flatten)]
        flags: SettingsFlags,
    }

    fn apply(flags: &[&str], mut settings: RenderSettings) -> RenderSettings {
        let parsed = Only::try_parse_from(["x"].iter().chain(flags)).unwrap_or_else(|e| panic!("{e}"));
        parsed.flags.apply(&mut settings);
        settings
    }

    #[test]
    fn no_flag_changes_nothing() {
        let settings = RenderSettings { seed: 7, depth: 3, ..RenderSettings::default() };
        assert_eq!(apply(&[], settings), settings);
    }

    #[test]
    fn flags_win_and_the_last_of_a_pair_too() {
        let flags = ["--cull", "--no-cull", "--size", "7x9", "--background", "1,0,2", "--exposure", "-1"];
        let default = RenderSettings { cull_back_faces: true, ..RenderSettings::default() };
        let settings = apply(&flags, default);
        assert!(!settings.cull_back_faces);
        assert_eq!((settings.size, settings.exposure, settings.background.x), ([7, 9], -1.0, 1.0));
    }

    #[test]
    fn unlit_models_are_not_exposed_unless_a_flag_says_so() {
        let exposed =
            RenderSettings { exposure: 2.0, tone_curve: ToneCurve::Agx, ..RenderSettings::default() };
        assert_eq!(apply(&["--lighting", "diffuse"], exposed).exposure, 0.0);
        assert_eq!(apply(&["--lighting", "diffuse"], exposed).tone_curve, ToneCurve::None);
        let aces = ["--lighting", "diffuse", "--tone-curve", "aces"];
        assert_eq!(apply(&aces, exposed).tone_curve, ToneCurve::Aces);
        assert_eq!(apply(&["--lighting", "distance", "--exposure", "1"], exposed).exposure, 1.0);
        assert_eq!(apply(&["--lighting", "lambert"], exposed).exposure, 2.0);
    }

    #[test]
    fn samples_and_grids_replace_each_other() {
        let grid = RenderSettings { pixel_sampling: PixelSampling::Grid(4), ..RenderSettings::default() };
        assert_eq!(apply(&["--samples", "9"], grid).pixel_sampling, PixelSampling::Random);
        assert_eq!(apply(&["--ssaa", "3"], grid).pixel_sampling, PixelSampling::Grid(3));
        assert!(Only::try_parse_from(["x", "--ssaa", "3", "--samples", "4"]).is_err());
    }
}
