//! The camera of a scene without one, as a value, and cameras that go around a scene.

use super::framing::{Motion, Surfaces};
use super::{SceneData, camera, geometry, places};
use crate::error::SceneError;
use crate::model::{Animation, Camera, CameraMotion, Scene};
use eosphor_core::geometry::Bounds;
use eosphor_core::math::Vec3;

impl Scene {
    /// The camera that flattening gives a scene without one: it shows what is there. Where there is nothing, or the scene has a
    /// camera of its own, it is the default one.
    ///
    /// # Errors
    ///
    /// As of [`SceneData::flatten`].
    pub fn framed_camera(&self) -> Result<Camera, SceneError> {
        self.validate()?;
        if self.camera_at(self.frame).is_some() {
            return Ok(Camera::default());
        }
        let flat = geometry::build(self, self.frame)?;
        if places::world_bounds(&flat.bounds, &flat.instances).is_empty() {
            return Ok(Camera::default());
        }
        Ok(camera::framed(self, &flat)?.camera)
    }

    /// Makes a turntable of a scene: in so many frames the camera goes once around the point that it looks at, or, where it
    /// looks at nothing in particular, around the middle of the scene. What else moves goes on moving, for so many frames.
    ///
    /// # Errors
    ///
    /// As of [`Scene::settle_orbit`].
    pub fn turntable(&mut self, frames: u32) -> Result<(), SceneError> {
        self.orbit_camera(frames);
        self.settle_orbit()
    }

    /// The first half of [`Scene::turntable`], for who has more to change before the camera is settled: an orbit around
    /// whatever the camera will look at.
    pub fn orbit_camera(&mut self, frames: u32) {
        let orbit = CameraMotion::Orbit { turns: 1.0, around: None };
        let animation = self.animation.get_or_insert(Animation::of_frames(frames));
        (animation.frames, animation.camera) = (frames, Some(orbit));
    }

    /// The second half of [`Scene::turntable`]: an orbit around nothing in particular, of a camera that looks at nothing in
    /// particular, goes around the middle of the scene. Other scenes stay as they are.
    ///
    /// # Errors
    ///
    /// As of [`SceneData::flatten`]; nothing has changed then.
    pub fn settle_orbit(&mut self) -> Result<(), SceneError> {
        let is_open = |motion: &mut CameraMotion| matches!(motion, CameraMotion::Orbit { around: None, .. });
        if self.camera.is_some_and(|camera| camera.look_at.is_some()) {
            return Ok(());
        }
        let Some(animation) = &mut self.animation else { return Ok(()) };
        let Some(mut orbit) = animation.camera.take_if(is_open) else { return Ok(()) };
        let framed = self.middle_and_camera();
        if let (Ok((middle, _)), CameraMotion::Orbit { around, .. }) = (&framed, &mut orbit) {
            *around = Some(*middle);
        }
        self.animation.iter_mut().for_each(|animation| animation.camera = Some(orbit.clone()));
        self.camera = Some(framed?.1);
        Ok(())
    }

    /// The middle of the scene over all its frames, and its camera, or one that looks there.
    fn middle_and_camera(&self) -> Result<(Vec3, Camera), SceneError> {
        let (data, _) = SceneData::flatten(self)?;
        let middle = data.world_bounds().union(&self.bounds_of_motion(&data)).center();
        let camera = match self.camera {
            Some(camera) => camera,
            None => Camera { look_at: Some(middle), ..self.framed_camera()? },
        };
        Ok((middle, camera))
    }

    /// The box around what moves, in other frames than the first.
    fn bounds_of_motion(&self, data: &SceneData) -> Bounds {
        let bounds = data.bounds_of_geometries();
        let (triangles, spheres) = (&data.triangles, &data.spheres);
        let (geometries, instances) = (&data.geometries, &data.instances);
        let surfaces = Surfaces { triangles, spheres, geometries, instances, bounds: &bounds };
        Motion::new(self, &surfaces, data.first_deforming()).bounds()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{LoadOptions, load};

    #[test]
    fn a_turntable_goes_around_the_middle() {
        let mut scene = load("builtin:cornell", &LoadOptions::default()).unwrap().scene;
        scene.camera = None;
        let framed = scene.framed_camera().unwrap();
        scene.turntable(8).unwrap();
        let (data, _) = SceneData::flatten(&scene).unwrap();
        let middle = data.world_bounds().center();
        assert_eq!(scene.camera, Some(Camera { look_at: Some(middle), ..framed }));
        let Some(Animation { frames: 8, camera: Some(CameraMotion::Orbit { around, .. }), .. }) =
            scene.animation
        else {
            panic!("an orbit of eight frames");
        };
        assert_eq!(around, Some(middle));
        // One that is settled stays.
        let before = scene.camera;
        scene.settle_orbit().unwrap();
        assert_eq!(scene.camera, before);
    }
}
