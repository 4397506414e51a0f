//! The real program, from outside: exit codes, messages, files.

mod compare;
#[cfg(unix)]
mod inputs;
mod output;
mod place;
mod render;
#[cfg(unix)]
mod streams;
