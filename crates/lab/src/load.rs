//! What else runs on the cores of a process: other programs, and other machines of the same host.

use serde::{Deserialize, Serialize};

/// What cores have done since the machine was started, in seconds summed over them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct CoreTimes {
    busy: f64,
    stolen: f64,
    /// Of the cores that were not asked for.
    elsewhere: f64,
    /// How many were asked for, and how many were not.
    counts: [u32; 2],
}

/// What was seen just before a process, and while it ran.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Load {
    /// Cores' worth of work by other processes, on the cores that the process could use.
    pub other_cores: f64,
    /// Cores' worth of time that the host gave to others.
    pub stolen_cores: f64,
    /// Cores' worth of work by others on the same cores, in a tenth of a second before the process.
    pub before_cores: f64,
    /// Cores' worth of work on all other cores of the machine.
    pub elsewhere_cores: f64,
    /// The clock of the cores before and after the process, where the system tells.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub megahertz: Option<[f64; 2]>,
}

/// More than this for each core, and once more, counts as disturbed: other programs, and the host.
const MOST_OTHER: f64 = 0.05;
const MOST_STOLEN: f64 = 0.025;

/// Seconds between two looks of the system at a core.
const TICK: f64 = 0.01;

/// Six digits after the point, which say enough and come back from a file as they were.
pub(crate) fn rounded(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}

impl Load {
    /// Whether a measurement under this load is not to be trusted, of a process that could use so many cores.
    pub fn disturbs(&self, cores: usize) -> bool {
        let parts = (cores + 1) as f64;
        self.other_cores > MOST_OTHER * parts || self.stolen_cores > MOST_STOLEN * parts
    }

    /// That of a process which took so many seconds of these cores' time, over so many seconds.
    pub(crate) fn between(before: CoreTimes, after: CoreTimes, own: f64, seconds: f64) -> Load {
        // What is certain: the clock of each core ticks in hundredths, so a tick more may be that of an instant.
        let cores = |spent: f64, count: u32| {
            rounded(((spent - TICK * f64::from(count)) / seconds.max(TICK)).max(0.0))
        };
        let [here, elsewhere] = after.counts;
        Load {
            other_cores: cores(after.busy - before.busy - own, here),
            stolen_cores: cores(after.stolen - before.stolen, here),
            elsewhere_cores: cores(after.elsewhere - before.elsewhere, elsewhere),
            ..Load::default()
        }
    }
}

/// The times of these cores. `None` where the system does not tell.
pub(crate) fn core_times(cores: &[usize]) -> Option<CoreTimes> {
    let text = std::fs::read_to_string("/proc/stat").ok()?;
    of_text(&text, cores)
}

/// Of the text of Linux's `/proc/stat`: `cpu3 user nice system idle iowait irq softirq steal ...`, in hundredths of a second.
fn of_text(text: &str, cores: &[usize]) -> Option<CoreTimes> {
    let mut sum = CoreTimes::default();
    let lines = text.lines().filter_map(|line| line.strip_prefix("cpu")?.split_once(' '));
    for (number, rest) in lines {
        // The first line is that of all cores together.
        let Ok(number) = number.parse::<usize>() else { continue };
        let ticks: Vec<f64> = rest.split_whitespace().map_while(|word| word.parse().ok()).collect();
        let [user, nice, system, _, _, irq, soft_irq, stolen, ..] = ticks[..] else { return None };
        let busy = (user + nice + system + irq + soft_irq) * TICK;
        if cores.contains(&number) {
            sum.counts[0] += 1;
            sum.busy += busy;
            sum.stolen += stolen * TICK;
        } else {
            sum.counts[1] += 1;
            sum.elsewhere += busy;
        }
    }
    (sum.counts[0] as usize == cores.len()).then_some(sum)
}

/// The mean clock of these cores in megahertz. `None` where the system does not tell.
pub(crate) fn clock_megahertz(cores: &[usize]) -> Option<f64> {
    let of_core = |core: &usize| {
        let path = format!("/sys/devices/system/cpu/cpu{core}/cpufreq/scaling_cur_freq");
        Some(std::fs::read_to_string(path).ok()?.trim().parse::<f64>().ok()? * 1e-3)
    };
    let clocks: Option<Vec<f64>> = cores.iter().map(of_core).collect();
    let clocks = clocks.or_else(|| {
        let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
        let of_line = |line: &str| line.strip_prefix("cpu MHz")?.split_once(':')?.1.trim().parse().ok();
        let all: Vec<f64> = text.lines().filter_map(of_line).collect();
        cores.iter().map(|&core| all.get(core).copied()).collect()
    })?;
    (!clocks.is_empty()).then(|| rounded(clocks.iter().sum::<f64>() / clocks.len() as f64))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cores_of_a_known_text() {
        let text = "cpu  1 1 1 1 1 1 1 1 1 1\ncpu0 100 0 50 900 3 0 10 20 0 0\ncpu1 200 100 0 0 0 0 0 0 0 0\ncpu10 9 9 9 9 9 9 9 9\nintr 5\n";
        let is = |cores: &[usize], [busy, stolen, elsewhere]: [f64; 3], counts| {
            let times = of_text(text, cores).unwrap();
            let near = |value: f64, expected: f64| (value - expected).abs() < 1e-12;
            assert!(near(times.busy, busy) && near(times.stolen, stolen) && near(times.elsewhere, elsewhere));
            assert_eq!(times.counts, counts);
        };
        is(&[0], [1.6, 0.2, 3.45], [1, 2]);
        is(&[0, 1], [4.6, 0.2, 0.45], [2, 1]);
        assert_eq!(of_text(text, &[2]), None);
        assert_eq!(of_text("cpu0 1 2\n", &[0]), None);
    }

    #[test]
    fn what_others_do_is_what_is_left() {
        let counts = [1, 1];
        let before = CoreTimes { busy: 10.0, stolen: 1.0, elsewhere: 3.0, counts };
        let after = CoreTimes { busy: 13.01, stolen: 1.11, elsewhere: 5.01, counts };
        let load = Load::between(before, after, 2.0, 2.0);
        assert_eq!([load.other_cores, load.stolen_cores, load.elsewhere_cores], [0.5, 0.05, 1.0]);
        assert!(load.disturbs(1) && !load.disturbs(16));
        assert_eq!(Load::between(before, before, 0.01, 1.0).other_cores, 0.0);
        assert!(!Load { other_cores: 0.01, elsewhere_cores: 1.0, ..Load::default() }.disturbs(1));
    }
}
