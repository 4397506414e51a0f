#![no_main]
// Pictures are told by their contents, those without a mark by their names.
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let (first, picture) = bytes.split_first().unwrap_or((&0, &[]));
    let name = ["t.png", "t.jpg", "t.hdr", "t.exr", "t.data", "t.tga", "t.bmp", "t.ppm"][*first as usize % 8];
    let mtl = format!("newmtl red\nmap_Kd {name}\n");
    let files = [("m.mtl", mtl.as_bytes()), (name, picture)];
    eosphor_fuzz::load_files("a.obj", &files);
});
