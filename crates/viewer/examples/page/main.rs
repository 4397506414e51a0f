//! A page as a program, for machines without a browser: how long an input takes to become a decoded picture, and whether
//! what rests is the file that `render` writes.
//!
//! `page PROGRAM SECONDS PROCESSES VIEW_ARGUMENTS...`: starts `PROGRAM view VIEW_ARGUMENTS --no-open` so many times, orbits for so
//! long with 120 inputs a second, then rests.
//!
//! `page --truth PROGRAM BACKEND SCENE...`: shows three changed views of each scene, and renders them by the command lines that the
//! page gives and from the scenes that it saves. A scene may be followed by flags of `view`: `"scene.obj --up z"`.
//!
//! `page --connect URL SECONDS PARTS`: orbits at a viewer that runs, and prints a line of JSON for each part of the time. `cargo
//! xtask lines` reads those. With `EOSPHOR_PAGE_JPEG` in the environment it says that it decodes no H.264.

mod orbit;
mod socket;
mod truth;

use orbit::{orbit, turned};
use socket::Page;
use std::error::Error;
use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use truth::Same;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// A viewer that ends with this.
struct Viewer(Child);

impl Drop for Viewer {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

impl Viewer {
    /// Starts one; with the address that it prints.
    fn start(program: &str, arguments: &[String]) -> Result<(Viewer, String)> {
        let child = Command::new(program)
            .arg("view")
            .args(arguments)
            .arg("--no-open")
            .stdout(Stdio::piped())
            .spawn()?;
        let mut viewer = Viewer(child);
        let mut url = String::new();
        BufReader::new(viewer.0.stdout.take().ok_or("no output")?).read_line(&mut url)?;
        Ok((viewer, url))
    }
}

/// Orbits at a viewer that runs.
fn connect(url: &str, seconds: &str, parts: &str) -> Result<()> {
    let mut page = Page::connect(url)?;
    let (_, own) = page.scene()?;
    let frames = orbit(&mut page, &own, seconds.parse()?)?;
    frames.parts(parts.parse()?).iter().for_each(|part| println!("{}", part.to_json()));
    Ok(())
}

/// Whether pictures at rest are those of `render`.
fn truth(program: &str, backend: &str, scenes: &[&str]) -> Result<()> {
    let mut same = Same::default();
    for scene in scenes {
        let arguments: Vec<String> = scene.split_whitespace().map(str::to_owned).collect();
        truth::compare(program, backend, &arguments, &mut same)?;
    }
    match same.command_lines == same.of && same.saved_scenes == same.of {
        true => Ok(()),
        false => Err("a picture at rest is not the file".into()),
    }
}

/// Orbits and rests at viewers of its own.
fn measure(program: &str, seconds: &str, processes: &str, arguments: &[String]) -> Result<()> {
    for _ in 0..processes.parse()? {
        let (_viewer, url) = Viewer::start(program, arguments)?;
        let mut page = Page::connect(&url)?;
        let (scene, own) = page.scene()?;
        page.at_rest(&own)?;
        orbit(&mut page, &own, seconds.parse()?)?.print();
        let (_, first) = page.at_rest(&turned(&own, 0.1))?;
        print!(" at rest after {:.1} ms;", first.as_secs_f64() * 1e3);
        println!(" {}", scene["backend"].as_str().unwrap_or_default());
    }
    Ok(())
}

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>().as_slice() {
        ["--connect", url, seconds, parts] => connect(url, seconds, parts),
        ["--truth", program, backend, scenes @ ..] => truth(program, backend, scenes),
        [program, seconds, processes, ..] => measure(program, seconds, processes, &arguments[3..]),
        _ => Err("usage: page PROGRAM SECONDS PROCESSES VIEW_ARGUMENTS...; page --truth PROGRAM BACKEND SCENE...; page --connect URL SECONDS PARTS"
            .into()),
    }
}
