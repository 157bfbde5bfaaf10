//! Plots of the columns of a recording.

use super::plot::Plot;
use super::recording::Recording;
use crate::error::UnknownName;
use crate::nested::IntoNested;

impl Recording {
    /// Plots columns over time.
    ///
    /// * `columns` – names of columns as in the CSV (`q.<joint>`, `v.<joint>`, `u.<input>`, …) or of series; `u<k>` is an input by index; the legend
    ///   shows its name
    ///
    /// # Errors
    /// If there is no such column.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Simulator, State, model::samples, view::Recording};
    ///
    /// let simulator = Simulator::new(samples::pendulum()).with_time_step(0.01);
    /// let swing = simulator.rollout(&State::new(&[1.0], &[0.0]), 200, |_, _, _| {});
    /// let recording = Recording::from_rollout(simulator.model(), &swing);
    /// let plot = recording.plot(&["q.pivot", "v.pivot"])?;
    /// assert!(plot.to_svg().contains("v.pivot"));
    /// # Ok::<(), dualbody::UnknownName>(())
    /// ```
    pub fn plot(&self, columns: &[&str]) -> Result<Plot, UnknownName> {
        let label = if let [only] = columns { only } else { "" };
        let mut plot = Plot::new(&self.title).with_axes("t [s]", label);
        for name in columns {
            let values = self.column(name)?;
            let points = self.times.iter().copied().zip(values);
            plot = plot.with_line(self.line_name(name), points);
        }
        Ok(plot)
    }

    /// Plots one column against another: a phase portrait with a position and its velocity.
    ///
    /// # Errors
    /// If there is no such column.
    pub fn phase_plot(&self, x: &str, y: &str) -> Result<Plot, UnknownName> {
        let points = self.column(x)?.into_iter().zip(self.column(y)?);
        let plot = Plot::new(&self.title).with_axes(x, y).with_size(560, 520);
        Ok(plot.with_line(y, points))
    }

    /// Name of a line: its column, and for an input also what it acts on.
    fn line_name(&self, column: &str) -> String {
        let inputs = self.robots.iter().nested(|track| {
            let prefix = self.prefix(track);
            let names = track.inputs.iter().enumerate();
            names.map(move |(k, name)| (format!("{prefix}u{k}"), name))
        });
        let mut own = inputs.filter(|(input, _)| input == column);
        own.next()
            .map_or(column.into(), |(_, name)| format!("{column}, {name}"))
    }

    /// The values of a column.
    fn column(&self, name: &str) -> Result<Vec<f64>, UnknownName> {
        let mut known = Vec::new();
        for track in &self.robots {
            let (names, prefix) = (self.own_columns(track), self.prefix(track));
            let named = names.iter().position(|own| own == name);
            let by_number = || {
                let name = name.strip_prefix(&prefix)?;
                track.state_names().iter().position(|own| own == name)
            };
            if let Some(j) = named.or_else(by_number) {
                let number = |k: usize| track.row(k).nth(j).unwrap_or(f64::NAN);
                return Ok((0..self.len()).map(number).collect());
            }
            known.extend(names);
        }
        if let Some(series) = self.series.iter().find(|series| series.name == name) {
            return Ok(series.values.clone());
        }
        known.extend(self.series.iter().map(|series| series.name.clone()));
        Err(UnknownName {
            model: self.title.clone(),
            element: "column".into(),
            name: name.into(),
            known,
        })
    }
}
