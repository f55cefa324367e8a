// The figures that the authors of the Daum-Huang localization study published: what `parloc compare` prints
// beside its own where the setting is theirs.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace parloc::tools::compare {

/// One filter at one noise of the wheels. Mean over the authors' runs.
struct PublishedRow {
  const char* name;        ///< As they call it.
  const char* kind;        ///< Ours that does the same; "" if none does.
  std::int64_t particles;  ///< Fixed number; 0: it has none, or they adapt.
  double position_rmse_m, heading_rmse_rad;
  std::optional<double> position_mae_m{}, heading_mae_rad{};
  std::optional<double> step_ms{};
};

/// What a published table was measured with.
struct PublishedSetting {
  const char* source;
  double kappa_m, sigma_range_m, resolution_m;  ///< Of the wheels, of the ranges, and of the map's cells.
  std::vector<PublishedRow> rows;
};

const std::vector<PublishedSetting>& published_settings();

/// The table of this setting; null if there is none.
const PublishedSetting* find_published(double kappa_m, double sigma_range_m, double resolution_m);
/// Its row for one of our filters; null if there is none. `particles` does not matter for filters that have
/// none or choose their own.
const PublishedRow* find_row(const PublishedSetting& setting, const std::string& kind,
                             std::int64_t particles);

}  // namespace parloc::tools::compare
