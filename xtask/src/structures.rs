//! `structures`: the tables in docs/accel-speed.md, between their markers: every structure and every builder on five
//! scenes, and the octree beside PG1's.
//!
//! Everything is measured by the release build of the program, one after the other, on one thread; it takes some ten
//! minutes and wants a quiet machine. `--quick` makes the picture of the comparison with PG1 smaller.

use crate::{build_program, root};
use anyhow::{Context, Result, bail, ensure};
use serde_json::Value;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

const PAGE: &str = "docs/accel-speed.md";

/// Name and file, of the scenes' folder.
const SCENES: [(&str, &str); 5] = [
    ("Cornell box", "cornell-box-pg1/CornellBox-Sphere.obj"),
    ("bunny", "bunny/bunny-watertight.obj"),
    ("sponza", "sponza-dabrovic/sponza.obj"),
    ("conference", "conference/conference.obj"),
    ("dragon", "dragon/dragon_vrip.ply"),
];

pub(crate) fn run(arguments: &[String]) -> Result<()> {
    let quick = arguments.first().is_some_and(|a| a == "--quick");
    let scenes = match &arguments[usize::from(quick)..] {
        [] => root().join("../shared/scenes"),
        [folder] => PathBuf::from(folder),
        _ => bail!("usage: cargo xtask structures [--quick] [SCENES_DIR]"),
    };
    let program = Program { path: build_program()? };
    let mut page = fs::read_to_string(root().join(PAGE)).context(PAGE)?;
    let machine = format!(
        "Measured on {} by `cargo xtask structures{}`.\n",
        machine(),
        if quick { " --quick" } else { "" }
    );
    for (section, choice) in [("structures", "all"), ("builders", "builders")] {
        let mut tables = machine.clone();
        for (name, file) in SCENES {
            eprintln!("{section}: {name}");
            let path = scenes.join(file);
            let rows = program.json(&["info", "--accel", choice, "--threads", "1", "--json"], &path)?;
            write!(tables, "\n{}", table(name, &rows)?)?;
        }
        page = with_section(&page, section, &tables)?;
    }
    eprintln!("octrees");
    let size = if quick { 200 } else { 800 };
    let octrees = program.octrees(&scenes.join(SCENES[0].1), size)?;
    page = with_section(&page, "pg1", &format!("{machine}\n{octrees}"))?;
    fs::write(root().join(PAGE), page).context(PAGE)
}

/// The release build.
struct Program {
    path: PathBuf,
}

impl Program {
    fn json(&self, arguments: &[&str], scene: &Path) -> Result<Value> {
        let output = Command::new(&self.path)
            .args(arguments)
            .arg(scene)
            .output()
            .with_context(|| format!("cannot run {}", self.path.display()))?;
        let errors = String::from_utf8_lossy(&output.stderr);
        ensure!(output.status.success(), "{} {}: {errors}", arguments.join(" "), scene.display());
        Ok(serde_json::from_slice(&output.stdout)?)
    }

    /// PG1's picture through both octrees: what is counted, and the median of three times each, taken in turns.
    fn octrees(&self, scene: &Path, size: u32) -> Result<String> {
        let picture = std::env::temp_dir().join(format!("eosphor-structures-{}.ppm", std::process::id()));
        let picture = picture.to_str().context("the temporary folder has an odd name")?;
        let size_flag = format!("{size}x{size}");
        let render = |accel: &str, flags: &[&str]| -> Result<Value> {
            let usual = ["render", "--preset", "pg1", "--size", &size_flag, "-q", "--json", "-o", picture];
            self.json(&[&usual[..], &["--accel", accel], flags].concat(), scene)
        };
        let accels = ["octree", "octree-parametric"];
        let counted = [render(accels[0], &["--stats"])?, render(accels[1], &["--stats"])?];
        let mut seconds = [Vec::new(), Vec::new()];
        for _ in 0..3 {
            for (accel, seconds) in accels.iter().zip(&mut seconds) {
                seconds.push(number(&render(accel, &["--threads", "1"])?, "/seconds/render_cpu")?);
            }
        }
        fs::remove_file(picture)?;
        let seconds = seconds.map(|mut s| {
            s.sort_by(f64::total_cmp);
            s[1]
        });
        let mut text = format!(
            "| {size} × {size} pixels | PG1's octree | `octree` | `octree-parametric` |\n|---|---:|---:|---:|\n"
        );
        let mut row = |title: &str, pg1: &str, of: &dyn Fn(&Value) -> Result<String>| -> Result<()> {
            writeln!(text, "| {title} | {pg1} | {} | {} |", of(&counted[0])?, of(&counted[1])?)?;
            Ok(())
        };
        let pixels = (size * size) as f64;
        let plain = |pointer: &'static str| move |v: &Value| Ok(grouped(number(v, pointer)?));
        let fixed = |pointer: &'static str| move |v: &Value| Ok(format!("{:.2}", number(v, pointer)?));
        let a_pixel =
            |pointer: &'static str| move |v: &Value| Ok(format!("{:.1}", number(v, pointer)? / pixels));
        row("nodes", "1,584", &plain("/hierarchy/nodes"))?;
        row("leaves", "1,300", &plain("/hierarchy/leaves"))?;
        row("mean depth of a leaf", "5.22", &fixed("/hierarchy/mean_leaf_depth"))?;
        row("triangles a leaf, mean", "7.03", &fixed("/hierarchy/mean_leaf_primitives"))?;
        row("triangles a leaf, most", "34", &plain("/hierarchy/max_leaf_primitives"))?;
        row("rays a pixel", "182.1", &fixed("/rays_per_pixel"))?;
        row("nodes searched a pixel", "1,779", &a_pixel("/rays/nodes_visited"))?;
        row("tests a pixel", "4,395", &a_pixel("/rays/primitive_tests"))?;
        row("nodes searched a ray", "9.8", &fixed("/work_per_ray/nodes"))?;
        row("tests a ray", "24.1", &fixed("/work_per_ray/tests"))?;
        let [basic, parametric] = seconds;
        writeln!(text, "| the picture, CPU seconds | – | {basic:.2} | {parametric:.2} |")?;
        writeln!(
            text,
            "\nThe parametric walk is {:.2} times as fast, the whole picture taken.",
            basic / parametric
        )?;
        Ok(text)
    }
}

/// One scene's rows, the fastest first.
fn table(name: &str, rows: &Value) -> Result<String> {
    let mut rows: Vec<&Value> = rows.as_array().context("rows")?.iter().collect();
    let speed = |row: &Value| number(row, "/camera_rays/mrays_per_second").unwrap_or(0.0);
    rows.sort_by(|a, b| speed(b).total_cmp(&speed(a)));
    let primitives = number(rows[0], "/statistics/primitives")?;
    let mut text = format!(
        "| {name}, {} primitives | build ms | MB | nodes | tests/ray | camera Mrays/s | diffuse Mrays/s |\n\
         |---|---:|---:|---:|---:|---:|---:|\n",
        grouped(primitives)
    );
    for row in rows {
        let title = row["accel"].as_str().context("accel")?;
        let builder = row["builder"].as_str().map_or(String::new(), |b| format!(", {b}"));
        writeln!(
            text,
            "| `{title}`{builder} | {:.1} | {:.2} | {} | {:.2} | {} | {} |",
            number(row, "/statistics/build_seconds")? * 1e3,
            number(row, "/statistics/bytes")? * 1e-6,
            grouped(number(row, "/statistics/nodes")?),
            number(row, "/camera_rays/tests_a_ray")?,
            rate(speed(row)),
            rate(number(row, "/camera_rays/diffuse_mrays_per_second")?),
        )?;
    }
    Ok(text)
}

fn number(value: &Value, pointer: &str) -> Result<f64> {
    value.pointer(pointer).and_then(Value::as_f64).with_context(|| format!("no number {pointer}"))
}

/// Three digits at least; nothing where not one ray was done in time.
fn rate(x: f64) -> String {
    if x == 0.0 {
        return "–".into();
    }
    let digits = if x >= 1.0 || x <= 0.0 { 2 } else { (2.0 - x.log10().floor()) as usize };
    format!("{x:.digits$}")
}

/// A whole number with commas.
fn grouped(number: f64) -> String {
    let digits = format!("{number:.0}");
    let mut text = String::new();
    for (k, digit) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// The text with what is between the markers of a section replaced.
fn with_section(text: &str, section: &str, new: &str) -> Result<String> {
    let (begin, end) = (format!("<!-- {section}: "), format!("<!-- end of {section} -->"));
    let begin = text.find(&begin).with_context(|| format!("{PAGE} has no marker of {section}"))?;
    let body = begin + text[begin..].find('\n').context("a marker has a line of its own")? + 1;
    let end = body + text[body..].find(&end).with_context(|| format!("{PAGE}: {section} has no end"))?;
    Ok(format!("{}\n{}\n{}", &text[..body], new.trim_end(), &text[end..]))
}

/// The processor's name and the system.
fn machine() -> String {
    let info = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = info.lines().find_map(|line| line.strip_prefix("model name")?.split_once(": "));
    let name = name.map_or("an unknown processor", |(_, name)| name);
    format!("one thread of {name} ({})", std::env::consts::OS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_section_is_replaced_and_the_rest_kept() {
        let text = "a\n<!-- x: made by -->\nold\n<!-- end of x -->\nb\n";
        let once = with_section(text, "x", "new\n").unwrap();
        assert_eq!(once, "a\n<!-- x: made by -->\n\nnew\n<!-- end of x -->\nb\n");
        assert_eq!(with_section(&once, "x", "new").unwrap(), once);
        assert!(with_section(text, "y", "").is_err());
    }

    #[test]
    fn numbers_have_commas() {
        assert_eq!([12.0, 1234.0, 1_234_567.0].map(grouped), ["12", "1,234", "1,234,567"]);
    }
}
