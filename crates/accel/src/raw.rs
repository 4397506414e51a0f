//! Casts between plain types of this crate and raw numbers, by bytemuck.

use bytemuck::{Pod, TransparentWrapper, Zeroable};
use eosphor_core::geometry::Sphere;
use eosphor_core::math::{Affine, Vec3};
use eosphor_core::ray::{Hit, PrimitiveId, Ray};

/// A value that bytemuck can cast: numbers of 32 bits, one after the other, without padding.
///
/// It stands around [`Vec3`] (3 floats; `[Vec3; 3]`, a triangle, 9), [`Ray`] (origin, `t_min`, direction, `t_max`: 8 floats,
/// aligned to 16 bytes), [`Hit`] (`t`, `t_rest`, `u`, `v`, instance, primitive), [`PrimitiveId`], [`Sphere`] (centre and radius,
/// aligned to 16 bytes) and [`Affine`] (three columns and the translation). bytemuck's `cast_slice` makes slices of it from raw
/// numbers and back, where the alignment fits; its `peel_slice` and `wrap_slice` take it off and put it on. No cast copies.
///
/// ```
/// use bytemuck::TransparentWrapper;
/// use eosphor_accel::{Hit, Raw, Ray, Vec3, vec3};
///
/// // Nine floats a triangle, as files and GPUs have them.
/// let floats = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
/// let triangles: &[[Vec3; 3]] = Raw::peel_slice(bytemuck::cast_slice(&floats));
/// assert_eq!(triangles[0][1], vec3(1.0, 0.0, 0.0));
///
/// // Results as bytes.
/// let hits = [Hit::miss(1.0); 2];
/// let bytes: &[u8] = bytemuck::cast_slice(Raw::wrap_slice(&hits));
/// assert_eq!(bytes.len(), 2 * 24);
///
/// // Rays into a buffer that is aligned for them.
/// let mut rays = vec![Ray::new(Vec3::ZERO, vec3(0.0, 0.0, 1.0)); 2];
/// let floats: &mut [f32] = bytemuck::cast_slice_mut(Raw::wrap_slice_mut(&mut rays));
/// floats[8 + 3] = 0.5;
/// assert_eq!(rays[1].t_min, 0.5);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(transparent)]
pub struct Raw<T>(pub T);

// SAFETY: plain numbers: a transparent struct has the layout of its only field.
unsafe impl<T> TransparentWrapper<T> for Raw<T> {}

/// Says that types are plain numbers of 32 bits: how many each has.
macro_rules! plain_numbers {
    ($($type:ty: $count:literal;)*) => {$(
        const _: () = assert!(size_of::<$type>() == 4 * $count);
        // SAFETY: plain numbers: these types are `repr(C)`, all their fields are numbers of 32 bits, for which any bits will do,
        // and the size is that of the fields, so nothing is padding.
        unsafe impl Zeroable for Raw<$type> {}
        // SAFETY: plain numbers, as for `Zeroable`; they are `Copy` and have no lifetime.
        unsafe impl Pod for Raw<$type> {}
    )*};
}

plain_numbers! {
    Vec3: 3;
    [Vec3; 3]: 9;
    Ray: 8;
    Hit: 6;
    PrimitiveId: 2;
    Sphere: 4;
    Affine: 12;
}
