//! The machine that an experiment runs on. Names of hosts and users are left out.

use serde::{Deserialize, Serialize};
use std::fs;

/// What the system tells of a machine; what it does not tell is not there.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Machine {
    /// The model of its processor.
    pub cpu: Option<String>,
    /// Cores that the system has, as it counts them.
    pub cores: usize,
    /// Those that this process may use.
    pub allowed_cores: Vec<usize>,
    /// Whether two of these share one of the processor's.
    pub smt: Option<bool>,
    /// Sizes of the first core's caches: `L1d 48K`.
    pub caches: Vec<String>,
    /// Bytes of memory.
    pub memory_bytes: Option<u64>,
    /// When it uses huge pages by itself.
    pub huge_pages: Option<String>,
    /// What decides how quick cores are.
    pub governor: Option<String>,
    /// The system and its version.
    pub system: String,
}

impl Machine {
    /// This one.
    pub fn this_one() -> Machine {
        let read = |path: &str| Some(fs::read_to_string(path).ok()?.trim().to_owned());
        let cpu = read("/proc/cpuinfo").and_then(|text| value_of(&text, "model name"));
        let memory = read("/proc/meminfo").and_then(|text| value_of(&text, "MemTotal"));
        let kilobytes = memory.and_then(|text| text.split_whitespace().next()?.parse::<u64>().ok());
        let caches = (0..8).filter_map(|index| {
            let of = |name: &str| read(&format!("/sys/devices/system/cpu/cpu0/cache/index{index}/{name}"));
            let kind = match of("type")?.as_str() {
                "Data" => "d",
                "Instruction" => "i",
                _ => "",
            };
            Some(format!("L{}{kind} {}", of("level")?, of("size")?))
        });
        let kernel = read("/proc/sys/kernel/osrelease").unwrap_or_default();
        Machine {
            cpu,
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            allowed_cores: crate::process::allowed_cores(),
            smt: read("/sys/devices/system/cpu/smt/active").map(|text| text == "1"),
            caches: caches.collect(),
            memory_bytes: kilobytes.map(|kilobytes| kilobytes * 1024),
            huge_pages: read("/sys/kernel/mm/transparent_hugepage/enabled").and_then(|text| chosen(&text)),
            governor: read("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor"),
            system: format!("{} {} {kernel}", std::env::consts::OS, std::env::consts::ARCH).trim().to_owned(),
        }
    }
}

/// The value of `name: value`, the first time.
fn value_of(text: &str, name: &str) -> Option<String> {
    let of_line = |line: &str| {
        let (key, value) = line.split_once(':')?;
        (key.trim() == name).then(|| value.trim().to_owned())
    };
    text.lines().find_map(of_line)
}

/// The choice in brackets: `always [madvise] never`.
fn chosen(text: &str) -> Option<String> {
    let (_, rest) = text.split_once('[')?;
    Some(rest.split_once(']')?.0.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_of_known_texts() {
        let text = "processor\t: 0\nmodel name\t: A CPU: fast\nmodel name\t: another\n";
        assert_eq!(value_of(text, "model name").as_deref(), Some("A CPU: fast"));
        assert_eq!(value_of(text, "flags"), None);
        assert_eq!(chosen("always [madvise] never").as_deref(), Some("madvise"));
        assert_eq!(chosen("nothing"), None);
    }

    #[test]
    fn this_machine_has_a_core_and_comes_back_from_json() {
        let machine = Machine::this_one();
        assert!(machine.cores >= 1);
        let text = serde_json::to_string(&machine).unwrap();
        assert_eq!(serde_json::from_str::<Machine>(&text).unwrap(), machine);
    }
}
