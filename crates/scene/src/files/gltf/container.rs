//! GLB: one file that holds the JSON and the first buffer.

/// The first bytes of every GLB file.
const MAGIC: &[u8; 4] = b"glTF";

/// JSON texts longer than this are refused: parsed, they take many times their length.
const MAX_JSON_BYTES: usize = 1 << 29;

/// The parts of a file.
pub(super) struct Container<'a> {
    pub(super) json: &'a [u8],
    /// The bytes of the first buffer, where the file is a GLB that has them.
    pub(super) binary: Option<&'a [u8]>,
    pub(super) is_glb: bool,
}

/// Takes a file apart. What it is, is told by its contents, not by its name.
pub(super) fn split(file: &[u8]) -> Result<Container<'_>, String> {
    let container = if file.starts_with(MAGIC) {
        split_glb(file)?
    } else {
        // Some editors write a byte order mark, which JSON does not allow.
        let json = file.strip_prefix(b"\xef\xbb\xbf").unwrap_or(file);
        Container { json, binary: None, is_glb: false }
    };
    if container.json.len() > MAX_JSON_BYTES {
        let mebibytes = container.json.len() >> 20;
        return Err(format!(
            "its JSON takes {mebibytes} MiB, and at most {} are read; keep buffers and pictures in files of their own",
            MAX_JSON_BYTES >> 20
        ));
    }
    Ok(container)
}

/// A header of 12 bytes, then chunks: the length, the kind, the bytes. The first is the JSON, the second the buffer;
/// others are passed over. The length in the header is not needed, and wrong in some files.
fn split_glb(file: &[u8]) -> Result<Container<'_>, String> {
    match word(file, 4) {
        Some(2) => {}
        Some(version) => {
            return Err(format!("GLB version {version} is not read, only 2; export it as glTF 2.0"));
        }
        None => return Err(cut("its header")),
    }
    let (json, after) = chunk(file, 12, b"JSON")?.ok_or("a GLB without JSON; export it again")?;
    // Some writers pad with zeros where the format asks for blanks.
    let end = json.iter().rposition(|&b| b != 0).map_or(0, |last| last + 1);
    let binary = chunk(file, after, b"BIN\0")?.map(|(binary, _)| binary);
    Ok(Container { json: &json[..end], binary, is_glb: true })
}

/// The chunk that starts at a byte, and where the next one starts; `None` where there is none of this kind.
fn chunk<'a>(file: &'a [u8], start: usize, kind: &[u8; 4]) -> Result<Option<(&'a [u8], usize)>, String> {
    let (Some(length), Some(found)) = (word(file, start), file.get(start + 4..start + 8)) else {
        return Ok(None);
    };
    if found != kind {
        return Ok(None);
    }
    let end = (start + 8).saturating_add(length as usize);
    let bytes = file.get(start + 8..end).ok_or_else(|| {
        let name = String::from_utf8_lossy(&kind[..3]).into_owned();
        cut(&format!("its {} chunk of {length} bytes", if name == "JSO" { "JSON" } else { &name }))
    })?;
    Ok(Some((bytes, end)))
}

fn cut(what: &str) -> String {
    format!("the file ends within {what}; get it again")
}

fn word(file: &[u8], at: usize) -> Option<u32> {
    let bytes = file.get(at..at + 4)?;
    Some(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]))
}
