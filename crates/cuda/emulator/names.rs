//! Names in PTX: of types, of comparisons, of what instructions compute.

use crate::program::{Comparison, Op, Special, Type};

/// The type that an instruction names.
pub(crate) fn type_of(name: &str) -> Option<Type> {
    Some(match name {
        "pred" => Type::Predicate,
        "b16" | "u16" => Type::U16,
        "s16" => Type::S16,
        "b32" | "u32" => Type::U32,
        "s32" => Type::S32,
        "b64" | "u64" => Type::U64,
        "s64" => Type::S64,
        "f32" => Type::F32,
        "f64" => Type::F64,
        _ => return None,
    })
}

/// Bytes, and whether they are extended by their sign.
pub(crate) fn memory_type(name: &str) -> Result<(u32, bool), String> {
    let bits: u32 = name[1..].parse().map_err(|_| format!("unknown type {name}"))?;
    let is_signed = name.starts_with('s') && bits == 32;
    if name.starts_with('s') && bits < 32 {
        return Err(format!("unknown type {name}"));
    }
    Ok((bits / 8, is_signed))
}

/// A comparison, and what it answers where one is not a number.
pub(crate) fn comparison(name: &str, is_float: bool) -> Result<(Comparison, bool), String> {
    let (name, is_unordered) = match name.strip_suffix('u') {
        Some(plain) if is_float => (plain, true),
        _ => (name, false),
    };
    let comparison = match name {
        "eq" => Comparison::Equal,
        "ne" => Comparison::NotEqual,
        "lt" => Comparison::Less,
        "le" => Comparison::LessOrEqual,
        "gt" => Comparison::Greater,
        "ge" => Comparison::GreaterOrEqual,
        "num" => Comparison::AreNumbers,
        "nan" => Comparison::IsNan,
        other => return Err(format!("unknown comparison {other}")),
    };
    Ok((comparison, is_unordered))
}

/// What a thread asks for by name.
pub(crate) fn special(name: &str) -> Option<Special> {
    Some(match name {
        "%tid.x" => Special::Thread,
        "%ctaid.x" => Special::Block,
        "%ntid.x" => Special::BlockSize,
        "%nctaid.x" => Special::Blocks,
        "%clock64" => Special::Clock,
        "%globaltimer" => Special::Nanoseconds,
        _ => return None,
    })
}

/// What an instruction computes that is named so, with a result and without other effects.
pub(crate) fn computation(parts: &[&str], of: Type) -> Option<Op> {
    let is_float = matches!(of, Type::F32 | Type::F64);
    // Rounding is named, and nothing else is done to floating-point numbers.
    let middle = &parts[1..parts.len() - 1];
    let is_plain = match parts[0] {
        "add" | "sub" | "mul" | "fma" | "div" | "rcp" | "sqrt" if is_float => middle == ["rn"],
        "mul" => middle == ["lo"] || (middle == ["wide"] || middle == ["hi"]) && of == Type::U32,
        "mad" => middle == ["lo"],
        "shf" => middle == ["r", "wrap"] || middle == ["l", "wrap"],
        _ => middle.is_empty(),
    };
    if !is_plain {
        return None;
    }
    Some(match parts[0] {
        "add" => Op::Add(of),
        "sub" => Op::Subtract(of),
        "mul" if middle == ["wide"] => Op::MultiplyWide,
        "mul" if middle == ["hi"] => Op::MultiplyHigh,
        "mul" => Op::Multiply(of),
        "mad" | "fma" => Op::MultiplyAdd(of),
        "div" if !is_float && matches!(of, Type::U32 | Type::U64) => Op::Divide(of),
        "div" if is_float => Op::Divide(of),
        "rcp" => Op::Reciprocal(of),
        "sqrt" => Op::Root(of),
        "neg" => Op::Negate(of),
        "abs" if is_float => Op::Absolute(of),
        "min" => Op::Least(of),
        "max" => Op::Greatest(of),
        "copysign" if of == Type::F32 => Op::CopySign,
        "and" => Op::And,
        "or" => Op::Or,
        "xor" => Op::Xor,
        "not" => Op::Not(of),
        "shl" => Op::ShiftLeft(of),
        "shr" => Op::ShiftRight(of),
        "shf" if middle == ["l", "wrap"] => Op::FunnelLeft,
        "shf" => Op::FunnelRight,
        "bfe" if matches!(of, Type::U32 | Type::S32) => Op::Field(of),
        "brev" if of == Type::U32 => Op::ReverseBits,
        "popc" => Op::CountOnes,
        "prmt" => Op::PermuteBytes,
        _ => return None,
    })
}
