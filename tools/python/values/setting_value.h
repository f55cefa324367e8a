// Values of settings from Python and to it.
#pragma once

#include <nanobind/nanobind.h>

#include <string>

#include "common/settings/setting.h"

namespace parloc::python {

/// A number, bool or text; an enumeration as the name that files have for it; None if it is missing.
nanobind::object value_of(const Setting& setting);
/// Throws TypeError for a wrong type, and Error{config} for a value out of its limits: the setting then keeps
/// the value that it had.
void assign(const Setting& setting, nanobind::handle value);
/// "float", "int | None", "Literal['a', 'b']": for stubs.
std::string python_type(const Setting& setting);
/// What it means, what it may be, and its default.
std::string python_doc(const Setting& setting);

}  // namespace parloc::python
