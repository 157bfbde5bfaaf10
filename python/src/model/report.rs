//! What was remarked when a file was loaded.

use dualbody::ImportReport;
use pyo3::prelude::*;

use crate::words::for_python;

/// What was remarked when a file was loaded: warnings, and what is not used. Its str is a table.
#[pyclass(frozen, name = "ImportReport", module = "dualbody")]
pub(crate) struct PyImportReport {
    pub(super) report: ImportReport,
}

/// One remark: element, name, line, reason.
type Note = (String, String, u32, String);

fn notes(notes: &[dualbody::io::ImportNote]) -> Vec<Note> {
    let note =
        |n: &dualbody::io::ImportNote| (n.path.clone(), n.name.clone(), n.line, for_python(&n.reason));
    notes.iter().map(note).collect()
}

#[pymethods]
impl PyImportReport {
    /// File, or "text".
    #[getter]
    pub(super) fn file(&self) -> &str {
        &self.report.file
    }

    /// Base of the robot: "fixed" or "floating".
    #[getter]
    pub(super) fn base(&self) -> String {
        format!("{:?}", self.report.base).to_lowercase()
    }

    /// Name of the link at the root.
    #[getter]
    fn root_link(&self) -> &str {
        &self.report.root_link
    }

    /// [(element, name, line, reason)] of what was corrected or is doubtful.
    #[getter]
    fn warnings(&self) -> Vec<Note> {
        notes(&self.report.warnings)
    }

    /// [(element, name, line, reason)] of what is not used.
    #[getter]
    fn ignored(&self) -> Vec<Note> {
        notes(&self.report.ignored)
    }

    fn __str__(&self) -> String {
        for_python(&self.report.to_string())
    }

    pub(super) fn __repr__(&self) -> String {
        for_python(&self.report.to_string())
    }

    pub(super) fn _repr_html_(&self) -> String {
        let escaped = |text: &str| text.replace('&', "&amp;").replace('<', "&lt;");
        let row = |kind: &str, n: &dualbody::io::ImportNote| {
            let cells = [kind, &n.path, &n.name, &n.line.to_string(), &for_python(&n.reason)].map(escaped);
            format!("<tr><td>{}</td></tr>", cells.join("</td><td>"))
        };
        let warnings = self.report.warnings.iter().map(|n| row("warning", n));
        let ignored = self.report.ignored.iter().map(|n| row("not used", n));
        let rows: String = warnings.chain(ignored).collect();
        let rows = match rows.is_empty() {
            true => "<tr><td colspan=5>nothing is left out, nothing is doubtful</td></tr>".into(),
            false => rows,
        };
        let notes = [self.report.base_note(), self.report.limits_note()];
        let notes: String = notes
            .into_iter()
            .flatten()
            .map(|note| format!("<p>{}</p>", escaped(&for_python(&note))))
            .collect();
        let head = "<tr><th></th><th>element</th><th>name</th><th>line</th><th>reason</th></tr>";
        format!(
            "<p>{} ({} base, root {})</p>{notes}<table>{head}{rows}</table>",
            escaped(&self.report.file),
            self.base(),
            escaped(&self.report.root_link)
        )
    }
}
