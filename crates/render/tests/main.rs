//! The tests of whole pictures, in one program: what they trace with is compiled and linked once.

mod adversarial;
mod closed_form;
mod doubles;
mod fallback;
mod features;
mod identity;
mod light_rays;
mod locality;
mod moving_vertices;
mod regions;
mod schedulers;
mod statistics;

// Shapes, and rays in double precision: the truth of accel's tests too.
#[path = "../../accel/tests/truth/double.rs"]
mod double;
#[path = "../../accel/tests/truth/random.rs"]
#[allow(dead_code, reason = "every test binary takes what it needs")]
mod random;
#[path = "../../accel/tests/truth/shapes.rs"]
#[allow(dead_code, reason = "every test binary takes what it needs")]
mod shapes;
#[path = "../../accel/tests/truth/vector.rs"]
#[allow(dead_code, reason = "every test binary takes what it needs")]
mod vector;

// Every kind of surface, as the GPU's tests have them.
#[path = "../../cuda/tests/common/surfaces.rs"]
mod surfaces;
