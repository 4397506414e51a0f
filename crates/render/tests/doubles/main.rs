//! Pictures are those of a tracer of double precision: at any size, far from the origin, and on grounds of any size.
//!
//! `EOSPHOR_TEST_RAYS` asks for other than the usual number of rays in closed bodies (1e8, say), `EOSPHOR_TEST_OBJ=file.obj`
//! for another body on the grounds.

#[path = "../../../accel/tests/truth/double.rs"]
mod double;
#[path = "../../../accel/tests/truth/random.rs"]
#[allow(dead_code, reason = "every test binary takes what it needs")]
mod random;
#[path = "../../../accel/tests/truth/shapes.rs"]
#[allow(dead_code, reason = "every test binary takes what it needs")]
mod shapes;
#[path = "../../../accel/tests/truth/vector.rs"]
#[allow(dead_code, reason = "every test binary takes what it needs")]
mod vector;

mod bodies;
mod boxes;
mod ground;
mod judge;
mod picture;
mod scale;
mod shade;
