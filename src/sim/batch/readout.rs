//! Sensor readings, row by row in the caller's memory.

use crate::scalar::{Over, Scalar};
use crate::sim::sensors::{SensorScratch, Sensors};
use crate::sim::simulator::Simulator;
use crate::sim::state::State;
use crate::sim::step::StepScratch;

/// Memory of a thread for sensors.
#[derive(Clone, Debug)]
pub(super) struct SensorMemory<T: Scalar> {
    scratch: SensorScratch<T>,
    readings: Vec<T>,
}

/// Sensors, and the rows of a group's states that they write.
pub(super) struct Readout<'a> {
    pub(super) sensors: &'a Sensors,
    pub(super) rows: &'a mut [f64],
}

impl Readout<'_> {
    /// Reads a step that has been taken, and writes the row of each lane; lanes past the last state have none.
    ///
    /// * `first` – row of the first lane
    pub(super) fn read<P: Scalar, T: Over<P>>(
        &mut self,
        (simulator, state, u): (&Simulator<P>, &State<T>, &[T]),
        step: &StepScratch<T>,
        memory: &mut Option<Box<SensorMemory<T>>>,
        first: usize,
    ) {
        let sensors = self.sensors;
        let new = || {
            let (scratch, readings) = (SensorScratch::new(simulator), Vec::new());
            Box::new(SensorMemory { scratch, readings })
        };
        let SensorMemory { scratch, readings } = &mut **memory.get_or_insert_with(new);
        readings.resize(sensors.len(), T::zero());
        sensors.read_step_into(simulator, state, u, step, scratch, readings);
        let rows = self.rows.chunks_exact_mut(sensors.len()).skip(first);
        for (lane, row) in rows.take(T::LANES).enumerate() {
            let values = row.iter_mut().zip(&*readings);
            values.for_each(|(out, y)| *out = y.value(lane));
        }
    }
}
