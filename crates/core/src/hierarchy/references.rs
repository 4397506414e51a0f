//! Primitives by number, for structures that hold a primitive in more than one place.

use super::Work;
use super::candidates::{Placement, PrimitivesView, trusted};
use super::search::Search;
use crate::intersect::LocalRay;
use crate::ray::RayFilter;

/// Set in references to spheres; the rest is the number in the array of triangles or of spheres.
pub const SPHERE_REFERENCE: u32 = 1 << 31;

/// How many of the last primitives a walk remembers.
const REMEMBERED: usize = 16;

/// The primitives that a walk tested last (mailboxing, Amanatides and Woo 1987, without memory in the primitives). A
/// primitive that is tested twice gives the same hit twice, so forgetting one costs time only.
pub(super) struct Mailbox {
    last: [u32; REMEMBERED],
}

impl Mailbox {
    /// Remembers nothing. (No reference has all bits set.)
    #[inline(always)]
    pub(super) fn new() -> Mailbox {
        Mailbox { last: [u32::MAX; REMEMBERED] }
    }

    /// Whether the primitive is remembered; it is from now on.
    #[inline(always)]
    pub(super) fn has(&mut self, reference: u32) -> bool {
        let place = &mut self.last[reference as usize % REMEMBERED];
        let same = *place == reference;
        *place = reference;
        same
    }
}

/// What it takes to test references, less the range.
pub(super) struct References<'a, C> {
    pub(super) primitives: &'a PrimitivesView<'a>,
    pub(super) references: &'a [u32],
    pub(super) ray: &'a LocalRay,
    pub(super) placement: &'a Placement<'a>,
    pub(super) filter: &'a RayFilter,
    pub(super) work: &'a C,
    pub(super) mailbox: Option<Mailbox>,
}

impl<C: Work> References<'_, C> {
    /// Tests the primitives that references `first .. first + count` name; `true` ends the search.
    #[inline(always)]
    pub(super) fn search(&mut self, first: u32, count: u32, search: &mut impl Search) -> bool {
        let (primitives, ray, placement) = (self.primitives, self.ray, self.placement);
        let mut k = first;
        while k < first + count {
            let reference = *trusted(self.references, k);
            k += 1;
            if let Some(mailbox) = &mut self.mailbox
                && mailbox.has(reference)
            {
                continue;
            }
            self.work.primitives(1);
            let ends = if reference & SPHERE_REFERENCE == 0 {
                primitives.search_triangles(reference, 1, ray, placement, self.filter, search)
            } else {
                primitives.search_spheres(reference & !SPHERE_REFERENCE, 1, ray, placement, search)
            };
            if ends {
                return true;
            }
        }
        false
    }
}
