// The likelihood field's table against the formula of SPEC 3.4 in float64, within the error that follows from
// how it is stored. That the backends look up as this header says is held by the stage tests.
#include "common/model/likelihood_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>
#include <string>

namespace parloc {
namespace {

constexpr double kRangeMax_m = 3.5;

SensorConfig spec_sensor() {
  SensorConfig c = default_sensor(SensorModel::likelihood_field);
  c.z_hit = c.z_rand = 0.5;
  c.sigma_hit = 0.2;
  return c;
}

/// log p(D) - log p(0)
double exact_nat(const SensorConfig& c, double distance_m) {
  const auto density = [&](double d) {
    return c.z_hit * std::exp(-0.5 * d * d / (c.sigma_hit * c.sigma_hit)) /
               (c.sigma_hit * std::sqrt(2 * 3.14159265358979323846)) +
           c.z_rand / kRangeMax_m;
  };
  return std::log(density(std::min(distance_m, c.laser_likelihood_max_dist)) / density(0));
}

/// A grid of 30 x 20 cells of 5 cm with two cells of wall, and the field of it.
struct Place {
  static constexpr int kWidth = 30, kHeight = 20;
  static constexpr double kCell_m = 0.05;
  explicit Place(const SensorConfig& sensor) : config(sensor) {
    for (int j = 0; j < kHeight; ++j)
      for (int i = 0; i < kWidth; ++i) {
        const auto squared = [&](int x, int y) { return (i - x) * (i - x) + (j - y) * (j - y); };
        squared_cells.push_back(static_cast<std::uint32_t>(std::min(squared(7, 5), squared(22, 14))));
      }
    const DistanceLikelihood likelihood = bind_distance(config, kCell_m, kRangeMax_m);
    for (std::size_t at = 0; at < table_size(kWidth, kHeight); ++at)
      table.push_back(table_entry(likelihood, squared_cells.data(), kWidth, kHeight, at));
    field = {table.data() + kWidth + 3, kWidth, kHeight, kWidth + 2, FieldLookup::bilinear,
             likelihood.unit_nat()};
  }
  std::int32_t value(double u, double v) const {
    const FieldPose pose = field.pose(static_cast<float>(u), static_cast<float>(v), {0.0f, 1.0f});
    return field.value_at(field.place(pose, 0.0f, 0.0f));
  }
  double nat(double u, double v) const { return value(u, v) * static_cast<double>(field.unit_nat); }
  double exact_cell_nat(int i, int j) const {
    const bool on_map = i >= 0 && i < kWidth && j >= 0 && j < kHeight;
    const double cells = on_map ? std::sqrt(squared_cells[static_cast<std::size_t>(j * kWidth + i)]) : 1e9;
    return exact_nat(config, cells * kCell_m);
  }
  double exact_bilinear_nat(double u, double v) const {
    const double fu = std::floor(u - 0.5), fv = std::floor(v - 0.5), a = u - 0.5 - fu, b = v - 0.5 - fv;
    const int i = static_cast<int>(fu), j = static_cast<int>(fv);
    return (1 - b) * ((1 - a) * exact_cell_nat(i, j) + a * exact_cell_nat(i + 1, j)) +
           b * ((1 - a) * exact_cell_nat(i, j + 1) + a * exact_cell_nat(i + 1, j + 1));
  }
  /// Half a unit of the table, and float32's part in it: log p is rounded to 3e-7, units to 6e-8 of the
  /// whole.
  double table_error_nat() const {
    return 0.5 * (1 << kValueBits) * static_cast<double>(field.unit_nat) + 4e-7 -
           6e-8 * exact_nat(config, 1e9);
  }

  SensorConfig config;
  std::vector<std::uint32_t> squared_cells, table;
  LikelihoodField field;
};

TEST(LikelihoodField, HasTheSpecifiedValues) {
  const Place place(spec_sensor());
  const double known[][2] = {// distance in cells, density
                             {0, 1.14021284386},
                             {1, 1.10952743486},
                             {4, 0.747783954155},
                             {10, 0.186677894091}};
  for (const auto& [cells, density] : known)
    EXPECT_NEAR(place.nat(7.5 + cells, 5.5), std::log(density / 1.14021284386), place.table_error_nat())
        << cells;
  EXPECT_NEAR(place.nat(-5, -5), std::log(0.142857142857 / 1.14021284386), place.table_error_nat());
}

TEST(LikelihoodField, StaysWithinItsStatedError) {
  for (const double sigma_m : {0.01, 0.05, 0.2}) {
    SensorConfig config = spec_sensor();
    config.sigma_hit = sigma_m;
    const Place place(config);
    double steepest_nat = 0;  // between neighbours
    for (int j = -1; j < Place::kHeight; ++j)
      for (int i = -1; i < Place::kWidth; ++i)
        steepest_nat =
            std::max({steepest_nat, std::abs(place.exact_cell_nat(i + 1, j) - place.exact_cell_nat(i, j)),
                      std::abs(place.exact_cell_nat(i, j + 1) - place.exact_cell_nat(i, j))});
    // The value's last rounding, and up to half a part of a cell in either direction (float32: 1e-5 more).
    const double most_nat = place.table_error_nat() + 0.5 * static_cast<double>(place.field.unit_nat) +
                            2 * steepest_nat * (0.5 / kCellParts + 1e-5);
    std::mt19937 random(1);
    std::uniform_real_distribution<double> u(-3, Place::kWidth + 3), v(-3, Place::kHeight + 3);
    double largest_nat = 0;
    for (int n = 0; n < 100000; ++n) {
      const double x = u(random), y = v(random);
      largest_nat = std::max(largest_nat, std::abs(place.nat(x, y) - place.exact_bilinear_nat(x, y)));
    }
    EXPECT_LE(largest_nat, most_nat) << sigma_m;
    EXPECT_GT(largest_nat, 0.2 * most_nat) << sigma_m;  // the bound means something
    RecordProperty("largest_nat_at_" + std::to_string(sigma_m), std::to_string(largest_nat));
  }
}

TEST(LikelihoodField, NearestIsTheValueOfTheCell) {
  Place place(spec_sensor());
  place.field.lookup = FieldLookup::nearest;
  for (int j = -1; j <= Place::kHeight; ++j)
    for (int i = -1; i <= Place::kWidth; ++i)
      for (const double part : {0.01, 0.5, 0.99})
        EXPECT_NEAR(place.nat(i + part, j + 1 - part), place.exact_cell_nat(i, j), place.table_error_nat());
}

TEST(LikelihoodField, OffTheMapIsTheLeast) {
  Place place(spec_sensor());
  for (const FieldLookup lookup : {FieldLookup::bilinear, FieldLookup::nearest}) {
    place.field.lookup = lookup;
    for (const double far : {1.0, 7.3, 1e6, 1e30, std::numeric_limits<double>::quiet_NaN()}) {
      EXPECT_EQ(place.value(-far, 5), kLeastInTable * (1 << kValueBits)) << far;
      EXPECT_EQ(place.value(5, -far), kLeastInTable * (1 << kValueBits)) << far;
      EXPECT_EQ(place.value(Place::kWidth + far, Place::kHeight + far), kLeastInTable * (1 << kValueBits))
          << far;
    }
  }
}

TEST(LikelihoodField, TakesTheEndsOfItsSettings) {
  SensorConfig config = spec_sensor();
  config.z_hit = 0, config.z_rand = 1;  // says nothing
  EXPECT_EQ(Place(config).nat(3, 4), 0.0);
  config.z_hit = 1, config.z_rand = 0, config.sigma_hit = 0.01;  // nothing far from a wall is possible
  const Place sharp(config);
  EXPECT_EQ(sharp.nat(7.5, 5.5), 0.0);
  EXPECT_NEAR(sharp.nat(8.5, 5.5), -12.5, sharp.table_error_nat());
  EXPECT_LT(sharp.nat(15.5, 5.5), -80.0);
}

TEST(LikelihoodField, TheLargestMapsLastCellIsFound) {
  constexpr float kSide = 32767;
  const LikelihoodField field{nullptr, 32767, 32767, 32769, FieldLookup::nearest, 1.0f};
  const FieldPlace last = field.place(field.pose(kSide - 0.5f, kSide - 0.5f, {0.0f, 1.0f}), 0.0f, 0.0f);
  EXPECT_EQ(last.at, 32766 * 32769 + 32766);
  const FieldPlace beyond = field.place(field.pose(2 * kSide, 2 * kSide, {0.0f, 1.0f}), 0.0f, 0.0f);
  EXPECT_EQ(beyond.at, 32767 * 32769 + 32767);
}

}  // namespace
}  // namespace parloc
