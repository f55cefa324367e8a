#include "tools/run/pose_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

namespace parloc::tools {
namespace {

/// Shortest form that reads back to the same double; empty for what is not finite, which JSON cannot say.
std::string number_text(double value) {
  return std::isfinite(value) ? fmt::format("{}", value) : "";
}

enum class FieldKind { number, word, truth };

struct Field {
  const char* name;
  std::string text;  ///< Empty: not known.
  FieldKind kind = FieldKind::number;
};

Field truth(const char* name, bool value) {
  return {name, value ? "1" : "0", FieldKind::truth};
}

/// All columns but the last, which are the hypotheses.
std::vector<Field> fields_of(const ScanAnswer& answer) {
  const LocalizerEstimate& said = answer.estimate;
  const Estimate& filter = said.filter;
  const double* covariance = filter.covariance.v;
  const auto judged = [&](const std::string& text) { return answer.judged ? text : ""; };
  return {{"stamp_s", fmt::format("{:.6f}", answer.stamp_s)},
          {"x_m", number_text(filter.pose.x_m)},
          {"y_m", number_text(filter.pose.y_m)},
          {"theta_rad", number_text(filter.pose.theta_rad)},
          {"covariance_xx_m2", number_text(covariance[0])},
          {"covariance_xy_m2", number_text(covariance[1])},
          {"covariance_xt_m_rad", number_text(covariance[2])},
          {"covariance_yy_m2", number_text(covariance[4])},
          {"covariance_yt_m_rad", number_text(covariance[5])},
          {"covariance_tt_rad2", number_text(covariance[8])},
          {"state", judged(name_of(said.health.state)), FieldKind::word},
          {"probability", judged(number_text(said.health.probability))},
          {"evidence", judged(number_text(said.health.evidence))},
          {"n_eff", number_text(filter.n_eff)},
          {"particles", fmt::format("{}", filter.particles)},
          {"beams_used", fmt::format("{}", answer.beams_used)},
          truth("weighted", filter.weighted),
          truth("searched", said.searched)};
}

std::string json_value(const Field& field) {
  if (field.text.empty()) return "null";
  if (field.kind == FieldKind::word) return fmt::format("\"{}\"", field.text);
  if (field.kind == FieldKind::truth) return field.text == "1" ? "true" : "false";
  return field.text;
}

std::string json_object(const std::vector<Field>& fields) {
  std::string text;
  for (const Field& field : fields)
    text += fmt::format("{}\"{}\":{}", text.empty() ? "" : ",", field.name, json_value(field));
  return text;
}

std::string json_object(const Mode& mode) {
  return "{" +
         json_object({{"x_m", number_text(mode.pose.x_m)},
                      {"y_m", number_text(mode.pose.y_m)},
                      {"theta_rad", number_text(mode.pose.theta_rad)},
                      {"weight", number_text(mode.weight)}}) +
         "}";
}

constexpr const char* kHypotheses = "hypotheses";

}  // namespace

std::string csv_header() {
  std::string text;
  for (const Field& field : fields_of({0.0, LocalizerEstimate(), false, 0}))
    text += fmt::format("{},", field.name);
  return text + kHypotheses + "\n";
}

std::string csv_row(const ScanAnswer& answer) {
  std::string text;
  for (const Field& field : fields_of(answer)) text += field.text + ",";
  return text + fmt::format("{}\n", answer.estimate.modes.size());
}

std::string jsonl_row(const ScanAnswer& answer) {
  std::vector<std::string> hypotheses;
  for (const Mode& mode : answer.estimate.modes) hypotheses.push_back(json_object(mode));
  return fmt::format("{{{},\"{}\":[{}]}}\n", json_object(fields_of(answer)), kHypotheses,
                     fmt::join(hypotheses, ","));
}

PoseFile::PoseFile(PoseFormat format, const std::string& path) : format_(format) {
  if (format == PoseFormat::none) return;
  file_ = std::make_unique<FileReplacement>(path);
  if (format != PoseFormat::csv) return;
  const std::string header = csv_header();
  file_->write(header.data(), header.size());
}

void PoseFile::write(const ScanAnswer& answer) {
  if (!file_) return;
  const std::string row = format_ == PoseFormat::csv ? csv_row(answer) : jsonl_row(answer);
  file_->write(row.data(), row.size());
}

void PoseFile::commit() {
  if (file_) file_->commit();
}

}  // namespace parloc::tools
