//! A scene on a device.

use crate::device::Device;
use crate::launch_buffers::{BANDS, LaunchBuffers};
use crate::memory::{Needs, upload};
use crate::parameters::{Parameters, Part};
use crate::structure::{Structure, add_structure};
use crate::top_level::{Taken, TopLevel};
use cudarc::driver::{CudaFunction, CudaSlice, DriverError};
use eosphor_core::camera::Camera;
use eosphor_core::geometry::Instance;
use eosphor_core::hierarchy::PrimitivesView;
use eosphor_core::light::Light;
use eosphor_core::settings::Settings;
use eosphor_core::view::SceneView;
use eosphor_render::BackendError;
use eosphor_scene::Moment;
use std::sync::{Mutex, PoisonError};

/// A scene on a device: its arrays, and the kernel that renders it.
pub(crate) struct DeviceScene {
    pub(crate) kernel: CudaFunction,
    /// What a kernel takes before the parameters of a launch.
    parameters: Vec<u64>,
    /// Where those begin that frames have of their own.
    parts: Vec<(Part, usize)>,
    top_level: TopLevel,
    /// Pixels of a row.
    pub(crate) width: u32,
    /// For launches: as many as frames have been rendered at the same time.
    rooms: Mutex<Vec<LaunchBuffers>>,
    /// Where the arrays are; kept for as long as the parameters name them.
    _memory: CudaSlice<u8>,
}

impl DeviceScene {
    /// Copies a scene and the structure over it to a device, where this kernel renders it, if there is room for them and for
    /// bands of `band_bytes`. `moving` is the number of instances where they move.
    ///
    /// # Errors
    ///
    /// [`BackendError::OutOfMemory`] with the numbers where there is not.
    pub(crate) fn upload(
        device: &Device,
        (kernel, block_size): (&'static str, u32),
        view: &SceneView,
        structure: &Structure,
        moving: usize,
        band_bytes: u64,
    ) -> Result<DeviceScene, BackendError> {
        let parameters = scene_parameters(view, structure)?;
        let kernel = device.kernel(kernel, block_size)?;
        let doing = "copying the scene";
        let fail = |error| device.failure(doing, error);
        Needs {
            scene: parameters.bytes(),
            film: band_bytes * BANDS,
            stacks: device.stack_bytes(&kernel).map_err(fail)?,
        }
        .check(device.free_bytes().map_err(fail)?, &device.name)?;
        let (memory, base) = upload(&device.stream, &parameters).map_err(fail)?;
        let top_level = TopLevel::new(structure.accel(), structure.trees.as_ref(), moving);
        let (parameters, parts) = (parameters.values(base), parameters.parts().to_vec());
        let (width, rooms) = (view.settings.width, Mutex::default());
        Ok(DeviceScene { kernel, parameters, parts, top_level, width, rooms, _memory: memory })
    }

    /// Room for launches of bands of at most so many bytes, which must be given back.
    pub(crate) fn take_room(&self, device: &Device, band_bytes: usize) -> Result<LaunchBuffers, DriverError> {
        let used = self.rooms.lock().unwrap_or_else(PoisonError::into_inner).pop();
        used.map_or_else(|| LaunchBuffers::new(device, band_bytes), Ok)
    }

    /// For whoever needs it next.
    pub(crate) fn give_back(&self, room: LaunchBuffers) {
        self.rooms.lock().unwrap_or_else(PoisonError::into_inner).push(room);
    }

    /// What a kernel takes for a frame before the parameters of a launch.
    pub(crate) fn at(
        &self,
        device: &Device,
        moment: Option<&Moment>,
    ) -> Result<FrameParameters<'_>, DriverError> {
        let mut values = self.parameters.clone();
        let Some(Moment { camera, lights, settings, places }) = moment else {
            return Ok(FrameParameters { values, _memory: None, _room: None });
        };
        let top = places.as_ref().map(|places| self.top_level.build(&places.instances));
        let mut own = Parameters::default();
        add_moment(&mut own, lights, camera, settings);
        let mut room = None;
        if let (Some(places), Some(top)) = (places, &top) {
            add_instances(&mut own, &places.instances);
            // The array that trees are in comes first of all.
            room = self.top_level.add(&mut own, top, &device.stream, values[0])?;
        }
        let (memory, base) = upload(&device.stream, &own)?;
        own.replace_parts(base, &self.parts, &mut values);
        Ok(FrameParameters { values, _memory: Some(memory), _room: room })
    }
}

/// What a kernel takes for a frame.
pub(crate) struct FrameParameters<'a> {
    pub(crate) values: Vec<u64>,
    /// Where the frame's own arrays are; kept for as long as the parameters name them.
    _memory: Option<CudaSlice<u8>>,
    _room: Option<Taken<'a>>,
}

/// All parameters of a kernel but those of a launch, in the order of `gpu/src/kernels.rs`.
pub(crate) fn scene_parameters<'a>(
    view: &SceneView<'a>,
    structure: &'a Structure,
) -> Result<Parameters<'a>, BackendError> {
    let mut parameters = Parameters::default();
    let primitives = add_structure(&mut parameters, structure)?;
    add_primitives(&mut parameters, view, &primitives);
    add_shading(&mut parameters, view);
    Ok(parameters)
}

/// What is hit: primitives in the structure's order, then in the scene's.
fn add_primitives<'a>(parameters: &mut Parameters<'a>, view: &SceneView<'a>, packed: &PrimitivesView<'a>) {
    // Shading reads the geometries too, so they are the scene's; a structure's own copies are for tracing alone.
    add_packed(
        parameters,
        &PrimitivesView { geometries: view.geometries, instances: view.instances, ..*packed },
    );
    parameters.array(view.triangles);
    parameters.array(view.spheres);
}

/// What rays meet: primitives in the structure's order, and where they are placed.
pub(crate) fn add_packed<'a>(parameters: &mut Parameters<'a>, packed: &PrimitivesView<'a>) {
    parameters.array(packed.triangles);
    parameters.array(packed.spheres);
    parameters.array(packed.sphere_primitives);
    parameters.array(packed.geometries);
    add_instances(parameters, packed.instances);
}

fn add_instances<'a>(parameters: &mut Parameters<'a>, instances: &'a [Instance]) {
    parameters.begin(Part::Instances);
    parameters.array(instances);
    parameters.count(instances.len());
}

/// What hits look like.
fn add_shading<'a>(parameters: &mut Parameters<'a>, view: &SceneView<'a>) {
    parameters.array(view.triangle_shading);
    parameters.array(view.triangle_extras);
    parameters.array(view.sphere_materials);
    parameters.array(view.materials);
    parameters.array(view.textures.textures);
    parameters.count(view.textures.textures.len());
    parameters.array(view.textures.words);
    parameters.count(view.textures.words.len());
    parameters.array(view.textures.srgb_decode);
    add_moment(parameters, view.lights, view.camera, view.settings);
}

/// What differs from frame to frame.
fn add_moment<'a>(
    parameters: &mut Parameters<'a>,
    lights: &'a [Light],
    camera: &'a Camera,
    settings: &'a Settings,
) {
    parameters.begin(Part::Moment);
    parameters.array(lights);
    parameters.count(lights.len());
    parameters.array(std::slice::from_ref(camera));
    parameters.array(std::slice::from_ref(settings));
}
