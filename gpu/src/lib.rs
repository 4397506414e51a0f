//! Kernel entry points. They are thin: everything that is computed is in `eosphor-core`, which the CPU compiles too.
//!
//! Parameters are references to the first items of arrays, because for kernel parameters `&T` means read-only and
//! unaliased to the compiler, which then loads them through the read-only cache; slices and raw pointers lose that.
#![no_std]
#![feature(abi_ptx, stdarch_nvptx)]

mod rays;

use core::arch::nvptx::{_block_dim_x, _block_idx_x, _thread_idx_x, trap};
use core::slice::from_raw_parts;
use core::sync::atomic::{AtomicU64, Ordering};
use eosphor_core::camera::Camera;
use eosphor_core::geometry::{Geometry, Instance, Sphere, TriangleExtra, TriangleShading};
use eosphor_core::hierarchy::{
    BvhNode, BvhTracer, BvhView, ExhaustiveTracer, IgnoreWork, PrimitivesView, Tracer,
};
use eosphor_core::intersect::PackedTriangle;
use eosphor_core::light::Light;
use eosphor_core::material::Material;
use eosphor_core::math::Vec3;
use eosphor_core::settings::Settings;
use eosphor_core::texture::{Texture, Textures};
use eosphor_core::view::SceneView;
use eosphor_core::whitted::{RayCounts, pixel_color, render_pixel};

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    // SAFETY: ends the kernel with an error. `cargo xtask ptx` makes sure that nothing gets here.
    unsafe { trap() }
}

/// Rays of a launch, in the order of `eosphor_core::whitted::RayCounts`.
#[repr(C)]
pub struct RayTotals {
    camera: AtomicU64,
    reflected: AtomicU64,
    refracted: AtomicU64,
    glossy: AtomicU64,
    shadow: AtomicU64,
}

impl RayTotals {
    fn add(&self, counts: &RayCounts) {
        let add = |total: &AtomicU64, count: u64| {
            if count > 0 {
                total.fetch_add(count, Ordering::Relaxed);
            }
        };
        add(&self.camera, counts.camera);
        add(&self.reflected, counts.reflected);
        add(&self.refracted, counts.refracted);
        add(&self.glossy, counts.glossy);
        add(&self.shadow, counts.shadow);
    }
}

/// The array that starts with `first` and has `length` items.
///
/// # Safety
///
/// The caller of the kernel must have put that many items there.
#[inline(always)]
pub(crate) unsafe fn array<'a, T>(first: &'a T, length: u64) -> &'a [T] {
    // SAFETY: as the function's contract says.
    unsafe { from_raw_parts(first, length as usize) }
}

/// The array that starts with `first`, for readers that do not look at its length: they take indices from the scene.
///
/// # Safety
///
/// As for [`array`], for every index that the scene holds.
#[inline(always)]
pub(crate) unsafe fn indexed<'a, T>(first: &'a T) -> &'a [T] {
    // SAFETY: as the function's contract says; nothing reads beyond the true length.
    unsafe { from_raw_parts(first, isize::MAX as usize / size_of::<T>()) }
}

/// The pixel of this thread in rows `first_row .. end_row`: a warp takes 8 × 4 pixels, whose rays stay together.
#[inline(always)]
fn pixel_of_thread(width: u32, first_row: u32, end_row: u32) -> Option<(u32, u32)> {
    // SAFETY: these read the thread's numbers.
    let thread = unsafe { (_block_idx_x() as u32) * (_block_dim_x() as u32) + _thread_idx_x() as u32 };
    let (tile, lane) = (thread / 32, thread % 32);
    // Never 0; said here so that there is no panic for the division.
    let tiles_in_row = width.div_ceil(8).max(1);
    let x = tile % tiles_in_row * 8 + lane % 8;
    let y = first_row + tile / tiles_in_row * 4 + lane / 8;
    (x < width && y < end_row).then_some((x, y))
}

/// Renders the thread's pixel, all samples of it.
///
/// # Safety
///
/// `film` must have room for the band's pixels.
#[inline(always)]
unsafe fn render_band<T: Tracer>(
    view: &SceneView,
    tracer: &T,
    first_row: u32,
    end_row: u32,
    film: *mut Vec3,
    totals: &RayTotals,
) {
    let width = view.settings.width;
    let Some((x, y)) = pixel_of_thread(width, first_row, end_row) else { return };
    let mut counts = RayCounts::default();
    let sum = render_pixel::<T, 1>(view, tracer, x, y, &mut counts);
    let index = (y - first_row) as usize * width as usize + x as usize;
    // SAFETY: x and y are in the band.
    unsafe { *film.add(index) = pixel_color(view, &sum) };
    totals.add(&counts);
}

/// Defines a kernel that renders a band of rows. After the tracer's own parameters all have the same ones, in the
/// order in which `crates/cuda/src/scene.rs` passes them.
macro_rules! render_kernel {
    ($(#[$doc:meta])* $name:ident($($own:ident: $type:ty),*) |$primitives:ident| $tracer:expr) => {
        $(#[$doc])*
        ///
        /// # Safety
        ///
        /// References are to the first items of the scene's arrays, which are as long as the scene's indices and the
        /// counts say; `film` has room for the pixels of rows `first_row .. end_row`.
        #[unsafe(no_mangle)]
        pub unsafe extern "ptx-kernel" fn $name(
            $($own: $type,)*
            packed_triangles: &PackedTriangle,
            packed_spheres: &Sphere,
            sphere_primitives: &u32,
            geometries: &Geometry,
            instances: &Instance,
            instance_count: u64,
            triangles: &[Vec3; 3],
            spheres: &Sphere,
            triangle_shading: &TriangleShading,
            triangle_extras: &TriangleExtra,
            sphere_materials: &u32,
            materials: &Material,
            textures: &Texture,
            texture_count: u64,
            texture_words: &u32,
            texture_word_count: u64,
            srgb_decode: &[f32; 256],
            lights: &Light,
            light_count: u64,
            camera: &Camera,
            settings: &Settings,
            extent: f32,
            first_row: u32,
            end_row: u32,
            film: *mut Vec3,
            totals: &RayTotals,
        ) {
            // SAFETY: the kernel's own contract.
            unsafe {
                let $primitives = PrimitivesView {
                    triangles: indexed(packed_triangles),
                    spheres: indexed(packed_spheres),
                    sphere_primitives: indexed(sphere_primitives),
                    geometries: indexed(geometries),
                    instances: array(instances, instance_count),
                };
                let view = SceneView {
                    triangles: indexed(triangles),
                    spheres: indexed(spheres),
                    geometries: indexed(geometries),
                    instances: array(instances, instance_count),
                    triangle_shading: indexed(triangle_shading),
                    triangle_extras: indexed(triangle_extras),
                    sphere_materials: indexed(sphere_materials),
                    materials: indexed(materials),
                    textures: Textures {
                        textures: array(textures, texture_count),
                        words: array(texture_words, texture_word_count),
                        srgb_decode,
                    },
                    lights: array(lights, light_count),
                    camera,
                    settings,
                    extent,
                };
                render_band(&view, &$tracer, first_row, end_row, film, totals);
            }
        }
    };
}

render_kernel! {
    /// Renders a band of rows over a bounding volume hierarchy.
    render_bvh(nodes: &BvhNode, roots: &u32, instance_order: &u32, instance_root: u32) |primitives| BvhTracer {
        bvh: BvhView {
            nodes: indexed(nodes),
            roots: indexed(roots),
            instance_root,
            instance_order: indexed(instance_order),
            primitives,
        },
        work: IgnoreWork,
    }
}

render_kernel! {
    /// Renders a band of rows without any hierarchy: the reference.
    render_exhaustive() |primitives| ExhaustiveTracer { primitives, work: IgnoreWork }
}
