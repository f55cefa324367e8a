#include "tools/report/plots/plot_shapes.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "tools/report/text/html_text.h"

namespace parloc::tools {
namespace {

constexpr int kColumns = 1000;
constexpr double kTickRow = 0.05, kTick = 0.04;  // of the plot's height
constexpr double kSame = 2.5e-4;                 // of the height: less than a line is wide

using Piece = std::vector<Pixel>;

bool crowded(const std::vector<EnvelopeColumn>& columns) {
  return std::any_of(columns.begin(), columns.end(), [](const EnvelopeColumn& c) { return c.samples > 2; });
}

/// The heights that a line passes in a column.
enum class Through { samples, extremes, means };
std::vector<double> heights_in(const EnvelopeColumn& c, Through through) {
  if (through == Through::means) return {c.mean};
  if (through == Through::extremes && c.samples > 2) return {c.low, c.high};
  if (c.samples < 3) return {c.first, c.last};
  return {c.first, c.low, c.high, c.last};
}

/// A value that the axis does not take lies on the lower edge.
double row_of(const Axis& y, double value) {
  return y.takes(value) ? 1.0 - y.fraction(value) : 1.0;
}

/// A piece between each two gaps. Heights that look the same are one point.
std::vector<Piece> curve(const std::vector<EnvelopeColumn>& columns, const Axis& y, Through through) {
  std::vector<Piece> pieces;
  for (const EnvelopeColumn& c : columns) {
    if (pieces.empty() || c.gap_before) pieces.emplace_back();
    bool first = true;
    for (const double value : heights_in(c, through)) {
      const double row = row_of(y, value);
      if (first || std::abs(row - pieces.back().back().y) > kSame) pieces.back().push_back({c.x, row});
      first = false;
    }
  }
  return pieces;
}

Piece band(const PlotBand& band, const Axis& x, const Axis& y) {
  const std::vector<EnvelopeColumn> columns = envelope(x, band.x, band.half, kColumns);
  Piece outline;
  for (const EnvelopeColumn& c : columns) outline.push_back({c.x, row_of(y, c.high)});
  for (std::size_t k = columns.size(); k-- > 0;)
    outline.push_back({columns[k].x, row_of(y, -columns[k].high)});
  return outline;
}

/// One tick per column at most.
std::vector<Piece> tick_marks(const PlotMarks& marks, const Axis& x) {
  std::vector<bool> seen(kColumns + 1, false);
  for (const double at : marks.x) {
    const double fraction = x.takes(at) ? x.fraction(at) : -1.0;
    if (fraction >= 0.0 && fraction <= 1.0) seen[static_cast<std::size_t>(fraction * kColumns)] = true;
  }
  std::vector<Piece> pieces;
  const double foot = 1.0 - kTickRow * marks.row;
  for (std::size_t k = 0; k < seen.size(); ++k) {
    const double at = static_cast<double>(k) / kColumns;
    if (seen[k]) pieces.push_back({{at, foot}, {at, foot - kTick}});
  }
  return pieces;
}

void add_grid(std::vector<PlotShape>& shapes, const Axis& x, const Axis& y) {
  PlotShape grid{ShapeKind::grid, "", {}};
  for (const Tick& tick : ticks(y)) grid.pieces.push_back({{0.0, 1.0 - tick.at}, {1.0, 1.0 - tick.at}});
  for (const Tick& tick : ticks(x)) grid.pieces.push_back({{tick.at, 0.0}, {tick.at, 1.0}});
  for (int k = static_cast<int>(std::floor(y.low)); y.logarithmic && y.high - y.low < 6 && k <= y.high; ++k) {
    for (int part = 2; part < 10; ++part) {  // steps between the powers of ten
      const double at = y.fraction(part * std::pow(10.0, k));
      if (at >= 0.0 && at <= 1.0) grid.pieces.push_back({{0.0, 1.0 - at}, {0.012, 1.0 - at}});
    }
  }
  shapes.push_back(std::move(grid));
}

void add_series(std::vector<PlotShape>& shapes, const PlotSeries& series, const Axis& x, const Axis& y) {
  std::vector<double> values = series.y;
  if (series.kind != LineKind::area) {
    for (double& value : values)
      if (!y.takes(value)) value = std::nan("");
  }
  const std::vector<EnvelopeColumn> columns = envelope(x, series.x, values, kColumns);
  if (series.kind == LineKind::area) {
    std::vector<Piece> areas = curve(columns, y, Through::samples);
    for (Piece& piece : areas) {
      piece.push_back({piece.back().x, 1.0});
      piece.push_back({piece.front().x, 1.0});
    }
    shapes.push_back({ShapeKind::area, series.colour, std::move(areas)});
    return;
  }
  const ShapeKind kind = series.dashed ? ShapeKind::dashed : ShapeKind::line;
  if (series.kind == LineKind::exact || !crowded(columns)) {
    shapes.push_back({kind, series.colour, curve(columns, y, Through::samples)});
    return;
  }
  shapes.push_back({ShapeKind::pale, series.colour, curve(columns, y, Through::extremes)});
  shapes.push_back({kind, series.colour, curve(columns, y, Through::means)});
}

}  // namespace

std::vector<EnvelopeColumn> envelope(const Axis& axis, const std::vector<double>& x,
                                     const std::vector<double>& y, int columns) {
  std::vector<std::size_t> order;
  for (std::size_t k = 0; k < std::min(x.size(), y.size()); ++k) {
    if (axis.takes(x[k])) order.push_back(k);
  }
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return x[a] < x[b]; });
  std::vector<EnvelopeColumn> result;
  bool gap = false;
  int last_column = -1;
  for (const std::size_t k : order) {
    if (!drawable(y[k])) {
      gap = true;
      continue;
    }
    const double at = std::clamp(axis.fraction(x[k]), 0.0, 1.0);
    const int column = static_cast<int>(at * columns);
    if (column == last_column) {
      EnvelopeColumn& c = result.back();
      c.low = std::min(c.low, y[k]);
      c.high = std::max(c.high, y[k]);
      c.last = y[k];
      c.mean += (y[k] - c.mean) / static_cast<double>(++c.samples);
    } else {
      result.push_back({at, y[k], y[k], y[k], y[k], y[k], 1, gap});
      gap = false;
    }
    last_column = column;
  }
  return result;
}

std::vector<PlotShape> shapes_of(const Plot& plot, const Axis& x, const Axis& y) {
  std::vector<PlotShape> shapes;
  add_grid(shapes, x, y);
  for (const PlotBand& b : plot.bands) shapes.push_back({ShapeKind::band, b.colour, {band(b, x, y)}});
  for (const PlotSeries& series : plot.series) add_series(shapes, series, x, y);
  for (const PlotLevel& level : plot.levels) {
    const double row = row_of(y, level.y);
    if (y.takes(level.y)) shapes.push_back({ShapeKind::level, level.colour, {{{0.0, row}, {1.0, row}}}});
  }
  for (const PlotMarks& marks : plot.marks)
    shapes.push_back({ShapeKind::tick, marks.colour, tick_marks(marks, x)});
  return shapes;
}

}  // namespace parloc::tools
