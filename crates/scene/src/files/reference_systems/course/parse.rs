//! The text → [`CourseInput`].

use super::words::Words;
use super::{
    CourseBody, CourseFloor, CourseInput, CourseLight, CourseLines, CoursePattern, MAX_COURSE_LIGHTS,
};
use crate::error::SceneError;
use crate::model::{Law, MAX_FRAMES};
use crate::solids::MAX_LIGHTS_PER_EDGE;
use std::path::Path;

impl CourseInput {
    /// Reads the text. `path` is what errors call it; a text from standard input may be called so.
    ///
    /// # Errors
    /// The first thing that is wrong, with its line and the name of the field: missing words, words that are no numbers,
    /// numbers out of range, words after the end.
    pub fn parse(text: &[u8], path: &Path) -> Result<CourseInput, SceneError> {
        CourseInput::parse_with_lines(text, path).map(|(input, _)| input)
    }

    /// As [`CourseInput::parse`], and where some of it stands.
    ///
    /// # Errors
    /// As [`CourseInput::parse`].
    pub fn parse_with_lines(text: &[u8], path: &Path) -> Result<(CourseInput, CourseLines), SceneError> {
        let text = std::str::from_utf8(text).map_err(|e| {
            let line = 1 + text[..e.valid_up_to()].iter().filter(|&&b| b == b'\n').count() as u32;
            SceneError::at(path, line, "this is no text: the input is read as UTF-8")
        })?;
        let mut words = Words::new(text.strip_prefix('\u{feff}').unwrap_or(text), path);
        let w = &mut words;
        let mut lines = CourseLines { output: 0, texture: 0 };
        let input = CourseInput {
            frames: w.whole("number of frames", 1, MAX_FRAMES)?,
            output: output(w, &mut lines)?,
            size: [w.whole("width", 1, 65_535)?, w.whole("height", 1, 65_535)?],
            fov_x_degrees: w.number("angle", "over 0 and under 180", |x| x > 0.0 && x < 180.0)?,
            position: law(w, "camera")?,
            look_at: law(w, "look-at point")?,
            bodies: [body(w, 1)?, body(w, 2)?, body(w, 3)?],
            floor: floor(w, &mut lines)?,
            lights: lights(w)?,
            depth: w.whole("recursion depth", 0, 64)?,
            rays_root: w.whole("square root of rays a pixel", 1, 256)?,
        };
        words.end()?;
        Ok((input, lines))
    }
}

fn output(w: &mut Words, lines: &mut CourseLines) -> Result<CoursePattern, SceneError> {
    let field = "output path";
    let word = w.word(field)?;
    lines.output = w.line();
    word.parse().map_err(|e: super::pattern::WrongCoursePattern| w.error(field, e.to_string()))
}

fn law(w: &mut Words, of: &str) -> Result<Law, SceneError> {
    let name = |field: &str| format!("{field} of {of}");
    Ok(Law {
        r: w.coordinate(&name("r0"))?,
        z: w.coordinate(&name("z0"))?,
        phi: w.angle(&name("phi0"))?,
        r_amplitude: w.coordinate(&name("A_r"))?,
        z_amplitude: w.coordinate(&name("A_z"))?,
        r_frequency: w.angle(&name("w_r"))?,
        z_frequency: w.angle(&name("w_z"))?,
        phi_frequency: w.angle(&name("w_phi"))?,
        r_phase: w.angle(&name("p_r"))?,
        z_phase: w.angle(&name("p_z"))?,
    })
}

fn body(w: &mut Words, number: u32) -> Result<CourseBody, SceneError> {
    let name = |field: &str| format!("{field} of body {number}");
    Ok(CourseBody {
        center: w.point(&name("centre"))?,
        color: w.color(&name("colour"))?,
        radius: w.length(&name("radius"))?,
        reflection: w.share(&name("reflection"))?,
        transparency: w.share(&name("transparency"))?,
        lights_per_edge: w.whole(&name("lights an edge"), 0, MAX_LIGHTS_PER_EDGE)?,
    })
}

fn floor(w: &mut Words, lines: &mut CourseLines) -> Result<CourseFloor, SceneError> {
    let mut corner = |number: u32| w.point(&format!("corner {number} of the floor"));
    let corners = [corner(1)?, corner(2)?, corner(3)?, corner(4)?];
    let texture = w.word("texture of the floor")?.to_string();
    lines.texture = w.line();
    Ok(CourseFloor {
        corners,
        texture,
        tint: w.color("tint of the floor")?,
        reflection: w.share("reflection of the floor")?,
    })
}

fn lights(w: &mut Words) -> Result<Vec<CourseLight>, SceneError> {
    let count = w.whole("number of lights", 0, MAX_COURSE_LIGHTS as u32)?;
    let light = |number: u32| {
        let position = w.point(&format!("position of light {number}"))?;
        Ok(CourseLight { position, color: w.light_color(&format!("colour of light {number}"))? })
    };
    (1..=count).map(light).collect()
}
