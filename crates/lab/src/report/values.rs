//! All values of a quantity as a table for programs, in CSV.

use super::section::{Finding, Section};
use crate::comparison::median_of;
use crate::records::{Measured, Outcome, Record};

const COLUMNS: [&str; 16] = [
    "block",
    "disturbed",
    "variant",
    "again",
    "value",
    "unit",
    "cpu_ms",
    "work",
    "answer",
    "hits",
    "different",
    "other_cores",
    "stolen_cores",
    "before_cores",
    "elsewhere_cores",
    "failed",
];

/// A line for each process of the run, in the order in which they ran. A value is the median of the process's repetitions.
pub(super) fn values(section: &Section, finding: &Finding) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(COLUMNS)?;
    for record in &section.records.records {
        writer.write_record(line(section, finding, record))?;
    }
    writer.into_inner().map_err(|error| csv::Error::from(error.into_error()))
}

fn line(section: &Section, finding: &Finding, record: &Record) -> [String; COLUMNS.len()] {
    let (measured, failed) = match &record.outcome {
        Outcome::Measured(measured) => (Some(measured), None),
        Outcome::Failed(why) => (None, Some(why.clone())),
    };
    let name = &finding.comparison.quantity;
    let of = |measured: &'_ Measured| measured.quantities.iter().find(|one| one.quantity == *name).cloned();
    let quantity = measured.and_then(of);
    let quantity = quantity.as_ref();
    let load = measured.and_then(|measured| measured.load);
    let said = |number: Option<f64>| number.map_or(String::new(), |number| number.to_string());
    let count = |number: Option<u64>| number.map_or(String::new(), |number| number.to_string());
    let clock = section.experiment().clock;
    [
        record.block.to_string(),
        section.records.is_disturbed(record.block).to_string(),
        record.variant.clone(),
        record.again.to_string(),
        said(quantity.and_then(|one| median_of(one, clock))),
        quantity.map_or(String::new(), |_| finding.unit.clone()),
        said(quantity.and_then(|one| crate::statistics::median(&one.cpu))),
        count(quantity.and_then(|one| one.work)),
        quantity.and_then(|one| one.answer.clone()).unwrap_or_default(),
        count(quantity.and_then(|one| one.hits)),
        count(quantity.and_then(|one| one.different)),
        said(load.map(|load| load.other_cores)),
        said(load.map(|load| load.stolen_cores)),
        said(load.map(|load| load.before_cores)),
        said(load.map(|load| load.elsewhere_cores)),
        failed.unwrap_or_default(),
    ]
}
