//! The report of an identification as an HTML page: measured and predicted forces, residuals, and parameters with their intervals.

use std::fmt::Write;

use super::html::escaped;
use crate::identify::{Report, Trace};

/// Width and height of a plot, pixels.
const SIZE: (f64, f64) = (820.0, 150.0);
/// Points of a line; of more the least and the largest of each stretch are kept.
const MAX_POINTS: usize = 1200;
/// Stretches of motion that are shown, the first ones.
const MAX_TRACES: usize = 6;

const STYLE: &str = "body{font:15px/1.45 system-ui,sans-serif;max-width:900px;margin:2em auto;padding:0 1em;color:#1d2630}\
h1{font-size:1.4em}h2{font-size:1.1em;margin-top:2em}h3{font-size:1em;margin-bottom:.2em}\
table{border-collapse:collapse}td,th{padding:.15em .8em;text-align:right;border-bottom:1px solid #dde2e8}\
td:first-child,th:first-child{text-align:left}svg{background:#fff;border:1px solid #dde2e8;display:block;margin-bottom:.4em}\
.m{stroke:#3b78d8}.p{stroke:#e0662f}.r{stroke:#2f9e6b}polyline{fill:none;stroke-width:1.3}text{font-size:11px;fill:#6e7884}\
@media(prefers-color-scheme:dark){body{background:#14181d;color:#dde2e8}svg{background:#1b2027}}";

/// Returns the report of an identification as an HTML page: a single file without scripts and network access. Write it to a file with the extension `.html`.
///
/// # Examples
/// ```
/// use dualbody::identify::{Dataset, Regressor, Report, Segment, estimate};
/// use dualbody::{dynamics, model::samples, view::identification_page};
/// use nalgebra::DMatrix;
///
/// let model = samples::pendulum();
/// let motion = |f: fn(f64) -> f64| DMatrix::from_fn(1, 200, |_, k| f(0.05 * k as f64));
/// let (q, v, a) = (motion(f64::sin), motion(f64::cos), motion(|t| -t.sin()));
/// let tau = DMatrix::from_fn(1, 200, |_, k| dynamics::inverse_dynamics(&model, &[q[k]], &[v[k]], &[a[k]])[0]);
/// let segment = Segment { experiment: "swing".into(), start: 0.0, rate: 20.0, q, v, a, tau };
/// let (learn, held) = Dataset::new(vec![segment]).hold_back(0.25);
/// let found = estimate(&Regressor::new(&model), &learn)?;
/// let page = identification_page(&Report::new(&found, &found.robot(), &held, 0.95)?);
/// assert!(page.starts_with("<!doctype html>") && page.contains("swing"));
/// # Ok::<(), dualbody::identify::IdentifyError>(())
/// ```
pub fn identification_page(report: &Report) -> String {
    let title = escaped(&format!("Identification of {}", report.robot));
    let policy = "default-src 'none'; style-src 'unsafe-inline'";
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"{policy}\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{title}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n\
         <p>{} base parameters from {} equations; condition {:.1}. {}</p>\n{}{}{}</body>\n</html>\n",
        report.base.len(),
        report.equations,
        report.condition,
        flaws(report),
        coordinates(report),
        plots(report),
        parameters(report),
    )
}

fn flaws(report: &Report) -> String {
    match report.flaws.is_empty() {
        true => "All inertias are physically consistent.".into(),
        false => format!(
            "These inertias are not physically consistent: {}.",
            escaped(&report.flaws.join("; "))
        ),
    }
}

/// Table of errors.
fn coordinates(report: &Report) -> String {
    let mut out = "<h2>Forces, N·m or N</h2>\n<table>\n<tr><th>joint</th><th>σ, learnt</th><th>validation, rms</th><th>mean</th><th>largest</th><th>measured, rms</th></tr>\n".to_owned();
    for own in &report.coordinates {
        let error = own.error;
        let numbers = [
            own.deviation,
            error.rms,
            error.mean,
            error.largest,
            error.measured,
        ];
        row(&mut out, &own.name, &numbers.map(|x| format!("{x:.3e}")));
    }
    out + "</table>\n"
}

/// Table of numbers with their intervals.
fn parameters(report: &Report) -> String {
    let mut out = format!(
        "<h2>Base parameters, SI units</h2>\n<table>\n<tr><th>meaning</th><th>value</th><th colspan=\"2\">interval of {} %</th></tr>\n",
        100.0 * report.level
    );
    for own in &report.base {
        let numbers = [own.value, own.lower, own.upper].map(|x| format!("{x:.5e}"));
        row(&mut out, &own.name, &numbers);
    }
    out + "</table>\n"
}

fn row(out: &mut String, name: &str, cells: &[String]) {
    *out += &format!("<tr><td>{}</td>", escaped(name));
    for cell in cells {
        *out += &format!("<td>{cell}</td>");
    }
    *out += "</tr>\n";
}

/// Measured and predicted forces, and their difference, of each joint.
fn plots(report: &Report) -> String {
    let mut out =
        "<h2>Validation: measured (blue), predicted (orange), difference (green)</h2>\n".to_owned();
    for trace in report.traces.iter().take(MAX_TRACES) {
        for (k, coordinate) in report.coordinates.iter().enumerate() {
            let (experiment, joint) = (escaped(&trace.experiment), escaped(&coordinate.name));
            out += &format!("<h3>{experiment}: {joint}</h3>\n{}", plot(trace, k));
        }
    }
    let more = report.traces.len().saturating_sub(MAX_TRACES);
    if more > 0 {
        out += &format!("<p>{more} more stretches are not shown.</p>\n");
    }
    out
}

fn plot(trace: &Trace, coordinate: usize) -> String {
    let measured: Vec<f64> = trace.measured.row(coordinate).iter().copied().collect();
    let predicted: Vec<f64> = trace.predicted.row(coordinate).iter().copied().collect();
    let errors: Vec<f64> = measured
        .iter()
        .zip(&predicted)
        .map(|(m, p)| m - p)
        .collect();
    let (width, height) = SIZE;
    let mut out =
        format!("<svg viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\">");
    let all = || measured.iter().chain(&predicted).chain(&errors).copied();
    let (low, high) = (all().fold(0.0, f64::min), all().fold(0.0, f64::max));
    let span = if high > low { high - low } else { 1.0 };
    let (first, last) = match trace.times[..] {
        [first, .., last] => (first, last),
        _ => (0.0, 1.0),
    };
    let x = |k: usize| 4.0 + (width - 8.0) * (trace.times[k] - first) / (last - first);
    let y = |value: f64| 4.0 + (height - 8.0) * (high - value) / span;
    for (class, values) in [("m", &measured), ("p", &predicted), ("r", &errors)] {
        let _ = write!(out, "<polyline class=\"{class}\" points=\"");
        for k in kept(values) {
            let _ = write!(out, "{:.1},{:.1} ", x(k), y(values[k]));
        }
        out += "\"/>";
    }
    let _ = writeln!(
        out,
        "<text x=\"6\" y=\"14\">{high:.3}</text><text x=\"6\" y=\"{:.0}\">{low:.3}</text><text x=\"{:.0}\" y=\"{:.0}\" text-anchor=\"end\">{first:.2} to {last:.2} s</text></svg>",
        height - 6.0,
        width - 6.0,
        height - 6.0
    );
    out
}

/// Indices of the points of a line that are drawn.
fn kept(values: &[f64]) -> Vec<usize> {
    let stretch = (2 * values.len()).div_ceil(MAX_POINTS).max(1);
    if stretch <= 2 {
        return (0..values.len()).collect();
    }
    let mut out = Vec::with_capacity(MAX_POINTS);
    for first in (0..values.len()).step_by(stretch) {
        let own = first..(first + stretch).min(values.len());
        let by_value = |a: &usize, b: &usize| values[*a].total_cmp(&values[*b]);
        let low = own.clone().min_by(by_value).unwrap_or(first);
        let high = own.max_by(by_value).unwrap_or(first);
        out.extend([low.min(high), low.max(high)]);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::{Dataset, Regressor, Segment, estimate};
    use crate::model::samples;
    use nalgebra::DMatrix;

    fn report(name: &str, samples: usize) -> Report {
        let model = samples::pendulum();
        let motion = |f: fn(f64) -> f64| DMatrix::from_fn(1, samples, |_, k| f(0.05 * k as f64));
        let (q, v, a) = (motion(f64::sin), motion(f64::cos), motion(|t| -t.sin()));
        let tau = DMatrix::from_fn(1, samples, |_, k| {
            crate::dynamics::inverse_dynamics(&model, &[q[k]], &[v[k]], &[a[k]])[0]
        });
        let segment = Segment {
            experiment: name.into(),
            start: 0.0,
            rate: 20.0,
            q,
            v,
            a,
            tau,
        };
        let data = Dataset::new(vec![segment]);
        let found = estimate(&Regressor::new(&model), &data).unwrap();
        Report::new(&found, &found.robot(), &data, 0.95).unwrap()
    }

    #[test]
    fn page_has_every_parameter_and_escapes_names() {
        let report = report("<b>swing</b> & \"more\"", 100);
        let page = identification_page(&report);
        assert!(page.contains("&lt;b&gt;swing") && !page.contains("<b>"));
        for own in &report.base {
            assert!(page.contains(&escaped(&own.name)), "{}", own.name);
        }
        assert_eq!(page.matches("<polyline").count(), 3);
        assert!(!page.contains("<script") && !page.contains("NaN"));
    }

    #[test]
    fn long_motions_are_thinned_out_but_keep_their_peaks() {
        let mut values = vec![0.0; 100_000];
        values[31_416] = 7.0;
        let kept = kept(&values);
        assert!(kept.len() <= MAX_POINTS + 2 && kept.contains(&31_416));
        assert!(kept.windows(2).all(|pair| pair[0] <= pair[1]));
        assert!(identification_page(&report("long", 20_000)).len() < 200_000);
    }
}
