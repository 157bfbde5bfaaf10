//! Variables of the robot that shooting adjusts, and where they go.

use nalgebra::DMatrix;

use super::Adjustable;
use crate::identify::consistent::possible;
use crate::identify::error::IdentifyError;
use crate::identify::estimate::Interval;
use crate::model::{ParameterGroup, ParameterLayout};
use crate::scalar::Dual;
use crate::sim::{Simulator, SimulatorParameterGroup as Group};
use crate::spatial::{INERTIAL_PARAMETERS, Inertia};

/// Variables that belong together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Block {
    /// Ten log-Cholesky parameters.
    Inertia,
    Number,
}

/// Places of a number in the vector of [parameters](Simulator::parameters): several where it is shared.
pub(super) type Target = Vec<usize>;

/// Numbers of the robot, and their slopes in the variables.
pub(super) struct Numbers {
    pub(super) values: Vec<f64>,
    pub(super) slopes: DMatrix<f64>,
}

/// Variables of the robot.
#[derive(Default)]
pub(super) struct Variables {
    blocks: Vec<Block>,
    pub(super) targets: Vec<Target>,
    names: Vec<String>,
    /// Those of the nominal robot.
    pub(super) nominal: Vec<f64>,
    /// Whether they stay not negative.
    pub(super) is_bounded: Vec<bool>,
}

impl Variables {
    /// # Errors
    /// If a name is unknown, or a number is none that a descent may take anywhere.
    pub(super) fn new(
        simulator: &Simulator,
        adjustable: &[Adjustable],
    ) -> Result<Self, IdentifyError> {
        let (mut out, layout) = (Self::default(), simulator.parameter_layout());
        for own in adjustable {
            match own {
                Adjustable::Inertia(link) => out.add_inertia(simulator, &layout, link)?,
                Adjustable::Parameter(name) => out.add_parameter(simulator, &layout, name)?,
                Adjustable::Friction(points) => out.add_friction(simulator, &layout, points)?,
            }
        }
        Ok(out)
    }

    fn add_inertia(
        &mut self,
        simulator: &Simulator,
        layout: &ParameterLayout<Group>,
        link: &str,
    ) -> Result<(), IdentifyError> {
        let model = simulator.model();
        let frame = model.find_frame(link)?;
        let body = model.frames()[frame.0].body;
        let body = body.ok_or_else(|| IdentifyError::option(link, "it does not move"))?;
        let group = Group::Model(ParameterGroup::Inertia(body));
        let range = layout.range(group).unwrap_or_default();
        self.names.extend_from_slice(&layout.names()[range.clone()]);
        self.targets.extend(range.map(|index| vec![index]));
        self.nominal.extend(possible(model, body).to_log_cholesky());
        self.is_bounded.extend([false; INERTIAL_PARAMETERS]);
        self.blocks.push(Block::Inertia);
        Ok(())
    }

    fn add_parameter(
        &mut self,
        simulator: &Simulator,
        layout: &ParameterLayout<Group>,
        name: &str,
    ) -> Result<(), IdentifyError> {
        let index = layout.find(name)?;
        let is_bounded = stays_positive(name);
        if !(is_bounded || is_free(layout, index, name)) {
            let reason = "a descent could take it where it makes no sense";
            return Err(IdentifyError::option(name, reason));
        }
        let value = simulator.parameters()[index];
        self.push(vec![index], name.into(), value, is_bounded);
        Ok(())
    }

    fn add_friction(
        &mut self,
        simulator: &Simulator,
        layout: &ParameterLayout<Group>,
        points: &[usize],
    ) -> Result<(), IdentifyError> {
        let error = |reason| IdentifyError::option("friction", reason);
        let of = |&k: &usize| {
            let mut law = layout.range(Group::ContactLaw(k))?;
            law.find(|&index| layout.names()[index].ends_with(": friction"))
        };
        let target: Option<Target> = points.iter().map(of).collect();
        let target = target.filter(|target| !target.is_empty());
        let target = target.ok_or_else(|| error("there are no such points of contact"))?;
        let parameters = simulator.parameters();
        if target.iter().any(|&index| !parameters[index].is_finite()) {
            return Err(error("that of a point is infinite"));
        }
        let name = format!("friction of points {points:?}");
        let first = parameters[target[0]];
        self.push(target, name, first, true);
        Ok(())
    }

    fn push(&mut self, target: Target, name: String, value: f64, is_bounded: bool) {
        self.targets.push(target);
        self.names.push(name);
        self.nominal.push(value);
        self.is_bounded.push(is_bounded);
        self.blocks.push(Block::Number);
    }

    pub(super) fn len(&self) -> usize {
        self.nominal.len()
    }

    /// Numbers of the robot at variables.
    pub(super) fn numbers(&self, x: &[f64]) -> Numbers {
        let p = self.len();
        let (mut values, mut slopes) = (Vec::with_capacity(p), DMatrix::zeros(p, p));
        for block in &self.blocks {
            let first = values.len();
            match block {
                Block::Number => {
                    values.push(x[first]);
                    slopes[(first, first)] = 1.0;
                }
                Block::Inertia => {
                    for (i, number) in inertia(&x[first..]).into_iter().enumerate() {
                        values.push(number.re);
                        for (k, slope) in number.eps.into_iter().enumerate() {
                            slopes[(first + i, first + k)] = slope;
                        }
                    }
                }
            }
        }
        Numbers { values, slopes }
    }

    /// Variables whose distance from the nominal ones counts: those of inertias.
    pub(super) fn penalized(&self) -> impl Iterator<Item = usize> + '_ {
        let of_block = |block: &Block| match block {
            Block::Number => [false].iter(),
            Block::Inertia => [true; INERTIAL_PARAMETERS].iter(),
        };
        let all = self.blocks.iter().flat_map(of_block).enumerate();
        all.filter(|(_, is_penalized)| **is_penalized)
            .map(|(k, _)| k)
    }

    pub(super) fn intervals(
        &self,
        values: &[f64],
        covariance: &DMatrix<f64>,
        factor: f64,
    ) -> Vec<Interval> {
        let interval = |k: usize| {
            let (value, deviation) = (values[k], covariance[(k, k)].max(0.0).sqrt());
            Interval::new(self.names[k].clone(), value, deviation, factor)
        };
        (0..values.len()).map(interval).collect()
    }
}

/// Whether a parameter makes sense wherever it is not negative.
fn stays_positive(name: &str) -> bool {
    let not_negative = [
        "damping",
        "armature",
        "stiffness",
        "friction",
        "Coulomb friction",
    ];
    let quantity = quantity(name);
    not_negative.iter().any(|own| quantity.starts_with(own)) && !quantity.ends_with("exponent")
}

/// Whether a parameter makes sense anywhere.
fn is_free(layout: &ParameterLayout<Group>, index: usize, name: &str) -> bool {
    let group = layout.groups().iter().find(|(_, own)| own.contains(&index));
    match group.map(|(group, _)| *group) {
        Some(Group::Model(_) | Group::Terrain | Group::ExternalForce(_)) => true,
        Some(Group::ContactPoint(_)) => quantity(name) != "radius",
        Some(Group::Constraint(_)) => quantity(name) != "time constant",
        _ => false,
    }
}

fn quantity(name: &str) -> &str {
    name.rsplit(": ").next().unwrap_or_default()
}

/// Inertial parameters at log-Cholesky ones, with their slopes.
fn inertia(x: &[f64]) -> [Dual<f64, INERTIAL_PARAMETERS>; INERTIAL_PARAMETERS] {
    let theta = std::array::from_fn(|i| {
        let mut seeded = Dual::from(x[i]);
        seeded.eps[i] = 1.0;
        seeded
    });
    Inertia::from_log_cholesky(theta).to_parameters()
}
