// The closed loop.
#include "common/localize/localizer.h"

#include "tools/python/bindings/bindings.h"
#include "tools/python/bindings/filter_methods.h"
#include "tools/python/values/prior.h"

namespace parloc::python {
namespace {

namespace nb = nanobind;
using namespace nb::literals;

using HeldLocalizer = Guarded<Localizer>;

void make_localizer(HeldLocalizer* self, const GridMap& map, const ConfigBox* config) {
  Config given = config_or_default(config);
  const nb::gil_scoped_release others_run;
  new (self) HeldLocalizer(std::move(given), [&](const Config& c) { return Localizer(c, map); });
}

void bind_starts(nb::class_<HeldLocalizer>& type) {
  static const std::string anywhere_doc = std::string(
                                              "The start is not known: the first scan decides. What is known "
                                              "restricts this and every later search: ") +
                                          kPriorText;
  type.def(
          "start_at",
          [](HeldLocalizer& self, const std::vector<PoseGuess>& guesses) {
            self.use([&](Localizer& l) { l.start_at(guesses); });
          },
          "guesses"_a, "It is one of these places.")
      .def(
          "start_anywhere",
          [](HeldLocalizer& self, const Disc& region, const Interval& heading) {
            const SearchPrior prior = prior_from(region, heading);
            self.use([&](Localizer& l) { l.start_anywhere(prior); });
          },
          "region"_a = nb::none(), "heading"_a = nb::none(), anywhere_doc.c_str());
}

void bind_searches(nb::class_<HeldLocalizer>& type) {
  type.def_prop_ro(
      "searches", [](HeldLocalizer& self) { return self.use([](Localizer& l) { return l.searches(); }); },
      "Searches of the whole map since the start.");
}

void bind_pictures(nb::class_<HeldLocalizer>& type) {
  type.def(
      "end_points",
      [](HeldLocalizer& self, const Scan& scan) {
        return array_of<float>(self.use([&](Localizer& l) { return l.filter().end_points(scan); }), 2);
      },
      "scan"_a,
      "float32 array of shape (N, 2): where the beams that hit something ended, in the base frame [m].");
}

}  // namespace

void bind_localizer(nb::module_& m) {
  nb::class_<HeldLocalizer> type(m, "Localizer",
                                 "Search, track, notice when lost, search again: a particle filter that "
                                 "needs no operator. Deterministic: the same "
                                 "configuration, map and calls give the same bits everywhere. Safe to use "
                                 "from several threads, one call at a time.");
  type.def("__init__", &make_localizer, "map"_a, "config"_a.none() = nb::none(),
           "Makes what searches need of the map, which takes a while. Raises ConfigError, BackendError, "
           "InputError for a "
           "map without free cells.");
  bind_steps(type);
  bind_readings(type);
  bind_runs(type);
  bind_starts(type);
  bind_searches(type);
  bind_pictures(type);
}

}  // namespace parloc::python
