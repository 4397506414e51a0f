//! A scene on a device.

use crate::develop_launch;
use crate::device::{Device, Kernel};
use crate::launch_buffers::{BANDS, LaunchBuffers};
use crate::launch_rooms::{LaunchRooms, TakenRoom};
use crate::light_room::PointRays;
use crate::memory::{Needs, upload};
use crate::parameters::Parameters;
use crate::queue_launch::{FrameKind, QueueKernels, ShadeKernel, SharedNames};
use crate::queue_room::{QueueSize, Queued};
use crate::ray_count::many_rays_share_lights;
use crate::stages::Stage;
use crate::structure::{KernelNames, Structure, WalkNames, add_structure};
use crate::top_level::{Taken, TopLevel};
use crate::traversal::Traversal;
use cudarc::driver::{CudaSlice, DriverError};
use eosphor_core::hierarchy::PrimitivesView;
use eosphor_core::integrator::whitted::light_rays_of_point;
use eosphor_core::light::{Light, LightNode};
use eosphor_core::material::Material;
use eosphor_core::settings::{Settings, ShadowMode};
use eosphor_core::view::{SceneArray, SceneCounts, SceneItem, SceneView, SceneVisitor};
use eosphor_render::{BackendError, ShapedScene};
use eosphor_scene::{FrameState, SceneData};
use std::slice;

/// The kernels that render a scene.
pub(crate) enum Kernels {
    /// One, whose threads follow samples from the camera to the end.
    Whole(Kernel),
    /// Those that work on queues.
    Queues(Box<QueueKernels>),
}

/// A scene on a device: its arrays, and the kernels that render it.
pub(crate) struct DeviceScene {
    pub(crate) kernels: Kernels,
    /// What a kernel takes before the launch.
    parameters: Vec<u64>,
    /// Their names.
    names: Vec<&'static str>,
    /// How many of them are the structure's. Those of the scene's arrays follow.
    pub(crate) structure_values: usize,
    /// How many items the scene's arrays have.
    counts: SceneCounts,
    /// Of the rays in queues.
    kind: FrameKind,
    block_size: u32,
    /// Of queues, where kernels work on them.
    queue: Option<QueueSize>,
    top_level: TopLevel,
    /// For launches: as many as frames are rendered at the same time.
    rooms: LaunchRooms<LaunchBuffers>,
    /// Where the arrays are; kept for as long as the parameters name them.
    _memory: CudaSlice<u8>,
}

impl Kernels {
    /// Loads them, for blocks of so many threads. Also says what the driver sets aside for stacks: at most one kernel's at a time.
    fn load(
        device: &Device,
        names: KernelNames,
        block_size: u32,
        view: &SceneView,
    ) -> Result<(Kernels, u64), BackendError> {
        let fail = |error| device.failure("loading the kernels", error);
        let WalkNames { hits, seen, crossed } = match names {
            KernelNames::Whole(name) => {
                let kernel = device.kernel(name, block_size)?;
                let stacks = device.stack_bytes(&kernel).map_err(fail)?;
                return Ok((Kernels::Whole(kernel), stacks));
            }
            KernelNames::Queues(names) => names,
        };
        let of = Queued::of(view.settings);
        let is_coloured = view.settings.shadow_mode == ShadowMode::Coloured;
        let SharedNames { prepare, begin, generate, shading, lighting, settle } = SharedNames::of(of);
        let lists_ends = of == Queued::Trees && view.materials.iter().any(Material::ends_rays);
        let shading = match of {
            Queued::Paths => shading,
            // Those that the scene has something for.
            Queued::Trees if view.materials.iter().all(Material::ends_rays) && lists_ends => &shading[..1],
            Queued::Trees if lists_ends => shading,
            Queued::Trees => &shading[1..],
        };
        // Those that take long apart, side by side; so those that structures share are compiled once. Bytes may be asked for later.
        let small = [begin, generate, settle, develop_launch::KERNEL];
        let groups =
            shading.iter().chain([&hits, &seen]).chain(is_coloured.then_some(&crossed)).map(slice::from_ref);
        let groups = groups
            .chain([&small[..]])
            .chain(lighting.as_ref().map(|names| &names[..]))
            .chain(prepare.as_ref().map(slice::from_ref));
        device.load(&groups.collect::<Vec<_>>(), block_size)?;
        let kernel = |name| device.kernel(name, block_size);
        let shading = shading.iter().map(|name| kernel(name)).collect::<Result<Vec<_>, _>>()?;
        let [find_hits, see_lights] = device.kernels([hits, seen], block_size)?;
        let lighting = lighting.map(|names| device.kernels(names, block_size)).transpose()?;
        let crosses = is_coloured.then(|| kernel(crossed)).transpose()?;
        let mut stacks = 0;
        let traced = [&find_hits, &see_lights].into_iter().chain(&crosses);
        for kernel in shading.iter().chain(traced).chain(lighting.iter().flatten()) {
            stacks = device.stack_bytes(kernel).map_err(fail)?.max(stacks);
        }
        let first = SharedNames::of(of).shading[0];
        let shading = shading.into_iter().map(|kernel| {
            let blocks = device.blocks_at_a_time(&kernel, block_size).map_err(fail)?;
            let list = if kernel.name == first { Stage::ShadeFirst } else { Stage::ShadeLast };
            Ok(ShadeKernel { kernel, list, blocks })
        });
        let kernels = QueueKernels {
            of,
            shading: shading.collect::<Result<_, BackendError>>()?,
            prepare: prepare.map(kernel).transpose()?,
            begin: kernel(begin)?,
            generate: kernel(generate)?,
            find_hits,
            lists_ends,
            see_lights,
            crossed,
            lighting,
            settle: kernel(settle)?,
        };
        Ok((Kernels::Queues(Box::new(kernels)), stacks))
    }
}

impl DeviceScene {
    /// Copies a scene and the structure over it to a device, where these kernels render it in blocks of so many threads, by so many
    /// paths at a time ([`CudaOptions::paths`]), if there is room for them and for bands of `band_bytes`. `moving` is the
    /// number of instances where they move.
    ///
    /// # Errors
    ///
    /// [`BackendError::OutOfMemory`] with the numbers where there is not.
    pub(crate) fn upload(
        device: &Device,
        (names, block_size, paths): (KernelNames, u32, Option<u32>),
        view: &SceneView,
        structure: &Structure,
        moving: usize,
        band_bytes: u64,
    ) -> Result<DeviceScene, BackendError> {
        let parameters = scene_parameters(view, structure)?;
        let structure_values = parameters.names().len() - SceneArray::ALL.len();
        let fail = |error| device.failure("copying the scene", error);
        let (kernels, stacks) = Kernels::load(device, names, block_size, view)?;
        let free = device.free_bytes().map_err(fail)?;
        let mut needs = Needs { scene: parameters.bytes(), film: band_bytes * BANDS, stacks, queues: 0 };
        let kind = kind(device, &kernels, block_size, (view.settings, view.lights, view.light_nodes))?;
        let mut queue = None;
        if let Kernels::Queues(_) = &kernels {
            let room = free.saturating_sub(needs.all()) / BANDS;
            let light_rays = PointRays { all: kind.light_rays, share_lights: many_rays_share_lights(view) };
            let size = QueueSize::new(view.settings, band_bytes, paths, light_rays, room);
            needs.queues = size.bytes() * BANDS;
            queue = Some(size);
        }
        needs.check(free, &device.name, device.has_memory_limit())?;
        let of_frame = (needs.film + needs.queues).max(1);
        let rooms = LaunchRooms::new(1 + (free - needs.all()) / of_frame);
        let (memory, base) = upload(&device.stream, &parameters).map_err(fail)?;
        let top_level = TopLevel::new(structure.accel(), structure.trees.as_ref(), moving);
        let (parameters, names) = (parameters.values(base), parameters.names().to_vec());
        Ok(DeviceScene {
            kernels,
            parameters,
            names,
            structure_values,
            kind,
            block_size,
            counts: view.counts(),
            queue,
            top_level,
            rooms,
            _memory: memory,
        })
    }

    /// Room for launches of bands of a frame, of at most so many bytes, whose pixels take so many samples. Waits for one that other
    /// frames have where there is no memory for more.
    pub(crate) fn take_room(
        &self,
        device: &Device,
        frame: &FrameParameters,
        band_bytes: usize,
        samples: u32,
    ) -> Result<TakenRoom<'_, LaunchBuffers>, DriverError> {
        let queue = match (&self.kernels, self.queue) {
            (Kernels::Queues(_), Some(size)) => {
                let size = size.for_bands(band_bytes, samples, frame.kind.depth);
                Some(size.for_shadows(frame.kind.cross.is_some()))
            }
            _ => None,
        };
        let suits = |room: &LaunchBuffers| room.suits(band_bytes, queue);
        self.rooms.take(suits, || LaunchBuffers::new(device, band_bytes, queue))
    }

    /// What a kernel takes for a frame before the launch. `shaped` has what is the frame's own where vertices of meshes are
    /// elsewhere.
    pub(crate) fn at(
        &self,
        device: &Device,
        state: Option<&FrameState>,
        shaped: Option<&ShapedFrame<'_>>,
    ) -> Result<FrameParameters<'_>, BackendError> {
        let fail = |error| device.failure("rendering", error);
        let (mut values, mut counts) = (self.parameters.clone(), self.counts);
        // Without `..`, so that a new field does not compile before frames have their own of it.
        let Some(FrameState { camera, lights, light_nodes, light_places, settings, places, shapes: _ }) =
            state
        else {
            let kind = self.kind.clone();
            return Ok(FrameParameters { values, counts, kind, _memory: None, _room: None });
        };
        let places = places.as_ref();
        let moved = places.filter(|_| shaped.is_none());
        let top = moved.map(|places| self.top_level.build(&places.instances));
        let kind = kind(device, &self.kernels, self.block_size, (settings, lights, light_nodes))?;
        let mut own = Parameters::default();
        own.array(SceneArray::Camera.label(), std::slice::from_ref(camera));
        own.array(SceneArray::Settings.label(), std::slice::from_ref(settings));
        own.array(SceneArray::Lights.label(), lights);
        own.array(SceneArray::LightNodes.label(), light_nodes);
        own.array(SceneArray::LightPlaces.label(), light_places);
        counts.lights = lights.len() as u64;
        counts.light_nodes = light_nodes.len() as u64;
        counts.light_places = light_places.len() as u64;
        if let Some(places) = places {
            own.array(SceneArray::Instances.label(), &places.instances);
        }
        let mut room = None;
        if let Some(top) = &top {
            // The array that trees are in comes first of all.
            room = self.top_level.add(&mut own, top, &device.stream, values[0]).map_err(fail)?;
        }
        if let Some(ShapedFrame { structure, view }) = shaped {
            let primitives = add_structure(&mut own, structure)?;
            add_packed(&mut own, &primitives);
            own.array(SceneArray::Geometries.label(), view.geometries);
            own.array(SceneArray::Triangles.label(), view.triangles);
            own.array(SceneArray::TriangleShading.label(), view.triangle_shading);
            own.array(SceneArray::TriangleExtras.label(), view.triangle_extras);
        }
        let (memory, base) = upload(&device.stream, &own).map_err(fail)?;
        own.replace(base, &self.names, &mut values);
        Ok(FrameParameters { values, counts, kind, _memory: Some(memory), _room: room })
    }
}

/// A scene in a frame in which vertices of meshes are elsewhere, as devices read it.
///
/// It is copied to the device for each frame, whole: a scene with such meshes is seldom large beside them.
pub(crate) struct ShapedFrame<'a> {
    structure: Structure<'a>,
    view: SceneView<'a>,
}

impl<'a> ShapedFrame<'a> {
    /// `is_counting` says that the kernel counts.
    ///
    /// # Errors
    ///
    /// As [`Structure::new`].
    pub(crate) fn new(
        scene: &'a SceneData,
        shaped: &'a ShapedScene,
        traversal: Traversal,
        is_counting: bool,
    ) -> Result<ShapedFrame<'a>, BackendError> {
        let structure = match is_counting {
            true => Structure::for_counting(&shaped.hierarchy),
            // The tree over the instances is the frame's own already.
            false => Structure::new(&shaped.hierarchy, traversal, 0)?,
        };
        Ok(ShapedFrame { structure, view: shaped.arrays.view(scene) })
    }
}

/// What a frame with these settings and lights says of the rays in queues. A kernel that no frame before has needed is loaded.
fn kind(
    device: &Device,
    kernels: &Kernels,
    block_size: u32,
    (settings, lights, light_nodes): (&Settings, &[Light], &[LightNode]),
) -> Result<FrameKind, BackendError> {
    let cross = match kernels {
        Kernels::Queues(kernels) if settings.shadow_mode == ShadowMode::Coloured => {
            Some(device.kernel(kernels.crossed, block_size)?)
        }
        _ => None,
    };
    let light_rays = light_rays_of_point(lights, !light_nodes.is_empty(), settings);
    let has_shadows = settings.shadow_mode != ShadowMode::None;
    Ok(FrameKind { depth: settings.max_depth, light_rays, has_shadows, cross })
}

/// What a kernel takes for a frame.
pub(crate) struct FrameParameters<'a> {
    pub(crate) values: Vec<u64>,
    /// How many items the scene's arrays have.
    pub(crate) counts: SceneCounts,
    /// Of the rays in queues.
    pub(crate) kind: FrameKind,
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
