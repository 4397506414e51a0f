//! Scenes for path tracing with numbers that nobody means: each gives a picture, or an error that says what is wrong.

use crate::place::{Place, Run};
use eosphor::Picture;
use std::fs;

/// A floor of 4 x 4 before a camera.
const FLOOR: &str = r#"{"corners": [[-2, 0, 2], [2, 0, 2], [2, 0, -2], [-2, 0, -2]]"#;

fn scene(place: &Place, keys: &str) {
    let text = format!(
        r#"{{"eosphor": 2, "camera": {{"position": [0, 3, 5], "look-at": [0, 0, 0]}}, {keys},
            "settings": {{"integrator": "path", "size": [16, 12], "samples": 4}}}}"#
    );
    fs::write(place.path("s.json"), text).unwrap();
}

fn render(place: &Place, more: &[&str]) -> Run {
    place.run(&[&["render", "s.json", "-o", "a.exr", "--no-metadata"], more].concat())
}

/// The picture, all of whose numbers are numbers.
fn pixels(place: &Place) -> Vec<[f32; 3]> {
    let Picture::Linear(film) = Picture::read(&place.path("a.exr")).unwrap() else { panic!("EXR is linear") };
    let pixels: Vec<[f32; 3]> = film.pixels.iter().map(|&p| p.into()).collect();
    assert!(pixels.iter().flatten().all(|x| x.is_finite() && *x >= 0.0), "{pixels:?}");
    pixels
}

/// An OpenEXR of floats, not compressed, with this texel again and again.
fn exr(width: i32, height: i32, texel: [f32; 3]) -> Vec<u8> {
    let mut file = vec![0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0];
    let mut attribute = |name: &str, kind: &str, value: &[u8]| {
        file.extend([name.as_bytes(), b"\0", kind.as_bytes(), b"\0"].concat());
        file.extend((value.len() as i32).to_le_bytes());
        file.extend(value);
    };
    let ints = |all: &[i32]| all.iter().flat_map(|n| n.to_le_bytes()).collect::<Vec<u8>>();
    let channel = |name: &str| [name.as_bytes(), b"\0", &ints(&[2, 0, 1, 1])[..]].concat();
    attribute("channels", "chlist", &[channel("B"), channel("G"), channel("R"), vec![0]].concat());
    attribute("compression", "compression", &[0]);
    let window = ints(&[0, 0, width - 1, height - 1]);
    attribute("dataWindow", "box2i", &window);
    attribute("displayWindow", "box2i", &window);
    attribute("lineOrder", "lineOrder", &[0]);
    attribute("pixelAspectRatio", "float", &1f32.to_le_bytes());
    attribute("screenWindowCenter", "v2f", &[0; 8]);
    attribute("screenWindowWidth", "float", &1f32.to_le_bytes());
    file.push(0);
    let row = 8 + 12 * width as usize;
    let first = file.len() + 8 * height as usize;
    (0..height as usize).for_each(|y| file.extend(((first + y * row) as u64).to_le_bytes()));
    for y in 0..height {
        file.extend(ints(&[y, 12 * width]));
        for value in [texel[2], texel[1], texel[0]] {
            (0..width).for_each(|_| file.extend(value.to_le_bytes()));
        }
    }
    file
}

/// NaN is black, as it is where an environment has no light at all; infinity is the brightest that a scene can have.
#[test]
fn pictures_of_no_numbers_are_read() {
    let place = Place::new();
    for (texel, is_black) in [
        ([f32::NAN; 3], true),
        ([-1.0; 3], true),
        ([f32::INFINITY; 3], false),
        ([f32::MAX, 1.0, f32::NAN], false),
    ] {
        fs::write(place.path("t.exr"), exr(3, 2, texel)).unwrap();
        scene(&place, &format!(r#""environment": "t.exr", "quadrilaterals": [{FLOOR}}}]"#));
        let run = render(&place, &[]).succeeded();
        assert_eq!(run.stderr.contains("the environment is black"), is_black, "{}", run.stderr);
        assert_eq!(pixels(&place).iter().all(|p| *p == [0.0; 3]), is_black, "{texel:?}");
        let textures = r#""materials": {"m": {"pbr": {"emission": [1, 1, 1]},
            "textures": {"color": "t.exr", "emission": "t.exr", "normal": "t.exr", "roughness": "t.exr"}}}"#;
        let floor = format!(r#"{textures}, "quadrilaterals": [{FLOOR}, "material": "m"}}]"#);
        scene(&place, &floor);
        render(&place, &["--background", "1,1,1"]).succeeded();
        pixels(&place);
    }
}

/// A picture of one texel is the same in all directions: like a background of that colour.
#[test]
fn environments_of_one_texel_are_uniform() {
    let place = Place::new();
    fs::write(place.path("t.exr"), exr(1, 1, [0.5, 0.25, 2.0])).unwrap();
    let ball = r#""materials": {"white": {"matte": {"color": [1, 1, 1]}}},
        "spheres": [{"center": [0, 0, 0], "radius": 1, "material": "white"}]"#;
    scene(&place, &format!(r#""environment": "t.exr", {ball}"#));
    render(&place, &[]).succeeded();
    let pixels = pixels(&place);
    assert_eq!(pixels[0], [0.5, 0.25, 2.0]);
    // A white ball is as bright as what is around it, on average.
    for (k, wanted) in [0.5, 0.25, 2.0].into_iter().enumerate() {
        let mean = pixels.iter().map(|p| p[k]).sum::<f32>() / pixels.len() as f32;
        assert!((mean - wanted).abs() < 0.02 * wanted, "{mean} {wanted}");
    }
}

/// What shines without an area is no light, and nothing is divided by that.
#[test]
fn lamps_without_area_light_nothing() {
    let place = Place::new();
    let points = "v 0 1 0\nv 0 1 0\nv 0 1 0\nf 1 2 3\nv 0 2 0\nv 1 2 0\nv 2 2 0\nf 4 5 6\n\
                  v 0 3 0\nv 1e-30 3 0\nv 0 3 1e-30\nf 7 8 9\n";
    fs::write(place.path("z.obj"), points).unwrap();
    let lamp = r#""materials": {"lamp": {"emissive": {"radiance": [5, 5, 5]}}},
        "meshes": [{"file": "z.obj", "material": "lamp"}]"#;
    scene(&place, &format!(r#"{lamp}, "quadrilaterals": [{FLOOR}}}]"#));
    render(&place, &["--headlight", "off"]).succeeded();
    assert!(pixels(&place).iter().all(|p| *p == [0.0; 3]));
}

/// The brightest radiance that a scene can state is rendered; more is refused.
#[test]
fn radiance_beyond_the_range_is_refused() {
    let place = Place::new();
    for (radiance, refusal) in [
        ("1e12", None),
        ("1e30", Some("1e30 is out of range")),
        ("1e39", Some("1e39 is out of range")),
        ("-1", Some("one of \"radiance\" is -1")),
    ] {
        let lamp = format!(r#""materials": {{"lamp": {{"emissive": {{"radiance": [{radiance}, 1, 1]}}}}}}"#);
        let ball = r#""spheres": [{"center": [0, 1, 0], "radius": 0.3, "material": "lamp"}]"#;
        scene(&place, &format!(r#"{lamp}, {ball}, "quadrilaterals": [{FLOOR}}}]"#));
        match refusal {
            None => {
                render(&place, &[]).succeeded();
                assert!(pixels(&place).iter().any(|p| p[0] > 1e6));
            }
            Some(words) => render(&place, &[]).failed_with(&["s.json", words]),
        }
    }
}
