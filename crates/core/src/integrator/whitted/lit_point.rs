//! What lights need to know of a surface point.

use super::{LampLobe, Receiver, shadow_origin, side_sign};
use crate::math::Vec3;
use crate::ray::PrimitiveId;
use crate::shading::SurfacePoint;

/// A surface point as lights see it: all that [`direct_light`](super::direct_light) asks of it.
#[derive(Clone, Copy, Debug)]
pub struct LitPoint {
    /// World space.
    pub position: Vec3,
    /// How far off the surface shadow rays start.
    pub offset: f32,
    /// Unit normal of the surface itself, on the viewer's side.
    pub geometric_normal: Vec3,
    /// Unit normal for shading.
    pub normal: Vec3,
    /// Unit vector to the viewer.
    pub to_viewer: Vec3,
    /// Its primitive.
    pub id: PrimitiveId,
    /// What lights are multiplied by, scattered.
    pub diffuse: Vec3,
    /// The highlight's weight.
    pub specular: Vec3,
    /// The highlight's exponent.
    pub shininess: f32,
    /// Lamps throw highlights too.
    pub lamp_highlights: bool,
    /// What light from behind is multiplied by.
    pub transmission: Vec3,
    /// By what lamps are reflected.
    pub lobe: LampLobe,
}

impl LitPoint {
    /// A surface point, which reflects lamps by this lobe.
    #[inline(always)]
    pub fn new(point: &SurfacePoint, lobe: &LampLobe) -> LitPoint {
        let values = &point.material_values;
        LitPoint {
            position: point.position,
            offset: point.offset,
            geometric_normal: point.geometric_normal,
            normal: point.normal,
            to_viewer: point.to_viewer,
            id: point.id,
            diffuse: values.diffuse,
            specular: values.specular,
            shininess: values.shininess,
            lamp_highlights: values.lamp_highlights,
            transmission: values.transmission,
            lobe: *lobe,
        }
    }

    /// The side that the viewer sees (0) or the other (1), with key and first sample 0 and scale 1.
    #[inline(always)]
    pub(super) fn receiver(&self, side: u32, highlights: bool) -> Receiver {
        let sign = side_sign(side);
        let above = self.geometric_normal * sign;
        Receiver {
            origin: shadow_origin(self.position, above, self.offset),
            normal: self.normal * sign,
            above,
            to_viewer: self.to_viewer,
            shininess: self.shininess,
            highlights,
            lobe: self.lobe,
            key: 0,
            first: 0,
            scale: 1.0,
        }
    }
}
