//! A scene on a device.

use crate::device::Device;
use crate::launch_buffers::{BANDS, LaunchBuffers};
use crate::memory::{Needs, upload};
use crate::parameters::Parameters;
use crate::structure::{Structure, add_structure};
use crate::top_level::{Taken, TopLevel};
use cudarc::driver::{CudaFunction, CudaSlice, DriverError};
use eosphor_core::hierarchy::PrimitivesView;
use eosphor_core::view::{SceneArray, SceneCounts, SceneItem, SceneView, SceneVisitor};
use eosphor_render::BackendError;
use eosphor_scene::FrameState;
use std::sync::{Mutex, PoisonError};

/// A scene on a device: its arrays, and the kernel that renders it.
pub(crate) struct DeviceScene {
    pub(crate) kernel: CudaFunction,
    /// What a kernel takes before the launch.
    parameters: Vec<u64>,
    /// Their names.
    names: Vec<&'static str>,
    /// How many items the scene's arrays have.
    counts: SceneCounts,
    top_level: TopLevel,
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
        let (parameters, names) = (parameters.values(base), parameters.names().to_vec());
        let (counts, rooms) = (view.counts(), Mutex::default());
        Ok(DeviceScene { kernel, parameters, names, counts, top_level, rooms, _memory: memory })
    }

    /// Room for launches of bands of at most so many bytes, which must be given back.
    pub(crate) fn take_room(&self, device: &Device, band_bytes: usize) -> Result<LaunchBuffers, DriverError> {
        let used = self.rooms.lock().unwrap_or_else(PoisonError::into_inner).pop();
        // One of a smaller frame is dropped.
        let used = used.filter(|room| room.band_bytes() >= band_bytes);
        used.map_or_else(|| LaunchBuffers::new(device, band_bytes), Ok)
    }

    /// For whoever needs it next.
    pub(crate) fn give_back(&self, room: LaunchBuffers) {
        self.rooms.lock().unwrap_or_else(PoisonError::into_inner).push(room);
    }

    /// What a kernel takes for a frame before the launch.
    pub(crate) fn at(
        &self,
        device: &Device,
        state: Option<&FrameState>,
    ) -> Result<FrameParameters<'_>, DriverError> {
        let (mut values, mut counts) = (self.parameters.clone(), self.counts);
        // Without `..`, so that a new field does not compile before frames have their own of it.
        let Some(FrameState { camera, lights, light_nodes, light_places, settings, places }) = state else {
            return Ok(FrameParameters { values, counts, _memory: None, _room: None });
        };
        let top = places.as_ref().map(|places| self.top_level.build(&places.instances));
        let mut own = Parameters::default();
        own.array(SceneArray::Camera.label(), std::slice::from_ref(camera));
        own.array(SceneArray::Settings.label(), std::slice::from_ref(settings));
        own.array(SceneArray::Lights.label(), lights);
        own.array(SceneArray::LightNodes.label(), light_nodes);
        own.array(SceneArray::LightPlaces.label(), light_places);
        counts.lights = lights.len() as u64;
        counts.light_nodes = light_nodes.len() as u64;
        counts.light_places = light_places.len() as u64;
        let mut room = None;
        if let (Some(places), Some(top)) = (places, &top) {
            own.array(SceneArray::Instances.label(), &places.instances);
            // The array that trees are in comes first of all.
            room = self.top_level.add(&mut own, top, &device.stream, values[0])?;
        }
        let (memory, base) = upload(&device.stream, &own)?;
        own.replace(base, &self.names, &mut values);
        Ok(FrameParameters { values, counts, _memory: Some(memory), _room: room })
    }
}

/// What a kernel takes for a frame.
pub(crate) struct FrameParameters<'a> {
    pub(crate) values: Vec<u64>,
    /// How many items the scene's arrays have.
    pub(crate) counts: SceneCounts,
    /// Where the frame's own arrays are; kept for as long as the parameters name them.
    _memory: Option<CudaSlice<u8>>,
    _room: Option<Taken<'a>>,
}

/// All parameters of a kernel but the launch, in the order of `gpu/src/kernels.rs`.
pub(crate) fn scene_parameters<'a>(
    view: &SceneView<'a>,
    structure: &'a Structure,
) -> Result<Parameters<'a>, BackendError> {
    let mut parameters = Parameters::default();
    let primitives = add_structure(&mut parameters, structure)?;
    add_packed(&mut parameters, &primitives);
    // Geometries and instances are the scene's, which shading reads too; a structure's own copies are for tracing on CPUs.
    view.visit(&mut parameters);
    Ok(parameters)
}

impl<'a> SceneVisitor<'a> for Parameters<'a> {
    fn array<T: SceneItem>(&mut self, array: SceneArray, items: &'a [T]) {
        Parameters::array(self, array.label(), items);
    }
}

/// Primitives in the structure's order.
pub(crate) fn add_packed<'a>(parameters: &mut Parameters<'a>, packed: &PrimitivesView<'a>) {
    parameters.array("packed_triangles", packed.triangles);
    parameters.array("packed_spheres", packed.spheres);
    parameters.array("sphere_primitives", packed.sphere_primitives);
}
