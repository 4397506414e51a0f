//! The machine that an experiment runs on. Names of hosts and users are left out.

use serde::{Deserialize, Serialize};
use std::fs;
use std::process::{Command, Stdio};

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
    /// Its GPUs, as `nvidia-smi` tells of them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub gpus: Vec<Gpu>,
}

/// A GPU of a machine, in the words of `nvidia-smi`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Gpu {
    /// Its model.
    pub name: String,
    /// The version of its driver.
    pub driver: String,
    /// Its memory.
    pub memory: String,
    /// The most that its multiprocessors are clocked at.
    pub clock: String,
    /// The most power that it may take.
    pub power_limit: String,
}

/// What `nvidia-smi` is asked, in the order of the fields of [`Gpu`].
const GPU_QUERY: &str = "--query-gpu=name,driver_version,memory.total,clocks.max.sm,power.limit";

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
            gpus: gpus(),
        }
    }
}

/// What `nvidia-smi` says; nothing where there is none.
fn gpus() -> Vec<Gpu> {
    let mut command = Command::new("nvidia-smi");
    let output = command.args([GPU_QUERY, "--format=csv,noheader"]).stderr(Stdio::null()).output();
    match output {
        Ok(output) if output.status.success() => gpus_of(&String::from_utf8_lossy(&output.stdout)),
        _ => Vec::new(),
    }
}

fn gpus_of(text: &str) -> Vec<Gpu> {
    let of_line = |line: &str| {
        let fields: Vec<String> = line.split(',').map(|field| field.trim().to_owned()).collect();
        let [name, driver, memory, clock, power_limit] = fields.try_into().ok()?;
        Some(Gpu { name, driver, memory, clock, power_limit })
    };
    text.lines().filter_map(of_line).collect()
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
    fn gpus_of_a_known_text() {
        let text = "NVIDIA H100 80GB HBM3, 580.159.04, 81559 MiB, 1980 MHz, 700.00 W\nno line\n";
        let [gpu] = &gpus_of(text)[..] else { panic!("one") };
        assert_eq!((&gpu.name[..], &gpu.power_limit[..]), ("NVIDIA H100 80GB HBM3", "700.00 W"));
    }

    #[test]
    fn this_machine_has_a_core_and_comes_back_from_json() {
        let machine = Machine::this_one();
        assert!(machine.cores >= 1);
        let text = serde_json::to_string(&machine).unwrap();
        assert_eq!(serde_json::from_str::<Machine>(&text).unwrap(), machine);
    }
}
