//! Writes a report into a folder, file by file, each whole or not at all.

use super::markdown;
use super::page;
use super::picture::ReportPicture;
use super::section::sections;
use super::values::values;
use crate::records::Records;
use std::fs;
use std::io::{Error, Write};
use std::path::{Path, PathBuf};

/// Why a report could not be written.
#[derive(Debug, thiserror::Error)]
#[error("{}: {source}", path.display())]
pub struct ReportError {
    path: PathBuf,
    source: Error,
}

/// Folders of a report.
pub(super) const CHARTS: &str = "charts";
pub(super) const TABLES: &str = "tables";

/// Writes what runs found, as far as they are, into a folder that is made where there is none: `report.html`, a page that needs no
/// other file; `report.md`, with its charts in `charts/`; and all values of all processes in `tables/`. Files that are there are
/// replaced. Claims are corrected for the number of all ratios of these runs. The paths that were written are returned.
///
/// # Errors
///
/// What the system says of a file.
pub fn write_report(
    runs: &[Records],
    pictures: &[ReportPicture],
    folder: &Path,
) -> Result<Vec<PathBuf>, ReportError> {
    let (sections, ratios) = sections(runs);
    for name in [CHARTS, TABLES] {
        let path = folder.join(name);
        fs::create_dir_all(&path).map_err(|source| ReportError { path, source })?;
    }
    let mut written = Vec::new();
    let mut write = |path: PathBuf, bytes: &[u8]| match write_whole(&path, bytes) {
        Ok(()) => {
            written.push(path);
            Ok(())
        }
        Err(source) => Err(ReportError { path, source }),
    };
    // Charts and tables first: a page that is there has what it names.
    for section in &sections {
        for (stem, chart) in section.charts() {
            let text = page::without_controls(chart.alone());
            write(folder.join(CHARTS).join(format!("{stem}.svg")), text.as_bytes())?;
        }
        for finding in &section.findings {
            let path = folder.join(TABLES).join(format!("{}.csv", finding.stem));
            let bytes = values(section, finding)
                .map_err(|error| ReportError { path: path.clone(), source: Error::other(error) })?;
            write(path, &bytes)?;
        }
    }
    write(folder.join("report.md"), markdown::whole(&sections, ratios).as_bytes())?;
    write(folder.join("report.html"), page::page(&sections, ratios, pictures).as_bytes())?;
    Ok(written)
}

/// Writes a file under another name, and then gives it its own.
fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".report-");
    // As any new file, and not for its owner alone.
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut file = builder.tempfile_in(folder)?;
    file.write_all(bytes)?;
    // Not flushed to the disk: that takes longer than all else for some hundred files, and what is lost with the machine's power is
    // made again from the runs.
    file.persist(path).map_err(|error| error.error)?;
    Ok(())
}
