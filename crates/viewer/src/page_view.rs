//! What a page wants to see.

use eosphor::math::vec3;
use eosphor::settings::{Integrator, LightingModel, ShadowMode};
use eosphor::{Camera, Lens, PixelSampling, RenderSettings, Scene, SceneError, ToneCurve};
use serde::{Deserialize, Serialize};

/// Most pixels of a page's picture.
const MAX_PIXELS: u64 = 1 << 25;

/// A camera and settings that a page may change. All else is the scene's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct PageView {
    /// Width and height in pixels of the picture at rest.
    pub size: [u32; 2],
    /// Where it is seen from.
    pub camera: PageCamera,
    /// Samples of each pixel at rest.
    pub samples: u32,
    /// Points that a shading point samples on each triangle that is a light, at rest.
    pub light_samples: u32,
    /// Bounces after the camera ray.
    pub depth: u32,
    /// How surface points are lit.
    pub lighting: LightingModel,
    /// What stands between a point and a light does this.
    pub shadows: ShadowMode,
    /// Stops.
    pub exposure: f32,
    /// What becomes of light that is brighter than a screen.
    pub tone_curve: ToneCurve,
    /// The frame of the scene's animation, from 0.
    pub frame: u32,
    /// What is shown of the scene.
    pub show: Show,
}

/// What a page shows of the scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Show {
    /// The picture.
    #[default]
    Picture,
    /// Normals of what camera rays find first, in world space: red, green and blue from -1 to 1.
    Normals,
    /// How far away that is, from white to black.
    Depth,
    /// Which object that is, each in a colour of its own.
    Objects,
    /// Which material that is, each in a colour of its own.
    Materials,
    /// How many nodes and primitives camera rays test.
    Cost,
}

/// A camera that looks at a point. Coordinates are those of the scene's file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct PageCamera {
    /// Its position.
    pub eye: [f64; 3],
    /// The point in the middle of the picture.
    pub look_at: [f64; 3],
    /// What is up.
    pub up: [f32; 3],
    /// Horizontal field of view in degrees; of an orthographic camera it does not count.
    pub fov: f32,
    /// Radius of the lens in world units; 0 is a pin-hole.
    pub aperture: f32,
    /// Distance of the plane that is sharp; where not given, that of the point that is looked at.
    pub focus_distance: Option<f32>,
}

impl PageView {
    /// That of the scene's own camera and settings.
    ///
    /// # Errors
    ///
    /// Where the scene has no camera, and none can be found for it.
    pub(crate) fn of(scene: &Scene) -> Result<PageView, SceneError> {
        let settings = &scene.settings;
        let camera = match scene.camera_at(scene.frame) {
            Some(camera) => camera,
            None => scene.framed_camera()?,
        };
        let ahead = camera.direction.normalize();
        let look_at = camera.look_at.unwrap_or(camera.position + ahead * distance_ahead(scene, &camera));
        let [width, height] = settings.size;
        let camera = PageCamera {
            eye: scene.point_in_file(camera.position),
            look_at: scene.point_in_file(look_at),
            up: [camera.up.x, camera.up.y, camera.up.z],
            fov: fov_x_degrees(&camera, width as f32 / height as f32),
            aperture: camera.lens.map_or(0.0, |lens| lens.aperture_radius),
            focus_distance: camera.lens.and_then(|lens| lens.focus_distance),
        };
        Ok(PageView {
            size: settings.size,
            camera,
            samples: samples_of(settings),
            light_samples: settings.light_samples,
            depth: settings.depth,
            lighting: settings.lighting,
            shadows: settings.shadows,
            exposure: settings.exposure,
            tone_curve: settings.tone_curve,
            frame: scene.frame,
            show: Show::Picture,
        })
    }

    /// The camera of its frame and the settings of the picture at rest; `own` is the scene's own view.
    pub(crate) fn applied(&self, scene: &Scene, own: &PageView) -> (Camera, RenderSettings) {
        let camera = match self.camera_of_scene(scene, own) {
            Some(camera) => camera,
            None => self.camera(scene),
        };
        (camera, self.settings(scene))
    }

    /// The scene's camera, where the page has not changed it.
    pub(crate) fn camera_of_scene(&self, scene: &Scene, own: &PageView) -> Option<Camera> {
        scene.camera_at(self.frame).filter(|_| self.camera == own.camera)
    }

    fn camera(&self, scene: &Scene) -> Camera {
        let before = scene.camera_at(0).unwrap_or_default();
        let is_orthographic = before.orthographic_height.is_some();
        let [x, y, z] = self.camera.up;
        Camera {
            position: scene.point_of_file(self.camera.eye),
            look_at: Some(scene.point_of_file(self.camera.look_at)),
            up: vec3(x, y, z),
            fov_x_degrees: self.camera.fov,
            fov_y_degrees: if is_orthographic { before.fov_y_degrees } else { None },
            lens: self.lens(),
            ..before
        }
    }

    fn lens(&self) -> Option<Lens> {
        let PageCamera { aperture, focus_distance, .. } = self.camera;
        (aperture != 0.0).then_some(Lens { aperture_radius: aperture, focus_distance })
    }

    fn settings(&self, scene: &Scene) -> RenderSettings {
        let mut settings = scene.settings;
        settings.size = self.size;
        if self.samples != samples_of(&settings) {
            settings.samples = self.samples;
            if let PixelSampling::Grid(_) = settings.pixel_sampling {
                settings.pixel_sampling = PixelSampling::Random;
            }
        }
        settings.light_samples = self.light_samples;
        settings.depth = self.depth;
        settings.lighting = self.lighting;
        settings.shadows = self.shadows;
        settings.exposure = self.exposure;
        settings.tone_curve = self.tone_curve;
        settings
    }

    /// What is wrong with it, if anything: pages are not trusted.
    pub(crate) fn check(&self, scene: &Scene, own: &PageView) -> Result<(), String> {
        let pixels = self.size.map(u64::from).iter().product::<u64>();
        if pixels > MAX_PIXELS {
            return Err(format!("a picture of {pixels} pixels: at most {MAX_PIXELS}"));
        }
        let numbers = self.camera.eye.iter().chain(&self.camera.look_at);
        if numbers.copied().any(|x| !x.is_finite() || x.abs() > 1e12) {
            return Err("a camera out of range".into());
        }
        if !(self.camera.fov > 0.0 && self.camera.fov < 180.0) {
            return Err("a field of view out of range".into());
        }
        let lens = &self.camera;
        let in_range = |length: f32| (0.0..=1e12).contains(&length);
        let has_focus = lens.focus_distance.is_some();
        if !in_range(lens.aperture) || !lens.focus_distance.is_none_or(|focus| in_range(focus) && focus > 0.0)
        {
            return Err("a lens out of range".into());
        }
        // Flags cannot take it away.
        if own.camera.focus_distance.is_some() && !has_focus {
            return Err("the scene's lens has a distance that is sharp".into());
        }
        if self.frame >= frames_of(scene) {
            return Err(format!("there is no frame {}: the scene has {}", self.frame, frames_of(scene)));
        }
        let of_whitted = |view: &PageView| (view.lighting, view.shadows, view.light_samples);
        if scene.settings.integrator == Integrator::Path && of_whitted(self) != of_whitted(own) {
            return Err("path tracing has no lighting model, shadows and light samples to choose".into());
        }
        let (camera, settings) = self.applied(scene, own);
        settings.validate().map_err(|problem| problem.to_string())?;
        let shown = Scene { camera: Some(camera), settings, ..Scene::default() };
        shown.check_view().map_err(|error| error.to_string())
    }

    /// The flags of `eosphor render` that turn the scene's own view into this one, and its output.
    pub(crate) fn flags(&self, scene: &Scene, own: &PageView) -> Vec<String> {
        let is_new = |differs: fn(&PageView, &PageView) -> bool| differs(self, own);
        let point = |p: [f64; 3]| p.map(|x| x.to_string()).join(",");
        let mut flags = vec![format!("--size={}x{}", self.size[0], self.size[1])];
        if self.camera_of_scene(scene, own).is_none() {
            flags.push(format!("--eye={}", point(self.camera.eye)));
            flags.push(format!("--look-at={}", point(self.camera.look_at)));
            flags.push(format!("--up={}", self.camera.up.map(|x| x.to_string()).join(",")));
            if scene.camera.is_none_or(|camera| camera.orthographic_height.is_none()) {
                flags.push(format!("--fov={}", self.camera.fov));
            }
        }
        if is_new(|a, b| a.camera.aperture != b.camera.aperture) {
            flags.push(format!("--aperture={}", self.camera.aperture));
        }
        if let (Some(focus), Some(_)) = (self.camera.focus_distance, self.lens())
            && self.camera.focus_distance != own.camera.focus_distance
        {
            flags.push(format!("--focus-distance={focus}"));
        }
        if is_new(|a, b| a.samples != b.samples) {
            flags.push(format!("--samples={}", self.samples));
        }
        if is_new(|a, b| a.light_samples != b.light_samples) {
            flags.push(format!("--light-samples={}", self.light_samples));
        }
        if is_new(|a, b| a.depth != b.depth) {
            flags.push(format!("--depth={}", self.depth));
        }
        if is_new(|a, b| a.lighting != b.lighting) {
            flags.push(format!("--lighting={}", word(&self.lighting)));
        }
        if is_new(|a, b| a.shadows != b.shadows) {
            flags.push(format!("--shadows={}", word(&self.shadows)));
        }
        // A change of the lighting model brings an exposure and a tone curve of its own.
        if is_new(|a, b| a.exposure != b.exposure || a.lighting != b.lighting) {
            flags.push(format!("--exposure={}", self.exposure));
        }
        if is_new(|a, b| a.tone_curve != b.tone_curve || a.lighting != b.lighting) {
            flags.push(format!("--tone-curve={}", word(&self.tone_curve)));
        }
        if is_new(|a, b| a.frame != b.frame) {
            flags.push(format!("--frame={}", self.frame));
        }
        flags.extend(self.output_flags());
        flags
    }

    /// What is shown, and the file that it is written to.
    fn output_flags(&self) -> Vec<String> {
        let mut flags = vec!["--no-metadata".to_owned()];
        let layer = match self.show {
            Show::Picture => None,
            Show::Normals => Some("normal"),
            Show::Depth => Some("depth"),
            Show::Objects => Some("object"),
            Show::Materials => Some("material"),
            Show::Cost => {
                flags.push("--show=cost".into());
                None
            }
        };
        let file = match layer {
            Some(layer) => {
                flags.push(format!("--layers={layer}"));
                "picture.exr"
            }
            None => "picture.png",
        };
        flags.extend(["-o".to_owned(), file.to_owned()]);
        flags
    }
}

/// How many frames a scene has.
pub(crate) fn frames_of(scene: &Scene) -> u32 {
    scene.animation.as_ref().map_or(1, |animation| animation.frames.max(1))
}

/// The word of a setting, as files and flags write it.
fn word(setting: &impl Serialize) -> String {
    serde_json::to_value(setting).ok().and_then(|value| value.as_str().map(str::to_owned)).unwrap_or_default()
}

fn samples_of(settings: &RenderSettings) -> u32 {
    match settings.pixel_sampling {
        PixelSampling::Grid(side) => side * side,
        PixelSampling::Center | PixelSampling::Random => settings.samples,
    }
}

/// How far ahead of a camera without a point to look at the page's camera turns around.
fn distance_ahead(scene: &Scene, camera: &Camera) -> f32 {
    let focus = camera.lens.and_then(|lens| lens.focus_distance);
    let framed = || {
        let framed =
            Scene { camera: None, animation: None, frame: 0, ..scene.clone() }.framed_camera().ok()?;
        Some((framed.look_at? - camera.position).length())
    };
    focus.or_else(framed).filter(|d| d.is_finite() && *d > 0.0).unwrap_or(1.0)
}

/// Horizontal field of view in degrees, also of a camera that says the vertical one.
fn fov_x_degrees(camera: &Camera, aspect: f32) -> f32 {
    match camera.fov_y_degrees {
        Some(fov_y) => {
            let tangent = f64::from(fov_y).to_radians() / 2.0;
            (2.0 * (tangent.tan() * f64::from(aspect)).atan()).to_degrees() as f32
        }
        None => camera.fov_x_degrees,
    }
}
