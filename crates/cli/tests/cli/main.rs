//! The real program, from outside: exit codes, messages, files.

mod alpha;
mod animation;
mod base;
mod bench;
mod cluster;
mod compare;
mod course;
mod damage;
mod folders;
mod gltf;
mod help;
mod hostile;
#[cfg(unix)]
mod inputs;
mod lab;
mod lights;
#[cfg(target_os = "linux")]
mod names;
mod output;
mod outputs;
mod place;
mod region;
mod render;
mod requests;
#[cfg(unix)]
mod resume;
mod schema;
mod sky;
mod statistics;
#[cfg(unix)]
mod streams;
mod textures;
mod usage;
