//! Writes XML.

/// A text that grows by elements.
#[derive(Debug, Default)]
pub(super) struct Writer {
    text: String,
}

impl Writer {
    /// A start tag.
    pub(super) fn start(&mut self, tag: &str, attributes: &[(&str, &str)]) {
        self.open(tag, attributes);
        self.text.push('>');
    }

    /// An element without content.
    pub(super) fn leaf(&mut self, tag: &str, attributes: &[(&str, &str)]) {
        self.open(tag, attributes);
        self.text.push_str("/>");
    }

    /// An end tag.
    pub(super) fn end(&mut self, tag: &str) {
        self.text.push_str("</");
        self.text.push_str(tag);
        self.text.push('>');
    }

    /// The text so far.
    pub(super) fn finish(self) -> String {
        self.text
    }

    fn open(&mut self, tag: &str, attributes: &[(&str, &str)]) {
        self.text.push('<');
        self.text.push_str(tag);
        for (name, value) in attributes {
            self.text.push(' ');
            self.text.push_str(name);
            self.text.push_str("=\"");
            self.escape(value);
            self.text.push('"');
        }
    }

    fn escape(&mut self, value: &str) {
        let mut rest = value;
        while let Some(at) = rest.find(['&', '<', '>', '"', '\n', '\r', '\t']) {
            self.text.push_str(&rest[..at]);
            self.text.push_str(match rest.as_bytes()[at] {
                b'&' => "&amp;",
                b'<' => "&lt;",
                b'>' => "&gt;",
                b'"' => "&quot;",
                // A line break or tab, which stands for a space in an attribute.
                _ => " ",
            });
            rest = &rest[at + 1..];
        }
        self.text.push_str(rest);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn written_attributes_equal_what_a_parser_reads_back() {
        let value = "a & b < c > \"d\" 'e' ü";
        let mut writer = Writer::default();
        writer.start("outer", &[("name", value), ("second", "1 2\n3")]);
        writer.leaf("inner", &[]);
        writer.end("outer");
        let text = writer.finish();
        let document = roxmltree::Document::parse(&text).unwrap();
        let outer = document.root_element();
        assert_eq!(outer.attribute("name"), Some(value));
        assert_eq!(outer.attribute("second"), Some("1 2 3"));
        assert!(outer.first_element_child().unwrap().has_tag_name("inner"));
    }
}
