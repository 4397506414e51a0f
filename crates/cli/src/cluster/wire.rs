//! What ranks send each other, as bytes. All ranks run the same program, so nothing but the bytes is agreed upon.

use crate::failure::Failure;
use eosphor::math::Vec3;
use eosphor::{ExactSum, Film, FrameState, RayStatistics, Rendered, SampleSums, Sampled, SceneData};
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use std::ops::Range;

/// What rank 0 tells all others to do next.
pub(super) enum Order {
    /// Get ready to render this scene.
    Prepare(Box<SceneData>),
    /// Everyone is ready: work.
    Work,
    /// Someone is not: wait for the next order.
    Wait,
    /// The command has ended.
    Leave,
}

const PREPARE: u8 = b'P';
const WORK: u8 = b'W';
const WAIT: u8 = b'-';
const LEAVE: u8 = b'L';

impl Order {
    /// [`Order::Prepare`], without a copy of the scene.
    pub(super) fn prepare(scene: &SceneData) -> Result<Vec<u8>, Failure> {
        let bytes = postcard::to_extend(scene, vec![PREPARE]);
        bytes.map_err(|error| Failure::Failed(format!("cannot send the scene to other ranks: {error}")))
    }

    pub(super) fn to_bytes(&self) -> Vec<u8> {
        match self {
            Order::Prepare(scene) => Order::prepare(scene).unwrap_or_default(),
            Order::Work => vec![WORK],
            Order::Wait => vec![WAIT],
            Order::Leave => vec![LEAVE],
        }
    }

    pub(super) fn from_bytes(bytes: &[u8]) -> Result<Order, String> {
        match bytes.split_first() {
            Some((&PREPARE, scene)) => decode(scene).map(|scene| Order::Prepare(Box::new(scene))),
            Some((&WORK, [])) => Ok(Order::Work),
            Some((&WAIT, [])) => Ok(Order::Wait),
            Some((&LEAVE, [])) => Ok(Order::Leave),
            _ => Err("an order of rank 0 cannot be read".into()),
        }
    }
}

/// A rank before it works.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Ready {
    /// What it renders on.
    pub(super) backend: String,
    pub(super) is_gpu: bool,
    /// Units that it renders at the same time.
    pub(super) units: u32,
    /// Processors that it may use, and that its host has.
    pub(super) processors: (u32, u32),
}

/// Some rows of a frame.
#[derive(Serialize, Deserialize)]
pub(super) struct Unit {
    pub(super) rows: Range<u32>,
    /// The samples whose sums are wanted; where there are none, colours are.
    pub(super) samples: Option<Range<u32>>,
    pub(super) count_work: bool,
    pub(super) frame: Option<FrameState>,
}

#[derive(Serialize, Deserialize)]
struct ResultHead {
    width: u32,
    height: u32,
    complete: bool,
    statistics: RayStatistics,
}

pub(super) fn encode<T: Serialize>(value: &T) -> Result<Vec<u8>, String> {
    postcard::to_allocvec(value).map_err(|error| error.to_string())
}

pub(super) fn decode<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, String> {
    postcard::from_bytes(bytes).map_err(|error| format!("a message of another rank cannot be read: {error}"))
}

/// The colours of a unit.
pub(super) fn encode_film(rendered: &Rendered) -> Result<Vec<u8>, String> {
    let Film { width, height, ref pixels } = rendered.film;
    let (complete, statistics) = (rendered.complete, rendered.statistics);
    let mut bytes = encode(&ResultHead { width, height, complete, statistics })?;
    bytes.reserve(pixels.len() * 12);
    for &pixel in pixels {
        let [r, g, b] = <[f32; 3]>::from(pixel).map(f32::to_le_bytes);
        bytes.extend_from_slice(&[r, g, b].concat());
    }
    Ok(bytes)
}

/// The sums of a unit.
pub(super) fn encode_sums(sampled: &Sampled) -> Result<Vec<u8>, String> {
    let SampleSums { width, height, ref sums } = sampled.sums;
    let (complete, statistics) = (sampled.complete, sampled.statistics);
    let mut bytes = encode(&ResultHead { width, height, complete, statistics })?;
    bytes.reserve(sums.len() * 24);
    for sum in sums {
        bytes.extend_from_slice(&sum.units.map(u64::to_le_bytes).concat());
    }
    Ok(bytes)
}

pub(super) fn decode_film(bytes: &[u8]) -> Result<Rendered, String> {
    let (head, rest) = decode_head(bytes, 12)?;
    let ResultHead { width, height, complete, statistics } = head;
    let float = |bytes: &[u8; 4]| f32::from_le_bytes(*bytes);
    let pixel = |bytes: &[u8; 12]| {
        let [r, g, b] = bytes.as_chunks::<4>().0 else { unreachable!("twelve bytes") };
        Vec3::from([float(r), float(g), float(b)])
    };
    let pixels = rest.as_chunks::<12>().0.iter().map(pixel).collect();
    Ok(Rendered { film: Film { width, height, pixels }, complete, statistics })
}

pub(super) fn decode_sums(bytes: &[u8]) -> Result<Sampled, String> {
    let (head, rest) = decode_head(bytes, 24)?;
    let ResultHead { width, height, complete, statistics } = head;
    let sum = |bytes: &[u8; 24]| {
        let mut units = [0; 3];
        units.iter_mut().zip(bytes.as_chunks::<8>().0).for_each(|(unit, of)| *unit = u64::from_le_bytes(*of));
        ExactSum { units }
    };
    let sums = rest.as_chunks::<24>().0.iter().map(sum).collect();
    Ok(Sampled { sums: SampleSums { width, height, sums }, complete, statistics })
}

/// What is said of pixels of so many bytes, and these.
fn decode_head(bytes: &[u8], pixel_bytes: u64) -> Result<(ResultHead, &[u8]), String> {
    let damaged = || "the pixels of another rank cannot be read".to_string();
    let (head, rest): (ResultHead, &[u8]) = postcard::take_from_bytes(bytes).map_err(|_| damaged())?;
    match rest.len() as u64 == u64::from(head.width) * u64::from(head.height) * pixel_bytes {
        true => Ok((head, rest)),
        false => Err(damaged()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eosphor::{FrameStates, LoadOptions, load, scene_hash};

    /// All that pixels depend on arrives.
    #[test]
    fn scenes_and_moments_come_back() {
        let scene = load("builtin:solids", &LoadOptions::default()).unwrap().scene;
        let (data, _) = SceneData::flatten(&scene).unwrap();
        let Ok(Order::Prepare(read)) = Order::from_bytes(&Order::prepare(&data).unwrap()) else { panic!() };
        let develop = eosphor::DevelopSettings::default();
        assert_eq!(scene_hash(&read, &develop), scene_hash(&data, &develop));
        let state = FrameStates::new(&scene, &data).at(7).unwrap();
        let (rows, samples, state) = (3..9, Some(2..5), Some(state));
        let unit = Unit { rows, samples, count_work: true, frame: state.clone() };
        let read: Unit = decode(&encode(&unit).unwrap()).unwrap();
        assert_eq!((read.rows, read.samples), (3..9, Some(2..5)));
        assert_eq!((read.count_work, read.frame), (true, state));
        // Where vertices move, frames have more of their own.
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/reed.glb");
        let scene = load(path, &LoadOptions::default()).unwrap().scene;
        let (data, _) = SceneData::flatten(&scene).unwrap();
        let Ok(Order::Prepare(read)) = Order::from_bytes(&Order::prepare(&data).unwrap()) else { panic!() };
        assert_eq!(read.deforming_geometries, 2);
        let state = FrameStates::new(&scene, &data).at(7).unwrap();
        let unit = Unit { rows: 0..1, samples: None, count_work: false, frame: Some(state.clone()) };
        let read: Unit = decode(&encode(&unit).unwrap()).unwrap();
        assert!(state.shapes.is_some() && read.frame == Some(state));
        for order in [Order::Work, Order::Wait, Order::Leave] {
            let bytes = order.to_bytes();
            assert_eq!(Order::from_bytes(&bytes).unwrap().to_bytes(), bytes);
        }
        assert!(Order::from_bytes(b"").is_err() && Order::from_bytes(b"Pxyz").is_err());
    }

    #[test]
    fn pixels_come_back_bit_for_bit() {
        let pixels = [0.1f32, -0.0, f32::INFINITY, 1e-40, 3.5, f32::MAX];
        let pixels: Vec<Vec3> = pixels.as_chunks().0.iter().map(|&p: &[f32; 3]| Vec3::from(p)).collect();
        let statistics = RayStatistics { camera: 5, shadow: 1 << 40, ..RayStatistics::default() };
        let film = Film { width: 1, height: 2, pixels };
        let rendered = Rendered { film, complete: true, statistics };
        let bytes = encode_film(&rendered).unwrap();
        let read = decode_film(&bytes).unwrap();
        let bits = |film: &Film| -> Vec<[u32; 3]> {
            film.pixels.iter().map(|&p| <[f32; 3]>::from(p).map(f32::to_bits)).collect()
        };
        assert_eq!(bits(&read.film), bits(&rendered.film));
        assert_eq!((read.statistics, read.complete), (statistics, true));
        assert!(decode_film(&bytes[..bytes.len() - 1]).is_err() && decode_sums(&bytes).is_err());
        let sums = [[0, 1, u64::MAX], [7, 1 << 40, 3]].map(|units| ExactSum { units }).to_vec();
        let sums = SampleSums { width: 2, height: 1, sums };
        let bytes = encode_sums(&Sampled { sums: sums.clone(), complete: false, statistics }).unwrap();
        let read = decode_sums(&bytes).unwrap();
        assert_eq!((read.sums, read.statistics, read.complete), (sums, statistics, false));
        assert!(decode_sums(&bytes[..bytes.len() - 1]).is_err());
    }
}
