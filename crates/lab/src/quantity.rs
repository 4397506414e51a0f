//! What a process measured, as it prints it.

use serde::{Deserialize, Serialize};

/// One quantity that was measured, several times, with the work and its answer. Programs print one as a line of JSON:
///
/// ```json
/// {"quantity":"primary, closest hit","unit":"ms","values":[41.2,40.9],"cpu":[41.1,40.8],"work":921600,"answer":"5f0c"}
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Quantity {
    /// What it is.
    pub quantity: String,
    /// What the values count: `ms` for times. Less is better, whatever it is.
    pub unit: String,
    /// Of each repetition, after one to warm up.
    pub values: Vec<f64>,
    /// Of times, the CPU time of the process in each repetition, in milliseconds.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cpu: Vec<f64>,
    /// Rays, where there are any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub work: Option<u64>,
    /// A hash of the picture, or of the hits: what has different answers is not compared. Programs whose hits are not ours bit for
    /// bit leave it out; their `hits` and `different` are shown instead.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub answer: Option<String>,
    /// How many rays hit something, of programs that do not hash.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hits: Option<u64>,
    /// How many rays have another answer than ours, of programs that do not hash.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub different: Option<u64>,
}

/// The unit of times.
pub const MILLISECONDS: &str = "ms";

/// The most quantities, repetitions and bytes of text of a process.
const MAX_QUANTITIES: usize = 100;
const MAX_REPEATS: usize = 1000;
const MAX_TEXT: usize = 200;

/// Reads what a process printed.
///
/// # Errors
///
/// What is wrong with it, in a line.
pub fn read_quantities(text: &str) -> Result<Vec<Quantity>, String> {
    let mut quantities: Vec<Quantity> = Vec::new();
    for (number, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
        let wrong = |what: &str| Err(format!("line {} of its output: {what}", number + 1));
        if quantities.len() == MAX_QUANTITIES {
            return wrong(&format!("more than {MAX_QUANTITIES} quantities"));
        }
        let quantity: Quantity = match serde_json::from_str(line) {
            Ok(quantity) => quantity,
            Err(error) => return wrong(&error.to_string()),
        };
        let Quantity { quantity: name, unit, values, cpu, answer, .. } = &quantity;
        let is_text = |text: &String| (1..=MAX_TEXT).contains(&text.len());
        let is_value = |value: &f64| value.is_finite() && *value > 0.0;
        if ![name, unit].into_iter().chain(answer).all(is_text) {
            return wrong(&format!("a name, unit or answer without 1 to {MAX_TEXT} bytes"));
        }
        if !(1..=MAX_REPEATS).contains(&values.len()) || !values.iter().all(is_value) {
            return wrong(&format!("it must have 1 to {MAX_REPEATS} values above 0"));
        }
        if !cpu.is_empty() && (cpu.len() != values.len() || !cpu.iter().all(is_value)) {
            return wrong("\"cpu\" must have a time above 0 for each value");
        }
        if quantities.iter().any(|other| other.quantity == *name) {
            return wrong("a quantity for the second time");
        }
        quantities.push(quantity);
    }
    match quantities.is_empty() {
        true => Err("it measured nothing".into()),
        false => Ok(quantities),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_come_back() {
        let quantity = |name: &str| Quantity {
            quantity: name.into(),
            unit: MILLISECONDS.into(),
            values: vec![1.5, 2.0],
            cpu: vec![1.25, 1.5],
            work: Some(7),
            answer: Some("5f".into()),
            ..Quantity::default()
        };
        let all = ["a", "b"].map(quantity);
        let text = all.iter().map(|one| serde_json::to_string(one).unwrap() + "\n").collect::<String>();
        assert_eq!(read_quantities(&text).unwrap(), all);
    }

    #[test]
    fn what_makes_no_sense_is_said_with_its_line() {
        let line = r#"{"quantity":"a","unit":"ms","values":[1.0]}"#;
        for (text, what) in [
            ("", "it measured nothing"),
            ("hello\n", "line 1"),
            (&format!("{line}\n{line}\n"), "line 2 of its output: a quantity for the second time"),
            (r#"{"quantity":"a","unit":"ms","values":[]}"#, "values above 0"),
            (r#"{"quantity":"a","unit":"ms","values":[0.0]}"#, "values above 0"),
            (r#"{"quantity":"a","unit":"ms","values":[-1.0]}"#, "values above 0"),
            (r#"{"quantity":"a","unit":"ms","values":[1.0],"cpu":[1.0,2.0]}"#, "\"cpu\" must have"),
            (r#"{"quantity":"","unit":"ms","values":[1.0]}"#, "a name"),
            (r#"{"quantity":"a","values":[1.0]}"#, "missing field"),
            (r#"{"quantity":"a","unit":"ms","values":[1.0],"more":1}"#, "unknown field"),
        ] {
            let error = read_quantities(text).unwrap_err();
            assert!(error.contains(what), "{text}: {error}");
        }
    }
}
