//! What the kernels of a picture take, one by one: measured where it is asked for, since each is waited for then.

use crate::queue_room::{Queued, control_at};
use cudarc::driver::sys::CUevent_flags;
use cudarc::driver::{CudaStream, DriverError};
use eosphor_core::device::{
    FRESH_NODE_ROWS, HIT_ROWS, LIT_ROWS, NODE_ROWS, PATH_ROWS, PROGRESS_ROWS, PathControl, PathLaunch,
    REQUEST_ROWS, Row,
};
use eosphor_core::math::Vec3;
use eosphor_core::sums::ExactSum;
use eosphor_render::StageWork;
use std::sync::{Arc, Mutex, PoisonError};

/// Threads of a warp.
const WARP: u64 = 32;

/// What a kernel of queues does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stage {
    Prepare,
    Begin,
    Generate,
    FindHits,
    /// Of what is listed from the first on.
    ShadeFirst,
    /// Of what is listed from the last on.
    ShadeLast,
    Ask,
    See,
    Cross,
    Sum,
    Settle,
}

impl Stage {
    /// How many items a launch had, by the control that it has left.
    fn items(self, launch: &PathLaunch, control: &PathControl) -> u64 {
        let points = (control.appended >> 32) as u32;
        let shadow_rays = if launch.is_of_trees() { launch.lights.rays(points) } else { points };
        u64::from(match self {
            Stage::Prepare => launch.slots,
            Stage::Begin => 1,
            Stage::Generate => control.samples - control.samples_left - control.first_sample,
            Stage::FindHits => control.paths,
            Stage::ShadeFirst => control.sorted as u32,
            Stage::ShadeLast => (control.sorted >> 32) as u32,
            Stage::Ask | Stage::See => shadow_rays,
            Stage::Cross => control.hidden as u32,
            Stage::Sum => points,
            // Its items are pixels.
            Stage::Settle => 0,
        })
    }

    /// Bytes of queues and sums that an item is read from and written to, at most.
    fn bytes(self, of: Queued, launch: &PathLaunch) -> u64 {
        let rows = |rows: usize| (rows * size_of::<Row>()) as u64;
        let (number, sum) = (size_of::<u32>() as u64, size_of::<ExactSum>() as u64);
        // A shadow ray of trees: its light, its weights, and its direction or what comes through.
        let light = number + size_of::<[f32; 2]>() as u64 + rows(1);
        match (self, of) {
            (Stage::Prepare | Stage::Begin, _) => number,
            (Stage::Settle, _) => 4 * sum + size_of::<Vec3>() as u64,
            (Stage::Generate, Queued::Paths) => rows(PATH_ROWS),
            (Stage::FindHits, Queued::Paths) => rows(3 + HIT_ROWS) + number,
            (Stage::ShadeFirst | Stage::ShadeLast, Queued::Paths) => {
                number + rows(2 * PATH_ROWS + HIT_ROWS + REQUEST_ROWS) + 2 * sum
            }
            (Stage::See | Stage::Cross, Queued::Paths) => number + rows(REQUEST_ROWS) + 2 * sum,
            (Stage::Generate, Queued::Trees) => rows(FRESH_NODE_ROWS) + 2 * number,
            (Stage::FindHits, Queued::Trees) => rows(NODE_ROWS) + 3 * number + 2 * sum,
            (Stage::ShadeFirst, Queued::Trees) => rows(NODE_ROWS + LIT_ROWS) + 2 * number + 2 * sum,
            (Stage::ShadeLast, Queued::Trees) => {
                rows(NODE_ROWS + LIT_ROWS + 3 * FRESH_NODE_ROWS) + 8 * number + 2 * sum
            }
            (Stage::Ask, Queued::Trees) => rows(LIT_ROWS) + light,
            (Stage::See | Stage::Cross, Queued::Trees) => rows(4 + 1) + light + number,
            (Stage::Sum, Queued::Trees) => {
                rows(LIT_ROWS + 2 * PROGRESS_ROWS) + u64::from(launch.lights.window) * light + 2 * sum
            }
            (Stage::Ask | Stage::Sum, Queued::Paths) => 0,
        }
    }
}

/// What launches took, by kernel, in the order of their first launches.
#[derive(Default)]
pub(crate) struct Stages(Mutex<Vec<StageWork>>);

impl Stages {
    /// Starts a kernel with this launch, for a band of so many pixels, and waits for it.
    pub(crate) fn measure(
        &self,
        (kernel, stage, of): (&'static str, Stage, Queued),
        stream: &Arc<CudaStream>,
        (launch, pixels): (&PathLaunch, u32),
        start: impl FnOnce() -> Result<(), DriverError>,
    ) -> Result<(), DriverError> {
        let event = || stream.record_event(Some(CUevent_flags::CU_EVENT_DEFAULT));
        let before = event()?;
        start()?;
        let after = event()?;
        after.synchronize()?;
        let milliseconds = f64::from(before.elapsed_ms(&after)?);
        let items = match stage {
            Stage::Settle => pixels.into(),
            // SAFETY: a launch's control is on the device.
            _ => stage.items(launch, &unsafe { control_at(stream, launch.control as u64) }?),
        };
        self.add(StageWork {
            kernel,
            launches: 1,
            milliseconds,
            items,
            lanes: items.div_ceil(WARP) * WARP,
            bytes: items * stage.bytes(of, launch),
        });
        Ok(())
    }

    fn add(&self, work: StageWork) {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        match all.iter_mut().find(|other| other.kernel == work.kernel) {
            Some(other) => *other += work,
            None => all.push(work),
        }
    }

    /// All of it.
    pub(crate) fn into_all(self) -> Vec<StageWork> {
        self.0.into_inner().unwrap_or_else(PoisonError::into_inner)
    }
}
