//! A file to measure with: a wavy grid of a million triangles, written as exporters do.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// Vertices along a side; 2 * 707 * 707 triangles are 999,698.
const SIDE: u32 = 708;

pub fn write(path: &Path) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(1 << 20, File::create(path)?);
    writeln!(out, "# a wavy grid\no grid")?;
    let last = f64::from(SIDE - 1);
    let places =
        || (0..SIDE).flat_map(|j| (0..SIDE).map(move |i| (f64::from(i) / last, f64::from(j) / last)));
    for (u, v) in places() {
        let height = 0.05 * (20.0 * u).sin() * (15.0 * v).cos();
        writeln!(out, "v {:.6} {height:.6} {:.6}", 10.0 * u - 5.0, 10.0 * v - 5.0)?;
    }
    for (u, v) in places() {
        writeln!(out, "vt {u:.6} {v:.6}")?;
    }
    for (u, v) in places() {
        let (x, z) =
            (-0.1 * (20.0 * u).cos() * (15.0 * v).cos(), 0.075 * (20.0 * u).sin() * (15.0 * v).sin());
        let length = (x * x + 1.0 + z * z).sqrt();
        writeln!(out, "vn {:.4} {:.4} {:.4}", x / length, 1.0 / length, z / length)?;
    }
    for j in 0..SIDE - 1 {
        for i in 0..SIDE - 1 {
            let a = j * SIDE + i + 1;
            let [b, c, d] = [a + 1, a + SIDE + 1, a + SIDE];
            writeln!(out, "f {a}/{a}/{a} {d}/{d}/{d} {c}/{c}/{c}\nf {a}/{a}/{a} {c}/{c}/{c} {b}/{b}/{b}")?;
        }
    }
    out.flush()
}
