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

/// Where a variable makes sense.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Domain {
    Anywhere,
    NotNegative,
    Positive,
}

impl Domain {
    /// Least value that a descent is to go to.
    pub(super) fn lower(self) -> f64 {
        match self {
            Self::Anywhere => f64::NEG_INFINITY,
            Self::NotNegative | Self::Positive => 0.0,
        }
    }

    fn holds(self, x: f64) -> bool {
        x.is_finite()
            && match self {
                Self::Anywhere => true,
                Self::NotNegative => x >= 0.0,
                Self::Positive => x > 0.0,
            }
    }
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
    pub(super) domains: Vec<Domain>,
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
        self.domains.extend([Domain::Anywhere; INERTIAL_PARAMETERS]);
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
        let domain = domain(layout, index, name).ok_or_else(|| {
            IdentifyError::option(name, "a descent could take it where it makes no sense")
        })?;
        let value = simulator.parameters()[index];
        self.push(vec![index], name.into(), value, domain);
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
        self.push(target, name, first, Domain::NotNegative);
        Ok(())
    }

    fn push(&mut self, target: Target, name: String, value: f64, domain: Domain) {
        self.targets.push(target);
        self.names.push(name);
        self.nominal.push(value);
        self.domains.push(domain);
        self.blocks.push(Block::Number);
    }

    pub(super) fn len(&self) -> usize {
        self.nominal.len()
    }

    /// Whether numbers of the robot, one for each variable, are where they make sense.
    pub(super) fn make_sense(&self, values: &[f64]) -> bool {
        let mut pairs = self.domains.iter().zip(values);
        pairs.all(|(domain, &x)| domain.holds(x))
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

/// Where a parameter makes sense; `None` if that is not known.
fn domain(layout: &ParameterLayout<Group>, index: usize, name: &str) -> Option<Domain> {
    let not_negative = [
        "mass",
        "damping",
        "armature",
        "stiffness",
        "friction",
        "Coulomb friction",
    ];
    let quantity = quantity(name);
    if not_negative.iter().any(|own| quantity.starts_with(own)) && !quantity.ends_with("exponent") {
        return Some(Domain::NotNegative);
    }
    let group = layout.groups().iter().find(|(_, own)| own.contains(&index));
    match group.map(|(group, _)| *group)? {
        Group::Constraint(_) if quantity == "length" => Some(Domain::Positive),
        Group::Constraint(_) if quantity == "time constant" => None,
        Group::ContactPoint(_) if quantity == "radius" => None,
        Group::Model(_)
        | Group::Terrain
        | Group::ExternalForce(_)
        | Group::ContactPoint(_)
        | Group::Constraint(_) => Some(Domain::Anywhere),
        _ => None,
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
