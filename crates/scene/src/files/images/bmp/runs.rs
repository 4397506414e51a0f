//! Run lengths of palette colours.

use super::{Palette, cut_short, damaged, index};

/// Decodes runs into rows, in the order of the file. What the runs leave out stays black.
pub(super) fn decode(
    texels: &[u8],
    bits: u32,
    palette: &Palette,
    rows: &mut [&mut [u8]],
) -> Result<(), String> {
    let mut rest = texels;
    let mut take = |bytes: usize| {
        let (taken, after) = rest.split_at_checked(bytes).ok_or_else(|| cut_short("BMP"))?;
        rest = after;
        Ok::<_, String>(taken)
    };
    let (mut x, mut y) = (0, 0);
    let last_y = rows.len() - 1;
    while let Some(row) = rows.get_mut(y) {
        let row = row.as_chunks_mut::<3>().0;
        let pair = take(2)?;
        let (count, value) = (pair[0], pair[1]);
        let repeated = [value; 255];
        // Stored numbers, how many of them, and whether more than the row takes is cut off.
        let (stored, count, may_overrun) = match (count, value) {
            (0, 0) => {
                (x, y) = (0, y + 1);
                continue;
            }
            (0, 1) => return Ok(()),
            (0, 2) => {
                let moved = take(2)?;
                (x, y) = (x + usize::from(moved[0]), y + usize::from(moved[1]));
                if y > last_y || x > row.len() {
                    return Err(damaged("BMP"));
                }
                continue;
            }
            // Literal numbers, filled up to whole words of 16 bits.
            (0, count) => {
                let bytes = (usize::from(count) * bits as usize).div_ceil(16) * 2;
                (take(bytes)?, usize::from(count), false)
            }
            // One number of 8 bits or two of 4, in turns. ImageMagick writes runs of 8 bits that are longer than the row.
            (count, _) => (&repeated[..], usize::from(count), bits == 8),
        };
        if x + count > row.len() && !may_overrun {
            return Err(damaged("BMP"));
        }
        for (i, out) in row.iter_mut().skip(x).take(count).enumerate() {
            *out = palette[usize::from(index(stored, bits, i))];
        }
        x += count;
    }
    Ok(())
}
