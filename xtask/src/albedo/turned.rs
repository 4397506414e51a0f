//! What a layer of microfacets does with the light that a rough base under it turns back: means of what `mirror_tables.rs` says.
//!
//! Of light at a cosine `c`, the base turns `s / t` back (`crates/core/src/bsdf/eon.rs`): over all turns about the normal this is
//! `2 / pi sine(c) sine(v) (1 / max(c, v) - 1)` to a viewer at a cosine `v`.

use super::{MIRROR, alpha_of, array, header, lines, node, number, read};
use crate::albedo::microfacets::Loss;
use std::fmt::Write;

/// Nodes over the cosine and the roughness.
const TURNED: [usize; 2] = [16, 21];
const STEPS: usize = 4000;

fn sine(cosine: f64) -> f64 {
    ((1.0 - cosine) * (1.0 + cosine)).sqrt()
}

/// Cosines, and what a step there is worth in an integral over the cosine: steps are short near the horizon, and near the normal.
fn steps() -> impl Iterator<Item = (f64, f64)> {
    (0..STEPS).map(|i| {
        let s = (i as f64 + 0.5) / STEPS as f64;
        (s * s * (3.0 - 2.0 * s), 6.0 * s * (1.0 - s) / STEPS as f64)
    })
}

/// Means of a row over the light that is turned back to a viewer at this cosine.
fn turned(row: &[Loss], alpha: f64, viewer: f64) -> Loss {
    let mut sum = Loss { lost: 0.0, grazing: 0.0 };
    let mut weights = 0.0;
    for (cosine, step) in steps() {
        let part = if cosine < viewer { cosine / viewer } else { (1.0 - cosine) / (1.0 - viewer) };
        let weight = part * sine(cosine) * step;
        let here = read(row, alpha, cosine);
        sum.lost += weight * here.lost;
        sum.grazing += weight * here.grazing;
        weights += weight;
    }
    Loss { lost: sum.lost / weights, grazing: sum.grazing / weights }
}

/// `G` of the model: all light that is turned back to a viewer.
fn all_turned(cosine: f64) -> f64 {
    let s = sine(cosine);
    s * (cosine.acos() - s * cosine) + 2.0 / 3.0 * (s / cosine * (1.0 - s.powi(3)) - s)
}

/// Means over all pairs of directions that a base turns light back between: of the lost part and of the grazing part of one of
/// them, of the product of both lost parts, of both grazing parts, and of one of each.
fn pairs(row: &[Loss], alpha: f64, nodes: &[Loss]) -> [f64; 5] {
    let (mut sums, mut weights) = ([0.0; 5], 0.0);
    for (cosine, step) in steps() {
        let weight = all_turned(cosine) * cosine * step;
        let here = read(row, alpha, cosine);
        // As core interpolates.
        let x = cosine * (nodes.len() - 1) as f64;
        let first = (x as usize).min(nodes.len() - 2);
        let between = |of: fn(&Loss) -> f64| {
            of(&nodes[first]) + (of(&nodes[first + 1]) - of(&nodes[first])) * (x - first as f64)
        };
        let (lost, grazing) = (between(|loss| loss.lost), between(|loss| loss.grazing));
        let values = [
            0.5 * (here.lost + lost),
            0.5 * (here.grazing + grazing),
            here.lost * lost,
            here.grazing * grazing,
            0.5 * (here.lost * grazing + here.grazing * lost),
        ];
        for (sum, value) in sums.iter_mut().zip(values) {
            *sum += weight * value;
        }
        weights += weight;
    }
    sums.map(|sum| sum / weights)
}

/// The file, from the rows of the mirror's tables.
pub fn tables(rows: &[Vec<Loss>]) -> String {
    let [columns, count] = TURNED;
    let stride = (MIRROR[1] - 1) / (count - 1);
    let mut nodes = Vec::new();
    let mut means = Vec::new();
    for i in 0..count {
        let (row, alpha) = (&rows[i * stride], alpha_of(i, count));
        let of_row: Vec<Loss> =
            (0..columns).map(|column| turned(row, alpha, node(column, columns))).collect();
        means.push(pairs(row, alpha, &of_row));
        nodes.push(of_row);
    }
    let mut text = header("What layers of microfacets do with light that a rough base turns back");
    writeln!(text, "/// Nodes over the cosine.\npub const COSINES: usize = {columns};").unwrap();
    writeln!(text, "/// Nodes over the roughness of the layer.\npub const ROUGHNESSES: usize = {count};")
        .unwrap();
    type Part = fn(&Loss) -> f64;
    let parts: [(&str, &str, Part); 2] = [
        ("LOST", "Mean of what one reflection loses of the light that is turned back to a viewer", |loss| {
            loss.lost
        }),
        ("GRAZING", "The same mean of all that is reflected of `(1 - cos)^5`", |loss| loss.grazing),
    ];
    for (name, what, part) in parts {
        let all: String = nodes.iter().map(|row| array(row.iter().map(|loss| number(part(loss))))).collect();
        writeln!(text, "\n/// {what}.\n#[rustfmt::skip]").unwrap();
        writeln!(text, "pub static {name}: [[f32; COSINES]; ROUGHNESSES] = [\n{}\n];", lines(&all)).unwrap();
    }
    writeln!(
        text,
        "\n/// Means over all pairs of directions: lost, grazing, lost of both, grazing of both, one of each."
    )
    .unwrap();
    let all: String = means.iter().map(|means| array(means.iter().map(|&x| number(x)))).collect();
    writeln!(text, "#[rustfmt::skip]\npub static PAIRS: [[f32; 5]; ROUGHNESSES] = [\n{}\n];", lines(&all))
        .unwrap();
    text
}
