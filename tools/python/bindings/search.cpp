// Where on the map was this scan taken?
#include "common/search/global_search.h"

#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <chrono>

#include "common/model/beams.h"
#include "common/model/lidar.h"
#include "tools/python/bindings/bindings.h"
#include "tools/python/values/arguments.h"
#include "tools/python/values/config_box.h"
#include "tools/python/values/guarded.h"
#include "tools/python/values/prior.h"

namespace parloc::python {
namespace {

namespace nb = nanobind;
using namespace nb::literals;

struct Search {
  GlobalSearch search;
  double resolution_m;
};
using HeldSearch = Guarded<Search>;

void make_search(HeldSearch* self, const GridMap& map, const ConfigBox* config) {
  Config given = config_or_default(config);
  const nb::gil_scoped_release others_run;
  validate(given);
  new (self) HeldSearch(std::move(given), [&](const Config& c) {
    return Search{GlobalSearch(map, c.search, c), map.resolution_m};
  });
}

/// As `parloc locate`, in slices, so that Ctrl-C ends it.
SearchResult search_scan(HeldSearch& self, const Scan& scan, const Disc& region, const Interval& heading) {
  const SearchPrior prior = prior_from(region, heading);
  return self.use([&](Search& s) -> SearchResult {
    const Config& config = self.config();
    BeamTable beams;
    BeamCounts counts;
    select_beams(scan, lidar_setup(scan, config.scan, find_lidar(config.lidars, scan.sensor)), nullptr,
                 config.sensor, s.resolution_m, beams, counts);
    if (beams.count < static_cast<std::size_t>(config.scan.min_beams)) return {};
    constexpr std::int64_t slice = 20'000'000;  // some 50 ms
    s.search.begin(beams, prior);
    while (!s.search.advance(slice)) {
      const nb::gil_scoped_acquire ours;
      heed_signals();
    }
    return s.search.result();
  });
}

void bind_result(nb::module_& m) {
  nb::class_<Hypothesis>(m, "Hypothesis",
                         "One place where the scan may have been taken. Shares are of all beams.")
      .def_ro("pose", &Hypothesis::pose, "In the map frame.")
      .def_ro("score", &Hypothesis::score, "How close the hits end to walls, 0 to 1.")
      .def_ro("explained", &Hypothesis::explained, "Share of beams that end where the map's ray does.")
      .def_ro("through", &Hypothesis::through, "Share of beams that go through a wall of the map.")
      .def_ro("unmapped", &Hypothesis::unmapped, "Share of beams that end before the map's wall.")
      .def_ro("evidence", &Hypothesis::evidence,
              "What the scan says for it, against any other place [nat per beam].")
      .def_ro("weight", &Hypothesis::weight, "Share among all hypotheses that were judged.")
      .def_ro("as_good", &Hypothesis::as_good, "As good as the first (which is, too).");
  nb::class_<SearchResult>(m, "SearchResult", "What a search of the map has found.")
      .def_ro("hypotheses", &SearchResult::hypotheses, "The most likely first; separated; may be empty.")
      .def_ro("ambiguous", &SearchResult::ambiguous,
              "Another one is as good as the first, or there were too many.")
      .def_ro("beams", &SearchResult::beams, "Hits that the exhaustive part looked at.")
      .def_ro("headings", &SearchResult::headings, "Of the lattice.")
      .def_ro("candidates", &SearchResult::candidates, "Places that were judged.")
      .def_ro("too_many", &SearchResult::too_many, "There may be more than those.");
}

}  // namespace

void bind_search(nb::module_& m) {
  bind_result(m);
  static const std::string search_doc =
      std::string("Where on the map was this scan taken? ") + kPriorText +
      " Raises InputError for a prior that is not finite or leaves no free cell.";
  nb::class_<HeldSearch>(
      m, "GlobalSearch",
      "Searches all poses of a lattice over the whole free space for where a scan was taken. "
      "Deterministic; one call at a time.")
      .def("__init__", &make_search, "map"_a, "config"_a.none() = nb::none(),
           "Makes what depends on the map alone. Raises as Localizer.")
      .def("search", &search_scan, "scan"_a, "region"_a = nb::none(), "heading"_a = nb::none(),
           search_doc.c_str())
      .def_prop_ro(
          "backend_name",
          [](HeldSearch& self) { return self.use([](Search& s) { return s.search.backend_name(); }); },
          "'cpu (AVX-512, 2 threads)' or 'cuda (device name)'.");
}

}  // namespace parloc::python
