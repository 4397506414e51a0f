//! What instructions compute of numbers, bit for bit as devices do.

use crate::program::{Comparison, Op, Type};

pub(crate) fn f32_of(bits: u64) -> f32 {
    f32::from_bits(bits as u32)
}

pub(crate) fn of_f32(value: f32) -> u64 {
    value.to_bits().into()
}

/// By what is computed of numbers of a type.
macro_rules! by_type {
    ($type:expr, $a:expr, $b:expr, float |$x:ident, $y:ident| $float:expr, integer |$m:ident, $n:ident| $integer:expr) => {
        match $type {
            Type::F32 => {
                let ($x, $y) = (f32_of($a), f32_of($b));
                let result = $float;
                of_f32(result)
            }
            Type::F64 => {
                let ($x, $y) = (f64::from_bits($a), f64::from_bits($b));
                let result: f64 = $float;
                result.to_bits()
            }
            other => {
                let ($m, $n) = ($a, $b);
                let result: u64 = $integer;
                result & other.mask()
            }
        }
    };
}

/// The lesser or the greater of two numbers, as devices have it: a number rather than none, and zeros in order of their signs.
macro_rules! extreme {
    ($x:expr, $y:expr, $least:literal) => {
        if $x.is_nan() {
            $y
        } else if $y.is_nan() {
            $x
        } else if $x == $y {
            if $x.is_sign_negative() == $least { $x } else { $y }
        } else if ($x < $y) == $least {
            $x
        } else {
            $y
        }
    };
}

fn signed(value: u64, of: Type) -> i64 {
    match of {
        Type::S16 => i64::from(value as i16),
        Type::S32 => i64::from(value as i32),
        _ => value as i64,
    }
}

/// The result of an instruction.
#[inline(always)]
pub(crate) fn computed(op: Op, [a, b, c]: [u64; 3]) -> u64 {
    match op {
        Op::Copy => a,
        Op::Join(bits) => a & ((1 << bits) - 1) | b << bits,
        Op::Add(of) => by_type!(of, a, b, float | x, y | x + y, integer | m, n | m.wrapping_add(n)),
        Op::Subtract(of) => by_type!(of, a, b, float | x, y | x - y, integer | m, n | m.wrapping_sub(n)),
        Op::Multiply(of) => by_type!(of, a, b, float | x, y | x * y, integer | m, n | m.wrapping_mul(n)),
        Op::MultiplyWide => a * b,
        Op::MultiplyHigh => (u64::from(a as u32) * u64::from(b as u32)) >> 32,
        Op::MultiplyAdd(Type::F32) => of_f32(f32_of(a).mul_add(f32_of(b), f32_of(c))),
        Op::MultiplyAdd(Type::F64) => {
            f64::from_bits(a).mul_add(f64::from_bits(b), f64::from_bits(c)).to_bits()
        }
        Op::MultiplyAdd(of) => a.wrapping_mul(b).wrapping_add(c) & of.mask(),
        Op::Divide(of) => {
            by_type!(of, a, b, float | x, y | x / y, integer | m, n | m.checked_div(n).unwrap_or(u64::MAX))
        }
        Op::Reciprocal(Type::F32) => of_f32(1.0 / f32_of(a)),
        Op::Reciprocal(_) => (1.0 / f64::from_bits(a)).to_bits(),
        Op::Root(Type::F32) => of_f32(f32_of(a).sqrt()),
        Op::Root(_) => f64::from_bits(a).sqrt().to_bits(),
        Op::Negate(of) => by_type!(of, a, b, float | x, _y | -x, integer | m, _n | m.wrapping_neg()),
        Op::Absolute(of) => by_type!(of, a, b, float | x, _y | x.abs(), integer | m, _n | m),
        Op::Least(of) => {
            by_type!(
                of,
                a,
                b,
                float | x,
                y | extreme!(x, y, true),
                integer | m,
                n | if signed_order(of, m, n) { m } else { n }
            )
        }
        Op::Greatest(of) => {
            by_type!(
                of,
                a,
                b,
                float | x,
                y | extreme!(x, y, false),
                integer | m,
                n | if signed_order(of, m, n) { n } else { m }
            )
        }
        Op::CopySign => of_f32(f32_of(b).copysign(f32_of(a))),
        Op::And => a & b,
        Op::Or => a | b,
        Op::Xor => a ^ b,
        Op::Not(of) => !a & of.mask(),
        Op::ShiftLeft(of) => a.checked_shl(b as u32).unwrap_or(0) & of.mask(),
        Op::ShiftRight(of @ (Type::S16 | Type::S32 | Type::S64)) => {
            (signed(a, of) >> b.min(63)) as u64 & of.mask()
        }
        Op::ShiftRight(_) => a.checked_shr(b as u32).unwrap_or(0),
        Op::FunnelRight => (b << 32 | a) >> (c & 31) & 0xffff_ffff,
        Op::FunnelLeft => (b << 32 | a) << (c & 31) >> 32,
        Op::Field(of) => field(of, a, b, c),
        Op::ReverseBits => (a as u32).reverse_bits().into(),
        Op::CountOnes => a.count_ones().into(),
        Op::PermuteBytes => {
            let bytes = b << 32 | a;
            (0..4).fold(0, |whole, k| {
                let which = c >> (4 * k);
                let byte = bytes >> (8 * (which & 7)) & 0xff;
                let byte = if which & 8 == 0 { byte } else { (byte >> 7) * 0xff };
                whole | byte << (8 * k)
            })
        }
        Op::Convert { to, from } => convert(a, to, from),
        Op::Floor => of_f32(f32_of(a).floor()),
        Op::Select => {
            if c != 0 {
                a
            } else {
                b
            }
        }
        Op::Compare { comparison, of, is_unordered } => compare(comparison, of, is_unordered, a, b).into(),
        other => unreachable!("{other:?} is no computation"),
    }
}

fn signed_order(of: Type, a: u64, b: u64) -> bool {
    match of {
        Type::S16 | Type::S32 | Type::S64 => signed(a, of) < signed(b, of),
        _ => a < b,
    }
}

fn field(of: Type, a: u64, first: u64, count: u64) -> u64 {
    let (first, count) = ((first & 0xff) as u32, (count & 0xff) as u32);
    if count == 0 {
        return 0;
    }
    let whole = if of == Type::S32 { signed(a, of) as u64 } else { a };
    let moved = if of == Type::S32 {
        (whole as i64 >> first.min(63)) as u64
    } else {
        whole.checked_shr(first).unwrap_or(0)
    };
    if count >= 32 {
        return moved & 0xffff_ffff;
    }
    let bits = moved & ((1 << count) - 1);
    match of {
        Type::S32 => (((bits << (64 - count)) as i64 >> (64 - count)) as u64) & 0xffff_ffff,
        _ => bits,
    }
}

fn convert(a: u64, to: Type, from: Type) -> u64 {
    let as_float = |value: f64| match to {
        Type::U32 => u64::from(value as u32),
        Type::S32 => u64::from(value as i32 as u32),
        Type::U64 => value as u64,
        _ => value as i64 as u64,
    };
    match (to, from) {
        (Type::F32, Type::F64) => of_f32(f64::from_bits(a) as f32),
        (Type::F64, Type::F32) => f64::from(f32_of(a)).to_bits(),
        (Type::F32, Type::S16 | Type::S32 | Type::S64) => of_f32(signed(a, from) as f32),
        (Type::F64, Type::S16 | Type::S32 | Type::S64) => (signed(a, from) as f64).to_bits(),
        (Type::F32, _) => of_f32(a as f32),
        (Type::F64, _) => (a as f64).to_bits(),
        (_, Type::F32) => as_float(f32_of(a).into()),
        (_, Type::F64) => as_float(f64::from_bits(a)),
        (_, Type::S16 | Type::S32) => signed(a, from) as u64 & to.mask(),
        _ => a & to.mask(),
    }
}

fn compare(comparison: Comparison, of: Type, is_unordered: bool, a: u64, b: u64) -> bool {
    use std::cmp::Ordering::{Equal, Greater, Less};
    let order = match of {
        Type::F32 => f32_of(a).partial_cmp(&f32_of(b)),
        Type::F64 => f64::from_bits(a).partial_cmp(&f64::from_bits(b)),
        Type::S16 | Type::S32 | Type::S64 => Some(signed(a, of).cmp(&signed(b, of))),
        _ => Some(a.cmp(&b)),
    };
    match (comparison, order) {
        (Comparison::AreNumbers, order) => order.is_some(),
        (Comparison::IsNan, order) => order.is_none(),
        (_, None) => is_unordered,
        (Comparison::Equal, Some(order)) => order == Equal,
        (Comparison::NotEqual, Some(order)) => order != Equal,
        (Comparison::Less, Some(order)) => order == Less,
        (Comparison::LessOrEqual, Some(order)) => order != Greater,
        (Comparison::Greater, Some(order)) => order == Greater,
        (Comparison::GreaterOrEqual, Some(order)) => order != Less,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_third_is_the_upper_half_of_a_product() {
        let third = |of: u64| computed(Op::MultiplyHigh, [of, u64::from(-1_431_655_765_i32 as u32), 0]) >> 1;
        assert_eq!([0, 2, 3, 4_194_303, u64::from(u32::MAX)].map(third), [0, 0, 1, 1_398_101, 1_431_655_765]);
    }

    #[test]
    fn two_words_move_as_one() {
        let moved = |op, by| computed(op, [0xddcc_bbaa, 0x4433_2211, by]);
        assert_eq!([8, 40, 0].map(|by| moved(Op::FunnelLeft, by)), [0x3322_11dd, 0x3322_11dd, 0x4433_2211]);
        assert_eq!([8, 40, 0].map(|by| moved(Op::FunnelRight, by)), [0x11dd_ccbb, 0x11dd_ccbb, 0xddcc_bbaa]);
    }
}
