//! Writes indented XML.

/// Levels that are indented; deeper ones stay there, so that the text of a chain is linear in its length.
const MAX_LEVELS: usize = 16;

/// A text that grows by elements.
#[derive(Debug)]
pub(super) struct Xml {
    text: String,
    open: Vec<&'static str>,
}

impl Xml {
    pub(super) fn new() -> Self {
        Self {
            text: "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n".into(),
            open: Vec::new(),
        }
    }

    /// A start tag; [`end`](Self::end) closes it.
    pub(super) fn start<S: AsRef<str>>(&mut self, tag: &'static str, attributes: &[(&str, S)]) {
        self.tag(tag, attributes);
        self.text.push_str(">\n");
        self.open.push(tag);
    }

    /// A start tag without attributes.
    pub(super) fn open(&mut self, tag: &'static str) {
        self.start::<&str>(tag, &[]);
    }

    /// An element without content.
    pub(super) fn leaf<S: AsRef<str>>(&mut self, tag: &str, attributes: &[(&str, S)]) {
        self.tag(tag, attributes);
        self.text.push_str("/>\n");
    }

    /// An element that contains a text only.
    pub(super) fn text(&mut self, tag: &str, text: &str) {
        self.tag::<&str>(tag, &[]);
        self.text.push('>');
        escape(&mut self.text, text);
        self.text.extend(["</", tag, ">\n"]);
    }

    /// Closes the innermost element.
    pub(super) fn end(&mut self) {
        if let Some(tag) = self.open.pop() {
            self.indent();
            self.text.push_str("</");
            self.text.push_str(tag);
            self.text.push_str(">\n");
        }
    }

    /// A comment; two hyphens in a row, which end one, are set apart.
    pub(super) fn comment(&mut self, text: &str) {
        self.indent();
        self.text.push_str("<!-- ");
        for c in text.chars() {
            let follows_hyphen = self.text.ends_with('-');
            self.text
                .extend((c == '-' && follows_hyphen).then_some(' '));
            self.text.push(c);
        }
        self.text.push_str(" -->\n");
    }

    /// The text, with every element closed.
    pub(super) fn finish(mut self) -> String {
        while !self.open.is_empty() {
            self.end();
        }
        self.text
    }

    fn tag<S: AsRef<str>>(&mut self, tag: &str, attributes: &[(&str, S)]) {
        self.indent();
        self.text.push('<');
        self.text.push_str(tag);
        for (name, value) in attributes {
            self.text.push(' ');
            self.text.push_str(name);
            self.text.push_str("=\"");
            escape(&mut self.text, value.as_ref());
            self.text.push('"');
        }
    }

    fn indent(&mut self) {
        let levels = self.open.len().min(MAX_LEVELS);
        self.text.extend(std::iter::repeat_n("  ", levels));
    }
}

fn escape(text: &mut String, value: &str) {
    for c in value.chars() {
        match c {
            '&' => text.push_str("&amp;"),
            '<' => text.push_str("&lt;"),
            '>' => text.push_str("&gt;"),
            '"' => text.push_str("&quot;"),
            // Readers take those for spaces where they stand for themselves.
            '\n' | '\r' | '\t' => text.extend(["&#", &u32::from(c).to_string(), ";"]),
            _ => text.push(c),
        }
    }
}

/// The shortest text that reads back as the same number.
pub(super) fn number(x: f64) -> String {
    let text = format!("{x:?}");
    text.strip_suffix(".0").map_or(text.clone(), Into::into)
}

/// Numbers with spaces between them.
pub(super) fn numbers(x: &[f64]) -> String {
    let texts: Vec<String> = x.iter().copied().map(number).collect();
    texts.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn written_text_equals_what_a_parser_reads_back() {
        let value = "a & b < c > \"d\" 'e' ü\n\r\n\tf";
        let mut xml = Xml::new();
        xml.start("outer", &[("name", value)]);
        xml.comment("a--b---> c-");
        xml.leaf("inner", &[("a", "b")]);
        let text = xml.finish();
        let document = roxmltree::Document::parse(&text).unwrap();
        let outer = document.root_element();
        assert_eq!(outer.attribute("name"), Some(value));
        assert!(outer.first_element_child().unwrap().has_tag_name("inner"));
    }

    #[test]
    fn written_numbers_equal_the_numbers_read_back() {
        for x in [
            0.0,
            -0.0,
            1.0,
            -2.5,
            0.1 + 0.2,
            1e-300,
            1e300,
            f64::MIN_POSITIVE,
            123_456_789.0,
        ] {
            assert_eq!(
                number(x).parse::<f64>().unwrap().to_bits(),
                x.to_bits(),
                "{x}"
            );
        }
        assert_eq!(numbers(&[1.0, -0.5, 2e-7]), "1 -0.5 2e-7");
    }
}
