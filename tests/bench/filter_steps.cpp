// Steps of the filter along the recorded corridor with 60 beams, on one thread: for tools that count
// instructions. What a particle costs is the difference between two numbers of them (docs/results/arm.md).
//   filter_steps MODEL PARTICLES        prints steps, beams, those that hit something, and the digest
#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>

#include "common/error.h"
#include "common/filter/particle_filter.h"
#include "common/io/log.h"
#include "common/map/map_reader.h"
#include "common/model/beams.h"
#include "common/model/model_settings.h"

namespace {

using namespace parloc;

FilterConfig config_for(const std::string& model, std::int64_t particles) {
  FilterConfig c;
  c.backend = BackendChoice::cpu;
  c.threads = 1;
  c.seed = 42;
  c.particles = particles;
  c.update_min_d = c.update_min_a = 0.0;  // every scan is weighed
  c.scan.max_beams = 60;
  c.sensor.z_max = c.sensor.z_rand = 0.05;
  for (const Choice<SensorModel>& choice : kSensorModels)
    if (choice.name == model) c.sensor.model = choice.value;
  return c;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    fmt::print(stderr, "usage: filter_steps MODEL PARTICLES\n");
    return 2;
  }
  try {
    const std::string maps = PARLOC_SOURCE_DIR "/maps/";
    ParticleFilter filter(config_for(argv[1], std::atoll(argv[2])), read_map(maps + "malaga_corridor.yaml"));
    filter.start_at({3.453, -10.171, -0.485}, 0.2, 0.2, 0.1);
    const auto log = open_carmen_log(maps + "logs/malaga_corridor.log.gz");
    std::size_t steps = 0, beams = 0, hits = 0;
    for (LogRecord record; log->next(record);) {
      if (record.kind != RecordKind::scan) continue;
      filter.step(record.odometry, record.scan);
      ++steps;
      beams += filter.last_beams().count;
      hits += filter.last_beams().hits;
    }
    fmt::print("{} steps, {} beams, {} hits, {}\n", steps, beams, hits, filter.digest());
  } catch (const Error& error) {
    fmt::print(stderr, "filter_steps: {}\n", error.what());
    return 3;
  }
}
