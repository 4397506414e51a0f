//! Queries against truth from outside: integers where rays meet edges and vertices, double precision elsewhere.
//!
//! `EOSPHOR_TEST_RAYS` asks for other than the usual number of rays: 1e8, say.

#[allow(dead_code, reason = "other tests share it")]
mod double;
mod dyadic;
mod edges;
mod far;
#[allow(dead_code, reason = "other tests share it")]
mod random;
mod shapes;
#[allow(dead_code, reason = "other tests share it")]
mod vector;
