// Every scan's own answer on paper: poses.csv or poses.jsonl.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "common/file/output_file.h"
#include "common/localize/localizer.h"
#include "common/settings/setting.h"

namespace parloc::tools {

enum class PoseFormat { csv, jsonl, none };
inline const std::vector<Choice<PoseFormat>> kPoseFormats{
    {"csv", PoseFormat::csv}, {"jsonl", PoseFormat::jsonl}, {"none", PoseFormat::none}};

inline constexpr const char* kPosesCsv = "poses.csv";
inline constexpr const char* kPosesJsonl = "poses.jsonl";

/// What a run says of one scan. Valid as long as the call that it is handed to.
struct ScanAnswer {
  double stamp_s;
  const LocalizerEstimate& estimate;
  bool judged;             ///< Of the bare filter, the estimate's health says nothing.
  std::size_t beams_used;  ///< Of this scan; 0 if it was not used.
};

/// The first row of a CSV file, ending in a newline.
std::string csv_header();
/// One row, ending in a newline. Stamps have 6 decimals, as in trajectory.tum; of the other numbers the
/// shortest form that reads back to the same double. What is not known, or not finite, is empty.
std::string csv_row(const ScanAnswer& answer);
/// The same as an object of JSON on one line: what is empty there is null, and the hypotheses are a list.
std::string jsonl_row(const ScanAnswer& answer);

/// Rows that are written as they come. Throws Error{output}.
class PoseFile {
 public:
  /// Nothing is made for PoseFormat::none.
  PoseFile(PoseFormat format, const std::string& path);
  void write(const ScanAnswer& answer);
  /// The file is at its path; without this, it never was.
  void commit();

 private:
  PoseFormat format_;
  std::unique_ptr<FileReplacement> file_;
};

}  // namespace parloc::tools
