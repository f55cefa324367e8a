// The extension module parloc._parloc.
#include "tools/python/bindings/bindings.h"

NB_MODULE(_parloc, m) {
  using namespace parloc::python;
  m.doc() = "The compiled part of parloc.";
  m.attr("version") = PARLOC_VERSION;
  // In this order: what a signature names is known before it.
  bind_errors(m);
  bind_pose(m);
  bind_config(m);
  bind_map(m);
  bind_scan(m);
  bind_trajectory(m);
  bind_log(m);
  bind_estimate(m);
  bind_filters(m);
  bind_localizer(m);
  bind_search(m);
  bind_slam(m);
  bind_simulator(m);
  bind_trials(m);
  bind_live(m);
}
