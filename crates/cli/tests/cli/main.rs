//! The real program, from outside: exit codes, messages, files.

mod animation;
mod bench;
mod cluster;
mod compare;
mod course;
#[cfg(unix)]
mod inputs;
mod output;
mod place;
mod render;
mod requests;
#[cfg(unix)]
mod resume;
mod schema;
mod statistics;
#[cfg(unix)]
mod streams;
