//! Who has a file in work, for other processes that want it.

/// This process, as `process 4711 on alpha`.
pub(crate) fn this_process() -> String {
    match host() {
        Some(host) => format!("process {} on {host}", std::process::id()),
        None => format!("process {}", std::process::id()),
    }
}

#[cfg(unix)]
fn host() -> Option<String> {
    let mut name = [0u8; 80];
    // SAFETY: gethostname writes at most `name.len()` bytes, and `name` has as many.
    let failed = unsafe { libc::gethostname(name.as_mut_ptr().cast(), name.len()) } != 0;
    let text = name.split(|byte| *byte == 0).next().unwrap_or_default();
    let text = String::from_utf8_lossy(text).into_owned();
    (!failed && !text.is_empty()).then_some(text)
}

#[cfg(not(unix))]
fn host() -> Option<String> {
    std::env::var("COMPUTERNAME").ok()
}
