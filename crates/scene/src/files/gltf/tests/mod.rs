//! Known answers of small files.
