//! What else runs on the cores of a process: other programs, and other machines of the same host.

use serde::{Deserialize, Serialize};

/// What cores have done since the machine was started, in seconds summed over them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct CoreTimes {
    busy: f64,
    stolen: f64,
}

/// What was seen while a process ran.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Load {
    /// Cores' worth of work by other processes, on the cores that the process could use.
    pub other_cores: f64,
    /// Cores' worth of time that the host gave to others.
    pub stolen_cores: f64,
}

/// More than this counts as disturbed: other programs, and the host.
const MOST: Load = Load { other_cores: 0.10, stolen_cores: 0.05 };

impl Load {
    /// Whether a measurement under this load is not to be trusted.
    pub fn disturbs(&self) -> bool {
        self.other_cores > MOST.other_cores || self.stolen_cores > MOST.stolen_cores
    }

    /// That of a process which took so many seconds of these cores' time, over so many seconds.
    pub(crate) fn between(before: CoreTimes, after: CoreTimes, own: f64, seconds: f64) -> Load {
        let cores = |spent: f64| (spent / seconds.max(1e-3)).max(0.0);
        Load {
            other_cores: cores(after.busy - before.busy - own),
            stolen_cores: cores(after.stolen - before.stolen),
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
    for core in cores {
        let line = text.lines().find_map(|line| line.strip_prefix(&format!("cpu{core} ")))?;
        let ticks: Vec<f64> = line.split_whitespace().map_while(|word| word.parse().ok()).collect();
        let [user, nice, system, _, _, irq, soft_irq, stolen, ..] = ticks[..] else { return None };
        sum.busy += (user + nice + system + irq + soft_irq) / 100.0;
        sum.stolen += stolen / 100.0;
    }
    Some(sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cores_of_a_known_text() {
        let text = "cpu  1 1 1 1 1 1 1 1 1 1\ncpu0 100 0 50 900 3 0 10 20 0 0\ncpu1 200 100 0 0 0 0 0 0 0 0\ncpu10 9 9 9 9 9 9 9 9\nintr 5\n";
        assert_eq!(of_text(text, &[0]), Some(CoreTimes { busy: 1.6, stolen: 0.2 }));
        assert_eq!(of_text(text, &[0, 1]), Some(CoreTimes { busy: 4.6, stolen: 0.2 }));
        assert_eq!(of_text(text, &[2]), None);
        assert_eq!(of_text("cpu0 1 2\n", &[0]), None);
    }

    #[test]
    fn what_others_do_is_what_is_left() {
        let (before, after) = (CoreTimes { busy: 10.0, stolen: 1.0 }, CoreTimes { busy: 13.0, stolen: 1.1 });
        let load = Load::between(before, after, 2.0, 2.0);
        assert!(
            (load.other_cores - 0.5).abs() < 1e-12 && (load.stolen_cores - 0.05).abs() < 1e-12,
            "{load:?}"
        );
        assert!(load.disturbs());
        // Clocks that tick in hundredths may see less than the process itself counted.
        assert_eq!(Load::between(before, before, 0.01, 1.0).other_cores, 0.0);
        assert!(!Load { other_cores: 0.01, stolen_cores: 0.0 }.disturbs());
    }
}
