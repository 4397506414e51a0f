//! Numbers, dates and conditions in words.

use crate::comparison::Verdict;
use crate::experiment::{Clock, Experiment, Measure};
use crate::machine::Machine;
use crate::program::Program;
use crate::quantity::MILLISECONDS;
use jiff::Timestamp;

/// So many digits that four count.
pub(super) fn number(value: f64) -> String {
    if value.abs() >= 1e10 {
        return format!("{value:.3e}");
    }
    let digits = (3.0 - value.abs().max(1e-12).log10().floor()).clamp(0.0, 9.0) as usize;
    format!("{value:.digits$}")
}

/// A ratio with two digits that count, or two after the point.
pub(super) fn ratio(value: f64) -> String {
    let digits = (1.0 - value.abs().max(1e-9).log10().floor()).clamp(2.0, 9.0) as usize;
    format!("{value:.digits$}")
}

/// Both ends of an interval.
pub(super) fn range(interval: Option<[f64; 2]>) -> String {
    interval.map_or("–".to_owned(), |[low, high]| format!("{} to {}", number(low), number(high)))
}

/// What the values of a quantity count, by the clock that the experiment asks for.
pub(super) fn unit_of(experiment: &Experiment, unit: &str) -> String {
    match (experiment.clock, unit) {
        (Clock::Cpu, MILLISECONDS) => "CPU ms".to_owned(),
        (_, unit) => unit.to_owned(),
    }
}

/// Millions of rays a second, of a time in milliseconds.
pub(super) fn rate(value: f64, work: Option<u64>, unit: &str) -> Option<f64> {
    let work = work.filter(|_| unit == MILLISECONDS && value > 0.0)?;
    Some(work as f64 * 1e-3 / value)
}

/// What may be said, in words.
pub(super) fn verdict(verdict: &Verdict, unit: &str) -> String {
    let is_time = unit == MILLISECONDS;
    match verdict {
        Verdict::Base => "base".to_owned(),
        Verdict::Less => if is_time { "faster" } else { "less" }.to_owned(),
        Verdict::More => if is_time { "slower" } else { "more" }.to_owned(),
        Verdict::NoDifferenceSeen => "no difference seen".to_owned(),
        Verdict::WithinNoise => "within the noise".to_owned(),
        Verdict::NoClaim(why) => format!("no claim: {why}"),
        Verdict::OtherWork => "different work: no ratio".to_owned(),
        Verdict::OtherAnswers => "different answers: no ratio".to_owned(),
        Verdict::NotMeasured(why) => format!("not measured: {why}"),
    }
}

/// What is measured, for a reader who does not know the program.
pub(super) fn measured(measure: Measure) -> &'static str {
    match measure {
        Measure::Picture => {
            "A time is that of a picture, from a scene that is loaded and whose hierarchy is built, to the whole picture in the memory of the \
             CPU."
        }
        Measure::Rays => {
            "A time is that of all queries of a set of rays, after the hierarchy was built; \u{201c}build\u{201d} is the time for that. Camera \
             rays are called primary; bounce rays leave what they hit; shuffled ones are bounce rays in random order. On GPUs it is that of \
             the kernel alone."
        }
        Measure::Noise => {
            "The noise of a picture is the standard deviation of its values by chance: the root mean square of the difference of two pictures \
             with other random numbers, over the root of two. It is the same on every machine, whatever else runs there."
        }
        Measure::Process => {
            "A time is that of a whole process, from its start to its end, with reading and writing files."
        }
    }
}

/// How often a process does its work.
pub(super) fn repeated(experiment: &Experiment) -> String {
    match experiment.measures {
        Measure::Process => "each does its work once".to_owned(),
        Measure::Picture | Measure::Rays | Measure::Noise => {
            let count = counted(experiment.repetitions(), "repetition");
            format!("{count} in each process, after one to warm up unless its arguments say otherwise")
        }
    }
}

/// `3 repetitions`, `1 repetition`.
pub(super) fn counted(count: impl Into<u64>, noun: &str) -> String {
    match count.into() {
        1 => format!("1 {noun}"),
        count => format!("{count} {noun}s"),
    }
}

/// The beginning of a text, with so many characters.
pub(super) fn shortened(text: &str, most: usize) -> String {
    match text.char_indices().nth(most) {
        Some(_) => text.chars().take(most.saturating_sub(1)).chain(['…']).collect(),
        None => text.to_owned(),
    }
}

/// A time in seconds since 1970, as UTC.
pub(super) fn utc(seconds: u64) -> String {
    let timestamp = i64::try_from(seconds).ok().and_then(|seconds| Timestamp::from_second(seconds).ok());
    timestamp.map_or("not known".to_owned(), |time| time.strftime("%Y-%m-%d %H:%M UTC").to_string())
}

/// Its processor and how many cores of it each process could use, and its GPUs.
pub(super) fn machine_in_short(machine: &Machine, cores: Option<usize>) -> String {
    let cpu = machine.cpu.as_deref().unwrap_or("a processor that the system does not name");
    let allowed = machine.allowed_cores.len().max(1);
    let cores = match cores.map_or(allowed, |cores| cores.min(allowed)) {
        1 => "1 core".to_owned(),
        n => format!("{n} cores"),
    };
    let gpus = machine.gpus.iter().map(|gpu| format!(", {}, driver {}", gpu.name, gpu.driver));
    format!("{cores} of {cpu}{}", gpus.collect::<String>())
}

/// Names and values of all that is known of a machine.
pub(super) fn machine_fields(machine: &Machine) -> Vec<(&'static str, String)> {
    let known = |text: &Option<String>| text.clone().unwrap_or_else(|| "not told by the system".to_owned());
    let smt = match machine.smt {
        Some(true) => "yes: two of these share a core of the processor",
        Some(false) => "no",
        None => "not told by the system",
    };
    let gib = |bytes: u64| format!("{:.1} GiB", bytes as f64 / f64::from(1 << 30));
    let mut fields = vec![
        ("Processor", known(&machine.cpu)),
        ("Cores", machine.cores.to_string()),
        (
            "Cores it may use",
            match machine.allowed_cores.len() {
                0 => "all".into(),
                count => format!("{count} (numbers {})", shortened(&ranges(&machine.allowed_cores), 200)),
            },
        ),
        ("SMT", smt.to_owned()),
        ("Caches", if machine.caches.is_empty() { known(&None) } else { machine.caches.join(", ") }),
        ("Memory", machine.memory_bytes.map_or_else(|| known(&None), gib)),
        ("Huge pages", known(&machine.huge_pages)),
        ("Governor", known(&machine.governor)),
        ("System", machine.system.clone()),
    ];
    for gpu in &machine.gpus {
        let parts = [&gpu.name, &gpu.memory, &gpu.clock, &gpu.power_limit].map(|part| &part[..]);
        fields.push(("GPU", format!("{}, driver {}", parts.join(", "), gpu.driver)));
    }
    if machine.gpus.is_empty() {
        fields.push(("GPU", "none".to_owned()));
    }
    fields
}

/// Numbers in increasing order, rows of them by their ends: `0-3, 8`.
fn ranges(numbers: &[usize]) -> String {
    let rows = numbers.chunk_by(|one, next| one.checked_add(1) == Some(*next));
    let row = |row: &[usize]| match row {
        [first, .., last] => format!("{first}-{last}"),
        row => row.iter().map(usize::to_string).collect(),
    };
    rows.map(row).collect::<Vec<_>>().join(", ")
}

/// Names and values of all that is known of a program.
pub(super) fn program_fields(program: &Program) -> Vec<(&'static str, String)> {
    let features = if program.features.is_empty() { "none".into() } else { program.features.join(", ") };
    vec![
        ("Eosphor", program.version.clone()),
        ("Commit", program.commit.clone().unwrap_or_else(|| "not known".to_owned())),
        ("Compiler", program.compiler.clone()),
        ("Profile", program.profile.clone()),
        ("Features", features),
        ("Hash of its file", program.hash.clone()),
    ]
}

/// The command of Eosphor that all variants have, up to their own arguments.
pub(super) fn held_command(experiment: &Experiment) -> String {
    let command = match experiment.measures {
        Measure::Picture => "eosphor bench render",
        Measure::Rays => "eosphor bench rays",
        Measure::Noise => "eosphor bench noise",
        Measure::Process => "eosphor",
    };
    [command.to_owned()]
        .into_iter()
        .chain(experiment.held.iter().map(|word| quoted(word)))
        .collect::<Vec<_>>()
        .join(" ")
}

/// A word of a command line, as a shell reads it.
pub(super) fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "-_./:=,+%@{}".contains(c);
    match !word.is_empty() && word.chars().all(is_plain) {
        true => word.to_owned(),
        false => format!("'{}'", word.replace('\'', r"'\''")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_dates() {
        for (value, text) in [
            (0.0, "0.000000000"),
            (1.23456, "1.235"),
            (12345.6, "12346"),
            (0.00123456, "0.001235"),
            (1e300, "1.000e300"),
        ] {
            assert_eq!(number(value), text);
        }
        assert_eq!(ranges(&[0, 1, 2, 5, 7, 8]), "0-2, 5, 7-8");
        assert_eq!(utc(0), "1970-01-01 00:00 UTC");
        assert_eq!(utc(1_764_000_000), "2025-11-24 16:00 UTC");
        assert_eq!(utc(u64::MAX), "not known");
        assert_eq!((shortened("abc", 3), shortened("äbcd", 3)), ("abc".into(), "äb…".into()));
        assert_eq!([quoted("a-b"), quoted("it's"), quoted("")], ["a-b", r"'it'\''s'", "''"]);
    }
}
