//! Sensor readings as series of a recording.

use super::recording::Recording;
use crate::sim::{SensorScratch, Sensors, Simulator};

impl Recording {
    /// Adds the sensor readings at each time as [series](Self::series), with name and unit; NaN if the input is unknown, as at the end of a rollout.
    ///
    /// * `simulator` – simulator of the first robot
    ///
    /// # Panics
    /// If simulator or sensors do not belong to the first robot of the recording, or the recording lacks inputs or the contact state of the simulator.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Simulator, State, model::samples, sim::{Sensor, Sensors}, view::Recording};
    ///
    /// let simulator = Simulator::new(samples::pendulum());
    /// let rod = simulator.model().find_frame("rod")?;
    /// let sensors = Sensors::new(simulator.model(), [("gyro", Sensor::Gyro(rod))]);
    /// let rollout = simulator.rollout(&State::new(&[0.5], &[2.0]), 10, |_, _, _| {});
    /// let mut recording = Recording::from_rollout(simulator.model(), &rollout);
    /// recording.add_readings(&simulator, &sensors);
    /// assert_eq!(recording.series()[0].name, "gyro.x [rad/s]");
    /// assert_eq!(recording.series()[0].values[3], rollout.states[3].v[0]);
    /// # Ok::<(), dualbody::UnknownName>(())
    /// ```
    #[inline]
    pub fn add_readings(&mut self, simulator: &Simulator, sensors: &Sensors) -> &mut Self {
        let (n, mut scratch) = (self.len(), SensorScratch::new(simulator));
        let mut series = vec![Vec::with_capacity(n); sensors.len()];
        let mut y = vec![0.0; sensors.len()];
        for k in 0..n {
            let track = &self.robots()[0];
            let (state, u) = (track.state(k), track.u(k));
            let is_known = state.is_finite() && u.iter().all(|u| u.is_finite());
            match is_known {
                true => sensors.read_into(simulator, &state, u, &mut scratch, &mut y),
                false => y.fill(f64::NAN),
            }
            let values = series.iter_mut().zip(&y);
            values.for_each(|(series, &y)| series.push(y));
        }
        let names = sensors.names().into_iter().zip(sensors.units());
        for ((name, unit), values) in names.zip(series) {
            let name = match unit {
                "" => name.to_owned(),
                unit => format!("{name} [{unit}]"),
            };
            self.add_series(name, values);
        }
        self
    }
}
