//! The name that was probably meant by a misspelt one.

/// Edits that a short name may differ from the intended one; each three letters allow one more.
/// Chosen so that `nose_tp` finds `nose_tip` and `elbow` finds none of the landmarks.
const BASE_EDITS: usize = 1;
const LETTERS_PER_EDIT: usize = 3;
/// Only this many letters of a name are compared, which bounds the time on any input.
const MAX_LETTERS: usize = 64;

/// The known name nearest to `name` by edit distance; `None` when no name is near enough to be the
/// one that was meant.
pub(crate) fn nearest_name<'a>(
    name: &str,
    known: impl IntoIterator<Item = &'a str>,
) -> Option<&'a str> {
    let best = known.into_iter().map(|k| (edit_distance(name, k), k)).min()?;
    (best.0 <= BASE_EDITS + best.1.len() / LETTERS_PER_EDIT).then_some(best.1)
}

/// Levenshtein distance, ignoring case.
fn edit_distance(a: &str, b: &str) -> usize {
    let a: Vec<char> = a.chars().take(MAX_LETTERS).flat_map(char::to_lowercase).collect();
    let b: Vec<char> = b.chars().take(MAX_LETTERS).flat_map(char::to_lowercase).collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.iter().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, cb) in b.iter().enumerate() {
            let substitute = diagonal + usize::from(ca != cb);
            diagonal = row[j + 1];
            row[j + 1] = substitute.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn misspelt_names_are_found_and_other_words_are_not() {
        assert_eq!(edit_distance("kitten", "sitting"), 3);
        assert_eq!(nearest_name("nose_tp", ["chin", "nose_tip"]), Some("nose_tip"));
        assert_eq!(nearest_name("elbow", ["chin", "nose_tip"]), None);
    }
}
