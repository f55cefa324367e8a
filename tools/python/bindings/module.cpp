// The extension module parloc._parloc.
#include "tools/python/bindings/bindings.h"

NB_MODULE(_parloc, m) {
  using namespace parloc::python;
  m.doc() = "The compiled part of parloc.";
  m.attr("__version__") = PARLOC_VERSION;
  bind_errors(m);
  bind_pose(m);
  bind_map(m);
  bind_settings(m);
  bind_live(m);
}
