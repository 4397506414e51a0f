//! [`CourseInput`] → a scene.

use super::{CourseBody, CourseFloor, CourseInput, CourseOptions};
use crate::error::{Place, SceneError};
use crate::files::loader::Loader;
use crate::files::source::Source;
use crate::files::{LoadOptions, LoadedScene};
use crate::model::{
    Animation, Camera, CameraMotion, Instance, Light, Material, MaterialKind, MaterialTextures, Mesh,
    NO_INDEX, Parallelogram, PixelSampling, RenderSettings, Texture, Transform, Triangle,
};
use crate::presets::course_settings;
use crate::solids::{Body, BodyLighting, FACE_DIFFUSE, PARQUET, PLATO_POWER, SHININESS, Solid, parquet};
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
        let mut loader = Loader::new(source, &LoadOptions::default());
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
            ..Texture::of_image(self.image(loader, folder)?)
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
        let [a, b, c, d] = self.corners;
        let (u, v) = (d - a, b - a);
        if b + u == c {
            scene.parallelograms.push(Parallelogram { corner: a, edge_u: u, edge_v: v, material });
            return Ok(());
        }
        let triangle = |corners: [u32; 3]| Triangle {
            positions: corners,
            normals: [NO_INDEX; 3],
            uvs: corners,
            material,
        };
        scene.meshes.push(Mesh {
            name: "floor".into(),
            positions: self.corners.to_vec(),
            uvs: vec![[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]],
            triangles: vec![triangle([0, 3, 2]), triangle([0, 2, 1])],
            ..Mesh::default()
        });
        scene.instances.push(Instance::new(scene.meshes.len() as u32 - 1, Transform::default()));
        Ok(())
    }

    /// The number of its picture.
    fn image(&self, loader: &mut Loader, folder: &Path) -> Result<u32, SceneError> {
        match self.texture.strip_prefix("builtin:") {
            None => loader.image(&folder.join(&self.texture)),
            Some(_) if self.texture == PARQUET => {
                loader.scene.images.push(parquet());
                Ok(loader.scene.images.len() as u32 - 1)
            }
            Some(name) => {
                let message = format!("there is no built-in texture \"{name}\"; there is parquet");
                Err(SceneError::invalid(Place::file(Path::new(&self.texture)), message))
            }
        }
    }
}
