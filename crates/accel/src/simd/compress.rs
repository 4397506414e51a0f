//! Where lanes go that are put one after the other, for instruction sets that cannot do that by themselves.

/// For each set of lanes, their numbers one after the other.
#[repr(align(64))]
pub(super) struct Compress(pub(super) [[u8; 8]; 256]);

pub(super) static COMPRESS: Compress = {
    let mut table = [[0; 8]; 256];
    let mut bits = 0;
    while bits < 256 {
        let (mut lane, mut to) = (0, 0);
        while lane < 8 {
            if bits >> lane & 1 == 1 {
                table[bits][to] = lane as u8;
                to += 1;
            }
            lane += 1;
        }
        bits += 1;
    }
    Compress(table)
};
