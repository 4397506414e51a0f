//! Flags that override the scene's camera.

use super::values::{LENGTHS, OVER_0, place, triple, within};
use super::{Need, check};
use crate::failure::Failure;
use clap::Args;
use eosphor::math::Vec3;
use eosphor::{Camera, Lens, Scene};
use std::ops::Bound;

#[derive(Clone, Debug, Args)]
#[command(
    next_help_heading = "Camera (flags override the scene's; a scene without one is framed automatically)"
)]
pub(crate) struct CameraFlags {
    /// Use this camera of a glTF file: a name, or a number from 0 [default: the first]
    #[arg(long, value_name = "NAME")]
    camera: Option<String>,
    /// Position of the camera. Together with --look-at or --direction it also takes the place of an animation of the camera
    #[arg(long, value_name = "X,Y,Z", value_parser = place, allow_hyphen_values = true)]
    eye: Option<[f64; 3]>,
    /// The point in the middle of the picture
    #[arg(long, value_name = "X,Y,Z", value_parser = place, allow_hyphen_values = true, conflicts_with = "direction")]
    look_at: Option<[f64; 3]>,
    /// The direction in which the camera looks, instead of --look-at
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true)]
    direction: Option<Vec3>,
    /// The direction that is up in the picture
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true)]
    up: Option<Vec3>,
    /// Horizontal field of view in degrees, over 0 and under 180; makes an orthographic camera a perspective one [default:
    /// the camera's]
    #[arg(long, value_name = "DEGREES", value_parser = within((Bound::Excluded(0.0), Bound::Excluded(180.0))), allow_hyphen_values = true)]
    fov: Option<f32>,
    /// Radius of the lens, 0 to 1e12; 0 is a pinhole, which keeps everything in focus
    #[arg(long, value_name = "RADIUS", value_parser = within(LENGTHS), allow_hyphen_values = true)]
    aperture: Option<f32>,
    /// Distance that is in focus, over 0 and at most 1e12 [default: that of --look-at]
    #[arg(long, value_name = "X", value_parser = within(OVER_0), allow_hyphen_values = true)]
    focus_distance: Option<f32>,
}

impl CameraFlags {
    /// The camera of the file that is taken, where one is chosen.
    pub(crate) fn choice(&self) -> Option<String> {
        self.camera.clone()
    }

    /// Overrides what was given, or what frames a scene without a camera.
    pub(crate) fn apply(&self, scene: &mut Scene) -> Result<(), Failure> {
        if !self.is_given() {
            return Ok(());
        }
        // A camera that is said as a whole stands still.
        if self.eye.is_some() && (self.look_at.is_some() || self.direction.is_some()) && scene.camera_is_led()
        {
            scene.camera = scene.camera_at(0);
            scene.animation.iter_mut().for_each(|animation| animation.camera = None);
        }
        self.check(scene)?;
        let mut camera = match scene.camera {
            Some(camera) => camera,
            None if self.is_whole() => Camera::default(),
            None => scene.framed_camera()?,
        };
        self.change(&mut camera, scene)?;
        scene.camera = Some(camera);
        scene.check_view().map_err(Failure::usage)
    }

    /// Whether nothing is left that framing the scene would say.
    fn is_whole(&self) -> bool {
        self.eye.is_some() && (self.look_at.is_some() || self.direction.is_some()) && self.fov.is_some()
    }

    fn is_given(&self) -> bool {
        let places = [self.eye, self.look_at];
        let vectors = [self.direction, self.up];
        let numbers = [self.fov, self.aperture, self.focus_distance];
        places.iter().any(Option::is_some)
            || vectors.iter().any(Option::is_some)
            || numbers.iter().any(Option::is_some)
    }

    /// Fails where one of these would do nothing in this scene.
    fn check(&self, scene: &Scene) -> Result<(), Failure> {
        let need = |flag, is_given| Need {
            flag,
            is_given,
            is_met: !scene.camera_is_led(),
            needs: "a camera that stands still or orbits (--orbit): the scene's animation moves this one; --eye together with \
                    --look-at or --direction takes its place",
        };
        check(&[
            need("--eye", self.eye.is_some()),
            need("--look-at", self.look_at.is_some()),
            need("--direction", self.direction.is_some()),
        ])
    }

    fn change(&self, camera: &mut Camera, scene: &Scene) -> Result<(), Failure> {
        // Flags have coordinates of the file.
        let of_file = |place: Option<[f64; 3]>| place.map(|p| scene.point_of_file(p));
        camera.position = of_file(self.eye).unwrap_or(camera.position);
        if let Some(direction) = self.direction {
            (camera.direction, camera.look_at) = (direction, None);
        }
        camera.look_at = of_file(self.look_at).or(camera.look_at);
        camera.up = self.up.unwrap_or(camera.up);
        if let Some(fov) = self.fov {
            camera.fov_x_degrees = fov;
            (camera.fov_y_degrees, camera.orthographic_height) = (None, None);
        }
        let before = camera.lens;
        let aperture_radius = self.aperture.or(before.map(|lens| lens.aperture_radius));
        let focus_distance = self.focus_distance.or(before.and_then(|lens| lens.focus_distance));
        camera.lens = match aperture_radius {
            Some(0.0) => None,
            Some(aperture_radius) => Some(Lens { aperture_radius, focus_distance }),
            None if self.focus_distance.is_some() => {
                return Err(Failure::Usage("--focus-distance needs a lens: add --aperture RADIUS".into()));
            }
            None => None,
        };
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;
    use eosphor::{LoadOptions, load};

    #[derive(Parser)]
    struct Flags {
        #[command(flatten)]
        camera: CameraFlags,
    }

    #[test]
    fn a_whole_camera_takes_the_place_of_one_that_moves() {
        let scene = || load("builtin:solids", &LoadOptions::default()).unwrap().scene;
        assert!(scene().camera_is_led());
        for alone in ["--eye=1,2,3", "--look-at=1,2,3", "--direction=0,1,0"] {
            let failure = Flags::parse_from(["", alone]).camera.apply(&mut scene()).unwrap_err();
            assert!(failure.line().unwrap().contains("takes its place"));
        }
        for aim in ["--look-at=0,0,1", "--direction=-1,-2,-2"] {
            let mut fixed = scene();
            Flags::parse_from(["", "--eye=1,2,3", aim]).camera.apply(&mut fixed).unwrap();
            assert!(!fixed.camera_is_led());
            let (first, last) = (fixed.camera_at(0).unwrap(), fixed.camera_at(50).unwrap());
            assert_eq!(first, last);
            assert_eq!(first.position, fixed.point_of_file([1.0, 2.0, 3.0]));
            // What the flags do not say is that of the first frame.
            assert_eq!(first.fov_x_degrees, scene().camera_at(0).unwrap().fov_x_degrees);
        }
    }
}
