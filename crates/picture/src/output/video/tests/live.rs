//! A live picture, by openh264's decoder.

use super::file::{difference, screen_bytes};
use super::*;
use crate::output::LiveEncoder;
use openh264::decoder::Decoder;

#[test]
fn each_frame_is_decoded_when_it_is_there() {
    for size in [(64, 48), (50, 36), (160, 90)] {
        let (mut encoder, mut decoder) = (LiveEncoder::new(size, 14).unwrap(), Decoder::new().unwrap());
        for number in 0..40 {
            let picture = frame(number, size);
            let made = encoder.encode(&picture).unwrap();
            assert_eq!(made.is_key, number == 0, "{size:?}, frame {number}");
            let decoded = decoder.decode(&made.bytes).unwrap().expect("nothing waits for the next frame");
            let (error, _) = difference(&screen_bytes(&decoded), &picture);
            // Quantiser 14 has steps of 3.25; the frame before would be 12 away.
            assert!(error < 4.0, "{size:?}, frame {number}: {error}");
        }
    }
}

#[test]
fn coarser_ones_have_fewer_bytes() {
    let size = (160, 90);
    let bytes = |quantiser| {
        let mut encoder = LiveEncoder::new(size, quantiser).unwrap();
        (0..10).map(|number| encoder.encode(&frame(number, size)).unwrap().bytes.len()).sum::<usize>()
    };
    let all: Vec<usize> = [20, 26, 32, 38].map(bytes).into();
    assert!(all.is_sorted_by(|finer, coarser| finer > coarser), "{all:?}");
}

#[test]
fn frames_of_other_sizes_are_refused() {
    assert!(LiveEncoder::new((8, 8), 26).is_err());
    assert!(LiveEncoder::new((8000, 8), 26).is_err());
    let mut encoder = LiveEncoder::new((64, 48), 26).unwrap();
    assert!(encoder.is_for((64, 48), 26) && encoder.is_for((63, 47), 26));
    assert!(!encoder.is_for((64, 50), 26) && !encoder.is_for((64, 48), 27));
    assert!(encoder.encode(&frame(0, (32, 48))).is_err());
    assert!(encoder.encode(&frame(0, (64, 48))).unwrap().is_key);
}
