// Logs: CARMEN text and bags of ROS, scan by scan.
#include "tools/python/values/log_scans.h"

#include <fmt/format.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include <filesystem>
#include <mutex>

#include "common/error.h"
#include "common/inputs/open_log.h"
#include "tools/python/bindings/bindings.h"
#include "tools/python/values/arguments.h"
#include "tools/python/values/config_box.h"

namespace parloc::python {
namespace {

namespace nb = nanobind;
using namespace nb::literals;

/// Scans for Python: one thread at a time.
struct Iterator {
  std::mutex mutex;
  Scans scans;

  Iterator(const Log& log, const Config& config) : scans(log, config) {}
};

ScanRecord next(Iterator& self) {
  ScanRecord record;
  bool more = false;
  {
    const nb::gil_scoped_release others_run;
    const std::lock_guard mine(self.mutex);
    more = self.scans.next(record);
  }
  if (!more) throw nb::stop_iteration();
  return record;
}

Log open(const std::filesystem::path& path, const ConfigBox* config) {
  const std::string name = path.string();
  Log log{name, config_or_default(config), [name](const Config& c) { return open_log(name, log_choice(c)); }};
  const nb::gil_scoped_release others_run;
  log.open(log.config);  // what is wrong is said at once
  return log;
}

std::unique_ptr<Iterator> scans_of(const Log& log, const ConfigBox* config) {
  const Config c = config != nullptr ? config->config : log.config;
  const nb::gil_scoped_release others_run;
  return std::make_unique<Iterator>(log, c);
}

void bind_warnings(nb::module_& m) {
  nb::class_<LogWarnings>(m, "LogWarnings",
                          "What a reader worked around. Nothing is dropped without being counted here.")
      .def_ro("broken_lines", &LogWarnings::broken_lines, "Skipped lines or messages.")
      .def_ro("backward_stamps", &LogWarnings::backward_stamps,
              "Scans with a stamp before that of the scan before.")
      .def_ro("beam_count_changes", &LogWarnings::beam_count_changes,
              "Scans with another number of beams than the one before of their LiDAR.")
      .def_ro("unknown_messages", &LogWarnings::unknown_messages, "Of types that parloc has no use for.")
      .def_ro("unread", &LogWarnings::unread, "The same by type: pairs of type and number.")
      .def_prop_ro(
          "notes",
          [](const LogWarnings& w) {
            std::vector<std::string> texts;
            for (const LogNote& note : w.notes) texts.push_back(note.text);
            return texts;
          },
          "What the log leaves open or states oddly, one line each, with the settings that decide it.")
      .def_ro("messages", &LogWarnings::messages, "The first broken lines: 'file:line: what was expected'.");
}

}  // namespace

void bind_log(nb::module_& m) {
  bind_warnings(m);
  nb::class_<ScanRecord>(m, "ScanRecord", "One scan of a log, with the odometry at its time and before it.")
      .def_prop_ro(
          "stamp_s", [](const ScanRecord& r) { return r.record.stamp_s; }, "Time of the scan [s].")
      .def_prop_ro(
          "odometry", [](const ScanRecord& r) { return r.record.odometry; },
          "Pose of the base in the odometry frame at that time.")
      .def_prop_ro(
          "scan", [](ScanRecord& r) -> Scan& { return r.record.scan; }, nb::rv_policy::reference_internal,
          "The scan; no copy.")
      .def_prop_ro(
          "readings",
          [](nb::handle_t<ScanRecord> self) {
            auto& readings = nb::cast<ScanRecord&>(self).readings;
            return Array<double>(readings.data(), {readings.size(), 4}, self);
          },
          "float64 array of shape (N, 4): the odometry read since the scan before, rows of (stamp_s, x_m, "
          "y_m, "
          "theta_rad), up to where the last beam was taken. A view.")
      .def_prop_ro(
          "line", [](const ScanRecord& r) { return r.record.line; }, "Line, or message, of the log.");

  nb::class_<Iterator>(m, "ScanIterator", "Goes through the scans of a log once.")
      .def(
          "__iter__", [](nb::handle self) { return nb::borrow(self); },
          nb::sig("def __iter__(self) -> ScanIterator"))
      .def("__next__", &next)
      .def_prop_ro(
          "progress", [](const Iterator& self) { return self.scans.reader().progress(); },
          "Share of the log read so far, 0 to 1.")
      .def_prop_ro(
          "warnings", [](const Iterator& self) { return self.scans.reader().warnings(); },
          "What was worked around so far.");

  nb::class_<Log>(m, "Log", "A robot's log. Iterating reads it from its beginning, each time anew.")
      .def_ro("name", &Log::name, "The file or folder.")
      .def("scans", &scans_of, "config"_a.none() = nb::none(),
           "Iterates over the scans as a filter with this configuration needs them, in file order. Raises "
           "InputError for "
           "a log without a scan.")
      .def("__iter__", [](const Log& log) { return scans_of(log, nullptr); })
      .def("__repr__", [](const Log& log) { return fmt::format("<parloc.Log {}>", log.name); });

  m.def("open_log", &open, "path"_a, "config"_a.none() = nb::none());
}

}  // namespace parloc::python
