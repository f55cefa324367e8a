// Many starts, and what they say together.
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <thread>

#include "common/error.h"
#include "common/eval/trial_summary.h"
#include "common/map/map_reader.h"
#include "tools/evaluate/trials.h"
#include "tools/python/bindings/bindings.h"
#include "tools/python/values/arguments.h"
#include "tools/python/values/config_box.h"
#include "tools/shards/shard.h"

namespace parloc::python {
namespace {

namespace nb = nanobind;
using namespace nb::literals;

struct Evaluation {
  TrialPlan plan;
  std::vector<TrialResult> trials;
  TrialSummary summary;
};

TrialTask task_named(const std::string& name) {
  if (name == "global") return TrialTask::global;
  if (name == "kidnap") return TrialTask::kidnap;
  if (name == "track") return TrialTask::track;
  throw Error(ErrorKind::usage, "task: expected global, kidnap or track, got '" + printable(name) + "'");
}

/// As `parloc evaluate --scenario`.
Evaluation evaluate_scenario(const std::filesystem::path& path, std::size_t trials, const ConfigBox* config,
                             const std::string& task, std::optional<double> duration_s,
                             std::optional<double> limit_s, std::uint64_t first_seed, int jobs) {
  if (trials < 1) throw Error(ErrorKind::usage, "trials: expected at least 1, got 0");
  Evaluation e;
  e.plan.task = task_named(task);
  const double limit = limit_s.value_or(e.plan.task == TrialTask::kidnap ? 5.0 : 3.0);
  e.plan.duration_s = duration_s.value_or(limit + e.plan.hold_s);
  tools::evaluate::TrialsRequest request{
      e.plan, config_or_default(config), first_seed, tools::shards::Shard{}.items(trials), jobs, false, {},
      {}};
  const nb::gil_scoped_release others_run;
  const int cores = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  request.jobs =
      static_cast<int>(std::min<std::size_t>(static_cast<std::size_t>(jobs > 0 ? jobs : cores), trials));
  bool interrupted = false;
  request.stop = [&] {
    const nb::gil_scoped_acquire ours;
    return interrupted = interrupted || PyErr_CheckSignals() != 0;
  };
  const Scenario scenario = read_scenario(path.string());
  const std::string& on =
      scenario.localization_map_path.empty() ? scenario.map_path : scenario.localization_map_path;
  e.trials = tools::evaluate::run_trials(
      request,
      tools::evaluate::simulated_trials(e.plan, scenario, read_map(scenario.map_path), path.string()),
      read_map(on));
  if (interrupted) {
    const nb::gil_scoped_acquire ours;
    throw nb::python_error();
  }
  e.summary = summarise(e.plan, limit, e.trials);
  return e;
}

nb::dict row_of(const TrialResult& t) {
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  nb::dict row;
  row["seed"] = t.seed;
  row["x_m"] = t.start.x_m;
  row["y_m"] = t.start.y_m;
  row["theta_rad"] = t.start.theta_rad;
  row["localized_after_s"] = t.outcome.localized_after_s.value_or(none);
  row["noticed_after_s"] = t.outcome.noticed_after_s.value_or(none);
  row["right_s"] = t.outcome.right_s;
  row["wrong_s"] = t.outcome.wrong_s;
  row["confident_wrong"] = t.outcome.confident_wrong;
  row["false_lost"] = t.outcome.false_lost;
  row["searches"] = t.searches;
  return row;
}

void bind_rate(nb::module_& m) {
  nb::class_<Rate>(m, "Rate", "A share with its 95 % confidence interval (Wilson 1927).")
      .def_ro("hits", &Rate::hits, "So many of them.")
      .def_ro("trials", &Rate::trials, "All.")
      .def_ro("share", &Rate::share, "NaN without a trial.")
      .def_ro("low", &Rate::low, "Lower bound.")
      .def_ro("high", &Rate::high, "Upper bound.");
}

}  // namespace

void bind_trials(nb::module_& m) {
  bind_rate(m);
  nb::class_<Evaluation>(m, "Evaluation", "Many trials of the localizer, in the order of their seeds.")
      .def_prop_ro(
          "trials",
          [](const Evaluation& e) {
            nb::list rows;
            for (const TrialResult& trial : e.trials) rows.append(row_of(trial));
            return rows;
          },
          nb::sig("def trials(self) -> list[dict[str, float]]"),
          "One dict per trial: seed, start (x_m, y_m, theta_rad), localized_after_s and noticed_after_s "
          "(NaN: not), "
          "right_s, wrong_s, confident_wrong, false_lost, searches. pandas.DataFrame takes the list.")
      .def_prop_ro(
          "success", [](const Evaluation& e) { return e.summary.success; }, "Localized within the limit.")
      .def_prop_ro(
          "localized", [](const Evaluation& e) { return e.summary.localized; }, "Localized at all.")
      .def_prop_ro(
          "confident_wrong", [](const Evaluation& e) { return e.summary.confident_wrong; },
          "Trials that were once sure and wrong.")
      .def_prop_ro(
          "noticed", [](const Evaluation& e) { return e.summary.noticed; }, "kidnap: noticed in time.")
      .def_prop_ro(
          "localize_median_s", [](const Evaluation& e) { return e.summary.localize_s.median; },
          "Median time until it was localized [s].")
      .def_prop_ro(
          "rmse_m", [](const Evaluation& e) { return e.summary.rmse_m; },
          "Position error since the localization, over all trials [m].")
      .def_prop_ro(
          "nees", [](const Evaluation& e) { return e.summary.nees.mean; },
          "Normalised estimation error squared: 3 is right, more is over-confident.")
      .def_prop_ro(
          "failed", [](const Evaluation& e) { return e.summary.failed; }, "Seeds without success.");
  m.def("evaluate", &evaluate_scenario, "scenario"_a, "trials"_a = 20, "config"_a.none() = nb::none(),
        "task"_a = "global", "duration_s"_a = nb::none(), "limit_s"_a = nb::none(), "first_seed"_a = 1,
        "jobs"_a = 0,
        "Tries the localizer on random drives through a scenario's map: how often, how soon and how surely "
        "does it find "
        "itself? task: 'global' (no start given), 'kidnap' or 'track'; limit_s: success is to be localized "
        "by then; jobs: "
        "trials at once, 0: as many as cores. The same trials as `parloc evaluate --scenario`. Raises "
        "ConfigError, "
        "InputError.");
}

}  // namespace parloc::python
