//! Colours of a screen (sRGB bytes) to those of video: BT.709 in its limited range, one colour for 2 × 2 pixels.
//!
//! All in integers, so that a video is the same bytes on every machine. The curve of sRGB is kept; as is usual, it goes
//! by the name of BT.709's, since players undo neither but send the bytes to the screen.

use super::super::Developed;
use super::padded_size;

/// Fixed point: bits after the point.
const BITS: u32 = 16;

/// Shares of red, green and blue in brightness: ITU-R BT.709.
const BRIGHTNESS: [f64; 3] = [0.2126, 0.7152, 0.0722];

const fn fixed(x: f64) -> i32 {
    (x * (1 << BITS) as f64 + 0.5) as i32
}

/// Brightness spans 219 steps from 16 on. Green takes the rounding, so that white is exactly 235.
const Y: [i32; 3] = {
    let [red, blue] = [fixed(BRIGHTNESS[0] * 219.0 / 255.0), fixed(BRIGHTNESS[2] * 219.0 / 255.0)];
    [red, fixed(219.0 / 255.0) - red - blue, blue]
};

/// Half of the 224 steps that differences of colour span.
const HALF: i32 = fixed(112.0 / 255.0);

/// Blue less brightness; the three sum to 0, so that greys are exactly 128.
const U: [i32; 3] = {
    let red = fixed(BRIGHTNESS[0] / (1.0 - BRIGHTNESS[2]) * 112.0 / 255.0);
    [-red, red - HALF, HALF]
};

/// Red less brightness.
const V: [i32; 3] = {
    let blue = fixed(BRIGHTNESS[2] / (1.0 - BRIGHTNESS[0]) * 112.0 / 255.0);
    [HALF, blue - HALF, -blue]
};

/// A picture as encoders take it: brightness for each pixel, two differences of colour for 2 × 2.
pub(super) struct Planes {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) y: Vec<u8>,
    pub(super) u: Vec<u8>,
    pub(super) v: Vec<u8>,
    /// Two rows of a picture added up: scratch.
    sums: Vec<[u16; 3]>,
}

impl Planes {
    /// Planes for pictures of this size, which may be odd.
    pub(super) fn new(size: (u32, u32)) -> Planes {
        let (width, height) = padded_size(size);
        let (width, height) = (width as usize, height as usize);
        let colours = width / 2 * (height / 2);
        Planes {
            width,
            height,
            y: vec![0; width * height],
            u: vec![0; colours],
            v: vec![0; colours],
            sums: vec![[0; 3]; width],
        }
    }

    /// Converts a picture of the size that the planes were made for.
    pub(super) fn convert(&mut self, picture: &Developed) {
        for pair in 0..self.height as u32 / 2 {
            let rows =
                [2 * pair, (2 * pair + 1).min(picture.height - 1)].map(|y| picture.row(y).as_chunks().0);
            let at = pair as usize;
            let brightness = &mut self.y[2 * at * self.width..][..2 * self.width];
            let (upper, lower) = brightness.split_at_mut(self.width);
            convert_brightness(upper, rows[0]);
            convert_brightness(lower, rows[1]);
            add_rows(&mut self.sums, rows);
            let half = self.width / 2;
            convert_colours(&mut self.u[at * half..][..half], &mut self.v[at * half..][..half], &self.sums);
        }
    }
}

/// A row. Where the picture has a pixel less, its last one is repeated.
fn convert_brightness(row: &mut [u8], pixels: &[[u8; 3]]) {
    for (y, pixel) in row.iter_mut().zip(pixels) {
        let sum = Y[0] * pixel[0] as i32 + Y[1] * pixel[1] as i32 + Y[2] * pixel[2] as i32;
        *y = (((16 << BITS) + (1 << (BITS - 1)) + sum) >> BITS) as u8;
    }
    if row.len() > pixels.len() {
        row[pixels.len()] = row[pixels.len() - 1];
    }
}

fn add_rows(sums: &mut [[u16; 3]], rows: [&[[u8; 3]]; 2]) {
    for (sum, (a, b)) in sums.iter_mut().zip(rows[0].iter().zip(rows[1])) {
        *sum = [a[0] as u16 + b[0] as u16, a[1] as u16 + b[1] as u16, a[2] as u16 + b[2] as u16];
    }
    if sums.len() > rows[0].len() {
        sums[rows[0].len()] = sums[rows[0].len() - 1];
    }
}

/// H.264 places a colour between two rows, but on the left of its two columns. So it is the mean of three columns, the
/// middle one twice; of two, and colours would lie a quarter of a pixel off.
fn convert_colours(u: &mut [u8], v: &mut [u8], sums: &[[u16; 3]]) {
    // Two rows, and columns with weights 1, 2, 1.
    const SHIFT: u32 = BITS + 3;
    let grey = (128 << SHIFT) + (1 << (SHIFT - 1));
    let mut left = sums[0];
    for ((u, v), columns) in u.iter_mut().zip(v).zip(sums.as_chunks::<2>().0) {
        let [middle, right] = *columns;
        let sum = |c: usize| (left[c] + 2 * middle[c] + right[c]) as i32;
        let [r, g, b] = [sum(0), sum(1), sum(2)];
        *u = ((grey + U[0] * r + U[1] * g + U[2] * b) >> SHIFT) as u8;
        *v = ((grey + V[0] * r + V[1] * g + V[2] * b) >> SHIFT) as u8;
        left = right;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn planes_of(width: u32, height: u32, colour: [u8; 3]) -> Planes {
        let rgb = colour.repeat((width * height) as usize);
        let mut planes = Planes::new((width, height));
        planes.convert(&Developed { width, height, rgb, alpha: Vec::new() });
        planes
    }

    #[test]
    fn known_colours_of_bt709() {
        // ITU-R BT.709's formulas by hand, and what ffmpeg's `-pix_fmt yuv420p -colorspace bt709` gives.
        let cases = [
            ([0, 0, 0], [16, 128, 128]),
            ([255, 255, 255], [235, 128, 128]),
            ([255, 0, 0], [63, 102, 240]),
            ([0, 255, 0], [173, 42, 26]),
            ([0, 0, 255], [32, 240, 118]),
        ];
        for (colour, [y, u, v]) in cases {
            let planes = planes_of(3, 5, colour);
            assert_eq!((planes.width, planes.height), (4, 6));
            assert!(planes.y.iter().all(|&value| value == y), "{colour:?} {:?}", planes.y);
            assert!(planes.u.iter().all(|&value| value == u), "{colour:?} {:?}", planes.u);
            assert!(planes.v.iter().all(|&value| value == v), "{colour:?} {:?}", planes.v);
        }
        for grey in 0..=255 {
            let planes = planes_of(1, 1, [grey; 3]);
            assert_eq!((planes.u[0], planes.v[0]), (128, 128));
        }
    }

    #[test]
    fn every_colour_is_within_half_a_step_of_the_formula() {
        for r in (0..=255).step_by(5) {
            for g in (0..=255).step_by(5) {
                for b in (0..=255).step_by(5) {
                    let planes = planes_of(2, 2, [r, g, b]);
                    let [red, green, blue] = [r, g, b].map(|x| x as f64 / 255.0);
                    let y = 0.2126 * red + 0.7152 * green + 0.0722 * blue;
                    let exact = [
                        16.0 + 219.0 * y,
                        128.0 + 224.0 * (blue - y) / 1.8556,
                        128.0 + 224.0 * (red - y) / 1.5748,
                    ];
                    let ours = [planes.y[3], planes.u[0], planes.v[0]];
                    for (exact, ours) in exact.iter().zip(ours) {
                        assert!((exact - ours as f64).abs() < 0.51, "{r} {g} {b}: {exact} {ours}");
                    }
                }
            }
        }
    }

    #[test]
    fn odd_sides_repeat_their_last_pixels() {
        let rgb: Vec<u8> = (0..27).map(|i| i * 9).collect();
        let odd = Developed { width: 3, height: 3, rgb, alpha: Vec::new() };
        let mut even = Vec::new();
        for y in [0, 1, 2, 2] {
            even.extend_from_slice(odd.row(y));
            even.extend_from_slice(&odd.row(y)[6..]);
        }
        let even = Developed { width: 4, height: 4, rgb: even, alpha: Vec::new() };
        let (mut a, mut b) = (Planes::new((3, 3)), Planes::new((4, 4)));
        a.convert(&odd);
        b.convert(&even);
        assert_eq!((a.y, a.u, a.v), (b.y, b.u, b.v));
    }
}
