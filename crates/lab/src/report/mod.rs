//! What runs found, for people: a page, Markdown, charts, and tables of all values.

mod chart;
mod curves;
mod files;
mod markdown;
mod page;
mod picture;
mod readme;
mod rows;
mod scale;
mod section;
mod tables;
mod values;
mod words;

pub use files::{ReportError, write_report};
pub use markdown::{changes_markdown, markdown};
pub use picture::ReportPicture;
pub use readme::readme_table;
