// The parts of the module, each with a source of its own: what module.cpp puts together.
#pragma once

#include <nanobind/nanobind.h>

namespace parloc::python {

void bind_errors(nanobind::module_& m);
void bind_pose(nanobind::module_& m);
void bind_config(nanobind::module_& m);
void bind_map(nanobind::module_& m);
void bind_scan(nanobind::module_& m);
void bind_trajectory(nanobind::module_& m);
void bind_log(nanobind::module_& m);
void bind_estimate(nanobind::module_& m);
void bind_filters(nanobind::module_& m);
void bind_localizer(nanobind::module_& m);
void bind_search(nanobind::module_& m);
void bind_slam(nanobind::module_& m);
void bind_simulator(nanobind::module_& m);
void bind_trials(nanobind::module_& m);
void bind_live(nanobind::module_& m);

}  // namespace parloc::python
