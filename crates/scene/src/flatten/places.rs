//! Where instances are, in a frame.

use crate::error::{Problem, SceneError};
use crate::model::{MAX_COORDINATE, Move, Scene};
use eosphor_core::geometry::{Bounds, Instance, Sphere};
use eosphor_core::math::{Affine, Vec3};

/// From an object into the world, and back.
pub(super) type Maps = (Affine, Affine);

/// The maps of an instance in a frame.
pub(super) fn maps(scene: &Scene, number: usize, frame: u32) -> Result<Maps, SceneError> {
    let instance = &scene.instances[number];
    let own = instance.world_from_object.affine();
    let map = match instance.moves.is_empty() {
        true => own,
        false => {
            let moved = Move::map_of_all(instance.moves.iter().map(|motion| &**motion), scene.seconds(frame));
            moved.after(&instance.world_from_object.to_double()).affine()
        }
    };
    let inverse = map.inverse().ok_or_else(|| {
        let message = "its transform cannot be inverted: it squashes the mesh flat; no scale may be 0";
        Problem::new(name(scene, number, frame), message)
    })?;
    Ok((map, inverse))
}

/// The maps of an instance that is not baked, in a frame. Fails where its geometry, with these bounds in its own space,
/// leaves the range of coordinates.
pub(super) fn maps_of_geometry(
    scene: &Scene,
    number: usize,
    frame: u32,
    bounds: &Bounds,
) -> Result<Maps, SceneError> {
    let maps = maps(scene, number, frame)?;
    let b = bounds.transformed(&maps.0);
    if b.is_empty() || (b.min.is_finite() && b.max.is_finite() && b.extent() <= MAX_COORDINATE) {
        return Ok(maps);
    }
    let message =
        format!("its transform takes the mesh out of range: coordinates must be within {MAX_COORDINATE:e}");
    Err(Problem::new(name(scene, number, frame), message).into())
}

/// For messages.
fn name(scene: &Scene, number: usize, frame: u32) -> String {
    let instance = &scene.instances[number];
    let mesh = &scene.meshes[instance.mesh as usize].name;
    let frame = if instance.moves.is_empty() { String::new() } else { format!(" in frame {frame}") };
    format!("instances[{number}] (mesh \"{mesh}\"){frame}")
}

/// The box around these.
pub(super) fn bounds_of(triangles: &[[Vec3; 3]], spheres: &[Sphere]) -> Bounds {
    let bounds = triangles.iter().flatten().fold(Bounds::EMPTY, |bounds, &p| bounds.including(p));
    spheres.iter().fold(bounds, |bounds, s| {
        let r = Vec3::splat(s.radius);
        bounds.including(s.center - r).including(s.center + r)
    })
}

/// The box around everything that is placed, not padded. `bounds` has that of each geometry.
pub(super) fn world_bounds(bounds: &[Bounds], instances: &[Instance]) -> Bounds {
    instances.iter().fold(Bounds::EMPTY, |all, instance| {
        all.union(&bounds[instance.geometry as usize].transformed(&instance.world_from_object))
    })
}
