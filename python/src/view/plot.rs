//! Plots of curves.

use std::path::PathBuf;

use dualbody::view::{Plot, PlotLine, PlotScale};
use pyo3::types::PyBytes;

use crate::prelude::*;

/// Plot of curves; shows itself in notebooks.
#[pyclass(frozen, name = "Plot", module = "dualbody")]
pub(crate) struct PyPlot {
    pub(super) plot: Plot,
}

functions! {
    /// Makes a plot again that was pickled.
    fn _plot(title: &str, axes: [String; 2], size: (u32, u32), is_logarithmic: bool, lines: Vec<(String, Vec<(f64, f64)>)>) -> PyResult<PyPlot> {
        let [x, y] = axes;
        let plot = Plot::new(title).with_axes(x, y);
        let mut plot = guarded(|| plot.with_size(size.0, size.1))?;
        if is_logarithmic {
            plot = plot.with_logarithmic_axes();
        }
        let add = |plot: Plot, (name, points)| plot.with_line(name, points);
        Ok(PyPlot {
            plot: lines.into_iter().fold(plot, add),
        })
    }
}

#[pymethods]
impl PyPlot {
    fn __reduce__<'py>(&self, py: Python<'py>) -> Recipe<'py> {
        let make = of_package!(py, "_dualbody", "_plot");
        let plot = &self.plot;
        let line = |line: &PlotLine| (line.name.clone(), line.points.clone());
        let lines: Vec<_> = plot.lines.iter().map(line).collect();
        let parts = (
            &plot.title,
            plot.axes.each_ref(),
            plot.size(),
            plot.scale == PlotScale::Logarithmic,
            lines,
        );
        Ok((make.clone(), parts.into_pyobject(py)?.into_any()))
    }

    fn _repr_svg_(&self) -> PyResult<String> {
        self.to_svg()
    }
}

methods! { PyPlot {
    /// The plot as a text of SVG.
    fn to_svg(&self) -> PyResult<String> { Ok(self.plot.to_svg()) }

    /// Writes the plot as SVG, and creates its folders; an OSError names a file that cannot be written.
    fn save_svg(&self, path: PathBuf) -> PyResult<()> { self.plot.save_svg(path).or_raise() }

    /// The plot as the bytes of a PNG.
    fn to_png(&self, py: Python) -> PyResult<Bound<'py, PyBytes>> { Ok(PyBytes::new(py, &self.plot.to_png())) }

    /// Writes the plot as PNG, and creates its folders; an OSError names a file that cannot be written.
    fn save_png(&self, path: PathBuf) -> PyResult<()> { self.plot.save_png(path).or_raise() }

    /// An empty plot: title, names of the axes, size in pixels.
    #[new]
    fn new(title: &str = "", *, x: &str = "", y: &str = "", size = None, logarithmic: bool = false) -> PyResult<Self> {
        let mut plot = Plot::new(title).with_axes(x, y);
        if let Some(size) = size {
            let (width, height) = whole("size", size)?;
            plot = guarded(|| plot.with_size(width, height))?;
        }
        if logarithmic {
            plot = plot.with_logarithmic_axes();
        }
        Ok(Self { plot })
    }

    /// The plot with another size, pixels.
    fn with_size(&self, width, height) -> PyResult<Self> {
        let (width, height) = (whole("width", width)?, whole("height", height)?);
        Ok(Self { plot: self.plot.clone().with_size(width, height) })
    }

    /// The plot with an additional curve through the points (x, y).
    fn with_line(&self, name: String, x, y) -> PyResult<Self> {
        let x = read_vector("x", x, None)?;
        let y = read_vector("y", y, Some(x.len()))?;
        Ok(Self { plot: self.plot.clone().with_line(name, x.into_iter().zip(y)) })
    }
} }
