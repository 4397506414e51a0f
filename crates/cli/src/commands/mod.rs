//! One file a subcommand.

mod bench;
mod compare;
mod completions;
mod cost;
mod course;
mod devices;
mod frames;
mod frames_work;
mod info;
mod lab;
mod merge;
mod pg1_config;
mod render;
mod scene;
mod schema;
mod still;
mod structures;
#[cfg(feature = "view")]
mod view;

pub(crate) use bench::{bench_noise, bench_rays, bench_render};
pub(crate) use compare::compare;
pub(crate) use completions::completions;
pub(crate) use course::course;
pub(crate) use devices::devices;
pub(crate) use info::info;
pub(crate) use lab::{lab_compare, lab_list, lab_report, lab_run, lab_schema};
pub(crate) use merge::merge;
pub(crate) use render::render;
pub(crate) use schema::schema;
#[cfg(feature = "view")]
pub(crate) use view::view;
