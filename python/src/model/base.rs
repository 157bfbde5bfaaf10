//! Base of a robot (fixed or floating), by name.

use dualbody::Base;

use crate::prelude::*;

pub(super) fn base_of(name: &str) -> PyResult<Base> {
    let choices = [
        ("auto", Base::Auto),
        ("fixed", Base::Fixed),
        ("floating", Base::Floating),
    ];
    choice("base", name, &choices)
}
