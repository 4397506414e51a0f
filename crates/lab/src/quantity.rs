//! What a process measured, as it prints it.

use serde::{Deserialize, Serialize};

/// One time that was measured, several times, with the work and its answer. Programs print one as a line of JSON:
///
/// ```json
/// {"quantity":"primary closest hit","work":921600,"answer":"5f0c","milliseconds":[41.2,40.9,41.0]}
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Quantity {
    /// What it is.
    pub quantity: String,
    /// Rays.
    pub work: u64,
    /// A hash of the picture, or of the hits: times of different answers are not compared. Programs whose hits are not ours bit for
    /// bit leave it out; their `hits` are shown instead.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub answer: Option<String>,
    /// How many rays hit something, of programs that do not hash.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hits: Option<u64>,
    /// Of each repetition, after one to warm up.
    pub milliseconds: Vec<f64>,
}

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
        let Quantity { quantity: name, milliseconds, answer, .. } = &quantity;
        let is_time = |ms: &f64| ms.is_finite() && *ms > 0.0;
        if name.is_empty()
            || name.len() > MAX_TEXT
            || answer.as_ref().is_some_and(|text| text.len() > MAX_TEXT)
        {
            return wrong(&format!("a name or answer without 1 to {MAX_TEXT} bytes"));
        }
        if !(1..=MAX_REPEATS).contains(&milliseconds.len()) || !milliseconds.iter().all(is_time) {
            return wrong(&format!("it must have 1 to {MAX_REPEATS} times above 0"));
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
            work: 7,
            answer: Some("5f".into()),
            hits: None,
            milliseconds: vec![1.5, 2.0],
        };
        let all = ["a", "b"].map(quantity);
        let text = all.iter().map(|one| serde_json::to_string(one).unwrap() + "\n").collect::<String>();
        assert_eq!(read_quantities(&text).unwrap(), all);
    }

    #[test]
    fn what_makes_no_sense_is_said_with_its_line() {
        let line = r#"{"quantity":"a","work":1,"milliseconds":[1.0]}"#;
        for (text, what) in [
            ("", "it measured nothing"),
            ("hello\n", "line 1"),
            (&format!("{line}\n{line}\n"), "line 2 of its output: a quantity for the second time"),
            (r#"{"quantity":"a","work":1,"milliseconds":[]}"#, "times above 0"),
            (r#"{"quantity":"a","work":1,"milliseconds":[0.0]}"#, "times above 0"),
            (r#"{"quantity":"a","work":1,"milliseconds":[-1.0]}"#, "times above 0"),
            (r#"{"quantity":"","work":1,"milliseconds":[1.0]}"#, "a name"),
            (r#"{"quantity":"a","work":1,"milliseconds":[1.0],"more":1}"#, "unknown field"),
        ] {
            let error = read_quantities(text).unwrap_err();
            assert!(error.contains(what), "{text}: {error}");
        }
    }
}
