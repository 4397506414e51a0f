//! Tests of viewers.

mod page;
mod shown;
mod viewer;
