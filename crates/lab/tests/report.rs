//! What a report holds, whatever the runs hold.

use super::sample::{self, Conditions, truth};
use eosphor_lab::{Axis, MILLISECONDS, Published, Records, ReportPicture, markdown, write_report};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::time::Instant;

/// The files of a report, by their paths within its folder.
fn files(runs: &[Records], pictures: &[ReportPicture]) -> BTreeMap<String, String> {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path().join("a/report");
    let written = write_report(runs, pictures, &root).unwrap();
    let name = |path: &Path| path.strip_prefix(&root).unwrap().to_str().unwrap().replace('\\', "/");
    let files: BTreeMap<String, String> =
        written.iter().map(|path| (name(path), fs::read_to_string(path).unwrap())).collect();
    assert_eq!(files.len(), written.len());
    // Nothing else is left there.
    let count = |folder: &Path| {
        fs::read_dir(folder).unwrap().filter(|one| one.as_ref().unwrap().path().is_file()).count()
    };
    assert_eq!(["", "charts", "tables"].map(|one| count(&root.join(one))).iter().sum::<usize>(), files.len());
    files
}

/// The names of elements, and their attributes with values.
fn elements(page: &str) -> Vec<(&str, Vec<(&str, &str)>)> {
    let mut elements = Vec::new();
    let mut rest = page;
    while let Some(start) = rest.find('<') {
        rest = &rest[start + 1..];
        let name_end = rest.find([' ', '>', '\n']).unwrap();
        let (name, mut inner) = rest.split_at(name_end);
        let mut attributes = Vec::new();
        loop {
            inner = inner.trim_start();
            if let Some(after) = inner.strip_prefix('>') {
                rest = after;
                break;
            }
            let end = inner.find(['=', ' ', '>']).unwrap();
            let (attribute, after) = inner.split_at(end);
            let value = after.strip_prefix("=\"").map(|after| after.split_once('"').unwrap());
            attributes.push((attribute, value.map_or("", |(value, _)| value)));
            inner = value.map_or(after, |(_, after)| after);
        }
        elements.push((name, attributes));
    }
    elements
}

/// A page that runs nothing and fetches nothing, with one place for each link.
fn is_sound(page: &str) {
    let elements = elements(page);
    let mut ids: Vec<&str> = Vec::new();
    let mut links: Vec<&str> = Vec::new();
    for (name, attributes) in &elements {
        assert!(
            !["script", "link", "iframe", "object", "embed", "image", "use", "base", "form"].contains(name),
            "{name}"
        );
        for &(attribute, value) in attributes {
            assert!(
                !attribute.starts_with("on") && !["style", "srcset", "xlink:href"].contains(&attribute),
                "{attribute}"
            );
            match attribute {
                "id" => ids.push(value),
                "href" => links.push(value),
                "src" => assert!(value.starts_with("data:image/png;base64,"), "{value}"),
                _ => {}
            }
        }
    }
    let styles = page.split("<style>").skip(1).map(|one| one.split("</style>").next().unwrap());
    for style in styles {
        assert!(!["@import", "url(", "http", "expression"].iter().any(|word| style.contains(word)));
    }
    for link in links {
        let is_there =
            link.strip_prefix('#').map_or(link.starts_with("tables/"), |place| ids.contains(&place));
        assert!(is_there, "{link}");
    }
    let count = ids.len();
    ids.sort();
    ids.dedup();
    assert_eq!(ids.len(), count, "each id once");
    assert!(page.chars().all(|c| c == '\n' || !c.is_control()));
}

#[test]
fn a_report_says_what_a_reader_asks() {
    let files = files(&sample::all_cases(), &[]);
    let page = &files["report.html"];
    is_sound(page);
    assert!(!["<script", "http://", "https://"].iter().any(|word| page.contains(word)));
    for said in [
        "AMD EPYC 9B45 128-Core Processor",
        "319352f4c1",
        "rustc 1.92.0",
        "9e3779b97f4a7c15",
        "2025-11-24 16:00 UTC",
        "eosphor lab run structures --blocks 7 --seed 7052913",
        "eosphor lab run bounces --quick --seed 7052913",
        "eosphor bench rays builtin:hare --size 640x480",
        "bvh8 is faster than bvh (primary, closest hit: 0.3",
        "build goes with these powers of triangles: bvh 1.0",
        "bvh8 is faster than bvh (0.3",
        "4096 rays: within the noise",
        "nothing is claimed: unstable",
        "nothing is claimed: fewer than 6 undisturbed blocks",
        "It has 4 undisturbed of its 4 blocks; a claim needs 6.",
        "Of its last block, ",
        "As a quick run it claims nothing",
        "gpu was left out: no GPU here.",
        "7 of 7 processes of kd-tree failed: exit status: 2: the scene has no triangles.",
        "different answers: no ratio",
        "314159; 12",
        "× theirs (different hardware)",
        "77aa0e1…",
    ] {
        assert!(page.contains(said), "{said}");
    }
    // Each chart is in the page, in a file, and in the Markdown; each quantity has a table.
    let charts: Vec<&String> = files.keys().filter(|name| name.starts_with("charts/")).collect();
    assert_eq!((charts.len(), page.matches("<svg ").count()), (11, 11));
    assert!(charts.iter().all(|name| files["report.md"].contains(&format!("]({name})"))));
    assert_eq!(files.keys().filter(|name| name.starts_with("tables/")).count(), 9);
    assert!(charts.iter().all(
        |name| files[*name].matches("http").count() == 1 && files[*name].contains("prefers-color-scheme")
    ));
    let id = sample::all_cases()[0].header.id();
    let captions: Vec<&str> =
        page.split("<figcaption>").skip(1).map(|one| one.split("</figcaption>").next().unwrap()).collect();
    assert!(captions.len() == 11 && captions.iter().all(|caption| caption.contains(&id)));
    assert!(!page.contains("different machines or programs"));
}

#[test]
fn tables_hold_every_process() {
    let runs = sample::all_cases();
    let files = files(&runs, &[]);
    let text = &files["tables/structures-primary-closest-hit.csv"];
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let header = reader.headers().unwrap().clone();
    let column = |name: &str| header.iter().position(|one| one == name).unwrap();
    let lines: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    assert_eq!(lines.len(), runs[0].records.len());
    for (line, record) in lines.iter().zip(&runs[0].records) {
        assert_eq!((&line[0], &line[2]), (&record.block.to_string()[..], &record.variant[..]));
        let failed = record.variant == "kd-tree";
        assert_eq!((line[column("value")].is_empty(), line[column("failed")].is_empty()), (failed, !failed));
        assert_eq!(&line[column("other_cores")], if failed { "" } else { "0.01" });
    }
    assert_eq!(lines.iter().filter(|line| &line[column("again")] == "true").count(), 7);
}

#[test]
fn the_same_runs_give_the_same_bytes() {
    let runs = sample::all_cases();
    assert_eq!(files(&runs, &[]), files(&runs, &[]));
}

#[test]
fn runs_of_several_machines_say_so() {
    let mut runs = sample::all_cases();
    runs.push(sample::of_another_machine());
    // The same experiment once more, of another version.
    let mut other = runs[0].clone();
    other.header.program.version = "0.2.0".into();
    runs.push(other);
    let files = files(&runs, &[]);
    let page = &files["report.html"];
    is_sound(page);
    assert!(page.contains("These runs come from 3 different machines or programs"));
    for run in [&runs[0], &runs[7], &runs[8]] {
        assert!(page.contains(&format!("href=\"#m-{}\"", run.header.id())));
    }
    assert!(
        page.contains("NVIDIA H100 80GB HBM3")
            && files.contains_key("charts/structures-2-shadow-any-hit.svg")
    );
}

/// Names that would be something else in HTML, SVG, Markdown, CSV or a shell, if they were not escaped.
const HOSTILE: [&str; 7] = [
    "<script>alert(1)</script>",
    "\"><img src=x onerror=alert(1)>",
    "a & b &lt; c' `id` $(id) $x^2$",
    "nul\0 bell\x07 escape\x1b[31m line\nnext\u{202e}turned\u{fffe}",
    "| **bold** | [link](https://a.example/) |",
    "名前名前名前名前名前名前名前名前名前名前",
    "=1+1,\"x\"",
];

#[test]
fn hostile_names_are_only_text() {
    let mut truths: Vec<_> = HOSTILE.iter().map(|name| truth(name, 10.0)).collect();
    truths[2].failure = Some(HOSTILE[0]);
    truths[3].answer = Some(HOSTILE[0]);
    truths[4].variant.program = Some(HOSTILE[1].into());
    for axis in [None, Some(Axis { label: HOSTILE[1].into(), logarithmic: true, slope: true })] {
        if axis.is_some() {
            for (number, truth) in truths.iter_mut().enumerate() {
                truth.variant.x = Some(1.0 + number as f64);
                truth.variant.series = Some(HOSTILE[number % 2].into());
            }
        }
        let mut experiment = sample::experiment("hostile", HOSTILE[1], &truths, axis);
        experiment.held = HOSTILE.map(String::from).into();
        let text = |number: usize| HOSTILE[number].to_owned();
        experiment.published = vec![Published {
            source: text(0),
            what: text(1),
            hardware: text(0),
            value: 3.0,
            unit: MILLISECONDS.into(),
            x: Some(2.0),
            beside: Some(text(0)),
        }];
        let quantities = HOSTILE.map(|name| (name.to_owned(), MILLISECONDS, 1.0)).into();
        let mut records =
            sample::run(&experiment, &truths, &Conditions { quantities, ..Conditions::default() });
        records.header.machine.cpu = Some(text(0));
        records.header.program.commit = Some(text(1));
        let picture =
            ReportPicture { title: text(1), caption: text(0), a_png: vec![1], ..ReportPicture::default() };
        let files = files(&[records], &[picture]);
        // What is only text is not looked for.
        let page =
            files["report.html"].replace("https://a.example/", "").replace("src=x onerror=alert(1)", "");
        is_sound(&page);
        assert!(page.contains("&lt;script&gt;alert(1)&lt;/script&gt;"));
        for (name, svg) in files.iter().filter(|(name, _)| name.ends_with(".svg")) {
            let is_text = |c: char| c == '\n' || !(c.is_control() || c == '\u{fffe}' || c == '\u{202e}');
            assert!(!svg.contains("<script") && !svg.contains("<img") && svg.chars().all(is_text), "{name}");
        }
        assert!(
            files.keys().all(|name| name.chars().all(|c| c.is_ascii_alphanumeric() || "-./".contains(c)))
        );
        let prose = files["report.md"].lines().filter(|line| !line.contains("Repeat it:"));
        assert!(
            prose
                .clone()
                .all(|line| !line.replace("\\<", "").contains("<script") && !line.contains(" **bold** "))
        );
    }
}

#[test]
fn reports_of_nothing_and_of_little_say_what_is_missing() {
    is_sound(&files(&[], &[])["report.html"]);
    let truths = [truth("a", 10.0), truth("b", 20.0)];
    let experiment = sample::experiment("little", "Is there anything?", &truths, None);
    let mut records =
        sample::run(&experiment, &truths, &Conditions { blocks: 1, cut: 1, ..Conditions::default() });
    let all = files(std::slice::from_ref(&records), &[]);
    let page = &all["report.html"];
    is_sound(page);
    assert!(page.contains("not measured: not yet") && page.contains("b has not run in block 1"));
    records.records.clear();
    let all = files(std::slice::from_ref(&records), &[]);
    is_sound(&all["report.html"]);
    assert!(all["report.html"].contains("nothing was measured: not yet"));
    assert_eq!(all.len(), 2, "no chart and no table");
    assert!(markdown(std::slice::from_ref(&records)).contains("It has 0 undisturbed of its 0 blocks"));
    // Where all of it needs a GPU, and there is none.
    records.header.machine.gpus.clear();
    records.header.experiment.variants.iter_mut().for_each(|variant| variant.needs_gpu = true);
    let page = &files(std::slice::from_ref(&records), &[])["report.html"];
    assert!(page.contains("nothing was measured: no GPU here"));
}

/// Files that people have changed: values that no process prints.
#[test]
fn values_that_make_no_sense_are_drawn_somewhere() {
    use eosphor_lab::Outcome;
    for axis in [None, Some(Axis { label: "x".into(), logarithmic: true, slope: true })] {
        let mut truths = vec![truth("a", 10.0), truth("b", 20.0), truth("c", 20.0)];
        if axis.is_some() {
            truths.iter_mut().enumerate().for_each(|(number, one)| one.variant.x = Some(1.0 + number as f64));
        }
        let experiment = sample::experiment("odd", "Does it hold?", &truths, axis);
        for odd in [0.0, -1.0, 1e308, -1.7e308, 1e-320, f64::INFINITY, f64::NAN] {
            let mut records = sample::run(&experiment, &truths, &Conditions::default());
            for record in records.records.iter_mut().step_by(3) {
                let Outcome::Measured(measured) = &mut record.outcome else { continue };
                measured.quantities[0].values = vec![odd];
                measured.quantities[0].work = Some(u64::MAX);
            }
            records.header.began = u64::MAX;
            is_sound(&files(&[records], &[])["report.html"]);
        }
    }
}

#[test]
fn pictures_are_within_the_page() {
    let picture = |experiment: &str| ReportPicture {
        experiment: experiment.into(),
        title: "A chair.".into(),
        caption: "Which is which?".into(),
        a_png: b"\x89PNG a".to_vec(),
        b_png: Some(b"\x89PNG b".to_vec()),
        heat_png: Some(b"\x89PNG c".to_vec()),
    };
    let files = files(&sample::all_cases(), &[picture("samples"), picture("none of these")]);
    let page = &files["report.html"];
    is_sound(page);
    assert_eq!((page.matches("data:image/png;base64,").count(), page.matches(" checked").count()), (6, 2));
    assert!(page.contains("<h2>Pictures</h2>"));
}

#[test]
fn a_large_report_is_small_and_soon_there() {
    let mut runs = Vec::new();
    for number in 0..15 {
        let truths: Vec<_> = (0..8)
            .map(|variant| {
                let one = truth(&format!("variant {variant}"), 10.0 * (1.0 + 0.1 * f64::from(variant)));
                if number % 3 == 0 {
                    one.at(["a", "b"][variant as usize % 2], 2_f64.powi(variant))
                } else {
                    one
                }
            })
            .collect();
        let axis =
            (number % 3 == 0).then(|| Axis { label: "triangles".into(), logarithmic: true, slope: true });
        let experiment =
            sample::experiment(&format!("experiment-{number}"), "How does it go?", &truths, axis);
        let quantities = (0..6)
            .map(|one| (format!("rays of kind {one}, closest hit"), MILLISECONDS, 1.0 + f64::from(one)));
        runs.push(sample::run(
            &experiment,
            &truths,
            &Conditions { quantities: quantities.collect(), ..Conditions::default() },
        ));
    }
    let folder = tempfile::tempdir().unwrap();
    let start = Instant::now();
    let written = write_report(&runs, &[], folder.path()).unwrap();
    let seconds = start.elapsed().as_secs_f64();
    let start = Instant::now();
    eosphor_lab::compare(&runs);
    let compared = start.elapsed().as_secs_f64();
    let bytes = fs::metadata(folder.path().join("report.html")).unwrap().len();
    println!(
        "{} files in {seconds:.3} s, {compared:.3} s of it to compare; the page has {bytes} bytes",
        written.len()
    );
    assert!(bytes <= 2 << 20, "{bytes}");
    is_sound(&fs::read_to_string(folder.path().join("report.html")).unwrap());
}

#[test]
fn a_folder_that_cannot_be_made_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("file");
    fs::write(&path, "").unwrap();
    let error = write_report(&[], &[], &path).unwrap_err().to_string();
    assert!(error.contains("file"), "{error}");
}
