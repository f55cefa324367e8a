// The folder that a run writes its results into.
#pragma once

#include <string>
#include <vector>

namespace parloc::tools {

/// Makes sure before the work that results can be written after it, and that a failed run leaves an earlier
/// one's results as they were: files are written into a hidden folder inside, and moved to their places all
/// at the end. Such a folder of a run that was killed is removed by the next one.
class OutputFolder {
 public:
  /// Creates `folder` (and those above it) if need be. Throws Error{output} if that fails, if nothing can be
  /// written there, or if a folder stands where one of `files` is to go.
  OutputFolder(const std::string& folder, std::vector<std::string> files);
  /// Removes what was not published, and the folders it created if they are empty.
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  /// Where to write `file` for now.
  std::string staged(const std::string& file) const { return staging_ + "/" + file; }
  /// Where it will be.
  std::string final_path(const std::string& file) const { return folder_ + "/" + file; }
  /// Moves the staged files to their places, replacing what is there; a file that was not staged is removed
  /// there, so that none of an earlier run stays among the others, unless it is one of `keep`. Throws
  /// Error{output}.
  void publish(const std::vector<std::string>& keep = {});

 private:
  void make_staging();

  std::string folder_;
  std::string staging_;
  int lock_ = -1;  ///< Of the staging folder, while this run lives.
  std::vector<std::string> files_;
  std::vector<std::string> created_;  ///< Outermost first.
};

}  // namespace parloc::tools
