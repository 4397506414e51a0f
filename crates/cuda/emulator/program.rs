//! What PTX is read into: functions whose operands are numbers of slots.

/// Numbers as instructions take them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Type {
    Predicate,
    U16,
    S16,
    U32,
    S32,
    U64,
    S64,
    F32,
    F64,
}

impl Type {
    /// Bits of a slot that it takes.
    pub(crate) fn mask(self) -> u64 {
        match self {
            Type::Predicate => 1,
            Type::U16 | Type::S16 => 0xffff,
            Type::U32 | Type::S32 | Type::F32 => 0xffff_ffff,
            Type::U64 | Type::S64 | Type::F64 => u64::MAX,
        }
    }
}

/// How two numbers are compared. If one is not a number, the answer is that of `is_unordered`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Comparison {
    Equal,
    NotEqual,
    Less,
    LessOrEqual,
    Greater,
    GreaterOrEqual,
    /// Whether both are numbers.
    AreNumbers,
    /// Whether one is not.
    IsNan,
}

/// What a thread asks for by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Special {
    Thread,
    Block,
    BlockSize,
    Blocks,
    Clock,
    Nanoseconds,
}

/// What an instruction does. `a`, `b` and `c` are what it takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Op {
    /// `a`, as it is.
    Copy,
    Special(Special),
    /// Halves of `a`, of so many bits each.
    Split(u32),
    /// `a` below `b`, of so many bits each.
    Join(u32),
    Add(Type),
    Subtract(Type),
    Multiply(Type),
    /// Of numbers of 32 bits, with all 64.
    MultiplyWide,
    /// Of numbers of 32 bits, the upper 32 of the 64.
    MultiplyHigh,
    /// `a * b + c`, for floating-point numbers rounded once.
    MultiplyAdd(Type),
    Divide(Type),
    Reciprocal(Type),
    Root(Type),
    Negate(Type),
    Absolute(Type),
    Least(Type),
    Greatest(Type),
    /// `b` with the sign of `a`.
    CopySign,
    And,
    Or,
    Xor,
    Not(Type),
    ShiftLeft(Type),
    ShiftRight(Type),
    /// The lower half of `b` over `a`, moved down by `c` modulo 32.
    FunnelRight,
    /// The upper half of `b` over `a`, moved up by `c` modulo 32.
    FunnelLeft,
    /// Bits of `a` from `b` on, as many as `c`.
    Field(Type),
    ReverseBits,
    CountOnes,
    /// Bytes of `a` and `b`, as `c` says.
    PermuteBytes,
    /// From one type to another; towards zero where that is an integer.
    Convert {
        to: Type,
        from: Type,
    },
    Floor,
    /// `a` if `c`, else `b`.
    Select,
    Compare {
        comparison: Comparison,
        of: Type,
        is_unordered: bool,
    },
    /// From the address `a`.
    Load {
        bytes: u32,
        is_signed: bool,
        count: u32,
    },
    /// To the address `a`: from `from[1..]` and `to`.
    Store {
        bytes: u32,
        count: u32,
    },
    /// At the address `a`, with `b`.
    AtomicAdd,
    AtomicExchange,
    AtomicMax,
    Jump,
    /// To one of a list, by `a`.
    JumpTo,
    Call,
    Return,
    /// `a` of the lane whose number differs in the bits of `b`, or that has the number `b`.
    Shuffle {
        is_butterfly: bool,
    },
    /// For which lanes of the mask `b` the predicate `a` is true.
    Ballot,
    /// Whether `a` is the same for all lanes of the mask `b`.
    MatchAll,
    ActiveMask,
}

/// No slot.
pub(crate) const NONE: u32 = u32::MAX;

/// An instruction.
#[derive(Clone, Debug)]
pub(crate) struct Instruction {
    pub(crate) op: Op,
    /// Where this is not so, nothing is done; [`NONE`] if it always is.
    pub(crate) guard: u32,
    pub(crate) wanted: bool,
    pub(crate) to: [u32; 4],
    pub(crate) from: [u32; 5],
    /// Of an address; or which instruction, list or call.
    pub(crate) offset: i64,
}

/// A call of a function.
#[derive(Clone, Debug)]
pub(crate) struct CallSite {
    pub(crate) function: String,
    /// Where arguments lie in the caller's area for calls.
    pub(crate) arguments: Vec<u32>,
    pub(crate) result: u32,
}

/// A function or a kernel.
#[derive(Clone, Debug, Default)]
pub(crate) struct Function {
    pub(crate) instructions: Vec<Instruction>,
    pub(crate) jump_lists: Vec<Vec<u32>>,
    pub(crate) calls: Vec<CallSite>,
    /// Slots of a frame: registers, then these constants, then addresses of parameters, of the result, and of the area for calls.
    pub(crate) registers: usize,
    pub(crate) constants: Vec<u64>,
    pub(crate) parameters: usize,
    /// Bytes of its variables, and then of its area for calls.
    pub(crate) local_bytes: usize,
    pub(crate) call_bytes: usize,
}

impl Function {
    pub(crate) fn first_parameter(&self) -> usize {
        self.registers + self.constants.len()
    }
    pub(crate) fn slots(&self) -> usize {
        self.first_parameter() + self.parameters + 2
    }
}
