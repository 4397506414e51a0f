//! `eosphor schema`.

use crate::arguments::SchemaFlags;
use crate::failure::Failure;
use crate::streams;
use eosphor::{scene_reference, scene_schema};

pub(crate) fn schema(flags: &SchemaFlags) -> Result<(), Failure> {
    streams::result(&if flags.markdown { scene_reference() } else { scene_schema() })
}
