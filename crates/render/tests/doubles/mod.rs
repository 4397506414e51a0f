//! Pictures are those of a tracer of double precision: at any size, far from the origin, and on grounds of any size.
//!
//! `EOSPHOR_TEST_RAYS` asks for other than the usual number of rays in closed bodies (1e8, say), `EOSPHOR_TEST_OBJ=file.obj`
//! for another body on the grounds.

mod bodies;
mod boxes;
mod ground;
mod judge;
mod picture;
mod scale;
mod shade;
