// How the parts of a grid SLAM's state are written into a checkpoint and read from it. What is read is
// checked as far as computing with it needs; get_... throw Error{input}.
#pragma once

#include <vector>

#include "common/file/bytes.h"
#include "common/filter/steps/step_front_end.h"
#include "common/math/pose.h"
#include "common/model/beams.h"
#include "common/model/trajectory.h"
#include "common/slam/scan_odometry.h"
#include "common/slam/slam_backend.h"

namespace parloc {

void put_pose(ByteWriter& w, const Pose& pose);
Pose get_pose(ByteReader& r);
void put_trajectory(ByteWriter& w, const Trajectory& trajectory);
Trajectory get_trajectory(ByteReader& r);

/// Configured as the one that was put.
void put_front_end(ByteWriter& w, const StepFrontEnd& front_end);
void get_front_end(ByteReader& r, StepFrontEnd& front_end);

void put_beams(ByteWriter& w, const BeamTable& beams);
BeamTable get_beams(ByteReader& r);

void put_scan_odometry(ByteWriter& w, const ScanOdometryState& s);
ScanOdometryState get_scan_odometry(ByteReader& r);

void put_tile(ByteWriter& w, const Tile& tile);
Tile get_tile(ByteReader& r);

/// Whether tables of that span reach there.
bool on_map(const TileSpan& span, double resolution_m, double x_m, double y_m);

/// Particles, and their maps: each tile once, named by its place in the file, whatever it is called in the
/// backend's memory.
void put_backend(ByteWriter& w, const SlamBackend& backend);
/// Into a backend of that configuration.
const SlamStep& get_backend(ByteReader& r, SlamBackend& backend, const SlamConfig& config);

/// What stands around the content of a checkpoint; SlamCheckpoint, where these are defined, checks it. Before
/// it magic and version; then come settings as YAML, the caller's own bytes, and the state; behind it a
/// checksum.
void put_checkpoint_begin(ByteWriter& w);
void put_checkpoint_end(ByteWriter& w);

}  // namespace parloc
