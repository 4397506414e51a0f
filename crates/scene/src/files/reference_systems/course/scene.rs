//! [`CourseInput`] → a scene.

use super::{CourseBody, CourseFloor, CourseInput, CourseOptions};
use crate::error::SceneError;
use crate::files::loader::Loader;
use crate::files::reference_systems::course_settings;
use crate::files::source::Source;
use crate::files::{LoadOptions, LoadedScene};
use crate::model::{
    Animation, Camera, CameraMotion, Light, Material, MaterialKind, MaterialTextures, PixelSampling,
    Quadrilateral, RenderSettings, Texture,
};
use crate::solids::{Body, BodyLighting, FACE_DIFFUSE, PLATO_POWER, SHININESS, Solid};
use eosphor_core::math::vec3;
use eosphor_core::texture::TextureWrap;
use std::path::Path;

impl CourseInput {
    /// The scene, with PLATO's settings and the camera's laws as its animation: frame k is at `t = 2 pi k / frames`.
    ///
    /// # Errors
    /// A texture that cannot be read, by its path; numbers out of range, where the input was not parsed.
    pub fn scene(&self, options: &CourseOptions) -> Result<LoadedScene, SceneError> {
        self.scene_from(Source::Disk, options)
    }

    pub(in crate::files) fn scene_from(
        &self,
        source: Source,
        options: &CourseOptions,
    ) -> Result<LoadedScene, SceneError> {
        let texture_memory_bytes = options.texture_memory_bytes;
        let load = LoadOptions { texture_memory_bytes, ..LoadOptions::default() };
        let mut loader = Loader::new(source, &load);
        for (body, shape) in self.bodies.iter().zip(options.shapes) {
            let Some(shape) = shape else { continue };
            body.body(shape, options.diodes).add_to(&mut loader.scene)?;
        }
        self.floor.add_to(&mut loader, &options.folder)?;
        let scene = &mut loader.scene;
        let light = |l: &super::CourseLight| Light::Point { position: l.position, color: l.color };
        scene.lights.extend(self.lights.iter().map(light));
        scene.settings = RenderSettings {
            size: self.size,
            depth: self.depth,
            pixel_sampling: PixelSampling::Grid(self.rays_root),
            ..course_settings()
        };
        scene.camera = Some(Camera {
            position: self.position.point(0.0),
            look_at: Some(self.look_at.point(0.0)),
            up: vec3(0.0, 0.0, 1.0),
            fov_x_degrees: self.fov_x_degrees,
            ..Camera::default()
        });
        let motion = CameraMotion::Laws { position: self.position, look_at: self.look_at };
        scene.animation = Some(Animation { camera: Some(motion), ..Animation::of_frames(self.frames) });
        loader.finish(Path::new("course input"))
    }
}

impl CourseBody {
    fn body(&self, shape: Solid, diodes: bool) -> Body {
        let power = PLATO_POWER;
        Body {
            center: self.center,
            radius: self.radius,
            color: self.color,
            reflection: self.reflection,
            transparency: self.transparency,
            lights_per_edge: self.lights_per_edge,
            lighting: if diodes { BodyLighting::Diodes { power } } else { BodyLighting::Centre { power } },
            ..Body::new(shape)
        }
    }
}

impl CourseFloor {
    /// Two triangles, the picture once over both, held at its borders.
    fn add_to(&self, loader: &mut Loader, folder: &Path) -> Result<(), SceneError> {
        let texture = Texture {
            wrap_u: TextureWrap::Clamp,
            wrap_v: TextureWrap::Clamp,
            ..Texture::of_image(loader.image_beside(folder, Path::new(&self.texture))?)
        };
        let textures = MaterialTextures { color: Some(loader.texture(texture)), ..MaterialTextures::NONE };
        // Opaque: a see-through material that lets nothing through.
        let kind = MaterialKind::Transparent {
            color: self.tint,
            transparency: 0.0,
            reflection: self.reflection,
            shininess: SHININESS,
            diffuse: FACE_DIFFUSE,
        };
        let scene = &mut loader.scene;
        let material = scene.materials.len() as u32;
        scene.materials.push(Material { textures, ..Material::new("floor", kind) });
        Quadrilateral { corners: self.corners, material }.add_to(scene);
        Ok(())
    }
}
