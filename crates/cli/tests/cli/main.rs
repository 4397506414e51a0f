//! The real program, from outside: exit codes, messages, files.

mod alpha;
mod animation;
mod bench;
mod cluster;
mod compare;
mod course;
#[cfg(unix)]
mod inputs;
mod lights;
mod output;
mod outputs;
mod place;
mod region;
mod render;
mod requests;
#[cfg(unix)]
mod resume;
mod schema;
mod statistics;
#[cfg(unix)]
mod streams;
mod textures;
