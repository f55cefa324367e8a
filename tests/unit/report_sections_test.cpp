// The parts of a report: views of maps, plots, numbers, PNG files.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "common/error.h"
#include "tests/unit/decoded_png.h"
#include "tools/report/map_view.h"
#include "tools/report/pictures/png_writer.h"
#include "tools/report/plots/plot.h"
#include "tools/report/plots/plot_shapes.h"
#include "tools/report/report_sections.h"
#include "tools/report/text/html_text.h"

namespace parloc::tools {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

GridMap free_map(std::int32_t width, std::int32_t height, double resolution_m) {
  GridMap map;
  map.width = width, map.height = height, map.resolution_m = resolution_m;
  map.cells.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), Cell::free);
  return map;
}
RunReport report_on(const GridMap& map) {
  RunReport report;
  report.map = &map;
  return report;
}
Cell cell_under(const std::vector<Cell>& cells, const MapView& view, const Pixel& at) {
  return cells[static_cast<std::size_t>(at.y) * static_cast<std::size_t>(view.width_px) +
               static_cast<std::size_t>(at.x)];
}

TEST(MapView, OccupiedCellsWinWhenALargeMapIsShrunk) {
  GridMap map = free_map(5000, 3000, 0.05);
  map.cells[1234U * 5000U + 4321U] = Cell::occupied;
  const RunReport report = report_on(map);
  const MapView view = fit_view(report, 1, 1600).value();
  EXPECT_LE(std::max(view.width_px, view.height_px), 1600);
  const std::vector<Cell> cells = raster(map, view);
  ASSERT_EQ(cells.size(), static_cast<std::size_t>(view.width_px) * static_cast<std::size_t>(view.height_px));
  EXPECT_EQ(std::count(cells.begin(), cells.end(), Cell::occupied), 1);
  EXPECT_EQ(cell_under(cells, view, view.to_pixel(4321.5 * 0.05, 1234.5 * 0.05)), Cell::occupied);
}

TEST(MapView, PointsLieOnTheirCellsInATurnedAndMagnifiedMap) {
  GridMap map = free_map(30, 20, 0.5);
  map.T_map_grid = {3.0, -4.0, 0.7};
  map.cells[7 * 30 + 21] = Cell::occupied;
  const RunReport report = report_on(map);
  const MapView view = fit_view(report, 600, 1600).value();
  ASSERT_GT(view.up, 1);
  const std::vector<Cell> cells = raster(map, view);
  // The cell's centre in the grid, then turned into the map frame.
  const double gx = 21.5 * 0.5, gy = 7.5 * 0.5;
  const Pixel at = view.to_pixel(3.0 + std::cos(0.7) * gx - std::sin(0.7) * gy,
                                 -4.0 + std::sin(0.7) * gx + std::cos(0.7) * gy);
  EXPECT_EQ(cell_under(cells, view, at), Cell::occupied);
  EXPECT_EQ(std::count(cells.begin(), cells.end(), Cell::occupied), view.up * view.up);
}

TEST(MapView, CropsAHugeMapToThePath) {
  const GridMap map = free_map(4000, 4000, 0.1);
  RunReport report = report_on(map);
  report.estimate = {{0, {100, 100, 0}}, {1, {110, 104, 0}}};
  const MapView view = fit_view(report, 1, 1600).value();
  EXPECT_EQ(view.down, 1);
  EXPECT_LT(view.width_px, 250);                               // 10 m of path and 2.5 m on both sides
  report.odometry = {{0, {100, 100, 0}}, {1, {1e6, 104, 0}}};  // far away: widens the window a little
  EXPECT_LT(fit_view(report, 1, 1600)->width_px, 300);
}

TEST(Envelope, KeepsPeaksOfALongSeries) {
  std::vector<double> stamps, values;
  for (int k = 0; k < 15000; ++k) {
    stamps.push_back(k);
    values.push_back(k == 7777 ? 50.0 : k == 8888 ? -20.0 : 1.0);
  }
  const auto columns = envelope(time_axis(stamps), stamps, values, 1000);
  EXPECT_LE(columns.size(), 1001U);
  double low = 0, high = 0;
  for (const EnvelopeColumn& c : columns) low = std::min(low, c.low), high = std::max(high, c.high);
  EXPECT_EQ(high, 50.0);
  EXPECT_EQ(low, -20.0);
}

TEST(RenderPlot, TellsOfPeaksThatAnErrorPlotCutsOff) {
  Plot plot{"Error", "m", PlotScale::symmetric, {{"", "c1", {}, {}}}};
  for (int k = 0; k < 1000; ++k) {
    plot.series[0].x.push_back(k);
    plot.series[0].y.push_back(k < 5 ? 3.25 : 0.02);
  }
  EXPECT_NE(render_plot(plot, time_axis(plot.series[0].x)).find("peaks up to 3.25"), std::string::npos);
  plot.series[0].y.assign(1000, 0.02);
  EXPECT_EQ(render_plot(plot, time_axis(plot.series[0].x)).find("peaks"), std::string::npos);
}

TEST(ValueAxis, HasMoreLabelsThanZero) {
  for (const double largest : {0.041, 0.9, 1.0, 2.1, 4.4, 4.6, 77.0}) {
    const Plot plot{"", "m", PlotScale::symmetric, {{"", "c1", {0, 1}, {-largest, largest}}}};
    const Axis axis = value_axis(plot).value();
    EXPECT_GE(ticks(axis).size(), 3U) << largest;
    EXPECT_LE(ticks(axis).size(), 9U) << largest;
    EXPECT_NEAR(axis.fraction(0.0), 0.5, 1e-12);
  }
}

TEST(Envelope, OrdersStampsThatRunBackwardsAndMarksGaps) {
  const std::vector<double> stamps = {0, 3, 1, 2, 4}, values = {10, 13, 11, nan, 14};
  const auto columns = envelope(time_axis(stamps), stamps, values, 100);
  ASSERT_EQ(columns.size(), 4U);
  EXPECT_EQ(columns[1].low, 11);
  EXPECT_EQ(columns[1].mean, 11);
  EXPECT_FALSE(columns[1].gap_before);
  EXPECT_EQ(columns[2].low, 13);
  EXPECT_TRUE(columns[2].gap_before);  // stamp 2 has no value
}

TEST(NumberText, IsForReaders) {
  EXPECT_EQ(number_text(1.50, 3), "1.5");
  EXPECT_EQ(number_text(-0.0001, 2), "0");
  EXPECT_EQ(number_text(100, 0), "100");
  EXPECT_EQ(number_text(nan, 2), "\xE2\x80\x93");
  EXPECT_EQ(number_text(12345678, 2), "1.23e+07");
}

TEST(PngWriter, RoundTripsColoursAndRefusesWrongSizes) {
  const std::vector<std::uint8_t> pixels = {255, 0, 0, 1, 2, 3, 0, 255, 0, 9, 8, 7};
  const Picture picture = decode(encode_png_rgb(2, 2, pixels));
  EXPECT_EQ(picture.width, 2);
  EXPECT_EQ(picture.rgb, pixels);
  EXPECT_THROW(encode_png_rgb(3, 2, pixels), Error);
  EXPECT_THROW(encode_png_palette(2, 1, {0, 5}, {{}, {}}), Error);
  EXPECT_EQ(png_data_uri("a"), "data:image/png;base64,YQ==");
  EXPECT_EQ(png_data_uri("ab"), "data:image/png;base64,YWI=");
  EXPECT_EQ(png_data_uri("\xFF\xFE\xFD"), "data:image/png;base64,//79");
}

TEST(EvenlySpaced, KeepsTheEnds) {
  EXPECT_EQ(evenly_spaced(3, 10), (std::vector<std::size_t>{0, 1, 2}));
  EXPECT_EQ(evenly_spaced(10, 4), (std::vector<std::size_t>{0, 3, 6, 9}));
  EXPECT_EQ(evenly_spaced(10, 1), (std::vector<std::size_t>{9}));
  EXPECT_TRUE(evenly_spaced(0, 4).empty());
}

}  // namespace
}  // namespace parloc::tools
