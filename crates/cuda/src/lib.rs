//! The CUDA backend of the Eosphor ray tracer.
//!
//! The kernels are `eosphor-core`, the crate that the CPU backend renders with, compiled to PTX by rustc; this crate
//! embeds the PTX, uploads scenes and launches. Pictures are those of the CPU, bit for bit. Users need NVIDIA's driver
//! and nothing else, and programs start without it: its library is opened at run time.
//!
//! ```no_run
//! use eosphor_cuda::{CudaBackend, CudaOptions, devices};
//!
//! for device in devices()? {
//!     println!("{device}");
//! }
//! let backend = CudaBackend::new(CudaOptions::default())?;
//! # Ok::<(), eosphor_render::BackendError>(())
//! ```
#![warn(missing_docs)]

mod backend;
mod bands;
mod compilation;
mod develop_launch;
mod device;
mod failure;
mod launch;
mod launch_buffers;
mod launch_rooms;
mod light_room;
mod memory;
mod options;
mod parameters;
mod pixel;
mod ptx;
mod ptx_text;
mod queue_launch;
mod queue_room;
mod ray_count;
mod rays;
mod scene;
mod scheduler;
mod stages;
mod staging;
mod structure;
mod top_level;
mod traversal;

pub use backend::CudaBackend;
pub use device::{DeviceInfo, devices};
pub use options::CudaOptions;
pub use rays::{CudaRays, Timed};
pub use scheduler::GpuScheduler;
pub use traversal::Traversal;
