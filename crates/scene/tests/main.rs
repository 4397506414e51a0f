//! The tests of whole files, in one program.

mod example_scenes;
mod gltf_files;
mod obj_awkward;
mod pg1_config;
mod ply_files;
mod posed_files;
mod real_files;
mod support;
