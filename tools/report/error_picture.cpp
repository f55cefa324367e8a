#include <string>
#include <vector>

#include "common/error.h"
#include "common/file/output_file.h"
#include "tools/report/plots/plot_picture.h"
#include "tools/report/report.h"
#include "tools/report/report_sections.h"

namespace parloc::tools {

void write_error_picture(const std::string& path, const RunReport& report) {
  std::vector<Plot> plots = error_plots(report);
  if (plots.empty()) throw Error(ErrorKind::output, path + ": cannot be written: no errors to show");
  plots.front().series.front().label = "estimate minus truth";
  constexpr std::int32_t kHeight_px = 180;
  replace_file(path, plot_picture(plots, time_axis(report.errors->stamp_s), kHeight_px));
}

}  // namespace parloc::tools
