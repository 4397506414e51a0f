//! In which order a device traces the rays of a picture.

use crate::ray_count::shadow_rays;
use eosphor_core::material::{Material, Refraction, SurfaceModel};
use eosphor_core::view::SceneView;

/// In which order a device traces the rays of a picture. No pixel depends on it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GpuScheduler {
    /// Whichever was faster where scenes of that kind were measured.
    #[default]
    Auto,
    /// One kernel, whose threads follow a sample with all that comes of it: for Whitted's integrator and a bounding volume
    /// hierarchy.
    Megakernel,
    /// Kernels for each stage, which work on queues of rays.
    Queues,
    /// The same, where shadow rays of Whitted's integrator have a queue of their own too.
    ShadowQueues,
}

impl GpuScheduler {
    /// All there are.
    pub const ALL: [GpuScheduler; 4] =
        [GpuScheduler::Auto, GpuScheduler::Megakernel, GpuScheduler::Queues, GpuScheduler::ShadowQueues];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            GpuScheduler::Auto => "auto",
            GpuScheduler::Megakernel => "megakernel",
            GpuScheduler::Queues => "queues",
            GpuScheduler::ShadowQueues => "shadow-queues",
        }
    }

    /// Whether it works on queues alone.
    pub fn is_queued(self) -> bool {
        matches!(self, GpuScheduler::Queues | GpuScheduler::ShadowQueues)
    }

    /// The one that a scene gets. [`GpuScheduler::Auto`] becomes queues where these are faster; else it stays, for the megakernel
    /// where there is one.
    ///
    /// By measurement (docs/gpu-speed.md) queues pay where rays of one surface part in many ways: threads of a warp then have
    /// different things to do. Where nearly all rays go to lights, they do not.
    pub(crate) fn of_scene(self, view: &SceneView) -> GpuScheduler {
        match self {
            GpuScheduler::Auto
                if shadow_rays(view) <= MANY_SHADOW_RAYS && view.materials.iter().any(parts_rays) =>
            {
                GpuScheduler::Queues
            }
            chosen => chosen,
        }
    }
}

/// With more shadow rays a point time goes into light: PG1's boxes, of 100, are slower by queues. Of 64, `scenes/materials.json` is
/// three times as fast; between the two nothing was measured.
const MANY_SHADOW_RAYS: f64 = 64.0;

/// Whether rays part at a surface of this material: at glass, and where several of a lobe are traced.
fn parts_rays(material: &Material) -> bool {
    let transmits = material.transmission.max_component() > 0.0;
    match material.model {
        SurfaceModel::MetallicRoughness => transmits || material.metallic > 0.0,
        SurfaceModel::Composed => {
            material.glossy_rays > 1 || transmits && material.refraction == Refraction::Snell
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eosphor_scene::{LoadOptions, SceneData, load};

    #[test]
    fn queues_are_for_scenes_whose_rays_part() {
        let chosen = |scene: &str, scheduler: GpuScheduler| {
            let scene = load(scene, &LoadOptions::default()).unwrap().scene;
            scheduler.of_scene(&SceneData::flatten(&scene).unwrap().0.view())
        };
        let scenes = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes");
        let auto = |scene: &str| chosen(scene, GpuScheduler::Auto);
        for scene in ["builtin:glass", &format!("{scenes}/glass-and-mirrors.json")] {
            assert_eq!(auto(scene), GpuScheduler::Queues, "{scene}");
        }
        for scene in ["builtin:cornell-pg1", "builtin:solids", &format!("{scenes}/coloured-shadows.json")] {
            assert_eq!(auto(scene), GpuScheduler::Auto, "{scene}");
        }
        for scheduler in [GpuScheduler::Megakernel, GpuScheduler::Queues, GpuScheduler::ShadowQueues] {
            assert_eq!(chosen("builtin:glass", scheduler), scheduler);
        }
    }
}
