//! Steps of a batch with sensor readings.
//!
//! Compiled only in programs that call it.

use super::group::Group;
use super::readout::Readout;
use super::simulator::{BatchSimulator, BatchWorker};
use super::states::BatchStates;
use super::worker::Worker;
use super::{BATCH_WIDTH, BatchMoment, BatchScalar};
use crate::parallel::for_each_part;
use crate::scalar::{Over, Scalar};
use crate::sim::sensors::Sensors;
use crate::sim::simulator::Simulator;
use crate::sim::state::State;

/// A group, with the rows of its states.
type Rows<'a> = (&'a mut Group<BatchScalar, BATCH_WIDTH>, &'a mut [f64]);

impl BatchSimulator {
    /// [`step`](Self::step) with sensor readings, bit-identical to [`Sensors::read_step_into`] of each state. Allocates a little memory.
    ///
    /// Sensors of a stopped state are evaluated as if the state took the step; the readings may not be finite.
    ///
    /// * `inputs` – the input of one state after the other, length `len` × `nu` (N·m or N)
    /// * `out` – output: the readings of one state after the other, length `len` × [`Sensors::len`]
    ///
    /// # Panics
    /// As [`step`](Self::step), or if the output has the wrong length or the sensors are those of another robot.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Simulator, State, model::samples, sim::{BatchSimulator, Sensor, Sensors}};
    ///
    /// let simulator = Simulator::new(samples::pendulum());
    /// let rod = simulator.model().find_frame("rod")?;
    /// let sensors = Sensors::new(simulator.model(), [("imu", Sensor::Accelerometer(rod))]);
    /// let starts: Vec<State> = (0..10).map(|k| State::new(&[0.1 * k as f64], &[0.0])).collect();
    /// let mut batch = BatchSimulator::new(simulator.clone(), 10);
    /// let (mut states, mut y) = (batch.states(&starts), [0.0; 30]);
    /// batch.step_and_read(&mut states, &[0.5; 10], &sensors, &mut y);
    /// assert_eq!(y[3 * 7..3 * 8], *sensors.read(&simulator, &starts[7], &[0.5]).as_slice());
    /// # Ok::<(), dualbody::UnknownName>(())
    /// ```
    #[inline]
    pub fn step_and_read(
        &mut self,
        states: &mut BatchStates,
        inputs: &[f64],
        sensors: &Sensors,
        out: &mut [f64],
    ) {
        let (step, nu, len) = (states.groups.steps, self.nu(), self.len());
        self.check_step(states, inputs);
        let width = sensors.len();
        assert_eq!(out.len(), len * width, "len × Sensors::len readings");
        if width == 0 {
            return self.step(states, inputs);
        }
        states.groups.steps += 1;
        let rows = out.chunks_mut(BATCH_WIDTH * width);
        let mut items: Vec<Rows<'_>> = states.groups.all.iter_mut().zip(rows).collect();
        let (simulator, variants, workers) = self.parts();
        for_each_part(workers, &mut items, |worker, k, (group, rows)| {
            let moment = BatchMoment::new(k, len);
            let control = |_: &State<BatchScalar>, u: &mut [BatchScalar]| {
                for (j, u) in u.iter_mut().enumerate() {
                    *u = moment.gather(|i| inputs[i * nu + j]);
                }
            };
            let mut readout = Readout { sensors, rows };
            match (worker, variants) {
                (BatchWorker::SideBySide(worker), variants) => {
                    worker.set_input(group, control);
                    match variants {
                        None => worker.step_and_read(simulator, step, group, &mut readout),
                        Some(all) => {
                            let own = &all.groups()[k];
                            worker.step_and_read(own, step, group, &mut readout);
                        }
                    }
                }
                (BatchWorker::OneByOne(worker), variants) => {
                    let of_lane = |lane: usize| match variants {
                        Some(all) => all.of_lane(k, lane),
                        None => simulator,
                    };
                    worker.set_input(group, control);
                    worker.step_and_read(of_lane, step, group, &mut readout);
                }
            }
        });
    }
}

impl<T: Scalar> Worker<T> {
    /// [`step`](Self::step), and the readings of sensors in it.
    fn step_and_read<P: Scalar, const N: usize>(
        &mut self,
        simulator: &Simulator<P>,
        step: usize,
        group: &mut Group<T, N>,
        readout: &mut Readout<'_>,
    ) where
        T: Over<P>,
    {
        self.step_with(simulator, step, group, |state, u, scratch, sensors| {
            readout.read((simulator, state, u), scratch, sensors, 0);
        });
    }
}
