//! Builds a scene of one mesh, and traces single rays or packets.

use crate::api::{
    self, Api, Handle, NO_GEOMETRY, Packet, QueryArguments, QueryPacket, SingleHit, SingleRay, SingleRayHit,
    Valid,
};
use peer_harness::{Hit, Library, MISS, Options, Quality, Ray, Triangle};
use std::arch::asm;
use std::ffi::CString;
use std::sync::OnceLock;

struct Device {
    api: Api,
    handle: Handle,
    /// Rays of a packet that the processor traces at once, or 1.
    width: usize,
}

// SAFETY: Embree's calls that take a device are safe to make from several threads.
unsafe impl Send for Device {}
// SAFETY: calls that take a device are safe to make from several threads.
unsafe impl Sync for Device {}

impl Device {
    /// One for the process. All calls have the same options.
    fn get(options: &Options) -> Result<&'static Self, String> {
        static DEVICE: OnceLock<Result<Device, String>> = OnceLock::new();
        DEVICE.get_or_init(|| Self::new(options)).as_ref().map_err(Clone::clone)
    }

    fn new(options: &Options) -> Result<Self, String> {
        let api = Api::open()?;
        let settings =
            CString::new(format!("threads={},set_affinity=0", options.threads)).expect("has no NUL");
        // SAFETY: the text ends with NUL.
        let handle = unsafe { (api.new_device)(settings.as_ptr()) };
        if handle.is_null() {
            // SAFETY: a null device is allowed here: it asks why there is none.
            return Err(format!("Embree makes no device: its error {}", unsafe {
                (api.device_error)(handle)
            }));
        }
        // SAFETY: the device was made above.
        let has = |property| unsafe { (api.device_property)(handle, property) } != 0;
        let width = match (has(api::PROPERTY_NATIVE_RAY16), has(api::PROPERTY_NATIVE_RAY8)) {
            (true, _) => 16,
            (_, true) => 8,
            _ => 1,
        };
        Ok(Self { api, handle, width })
    }

    fn check(&self, what: &str) -> Result<(), String> {
        // SAFETY: the device lives as long as the process.
        match unsafe { (self.api.device_error)(self.handle) } {
            0 => Ok(()),
            error => Err(format!("Embree cannot {what}: its error {error}")),
        }
    }
}

/// A geometry with its vertices and indices.
pub struct Geometry {
    device: &'static Device,
    handle: Handle,
}

// SAFETY: only its owner uses it.
unsafe impl Send for Geometry {}

impl Geometry {
    fn new(mesh: &[Triangle], options: &Options) -> Result<Self, String> {
        let device = Device::get(options)?;
        let api = &device.api;
        // SAFETY: the device lives as long as the process.
        let handle = unsafe { (api.new_geometry)(device.handle, api::GEOMETRY_TRIANGLE) };
        device.check("make a geometry")?;
        let geometry = Self { device, handle };
        let corners = mesh.as_flattened();
        if corners.len() > u32::MAX as usize {
            return Err("the mesh has too many corners for indices of 32 bits".into());
        }
        // SAFETY: a buffer has room for as many elements as are asked for, and Embree pads it by itself.
        unsafe {
            let vertices =
                (api.new_buffer)(handle, api::BUFFER_VERTEX, 0, api::FORMAT_FLOAT3, 12, corners.len());
            let indices = (api.new_buffer)(handle, api::BUFFER_INDEX, 0, api::FORMAT_UINT3, 12, mesh.len());
            device.check("make buffers")?;
            vertices.cast::<[f32; 3]>().copy_from_nonoverlapping(corners.as_ptr(), corners.len());
            for index in 0..corners.len() {
                indices.cast::<u32>().add(index).write(index as u32);
            }
        }
        Ok(geometry)
    }
}

impl Drop for Geometry {
    fn drop(&mut self) {
        // SAFETY: it was made with the device, and is released once.
        unsafe { (self.device.api.release_geometry)(self.handle) }
    }
}

struct Scene {
    device: &'static Device,
    handle: Handle,
}

// SAFETY: a committed scene is only read, which Embree allows from several threads.
unsafe impl Send for Scene {}
// SAFETY: queries only read a committed scene.
unsafe impl Sync for Scene {}

impl Scene {
    fn new(geometry: &Geometry, options: &Options) -> Result<Self, String> {
        let device = geometry.device;
        let api = &device.api;
        let quality = match options.quality {
            Quality::Low => 0,
            Quality::Medium => 1,
            Quality::High => 2,
        };
        // SAFETY: geometry and device are alive; the scene keeps the geometry alive from here on.
        let handle = unsafe {
            let scene = (api.new_scene)(device.handle);
            (api.set_scene_quality)(scene, quality);
            (api.set_geometry_quality)(geometry.handle, quality);
            (api.commit_geometry)(geometry.handle);
            (api.attach_geometry)(scene, geometry.handle);
            (api.commit_scene)(scene);
            scene
        };
        let scene = Self { device, handle };
        device.check("build")?;
        Ok(scene)
    }
}

impl Drop for Scene {
    fn drop(&mut self) {
        // SAFETY: it was made with the device, and is released once.
        unsafe { (self.device.api.release_scene)(self.handle) }
    }
}

/// Embree's manual asks for both in each thread that traces: denormal numbers are slow. The program ends after it has
/// measured, and its own arithmetic on these threads is of copies and counts, so that nothing else sees the change.
fn flush_denormals() {
    let mut control = 0u32;
    // SAFETY: it stores the control word into a place of its size, and loads it with two more bits: flush to zero (15),
    // denormals are zero (6).
    unsafe {
        asm!("stmxcsr [{}]", in(reg) &raw mut control, options(nostack));
        control |= 1 << 15 | 1 << 6;
        asm!("ldmxcsr [{}]", in(reg) &raw const control, options(nostack));
    }
}

/// One ray a call.
pub struct Single(Scene);

fn single(ray: &Ray) -> SingleRay {
    SingleRay {
        origin: ray.origin,
        t_near: ray.t_min,
        direction: ray.direction,
        time: 0.0,
        t_far: ray.t_max,
        mask: u32::MAX,
        id: 0,
        flags: 0,
    }
}

impl Library for Single {
    type Mesh = Geometry;

    fn prepare(mesh: &[Triangle], options: &Options) -> Result<Geometry, String> {
        Geometry::new(mesh, options)
    }

    fn build(mesh: Geometry, options: &Options) -> Result<Self, String> {
        Scene::new(&mesh, options).map(Self)
    }

    fn start_thread() {
        flush_denormals();
    }

    fn closest_hits(&self, rays: &[Ray], coherent: bool, hits: &mut [Hit]) {
        let scene = &self.0;
        let mut arguments = QueryArguments::new(coherent);
        for (ray, found) in rays.iter().zip(hits) {
            let hit = SingleHit {
                normal: [0.0; 3],
                uv: [0.0; 2],
                primitive: NO_GEOMETRY,
                geometry: NO_GEOMETRY,
                instance: NO_GEOMETRY,
                instance_primitive: NO_GEOMETRY,
            };
            let mut query = SingleRayHit { ray: single(ray), hit };
            // SAFETY: the scene is committed; the others are alive and aligned as their types say.
            unsafe { (scene.device.api.intersect1)(scene.handle, &mut query, &mut arguments) };
            *found = match query.hit.geometry {
                NO_GEOMETRY => Hit { t: 0.0, triangle: MISS },
                _ => Hit { t: query.ray.t_far, triangle: query.hit.primitive },
            };
        }
    }

    fn any_hits(&self, rays: &[Ray], coherent: bool, hits: &mut [bool]) {
        let scene = &self.0;
        let mut arguments = QueryArguments::new(coherent);
        for (ray, found) in rays.iter().zip(hits) {
            let mut query = single(ray);
            // SAFETY: the scene is committed; ray and arguments are alive and aligned as their types say.
            unsafe { (scene.device.api.occluded1)(scene.handle, &mut query, &mut arguments) };
            // Embree marks a ray that hits by an end of -infinity.
            *found = query.t_far < 0.0;
        }
    }
}

/// As many rays a call as the processor's vectors are wide.
pub struct Packets(Scene);

impl<const N: usize> Packet<N> {
    fn new() -> Self {
        Self {
            origin: [[0.0; N]; 3],
            t_near: [0.0; N],
            direction: [[0.0; N]; 3],
            time: [0.0; N],
            t_far: [0.0; N],
            mask: [u32::MAX; N],
            id: [0; N],
            flags: [0; N],
            normal: [[0.0; N]; 3],
            uv: [[0.0; N]; 2],
            primitive: [NO_GEOMETRY; N],
            geometry: [NO_GEOMETRY; N],
            instance: [NO_GEOMETRY; N],
            instance_primitive: [NO_GEOMETRY; N],
        }
    }

    #[inline(always)]
    fn fill(&mut self, rays: &[Ray]) {
        for (lane, ray) in rays.iter().enumerate().take(N) {
            for axis in 0..3 {
                self.origin[axis][lane] = ray.origin[axis];
                self.direction[axis][lane] = ray.direction[axis];
            }
            self.t_near[lane] = ray.t_min;
            self.t_far[lane] = ray.t_max;
        }
        self.geometry = [NO_GEOMETRY; N];
    }
}

impl Packets {
    /// Traces all rays, and takes each lane's result.
    #[inline(always)]
    fn trace<const N: usize, H>(
        &self,
        query: QueryPacket,
        rays: &[Ray],
        coherent: bool,
        hits: &mut [H],
        result: impl Fn(&Packet<N>, usize) -> H,
    ) {
        let mut arguments = QueryArguments::new(coherent);
        let mut packet = Packet::<N>::new();
        let mut valid = Valid([-1; N]);
        for (rays, hits) in rays.chunks(N).zip(hits.chunks_mut(N)) {
            packet.fill(rays);
            if rays.len() < N {
                valid.0[rays.len()..].fill(0);
            }
            // SAFETY: the scene is committed; the packet is of the query's width and at least of its alignment.
            unsafe { query(valid.0.as_ptr(), self.0.handle, (&raw mut packet).cast(), &mut arguments) };
            for (lane, hit) in hits.iter_mut().enumerate() {
                *hit = result(&packet, lane);
            }
        }
    }
}

fn closest<const N: usize>(packet: &Packet<N>, lane: usize) -> Hit {
    match packet.geometry[lane] {
        NO_GEOMETRY => Hit { t: 0.0, triangle: MISS },
        _ => Hit { t: packet.t_far[lane], triangle: packet.primitive[lane] },
    }
}

fn any<const N: usize>(packet: &Packet<N>, lane: usize) -> bool {
    packet.t_far[lane] < 0.0
}

impl Library for Packets {
    type Mesh = Geometry;

    fn prepare(mesh: &[Triangle], options: &Options) -> Result<Geometry, String> {
        match Device::get(options)?.width {
            1 => Err("this processor has no packets of 8 or 16 rays in Embree (it needs AVX)".into()),
            _ => Geometry::new(mesh, options),
        }
    }

    fn build(mesh: Geometry, options: &Options) -> Result<Self, String> {
        Scene::new(&mesh, options).map(Self)
    }

    fn start_thread() {
        flush_denormals();
    }

    fn closest_hits(&self, rays: &[Ray], coherent: bool, hits: &mut [Hit]) {
        let api = &self.0.device.api;
        match self.0.device.width {
            16 => self.trace::<16, _>(api.intersect16, rays, coherent, hits, closest),
            _ => self.trace::<8, _>(api.intersect8, rays, coherent, hits, closest),
        }
    }

    fn any_hits(&self, rays: &[Ray], coherent: bool, hits: &mut [bool]) {
        let api = &self.0.device.api;
        match self.0.device.width {
            16 => self.trace::<16, _>(api.occluded16, rays, coherent, hits, any),
            _ => self.trace::<8, _>(api.occluded8, rays, coherent, hits, any),
        }
    }
}
