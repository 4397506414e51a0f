//! The tests of whole surfaces, in one program.

mod dielectrics;
mod shading_normals;
