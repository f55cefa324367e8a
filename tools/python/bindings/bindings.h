// The parts of the module, each with a source of its own: what module.cpp puts together.
#pragma once

#include <nanobind/nanobind.h>

namespace parloc::python {

void bind_errors(nanobind::module_& m);
void bind_pose(nanobind::module_& m);
void bind_map(nanobind::module_& m);
void bind_live(nanobind::module_& m);
void bind_settings(nanobind::module_& m);

}  // namespace parloc::python
