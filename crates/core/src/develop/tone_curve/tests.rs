use super::*;
use proptest::prelude::*;

const CURVES: [(&str, ToneCurve); 3] =
    [("neutral", ToneCurve::Neutral), ("aces", ToneCurve::Aces), ("agx", ToneCurve::Agx)];

/// What a curve makes of a colour, cut to 0 and 1.
fn after(curve: ToneCurve, color: [f32; 3]) -> [f32; 3] {
    let mut planes = color.map(|x| [x; PIXELS]);
    bend(curve, &mut planes);
    planes.map(|plane| {
        assert!(plane.iter().all(|x| x.to_bits() == plane[0].to_bits() && x.is_finite()), "{plane:?}");
        plane[0].clamp(0.0, 1.0)
    })
}

/// Values of `truth.py`: the published formulas in double precision.
#[test]
fn colours_are_those_of_the_publications() {
    let (mut count, mut worst) = (0, 0f64);
    for line in include_str!("truth.txt").lines().filter(|line| !line.starts_with('#')) {
        let (name, numbers) = line.split_once(' ').unwrap();
        let n: Vec<f64> = numbers.split(' ').map(|n| n.parse().unwrap()).collect();
        let curve = CURVES.iter().find(|(known, _)| *known == name).unwrap().1;
        let got = after(curve, [n[0] as f32, n[1] as f32, n[2] as f32]);
        for (got, expected) in got.iter().zip(&n[3..]) {
            let error = (f64::from(*got) - expected).abs();
            // (A byte is 1 / 255, and the darkest one of sRGB 3e-4.)
            assert!(error < 2e-6, "{line}: {got}");
            worst = worst.max(error);
        }
        count += 1;
    }
    assert_eq!(count, 3 * 35);
    println!("at most {worst:.1e} from double precision");
}

#[test]
fn black_is_black_and_the_brightest_is_white() {
    for (name, curve) in CURVES {
        for black in [0.0, -0.0, -1.0, f32::NAN, f32::NEG_INFINITY, f32::MIN_POSITIVE, 1e-6] {
            let [r, g, b] = after(curve, [black; 3]);
            assert!(r < 1e-9 && g < 1e-9 && b < 1e-9, "{name} {black}: {r} {g} {b}");
        }
        for white in [1e5, 1e20, f32::MAX, f32::INFINITY] {
            let [r, g, b] = after(curve, [white; 3]);
            assert!(r > 0.9999 && g > 0.9999 && b > 0.9999, "{name} {white}: {r} {g} {b}");
        }
    }
}

/// Where Khronos' curve changes nothing but the reflection that it takes away.
#[test]
fn neutral_keeps_colours_up_to_its_start() {
    let c = [0.3, 0.8, 0.08];
    assert_eq!(after(ToneCurve::Neutral, c), c.map(|x| x - 0.04));
}

/// AgX puts middle grey in its middle, which is a power of 2.2.
#[test]
fn middle_grey_is_the_middle_of_agx() {
    let [grey, ..] = after(ToneCurve::Agx, [0.18; 3]);
    assert!((grey - 0.5f32.powf(2.2)).abs() < 1e-6, "{grey}");
}

/// Light by light from 1e-6 to 1e4, in steps that are far over rounding.
#[test]
fn more_light_is_no_darker() {
    for (name, curve) in CURVES {
        let mut before = [0.0; 3];
        for step in 0..4000 {
            let x = 10f32.powf(-6.0 + step as f32 / 400.0);
            let grey = after(curve, [x; 3]);
            assert!(grey.iter().zip(&before).all(|(after, before)| *after >= before - 2e-7), "{name} {x}");
            // No curve tints greys by as much as a quarter of a byte.
            assert!(grey.iter().all(|c| (c - grey[0]).abs() < 2e-5), "{name} {x}: {grey:?}");
            before = grey;
        }
        assert!(before[0] > 0.999, "{name}");
    }
}

proptest! {
    /// Whatever the bits, colours are numbers; a channel's place is that of its light.
    #[test]
    fn any_bits_give_colours(bits in any::<[u32; 3]>()) {
        let color = bits.map(f32::from_bits);
        for (_, curve) in CURVES {
            after(curve, color);
        }
        let mirrored = after(ToneCurve::Neutral, [color[2], color[0], color[1]]);
        let [r, g, b] = after(ToneCurve::Neutral, color);
        prop_assert_eq!(mirrored, [b, r, g]);
    }
}
