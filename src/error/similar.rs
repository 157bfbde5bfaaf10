//! Names that a wrong one may have been meant for.

use crate::nested::IntoNested;
use crate::sorting::sort_seldom;

/// Characters of a name that are compared: longer names are not typing errors.
const MAX_CHARACTERS: usize = 64;

/// Share of the characters that may differ.
const SHARE: usize = 3;

/// Shortest name that counts as similar by being part of another.
const LEAST_PART: usize = 3;

/// The names, those similar to another one first, most similar ones ahead; the others in their order.
pub(super) fn similar_first<'a>(name: &str, known: &'a [String]) -> Vec<&'a String> {
    let wanted = Name::of(name);
    let mut ranked: Vec<_> = known
        .iter()
        .map(|known| (wanted.rank(&Name::of(known)), known))
        .collect();
    sort_seldom(&mut ranked, |(one, _), (other, _)| one.cmp(other));
    ranked.into_iter().map(|(_, name)| name).collect()
}

/// A name in the form in which it is compared: without regard to case.
struct Name(Vec<char>);

impl Name {
    fn of(name: &str) -> Self {
        let lower = name.chars().nested(char::to_lowercase);
        Self(lower.take(MAX_CHARACTERS).collect())
    }

    /// Rank of a name by its distance from this one: the lower, the more similar; the largest number if it is not
    /// similar.
    fn rank(&self, other: &Self) -> usize {
        let (own, theirs) = (self.0.len(), other.0.len());
        let most = (own.max(theirs) / SHARE).max(1);
        if own.abs_diff(theirs) <= most {
            let distance = edit_distance(&self.0, &other.0);
            if distance <= most && distance < own.max(theirs) {
                return distance;
            }
        }
        let (short, long) = if own < theirs {
            (&self.0, &other.0)
        } else {
            (&other.0, &self.0)
        };
        let is_part =
            short.len() >= LEAST_PART && long.windows(short.len()).any(|part| part == short);
        // Behind all that differ by slips.
        if is_part {
            MAX_CHARACTERS + long.len() - short.len()
        } else {
            usize::MAX
        }
    }
}

/// The number of characters to insert, remove or replace, the one text becoming the other [Wagner and Fischer 1974].
fn edit_distance(a: &[char], b: &[char]) -> usize {
    // Distances of the beginning of `a` from all beginnings of `b`.
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, a) in a.iter().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, b) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(a != b);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn distance(a: &str, b: &str) -> usize {
        let [a, b] = [a, b].map(|text| text.chars().collect::<Vec<char>>());
        assert_eq!(edit_distance(&a, &b), edit_distance(&b, &a));
        edit_distance(&a, &b)
    }

    #[test]
    fn edit_distance_equals_the_textbook_examples() {
        assert_eq!(distance("kitten", "sitting"), 3);
        assert_eq!(distance("sunday", "saturday"), 3);
        assert_eq!(distance("", "abc"), 3);
        assert_eq!(distance("knöchel", "knochel"), 1);
        assert_eq!(distance("same", "same"), 0);
    }

    #[test]
    fn similar_names_come_first_and_the_others_keep_their_order() {
        let known: Vec<String> = [
            "waist",
            "left_elbow_joint",
            "elbow_pitch",
            "Elbw",
            "knee",
            "elbows",
            "ELBOW",
        ]
        .map(String::from)
        .into();
        let sorted = similar_first("elbow", &known);
        assert_eq!(
            sorted,
            [
                "ELBOW",
                "Elbw",
                "elbows",
                "elbow_pitch",
                "left_elbow_joint",
                "waist",
                "knee"
            ]
        );
        assert_eq!(similar_first("x", &known), Vec::from_iter(&known));
        assert_eq!(similar_first("", &known), Vec::from_iter(&known));
        // Long names take no time by the square of their length.
        let long = vec!["a".repeat(1_000_000), "b".repeat(1_000_000)];
        assert_eq!(similar_first(&"b".repeat(900_000), &long)[0], &long[1]);
    }
}
