//! Reading PTX: what LLVM makes of Rust, and the instructions that are written by hand.

use crate::execute::Program;
use crate::names::{comparison, computation, memory_type, special, type_of};
use crate::operands::{inside, split, vector};
use crate::program::{CallSite, Function, Instruction, NONE, Op, Type};
use std::collections::HashMap;

/// Reads a module.
pub(crate) fn read(text: &str) -> Result<Program, String> {
    let mut globals = Globals::default();
    let mut functions = Vec::new();
    let mut numbers = HashMap::new();
    let mut lines = text.lines().map(without_comment);
    while let Some(line) = lines.next() {
        let data = line.strip_prefix(".visible ").unwrap_or(line);
        if data.starts_with(".global") || data.starts_with(".const") {
            globals.add(data)?;
        }
        if !(line.contains(".entry ") || line.contains(".func ")) {
            continue;
        }
        let mut head = String::from(line);
        let mut is_declared = false;
        for line in lines.by_ref() {
            if line == "{" {
                break;
            }
            if line == ";" {
                is_declared = true;
                break;
            }
            head.push_str(line);
            head.push('\n');
        }
        if is_declared {
            continue;
        }
        let body = lines.by_ref().take_while(|line| *line != "}");
        let (name, function) = FunctionReader::new(&head, &globals)?.read(body)?;
        numbers.insert(name, functions.len());
        functions.push(function);
    }
    let callee = |call: &CallSite| {
        numbers.get(&call.function).copied().ok_or_else(|| format!("no function {}", call.function))
    };
    let callees = functions
        .iter()
        .map(|function: &Function| function.calls.iter().map(callee).collect())
        .collect::<Result<_, String>>()?;
    Ok(Program { functions, numbers, callees, globals: globals.places })
}

fn without_comment(line: &str) -> &str {
    // Functions end with a brace; calls do not.
    if line.trim_start().starts_with("} // callseq") {
        return "";
    }
    line.split("//").next().unwrap_or("").trim()
}

/// Arrays of the module.
#[derive(Default)]
struct Globals {
    addresses: HashMap<String, u64>,
    /// Address and bytes of each.
    places: HashMap<String, (u64, usize)>,
}

impl Globals {
    /// `.global .align 4 .b8 name[40] = {0, 1};`, or without contents.
    fn add(&mut self, line: &str) -> Result<(), String> {
        let bad = || format!("cannot read: {line}");
        let line = line.trim_end_matches(';');
        let (head, bytes) = line.split_once('=').unwrap_or((line, ""));
        let name_and_size = head.split_whitespace().last().ok_or_else(bad)?;
        let (name, size) = name_and_size.split_once('[').ok_or_else(bad)?;
        if !head.contains(".b8") {
            return Err(bad());
        }
        let size: usize = size.trim_end_matches(']').parse().map_err(|_| bad())?;
        let mut data = vec![0u8; size.next_multiple_of(16)];
        let bytes = bytes.trim_matches([' ', '{', '}']);
        for (place, byte) in
            data.iter_mut().zip(bytes.split(',').map(str::trim).filter(|byte| !byte.is_empty()))
        {
            *place = byte.parse().map_err(|_| bad())?;
        }
        let words: Box<[u128]> = data
            .chunks_exact(16)
            .map(|chunk| u128::from_le_bytes(chunk.try_into().expect("16 bytes")))
            .collect();
        // Modules are kept: processes with this driver are short.
        let words = Box::leak(words).as_mut_ptr();
        self.addresses.insert(name.into(), words as u64);
        self.places.insert(name.into(), (words as u64, size));
        Ok(())
    }
}

struct FunctionReader<'a> {
    globals: &'a Globals,
    name: String,
    function: Function,
    registers: HashMap<String, u32>,
    /// Slots of constants are known at the end: until then they have these numbers.
    constants: HashMap<u64, u32>,
    parameters: HashMap<String, u32>,
    /// Where arguments of the call lie that is being prepared.
    arguments: HashMap<String, u32>,
    argument_bytes: u32,
    labels: HashMap<String, u32>,
    /// Jumps, and to which label.
    jumps: Vec<(usize, String)>,
    lists: HashMap<String, Vec<String>>,
    list_numbers: HashMap<String, usize>,
}

const CONSTANT: u32 = 1 << 30;
const PARAMETER: u32 = 1 << 29;
/// Where the caller wants the result, among parameters.
const RESULT: u32 = PARAMETER | 1 << 28;
/// The area for calls.
const AREA: u32 = RESULT | 1;

/// Registers that every function has: what local variables begin with, and one for what nobody reads.
const LOCAL: u32 = 0;
const UNREAD: u32 = 1;

impl<'a> FunctionReader<'a> {
    fn new(head: &str, globals: &'a Globals) -> Result<Self, String> {
        let bad = || format!("cannot read: {head}");
        let after =
            head.split_once(".entry ").or_else(|| head.split_once(".func ")).ok_or_else(bad)?.1.trim_start();
        let after = match after.strip_prefix('(') {
            Some(result) => result.split_once(')').ok_or_else(bad)?.1,
            None => after,
        };
        let name = after.trim_start().split(['(', '\n', ' ']).next().ok_or_else(bad)?.to_string();
        let name_end = after.find(&name).ok_or_else(bad)? + name.len();
        let list =
            after[name_end..].split_once('(').map_or("", |(_, rest)| rest.split(')').next().unwrap_or(""));
        let mut parameters = HashMap::new();
        for (number, parameter) in list.split(',').map(str::trim).filter(|text| !text.is_empty()).enumerate()
        {
            let own = parameter.split_whitespace().last().ok_or_else(bad)?;
            let own = own.split('[').next().unwrap_or(own);
            parameters.insert(own.to_string(), PARAMETER | number as u32);
        }
        let function = Function { parameters: parameters.len(), ..Function::default() };
        parameters.insert("func_retval0".into(), RESULT);
        Ok(FunctionReader {
            globals,
            name,
            function,
            registers: HashMap::from([("_".into(), UNREAD)]),
            constants: HashMap::new(),
            parameters,
            arguments: HashMap::new(),
            argument_bytes: 0,
            labels: HashMap::new(),
            jumps: Vec::new(),
            lists: HashMap::new(),
            list_numbers: HashMap::new(),
        })
    }

    fn read<'l>(mut self, body: impl Iterator<Item = &'l str>) -> Result<(String, Function), String> {
        let mut pending = String::new();
        for line in body {
            let mut line = line;
            if line.contains(".pragma") || line.is_empty() {
                continue;
            }
            if pending.is_empty() {
                if line == "{" {
                    self.arguments.clear();
                    self.argument_bytes = 0;
                    continue;
                }
                if line == "}" {
                    continue;
                }
                if let Some(label) = line.strip_suffix(':') {
                    self.labels.insert(label.into(), self.function.instructions.len() as u32);
                    continue;
                }
                // A block in one line.
                if line.starts_with('{') {
                    line = line[1..].trim_end().trim_end_matches('}');
                }
            }
            pending.push_str(line);
            pending.push(' ');
            if !line.trim_end().ends_with(';') {
                continue;
            }
            let whole = std::mem::take(&mut pending);
            for statement in whole.split(';').map(str::trim).filter(|statement| !statement.is_empty()) {
                self.statement(statement).map_err(|why| format!("{}: {statement}: {why}", self.name))?;
            }
        }
        self.finish()
    }

    fn finish(mut self) -> Result<(String, Function), String> {
        let registers = self.registers.len() as u32 + 1;
        let mut constants: Vec<(u32, u64)> =
            self.constants.iter().map(|(value, slot)| (*slot, *value)).collect();
        constants.sort();
        self.function.registers = registers as usize;
        self.function.constants = constants.into_iter().map(|(_, value)| value).collect();
        let first_parameter = self.function.first_parameter() as u32;
        let result = first_parameter + self.function.parameters as u32;
        for instruction in &mut self.function.instructions {
            for slot in instruction.to.iter_mut().chain(&mut instruction.from) {
                *slot = match *slot {
                    NONE => UNREAD,
                    AREA => result + 1,
                    RESULT => result,
                    constant if constant & CONSTANT != 0 => registers + (constant & !CONSTANT),
                    parameter if parameter & PARAMETER != 0 => first_parameter + (parameter & !PARAMETER),
                    register => register,
                };
            }
        }
        let at = |label: &String| self.labels.get(label).copied().ok_or_else(|| format!("no label {label}"));
        for (instruction, label) in &self.jumps {
            self.function.instructions[*instruction].offset = at(label)?.into();
        }
        self.function.jump_lists = vec![Vec::new(); self.list_numbers.len()];
        for (name, number) in &self.list_numbers {
            let labels = self.lists.get(name).ok_or_else(|| format!("no list {name}"))?;
            self.function.jump_lists[*number] = labels.iter().map(at).collect::<Result<_, _>>()?;
        }
        // Alignment of what comes after.
        self.function.local_bytes = self.function.local_bytes.next_multiple_of(16);
        Ok((self.name, self.function))
    }

    fn statement(&mut self, statement: &str) -> Result<(), String> {
        if let Some((label, list)) = statement.split_once(": .branchtargets") {
            self.lists
                .insert(label.trim().into(), list.split(',').map(|label| label.trim().into()).collect());
            return Ok(());
        }
        if let Some(declaration) = statement.strip_prefix('.') {
            return self.declaration(declaration);
        }
        let (guard, wanted, statement) = match statement.strip_prefix('@') {
            Some(guarded) => {
                let (guard, rest) = guarded.split_once(char::is_whitespace).ok_or("no instruction")?;
                let wanted = !guard.starts_with('!');
                (self.register(guard.trim_start_matches('!')), wanted, rest.trim())
            }
            None => (NONE, true, statement),
        };
        let (name, operands) = statement.split_once(char::is_whitespace).unwrap_or((statement, ""));
        let mut instruction =
            Instruction { op: Op::Return, guard, wanted, to: [NONE; 4], from: [NONE; 5], offset: 0 };
        self.instruction(name, &split(operands), &mut instruction)?;
        self.function.instructions.push(instruction);
        Ok(())
    }

    /// `.reg`, `.local` and, of a call, `.param`.
    fn declaration(&mut self, declaration: &str) -> Result<(), String> {
        let name = declaration.split_whitespace().last().ok_or("nothing is declared")?;
        let (name, size) = match name.split_once('[') {
            Some((name, size)) => (name, size.trim_end_matches(']').parse().map_err(|_| "no size")?),
            None => (name, 8),
        };
        if declaration.starts_with("local") {
            self.function.local_bytes = size;
        } else if declaration.starts_with("param") {
            self.arguments.insert(name.into(), self.argument_bytes);
            self.argument_bytes = (self.argument_bytes + size as u32).next_multiple_of(16);
            self.function.call_bytes = self.function.call_bytes.max(self.argument_bytes as usize);
        }
        Ok(())
    }

    fn register(&mut self, name: &str) -> u32 {
        // Two are there from the beginning.
        let next = self.registers.len() as u32 + 1;
        *self.registers.entry(name.into()).or_insert(next)
    }

    fn constant(&mut self, value: u64) -> u32 {
        let next = self.constants.len() as u32;
        CONSTANT | *self.constants.entry(value).or_insert(next)
    }

    /// A register, a number or the address of something.
    fn operand(&mut self, text: &str, of: Type) -> Result<u32, String> {
        let bits = |digits: &str| u64::from_str_radix(digits, 16).map_err(|_| format!("what is {text}?"));
        if text.starts_with('%') || text == "p" || text == "tmp" || text == "_" {
            return Ok(self.register(text));
        }
        if let Some(digits) = text.strip_prefix("0f").or(text.strip_prefix("0d")) {
            let value = bits(digits)?;
            return Ok(self.constant(value));
        }
        if let Some(digits) = text.strip_prefix("0x") {
            let value = bits(digits.trim_end_matches('U'))?;
            return Ok(self.constant(value & of.mask()));
        }
        if let Ok(value) = text.trim_end_matches('U').parse::<i128>() {
            return Ok(self.constant(value as u64 & of.mask()));
        }
        if text.starts_with("__local_depot") {
            return Ok(LOCAL);
        }
        if let Some(address) = self.globals.addresses.get(text) {
            return Ok(self.constant(*address));
        }
        Err(format!("what is {text}?"))
    }

    /// `[base+offset]`: the slot of the base, and the offset.
    fn address(&mut self, text: &str) -> Result<(u32, i64), String> {
        let inside = text.strip_prefix('[').and_then(|text| text.strip_suffix(']')).ok_or("no address")?;
        let (base, offset) = match inside.rsplit_once('+') {
            Some((base, offset)) => (base, offset.parse().map_err(|_| "no offset")?),
            None => (inside, 0),
        };
        if let Some(parameter) = self.parameters.get(base) {
            return Ok((*parameter, offset));
        }
        if let Some(argument) = self.arguments.get(base) {
            return Ok((AREA, i64::from(*argument) + offset));
        }
        Ok((self.operand(base, Type::U64)?, offset))
    }

    fn instruction(&mut self, name: &str, operands: &[&str], of: &mut Instruction) -> Result<(), String> {
        let parts: Vec<&str> = name.split('.').collect();
        let kind = parts[parts.len() - 1];
        let own = |text: &str| type_of(text).ok_or_else(|| format!("unknown type {text}"));
        match parts[0] {
            "ret" => of.op = Op::Return,
            "bra" => {
                of.op = Op::Jump;
                self.jumps.push((self.function.instructions.len(), operands[0].into()));
            }
            "brx" => {
                of.op = Op::JumpTo;
                of.from[0] = self.register(operands[0]);
                let next = self.list_numbers.len();
                of.offset = *self.list_numbers.entry(operands[1].into()).or_insert(next) as i64;
            }
            "call" => self.call(operands, of)?,
            "ld" => {
                let (bytes, is_signed) = memory_type(kind)?;
                let to = vector(operands[0]);
                of.op = Op::Load { bytes, is_signed, count: to.len() as u32 };
                for (slot, register) in of.to.iter_mut().zip(to) {
                    *slot = self.register(register);
                }
                (of.from[0], of.offset) = self.address(operands[1])?;
            }
            "st" => {
                let (bytes, _) = memory_type(kind)?;
                let from = vector(operands[1]);
                of.op = Op::Store { bytes, count: from.len() as u32 };
                (of.from[0], of.offset) = self.address(operands[0])?;
                for (slot, value) in of.from[1..].iter_mut().zip(from) {
                    *slot = self.operand(value, Type::U64)?;
                }
            }
            "atom" => {
                of.op = match parts[parts.len() - 2] {
                    "add" => Op::AtomicAdd,
                    "exch" => Op::AtomicExchange,
                    "max" => Op::AtomicMax,
                    other => return Err(format!("unknown: {other}")),
                };
                of.to[0] = self.register(operands[0]);
                (of.from[0], of.offset) = self.address(operands[1])?;
                of.from[1] = self.operand(operands[2], Type::U64)?;
            }
            "mov" => self.copy(kind, operands, of)?,
            "cvta" => self.take(Op::Copy, Type::U64, operands, of)?,
            "setp" => {
                let of_type = own(kind)?;
                let is_float = matches!(of_type, Type::F32 | Type::F64);
                let (comparison, is_unordered) = comparison(parts[1], is_float)?;
                self.take(Op::Compare { comparison, of: of_type, is_unordered }, of_type, operands, of)?;
            }
            "cvt" => {
                let from = own(kind)?;
                let to = own(parts[parts.len() - 2])?;
                let op = if parts[1] == "rmi" { Op::Floor } else { Op::Convert { to, from } };
                self.take(op, from, operands, of)?;
            }
            "shfl" => {
                let is_butterfly = parts[2] == "bfly";
                self.take(Op::Shuffle { is_butterfly }, Type::U32, &operands[..3], of)?;
            }
            "vote" => {
                of.op = Op::Ballot;
                of.to[0] = self.register(operands[0]);
                of.from[0] = self.register(operands[1]);
                of.from[1] = self.operand(operands[2], Type::U32)?;
            }
            "match" => {
                // The lanes themselves are not asked for.
                let (_, agrees) = operands[0].split_once('|').ok_or("no predicate")?;
                of.op = Op::MatchAll;
                of.to[0] = self.register(agrees);
                of.from[0] = self.register(operands[1]);
                of.from[1] = self.operand(operands[2], Type::U32)?;
            }
            "activemask" => {
                of.op = Op::ActiveMask;
                of.to[0] = self.register(operands[0]);
            }
            "selp" => self.take(Op::Select, own(kind)?, operands, of)?,
            _ if kind == "pred" || own(kind).is_ok() => {
                let of_type = own(kind)?;
                let op = computation(&parts, of_type).ok_or("unknown instruction")?;
                self.take(op, of_type, operands, of)?;
            }
            _ => return Err("unknown instruction".into()),
        }
        Ok(())
    }

    /// An instruction with a result and what it takes.
    fn take(&mut self, op: Op, of_type: Type, operands: &[&str], of: &mut Instruction) -> Result<(), String> {
        of.op = op;
        of.to[0] = self.register(operands[0]);
        for (slot, operand) in of.from.iter_mut().zip(&operands[1..]) {
            *slot = self.operand(operand, of_type)?;
        }
        Ok(())
    }

    fn copy(&mut self, kind: &str, operands: &[&str], of: &mut Instruction) -> Result<(), String> {
        let of_type = type_of(kind).ok_or("unknown type")?;
        let bits = of_type.mask().count_ones() / 2;
        let (to, from) = (vector(operands[0]), vector(operands[1]));
        for (slot, register) in of.to.iter_mut().zip(&to) {
            *slot = self.register(register);
        }
        of.op = match (to.len(), from.len()) {
            (2, 1) => Op::Split(bits),
            (1, 2) => Op::Join(bits),
            _ => match special(from[0]) {
                Some(special) => {
                    of.op = Op::Special(special);
                    return Ok(());
                }
                None => Op::Copy,
            },
        };
        for (slot, value) in of.from.iter_mut().zip(from) {
            *slot = self.operand(value, of_type)?;
        }
        Ok(())
    }

    /// `call.uni (retval0), name, (param0, param1)`
    fn call(&mut self, operands: &[&str], of: &mut Instruction) -> Result<(), String> {
        let (result, rest) = match operands[0].starts_with('(') {
            true => (self.arguments.get(inside(operands[0])).copied().unwrap_or(0), &operands[1..]),
            false => (0, operands),
        };
        let arguments = rest.get(1).map_or("", |list| inside(list));
        let at = |name: &str| self.arguments.get(name).copied().ok_or_else(|| format!("no argument {name}"));
        let arguments = arguments
            .split(',')
            .map(str::trim)
            .filter(|name| !name.is_empty())
            .map(at)
            .collect::<Result<Vec<u32>, String>>()?;
        of.op = Op::Call;
        of.offset = self.function.calls.len() as i64;
        self.function.calls.push(CallSite { function: rest[0].into(), arguments, result });
        Ok(())
    }
}
