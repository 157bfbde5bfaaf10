//! Texts of files in messages: on one line, without control characters, of bounded length.
//!
//! Messages are shown in terminals, logs and browsers. Names and values from a file must neither control nor flood them.

use std::fmt::{self, Write};

/// Characters of a text that a message shows: enough for a path or a sentence.
const MAX_CHARACTERS: usize = 400;

/// Names of a list that a message shows: enough for the joints of most robots.
const MAX_NAMES: usize = 40;

/// Remarks of a report that are shown, and how many bytes of them: names in a file may be as long as they like.
const MAX_REMARKS: usize = 100;
const MAX_REMARK_BYTES: usize = 8_500;

/// A message, as `format_args!` makes it of texts of others: control characters, and those that turn the direction of
/// writing, are escaped; a text in it that is too long ends with its length.
pub(crate) fn message(text: fmt::Arguments<'_>) -> Message<'_> {
    Message(text)
}

/// Names of others, separated by commas; the first ones where there are many.
pub(crate) fn listed<T: fmt::Display>(names: &[T]) -> Listed<'_, T> {
    Listed(names)
}

/// Writes remarks, one a line; the first ones where there are many.
pub(crate) fn write_remarks<T: fmt::Display>(
    f: &mut fmt::Formatter<'_>,
    remarks: &[T],
) -> fmt::Result {
    let (mut shown, mut left) = (0, MAX_REMARK_BYTES);
    for remark in remarks.iter().take(MAX_REMARKS) {
        let text = remark.to_string();
        let Some(rest) = left.checked_sub(text.len()) else {
            break;
        };
        writeln!(f, "  {text}")?;
        (shown, left) = (shown + 1, rest);
    }
    match remarks.len() - shown {
        0 => Ok(()),
        more => writeln!(f, "  and {more} more"),
    }
}

/// A number with so many digits, but without zeros at the end of its decimals.
#[cfg(any(feature = "identification", feature = "plot"))]
pub(crate) fn rounded(x: f64, digits: i32) -> String {
    let magnitude = x.abs().log10().floor() as i32;
    let places = (digits - 1).saturating_sub(magnitude).max(0) as usize;
    let text = format!("{x:.places$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

/// See [`message`].
pub(crate) struct Message<'a>(fmt::Arguments<'a>);

impl fmt::Display for Message<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        Plain(f).write_fmt(self.0)
    }
}

/// Formatter that takes the texts of a message in sequence.
struct Plain<'a, 'f>(&'a mut fmt::Formatter<'f>);

impl Write for Plain<'_, '_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let end = text.char_indices().nth(MAX_CHARACTERS).map(|(i, _)| i);
        for c in text[..end.unwrap_or(text.len())].chars() {
            if is_steering(c) {
                write!(self.0, "{}", c.escape_debug())?;
            } else {
                self.0.write_char(c)?;
            }
        }
        end.map_or(Ok(()), |_| write!(self.0, "… ({} bytes)", text.len()))
    }
}

/// Whether a character controls the display.
fn is_steering(c: char) -> bool {
    let is_format = matches!(c, '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{feff}');
    c.is_control() || is_format
}

/// See [`listed`].
pub(crate) struct Listed<'a, T>(&'a [T]);

impl<T: fmt::Display> fmt::Display for Listed<'_, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (k, name) in self.0.iter().take(MAX_NAMES).enumerate() {
            let separator = if k > 0 { ", " } else { "" };
            write!(f, "{separator}{name}")?;
        }
        match self.0.len().saturating_sub(MAX_NAMES) {
            0 => Ok(()),
            more => write!(f, " and {more} more"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Remarks of so many bytes each.
    struct Report(Vec<String>);

    impl fmt::Display for Report {
        fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            write_remarks(f, &self.0)
        }
    }

    #[test]
    fn reports_show_the_first_remarks_and_how_many_more_there_are() {
        for (length, remarks, more) in [(10, 7, 0), (10, 130, 30), (400, 100, 79)] {
            let text = Report(vec!["x".repeat(length); remarks]).to_string();
            let said = text.contains(&format!("  and {more} more\n"));
            assert!(said == (more > 0) && text.len() < 9_000, "{text}");
            assert_eq!(text.matches(&"x".repeat(length)).count(), remarks - more);
        }
    }

    fn shown(text: &str) -> String {
        message(format_args!("<{text}>")).to_string()
    }

    #[test]
    fn control_characters_are_shown_and_other_characters_stay() {
        let text = shown("\u{1b}[2J\0 \r\n\t\u{9b}\u{202e} «é» \"a\\b'\" 漢");
        let expected = "<\\u{1b}[2J\\0 \\r\\n\\t\\u{9b}\\u{202e} «é» \"a\\b'\" 漢>";
        assert_eq!(text, expected);
    }

    #[test]
    fn long_texts_are_cut_and_say_how_long_they_are() {
        let text = shown(&"ä".repeat(1_000_000));
        assert!(
            text.len() < 1000 && text.ends_with("ä… (2000000 bytes)>"),
            "{text}"
        );
        let exact = "a".repeat(MAX_CHARACTERS);
        assert_eq!(shown(&exact), format!("<{exact}>"));
    }

    #[test]
    fn long_lists_are_cut_and_say_how_much_there_is() {
        let names: Vec<String> = (0..20_000).map(|k| format!("link{k}")).collect();
        let text = message(format_args!("{}", listed(&names))).to_string();
        assert!(text.len() < 1000 && text.ends_with("link38, link39 and 19960 more"));
        assert_eq!(listed(&names[..2]).to_string(), "link0, link1");
    }

    #[test]
    fn error_of_twenty_thousand_roots_is_short() {
        let roots = (0..20_000).map(|k| format!("link\u{1b}{k}")).collect();
        let file = "many.urdf".into();
        let error = crate::LoadError::SeveralRoots { file, roots };
        let text = error.to_string();
        assert!(text.len() < 1000 && !text.contains('\u{1b}'), "{text}");
        assert!(text.starts_with("many.urdf: several links have no parent: link\\u{1b}0, "));
    }

    #[test]
    fn error_of_a_misspelt_name_shows_the_right_one_of_thousands() {
        let known = (0..5_000).map(|k| format!("joint_{k}")).collect();
        let error = crate::UnknownName {
            model: "crowd".into(),
            element: "joint".into(),
            name: "jont_4321".into(),
            known,
        };
        let text = error.to_string();
        let start = "model \"crowd\" has no joint \"jont_4321\"; it has: joint_4321, ";
        assert!(
            text.starts_with(start) && text.ends_with(" and 4960 more"),
            "{text}"
        );
    }
}
