//! A scene in frames in which the vertices of some meshes are elsewhere: its arrays and the hierarchy over them.

use crate::scene_hierarchy::does_not_hold_together;
use crate::{BackendError, Hierarchy, HierarchyOptions};
use eosphor_accel::{RefitError, SceneGeometry};
use eosphor_core::geometry::Instance;
use eosphor_core::math::Affine;
use eosphor_scene::{FrameState, Places, SceneData, ShapedArrays, Shapes};
use std::sync::{Arc, Mutex, PoisonError};

/// Makes [`ShapedScene`]s over a prepared scene. As many are kept as frames have been rendered at the same time, so that of one
/// frame after the other only what moves is written and built.
#[derive(Debug)]
pub struct ShapedScenes {
    scene: Arc<SceneData>,
    hierarchy: Arc<Hierarchy>,
    options: HierarchyOptions,
    kept: Mutex<Vec<Arc<ShapedScene>>>,
}

/// A scene in a frame.
#[derive(Clone, Debug)]
pub struct ShapedScene {
    /// The arrays that differ.
    pub arrays: ShapedArrays,
    /// Over everything, and over the instances where they are in the frame.
    pub hierarchy: Hierarchy,
    places: Places,
}

impl ShapedScenes {
    /// Over a scene and the hierarchy that was built over it with these options.
    pub fn new(scene: Arc<SceneData>, hierarchy: Arc<Hierarchy>, options: HierarchyOptions) -> ShapedScenes {
        ShapedScenes { scene, hierarchy, options, kept: Mutex::default() }
    }

    /// The scene in a frame; `None` where no vertex is elsewhere. Trees of meshes whose vertices move are built anew, on the
    /// threads of the current rayon pool, and all others stay.
    ///
    /// # Errors
    /// [`BackendError::Failed`] where the shapes are not of this scene, or out of range.
    pub fn of_frame(&self, state: Option<&FrameState>) -> Result<Option<Arc<ShapedScene>>, BackendError> {
        let Some((shapes, places)) = state.and_then(|s| s.shapes.as_ref().zip(s.places.as_ref())) else {
            return Ok(None);
        };
        let before = {
            let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some(same) = kept.iter().find(|scene| scene.is_of(shapes, places)) {
                return Ok(Some(Arc::clone(same)));
            }
            // One that nobody else has: it is not given out while it is not in the list.
            let idle = kept.iter().position(|scene| Arc::strong_count(scene) == 1);
            idle.map(|number| kept.swap_remove(number))
        };
        let before = before.and_then(|scene| Arc::try_unwrap(scene).ok());
        let mut scene = before.unwrap_or_else(|| ShapedScene {
            arrays: ShapedArrays::new(&self.scene),
            hierarchy: Hierarchy::clone(&self.hierarchy),
            places: Places { instances: self.scene.instances.clone() },
        });
        scene.take(shapes, places, self)?;
        let scene = Arc::new(scene);
        self.kept.lock().unwrap_or_else(PoisonError::into_inner).push(Arc::clone(&scene));
        Ok(Some(scene))
    }
}

impl ShapedScene {
    fn is_of(&self, shapes: &Shapes, places: &Places) -> bool {
        let same = self.places.instances.iter().flat_map(words).eq(places.instances.iter().flat_map(words));
        same && self.arrays.has(shapes)
    }

    fn take(&mut self, shapes: &Shapes, places: &Places, of: &ShapedScenes) -> Result<(), BackendError> {
        let ShapedScenes { scene, options, .. } = of;
        self.arrays.take(shapes, scene).map_err(|problem| does_not_hold_together(&problem))?;
        self.places.clone_from(places);
        let view = self.arrays.view(scene);
        let geometry = SceneGeometry::new(view.triangles, view.spheres, view.geometries, &places.instances);
        let geometry = geometry.map_err(|error| does_not_hold_together(&error))?;
        let rebuilt = self.hierarchy.rebuild_from(scene.first_deforming(), &geometry, options);
        rebuilt.map_err(|error: RefitError| does_not_hold_together(&error))
    }
}

/// All that an instance says, bit for bit.
fn words(instance: &Instance) -> impl Iterator<Item = u32> {
    let Instance { object_from_world, world_from_object, world_bounds, geometry, material, object } =
        *instance;
    let vectors = |map: Affine| map.columns.into_iter().chain([map.translation]);
    let all = vectors(object_from_world).chain(vectors(world_from_object));
    let all = all.chain([world_bounds.min, world_bounds.max]);
    all.flat_map(|v| <[f32; 3]>::from(v).map(f32::to_bits)).chain([geometry, material, object])
}
