//! `cargo xtask albedo`: makes the tables of what rough surfaces lose by single scattering, in double precision.
//!
//! Coordinates of the tables are those of `crates/core/src/bsdf/albedo.rs`, which reads them; its tests compute entries again by
//! another way.

mod microfacets;
mod turned;

use anyhow::Context;
use microfacets::{Loss, glass_loss, mirror_loss};
use std::fmt::Write;

/// Nodes over the cosine and the roughness, of mirrors.
const MIRROR: [usize; 2] = [48, 41];
/// The same of glass where the index beyond the surface is denser, and over the index.
const DENSER: [usize; 3] = [56, 41, 49];
/// Where it is less dense. The number over the cosine is odd, so that the critical angle has a node.
const THINNER: [usize; 3] = [79, 41, 85];
/// Steps over microfacets away from the mean and about the normal, for nodes of glass and for what lies between them. With 48 about
/// the normal, what of leaving light is reflected totally was off by up to 0.002.
const NODE_STEPS: [usize; 2] = [96, 144];
const BETWEEN_STEPS: [usize; 2] = [64, 96];
/// Where light comes from above, all facets of one turn are alike, and total reflection begins at a ring: more than this cosine is
/// above, and has twice as many steps of the first kind and half as many of the second.
const ABOVE: f64 = 0.9;
/// A cosine is measured against alpha times this: what is lost at grazing angles is a function of their ratio.
const CORNER: f64 = 4.0;
/// Tables of glass go to the indices 5/2 and 2/5.
const LAST_CONTRAST: f64 = 3.0 / 7.0;

pub fn run(_: &[String]) -> anyhow::Result<()> {
    let folder = crate::root().join("crates/core/src/bsdf");
    let rows = mirror_rows();
    let files: [(&str, &dyn Fn() -> String); 3] = [
        ("mirror_tables.rs", &|| mirror_tables(&rows)),
        ("turned_tables.rs", &|| turned::tables(&rows)),
        ("glass_tables.rs", &glass_tables),
    ];
    for (name, text) in files {
        let path = folder.join(name);
        std::fs::write(&path, text()).with_context(|| format!("cannot write {}", path.display()))?;
        println!("wrote {}", path.display());
    }
    Ok(())
}

/// Node `i` of `count`, 0 to 1.
fn node(i: usize, count: usize) -> f64 {
    i as f64 / (count - 1) as f64
}

fn alpha_of(row: usize, count: usize) -> f64 {
    node(row, count).powi(2)
}

/// The cosine at a coordinate `sqrt(cos (1 + k) / (cos + k))` with `k` = [`CORNER`] alpha.
fn cosine_of(coordinate: f64, alpha: f64) -> f64 {
    let (k, square) = (CORNER * alpha, coordinate * coordinate);
    (square * k / (1.0 + k - square)).clamp(1e-6, 1.0)
}

/// The cosine at a coordinate which is 1/2 at the critical angle, and close to which it changes slowly there and at 0.
fn cosine_about_critical(coordinate: f64, eta: f64) -> f64 {
    let critical = (1.0 - eta * eta).max(0.0).sqrt();
    let x = 2.0 * coordinate;
    let cosine = if x < 0.5 {
        2.0 * x * x * critical
    } else if x < 1.0 {
        (1.0 - 2.0 * (1.0 - x).powi(2)) * critical
    } else {
        critical + (x - 1.0).powi(2) * (1.0 - critical)
    };
    cosine.clamp(1e-6, 1.0)
}

fn coordinate_of(cosine: f64, alpha: f64) -> f64 {
    let k = CORNER * alpha;
    (cosine * (1.0 + k) / (cosine + k)).sqrt()
}

/// What a row of a mirror's tables has: at each cosine the loss, and the part of `(1 - cos)^5` that goes beyond a smooth
/// mirror's.
fn mirror_row(alpha: f64) -> Vec<Loss> {
    let smooth = |cosine: f64| (1.0 - cosine).powi(5);
    let at = |i| {
        let cosine = cosine_of(node(i, MIRROR[0]), alpha);
        let exact = mirror_loss(cosine, alpha);
        // As the file will have it, so that means are those of what is read.
        let lost = rounded(exact.lost);
        Loss { lost, grazing: rounded(exact.grazing - (1.0 - lost) * smooth(cosine)) }
    };
    (0..MIRROR[0]).map(at).collect()
}

/// What core reads at a cosine from a row: what is lost, and all that is reflected of `(1 - cos)^5`.
fn read(row: &[Loss], alpha: f64, cosine: f64) -> Loss {
    // A smooth mirror's cosines are all at the last node: nothing is lost.
    let x = coordinate_of(cosine, alpha) * (row.len() - 1) as f64;
    let first = (x as usize).min(row.len() - 2);
    let between =
        |of: fn(&Loss) -> f64| of(&row[first]) + (of(&row[first + 1]) - of(&row[first])) * (x - first as f64);
    let lost = between(|loss| loss.lost);
    Loss { lost, grazing: between(|loss| loss.grazing) + (1.0 - lost) * (1.0 - cosine).powi(5) }
}

/// Means over the hemisphere, weighted by the cosine, of what core interpolates from a row.
fn mean(row: &[Loss], alpha: f64) -> Loss {
    const STEPS: usize = 20_000;
    let mut sum = Loss { lost: 0.0, grazing: 0.0 };
    for i in 0..STEPS {
        // Steps are short near the horizon, where the row changes fast.
        let s = (i as f64 + 0.5) / STEPS as f64;
        let (cosine, weight) = (s * s, 2.0 * s / STEPS as f64);
        let here = read(row, alpha, cosine);
        sum.lost += 2.0 * cosine * weight * here.lost;
        sum.grazing += 2.0 * cosine * weight * here.grazing;
    }
    sum
}

fn number(x: f64) -> String {
    format!("{:e}", rounded(x))
}

/// To the digits that a table has.
fn rounded(x: f64) -> f64 {
    format!("{x:.6e}").parse().unwrap_or(x)
}

/// All rows of a mirror's tables, over its roughness.
fn mirror_rows() -> Vec<Vec<Loss>> {
    let smooth = vec![Loss { lost: 0.0, grazing: 0.0 }; MIRROR[0]];
    let rough = (1..MIRROR[1]).map(|i| mirror_row(alpha_of(i, MIRROR[1])));
    std::iter::once(smooth).chain(rough).collect()
}

fn mirror_tables(rows: &[Vec<Loss>]) -> String {
    let mut means = vec![Loss { lost: 0.0, grazing: 1.0 / 21.0 }];
    means.extend((1..MIRROR[1]).map(|i| mean(&rows[i], alpha_of(i, MIRROR[1]))));
    let mut text = header("What mirrors of microfacets lose by single scattering");
    let [columns, count] = MIRROR;
    writeln!(text, "/// Nodes over the cosine.\npub const COSINES: usize = {columns};").unwrap();
    writeln!(text, "/// Nodes over the roughness.\npub const ROUGHNESSES: usize = {count};").unwrap();
    type Part = fn(&Loss) -> f64;
    let parts: [(&str, &str, Part); 2] = [
        (
            "LOST",
            "The part of light that one reflection does not return, for each roughness over the cosine",
            |loss| loss.lost,
        ),
        ("GRAZING", "What is reflected of `(1 - cos)^5` beyond a smooth mirror's part", |loss| loss.grazing),
    ];
    for (name, what, part) in parts {
        let all: String = rows.iter().map(|row| array(row.iter().map(|loss| number(part(loss))))).collect();
        writeln!(text, "\n/// {what}.\n#[rustfmt::skip]").unwrap();
        writeln!(text, "pub static {name}: [[f32; COSINES]; ROUGHNESSES] = [\n{}\n];", lines(&all)).unwrap();
    }
    let parts: [(&str, &str, Part); 2] = [
        (
            "MEAN_LOST",
            "Mean of the lost part over the hemisphere, weighted by the cosine, for each roughness",
            |loss| loss.lost,
        ),
        ("MEAN_GRAZING", "The same mean of all that is reflected of `(1 - cos)^5`", |loss| loss.grazing),
    ];
    for (name, what, part) in parts {
        writeln!(text, "\n/// {what}.\n#[rustfmt::skip]\npub static {name}: [f32; ROUGHNESSES] = [").unwrap();
        writeln!(
            text,
            "{}\n];",
            lines(&means.iter().map(|loss| number(part(loss)) + ",").collect::<String>())
        )
        .unwrap();
    }
    text
}

/// The index beyond the surface at a coordinate: the contrast `|eta - 1| / (eta + 1)` grows with the square of it, at first slowly.
fn index_of(coordinate: f64, is_denser: bool) -> f64 {
    let root = if coordinate < 1.0 / 3.0 { 0.375 * coordinate } else { (21.0 * coordinate - 5.0) / 16.0 };
    let contrast = (LAST_CONTRAST * root.powi(2)).max(1e-10);
    let eta = (1.0 + contrast) / (1.0 - contrast);
    if is_denser { eta } else { 1.0 / eta }
}

/// What a table of glass approximates, at coordinates of the cosine, the roughness and the index.
fn glass_at([x, roughness, index]: [f64; 3], is_denser: bool, steps: [usize; 2]) -> f64 {
    let (alpha, eta) = (roughness * roughness, index_of(index, is_denser));
    if alpha == 0.0 {
        return 0.0;
    }
    let cosine = if is_denser { cosine_of(x, alpha) } else { cosine_about_critical(x, eta) };
    let steps = if cosine > ABOVE { [2 * steps[0], steps[1] / 2] } else { steps };
    let [glass, mirror] = glass_loss(cosine, alpha, eta, steps);
    // Beyond the critical angle glass is a mirror: the difference has no details there.
    if is_denser { glass } else { glass - mirror }
}

/// Values for all places of a grid, the first coordinate fastest; `at` has their coordinates from the numbers.
fn grid(counts: [usize; 3], at: impl Fn([usize; 3]) -> f64 + Sync) -> Vec<f64> {
    let layer = |k: usize| -> Vec<f64> {
        let places = (0..counts[1]).flat_map(|j| (0..counts[0]).map(move |i| [i, j, k]));
        places.map(&at).collect()
    };
    let halves = [0..counts[2] / 2, counts[2] / 2..counts[2]];
    std::thread::scope(|scope| {
        let threads = halves.map(|half| scope.spawn(|| half.flat_map(&layer).collect::<Vec<_>>()));
        threads.into_iter().flat_map(|thread| thread.join().unwrap_or_default()).collect()
    })
}

/// The nodes of a table of glass. Between exact nodes interpolation is off to one side where the loss is curved; nodes are moved so
/// that they are off to the other side by as much as the middles of the cells around them.
fn glass_nodes(counts: [usize; 3], is_denser: bool) -> Vec<f64> {
    let coordinate = |k: usize, place: f64| place / (counts[k] - 1) as f64;
    let exact =
        grid(counts, |n| glass_at([0, 1, 2].map(|k| coordinate(k, n[k] as f64)), is_denser, NODE_STEPS));
    let number = |[i, j, k]: [usize; 3]| (k * counts[1] + j) * counts[0] + i;
    let corners = |[i, j, k]: [usize; 3]| (0..8).map(move |c| [i + c % 2, j + c / 2 % 2, k + c / 4]);
    let cells = counts.map(|count| count - 1);
    let errors = grid(cells, |n| {
        let middle = [0, 1, 2].map(|k| coordinate(k, n[k] as f64 + 0.5));
        corners(n).map(|c| exact[number(c)]).sum::<f64>() / 8.0 - glass_at(middle, is_denser, BETWEEN_STEPS)
    });
    let (mut sums, mut around) = (vec![0.0; exact.len()], vec![0.0; exact.len()]);
    for (cell, error) in errors.iter().enumerate() {
        let place = [cell % cells[0], cell / cells[0] % cells[1], cell / cells[0] / cells[1]];
        for corner in corners(place).map(number) {
            sums[corner] += error;
            around[corner] += 1.0;
        }
    }
    // Smooth glass loses nothing.
    let is_rough = |node: usize| !(node / counts[0]).is_multiple_of(counts[1]);
    let moved = |node: usize| if is_rough(node) { 0.5 * sums[node] / around[node] } else { 0.0 };
    (0..exact.len()).map(|node| exact[node] - moved(node)).collect()
}

fn glass_tables() -> String {
    let mut text = header("What rough glass of microfacets lose by single scattering");
    for (name, what, counts, is_denser) in
        [("DENSER", "denser", DENSER, true), ("THINNER", "less dense", THINNER, false)]
    {
        let [columns, rows, layers] = counts;
        let nodes = glass_nodes(counts, is_denser);
        let mut all = String::new();
        for layer in nodes.chunks(columns * rows) {
            all += "[";
            for row in layer.chunks(columns) {
                all += &array(row.iter().map(|lost| ((lost * 32768.0).round() as i16).to_string()));
            }
            all += "],";
        }
        writeln!(text, "/// The part of light that is lost where the index beyond is {what}, in 32768ths.")
            .unwrap();
        writeln!(text, "/// Over the index, the roughness and the cosine.\n#[rustfmt::skip]").unwrap();
        let exported = format!("glass_{}", name.to_lowercase());
        writeln!(text, "#[cfg_attr(target_arch = \"nvptx64\", unsafe(export_name = \"{exported}\"))]")
            .unwrap();
        writeln!(
            text,
            "pub static {name}: [[[i16; {columns}]; {rows}]; {layers}] = [\n{}\n];\n",
            lines(&all)
        )
        .unwrap();
    }
    text.truncate(text.trim_end().len());
    text + "\n"
}

fn header(what: &str) -> String {
    format!("//! {what}. Made by `cargo xtask albedo`.\n\n")
}

/// An array's elements in lines that are not too long.
fn lines(elements: &str) -> String {
    let (mut text, mut width) = (String::new(), 0);
    for element in elements.split_inclusive(',') {
        if width + element.len() > 131 {
            text.push('\n');
            width = 0;
        }
        width += element.len();
        text += element;
    }
    text
}

/// `[a,b,c],`
fn array(elements: impl Iterator<Item = String>) -> String {
    format!("[{}],", elements.map(|element| element + ",").collect::<String>())
}
