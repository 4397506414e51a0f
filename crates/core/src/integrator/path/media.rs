//! Bodies inside of bodies: which ones a path is in, and what bends it where one ends.
//!
//! After Schmidt and Budge 2002, "Simple nested dielectrics in ray traced images": a path keeps a list of the bodies that it has
//! entered and not left. Where bodies overlap, light is in the one that it entered last, and a surface of another body is not
//! there. Only what flattening has found to be closed is a body ([`Material::is_body`]): a path would never leave other things.
//!
//! [`Material::is_body`]: crate::material::Material::is_body

use super::PathPoint;
use crate::integrator::PathRay;
use crate::math::{Vec3, max};
use crate::shading::{LEAST_IOR, left_by_body};
use crate::view::{SceneView, item};

/// The bodies that a ray is in, the one that it is in first: numbers of materials plus 1 in 16 bits each, 0 for none. A ray that
/// enters a fifth forgets the outermost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Media(u64);

const BITS: u32 = 16;
const MASK: u64 = (1 << BITS) - 1;

impl Media {
    /// Of a ray of a path.
    #[inline(always)]
    pub fn of(ray: &PathRay) -> Media {
        Media(ray.inside as u64 | (ray.path as u64) << 32)
    }

    /// Whether the ray is in no body.
    #[inline(always)]
    pub fn is_nowhere(self) -> bool {
        self.0 == 0
    }

    /// As [`PathRay::inside`] and [`PathRay::path`].
    #[inline(always)]
    pub fn words(self) -> [u32; 2] {
        [self.0 as u32, (self.0 >> 32) as u32]
    }

    /// Beyond the surface of a point that the ray meets.
    #[inline(always)]
    pub fn beyond(self, view: &SceneView, point: &PathPoint) -> Media {
        if !item(view.materials, point.material).is_body {
            return self;
        }
        let number = point.material as u64 + 1;
        if point.front {
            return Media(self.0 << BITS | number);
        }
        match self.place_of(number) {
            Some(place) => {
                let kept = (1 << place) - 1;
                Media((self.0 & kept) | (self.0 >> BITS & !kept))
            }
            None => self,
        }
    }

    /// The index of refraction inside of the point's body over that outside of it, where the ray meets it.
    #[inline(always)]
    pub fn relative_ior(self, view: &SceneView, point: &PathPoint) -> f32 {
        let own = point.material_values.ior;
        if self.0 == 0 {
            return own;
        }
        if point.front {
            return own / self.ior(view);
        }
        match self.place_of(point.material as u64 + 1) {
            // The ray is in another body, which this one overlaps.
            Some(place) if place > 0 => 1.0,
            _ => own / self.beyond(view, point).ior(view),
        }
    }

    /// What is left of light after a distance inside.
    #[inline(always)]
    pub fn left(self, view: &SceneView, distance: f32) -> Vec3 {
        match self.material() {
            Some(material) => left_by_body(view, material, distance),
            None => Vec3::ONE,
        }
    }

    /// The material of the body that the ray is in.
    #[inline(always)]
    pub fn material(self) -> Option<u32> {
        let number = (self.0 & MASK) as u32;
        if number == 0 { None } else { Some(number - 1) }
    }

    #[inline(always)]
    fn ior(self, view: &SceneView) -> f32 {
        match self.material() {
            Some(material) => max(item(view.materials, material).ior, LEAST_IOR),
            None => 1.0,
        }
    }

    /// By how many bits the innermost body of this number is shifted.
    #[inline(always)]
    fn place_of(self, number: u64) -> Option<u32> {
        let mut place = 0;
        while place < 64 {
            if self.0 >> place & MASK == number {
                return Some(place);
            }
            place += BITS;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_keep_four_bodies() {
        let list = |numbers: &[u64]| Media(numbers.iter().rev().fold(0, |all, number| all << BITS | number));
        assert_eq!(list(&[7, 3]).material(), Some(6));
        assert_eq!(Media(0).material(), None);
        let all = list(&[1, 2, 3, 65_535]);
        assert_eq!(
            [1, 2, 3, 65_535, 9].map(|n| all.place_of(n)),
            [Some(0), Some(16), Some(32), Some(48), None]
        );
        let [inside, path] = all.words();
        assert_eq!((inside, path), (0x0002_0001, 0xffff_0003));
    }
}
