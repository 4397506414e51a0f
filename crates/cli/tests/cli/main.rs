//! The real program, from outside: exit codes, messages, files.

mod compare;
mod place;
mod render;
#[cfg(unix)]
mod streams;
