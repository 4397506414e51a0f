//! The few functions of Embree 4's C interface that are needed, looked up in the library at run time. No header and no
//! compiler for C is needed, and the program builds where Embree is not installed.

use libloading::Library;
use std::ffi::{c_char, c_int, c_uint, c_void};
use std::path::PathBuf;
use std::ptr;

/// The name that Linux looks for in its own folders.
const SONAME: &str = "libembree4.so.4";

pub const GEOMETRY_TRIANGLE: c_int = 0;
pub const BUFFER_INDEX: c_int = 0;
pub const BUFFER_VERTEX: c_int = 1;
pub const FORMAT_UINT3: c_int = 0x5003;
pub const FORMAT_FLOAT3: c_int = 0x9003;
pub const PROPERTY_NATIVE_RAY8: c_int = 33;
pub const PROPERTY_NATIVE_RAY16: c_int = 34;
pub const FLAG_COHERENT: c_int = 1 << 16;
/// The geometry of a ray that meets none.
pub const NO_GEOMETRY: c_uint = c_uint::MAX;

/// `RTCIntersectArguments` and `RTCOccludedArguments`, which are laid out alike.
#[repr(C)]
pub struct QueryArguments {
    pub flags: c_int,
    pub features: c_uint,
    context: *mut c_void,
    filter: *mut c_void,
    user_geometry: *mut c_void,
    /// Is there only where Embree was built with a minimum width for curves; it is at the end, and is ignored elsewhere.
    min_width_factor: f32,
}

impl QueryArguments {
    pub fn new(coherent: bool) -> Self {
        Self {
            flags: if coherent { FLAG_COHERENT } else { 0 },
            features: c_uint::MAX,
            context: ptr::null_mut(),
            filter: ptr::null_mut(),
            user_geometry: ptr::null_mut(),
            min_width_factor: 0.0,
        }
    }
}

/// `RTCRay`.
#[repr(C, align(16))]
pub struct SingleRay {
    pub origin: [f32; 3],
    pub t_near: f32,
    pub direction: [f32; 3],
    pub time: f32,
    pub t_far: f32,
    pub mask: c_uint,
    pub id: c_uint,
    pub flags: c_uint,
}

/// `RTCRayHit`.
#[repr(C, align(16))]
pub struct SingleRayHit {
    pub ray: SingleRay,
    pub hit: SingleHit,
}

/// `RTCHit`. The last word is there only in builds with arrays of instances; elsewhere it is padding.
#[repr(C, align(16))]
pub struct SingleHit {
    pub normal: [f32; 3],
    pub uv: [f32; 2],
    pub primitive: c_uint,
    pub geometry: c_uint,
    pub instance: c_uint,
    pub instance_primitive: c_uint,
}

/// `RTCRayHit8` or `RTCRayHit16`; its start is an `RTCRay8` or `RTCRay16`. Aligned for the wider.
#[repr(C, align(64))]
pub struct Packet<const N: usize> {
    pub origin: [[f32; N]; 3],
    pub t_near: [f32; N],
    pub direction: [[f32; N]; 3],
    pub time: [f32; N],
    pub t_far: [f32; N],
    pub mask: [c_uint; N],
    pub id: [c_uint; N],
    pub flags: [c_uint; N],
    pub normal: [[f32; N]; 3],
    pub uv: [[f32; N]; 2],
    pub primitive: [c_uint; N],
    pub geometry: [c_uint; N],
    pub instance: [c_uint; N],
    pub instance_primitive: [c_uint; N],
}

/// Which rays of a packet are to be traced: -1 for yes, 0 for no.
#[repr(C, align(64))]
pub struct Valid<const N: usize>(pub [c_int; N]);

// What Embree reads and writes has to lie where its header says.
const _: () = {
    assert!(size_of::<SingleRay>() == 48 && size_of::<SingleRayHit>() == 96);
    assert!(std::mem::offset_of!(Packet<8>, normal) == 12 * 8 * 4);
    assert!(std::mem::offset_of!(Packet<16>, normal) == 12 * 16 * 4);
    assert!(std::mem::offset_of!(Packet<16>, geometry) == 18 * 16 * 4);
};

/// An `RTCDevice`, `RTCScene` or `RTCGeometry`.
pub type Handle = *mut c_void;

/// `rtcIntersect8` and the like: which rays are valid, the scene, the packet.
pub type QueryPacket = unsafe extern "C" fn(*const c_int, Handle, *mut c_void, *mut QueryArguments);

macro_rules! api {
    ($($field:ident: $symbol:literal, $type:ty;)*) => {
        /// Pointers to the functions, with the library that they are in.
        pub struct Api {
            $(pub $field: $type,)*
            _library: Library,
        }

        impl Api {
            fn new(library: Library) -> Result<Self, libloading::Error> {
                // SAFETY: the types are those of Embree 4's header; the pointers are kept with the library.
                unsafe { Ok(Self { $($field: *library.get::<$type>($symbol)?,)* _library: library }) }
            }
        }
    };
}

api! {
    new_device: c"rtcNewDevice", unsafe extern "C" fn(*const c_char) -> Handle;
    device_error: c"rtcGetDeviceError", unsafe extern "C" fn(Handle) -> c_int;
    device_property: c"rtcGetDeviceProperty", unsafe extern "C" fn(Handle, c_int) -> isize;
    new_scene: c"rtcNewScene", unsafe extern "C" fn(Handle) -> Handle;
    release_scene: c"rtcReleaseScene", unsafe extern "C" fn(Handle);
    set_scene_quality: c"rtcSetSceneBuildQuality", unsafe extern "C" fn(Handle, c_int);
    commit_scene: c"rtcCommitScene", unsafe extern "C" fn(Handle);
    new_geometry: c"rtcNewGeometry", unsafe extern "C" fn(Handle, c_int) -> Handle;
    release_geometry: c"rtcReleaseGeometry", unsafe extern "C" fn(Handle);
    set_geometry_quality: c"rtcSetGeometryBuildQuality", unsafe extern "C" fn(Handle, c_int);
    new_buffer: c"rtcSetNewGeometryBuffer",
        unsafe extern "C" fn(Handle, c_int, c_uint, c_int, usize, usize) -> *mut c_void;
    commit_geometry: c"rtcCommitGeometry", unsafe extern "C" fn(Handle);
    attach_geometry: c"rtcAttachGeometry", unsafe extern "C" fn(Handle, Handle) -> c_uint;
    intersect1: c"rtcIntersect1", unsafe extern "C" fn(Handle, *mut SingleRayHit, *mut QueryArguments);
    occluded1: c"rtcOccluded1", unsafe extern "C" fn(Handle, *mut SingleRay, *mut QueryArguments);
    intersect8: c"rtcIntersect8", QueryPacket;
    occluded8: c"rtcOccluded8", QueryPacket;
    intersect16: c"rtcIntersect16", QueryPacket;
    occluded16: c"rtcOccluded16", QueryPacket;
}

impl Api {
    /// Opens the library that `EMBREE_LIBRARY` names, or the one that peers/build has fetched, or the system's.
    pub fn open() -> Result<Self, String> {
        let path = match std::env::var_os("EMBREE_LIBRARY") {
            Some(path) => path.into(),
            None => fetched().unwrap_or_else(|| SONAME.into()),
        };
        let fail =
            |error| format!("cannot open Embree ({}): {error}; peers/build fetches it", path.display());
        // SAFETY: opening Embree runs no code but its initialisers.
        let library = unsafe { Library::new(&path) }.map_err(fail)?;
        Self::new(library).map_err(fail)
    }
}

/// In the folder that a Python wheel keeps its libraries in, below `target/embree`; the program is in `target/release`.
fn fetched() -> Option<PathBuf> {
    let program = std::env::current_exe().ok()?;
    let target =
        program.ancestors().find(|folder| folder.file_name().is_some_and(|name| name == "target"))?;
    let entries = std::fs::read_dir(target.join("embree/embreex.libs")).ok()?;
    let mut paths = entries.flatten().map(|entry| entry.path());
    paths.find(|path| {
        path.file_name().and_then(|name| name.to_str()).is_some_and(|name| name.starts_with("libembree4"))
    })
}
