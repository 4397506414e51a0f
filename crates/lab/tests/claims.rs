//! What is said of runs whose truth is known.

use super::{experiment, header};
use eosphor_lab::statistics::CountedRandom;
use eosphor_lab::{
    Load, MILLISECONDS, Measured, Outcome, Quantity, Record, Records, TOO_FEW, UNSTABLE, Verdict, compare,
    markdown,
};

/// A machine with noise, and other work in some blocks.
struct World {
    random: CountedRandom,
    /// Of a single process, as a share.
    noise: f64,
    /// Of all processes of a block.
    drift: f64,
    /// How many processes take up to twice their time.
    hiccups: f64,
    /// Cores' worth of other work.
    other_cores: f64,
}

impl World {
    fn quiet(key: u64) -> World {
        World { random: CountedRandom::new(key), noise: 0.01, drift: 0.05, hiccups: 0.0, other_cores: 0.0 }
    }

    fn uniform(&mut self) -> f64 {
        self.random.next_bits() as f64 / 2f64.powi(64)
    }

    /// Nearly normal, with a standard deviation of 1.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }

    fn process(&mut self, ms: f64, block: f64, answer: &str) -> Outcome {
        let hiccup = if self.uniform() < self.hiccups { self.uniform() } else { 0.0 };
        let ms = ms * block * (1.0 + self.noise * self.normal() + hiccup);
        let quantity = Quantity {
            quantity: "time".into(),
            unit: MILLISECONDS.into(),
            values: vec![ms, ms * 1.001, ms * 0.999],
            work: Some(1000),
            answer: Some(answer.into()),
            ..Quantity::default()
        };
        let load = Some(Load { other_cores: self.other_cores, ..Load::default() });
        Outcome::Measured(Measured { quantities: vec![quantity], wall_seconds: 1.0, cpu_seconds: 1.0, load })
    }

    /// A run of variants with these true times and answers.
    fn run(&mut self, blocks: u32, variants: &[(&str, f64, &str)]) -> Records {
        let names: Vec<&str> = variants.iter().map(|variant| variant.0).collect();
        let mut records = Records { header: header(experiment(&names, "")), records: Vec::new() };
        for block in 0..blocks {
            let shift = 1.0 + self.drift * self.normal().abs();
            for (again, (name, ms, answer)) in
                variants.iter().map(|one| (false, one)).chain([(true, &variants[0])])
            {
                let outcome = self.process(*ms, shift, answer);
                records.records.push(Record { block, variant: (*name).into(), again, outcome });
            }
        }
        records
    }
}

fn verdicts(records: &Records) -> Vec<Verdict> {
    let [comparison] = &compare(std::slice::from_ref(records))[0][..] else { panic!("one quantity") };
    comparison.variants.iter().map(|result| result.verdict.clone()).collect()
}

fn report(records: &Records) -> String {
    markdown(std::slice::from_ref(records))
}

fn claims(records: &Records) -> usize {
    verdicts(records).iter().filter(|verdict| matches!(verdict, Verdict::Less | Verdict::More)).count()
}

#[test]
fn of_equal_variants_nothing_is_claimed() {
    for hiccups in [0.0, 0.1] {
        let equal = [("a", 10.0, "x"), ("b", 10.0, "x"), ("c", 10.0, "x")];
        let wrong = (0..200).filter(|&key| {
            let mut world = World { hiccups, ..World::quiet(key) };
            claims(&world.run(6, &equal)) > 0
        });
        let wrong = wrong.count();
        assert!(wrong <= 10, "{hiccups}: {wrong} of 200 runs");
    }
}

#[test]
fn a_slowdown_of_a_twentieth_is_found() {
    let found = (0..50).filter(|&key| {
        let records = World::quiet(1000 + key).run(6, &[("a", 10.0, "x"), ("b", 10.5, "x")]);
        verdicts(&records)[1] == Verdict::More
    });
    let found = found.count();
    assert!(found >= 45, "{found} of 50");
    let records = World::quiet(3).run(6, &[("a", 10.0, "x"), ("b", 5.0, "x")]);
    assert_eq!(verdicts(&records), [Verdict::Base, Verdict::Less]);
}

#[test]
fn nothing_is_claimed_of_few_blocks_or_beside_other_work() {
    let variants = [("a", 10.0, "x"), ("b", 20.0, "x")];
    let records = World::quiet(1).run(5, &variants);
    assert_eq!(verdicts(&records), [Verdict::Base, Verdict::NoClaim(TOO_FEW)]);
    let records = World { other_cores: 0.5, ..World::quiet(1) }.run(12, &variants);
    assert_eq!(verdicts(&records), [Verdict::Base, Verdict::NoClaim(UNSTABLE)]);
    assert!(report(&records).contains("12 of them disturbed"));
    // Six quiet blocks are enough, whatever the others say.
    let mut records = World::quiet(1).run(6, &variants);
    let mut loud =
        World { other_cores: 0.5, ..World::quiet(2) }.run(12, &[("a", 10.0, "x"), ("b", 5.0, "x")]);
    loud.records.retain(|record| record.block >= 6);
    records.records.extend(loud.records);
    assert_eq!(verdicts(&records), [Verdict::Base, Verdict::More]);
}

#[test]
fn times_of_other_answers_are_not_compared() {
    let records = World::quiet(1).run(6, &[("a", 10.0, "x"), ("b", 5.0, "y"), ("c", 5.0, "x")]);
    assert_eq!(verdicts(&records), [Verdict::Base, Verdict::OtherAnswers, Verdict::Less]);
    let text = report(&records);
    let row = text.lines().find(|line| line.starts_with("| b |")).unwrap();
    assert!(row.contains("| – | – | – | different answers: no ratio |"), "{row}");
    // Neither are those of a variant whose own answers differ from process to process.
    let mut records = World::quiet(1).run(6, &[("a", 10.0, "x"), ("b", 5.0, "x")]);
    let Outcome::Measured(last) = &mut records.records[16].outcome else { panic!("measured") };
    last.quantities[0].answer = Some("z".into());
    assert_eq!(records.records[16].variant, "b");
    assert_eq!(verdicts(&records)[1], Verdict::OtherAnswers);
}

#[test]
fn what_is_missing_is_said() {
    let mut records = World::quiet(1).run(6, &[("a", 10.0, "x"), ("b", 5.0, "x"), ("c", 5.0, "x")]);
    let failed = Outcome::Failed("exit status: 1: no such | scene".into());
    for record in records.records.iter_mut().filter(|record| record.variant == "b") {
        record.outcome = failed.clone();
    }
    records.records.retain(|record| record.variant != "c");
    let why = |text: &str| Verdict::NotMeasured(text.into());
    assert_eq!(verdicts(&records), [Verdict::Base, why("exit status: 1: no such | scene"), why("not yet")]);
    assert!(report(&records).contains("not measured: exit status: 1: no such \\| scene"));
    // Without the base there is nothing to compare with.
    let mut records = World::quiet(1).run(6, &[("a", 10.0, "x"), ("b", 5.0, "x")]);
    records.records.retain(|record| record.variant != "a");
    assert!(matches!(verdicts(&records)[..], [Verdict::NotMeasured(_), Verdict::NoClaim(_)]));
    records.records.clear();
    assert!(compare(&[records.clone()])[0].is_empty() && report(&records).contains("0 processes"));
}
