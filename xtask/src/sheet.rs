//! `sheet`: a contact sheet to be looked at: every lighting model, shadow mode, normal mode, Fresnel mode, depth of field,
//! glossy reflection and culling, and real scenes where they are at hand. `sheet --models` shows every model in the folder of
//! scenes instead, as it opens by itself: with the automatic camera, where it brings none. That folder is ../shared/scenes,
//! or what `EOSPHOR_SCENES` names.

use crate::{build_program, root};
use anyhow::{Context, Result, bail, ensure};
use font8x8::legacy::BASIC_LEGACY;
use std::fs::{self, File};
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::process::Command;

const CELL: (usize, usize) = (400, 300);
const LABEL: usize = 14;
const COLUMNS: usize = 5;

/// A label, and what `eosphor render` is told.
type Cell = (String, Vec<String>);

pub(crate) fn run(arguments: &[String]) -> Result<()> {
    let models = arguments.first().is_some_and(|a| a == "--models");
    let out = match &arguments[usize::from(models)..] {
        [] => root().join(if models { "out/models.png" } else { "out/sheet.png" }),
        [path] => PathBuf::from(path),
        _ => bail!("usage: cargo xtask sheet [--models] [OUT.png]"),
    };
    let binary = build_program()?;
    let folder = out.parent().unwrap_or(Path::new(".")).to_owned();
    fs::create_dir_all(&folder)?;
    let picture = folder.join("sheet-cell.ppm");
    let cells = if models { model_cells() } else { cells() };
    let rows = cells.len().div_ceil(COLUMNS);
    let mut sheet = Sheet::new(COLUMNS * CELL.0, rows * (CELL.1 + LABEL));
    for (number, (label, arguments)) in cells.iter().enumerate() {
        println!("{label}: eosphor render {}", arguments.join(" "));
        let (x, y) = (number % COLUMNS * CELL.0, number / COLUMNS * (CELL.1 + LABEL));
        let output = Command::new(&binary)
            .arg("render")
            .args(arguments)
            .args((!models).then_some("-q"))
            .args(["--size", &format!("{}x{}", CELL.0, CELL.1), "-o"])
            .arg(&picture)
            .current_dir(root())
            .output()
            .with_context(|| format!("cannot run {}", binary.display()))?;
        let said = String::from_utf8_lossy(&output.stderr);
        if models && !output.status.success() {
            // Some files are wrong on purpose.
            println!("    {}", said.trim_end());
            sheet.text(x + 3, y + 3, &format!("{label}: refused"));
            continue;
        }
        ensure!(output.status.success(), "{label}: {said}");
        sheet.text(x + 3, y + 3, label);
        for line in said.lines().filter(|line| models && line.contains("no camera")) {
            println!("    {line}");
        }
        sheet.paste(x, y + LABEL, &fs::read(&picture)?)?;
    }
    fs::remove_file(&picture)?;
    sheet.save(&out)?;
    println!("{}", out.display());
    Ok(())
}

fn cells() -> Vec<Cell> {
    let cornell = "builtin:cornell";
    let panes = "scenes/coloured-shadows.json";
    let lens = "scenes/depth-of-field.json";
    let glass = "scenes/glass-and-mirrors.json";
    let mut cells = Vec::new();
    let mut add = |label: &str, scene: &str, flags: &str| {
        let words = std::iter::once(scene).chain(flags.split_whitespace());
        cells.push((label.to_owned(), words.map(str::to_owned).collect()));
    };
    for model in ["distance", "diffuse", "lambert", "phong", "blinn-phong"] {
        add(&format!("lighting {model}"), lens, &format!("--aperture 0 --samples 16 --lighting {model}"));
    }
    for mode in ["none", "opaque", "coloured"] {
        add(&format!("shadows {mode}"), panes, &format!("--shadows {mode} --no-light-from-behind"));
    }
    add("light from behind", panes, "--light-from-behind");
    add("preset pg1 on builtin", cornell, "--preset pg1");
    for mode in ["exact", "schlick", "constant"] {
        add(&format!("fresnel {mode}"), glass, &format!("--fresnel {mode}"));
    }
    add("depth 0", glass, "--depth 0");
    add("depth 2", glass, "--depth 2");
    add("lens", lens, "");
    add("pin-hole", lens, "--aperture 0");
    add("lens, far focus", lens, "--focus-distance 9");
    add("ssaa 1", lens, "--aperture 0 --ssaa 1");
    add("ssaa 4", lens, "--aperture 0 --ssaa 4");
    for mode in ["flat", "smooth", "auto", "generated"] {
        add(&format!("normals {mode}"), cornell, &format!("--normals {mode}"));
    }
    add("from outside, no culling", cornell, "--eye 4,2,3 --look-at 0,0.8,0 --fov 40 --no-cull");
    add("from outside, culling", cornell, "--eye 4,2,3 --look-at 0,0.8,0 --fov 40 --cull");
    add("ambient 0", cornell, "--ambient 0");
    add("one light sample", cornell, "--light-samples 1 --samples 1");
    add("one stop less", cornell, "--exposure 0.9");
    add("linear transfer", cornell, "--transfer linear");
    real_scenes(&mut add);
    cells
}

/// Where the standard scenes are.
fn scenes() -> PathBuf {
    std::env::var_os("EOSPHOR_SCENES").map_or_else(|| PathBuf::from("../shared/scenes"), PathBuf::from)
}

/// All models, as they open by themselves.
fn model_cells() -> Vec<Cell> {
    let mut files = Vec::new();
    collect_models(&scenes(), &mut files);
    if files.is_empty() {
        println!("SKIPPED: there are no models in {}", scenes().display());
    }
    files.sort();
    let cell = |file: PathBuf| {
        let label = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        (label, vec![file.to_string_lossy().into_owned(), "--samples".into(), "4".into()])
    };
    files.into_iter().map(cell).collect()
}

fn collect_models(folder: &Path, files: &mut Vec<PathBuf>) {
    let Ok(entries) = fs::read_dir(root().join(folder)) else { return };
    for entry in entries.flatten() {
        let path = folder.join(entry.file_name());
        if entry.path().is_dir() {
            collect_models(&path, files);
        } else if path
            .extension()
            .is_some_and(|e| ["gltf", "glb", "ply", "obj"].iter().any(|name| e == *name))
        {
            files.push(path);
        }
    }
}

/// Standard scenes, where ../shared holds them.
fn real_scenes(add: &mut impl FnMut(&str, &str, &str)) {
    let scenes = scenes().to_string_lossy().into_owned();
    if !root().join(&scenes).is_dir() {
        println!("SKIPPED: the standard scenes: there is no {scenes}");
        return;
    }
    let box_camera = "--eye 0,1,4.42 --look-at 0,1,0 --fov 34.4 --samples 4";
    for (label, file, flags) in [
        ("PG1's T1", "cornell-box-pg1/CornellBox-Sphere.obj", "--preset pg1"),
        ("bunny, eos", "bunny/bunny-watertight.obj", "--preset eos --translate 2,-2,-2"),
        ("suzanne, eos", "suzanne/suzanne.obj", "--preset eos --translate 2,0,-2"),
        ("Original", "cornell-box/CornellBox-Original.obj", box_camera),
        ("Mirror", "cornell-box/CornellBox-Mirror.obj", box_camera),
        ("Glossy", "cornell-box/CornellBox-Glossy.obj", box_camera),
        ("Spot, framed", "spot/spot.obj", "--ssaa 2"),
        ("Spot, its face", "spot/spot.obj", "--ssaa 2 --eye 1.5,0.8,-3 --look-at 0,0.1,0"),
        ("sponza, framed", "sponza-dabrovic/sponza.obj", "--ssaa 2"),
        ("sponza, inside", "sponza-dabrovic/sponza.obj", "--ssaa 2 --eye -13,4,0.5 --look-at 0,5,0 --fov 75"),
        ("conference, framed", "conference/conference.obj", "--ssaa 2"),
        (
            "conference, inside",
            "conference/conference.obj",
            "--ssaa 2 --eye 1300,420,400 --look-at 200,150,-250 --fov 75",
        ),
    ] {
        add(label, &format!("{scenes}/{file}"), flags);
    }
}

/// The sheet in the making, RGB.
struct Sheet {
    width: usize,
    height: usize,
    pixels: Vec<u8>,
}

impl Sheet {
    fn new(width: usize, height: usize) -> Sheet {
        Sheet { width, height, pixels: vec![40; width * height * 3] }
    }

    fn text(&mut self, x: usize, y: usize, text: &str) {
        for (place, character) in text.chars().enumerate() {
            let glyph = BASIC_LEGACY.get(character as usize).copied().unwrap_or_default();
            for (dy, row) in glyph.iter().enumerate() {
                for dx in (0..8).filter(|dx| row >> dx & 1 == 1) {
                    let at = ((y + dy) * self.width + x + place * 8 + dx) * 3;
                    self.pixels[at..at + 3].fill(255);
                }
            }
        }
    }

    /// Pastes a binary PPM of the size of a cell.
    fn paste(&mut self, x: usize, y: usize, ppm: &[u8]) -> Result<()> {
        let size = CELL.0 * CELL.1 * 3;
        ensure!(ppm.len() > size, "the picture is too small");
        let rows = ppm[ppm.len() - size..].chunks_exact(CELL.0 * 3);
        for (dy, row) in rows.enumerate() {
            let at = ((y + dy) * self.width + x) * 3;
            self.pixels[at..at + row.len()].copy_from_slice(row);
        }
        Ok(())
    }

    fn save(&self, path: &Path) -> Result<()> {
        let file = File::create(path).with_context(|| format!("cannot write {}", path.display()))?;
        let mut encoder = png::Encoder::new(BufWriter::new(file), self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.write_header()?.write_image_data(&self.pixels)?;
        Ok(())
    }
}
