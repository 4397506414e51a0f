//! Links of pages to sections lead to headings that are there.

use super::Text;
use super::pages::{in_prose, joined};
use std::collections::HashMap;

pub(super) fn check(texts: &[Text], found: &mut Vec<String>) {
    let pages = || texts.iter().filter(|text| text.path.ends_with(".md"));
    let anchors: HashMap<&str, Vec<String>> =
        pages().map(|page| (&*page.path, anchors(&page.content))).collect();
    for page in pages().filter(|page| page.path != "CHANGELOG.md") {
        let folder = page.path.rsplit_once('/').map_or("", |(folder, _)| folder);
        for (number, line) in in_prose(&page.content) {
            for target in line.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
                let Some((path, anchor)) = target.split_once('#') else { continue };
                let path = if path.is_empty() { page.path.clone() } else { joined(folder, path) };
                if anchors.get(&*path).is_some_and(|known| !known.iter().any(|a| a == anchor)) {
                    found.push(format!("{}:{number}: {path} has no section #{anchor}", page.path));
                }
            }
        }
    }
}

/// The anchors that GitHub makes of a page's headings: small letters and digits, hyphens for spaces.
fn anchors(content: &str) -> Vec<String> {
    let headings = in_prose(content).filter(|(_, line)| line.starts_with('#'));
    let anchor = |(_, line): (usize, &str)| {
        let text = line.trim_start_matches('#').trim().to_lowercase();
        text.chars()
            .filter(|c| c.is_alphanumeric() || " -_".contains(*c))
            .map(|c| if c == ' ' { '-' } else { c })
            .collect()
    };
    headings.map(anchor).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sections_that_are_not_there_are_found() {
        let page = |path: &str, content: &str| Text { path: path.into(), content: content.into() };
        let texts = [
            page("docs/a.md", "# A page\n## The octree beside PG1's\n```\n# no heading\n```\n"),
            page(
                "README.md",
                "[x](docs/a.md#the-octree-beside-pg1s) [y](docs/a.md#no-heading) [z](#start) [w](https://a.b/#c)\n",
            ),
        ];
        let mut found = Vec::new();
        check(&texts, &mut found);
        assert_eq!(
            found,
            [
                "README.md:1: docs/a.md has no section #no-heading",
                "README.md:1: README.md has no section #start"
            ]
        );
    }
}
