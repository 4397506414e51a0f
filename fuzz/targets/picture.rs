#![no_main]
use eosphor_picture::output::{Format, Picture};
// What `eosphor compare` reads.
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let (first, picture) = bytes.split_first().unwrap_or((&0, &[]));
    let format = Format::ALL[*first as usize % Format::ALL.len()];
    let _ = Picture::from_bytes(picture, format);
});
