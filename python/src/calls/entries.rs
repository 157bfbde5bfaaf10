//! Functions of the table with their derivatives.

use dualbody_python_table::{Dual, Lifted, Memory, Point, Prepared, Robot, adjoint_of, on_duals};

use super::{Call, Kind, Rows, Signature};
use crate::dynamics::table::Entry;
use crate::prelude::*;
use crate::simulator::check_finite;

/// A call of an entry of the table.
struct OfEntry<'a> {
    call: &'a Call<'a>,
    entry: &'static Entry,
    names: &'a [&'static str],
    /// Vectors, parameters not among them.
    given: usize,
    rows: &'a Rows<'a>,
    robot: Robot<'a, f64>,
    id: u64,
}

pub(super) fn call(
    call: &Call<'_>,
    signature: &Signature,
    rows: &Rows<'_>,
    found: &[usize],
    out: &mut [&mut [f64]],
) -> PyResult<()> {
    let (robot, id) = call.of.robot();
    let given = signature.inputs.len() - usize::from(call.has_parameters);
    let entry = signature.entry.expect("it is one of the table");
    if entry.function.is_of_simulator {
        for (name, x) in signature.names.iter().zip(rows.arrays) {
            check_finite(name, x)?;
        }
    }
    let names = &signature.names;
    let own = OfEntry {
        call,
        entry,
        names,
        given,
        rows,
        robot,
        id,
    };
    match call.kind {
        Kind::Value => own.value(found, out),
        Kind::Push | Kind::Pull => own.derivatives(found, out),
    }
}

impl OfEntry<'_> {
    fn value(&self, found: &[usize], out: &mut [&mut [f64]]) -> PyResult<()> {
        let f = self.entry.prepared(self.robot.model(), &self.call.names)?;
        if self.call.has_parameters {
            let one = |k: usize, out: &mut [f64]| {
                let own = self.robot.over(self.parameters(k));
                let mut memory = Memory::new(own.robot().model());
                f(own.robot(), &mut memory, &self.vectors(k), out);
                Ok(())
            };
            in_rows(self.call.count, found, out, &one)?;
        } else {
            let views: Vec<View<'_>> = (0..self.given)
                .map(|i| View::of_batch(self.rows.arrays[i], self.rows.widths[i]))
                .collect();
            let wide = self.entry.wide.map(|wide| {
                move |memory: &mut _, x: &[&[_]], out: &mut [_]| {
                    wide(self.robot.model(), memory, x, out)
                }
            });
            let work = Work {
                one: &|memory, x, out| f(self.robot, memory, x, out),
                wide: wide.as_ref().map(|wide| wide as _),
            };
            map_views(
                (self.robot.model(), self.id),
                &views,
                self.call.count,
                work,
                out[0],
            )?;
        }
        match self.entry.function.is_of_simulator && out[0].iter().any(|x| !x.is_finite()) {
            true => Err(invalid!("{} is not finite", self.call.function)),
            false => Ok(()),
        }
    }

    fn vectors(&self, k: usize) -> Vec<&[f64]> {
        (0..self.given).map(|i| self.rows.row(i, k)).collect()
    }

    fn parameters(&self, k: usize) -> Option<&[f64]> {
        self.call
            .has_parameters
            .then(|| self.rows.row(self.given, k))
    }

    fn derivatives(&self, found: &[usize], out: &mut [&mut [f64]]) -> PyResult<()> {
        let function = on_duals(self.call.function);
        let prepare = function
            .and_then(|function| function.prepare)
            .ok_or_else(|| invalid!("{} has no derivatives here", self.call.function))?;
        let f: Prepared<Dual> = prepare(self.robot.model(), &self.call.names).or_raise()?;
        let one = |k: usize, out: &mut [f64]| {
            let x = self.vectors(k);
            let names = &self.names[..self.given];
            let point = Point {
                robot: self.robot,
                names,
                x: &x,
                parameters: self.parameters(k),
            };
            if self.call.kind == Kind::Pull && self.by_adjoint(&point, k, out) {
                return Ok(());
            }
            with_memory((self.robot.model(), self.id), |memory| {
                let kept = memory
                    .dual
                    .get_or_insert_with(|| Lifted::new(self.robot, None));
                let directions = self.call.directions.max(1);
                if self.call.kind == Kind::Pull {
                    let weights = self.rows.more(0, k);
                    let width = weights.len() / directions;
                    let pull = |i, out: &mut [f64]| point.pull(&f, kept, i, weights, out, width);
                    return self.each_active(out, pull);
                }
                let mut all = vec![None; self.given + 1];
                for (p, &i) in self.call.active.iter().enumerate() {
                    all[i] = Some(self.rows.more(p, k));
                }
                let width = out.len() / directions;
                point.push(&f, kept, &all, out, width);
            });
            Ok(())
        };
        in_rows(self.call.count, found, out, &one)
    }

    /// The part of the row of each input whose derivatives are wanted.
    fn each_active(&self, out: &mut [f64], mut one: impl FnMut(usize, &mut [f64])) {
        let mut rest = out;
        for &i in &self.call.active {
            let (own, others) = rest.split_at_mut(self.rows.widths[i] * self.call.directions);
            one(i, own);
            rest = others;
        }
    }

    /// Derivatives by an adjoint along the tree, if there is one for what is given.
    fn by_adjoint(&self, point: &Point<'_>, k: usize, out: &mut [f64]) -> bool {
        let Some(adjoint) = adjoint_of(self.call.function) else {
            return false;
        };
        if self.given > self.entry.function.arguments.len() {
            return false;
        }
        let own = point
            .parameters
            .map(|all| self.robot.model().with_parameters(all));
        let model = own.as_ref().unwrap_or(self.robot.model());
        let width = model.nv().max(1);
        let all: Vec<_> = (self
            .rows
            .more(0, k)
            .chunks(width)
            .map(|weights| adjoint(model, point.x, weights)))
        .collect();
        self.each_active(out, |i, out| {
            let slopes: Vec<f64> = all.iter().flat_map(|all| all[i].iter().copied()).collect();
            point.write_slopes(i, &slopes, out);
        });
        true
    }
}
