//! What fuzzing of traversals has found (`cargo xtask fuzz`), again.

#[allow(dead_code, reason = "the target of builders takes the rest")]
#[path = "../../../fuzz/src/hits.rs"]
mod hits;
mod support;

use std::path::Path;

#[test]
fn what_fuzzing_found_stays_mended() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/regressions/traversals");
    let files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    assert!(files.len() > 50);
    for file in files {
        println!("{}", file.display());
        hits::traverse(&std::fs::read(&file).unwrap());
    }
}
