//! Sensor noise and other imperfections: a layer on readings, with a seed for each state.

use std::collections::VecDeque;
use std::f64::consts::TAU;

use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};

use super::catalogue::Sensors;
use crate::error::UnknownName;
use crate::memory;
use crate::numbers::Domain;

/// Imperfections of a sensor. The default has none.
///
/// A sample is taken every [`period`](Self::period), and is  y + offset + bias + noise,  rounded to the resolution and clamped to ± the limit. The reading is
/// this sample, from its delay until that of the next one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorNoise {
    /// Constant error, in the unit of the reading.
    pub offset: f64,
    /// Standard deviation of the independent noise of each sample, in the unit of the reading.
    pub white: f64,
    /// Standard deviation of the bias at the start, in the unit of the reading.
    pub bias: f64,
    /// Standard deviation of the change of the bias over one second (random walk): unit of the reading per √s.
    pub bias_walk: f64,
    /// Quantisation step, in the unit of the reading; 0 for none.
    pub resolution: f64,
    /// Largest absolute value, in the unit of the reading; infinite by default.
    pub limit: f64,
    /// Time between two samples, s; 0 for one in each step. Each interval is a whole number of steps; the average is exact.
    pub period: f64,
    /// Delay between sample and reading, s; rounded to steps. Until the first delayed sample arrives, samples are read without delay.
    pub delay: f64,
}

impl Default for SensorNoise {
    fn default() -> Self {
        Self {
            offset: 0.0,
            white: 0.0,
            bias: 0.0,
            bias_walk: 0.0,
            resolution: 0.0,
            limit: f64::INFINITY,
            period: 0.0,
            delay: 0.0,
        }
    }
}

impl SensorNoise {
    fn check(&self) {
        Domain::Finite.check("offset of a sensor", self.offset);
        for (quantity, x) in [
            ("white noise of a sensor", self.white),
            ("bias of a sensor", self.bias),
            ("bias walk of a sensor", self.bias_walk),
            ("resolution of a sensor", self.resolution),
            ("period of a sensor", self.period),
            ("delay of a sensor", self.delay),
        ] {
            Domain::NotNegative.check(quantity, x);
        }
        Domain::NotNegativeOrInfinite.check("limit of a sensor", self.limit);
    }
}

/// Sensors with imperfections, for one state: their samples and random numbers. The same seed gives the same readings, independent of other states and sensors.
///
/// # Examples
/// ```
/// use dualbody::{model::samples, sim::{NoisySensors, Sensor, SensorNoise, Sensors}};
///
/// let model = samples::pendulum();
/// let sensors = Sensors::new(&model, [("encoder", Sensor::JointPosition(model.find_joint("pivot")?))]);
/// // 100 counts per rad, read 2 ms late
/// let encoder = SensorNoise { resolution: 0.01, delay: 2e-3, ..SensorNoise::default() };
/// let mut noisy = NoisySensors::new(&sensors, 1e-3, 7).with_noise("encoder", encoder)?;
/// let mut y = [0.0];
/// for (exact, expected) in [(0.123, 0.12), (0.3, 0.12), (0.4, 0.12), (0.5, 0.3)] {
///     noisy.sample_into(&[exact], &mut y);
///     assert!((y[0] - expected).abs() < 1e-15);
/// }
/// # Ok::<(), dualbody::UnknownName>(())
/// ```
#[derive(Clone, Debug)]
pub struct NoisySensors {
    sensors: Sensors,
    /// Time between two calls, s.
    time_step: f64,
    /// Of each number that is read.
    channels: Vec<NoisyChannel>,
}

/// A number that is read, with its imperfections.
#[derive(Clone, Debug)]
struct NoisyChannel {
    noise: SensorNoise,
    random: Xoshiro256PlusPlus,
    bias: f64,
    /// Steps so far.
    steps: u64,
    /// The last sample.
    held: f64,
    /// Samples that have not been read yet, one for each step of the delay.
    late: VecDeque<f64>,
}

/// Distance between the seeds of two numbers of one state: the golden ratio of 2⁶⁴, as in the generator `SplitMix64`, so that the seeds of neighbouring states
/// and numbers do not meet.
const SEED_STRIDE: u64 = 0x9E37_79B9_7F4A_7C15;

/// Most steps of a delay.
const MOST_DELAY: f64 = 1e9;

impl NoisySensors {
    /// Makes sensors without imperfections; [`with_noise`](Self::with_noise) adds them.
    ///
    /// * `time_step` – time between two samples, s: that of the simulator, or of the control
    /// * `seed` – of the random numbers of one state
    ///
    /// # Panics
    /// If the time step is not positive and finite.
    pub fn new(sensors: &Sensors, time_step: f64, seed: u64) -> Self {
        Domain::Positive.check("time step of sensors", time_step);
        let mut out = Self {
            sensors: sensors.clone(),
            time_step,
            channels: Vec::with_capacity(sensors.len()),
        };
        let channels = (0..sensors.len()).map(|_| NoisyChannel::new());
        out.channels.extend(channels);
        out.reset(seed);
        out
    }

    /// Sets the imperfections of all readings of a sensor, and restarts them.
    ///
    /// # Errors
    /// If there is no sensor of the name.
    ///
    /// # Panics
    /// If a value is negative or not finite, or if the delay needs more [memory](crate::memory) than the limit.
    pub fn with_noise(mut self, name: &str, noise: SensorNoise) -> Result<Self, UnknownName> {
        noise.check();
        let range = self.sensors.find(name)?;
        let steps = (noise.delay / self.time_step).round().min(MOST_DELAY) as usize;
        let bytes = steps.saturating_mul(size_of::<f64>() * range.len());
        memory::granted(memory::check("samples of a delayed sensor", bytes));
        for channel in &mut self.channels[range] {
            channel.noise = noise;
            channel.late.reserve_exact(steps + 1);
            channel.draw_bias();
        }
        Ok(self)
    }

    /// Restarts with the random numbers of a seed.
    pub fn reset(&mut self, seed: u64) {
        for (k, channel) in (1..).zip(&mut self.channels) {
            let own = seed ^ SEED_STRIDE.wrapping_mul(k);
            channel.random = Xoshiro256PlusPlus::seed_from_u64(own);
            channel.steps = 0;
            channel.late.clear();
            channel.draw_bias();
        }
    }

    /// Converts the exact readings of a step to readings with imperfections. Does not allocate.
    ///
    /// * `exact`, `out` – length [`Sensors::len`]
    ///
    /// # Panics
    /// If a slice has the wrong length.
    pub fn sample_into(&mut self, exact: &[f64], out: &mut [f64]) {
        let n = self.channels.len();
        assert_eq!(
            (exact.len(), out.len()),
            (n, n),
            "lengths of the readings, given and of the sensors"
        );
        let numbers = exact.iter().zip(out);
        for (channel, (&exact, out)) in self.channels.iter_mut().zip(numbers) {
            *out = channel.sample(exact, self.time_step);
        }
    }
}

impl NoisyChannel {
    fn new() -> Self {
        Self {
            noise: SensorNoise::default(),
            random: Xoshiro256PlusPlus::seed_from_u64(0),
            bias: 0.0,
            steps: 0,
            held: 0.0,
            late: VecDeque::new(),
        }
    }

    fn draw_bias(&mut self) {
        self.bias = self.normal(self.noise.bias);
    }

    /// A normally distributed number by the method of Box and Muller; none is drawn for a deviation of zero.
    fn normal(&mut self, deviation: f64) -> f64 {
        if deviation == 0.0 {
            return 0.0;
        }
        let (u, w): (f64, f64) = (self.random.random(), self.random.random());
        deviation * (-2.0 * (1.0 - u).ln()).sqrt() * (TAU * w).cos()
    }

    /// The reading of a step.
    fn sample(&mut self, exact: f64, time_step: f64) -> f64 {
        if self.is_due(time_step) {
            self.held = self.measure(exact, time_step);
        }
        self.steps += 1;
        if self.noise.delay == 0.0 {
            return self.held;
        }
        let delay = (self.noise.delay / time_step).round().min(MOST_DELAY) as usize;
        self.late.push_back(self.held);
        match self.late.len() > delay {
            true => self.late.pop_front().unwrap_or(self.held),
            false => self.late[0],
        }
    }

    /// Whether a sample is taken in this step: its number of periods so far has grown.
    fn is_due(&self, time_step: f64) -> bool {
        // So that a period of some steps is not missed by rounding.
        const NEARLY: f64 = 1e-9;
        let periods = |steps: u64| (steps as f64 * time_step / self.noise.period + NEARLY).floor();
        self.noise.period <= time_step
            || self.steps == 0
            || periods(self.steps) > periods(self.steps - 1)
    }

    fn measure(&mut self, exact: f64, time_step: f64) -> f64 {
        let noise = self.noise;
        if self.steps > 0 {
            let time = noise.period.max(time_step);
            self.bias += self.normal(noise.bias_walk * time.sqrt());
        }
        let measured = exact + (noise.offset + self.bias) + self.normal(noise.white);
        let rounded = match noise.resolution > 0.0 {
            true => (measured / noise.resolution).round() * noise.resolution,
            false => measured,
        };
        rounded.clamp(-noise.limit, noise.limit)
    }
}
