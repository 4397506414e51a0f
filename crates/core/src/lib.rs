//! The arithmetic of the Eosphor ray tracer: everything that reaches a pixel.
//!
//! This crate is compiled twice from the same source: for the CPU and, by rustc's own NVPTX backend, for NVIDIA
//! GPUs. It does no IO, allocates nothing, recurses nowhere and cannot fail. Both compilations give the same bits;
//! the rules that keep it so are in ARCHITECTURE.md, "The picture contract".
//!
//! The way of a pixel: [`whitted::camera_ray`] → [`hierarchy::Tracer::closest_hit`] →
//! [`shading::SurfacePoint`] → [`whitted::local_radiance`], [`whitted::direct_light`], [`whitted::child_ray`] →
//! [`whitted::ExactSum`].
#![cfg_attr(target_arch = "nvptx64", no_std)]
#![cfg_attr(target_arch = "nvptx64", feature(asm_experimental_arch, core_float_math))]

pub mod camera;
pub mod geometry;
pub mod hierarchy;
pub mod intersect;
pub mod light;
pub mod material;
pub mod math;
mod out_of_line;
pub mod ray;
pub mod sampling;
pub mod settings;
pub mod shading;
pub mod texture;
pub mod view;
pub mod whitted;
