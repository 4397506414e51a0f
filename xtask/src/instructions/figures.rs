//! The committed figures, and how they are compared with what is counted.

use anyhow::{Context, Result, ensure};
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// How many percent more instructions a case may take. The same program counts the same within 0.01 %, and one that was
/// built in another folder within 0.02 %: 2 % is never noise. It leaves room for what the compiler inlines differently
/// after a change elsewhere.
const TOLERANCE_PERCENT: u64 = 2;

const RENEW: &str = "cargo xtask instructions --write";

/// What counts depend on, besides the sources.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Conditions {
    pub(super) rustc: String,
    pub(super) target: String,
    /// It copies memory, allocates and, for what is compiled for any CPU, has the fused multiply-add.
    pub(super) c_library: String,
}

impl Conditions {
    /// Why counts of one are not to be compared with counts of the other.
    pub(super) fn other_than(&self, here: &Conditions) -> Option<String> {
        let of = |c: &Conditions| format!("rustc {}, {}, {}", c.rustc, c.target, c.c_library);
        (self != here).then(|| format!("the figures are of {}, and here is {}", of(self), of(here)))
    }
}

/// Instructions by case.
#[derive(Debug, PartialEq)]
pub(super) struct Figures {
    pub(super) conditions: Conditions,
    pub(super) instructions: BTreeMap<String, u64>,
}

/// What a comparison found.
pub(super) struct Compared {
    /// One for each case.
    pub(super) lines: Vec<String>,
    /// One for each thing that must not be.
    pub(super) wrong: Vec<String>,
}

impl Figures {
    pub(super) fn to_json(&self) -> String {
        let Conditions { rustc, target, c_library } = &self.conditions;
        let value = json!({
            "rustc": rustc, "target": target, "c_library": c_library, "instructions": self.instructions
        });
        format!("{value:#}\n")
    }

    pub(super) fn parse(text: &str) -> Result<Figures> {
        let value: Value = serde_json::from_str(text)?;
        let word =
            |key: &str| value[key].as_str().map(String::from).with_context(|| format!("it lacks \"{key}\""));
        let conditions =
            Conditions { rustc: word("rustc")?, target: word("target")?, c_library: word("c_library")? };
        let counts = value["instructions"].as_object().context("it lacks \"instructions\"")?;
        let count = |(name, count): (&String, &Value)| {
            let count = count.as_u64().filter(|&count| count > 0);
            Ok((name.clone(), count.with_context(|| format!("{name} must be a number from 1"))?))
        };
        Ok(Figures { conditions, instructions: counts.iter().map(count).collect::<Result<_>>()? })
    }

    /// Compares these figures with what is counted now.
    pub(super) fn compare(&self, now: &BTreeMap<String, u64>) -> Compared {
        let mut compared = Compared { lines: Vec::new(), wrong: Vec::new() };
        for (name, &count) in now {
            let Some(&before) = self.instructions.get(name) else {
                compared.wrong.push(format!("{name}: {count} instructions, and no figure: {RENEW}"));
                continue;
            };
            let percent = 100.0 * (count as f64 / before as f64 - 1.0);
            let change = format!("{before:11} instructions before, {count:11} now ({percent:+.2} %)");
            if count == 0 {
                compared.wrong.push(format!("{name}: nothing was counted"));
            } else if 100 * count > (100 + TOLERANCE_PERCENT) * before {
                let change = change.split_whitespace().collect::<Vec<_>>().join(" ");
                compared.wrong.push(format!(
                    "{name}: {change}, and {TOLERANCE_PERCENT} % more are allowed; if they are worth it: {RENEW}"
                ));
            }
            let note = match 100 * count < (100 - TOLERANCE_PERCENT) * before {
                true => format!(": fewer, so that more would pass later: {RENEW}"),
                false => String::new(),
            };
            compared.lines.push(format!("{name:22} {change}{note}"));
        }
        for name in self.instructions.keys().filter(|name| !now.contains_key(*name)) {
            compared
                .wrong
                .push(format!("{name}: it has a figure, and was not counted; if it is no more: {RENEW}"));
        }
        compared
    }
}

/// The name of a case, and its instructions, from what gungraun writes about it.
pub(super) fn of_summary(text: &str) -> Result<(String, u64)> {
    let summary: Value = serde_json::from_str(text)?;
    let name = summary["function_name"].as_str().context("it names no function")?;
    let profiles = summary["profiles"].as_array().map_or(&[][..], Vec::as_slice);
    ensure!(profiles.len() == 1, "it has {} profiles, and should have one", profiles.len());
    let counts = profiles[0].pointer("/data/total/metrics/Ir/values/new").and_then(Value::as_u64);
    Ok((name.to_owned(), counts.context("it has no number of instructions")?))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counts(list: &[(&str, u64)]) -> BTreeMap<String, u64> {
        list.iter().map(|&(name, count)| (name.to_owned(), count)).collect()
    }

    fn figures(list: &[(&str, u64)]) -> Figures {
        let conditions =
            Conditions { rustc: "1.95.0".into(), target: "x86_64".into(), c_library: "glibc 2.36".into() };
        Figures { conditions, instructions: counts(list) }
    }

    #[test]
    fn a_slowdown_is_named_with_both_counts() {
        let compared = figures(&[("build", 1_000_000), ("trace", 500_000)])
            .compare(&counts(&[("build", 2_000_000), ("trace", 509_999)]));
        let expected = "build: 1000000 instructions before, 2000000 now (+100.00 %), and 2 % more are allowed; if they \
                        are worth it: cargo xtask instructions --write";
        assert_eq!(compared.wrong, [expected]);
        assert_eq!(compared.lines.len(), 2);
    }

    #[test]
    fn two_percent_more_pass_and_fewer_are_told() {
        let of = |now: u64| figures(&[("build", 100_000)]).compare(&counts(&[("build", now)]));
        assert_eq!([102_000, 102_001, 50_000, 0].map(|now| of(now).wrong.len()), [0, 1, 0, 1]);
        assert_eq!(of(0).wrong, ["build: nothing was counted"]);
        assert_eq!([98_000, 97_999].map(|now| of(now).lines[0].contains("fewer")), [false, true]);
    }

    #[test]
    fn cases_without_figures_and_figures_without_cases_are_wrong() {
        let compared = figures(&[("old", 5)]).compare(&counts(&[("new", 5)]));
        let begins = |k: usize, with: &str| compared.wrong[k].starts_with(with);
        assert!(begins(0, "new: 5 instructions, and no figure") && begins(1, "old: it has a figure"));
    }

    #[test]
    fn figures_are_read_as_they_are_written_and_know_what_they_are_of() {
        let old = figures(&[("build", 7), ("trace", 8)]);
        assert_eq!(Figures::parse(&old.to_json()).unwrap(), old);
        assert!(Figures::parse(&old.to_json().replace('7', "0")).is_err());
        let mut here = old.conditions.clone();
        assert_eq!(old.conditions.other_than(&here), None);
        here.rustc = "1.96.0".into();
        assert!(
            old.conditions.other_than(&here).unwrap().ends_with("here is rustc 1.96.0, x86_64, glibc 2.36")
        );
    }

    #[test]
    fn a_summary_of_gungraun_is_read() {
        let text = r#"{"function_name": "build", "profiles": [{"data": {"total": {"metrics":
            {"Ir": {"values": {"new": 1088911}}}}}, "tool": "Callgrind"}]}"#;
        assert_eq!(of_summary(text).unwrap(), ("build".to_owned(), 1_088_911));
        assert!(of_summary(&text.replace("Ir", "Dr")).is_err());
    }
}
