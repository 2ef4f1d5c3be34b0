//! The documents speak of what is there.

use crate::sources::top;

fn read(name: &str) -> String {
    std::fs::read_to_string(top().join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

#[test]
fn every_invariant_of_the_architecture_names_a_guard_that_exists() {
    let text = read("docs/ARCHITECTURE.md");
    let rows: Vec<&str> = text.lines().filter(|line| line.starts_with("| ") && line.contains("guard:")).collect();
    assert!(rows.len() >= 11, "the table of invariants has {} rows, not 11", rows.len());
    for row in rows {
        let guards: Vec<&str> = row.split("guard:").skip(1).filter_map(|rest| rest.split('`').nth(1)).collect();
        assert!(!guards.is_empty(), "no guard in: {row}");
        for guard in guards {
            let (file, test) = guard.split_once("::").unwrap_or((guard, ""));
            let source = read(file);
            assert!(source.contains(&format!("fn {test}")), "{file} has no test {test}");
        }
    }
}

#[test]
fn the_readme_gives_the_exit_codes_that_the_program_prints() {
    let readme = read("README.md");
    let help = read("src/exit.rs");
    let codes = help.lines().filter(|line| line.trim_start().starts_with(|first: char| first.is_ascii_digit()));
    for code in codes {
        let words = code.split_whitespace().collect::<Vec<_>>().join(" ");
        let (number, meaning) = words.split_once(' ').expect("a code and its meaning");
        assert!(readme.contains(&format!("| {number} | {meaning} |")), "README lacks: | {number} | {meaning} |");
    }
}
