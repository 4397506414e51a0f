//! Hits in the order of their triangles.
//!
//! Neighbours in the file are mostly neighbours in the scene: rays that start at them go the same ways. (In
//! the order of their places, by Morton codes, hits do no better.)

/// Hits are put into so many lists by their triangles' numbers.
const BUCKET_BITS: u32 = 11;
const BUCKETS: usize = 1 << BUCKET_BITS;

/// Fewer stay as they are.
const MIN_SORTED: usize = 64;

/// What sorting works in.
pub(super) struct TriangleOrder<T> {
    sorted: Vec<T>,
    counts: Vec<u32>,
}

impl<T> Default for TriangleOrder<T> {
    fn default() -> TriangleOrder<T> {
        TriangleOrder { sorted: Vec::new(), counts: Vec::new() }
    }
}

impl<T: Copy> TriangleOrder<T> {
    /// Puts hits beside those of triangles with numbers near theirs. The scene has so many.
    #[inline(always)]
    pub(super) fn sort(&mut self, hits: &mut Vec<T>, triangles: usize, number: impl Fn(&T) -> u32) {
        if hits.len() < MIN_SORTED {
            return;
        }
        let bits = u32::BITS - (triangles as u32).leading_zeros();
        let shift = bits.saturating_sub(BUCKET_BITS);
        let bucket = |hit: &T| (number(hit) >> shift) as usize % BUCKETS;
        self.counts.clear();
        self.counts.resize(BUCKETS, 0);
        hits.iter().for_each(|hit| self.counts[bucket(hit)] += 1);
        let mut before = 0;
        for count in &mut self.counts {
            (*count, before) = (before, before + *count);
        }
        self.sorted.clear();
        self.sorted.extend_from_slice(hits);
        for hit in hits.iter() {
            let place = &mut self.counts[bucket(hit)];
            self.sorted[*place as usize] = *hit;
            *place += 1;
        }
        std::mem::swap(hits, &mut self.sorted);
    }
}
