//! Presets: render as the reference systems do.

use crate::model::{
    Camera, Composition, Light, LightSelection, LightUnits, Material, MaterialKind, Mtl, NormalMode,
};
use crate::model::{PixelSampling, RenderSettings, Scene, double};
use eosphor_core::develop::Transfer;
use eosphor_core::math::{Vec3, vec3};
use eosphor_core::settings::{FresnelMode, LightingModel, ShadowMode};
use std::fmt;
use std::str::FromStr;

/// The way of one of the reference systems.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Preset {
    /// "Porting and optimization of a ray-tracing application on a manycore platform", Thessaly 2015.
    Eos,
    /// "Raytracer with an acceleration structure and a GPU implementation", CTU FIT 2025.
    Pg1,
    /// PLATO: "Backward ray tracing with MPI, CUDA and OpenMP", a course project of MAI.
    Course,
}

/// No preset has this name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no preset \"{0}\"; there are eos, pg1 and course")]
pub struct UnknownPreset(pub String);

impl Preset {
    /// All presets.
    pub const ALL: [Preset; 3] = [Preset::Eos, Preset::Pg1, Preset::Course];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Preset::Eos => "eos",
            Preset::Pg1 => "pg1",
            Preset::Course => "course",
        }
    }

    /// Makes a scene look as in that system.
    ///
    /// All [`RenderSettings`] but the seed and the headlight become the preset's, whatever the scene said: they are what
    /// the preset is. What a scene shows is its own: a camera, and for `eos` lights, are put only where it has none, the
    /// lights only where the scene lets light be added ([`RenderSettings::headlight`]), and the default material, which
    /// nobody chose, becomes that of the system. Flags of the command line apply after this.
    pub fn apply(&self, scene: &mut Scene) {
        let RenderSettings { seed, headlight, .. } = scene.settings;
        scene.settings = RenderSettings { seed, headlight, ..self.settings() };
        match self {
            Preset::Eos => eos_scene(scene),
            Preset::Pg1 => {
                place_camera(scene, pg1_camera());
            }
            Preset::Course => {}
        }
    }

    /// The render settings that reproduce this preset's reference system.
    pub fn settings(self) -> RenderSettings {
        let common = RenderSettings {
            samples: 1,
            pixel_sampling: PixelSampling::Center,
            energy_threshold: 0.0,
            shadows: ShadowMode::Opaque,
            fresnel: FresnelMode::Exact,
            normals: NormalMode::Smooth,
            lights: Some(LightSelection::All),
            light_units: LightUnits::Plain,
            light_falloff: false,
            srgb_textures: false,
            transfer: Transfer::Linear,
            ..RenderSettings::default()
        };
        match self {
            Preset::Eos => RenderSettings {
                size: [1280, 720],
                depth: 5,
                lighting: LightingModel::Phong,
                ambient: 0.15,
                composition: Composition::Eos,
                ..common
            },
            Preset::Pg1 => RenderSettings {
                size: [800, 800],
                depth: 10,
                light_samples: 50,
                lighting: LightingModel::BlinnPhong,
                cull_back_faces: true,
                max_distance: Some(6.0),
                background: Vec3::splat(0.01),
                composition: Composition::Pg1,
                ..common
            },
            Preset::Course => RenderSettings {
                size: [640, 480],
                depth: 6,
                pixel_sampling: PixelSampling::Grid(2),
                light_samples: 1,
                lighting: LightingModel::Phong,
                shadows: ShadowMode::Coloured,
                energy_threshold: 0.005,
                normals: NormalMode::Flat,
                ..common
            },
        }
    }
}

/// The settings of PLATO's course project; size, depth and rays a pixel are those of its measurements.
pub fn course_settings() -> RenderSettings {
    Preset::Course.settings()
}

/// PG1's camera for the Cornell box: its field of view is 0.6 rad.
pub(crate) fn pg1_camera() -> Camera {
    Camera {
        position: vec3(0.0, 1.0, 4.42),
        direction: vec3(0.0, 0.0, -1.0),
        fov_x_degrees: 34.377_47,
        ..Camera::default()
    }
}

/// Gives a scene without a camera this one, which has coordinates of the file.
fn place_camera(scene: &mut Scene, camera: Camera) {
    let position = scene.point_of_file(double(camera.position));
    scene.camera.get_or_insert(Camera { position, ..camera });
}

/// Camera, lights and material of EOS. Its view plane reaches from -1 to 1 at distance 1 whatever its `FOV` says, so
/// the horizontal field of view is 90 degrees.
fn eos_scene(scene: &mut Scene) {
    let camera = Camera {
        position: vec3(2.0, 0.0, 5.0),
        direction: vec3(0.0, 0.0, -1.0),
        fov_x_degrees: 90.0,
        ..Camera::default()
    };
    place_camera(scene, camera);
    if scene.settings.headlight && scene.lights.is_empty() && !scene.has_emissive_triangles() {
        let place = |x| scene.point_of_file([x, 10.0, 10.0]);
        let light = |x| Light::Point { position: place(x), color: Vec3::ONE };
        let both = [light(-20.0), light(20.0)];
        scene.lights.extend(both);
    }
    for material in scene.materials.iter_mut().filter(|m| m.is_default()) {
        // Reflective: illum 3, from which the composition of EOS makes kr = 0.4.
        let mtl = Mtl { Kd: Vec3::splat(0.75), Ks: Vec3::ONE, Ns: 120.0, illum: 3, ..Mtl::default() };
        *material = Material::new("eos", MaterialKind::Mtl(mtl));
    }
}

impl fmt::Display for Preset {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Preset {
    type Err = UnknownPreset;
    fn from_str(name: &str) -> Result<Preset, UnknownPreset> {
        Preset::ALL.into_iter().find(|p| p.name() == name).ok_or_else(|| UnknownPreset(name.into()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_round_trip() {
        for preset in Preset::ALL {
            assert_eq!(preset.to_string().parse(), Ok(preset));
        }
        let error = "x".parse::<Preset>().unwrap_err();
        assert_eq!(error.to_string(), "there is no preset \"x\"; there are eos, pg1 and course");
    }

    #[test]
    fn pg1_has_its_field_of_view() {
        let radians = f64::from(pg1_camera().fov_x_degrees) * (std::f64::consts::PI / 180.0);
        assert!((radians - 0.6).abs() < 1e-7);
    }

    #[test]
    fn a_preset_keeps_what_the_scene_shows() {
        let camera = Camera { fov_x_degrees: 10.0, ..Camera::default() };
        let light = Light::Point { position: Vec3::ONE, color: Vec3::ONE };
        let mut scene = Scene { camera: Some(camera), lights: vec![light], ..Scene::default() };
        scene.settings.seed = 7;
        Preset::Eos.apply(&mut scene);
        assert_eq!((scene.camera, scene.lights.len()), (Some(camera), 1));
        assert_eq!((scene.settings.seed, scene.settings.size), (7, [1280, 720]));

        let mut bare = Scene { materials: vec![Material::default_material()], ..Scene::default() };
        Preset::Eos.apply(&mut bare);
        assert_eq!((bare.camera.unwrap().position, bare.lights.len()), (vec3(2.0, 0.0, 5.0), 2));
        assert!(matches!(bare.materials[0].kind, MaterialKind::Mtl(Mtl { illum: 3, Ns: 120.0, .. })));
    }

    #[test]
    fn no_preset_brings_light_that_the_scene_does_not_want() {
        for preset in Preset::ALL {
            let mut dark = Scene::default();
            dark.settings.headlight = false;
            preset.apply(&mut dark);
            assert!(dark.lights.is_empty() && !dark.settings.headlight, "{preset}");
            let mut open = Scene::default();
            preset.apply(&mut open);
            assert!(open.settings.headlight, "{preset}");
        }
    }

    #[test]
    fn settings_of_presets_are_valid() {
        for preset in Preset::ALL {
            preset.settings().validate().unwrap();
        }
    }
}
