//! Random states of a robot, with the results of the library on the CPU.

use std::error::Error;
use std::fs;
use std::path::Path;

/// Inputs of a function for some states, and the expected results, as stored in a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Cases {
    /// Number of states.
    pub(crate) count: usize,
    /// How many of them, from the first, are ordinary; the others leave a condition of the function.
    pub(crate) ordinary: usize,
    /// Steps that a motion has; 0 of a function that is none.
    pub(crate) steps: usize,
    /// Inputs of one state after the other; of a step its parameters.
    pub(crate) inputs: Vec<f64>,
    /// States of a motion at its start.
    pub(crate) start: Vec<f64>,
    /// Inputs of the motors, those of one state after the other, each step by step.
    pub(crate) each_step: Vec<f64>,
    /// Inputs that are the same for all states.
    pub(crate) shared: Vec<f64>,
    /// Outputs of one state after the other, or its last state.
    pub(crate) expected: Vec<f64>,
    /// Status of each state.
    pub(crate) status: Vec<f64>,
    /// Steps that each state takes.
    pub(crate) taken: Vec<f64>,
}

impl Cases {
    fn arrays(&self) -> [&[f64]; 7] {
        [
            &self.inputs,
            &self.start,
            &self.each_step,
            &self.shared,
            &self.expected,
            &self.status,
            &self.taken,
        ]
    }

    /// Writes them: three sizes, then each array behind its length, as 64-bit numbers.
    pub(crate) fn write(&self, file: &Path) -> Result<(), Box<dyn Error>> {
        let sizes = [self.count, self.ordinary, self.steps].map(|n| n as u64);
        let mut bytes: Vec<u8> = sizes.iter().flat_map(|n| n.to_le_bytes()).collect();
        for array in self.arrays() {
            bytes.extend((array.len() as u64).to_le_bytes());
            bytes.extend(array.iter().flat_map(|x| x.to_le_bytes()));
        }
        fs::write(file, bytes).map_err(|error| format!("{}: {error}", file.display()))?;
        Ok(())
    }

    /// Reads them.
    pub(crate) fn read(file: &Path) -> Result<Self, Box<dyn Error>> {
        let bytes = fs::read(file).map_err(|error| format!("{}: {error}", file.display()))?;
        let (words, _) = bytes.as_chunks::<8>();
        let mut words = words.iter().copied();
        let found = Self::parse(&mut words);
        Ok(found.ok_or_else(|| format!("{}: the file ends too early", file.display()))?)
    }

    fn parse(words: &mut impl Iterator<Item = [u8; 8]>) -> Option<Self> {
        let size = |words: &mut dyn Iterator<Item = [u8; 8]>| {
            usize::try_from(u64::from_le_bytes(words.next()?)).ok()
        };
        let (count, ordinary, steps) = (size(words)?, size(words)?, size(words)?);
        let mut array = || {
            let len = size(words)?;
            let numbers: Vec<f64> = words.take(len).map(f64::from_le_bytes).collect();
            (numbers.len() == len).then_some(numbers)
        };
        Some(Self {
            count,
            ordinary,
            steps,
            inputs: array()?,
            start: array()?,
            each_step: array()?,
            shared: array()?,
            expected: array()?,
            status: array()?,
            taken: array()?,
        })
    }

    /// Numbers of an array that each state has.
    pub(crate) fn rows(&self, array: &[f64]) -> usize {
        array.len() / self.count.max(1)
    }

    /// The same with small inputs of the motors, under which no motion diverges soon.
    pub(crate) fn calm(mut self) -> Self {
        /// Factor of the inputs, which are of size one.
        const FACTOR: f64 = 1.0 / 64.0;
        self.each_step.iter_mut().for_each(|u| *u *= FACTOR);
        self
    }

    /// The same without states that leave a condition.
    pub(crate) fn ordinary(&self) -> Self {
        let of = |array: &[f64]| array[..self.rows(array) * self.ordinary].to_vec();
        Self {
            count: self.ordinary,
            inputs: of(&self.inputs),
            start: of(&self.start),
            each_step: of(&self.each_step),
            shared: self.shared.clone(),
            expected: of(&self.expected),
            status: of(&self.status),
            taken: of(&self.taken),
            ..*self
        }
    }
}
