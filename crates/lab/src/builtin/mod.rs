//! The experiments that come with the program.

use crate::experiment::Experiment;

/// All of them.
///
/// # Panics
///
/// Never: a test reads them.
pub fn builtin_experiments() -> Vec<Experiment> {
    let read = |text: &str| serde_json::from_str(text).expect("a test has read it");
    TEXTS.iter().map(|text| read(text)).collect()
}

/// In the order of the report.
const TEXTS: [&str; 14] = [
    include_str!("structures.json"),
    include_str!("builders.json"),
    include_str!("resolution.json"),
    include_str!("pg1.json"),
    include_str!("plato.json"),
    include_str!("launch.json"),
    include_str!("triangles.json"),
    include_str!("threads.json"),
    include_str!("ranks.json"),
    include_str!("devices.json"),
    include_str!("samples.json"),
    include_str!("bounces.json"),
    include_str!("batch.json"),
    include_str!("distance.json"),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_are_sound_and_have_names_of_their_own() {
        let all = builtin_experiments();
        for (number, experiment) in all.iter().enumerate() {
            assert_eq!((experiment.check(), experiment.check_use()), (Ok(()), Ok(())));
            assert_eq!(experiment.quickly().check(), Ok(()));
            assert!(all[..number].iter().all(|other| other.name != experiment.name));
            let text = serde_json::to_string(experiment).unwrap();
            assert_eq!(&serde_json::from_str::<Experiment>(&text).unwrap(), experiment);
        }
    }
}
