//! Rows of a picture that lie apart, as a picture of their own.

use crate::backend::check_rows;
use crate::{
    BackendError, FeatureRows, Film, Hierarchy, HierarchyStatistics, PreparedScene, Progress, RenderControl,
    Rendered, SampleSums, Sampled,
};
use std::ops::Range;
use std::sync::Arc;

/// Rows that lie together are few: so many such ranges are in work at the same time, as one is too small for all threads.
const AT_A_TIME: usize = 8;

/// Some rows of a picture, by ranges from the top, which are the rows of another one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PickedRows(Vec<Range<u32>>);

impl PickedRows {
    /// These ranges of rows, one below the other.
    pub fn new(ranges: impl IntoIterator<Item = Range<u32>>) -> PickedRows {
        PickedRows(ranges.into_iter().collect())
    }

    /// The number of rows that are picked.
    pub fn height(&self) -> u32 {
        self.0.iter().map(|range| range.end - range.start).sum()
    }

    /// The ranges of rows of the picture that a range of the picked rows (counted from 0) is taken from.
    pub fn in_picture(&self, rows: &Range<u32>) -> Vec<Range<u32>> {
        let mut first = 0;
        let mut found = Vec::new();
        for range in &self.0 {
            let end = first + (range.end - range.start);
            let (from, to) = (rows.start.max(first), rows.end.min(end));
            if from < to {
                found.push(range.start + (from - first)..range.start + (to - first));
            }
            first = end;
        }
        found
    }

    /// Features of some of its rows, by those of rows of the picture that they are taken from.
    ///
    /// # Errors
    ///
    /// What `of` gives.
    pub fn features<E>(
        &self,
        rows: &Range<u32>,
        of: impl Fn(Range<u32>) -> Result<FeatureRows, E>,
    ) -> Result<FeatureRows, E> {
        let mut all = FeatureRows::new(0, 0);
        for range in self.in_picture(rows) {
            let some = of(range)?;
            (all.width, all.height) = (some.width, all.height + some.height);
            all.pixels.extend(some.pixels);
            all.work.extend(some.work);
        }
        Ok(all)
    }
}

/// Rows of a picture that lie apart, as a picture of their own.
pub struct PreparedRows {
    whole: Box<dyn PreparedScene>,
    rows: PickedRows,
}

impl PreparedRows {
    /// Restricts a prepared scene to `rows`, which form a picture of their own.
    ///
    /// # Errors
    ///
    /// [`BackendError::Failed`] where the picture lacks some of them.
    pub fn new(whole: Box<dyn PreparedScene>, rows: PickedRows) -> Result<PreparedRows, BackendError> {
        let (_, height) = whole.size();
        rows.0.iter().try_for_each(|range| check_rows(range, height))?;
        Ok(PreparedRows { whole, rows })
    }
}

impl PreparedScene for PreparedRows {
    fn hierarchy_statistics(&self) -> HierarchyStatistics {
        self.whole.hierarchy_statistics()
    }

    fn hierarchy(&self) -> Option<Arc<Hierarchy>> {
        self.whole.hierarchy()
    }

    fn size(&self) -> (u32, u32) {
        (self.whole.size().0, self.rows.height())
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
        let (width, height) = self.size();
        check_rows(&rows, height)?;
        let mut all =
            Sampled { sums: SampleSums::new(width, 0), complete: true, statistics: Default::default() };
        let pixels_total = rows.len() as u64 * u64::from(width);
        let part = RenderControl { on_progress: &|_| {}, ..*control };
        let take = |range: Range<u32>| self.whole.sample_rows(range, samples.clone(), &part);
        for some in self.rows.in_picture(&rows).chunks(AT_A_TIME) {
            let done: Vec<_> = std::thread::scope(|scope| {
                let take = &take;
                let running: Vec<_> =
                    some.iter().map(|range| scope.spawn(move || take(range.clone()))).collect();
                let end = |panic| std::panic::resume_unwind(panic);
                running.into_iter().map(|range| range.join().unwrap_or_else(end)).collect()
            });
            for sampled in done {
                let Sampled { sums, complete, statistics } = sampled?;
                all.sums.height += sums.height;
                all.sums.sums.extend(sums.sums);
                all.complete &= complete;
                all.statistics += statistics;
            }
            (control.on_progress)(Progress {
                pixels_done: all.sums.sums.len() as u64,
                pixels_total,
                rays: all.statistics.total_rays(),
            });
        }
        Ok(all)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_found_in_the_picture() {
        let rows = PickedRows::new([8..16, 24..32, 40..43]);
        assert_eq!(rows.height(), 19);
        assert_eq!(rows.in_picture(&(0..19)), [8..16, 24..32, 40..43]);
        assert_eq!(rows.in_picture(&(7..9)), [15..16, 24..25]);
        assert_eq!(rows.in_picture(&(6..17)), [14..16, 24..32, 40..41]);
        assert_eq!(rows.in_picture(&(15..19)), [31..32, 40..43]);
        assert!(rows.in_picture(&(3..3)).is_empty() && PickedRows::new([]).height() == 0);
    }
}
