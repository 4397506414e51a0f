//! The arithmetic of the Eosphor ray tracer: everything that reaches a pixel.
//!
//! This crate is compiled twice from the same source: for the CPU and, by rustc's own NVPTX backend, for NVIDIA
//! GPUs. It does no IO, allocates nothing, recurses nowhere and cannot fail. Both compilations give the same bits;
//! the rules that keep it so are in docs/contract.md.
//!
//! The way of a pixel: [`integrator::camera_ray`] → [`hierarchy::Tracer::closest_hit`] →
//! [`shading::SurfacePoint`] → [`integrator::whitted`]'s stages (local terms, lights, child rays) → [`sums::ExactSum`].
#![cfg_attr(target_arch = "nvptx64", no_std)]
#![cfg_attr(target_arch = "nvptx64", feature(asm_experimental_arch, core_float_math))]

pub mod bsdf;
pub mod camera;
pub mod develop;
pub mod device;
pub mod environment;
pub mod geometry;
pub mod hierarchy;
pub mod integrator;
pub mod intersect;
pub mod light;
pub mod material;
pub mod math;
mod memory;
mod out_of_line;
pub mod ray;
pub mod sampling;
pub mod settings;
pub mod shading;
pub mod sums;
pub mod texture;
mod texture_lanes;
pub mod view;
