//! A scene on a device, and launches over it.

use crate::device::Device;
use crate::memory::{DeviceArray, allocate, download, upload};
use crate::ptx::BLOCK;
use cudarc::driver::{CudaStream, DriverError, LaunchConfig, PushKernelArg};
use eosphor_accel::{Bvh, PackedPrimitives};
use eosphor_core::camera::Camera;
use eosphor_core::geometry::{Geometry, Instance, Sphere, TriangleExtra, TriangleShading};
use eosphor_core::hierarchy::BvhNode;
use eosphor_core::intersect::PackedTriangle;
use eosphor_core::light::Light;
use eosphor_core::material::Material;
use eosphor_core::math::Vec3;
use eosphor_core::settings::Settings;
use eosphor_core::texture::Texture;
use eosphor_core::view::SceneView;
use eosphor_render::RayStatistics;
use std::sync::Arc;

/// Arguments that `render_bvh` takes before the common ones.
#[cfg(test)]
pub(crate) const BVH_ARGUMENTS: usize = 4;

/// Arguments that both kernels take.
#[cfg(test)]
pub(crate) const COMMON_ARGUMENTS: usize = 26;

/// A BVH on a device, but its primitives.
struct DeviceBvh {
    nodes: DeviceArray<BvhNode>,
    roots: DeviceArray<u32>,
    instance_order: DeviceArray<u32>,
    instance_root: u32,
}

/// A scene on a device: the arrays of core's views.
pub(crate) struct DeviceScene {
    bvh: Option<DeviceBvh>,
    packed_triangles: DeviceArray<PackedTriangle>,
    packed_spheres: DeviceArray<Sphere>,
    sphere_primitives: DeviceArray<u32>,
    geometries: DeviceArray<Geometry>,
    instances: DeviceArray<Instance>,
    instance_count: u64,
    triangles: DeviceArray<[Vec3; 3]>,
    spheres: DeviceArray<Sphere>,
    triangle_shading: DeviceArray<TriangleShading>,
    triangle_extras: DeviceArray<TriangleExtra>,
    sphere_materials: DeviceArray<u32>,
    materials: DeviceArray<Material>,
    textures: DeviceArray<Texture>,
    texture_count: u64,
    texture_words: DeviceArray<u32>,
    texture_word_count: u64,
    srgb_decode: DeviceArray<f32>,
    lights: DeviceArray<Light>,
    light_count: u64,
    camera: DeviceArray<Camera>,
    settings: DeviceArray<Settings>,
    extent: f32,
    width: u32,
}

impl DeviceScene {
    /// Copies a scene to a device, with its primitives in the order of the hierarchy, where there is one.
    pub(crate) fn upload(
        stream: &Arc<CudaStream>,
        view: &SceneView,
        bvh: Option<&Bvh>,
        primitives: &PackedPrimitives,
    ) -> Result<DeviceScene, DriverError> {
        let bvh = match bvh {
            None => None,
            Some(bvh) => Some(DeviceBvh {
                nodes: upload(stream, &bvh.nodes)?,
                roots: upload(stream, &bvh.roots)?,
                instance_order: upload(stream, &bvh.instance_order)?,
                instance_root: bvh.instance_root,
            }),
        };
        Ok(DeviceScene {
            bvh,
            packed_triangles: upload(stream, &primitives.triangles)?,
            packed_spheres: upload(stream, &primitives.spheres)?,
            sphere_primitives: upload(stream, &primitives.sphere_primitives)?,
            geometries: upload(stream, view.geometries)?,
            instances: upload(stream, view.instances)?,
            instance_count: view.instances.len() as u64,
            triangles: upload(stream, view.triangles)?,
            spheres: upload(stream, view.spheres)?,
            triangle_shading: upload(stream, view.triangle_shading)?,
            triangle_extras: upload(stream, view.triangle_extras)?,
            sphere_materials: upload(stream, view.sphere_materials)?,
            materials: upload(stream, view.materials)?,
            textures: upload(stream, view.textures.textures)?,
            texture_count: view.textures.textures.len() as u64,
            texture_words: upload(stream, view.textures.words)?,
            texture_word_count: view.textures.words.len() as u64,
            srgb_decode: upload(stream, view.textures.srgb_decode)?,
            lights: upload(stream, view.lights)?,
            light_count: view.lights.len() as u64,
            camera: upload(stream, std::slice::from_ref(view.camera))?,
            settings: upload(stream, std::slice::from_ref(view.settings))?,
            extent: view.extent,
            width: view.settings.width,
        })
    }

    /// Renders rows from `first_row` on, as many as `colors` has room for, and waits for them.
    pub(crate) fn render_rows(
        &self,
        device: &Device,
        first_row: u32,
        colors: &mut [Vec3],
    ) -> Result<RayStatistics, DriverError> {
        let stream = &device.stream;
        let end_row = first_row + (colors.len() / self.width as usize) as u32;
        let film = allocate::<Vec3>(stream, colors.len())?;
        let totals = stream.alloc_zeros::<u64>(5)?;
        let kernel = if self.bvh.is_some() { &device.render_bvh } else { &device.render_exhaustive };
        let mut launch = stream.launch_builder(kernel);
        // The order is that of `gpu/src/lib.rs`.
        if let Some(bvh) = &self.bvh {
            launch.arg(&bvh.nodes).arg(&bvh.roots).arg(&bvh.instance_order).arg(&bvh.instance_root);
        }
        launch.arg(&self.packed_triangles).arg(&self.packed_spheres).arg(&self.sphere_primitives);
        launch.arg(&self.geometries).arg(&self.instances).arg(&self.instance_count);
        launch.arg(&self.triangles).arg(&self.spheres).arg(&self.triangle_shading);
        launch.arg(&self.triangle_extras).arg(&self.sphere_materials).arg(&self.materials);
        launch.arg(&self.textures).arg(&self.texture_count);
        launch.arg(&self.texture_words).arg(&self.texture_word_count).arg(&self.srgb_decode);
        launch.arg(&self.lights).arg(&self.light_count);
        launch.arg(&self.camera).arg(&self.settings).arg(&self.extent);
        launch.arg(&first_row).arg(&end_row).arg(&film).arg(&totals);
        let shape = launch_shape(self.width, end_row - first_row);
        // SAFETY: the arguments are those of the kernel, in its order; the arrays are those of a SceneData and a
        // hierarchy over it, whose indices are in range; the film has room for the rows.
        unsafe { launch.launch(shape) }?;
        stream.synchronize()?;
        download(stream, &film, colors)?;
        let totals = stream.clone_dtoh(&totals)?;
        stream.synchronize()?;
        Ok(RayStatistics {
            camera: totals[0],
            reflected: totals[1],
            refracted: totals[2],
            glossy: totals[3],
            shadow: totals[4],
            ..RayStatistics::default()
        })
    }
}

/// Rows that a warp covers: 8 × 4 pixels.
pub(crate) const WARP_ROWS: u32 = 4;

/// Enough blocks for 8 × 4 pixels a warp.
fn launch_shape(width: u32, rows: u32) -> LaunchConfig {
    let warps = width.div_ceil(8) * rows.div_ceil(WARP_ROWS);
    LaunchConfig {
        grid_dim: (warps.div_ceil(BLOCK / 32), 1, 1),
        block_dim: (BLOCK, 1, 1),
        shared_mem_bytes: 0,
    }
}
