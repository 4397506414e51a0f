//! A page as a program, for machines without a browser: how long an input takes to become a decoded picture, and whether
//! what rests is the file that the copied command line writes.
//!
//! `page PROGRAM SECONDS PROCESSES VIEW_ARGUMENTS...`: starts `PROGRAM view VIEW_ARGUMENTS --no-open` so many times, orbits for so
//! long with 120 inputs a second, then rests. The same views are then rendered by their command lines.
//!
//! `page --connect URL SECONDS PARTS`: orbits at a viewer that runs, and prints a line of JSON for each part of the time. `cargo
//! xtask lines` reads those.

mod orbit;
mod socket;

use orbit::{orbit, turned};
use socket::Page;
use std::error::Error;
use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use tungstenite::Message;

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

/// Orbits and rests at viewers of its own.
fn measure(program: &str, seconds: &str, processes: &str, arguments: &[String]) -> Result<()> {
    let (mut same, mut all) = (0, 0);
    for _ in 0..processes.parse()? {
        let (_viewer, url) = Viewer::start(program, arguments)?;
        let mut page = Page::connect(&url)?;
        let (scene, own) = page.scene()?;
        page.at_rest(&own)?;
        orbit(&mut page, &own, seconds.parse()?)?.print();
        for angle in [0.1, 0.5] {
            let view = turned(&own, angle);
            let (picture, first) = page.at_rest(&view)?;
            print!(" at rest after {:.1} ms;", first.as_secs_f64() * 1e3);
            page.socket.send(Message::text(r#"{"type":"command"}"#))?;
            let command = page.text("command")?["text"].as_str().unwrap_or_default().to_owned();
            let file = std::env::temp_dir().join(format!("page-{}.png", std::process::id()));
            let command =
                command.replacen("eosphor", program, 1).replace("picture.png", &file.to_string_lossy());
            let is_done = Command::new("sh").args(["-c", &format!("{command} -q")]).status()?.success();
            all += 1;
            same += u32::from(is_done && std::fs::read(&file)? == picture);
            let _ = std::fs::remove_file(&file);
        }
        println!(" {}", scene["backend"].as_str().unwrap_or_default());
    }
    println!("{same} of {all} pictures at rest are the same bytes as those of their command lines");
    Ok(())
}

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>().as_slice() {
        ["--connect", url, seconds, parts] => connect(url, seconds, parts),
        [program, seconds, processes, ..] => measure(program, seconds, processes, &arguments[3..]),
        _ => Err("usage: page PROGRAM SECONDS PROCESSES VIEW_ARGUMENTS...; page --connect URL SECONDS PARTS"
            .into()),
    }
}
