//! Plots as SVG and PNG (feature `plot`).
//!
//! A [`Plot`] has lines over two axes, linear or logarithmic; a recording [plots](super::Recording::plot) its columns over time and against each
//! other. Use it for papers and reports; to explore a motion, the HTML viewer is better.

use std::error::Error;
use std::ops::Range;
use std::path::Path;
use std::sync::Once;

use plotters::coord::ranged1d::{AsRangedCoord, Ranged, ValueFormatter};
use plotters::prelude::*;
use plotters::style::register_font;

use super::files::write;
use super::png;
use crate::error::{RecordingError, rounded};
use crate::memory;
use crate::nested::IntoNested;

/// Letters, digits, Greek and a few signs of `DejaVu` Sans, so that a PNG has text wherever it is made.
const FONT: &[u8] = include_bytes!("../../assets/fonts/DejaVuSans-subset.ttf");

/// Colours of the lines, those of the HTML viewer.
const INK: [RGBColor; 8] = [
    RGBColor(59, 120, 216),
    RGBColor(224, 102, 47),
    RGBColor(47, 158, 107),
    RGBColor(184, 84, 143),
    RGBColor(138, 111, 209),
    RGBColor(176, 138, 30),
    RGBColor(42, 154, 171),
    RGBColor(214, 69, 80),
];

/// Points of a line; of more the least and the largest of each stretch are kept, closer than a pixel.
const MAX_POINTS: usize = 4000;
/// Bytes of a pixel.
const COLORS: usize = 3;

/// Numbers on an axis smaller than this part of it come from rounding.
const ROUNDING: f64 = 1e-9;

/// Lines over two axes.
///
/// # Examples
/// ```
/// use dualbody::view::Plot;
///
/// let wave = (0..100).map(|k| 0.1 * f64::from(k)).map(|t| (t, t.sin()));
/// let svg = Plot::new("A wave").with_axes("t / s", "x / m").with_line("x", wave).to_svg();
/// assert!(svg.starts_with("<svg") && svg.contains("A wave"));
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Plot {
    /// Title.
    pub title: String,
    /// Labels of the axes, x and y.
    pub axes: [String; 2],
    /// Scale of both axes.
    pub scale: PlotScale,
    size: (u32, u32),
    /// The lines.
    pub lines: Vec<PlotLine>,
}

/// A line of a [`Plot`].
#[derive(Clone, Debug, PartialEq)]
pub struct PlotLine {
    /// Its name in the legend.
    pub name: String,
    /// Its points; the line is interrupted at values that are not finite.
    pub points: Vec<(f64, f64)>,
}

/// Scale of both axes of a [`Plot`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlotScale {
    /// Linear.
    Linear,
    /// Logarithmic; points that are not positive are dropped.
    Logarithmic,
}

impl Plot {
    /// Makes a plot without lines, 800 × 480 pixels.
    pub fn new(title: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            axes: Default::default(),
            scale: PlotScale::Linear,
            size: (800, 480),
            lines: Vec::new(),
        }
    }

    /// Sets the labels of the axes, with their units.
    #[must_use]
    pub fn with_axes(mut self, x: impl Into<String>, y: impl Into<String>) -> Self {
        self.axes = [x.into(), y.into()];
        self
    }

    /// Makes both axes logarithmic; points that are not positive are dropped.
    #[must_use]
    pub fn with_logarithmic_axes(mut self) -> Self {
        self.scale = PlotScale::Logarithmic;
        self
    }

    /// Sets width and height in pixels.
    ///
    /// # Panics
    /// If the pixels would need more memory than the [limit](crate::memory).
    #[must_use]
    pub fn with_size(mut self, width: u32, height: u32) -> Self {
        let bytes = (width as usize).saturating_mul(height as usize);
        let bytes = bytes.saturating_mul(COLORS);
        let what = format_args!("{width} × {height} pixels");
        memory::granted(memory::check(what, bytes));
        self.size = (width, height);
        self
    }

    /// Adds a line through points; it is interrupted at values that are not finite.
    #[must_use]
    pub fn with_line(
        mut self,
        name: impl Into<String>,
        points: impl IntoIterator<Item = (f64, f64)>,
    ) -> Self {
        self.lines.push(PlotLine {
            name: name.into(),
            points: points.into_iter().collect(),
        });
        self
    }

    /// Width and height in pixels.
    pub fn size(&self) -> (u32, u32) {
        self.size
    }

    /// Draws the plot as SVG.
    pub fn to_svg(&self) -> String {
        let mut svg = String::new();
        self.draw(&SVGBackend::with_string(&mut svg, self.size).into_drawing_area());
        svg
    }

    /// Draws the plot as PNG.
    pub fn to_png(&self) -> Vec<u8> {
        let (width, height) = self.size;
        let mut pixels = vec![0; COLORS * width as usize * height as usize];
        self.draw(&BitMapBackend::with_buffer(&mut pixels, self.size).into_drawing_area());
        png::encode(width, height, &pixels)
    }

    /// Writes the plot as SVG. Makes the folder.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn save_svg(&self, path: impl AsRef<Path>) -> Result<(), RecordingError> {
        write(path.as_ref(), self.to_svg())
    }

    /// Writes the plot as PNG. Makes the folder.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn save_png(&self, path: impl AsRef<Path>) -> Result<(), RecordingError> {
        write(path.as_ref(), self.to_png())
    }

    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, plotters::coord::Shift>)
    where
        B::ErrorType: 'static,
    {
        static FONT_IS_REGISTERED: Once = Once::new();
        FONT_IS_REGISTERED.call_once(|| {
            let registered = register_font("sans-serif", FontStyle::Normal, FONT);
            assert!(registered.is_ok(), "the font is a font");
        });
        let [x, y] = [self.range(|p| p.0), self.range(|p| p.1)];
        let drawn = match self.scale {
            PlotScale::Linear => self.draw_over(area, x, y),
            PlotScale::Logarithmic => self.draw_over(area, x.log_scale(), y.log_scale()),
        };
        // Both backends write to memory, where nothing goes wrong.
        drawn.unwrap_or_else(|error| unreachable!("{error}"));
    }

    fn draw_over<B: DrawingBackend, X>(
        &self,
        area: &DrawingArea<B, plotters::coord::Shift>,
        x: X,
        y: X,
    ) -> Result<(), Box<dyn Error>>
    where
        B::ErrorType: 'static,
        X: AsRangedCoord<Value = f64>,
        X::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
    {
        area.fill(&WHITE)?;
        let mut chart = ChartBuilder::on(area)
            .caption(&self.title, ("sans-serif", 20))
            .margin(14)
            .x_label_area_size(42)
            .y_label_area_size(66)
            .build_cartesian_2d(x, y)?;
        // Of a linear axis what rounding leaves of zero is zero.
        let [x_number, y_number] = [self.range(|p| p.0), self.range(|p| p.1)].map(|range| {
            let least = match self.scale {
                PlotScale::Linear => ROUNDING * (range.end - range.start),
                PlotScale::Logarithmic => 0.0,
            };
            move |x: &f64| short(if x.abs() < least { 0.0 } else { *x })
        });
        chart
            .configure_mesh()
            .light_line_style(WHITE)
            .bold_line_style(RGBColor(221, 226, 232))
            .axis_style(RGBColor(110, 120, 132))
            .label_style(("sans-serif", 13))
            .x_desc(&self.axes[0])
            .y_desc(&self.axes[1])
            .x_label_formatter(&x_number)
            .y_label_formatter(&y_number)
            .draw()?;
        for (k, line) in self.lines.iter().enumerate() {
            let ink = INK[k % INK.len()].stroke_width(2);
            let (mut pieces, key) = (self.pieces(line).into_iter(), ink);
            let first = pieces.next().unwrap_or_default();
            chart
                .draw_series(LineSeries::new(first, ink))?
                .label(&line.name)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 16, y)], key));
            for piece in pieces {
                chart.draw_series(LineSeries::new(piece, ink))?;
            }
        }
        if self.lines.len() > 1 {
            chart
                .configure_series_labels()
                .position(self.legend())
                .background_style(WHITE.mix(0.85))
                .border_style(RGBColor(221, 226, 232))
                .label_font(("sans-serif", 13))
                .draw()?;
        }
        area.present()?;
        Ok(())
    }

    /// Place of the legend, where there is room: what grows as a power starts at the lower left.
    fn legend(&self) -> SeriesLabelPosition {
        match self.scale {
            PlotScale::Linear => SeriesLabelPosition::UpperRight,
            PlotScale::Logarithmic => SeriesLabelPosition::UpperLeft,
        }
    }

    fn can_show(&self, x: f64, y: f64) -> bool {
        let is_inside = self.scale == PlotScale::Linear || (x > 0.0 && y > 0.0);
        x.is_finite() && y.is_finite() && is_inside
    }

    /// The stretches of a line that can be shown.
    fn pieces(&self, line: &PlotLine) -> Vec<Vec<(f64, f64)>> {
        let pieces = line.points.split(|&(x, y)| !self.can_show(x, y));
        let pieces = pieces.filter(|piece| !piece.is_empty());
        pieces.map(thinned).collect()
    }

    /// Range from the least to the largest number of all lines, with a margin.
    fn range(&self, of: impl Fn(&(f64, f64)) -> f64) -> Range<f64> {
        let points = self.lines.iter().nested(|line| &line.points);
        let shown = points.filter(|&&(x, y)| self.can_show(x, y)).map(of);
        let (low, high) = shown.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
            (low.min(x), high.max(x))
        });
        match self.scale {
            _ if low > high => 1.0..2.0,
            PlotScale::Logarithmic => low / 1.2..high * 1.2,
            PlotScale::Linear if low < high => {
                let margin = 0.04 * (high - low);
                low - margin..high + margin
            }
            PlotScale::Linear => low - 1.0..high + 1.0,
        }
    }
}

/// The least and the largest of each stretch, where there are too many points.
fn thinned(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let stretch = (2 * points.len()).div_ceil(MAX_POINTS);
    if stretch <= 2 {
        return points.to_vec();
    }
    let ends = |points: &[(f64, f64)]| {
        let by_value = |a: &usize, b: &usize| points[*a].1.total_cmp(&points[*b].1);
        let low = (0..points.len()).min_by(by_value).unwrap_or(0);
        let high = (0..points.len()).max_by(by_value).unwrap_or(0);
        [points[low.min(high)], points[low.max(high)]]
    };
    points.chunks(stretch).nested(ends).collect()
}

/// A number with as many digits as an axis needs.
fn short(x: f64) -> String {
    const DIGITS: i32 = 4;
    if x == 0.0 || !x.is_finite() {
        return "0".into();
    }
    if !(-3..6).contains(&(x.abs().log10().floor() as i32)) {
        return format!("{x:.1e}");
    }
    rounded(x, DIGITS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::samples;
    use crate::view::Recording;
    use crate::{Simulator, State};

    fn recording() -> Recording {
        let simulator = Simulator::new(samples::cartpole()).with_time_step(0.01);
        let start = State::new(&[0.0, 0.5], &[0.0; 2]);
        let rollout = simulator.rollout(&start, 300, |_, _, _| {});
        Recording::from_rollout(simulator.model(), &rollout)
    }

    #[test]
    fn pixels_of_a_png_have_the_colours_of_its_lines() {
        let plot = recording().plot(&["q.linear", "q.pivot"]).unwrap();
        let (width, height, pixels) = png::decode(&plot.to_png());
        assert_eq!((width, height), (800, 480));
        let count = |ink: RGBColor| {
            pixels
                .chunks(3)
                .filter(|p| *p == [ink.0, ink.1, ink.2])
                .count()
        };
        assert!(count(INK[0]) > 500 && count(INK[1]) > 500 && count(INK[2]) == 0);
        // Text is dark, and the grid is not.
        assert!(
            pixels
                .chunks(3)
                .filter(|p| p.iter().all(|&c| c < 60))
                .count()
                > 100
        );
    }

    #[test]
    fn line_of_an_svg_equals_the_rows_of_the_recording() {
        /// A part of the height of a line, with its rounding at both ends.
        const PIXEL: f64 = 0.01;
        let recording = recording();
        let svg = recording.plot(&["q.pivot"]).unwrap().to_svg();
        let line = svg
            .split("<polyline")
            .find(|part| part.contains("#3B78D8"))
            .unwrap();
        let points = line.split("points=\"").nth(1).unwrap();
        let points: Vec<f64> = points[..points.find('"').unwrap()]
            .split_whitespace()
            .map(|point| point.split(',').nth(1).unwrap().parse().unwrap())
            .collect();
        assert_eq!(points.len(), recording.len());
        // Pixels grow downwards and in proportion: (y − y₀) / (y₁ − y₀) is the same in both.
        let q = |k: usize| recording.robots()[0].q(k)[1];
        let far = (0..=300).max_by(|&a, &b| q(a).total_cmp(&q(b))).unwrap();
        let share = |k: usize| (points[k] - points[0]) / (points[far] - points[0]);
        for k in [50, 100, 200, 300] {
            let expected = (q(k) - q(0)) / (q(far) - q(0));
            let error = (share(k) - expected).abs();
            assert!(error < PIXEL, "{} against {expected}", share(k));
        }
    }

    #[test]
    fn column_that_is_not_there_is_an_error_that_lists_those_that_are() {
        let error = recording().phase_plot("q.pivot", "w.pivot").unwrap_err();
        let expected = "model \"cartpole\" has no column \"w.pivot\"; it has: q.pivot, v.pivot, u.pivot, q.linear, v.linear, u.linear";
        assert_eq!(error.to_string(), expected);
    }

    #[test]
    fn numbers_that_cannot_be_shown_interrupt_the_line() {
        let plot = Plot::new("").with_logarithmic_axes();
        let points = [
            (1.0, 2.0),
            (2.0, f64::NAN),
            (3.0, 1.0),
            (4.0, 0.0),
            (5.0, 9.0),
        ];
        let plot = plot.with_line("", points);
        assert_eq!(plot.pieces(&plot.lines[0]).len(), 3);
        assert!(plot.to_svg().starts_with("<svg"));
        assert!(Plot::new("nothing").to_svg().starts_with("<svg"));
    }

    #[test]
    fn thinned_line_keeps_the_peak() {
        let points: Vec<_> = (0..100_000).map(|k| (f64::from(k), 0.0)).collect();
        let mut points = points;
        points[54_321].1 = 7.0;
        let thinned = thinned(&points);
        assert!(thinned.len() <= MAX_POINTS);
        assert!(thinned.contains(&(54_321.0, 7.0)));
    }

    #[test]
    fn numbers_at_axes_equal_what_a_person_would_write() {
        for (x, expected) in [
            (0.1 + 0.2, "0.3"),
            (-12.5, "-12.5"),
            (1e-7, "1.0e-7"),
            (123_456.0, "123456"),
            (0.0, "0"),
        ] {
            assert_eq!(short(x), expected);
        }
    }

    #[test]
    #[should_panic(expected = "4294967295 × 4294967295 pixels need")]
    fn size_that_memory_has_no_room_for_is_refused() {
        let _ = Plot::new("wide").with_size(u32::MAX, u32::MAX);
    }
}
