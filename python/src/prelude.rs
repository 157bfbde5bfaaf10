//! Items that most files of the binding use.

pub(crate) use crate::arrays::{
    Argument, Array, Rows, View, WIDTH, Wide, Work, argument, checked_output, common_batch, empty,
    in_rows, map_plain, map_rows, map_views, matrices, matrix, numbers, numbers_mut, read_matrix,
    read_matrix_of, read_numbers, read_vector, room, stack, vector, with_memory, write_matrix,
};
pub(crate) use crate::errors::{
    OrRaise, about_base, caught, choice, ensure, guarded, invalid, refuse, shape_error, type_error,
    value_error, variant, warn, wrong_type,
};
pub(crate) use crate::kinds::{attribute, check_kind, fields, kind_of, whole};
pub(crate) use crate::limits::{check_array, check_grid, check_trajectories};
pub(crate) use crate::model::PyModel;
pub(crate) use crate::options::{chosen, read_options};
pub(crate) use crate::python::{Recipe, dict, functions, getters, methods, of_package, slice};
pub(crate) use crate::raised::Raised;
pub(crate) use crate::scratch::with_kept;
pub(crate) use crate::simulator::PySimulator;
pub(crate) use crate::threads::{each, on_pool, on_pool_stopped};
pub(crate) use crate::words::snake;
pub(crate) use dualbody::{Model, Simulator, State};
pub(crate) use nalgebra::{DMatrix, DVector};
pub(crate) use numpy::{PyArray1, PyArrayMethods, PyUntypedArrayMethods};
pub(crate) use pyo3::prelude::*;
pub(crate) use pyo3::types::{PyDict, PyTuple};
