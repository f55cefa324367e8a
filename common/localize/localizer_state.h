// What a localizer remembers between scans.
#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "common/localize/localizer.h"
#include "common/localize/missing_returns.h"
#include "common/localize/place_evidence.h"
#include "common/localize/rivals.h"
#include "common/localize/scan_novelty.h"
#include "common/localize/slip_search.h"
#include "common/search/global_search.h"

namespace parloc {

/// Particles are put with this spread about what they already stand for.
constexpr double kModeSigma_m = 0.05, kModeSigma_rad = 0.02;
constexpr double kLeastMode = 0.02;  ///< Share of the weight of a mode.
/// A place that the search has chosen has to show itself [nat].
constexpr double kFoundLogOdds = 0.5;

/// The methods that look for other places are in localizer_search.cpp.
struct Localizer::State {
  /// What is known at a step before its scan is weighed.
  struct Now {
    Pose odometry;
    double elapsed_s;
    const BeamTable& beams;
  };

  State(const LocalizerConfig& c, const GridMap& map)
      : config(c), filter(c, map), judge(map, c.search.effective_beams) {}

  void begin(bool is_lost, bool is_settled, const SearchPrior& known);
  void told(bool is_settled, const PoseEstimate& where);
  void expect_takes(const Scan& scan, const Pose& recorded) const;
  /// After the filter was asked for its odometry.
  LocalizerEstimate step(const std::optional<OdometryReading>& reading, const Pose& recorded,
                         const Scan& scan);
  /// How far the LiDARs reach whose scans were taken so far [m].
  std::vector<double> reaches_m() const;
  void note_reach(double range_max_m);
  bool searches() const { return config.localize.recover || config.localize.slips; }
  GlobalSearch& whole_map();
  SlipSearch& near_by();
  std::vector<Mode> modes_at(const Pose& odometry) const;
  bool search_is_due(const Pose& odometry) const;
  void start_search(const Now& now);
  void go_on_searching(const Now& now, LocalizerEstimate& out);
  std::vector<JudgedPlace> found_now(const Now& now, LocalizerEstimate& out);
  void put_at(std::vector<JudgedPlace> found, const Now& now);
  std::vector<JudgedPlace> newcomers(const std::vector<JudgedPlace>& found, const std::vector<Mode>& modes,
                                     const Now& now);
  void look_for_others(const std::vector<JudgedPlace>& found, const Now& now);
  void weigh_rivals(const Now& now);
  void drop_refuted(const Now& now);
  bool fits_again(const Now& now);
  void look_for_slips(const Now& now);
  void settle(const Now& now, LocalizerEstimate& out);
  JudgedPlace judge_estimate(const BeamTable& beams, const Pose& pose);
  void watch(const Now& now, LocalizerEstimate& out);

  const LocalizerConfig config;
  bool started = false;
  mutable std::mutex reaches_lock;  // prepare_map() asks from another thread
  std::vector<double> reaches;
  ParticleFilter filter;
  std::unique_ptr<GlobalSearch> search;  // made when there is something to search
  std::unique_ptr<SlipSearch> slips;     // likewise
  PlaceEvidence judge;                   // remembers scans from where the doubt began

  /// Of one run, from start to start.
  struct Drive {
    SearchPrior prior;
    HealthMonitor monitor;
    ScanNovelty novelty;
    MissingReturns missing;
    bool placed = false;                    // it was told or has found where it may be, since the start
    bool lost = true;                       // search
    bool doubt = false;                     // more speaks against it than for it, since a little while
    bool settled = false;                   // else there may be other places, as good as the filter's
    bool found = false;                     // it is where a search has put it, and has not shown itself yet
    std::size_t refuted = 0;                // places in a row that did not: perhaps it is nowhere on this map
    bool was_settled = false;               // until it was lost; no search has found another place since
    std::optional<Pose> searched_odometry;  // where the last search began
    double since_search_s = 0.0;
    std::size_t searches = 0;
    Rivals rivals;
    std::optional<JudgedPlace> expected;  // where the robot was to be at this scan, if the scan says so, too
    std::optional<Pose> tracked;          // the heaviest cluster, after the last step that was weighed
    double since_well_m = 0.0;
    bool trusted = false;         // it has shown itself, and was not lost since
    std::size_t unexplained = 0;  // scans in a row that fitted badly where the robot was expected
    Health last;
    PoseEstimate given;             // the last pose that was given out, ...
    std::optional<double> given_s;  // ... and its time
  };
  Drive d;
};

}  // namespace parloc
