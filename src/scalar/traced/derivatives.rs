//! Derivatives of a graph, as graphs: Jacobians by forward or reverse sweeps, gradients by one reverse sweep.

use super::graph::Graph;
use super::number::Traced;
use super::port::Port;
use super::sparsity::Sparsity;
use super::trace::{Tracer, trace};
use crate::error::UnknownName;
use crate::nested::IntoNested;
use crate::scalar::{Dual, One, Zero};

/// Numbers of the ports of some names: where they begin, and the index of each among those of all ports.
struct Chosen<'a> {
    ports: Vec<&'a Port>,
    indices: Vec<usize>,
}

impl<'a> Chosen<'a> {
    fn new(
        names: &[&str],
        find: impl Fn(&str) -> Result<(&'a Port, usize), UnknownName>,
    ) -> Result<Self, UnknownName> {
        let (mut ports, mut indices) = (Vec::new(), Vec::new());
        for name in names {
            let (port, first) = find(name)?;
            ports.push(port);
            indices.extend(first..first + port.len());
        }
        Ok(Self { ports, indices })
    }
}

impl Graph {
    /// Returns a graph of the Jacobians of some outputs in some inputs: `dy_dx` for the output `y` and the input `x`,
    /// with a row for each entry of `y`. It has the inputs of this graph.
    ///
    /// Inputs are seeded together if no output depends on more than one of them, and outputs if they share no input. The mode with fewer sweeps is
    /// used, forward or reverse. The chain rule on operations ignores the structure of the physics: the traced derivatives along the tree in
    /// [`dynamics`](crate::dynamics) take fewer operations.
    ///
    /// # Errors
    /// If there is no input or output with this name.
    ///
    /// # Examples
    /// ```
    /// use dualbody::scalar::traced::{Port, trace};
    ///
    /// let area = trace(|t| {
    ///     let x = t.input(Port::vector("x", 2));
    ///     t.output(Port::number("y"), [&(x[0] * x[1])]);
    /// });
    /// let jacobian = area.jacobian(&["y"], &["x"])?;
    /// assert_eq!(jacobian.evaluate(&[3.0, 5.0]).unwrap(), [5.0, 3.0]);
    /// assert_eq!(jacobian.outputs()[0].name, "dy_dx");
    /// # Ok::<(), dualbody::UnknownName>(())
    /// ```
    pub fn jacobian(&self, outputs: &[&str], inputs: &[&str]) -> Result<Self, UnknownName> {
        let y = Chosen::new(outputs, |name| self.output(name))?;
        let x = Chosen::new(inputs, |name| self.input(name))?;
        let sparsity = Sparsity::of(self, &y.indices, &x.indices);
        let forward = sparsity.input_colours(x.indices.len());
        let reverse = sparsity.output_colours(x.indices.len());
        Ok(self.derived(|t, all| {
            let entries = if forward.len() <= reverse.len() {
                self.by_forward_sweeps(&sparsity, &forward, all, [&y.indices, &x.indices])
            } else {
                self.by_reverse_sweeps(&sparsity, &reverse, all, [&y.indices, &x.indices])
            };
            declare(t, &entries, &y, &x);
        }))
    }

    /// Returns a graph of the gradient of a scalar output in some inputs: `dy_dx` for the output `y` and the input `x`, of the shape of `x`. It costs
    /// a small multiple of the output, independent of the number of inputs.
    ///
    /// # Errors
    /// If there is no input or output with this name.
    ///
    /// # Panics
    /// If the output is not a scalar.
    pub fn gradient(&self, output: &str, inputs: &[&str]) -> Result<Self, UnknownName> {
        let (y, first) = self.output(output)?;
        assert_eq!(y.len(), 1, "a gradient is that of an output of one number");
        let x = Chosen::new(inputs, |name| self.input(name))?;
        Ok(self.derived(|t, all| {
            let mut weights = vec![Traced::zero(); self.n_outputs()];
            weights[first] = Traced::one();
            let bar = self.reverse_sweep(&self.replay_nodes(all), &weights);
            self.declare_weights(t, &x, &bar, |x| format!("d{output}_d{x}"));
        }))
    }

    /// Returns a graph of products of weights with the Jacobian, x̄ = (∂y/∂x)ᵀ ȳ: it has an additional input `y_weight` for each output `y`, of its
    /// shape, and an output `x_weight` for each of some inputs.
    ///
    /// # Errors
    /// If there is no input with this name.
    ///
    /// # Panics
    /// If an input has the name of a weight.
    pub fn adjoint(&self, inputs: &[&str]) -> Result<Self, UnknownName> {
        let x = Chosen::new(inputs, |name| self.input(name))?;
        Ok(self.derived(|t, all| {
            let weight = |y: &Port| Port::matrix(format!("{}_weight", &y.name), y.rows, y.columns);
            let weights = self.outputs().iter().nested(|y| t.input(weight(y)));
            let weights: Vec<_> = weights.collect();
            let bar = self.reverse_sweep(&self.replay_nodes(all), &weights);
            self.declare_weights(t, &x, &bar, |x| format!("{x}_weight"));
        }))
    }

    /// A graph with the same inputs, of the same robot.
    fn derived(&self, work: impl FnOnce(&mut Tracer, &[Traced])) -> Self {
        let out = trace(|t| {
            let inputs = self.inputs().iter().nested(|port| t.input(port.clone()));
            let inputs: Vec<_> = inputs.collect();
            work(t, &inputs);
        });
        match self.origin() {
            Some(origin) => out.with_origin(origin.clone()),
            None => out,
        }
    }

    fn declare_weights(
        &self,
        t: &mut Tracer,
        x: &Chosen<'_>,
        bar: &[Traced],
        name: impl Fn(&str) -> String,
    ) {
        let mut indices = x.indices.iter();
        for port in &x.ports {
            let numbers: Vec<_> = indices.by_ref().take(port.len()).map(|&i| bar[i]).collect();
            let port = Port::matrix(name(&port.name), port.rows, port.columns);
            t.output(port, &numbers);
        }
    }

    /// Entries of the Jacobian, column by column: a dual number with one direction for each colour of inputs.
    fn by_forward_sweeps(
        &self,
        sparsity: &Sparsity,
        colours: &[Vec<usize>],
        inputs: &[Traced],
        [y, x]: [&[usize]; 2],
    ) -> Vec<Traced> {
        let mut out = vec![Traced::zero(); y.len() * x.len()];
        for colour in colours {
            let constants = inputs.iter().map(|&x| Dual::<Traced, 1>::constant_of(x));
            let mut moved: Vec<_> = constants.collect();
            colour
                .iter()
                .for_each(|&k| moved[x[k]].eps[0] = Traced::one());
            let found = self.replay(&moved);
            for &k in colour {
                let rows = (0..y.len()).filter(|&row| sparsity.depends(row, k));
                rows.for_each(|row| out[k * y.len() + row] = found[y[row]].eps[0]);
            }
        }
        out
    }

    /// Finds it by weights of one for each colour of outputs.
    fn by_reverse_sweeps(
        &self,
        sparsity: &Sparsity,
        colours: &[Vec<usize>],
        inputs: &[Traced],
        [y, x]: [&[usize]; 2],
    ) -> Vec<Traced> {
        let mut out = vec![Traced::zero(); y.len() * x.len()];
        let values = self.replay_nodes(inputs);
        for colour in colours {
            let mut weights = vec![Traced::zero(); self.n_outputs()];
            colour
                .iter()
                .for_each(|&row| weights[y[row]] = Traced::one());
            let bar = self.reverse_sweep(&values, &weights);
            for &row in colour {
                let columns = (0..x.len()).filter(|&k| sparsity.depends(row, k));
                columns.for_each(|k| out[k * y.len() + row] = bar[x[k]]);
            }
        }
        out
    }
}

/// Declares the blocks of a Jacobian, column by column, as outputs.
fn declare(t: &mut Tracer, entries: &[Traced], y: &Chosen<'_>, x: &Chosen<'_>) {
    let height = y.indices.len();
    let mut row = 0;
    for output in &y.ports {
        let mut column = 0;
        for input in &x.ports {
            let columns = column..column + input.len();
            let block = columns.nested(|k| &entries[k * height + row..][..output.len()]);
            let name = format!("d{}_d{}", &output.name, &input.name);
            t.output(Port::matrix(name, output.len(), input.len()), block);
            column += input.len();
        }
        row += output.len();
    }
}
