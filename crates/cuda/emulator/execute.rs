//! A warp, instruction by instruction: those of its threads that are at the same instruction execute it together.

use crate::compute::computed;
use crate::program::{Function, Instruction, NONE, Op, Special, Type};
use std::collections::HashMap;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

/// Functions of a module, by name and number.
pub(crate) struct Program {
    pub(crate) functions: Vec<Function>,
    pub(crate) numbers: HashMap<String, usize>,
    /// Of each function and each of its calls, which function that is.
    pub(crate) callees: Vec<Vec<usize>>,
    /// Address and bytes of each array of the module.
    pub(crate) globals: HashMap<String, (u64, usize)>,
}

/// Threads of a warp.
pub(crate) const WARP: usize = 32;

/// Where a warp is in its launch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    pub(crate) first_thread: u32,
    pub(crate) block: u32,
    pub(crate) block_size: u32,
    pub(crate) blocks: u32,
}

/// Bytes for the variables of a thread.
const LOCAL_BYTES: usize = 1 << 15;

/// A number of each thread.
type Slot = [u64; WARP];

/// Room for a warp. Functions do not call themselves, so each has slots of its own.
pub(crate) struct Warp<'p> {
    program: &'p Program,
    slots: Vec<Slot>,
    /// Where the slots of each function begin.
    first: Vec<usize>,
    local: Vec<u128>,
    place: Place,
}

/// The lanes of a mask.
fn lanes(mask: u32) -> impl Iterator<Item = usize> {
    let mut left = mask;
    std::iter::from_fn(move || {
        let lane = left.trailing_zeros() as usize;
        left &= left.wrapping_sub(1);
        (lane < WARP).then_some(lane)
    })
}

/// Which of these lanes are at an instruction.
fn at_one(at: &[u32; WARP], of: u32, instruction: u32) -> u32 {
    lanes(of).filter(|&lane| at[lane] == instruction).fold(0, |group, lane| group | 1 << lane)
}

impl<'p> Warp<'p> {
    pub(crate) fn new(program: &'p Program, place: Place) -> Warp<'p> {
        let mut slots = Vec::new();
        let mut first = Vec::new();
        for function in &program.functions {
            first.push(slots.len());
            slots.resize(slots.len() + function.registers, [0; WARP]);
            slots.extend(function.constants.iter().map(|constant| [*constant; WARP]));
            slots.resize(slots.len() + function.parameters + 2, [0; WARP]);
        }
        Warp { program, slots, first, local: vec![0; WARP * LOCAL_BYTES / size_of::<u128>()], place }
    }

    /// Runs a kernel, whose parameters have these addresses, for as many threads.
    ///
    /// # Safety
    ///
    /// What it reads and writes is there.
    pub(crate) unsafe fn run_kernel(
        &mut self,
        kernel: usize,
        parameters: &[u64],
        place: Place,
        threads: u32,
    ) {
        self.place = place;
        let first = self.first[kernel] + self.program.functions[kernel].first_parameter();
        for (slot, parameter) in self.slots[first..].iter_mut().zip(parameters) {
            *slot = [*parameter; WARP];
        }
        let mask = if threads == WARP as u32 { u32::MAX } else { (1 << threads) - 1 };
        // SAFETY: by this function's contract.
        unsafe { self.run(kernel, mask, 0) };
    }

    /// Runs a function for the threads of this mask, whose variables begin at `local`.
    ///
    /// # Safety
    ///
    /// As for [`Warp::run_kernel`].
    unsafe fn run(&mut self, number: usize, mask: u32, local: usize) {
        let program = self.program;
        let function = &program.functions[number];
        let base = self.first[number];
        let end = local + function.local_bytes + function.call_bytes;
        assert!(end <= LOCAL_BYTES, "the stack is too small");
        let memory = self.local.as_mut_ptr() as usize;
        for lane in lanes(mask) {
            let own = memory + lane * LOCAL_BYTES + local;
            self.slots[base][lane] = own as u64;
            self.slots[base + function.slots() - 1][lane] = (own + function.local_bytes) as u64;
        }
        let mut at = [0u32; WARP];
        // Those that wait for others to vote or exchange with.
        let (mut live, mut waiting) = (mask, 0u32);
        while live != 0 {
            let ready = live & !waiting;
            if ready == 0 {
                // Those that others wait for may have ended meanwhile.
                let together = |lane: usize| at_one(&at, live, at[lane]);
                let done = lanes(live)
                    .map(|lane| {
                        self.exchange(&function.instructions[at[lane] as usize], base, together(lane), live)
                    })
                    .find(|done| *done != 0)
                    .expect("threads of a warp wait for others that do not come");
                lanes(done).for_each(|lane| at[lane] += 1);
                waiting &= !done;
                continue;
            }
            // Those that are farthest behind go first: so all meet again where ways join.
            let mut next = lanes(ready).map(|lane| at[lane]).min().expect("there is one");
            let group = at_one(&at, ready, next);
            let others = lanes(ready & !group).map(|lane| at[lane]).min().unwrap_or(u32::MAX);
            loop {
                let instruction = &function.instructions[next as usize];
                let mut active = group;
                if instruction.guard != NONE {
                    let guard = &self.slots[base + instruction.guard as usize];
                    let is_set = lanes(group).fold(0, |set, lane| set | u32::from(guard[lane] != 0) << lane);
                    active = if instruction.wanted { is_set } else { group & !is_set };
                }
                let rest = group & !active;
                next += 1;
                match instruction.op {
                    Op::Jump => {
                        let target = instruction.offset as u32;
                        if rest == 0 {
                            next = target;
                        } else if active != 0 {
                            lanes(active).for_each(|lane| at[lane] = target);
                            lanes(rest).for_each(|lane| at[lane] = next);
                            break;
                        }
                    }
                    Op::JumpTo => {
                        let list = &function.jump_lists[instruction.offset as usize];
                        let which = &self.slots[base + instruction.from[0] as usize];
                        lanes(rest).for_each(|lane| at[lane] = next);
                        lanes(active).for_each(|lane| at[lane] = list[which[lane] as usize]);
                        break;
                    }
                    Op::Return => {
                        live &= !active;
                        lanes(rest).for_each(|lane| at[lane] = next);
                        break;
                    }
                    Op::Call if active != 0 => {
                        let call = &function.calls[instruction.offset as usize];
                        let callee = program.callees[number][instruction.offset as usize];
                        let of = &program.functions[callee];
                        let area = local + function.local_bytes;
                        let first = self.first[callee] + of.first_parameter();
                        for lane in lanes(active) {
                            let area = memory + lane * LOCAL_BYTES + area;
                            for (k, offset) in call.arguments.iter().enumerate() {
                                self.slots[first + k][lane] = (area + *offset as usize) as u64;
                            }
                            self.slots[first + of.parameters][lane] = (area + call.result as usize) as u64;
                        }
                        // SAFETY: by this function's contract.
                        unsafe { self.run(callee, active, end.next_multiple_of(16)) };
                    }
                    Op::Shuffle { .. } | Op::Ballot | Op::MatchAll | Op::ActiveMask => {
                        lanes(group).for_each(|lane| at[lane] = next - 1);
                        let here = group | at_one(&at, waiting, next - 1);
                        let done = self.exchange(instruction, base, here, live);
                        lanes(done).for_each(|lane| at[lane] = next);
                        waiting = (waiting | here) & !done;
                        break;
                    }
                    // SAFETY: by this function's contract.
                    _ => unsafe { self.execute(instruction, base, active) },
                }
                if next >= others {
                    lanes(group).for_each(|lane| at[lane] = next);
                    break;
                }
            }
        }
    }

    /// Exchanges numbers between the lanes that came `here`, as far as all that they exchange with are among them. Gives back which
    /// ones are.
    fn exchange(&mut self, instruction: &Instruction, base: usize, here: u32, live: u32) -> u32 {
        let [given, with] = [0, 1].map(|k| self.slots[base + instruction.from[k] as usize]);
        let to = &mut self.slots[base + instruction.to[0] as usize];
        let partners = |lane: usize| match instruction.op {
            Op::Shuffle { .. } => u32::MAX,
            Op::ActiveMask => here,
            _ => with[lane] as u32,
        };
        let done = lanes(here)
            .filter(|&lane| partners(lane) & live & !here == 0)
            .fold(0, |done, lane| done | 1u32 << lane);
        for lane in lanes(done) {
            let own = partners(lane) & here;
            let of = |lane: usize| if own >> lane & 1 != 0 { given[lane] } else { 0 };
            to[lane] = match instruction.op {
                Op::Shuffle { is_butterfly: true } => of((lane ^ with[lane] as usize) % WARP),
                Op::Shuffle { is_butterfly: false } => of(with[lane] as usize % WARP),
                Op::Ballot => {
                    lanes(own).fold(0, |set, lane| set | u32::from(given[lane] != 0) << lane).into()
                }
                Op::MatchAll => lanes(own).all(|other| given[other] == given[lane]).into(),
                _ => own.into(),
            };
        }
        done
    }

    /// Executes an instruction that is each thread's own.
    ///
    /// # Safety
    ///
    /// As for [`Warp::run_kernel`].
    unsafe fn execute(&mut self, instruction: &Instruction, base: usize, active: u32) {
        let Instruction { op, to, from, offset, .. } = *instruction;
        let slots = &mut self.slots[base..];
        let value = |slots: &[Slot], k: usize, lane: usize| slots[from[k] as usize][lane];
        match op {
            Op::Load { bytes, is_signed, count } => {
                for lane in lanes(active) {
                    let address = (value(slots, 0, lane) as i64 + offset) as usize;
                    for k in 0..count as usize {
                        // SAFETY: by this function's contract.
                        slots[to[k] as usize][lane] =
                            unsafe { load(address + k * bytes as usize, bytes, is_signed) };
                    }
                }
            }
            Op::Store { bytes, count } => {
                for lane in lanes(active) {
                    let address = (value(slots, 0, lane) as i64 + offset) as usize;
                    for k in 0..count as usize {
                        // SAFETY: by this function's contract.
                        unsafe { store(address + k * bytes as usize, bytes, value(slots, 1 + k, lane)) };
                    }
                }
            }
            Op::Split(bits) => {
                for lane in lanes(active) {
                    let whole = value(slots, 0, lane);
                    slots[to[0] as usize][lane] = whole & ((1 << bits) - 1);
                    slots[to[1] as usize][lane] = whole >> bits & ((1 << bits) - 1);
                }
            }
            Op::Special(special) => {
                for lane in lanes(active) {
                    slots[to[0] as usize][lane] = self.place.answer(special, lane);
                }
            }
            Op::AtomicAdd | Op::AtomicExchange | Op::AtomicMax => {
                for lane in lanes(active) {
                    let address = (value(slots, 0, lane) as i64 + offset) as usize as *mut u64;
                    // SAFETY: by this function's contract, and it is touched by atomic operations alone.
                    let number = unsafe { AtomicU64::from_ptr(address) };
                    let with = value(slots, 1, lane);
                    slots[to[0] as usize][lane] = match op {
                        Op::AtomicAdd => number.fetch_add(with, Ordering::Relaxed),
                        Op::AtomicMax => number.fetch_max(with, Ordering::Relaxed),
                        _ => number.swap(with, Ordering::Relaxed),
                    };
                }
            }
            // Those that are frequent have loops of their own.
            Op::Add(Type::F32) => each(slots, instruction, active, |n| computed(Op::Add(Type::F32), n)),
            Op::Subtract(Type::F32) => {
                each(slots, instruction, active, |n| computed(Op::Subtract(Type::F32), n))
            }
            Op::Multiply(Type::F32) => {
                each(slots, instruction, active, |n| computed(Op::Multiply(Type::F32), n))
            }
            Op::MultiplyAdd(Type::F32) => {
                each(slots, instruction, active, |n| computed(Op::MultiplyAdd(Type::F32), n))
            }
            Op::Least(Type::F32) => each(slots, instruction, active, |n| computed(Op::Least(Type::F32), n)),
            Op::Greatest(Type::F32) => {
                each(slots, instruction, active, |n| computed(Op::Greatest(Type::F32), n))
            }
            Op::Add(Type::U64 | Type::S64) => {
                each(slots, instruction, active, |n| computed(Op::Add(Type::U64), n))
            }
            Op::Add(Type::U32 | Type::S32) => {
                each(slots, instruction, active, |n| computed(Op::Add(Type::U32), n))
            }
            Op::Copy => each(slots, instruction, active, |n| computed(Op::Copy, n)),
            Op::And => each(slots, instruction, active, |n| computed(Op::And, n)),
            Op::Or => each(slots, instruction, active, |n| computed(Op::Or, n)),
            Op::Xor => each(slots, instruction, active, |n| computed(Op::Xor, n)),
            Op::Select => each(slots, instruction, active, |n| computed(Op::Select, n)),
            other => each(slots, instruction, active, |n| computed(other, n)),
        }
    }
}

/// Computes something of each thread.
#[inline(always)]
fn each(slots: &mut [Slot], instruction: &Instruction, active: u32, compute: impl Fn([u64; 3]) -> u64) {
    let [a, b, c, ..] = instruction.from.map(|slot| slot as usize);
    let to = instruction.to[0] as usize;
    assert!(a.max(b).max(c).max(to) < slots.len());
    let first: *mut Slot = slots.as_mut_ptr();
    // SAFETY: the slots are there, as was just asserted. One may be another, so they are no references.
    let compute_lane = |lane: usize| unsafe {
        let slot = |number: usize| first.add(number).cast::<u64>().add(lane);
        let taken = [slot(a).read(), slot(b).read(), slot(c).read()];
        slot(to).write(compute(taken));
    };
    if active == u32::MAX {
        (0..WARP).for_each(compute_lane);
    } else {
        lanes(active).for_each(compute_lane);
    }
}

impl Place {
    fn answer(&self, special: Special, lane: usize) -> u64 {
        match special {
            Special::Thread => u64::from(self.first_thread) + lane as u64,
            Special::Block => self.block.into(),
            Special::BlockSize => self.block_size.into(),
            Special::Blocks => self.blocks.into(),
            Special::Clock | Special::Nanoseconds => {
                static START: OnceLock<Instant> = OnceLock::new();
                START.get_or_init(Instant::now).elapsed().as_nanos() as u64
            }
        }
    }
}

/// # Safety
///
/// So many bytes are there.
unsafe fn load(address: usize, bytes: u32, is_signed: bool) -> u64 {
    // SAFETY: by this function's contract.
    unsafe {
        match (bytes, is_signed) {
            (1, _) => u64::from((address as *const u8).read()),
            (2, _) => u64::from((address as *const u16).read()),
            (4, true) => i64::from((address as *const i32).read()) as u64,
            (4, false) => u64::from((address as *const u32).read()),
            _ => (address as *const u64).read(),
        }
    }
}

/// # Safety
///
/// So many bytes are there.
unsafe fn store(address: usize, bytes: u32, value: u64) {
    // SAFETY: by this function's contract.
    unsafe {
        match bytes {
            1 => (address as *mut u8).write(value as u8),
            2 => (address as *mut u16).write(value as u16),
            4 => (address as *mut u32).write(value as u32),
            _ => (address as *mut u64).write(value),
        }
    }
}
