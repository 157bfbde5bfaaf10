//! Butterworth low-pass filter, applied forwards and backwards.

use std::f64::consts::PI;

use super::error::IdentifyError;

/// Digital Butterworth low-pass by the bilinear transformation, in sections of second order. Forward and backward application gives zero delay and
/// squares the gain:
///
/// > |H(f)|² = 1 / (1 + (tan(π f / rate) / tan(π cutoff / rate))^(2 n)).
///
/// # Examples
/// ```
/// use dualbody::identify::Butterworth;
///
/// let filter = Butterworth::new(4, 10.0, 500.0)?;
/// assert!((filter.gain(10.0) - 0.5).abs() < 1e-12);
/// # Ok::<(), dualbody::identify::IdentifyError>(())
/// ```
///
/// # References
/// [Oppenheim, Schafer 2010, sections 7.1 and 7.2].
#[derive(Clone, Debug, PartialEq)]
pub struct Butterworth {
    order: usize,
    cutoff: f64,
    rate: f64,
    sections: Vec<Section>,
}

/// y = (b₀ + b₁ z⁻¹ + b₂ z⁻²) / (1 + a₁ z⁻¹ + a₂ z⁻²) x, with gain 1 at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Section {
    b: [f64; 3],
    a: [f64; 2],
}

impl Butterworth {
    /// Makes a filter of a given order.
    ///
    /// * `cutoff` – frequency at which one pass has a gain of 71 % and both passes together one half, Hz
    /// * `rate` – samples per second
    ///
    /// # Errors
    /// If the order is not from 1 to 8, or the cutoff not between 0 and half the rate.
    pub fn new(order: usize, cutoff: f64, rate: f64) -> Result<Self, IdentifyError> {
        const MOST: usize = 8;
        let is_between = cutoff > 0.0 && cutoff < 0.5 * rate && rate.is_finite();
        if !(1..=MOST).contains(&order) || !is_between {
            return Err(IdentifyError::Filter {
                reason: format!(
                    "Butterworth of order {order} with a cutoff of {cutoff} Hz at {rate} samples a second; the order is from 1 to {MOST}, the cutoff between 0 and half the rate"
                ),
            });
        }
        let warped = (PI * cutoff / rate).tan();
        let pairs = (0..order / 2).map(|k| {
            // Poles s = −sin θ ± i cos θ, for which s² + 2 sin θ s + 1.
            let theta = PI * (2 * k + 1) as f64 / (2 * order) as f64;
            Section::of_pair(warped, 2.0 * theta.sin())
        });
        let mut sections: Vec<_> = pairs.collect();
        if order % 2 == 1 {
            sections.push(Section::of_pole(warped));
        }
        Ok(Self {
            order,
            cutoff,
            rate,
            sections,
        })
    }

    /// Computes the gain of both passes together at a frequency, Hz.
    pub fn gain(&self, frequency: f64) -> f64 {
        let tangent = |f: f64| (PI * f / self.rate).tan();
        let ratio = tangent(frequency) / tangent(self.cutoff);
        (1.0 + ratio.powi(2 * self.order as i32)).recip()
    }

    /// Number of samples by which a row is continued at either end, by its own point reflection: as long as a disturbance is heard.
    pub(super) fn continuation(&self) -> usize {
        /// Decay times after which 0.2 % are left.
        const DECAYS: f64 = 6.0;
        let slowest = (PI / (2 * self.order) as f64).sin();
        let decay = self.rate / (2.0 * PI * self.cutoff * slowest);
        (DECAYS * decay).ceil() as usize
    }

    /// Filters a sequence forwards and backwards, in place. The sequence is extended at both ends, for a short sequence by at most its own length.
    pub fn filter(&self, x: &mut [f64]) {
        let n = x.len();
        if n == 0 {
            return;
        }
        let margin = self.continuation().min(n - 1);
        let (first, last) = (x[0], x[n - 1]);
        let before = (1..=margin).rev().map(|k| 2.0 * first - x[k]);
        let after = (1..=margin).map(|k| 2.0 * last - x[n - 1 - k]);
        let mut row: Vec<f64> = before.chain(x.iter().copied()).chain(after).collect();
        for section in &self.sections {
            section.run(row.iter_mut());
        }
        for section in &self.sections {
            section.run(row.iter_mut().rev());
        }
        x.copy_from_slice(&row[margin..margin + n]);
    }
}

impl Section {
    /// 1 / (s² + d s + 1) with s = (1 − z⁻¹) / (w (1 + z⁻¹)).
    fn of_pair(w: f64, d: f64) -> Self {
        let scale = (1.0 + d * w + w * w).recip();
        let b = w * w * scale;
        Self {
            b: [b, 2.0 * b, b],
            a: [2.0 * (w * w - 1.0) * scale, (1.0 - d * w + w * w) * scale],
        }
    }

    /// 1 / (s + 1).
    fn of_pole(w: f64) -> Self {
        let b = w / (1.0 + w);
        Self {
            b: [b, b, 0.0],
            a: [(w - 1.0) / (w + 1.0), 0.0],
        }
    }

    /// Runs over a row, from rest at its first number.
    fn run<'a>(&self, row: impl Iterator<Item = &'a mut f64>) {
        let Self { b, a } = self;
        let mut memory: Option<[f64; 2]> = None;
        for x in row {
            let [s1, s2] = memory.unwrap_or([(1.0 - b[0]) * *x, (b[2] - a[1]) * *x]);
            let y = b[0] * *x + s1;
            memory = Some([b[1] * *x - a[0] * y + s2, b[2] * *x - a[1] * y]);
            *x = y;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn filtered_harmonic_equals_the_true_one_times_the_gain() {
        let rate = 500.0;
        for order in 1..=8 {
            let filter = Butterworth::new(order, 20.0, rate).unwrap();
            for frequency in [2.0, 12.0, 20.0, 31.0, 80.0] {
                let turn = 2.0 * PI * frequency / rate;
                let mut x: Vec<f64> = (0..4000).map(|k| (turn * f64::from(k)).sin()).collect();
                filter.filter(&mut x);
                let gain = filter.gain(frequency);
                // Far from the ends, where nothing is known of what lies beyond.
                for k in 1500..2500 {
                    let expected = gain * (turn * k as f64).sin();
                    assert!(
                        (x[k] - expected).abs() < 1e-9,
                        "order {order}, {frequency} Hz"
                    );
                }
            }
        }
    }

    #[test]
    fn constants_and_slopes_pass_unchanged_up_to_the_ends() {
        for order in [1, 2, 3, 5] {
            let filter = Butterworth::new(order, 5.0, 200.0).unwrap();
            let line = |k: usize| 3.0 - 0.02 * k as f64;
            let mut x: Vec<f64> = (0..900).map(line).collect();
            filter.filter(&mut x);
            for (k, x) in x.iter().enumerate() {
                // Error of the continuation: 0.2 % of the slope over a decay.
                assert!((x - line(k)).abs() < 2e-3, "order {order}, {k}: {x}");
            }
            let mut constant = vec![7.0; 50];
            filter.filter(&mut constant);
            assert!(constant.iter().all(|x| (x - 7.0).abs() < 1e-12));
        }
    }

    #[test]
    fn numbers_out_of_range_are_refused_and_empty_rows_taken() {
        for (order, cutoff, rate) in [
            (0, 1.0, 10.0),
            (9, 1.0, 10.0),
            (2, 5.0, 10.0),
            (2, 0.0, 10.0),
            (2, f64::NAN, 10.0),
        ] {
            assert!(Butterworth::new(order, cutoff, rate).is_err());
        }
        Butterworth::new(2, 1.0, 10.0).unwrap().filter(&mut []);
    }
}
