//! Which known word somebody may have meant.

/// The candidate nearest to `word`, if it is near enough to be a slip: at most a third of the letters.
pub(crate) fn nearest<'a>(word: &str, candidates: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let limit = (word.chars().count() / 3).clamp(1, 4);
    let fits = |candidate: &&str| candidate.len().abs_diff(word.len()) <= 4 * limit;
    let scored = candidates.filter(fits).map(|candidate| (distance(word, candidate), candidate));
    scored.filter(|(edits, _)| *edits <= limit).min().map(|(_, candidate)| candidate)
}

/// Letters to insert, delete or replace, or neighbours to swap, to make `a` into `b` (optimal string alignment).
fn distance(a: &str, b: &str) -> usize {
    const LETTERS_MAX: usize = 64;
    let a: Vec<char> = a.chars().take(LETTERS_MAX).collect();
    let b: Vec<char> = b.chars().take(LETTERS_MAX).collect();
    let mut rows = vec![vec![0; b.len() + 1]; a.len() + 1];
    for (i, row) in rows.iter_mut().enumerate() {
        row[0] = i;
    }
    for (j, cell) in rows[0].iter_mut().enumerate() {
        *cell = j;
    }
    for i in 1..=a.len() {
        for j in 1..=b.len() {
            let replace = rows[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let mut best = replace.min(rows[i - 1][j] + 1).min(rows[i][j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                best = best.min(rows[i - 2][j - 2] + 1);
            }
            rows[i][j] = best;
        }
    }
    rows[a.len()][b.len()]
}

#[cfg(test)]
mod tests {
    use super::nearest;

    #[test]
    fn a_slip_finds_the_word_that_was_meant() {
        let words = ["speed_mps_max", "reverse_mps_max", "margin_m"];
        assert_eq!(nearest("speed_mps_mx", words.into_iter()), Some("speed_mps_max"));
        assert_eq!(nearest("maring_m", words.into_iter()), Some("margin_m"));
        assert_eq!(nearest("colour", words.into_iter()), None);
    }
}
