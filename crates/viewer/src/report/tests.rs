//! Laws of the page.

use super::*;

fn report(name: &str) -> Report {
    Report {
        name: name.to_owned(),
        summary: format!("{name} is clean."),
        before: vec![1, 2, 3],
        after: vec![4, 5, 6],
        heat_maps: vec![HeatMap { title: name.to_owned(), caption: name.to_owned(), picture: vec![7] }],
        histograms: Histogram::new(name, name, name, [0.0, 1.0, 2.0]).into_iter().collect(),
        figures: vec![(name.to_owned(), name.to_owned())],
        command: format!("planish bake {name}"),
    }
}

/// Elements that have no end.
const VOID: [&str; 4] = ["!DOCTYPE", "meta", "img", "input"];

/// Names of the elements of a page, in order; fails where one is not closed in its turn or an attribute has no quotes.
#[track_caller]
fn elements(page: &str) -> Vec<String> {
    let (mut open, mut found) = (Vec::new(), Vec::new());
    for rest in page.split('<').skip(1) {
        let (tag, _) = rest.split_once('>').unwrap();
        assert_eq!(tag.matches('"').count() % 2, 0, "{tag}");
        let name = tag.trim_start_matches('/').split([' ', '/']).next().unwrap().to_owned();
        match () {
            () if tag.starts_with('/') => assert_eq!(open.pop().as_deref(), Some(name.as_str())),
            () if VOID.contains(&name.as_str()) || tag.ends_with('/') => found.push(name),
            () => {
                found.push(name.clone());
                open.push(name);
            }
        }
    }
    assert!(open.is_empty(), "{open:?}");
    found
}

#[test]
fn the_page_is_well_formed_and_refers_to_nothing_outside() {
    let page = report("scan.obj").page();
    let found = elements(&page);
    for (name, count) in [("img", 3), ("input", 1), ("svg", 1), ("rect", 3), ("table", 1), ("script", 0), ("link", 0)] {
        assert_eq!(found.iter().filter(|element| *element == name).count(), count, "{name}");
    }
    for outside in ["http:", "https:", "//", "url(", "@import"] {
        assert!(!page.contains(outside), "{outside}");
    }
    assert!(page.contains("default-src 'none'"));
    assert!(page.contains("src=\"data:image/png;base64,AQID\"") && page.contains("base64,BAUG"));
}

#[test]
fn names_cannot_become_part_of_the_page() {
    let harmless = elements(&report("scan.obj").page());
    for name in ["<script>alert(1)</script>", "\" onload=\"alert(1)", "'><img src=x>", "a&lt;b", "a\nb\u{202e}c"] {
        let page = report(name).page();
        assert_eq!(elements(&page), harmless, "{name:?}");
        assert!(!page.contains('\u{202e}') && !page.contains("alert(1)</script>") && !page.contains(" onload=\""));
    }
    assert!(report("a&lt;b").page().contains("a&amp;lt;b"), "shown as it is");
}

#[test]
fn numbers_have_three_digits_that_count() {
    let all = [(0.0, "0.00"), (1234.0, "1234"), (0.012345, "0.0123"), (2.5, "2.50"), (-3e-9, "-3.00e-9")];
    all.into_iter().for_each(|(x, text)| assert_eq!(rounded(x), text));
}
