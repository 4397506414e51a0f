//! Jobs: what a caller says of its work, and hears of it.

use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// What a unit's computation is: from its number and description, its result or the reason why there is none.
pub type Compute<'a> = &'a (dyn Fn(u64, &[u8]) -> Result<Vec<u8>, String> + Sync);

/// Work that all ranks do together, in units that are numbered from 0.
///
/// An `Err` or a panic of any of these functions ends the job on all ranks at once, with one line that says where.
pub struct Job<'a, 'c> {
    /// Number of units, or the most that there may be; rank 0's counts.
    pub units: u64,
    /// Units that a rank has at a time, those in work and the next ones, so that it never waits for a message; rank 0's
    /// counts. At least 2 usually. Towards the end a rank has no more than it computes at a time.
    pub in_flight: u32,
    /// Rank 0 only (`None` elsewhere): says what the units are and takes results.
    pub coordinator: Option<Coordinator<'c>>,
    /// All ranks, also rank 0: computes a unit from its number and description. Called on threads of its own.
    pub compute: Compute<'a>,
    /// How many units of this rank are computed at the same time, usually 1 or 2.
    pub threads: u32,
}

/// Rank 0's side of a job.
pub struct Coordinator<'a> {
    /// What a unit is. In the order of units, a few ahead of those that are handed out, on a thread of its own, so it may
    /// wait. `None`: there are no more, whatever [`Job::units`] says.
    pub describe: &'a mut (dyn FnMut(u64) -> Result<Option<Vec<u8>>, String> + Send),
    /// Takes a result, each once, on a thread of its own.
    pub collect: &'a mut (dyn FnMut(u64, Vec<u8>) -> Result<(), String> + Send),
    /// Whether results are collected in the order of units, and not as they come.
    pub in_order: bool,
    /// Now and then, at most ten times a second, and at the end.
    pub progress: &'a mut dyn FnMut(&JobProgress),
    /// When raised, nothing more is handed out; what was is computed and collected, and [`Report::complete`] is false.
    pub cancel: &'a AtomicBool,
}

/// How far a job is.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JobProgress {
    /// Units whose results have come.
    pub units_done: u64,
    /// Units whose results were collected.
    pub units_collected: u64,
    /// How many units the job has.
    pub units_total: u64,
    /// Bytes of descriptions and results that went between rank 0 and others.
    pub bytes_moved: u64,
    /// Time since rank 0 began the job.
    pub elapsed: Duration,
    /// What each rank did, by its number.
    pub ranks: Vec<RankProgress>,
}

/// What a rank has done.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RankProgress {
    /// Units whose results have come.
    pub units_done: u64,
    /// Units that it has now, in work or next.
    pub in_flight: u64,
    /// The sum of the times that its units took.
    pub seconds_computing: f64,
    /// How many units the rank computes at the same time; 0 before it has come to the job.
    pub threads: u32,
    /// Bytes of the results that the rank has sent.
    pub result_bytes: u64,
}

/// What a job was. The same on all ranks.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Whether all units were computed and collected; not so where the job was cancelled before.
    pub complete: bool,
    /// Units that were computed and collected: these are the first ones.
    pub units_done: u64,
    /// How many units the job has.
    pub units_total: u64,
    /// Bytes of descriptions and results that went between rank 0 and others.
    pub bytes_moved: u64,
    /// Time from when rank 0 began the job until it had collected the last result.
    pub elapsed: Duration,
    /// What each rank did, by its number.
    pub ranks: Vec<RankProgress>,
}

impl Report {
    pub(crate) fn new(progress: JobProgress) -> Report {
        let JobProgress { units_collected, units_total, bytes_moved, elapsed, ranks, .. } = progress;
        let complete = units_collected == units_total;
        Report { complete, units_done: units_collected, units_total, bytes_moved, elapsed, ranks }
    }

    pub(crate) fn to_bytes(&self) -> Vec<u8> {
        let head = [u64::from(self.complete), self.units_done, self.units_total, self.bytes_moved];
        let times = [self.elapsed.as_nanos() as u64];
        let ranks = self.ranks.iter().flat_map(|rank| {
            let seconds = rank.seconds_computing.to_bits();
            [rank.units_done, rank.in_flight, seconds, rank.threads.into(), rank.result_bytes]
        });
        head.into_iter().chain(times).chain(ranks).flat_map(u64::to_le_bytes).collect()
    }

    /// `None` where these are not a report's bytes.
    pub(crate) fn from_bytes(bytes: &[u8]) -> Option<Report> {
        let numbers: Vec<u64> = bytes.as_chunks().0.iter().map(|word| u64::from_le_bytes(*word)).collect();
        let (head, ranks) = numbers.split_first_chunk::<5>()?;
        let ranks = ranks.as_chunks::<5>().0.iter().map(|rank| RankProgress {
            units_done: rank[0],
            in_flight: rank[1],
            seconds_computing: f64::from_bits(rank[2]),
            threads: rank[3] as u32,
            result_bytes: rank[4],
        });
        Some(Report {
            complete: head[0] == 1,
            units_done: head[1],
            units_total: head[2],
            bytes_moved: head[3],
            elapsed: Duration::from_nanos(head[4]),
            ranks: ranks.collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reports_come_back_as_they_were() {
        let rank =
            RankProgress { units_done: 3, in_flight: 1, seconds_computing: 0.1, threads: 2, result_bytes: 9 };
        let report = Report {
            complete: true,
            units_done: 5,
            units_total: 5,
            bytes_moved: 7,
            elapsed: Duration::from_millis(1500),
            ranks: vec![rank, RankProgress::default()],
        };
        assert_eq!(Report::from_bytes(&report.to_bytes()), Some(report));
        assert_eq!(Report::from_bytes(&[1, 2, 3]), None);
    }
}
