// A state of grid SLAM in a file, to go on from later as if nothing had happened.
#pragma once

#include <iosfwd>
#include <istream>
#include <memory>
#include <string>

#include "common/slam/grid_slam_config.h"

namespace parloc {

class ByteReader;

/// What GridSlam::save wrote, found to be whole. For GridSlam's constructor, once.
class SlamCheckpoint {
 public:
  /// Throws Error{input} for a file that cannot be read, is none, is damaged, or is of another version.
  explicit SlamCheckpoint(const std::string& path);
  /// Bytes in memory; `name` stands for them in messages.
  SlamCheckpoint(std::string bytes, const std::string& name);
  ~SlamCheckpoint();
  SlamCheckpoint(SlamCheckpoint&&) noexcept;
  SlamCheckpoint& operator=(SlamCheckpoint&&) noexcept;

  /// The file, for messages.
  const std::string& name() const { return name_; }
  /// What the state was made with. Backend, threads and device may be set to others before going on, nothing
  /// else: the bits are the same everywhere.
  GridSlamConfig config;
  /// What the caller of save() gave besides.
  std::string own;

 private:
  friend class GridSlam;
  void open(std::unique_ptr<std::istream> in);

  std::string name_;
  GridSlamConfig saved_config_;
  std::unique_ptr<std::istream> in_;
  std::unique_ptr<ByteReader> rest_;
};

}  // namespace parloc
