//! Parts of pictures. Pixels keep the numbers that they have in the whole, so theirs is the camera, the random numbers and
//! every bit.

use crate::backend::check_rows;
use crate::{
    BackendError, Film, Hierarchy, HierarchyStatistics, PreparedScene, Progress, RenderControl, Rendered,
    SampleSums, Sampled,
};
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::sync::Arc;

/// Where a device renders whole rows only, rows of about so many pixels are rendered at a time.
const MAX_PIXELS_AT_ONCE: u32 = 1 << 22;

/// A rectangle of pixels of a picture; (0, 0) is the upper left one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Region {
    /// First column, from the left of the picture, from 0.
    pub x: u32,
    /// First row, from the top of the picture, from 0.
    pub y: u32,
    /// Number of columns.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
}

impl Region {
    /// The region that is a whole picture of this width and height in pixels.
    pub fn whole((width, height): (u32, u32)) -> Region {
        Region { x: 0, y: 0, width, height }
    }

    /// Some rows of it, counted from its first one.
    pub fn rows(&self, rows: &Range<u32>) -> Region {
        Region { y: self.y + rows.start, height: rows.end - rows.start, ..*self }
    }

    /// Whether the region has pixels, and all of them are in a picture of this width and height.
    pub fn is_in(&self, (width, height): (u32, u32)) -> bool {
        let fits =
            |first: u32, count: u32, all| count > 0 && u64::from(first) + u64::from(count) <= u64::from(all);
        fits(self.x, self.width, width) && fits(self.y, self.height, height)
    }

    /// The number of pixels of the region.
    pub fn pixels(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    /// The rows of the picture that it has pixels of.
    pub fn picture_rows(&self) -> Range<u32> {
        self.y..self.y + self.height
    }
}

/// Fails where a region has no pixels, or some that the picture lacks.
pub(crate) fn check_region(region: &Region, size: (u32, u32)) -> Result<(), BackendError> {
    match region.is_in(size) {
        true => Ok(()),
        false => Err(BackendError::Failed(format!(
            "{} x {} pixels from ({}, {}) on are asked for, and the picture has {} x {}",
            region.width, region.height, region.x, region.y, size.0, size.1
        ))),
    }
}

/// Takes samples of whole rows, and keeps those of a region: for devices that know rows only.
pub(crate) fn sample_whole_rows<P: PreparedScene + ?Sized>(
    prepared: &P,
    region: &Region,
    samples: Range<u32>,
    control: &RenderControl,
) -> Result<Sampled, BackendError> {
    let (width, _) = control.size_of(prepared);
    check_region(region, control.size_of(prepared))?;
    let of_region = |pixels: u64| pixels * u64::from(region.width) / u64::from(width);
    let mut all = Sampled {
        sums: SampleSums::new(region.width, region.height),
        complete: true,
        statistics: Default::default(),
    };
    let at_once = (MAX_PIXELS_AT_ONCE / width).max(1);
    let columns = region.x as usize..(region.x + region.width) as usize;
    let mut done = 0;
    while done < region.height && all.complete {
        let rows = done..region.height.min(done + at_once);
        let rays = all.statistics.total_rays();
        let pixels_before = u64::from(done) * u64::from(region.width);
        let on_progress = |progress: Progress| {
            (control.on_progress)(Progress {
                pixels_done: pixels_before + of_region(progress.pixels_done),
                pixels_total: region.pixels(),
                rays: rays + progress.rays,
            })
        };
        let control = RenderControl { on_progress: &on_progress, ..*control };
        let of_picture = region.rows(&rows).picture_rows();
        let some = prepared.sample_rows(of_picture, samples.clone(), &control)?;
        let to = all.sums.sums.chunks_exact_mut(region.width as usize).skip(done as usize);
        let from = some.sums.sums.chunks_exact(width as usize);
        to.zip(from).for_each(|(to, from)| to.copy_from_slice(&from[columns.clone()]));
        all.complete = some.complete;
        all.statistics += some.statistics;
        done = rows.end;
    }
    Ok(all)
}

/// A part of a picture, as a picture of its own size.
pub struct PreparedRegion {
    whole: Box<dyn PreparedScene>,
    region: Region,
}

impl PreparedRegion {
    /// A part of what is prepared.
    ///
    /// # Errors
    ///
    /// [`BackendError::Failed`] where it has no pixels, or some that the picture lacks.
    pub fn new(whole: Box<dyn PreparedScene>, region: Region) -> Result<PreparedRegion, BackendError> {
        check_region(&region, whole.size())?;
        Ok(PreparedRegion { whole, region })
    }
}

impl PreparedScene for PreparedRegion {
    fn hierarchy_statistics(&self) -> HierarchyStatistics {
        self.whole.hierarchy_statistics()
    }

    fn hierarchy(&self) -> Option<Arc<Hierarchy>> {
        self.whole.hierarchy()
    }

    fn size(&self) -> (u32, u32) {
        (self.region.width, self.region.height)
    }

    fn samples(&self) -> u32 {
        self.whole.samples()
    }

    fn pixels_at_a_time(&self) -> u64 {
        self.whole.pixels_at_a_time()
    }

    fn frames_left(&self, frames: usize) {
        self.whole.frames_left(frames);
    }

    fn render_rows(&self, rows: Range<u32>, control: &RenderControl) -> Result<Rendered, BackendError> {
        let samples = self.samples();
        let Sampled { sums, complete, statistics } = self.sample_rows(rows, 0..samples, control)?;
        let film = match complete {
            true => sums.film(samples),
            false => Film::new(sums.width, sums.height),
        };
        Ok(Rendered { film, complete, statistics })
    }

    fn sample_rows(
        &self,
        rows: Range<u32>,
        samples: Range<u32>,
        control: &RenderControl,
    ) -> Result<Sampled, BackendError> {
        check_rows(&rows, self.region.height)?;
        self.whole.sample_region(&self.region.rows(&rows), samples, control)
    }

    fn sample_region(
        &self,
        region: &Region,
        samples: Range<u32>,
        control: &RenderControl,
    ) -> Result<Sampled, BackendError> {
        check_region(region, self.size())?;
        let of_picture = Region { x: self.region.x + region.x, y: self.region.y + region.y, ..*region };
        self.whole.sample_region(&of_picture, samples, control)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regions_lie_in_pictures_or_not() {
        let region = |x, y, width, height| Region { x, y, width, height };
        assert!(region(0, 0, 8, 6).is_in((8, 6)) && region(7, 5, 1, 1).is_in((8, 6)));
        for wrong in [region(0, 0, 9, 6), region(1, 0, 8, 6), region(0, 0, 0, 6), region(8, 0, 1, 1)] {
            assert!(!wrong.is_in((8, 6)), "{wrong:?}");
        }
        assert!(!region(u32::MAX, 0, u32::MAX, 1).is_in((8, 6)));
        assert_eq!(region(2, 3, 4, 9).rows(&(1..3)), region(2, 4, 4, 2));
        assert_eq!(region(2, 3, 4, 2).picture_rows(), 3..5);
    }
}
