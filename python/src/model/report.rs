//! Report of loading a file.

use dualbody::io::ImportNote;
use dualbody::{Base, ImportReport};

use crate::prelude::*;
use crate::words::for_python;

/// Report of loading a file: warnings, and unused content. Its str is a table.
#[pyclass(frozen, name = "ImportReport", module = "dualbody")]
pub(crate) struct PyImportReport {
    pub(crate) report: ImportReport,
}

/// Base of a robot, by name.
pub(super) fn base_of(name: &str) -> PyResult<Base> {
    variant("base", name, &[Base::Auto, Base::Fixed, Base::Floating])
}

functions! {
    /// Restores a pickled report: file, base, requested base, root link, joints with limits, warnings, unused lines.
    fn _import_report(
        file: String, bases: [String; 2], root_link: String, limited_joints: usize, warnings: Vec<Note>, ignored: Vec<Note>
    ) -> PyResult<PyImportReport> {
        let one = |(path, name, line, reason): Note| ImportNote::new(path, name, line, reason);
        let mut report = ImportReport::new(file, base_of(&bases[0])?, root_link);
        report.wanted_base = base_of(&bases[1])?;
        report.limited_joints = limited_joints;
        report.warnings = warnings.into_iter().map(one).collect();
        report.ignored = ignored.into_iter().map(one).collect();
        Ok(PyImportReport { report })
    }
}

/// One remark: element, name, line, reason.
type Note = (String, String, u32, String);

fn notes(notes: &[ImportNote]) -> Vec<Note> {
    let note = |n: &ImportNote| {
        (
            n.path.clone(),
            n.name.clone(),
            n.line,
            for_python(&n.reason),
        )
    };
    notes.iter().map(note).collect()
}

getters! { PyImportReport {
    /// File, or "text".
    file: &str = |own| &own.report.file;

    /// Base of the robot: "fixed" or "floating".
    base: String = |own| snake(own.report.base);

    /// Name of the link at the root.
    root_link: &str = |own| &own.report.root_link;

    /// [(element, name, line, reason)] of corrected or doubtful content.
    warnings: Vec<Note> = |own| notes(&own.report.warnings);

    /// [(element, name, line, reason)] of unused content.
    ignored: Vec<Note> = |own| notes(&own.report.ignored);
} }

#[pymethods]
impl PyImportReport {
    fn __reduce__<'py>(&self, py: Python<'py>) -> Recipe<'py> {
        let make = of_package!(py, "_dualbody", "_import_report");
        let r = &self.report;
        let parts = (
            &r.file,
            [snake(r.base), snake(r.wanted_base)],
            &r.root_link,
            r.limited_joints,
            self.warnings(),
            self.ignored(),
        );
        Ok((make.clone(), parts.into_pyobject(py)?.into_any()))
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.report == other.report
    }

    fn __str__(&self) -> String {
        for_python(&self.report.to_string())
    }

    pub(super) fn __repr__(&self) -> String {
        for_python(&self.report.to_string())
    }

    pub(super) fn _repr_html_(&self) -> String {
        let escaped = |text: &str| text.replace('&', "&amp;").replace('<', "&lt;");
        let row = |kind: &str, n: &ImportNote| {
            let cells = [
                kind,
                &n.path,
                &n.name,
                &n.line.to_string(),
                &for_python(&n.reason),
            ]
            .map(escaped);
            format!("<tr><td>{}</td></tr>", cells.join("</td><td>"))
        };
        let warnings = self.report.warnings.iter().map(|n| row("warning", n));
        let ignored = self.report.ignored.iter().map(|n| row("not used", n));
        let rows: String = warnings.chain(ignored).collect();
        let notes = [self.report.base_note(), self.report.limits_note()];
        let notes: String = notes
            .into_iter()
            .flatten()
            .map(|note| format!("<p>{}</p>", escaped(&for_python(&note))))
            .collect();
        let head = "<tr><th></th><th>element</th><th>name</th><th>line</th><th>reason</th></tr>";
        let table = match rows.is_empty() {
            true => "<p>nothing is left out, nothing is doubtful</p>".into(),
            false => format!("<table>{head}{rows}</table>"),
        };
        format!(
            "<p>{} ({} base, root {})</p>{notes}{table}",
            escaped(&self.report.file),
            self.base(),
            escaped(&self.report.root_link)
        )
    }
}
