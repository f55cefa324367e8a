#include "tools/compare/published.h"

#include <algorithm>
#include <cmath>

namespace parloc::tools::compare {
namespace {

// Slides of the study (TurtleBot3 House in Gazebo, LDS-01,
// 439 s of driving, 5 cm map): position and heading, first the RMSE, then the MAE. AMCL has 500 to 3000
// particles, EDH ten Euler steps.
constexpr const char* kStudy = "Csuzdi and Toro 2021, slides, table of the three noise levels";
// The authors' evaluation scripts of their follow-up: 50 runs; times in ROS, per update. Its EDH takes Euler
// steps that grow by 1.3 (MEDH), its NAEDH the closed form. AMCL+ weighs every scan.
constexpr const char* kFollowUp =
    "follow-up of Csuzdi and Toro 2021, figures of the authors' evaluation scripts";

bool about(double a, double b) {
  return std::fabs(a - b) <= 1e-6 * std::fabs(b);
}

}  // namespace

const std::vector<PublishedSetting>& published_settings() {
  static const std::vector<PublishedSetting> settings{
      {kStudy,
       1e-6,
       0.01,
       0.05,
       {{"EKF", "ekf", 0, .0559, .0212, .0492, .0168},
        {"AMCL", "amcl", 0, .0529, .0233, .0453, .0177},
        {"EDH, 10", "edh", 10, .0504, .0228, .0449, .0183},
        {"EDH, 100", "edh", 100, .0504, .0229, .0447, .0183},
        {"EDH, 500", "edh", 500, .0498, .0231, .0441, .0185}}},
      {kStudy,
       1e-4,
       0.01,
       0.05,
       {{"EKF", "ekf", 0, .0497, .0186, .0428, .0159},
        {"AMCL", "amcl", 0, .0816, .0708, .0672, .0547},
        {"EDH, 10", "edh", 10, .0439, .0205, .0381, .0188},
        {"EDH, 100", "edh", 100, .0437, .0206, .0383, .0190},
        {"EDH, 500", "edh", 500, .0438, .0206, .0382, .0190}}},
      {kStudy,
       5e-3,
       0.01,
       0.05,
       {{"EKF", "ekf", 0, .0732, .0297, .0610, .0256},
        {"AMCL", "amcl", 0, .5261, .4940, .3533, .3841},
        {"EDH, 10", "edh", 10, .0587, .0401, .0494, .0372},
        {"EDH, 100", "edh", 100, .0616, .0403, .0503, .0374},
        {"EDH, 500", "edh", 500, .0617, .0402, .0503, .0373}}},
      {kFollowUp,
       5e-4,
       0.02,
       0.01,
       {{"EKF", "ekf", 0, .04461, .02879, {}, {}, 6.23},
        {"AMCL", "amcl", 0, .11113, .14806, {}, {}, 5.62},
        {"AMCL+", "", 0, .06111, .11088, {}, {}, 38.29},
        {"MEDH, 100", "edh", 100, .01563, .02267, {}, {}, 49.78},
        {"NAEDH, 100", "naedh", 100, .01701, .02263, {}, {}, 49.62}}},
  };
  return settings;
}

const PublishedSetting* find_published(double kappa_m, double sigma_range_m, double resolution_m) {
  for (const PublishedSetting& s : published_settings())
    if (about(kappa_m, s.kappa_m) && about(sigma_range_m, s.sigma_range_m) &&
        about(resolution_m, s.resolution_m))
      return &s;
  return nullptr;
}

const PublishedRow* find_row(const PublishedSetting& setting, const std::string& kind,
                             std::int64_t particles) {
  const auto row = std::find_if(setting.rows.begin(), setting.rows.end(), [&](const PublishedRow& r) {
    return r.kind == kind && (r.particles == 0 || r.particles == particles);
  });
  return row == setting.rows.end() ? nullptr : &*row;
}

}  // namespace parloc::tools::compare
