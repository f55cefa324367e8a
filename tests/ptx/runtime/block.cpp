#include "tests/ptx/runtime/block.h"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <set>
#include <utility>

#include "tests/ptx/runtime/report.h"
#include "tests/ptx/runtime/settings.h"

namespace ptx {
namespace {

constexpr int kPoison = 0xCD;
constexpr int kPatience = 64;  // reads that may wait, before others run
constexpr std::size_t kLine = 16;

std::size_t lines(std::size_t bytes) {
  return (bytes + kLine - 1) / kLine;
}

std::vector<std::unique_ptr<BlockMemory>>& unused() {
  static std::vector<std::unique_ptr<BlockMemory>> pieces;
  return pieces;
}

std::unique_ptr<BlockMemory> take_unused() {
  if (unused().empty()) return std::make_unique<BlockMemory>();
  auto memory = std::move(unused().back());
  unused().pop_back();
  return memory;
}

template <class T>
void grow(std::vector<T>& v, std::size_t size) {
  if (v.size() < size) v.resize(size);
}

/// A thread's registers begin with the place where it goes on: at the start.
void start_of(void* registers) {
  *static_cast<int*>(registers) = 0;
}

Extent place_in(const Extent& extent, std::uint32_t index) {
  return {index % extent.x, index / extent.x % extent.y, index / extent.x / extent.y};
}

}  // namespace

Block::Block(const Launch& launch, std::uint32_t block_number)
    : number(block_number),
      threads(launch.threads.all()),
      states(threads.size(), State::ready),
      memory(take_unused()),
      launch_(launch),
      registers_each_(launch.kernel->meets ? lines(launch.kernel->register_bytes) : 0) {
  static std::uint32_t blocks = 0;
  serial = ++blocks;
  const std::uint32_t shared_bytes = launch.kernel->shared_bytes + launch.dynamic_shared;
  const std::size_t local_each = lines(launch.kernel->local_bytes);
  grow(memory->shared, lines(shared_bytes));
  grow(memory->registers, lines(launch.kernel->register_bytes) + registers_each_ * (threads.size() - 1));
  grow(memory->local, local_each * threads.size());
  grow(memory->traces, shared_bytes / 4 + 1);
  std::memset(static_cast<void*>(memory->shared.data()), kPoison, shared_bytes);
  std::memset(static_cast<void*>(memory->local.data()), kPoison, local_each * threads.size() * kLine);
  const std::size_t pieces = launch.kernel->piece_count;
  memory->visits.assign(threads.size() * pieces, 0);
  for (std::uint32_t i = 0; i < threads.size(); ++i) {
    Thread& thread = threads[i];
    thread.launch = &launch;
    thread.block = this;
    thread.index = i;
    thread.id = place_in(launch.threads, i);
    thread.block_id = place_in(launch.blocks, number);
    thread.parameters = const_cast<char*>(launch.parameters.data());
    thread.shared = reinterpret_cast<char*>(memory->shared.data());
    thread.shared_bytes = shared_bytes;
    thread.local = reinterpret_cast<char*>(memory->local.data() + i * local_each);
    thread.local_bytes = launch.kernel->local_bytes;
    thread.visits = memory->visits.data() + i * pieces;
    start_of(memory->registers.data() + i * registers_each_);
  }
}

Block::~Block() {
  count_visits();
  unused().push_back(std::move(memory));
}

/// A warp issues a piece as often as that of its lanes which comes there most often: they part at branches,
/// and are together again behind them.
void Block::count_visits() const {
  constexpr std::size_t kLanes = 32;
  KernelCounts& counts = counts_of(*launch_.kernel);
  ++counts.blocks;
  counts.issued_in.resize(launch_.kernel->piece_count);
  std::uint64_t longest = 0;
  for (std::size_t first = 0; first < threads.size(); first += kLanes) {
    const std::size_t end = std::min(first + kLanes, threads.size());
    std::uint64_t issued = 0;
    for (std::uint32_t piece = 0; piece < launch_.kernel->piece_count; ++piece) {
      std::uint64_t all = 0, most = 0;
      for (std::size_t i = first; i < end; ++i) {
        all += threads[i].visits[piece];
        most = std::max<std::uint64_t>(most, threads[i].visits[piece]);
      }
      if (most == 0) continue;
      std::uint64_t& in_piece = counts.issued_in[piece];
      for (std::size_t kind = 0; kind < kKinds; ++kind) {
        const std::uint64_t here = launch_.kernel->pieces[piece][kind];
        counts.instructions[kind] += all * here;
        counts.issued[kind] += most * here;
        issued += most * here;
        in_piece += most * here;
      }
    }
    longest = std::max(longest, issued);
  }
  counts.longest_warp = std::max(counts.longest_warp, longest);
  counts.block_chains += longest;
}

Block::Progress Block::run_round(std::mt19937& order) {
  Ran ran = run_threads(order);
  if (live() == 0) return Progress::finished;
  for (std::uint32_t warp = 0; warp * 32 < threads.size(); ++warp) ran.advanced |= meet_in_warp(*this, warp);
  ran.advanced |= release_barriers();
  if (!ran.advanced && std::find(states.begin(), states.end(), State::ready) == states.end())
    explain_standstill();
  return ran.looked ? Progress::looked : Progress::advanced;
}

Block::Ran Block::run_threads(std::mt19937& order) {
  const auto count = static_cast<std::uint32_t>(threads.size());
  const bool shuffled = settings().seed != 0;
  // A walk through all of them: from anywhere, by a step that has no factor in common with their number.
  std::uint32_t step = shuffled ? order() % count | 1 : 1;
  while (std::gcd(step, count) != 1) ++step;
  std::uint32_t at = shuffled ? order() % count : 0;
  Ran ran;
  for (std::uint32_t i = 0; i < count; ++i, at += at + step < count ? step : step - count) {
    if (states[at] != State::ready) continue;
    Thread& thread = threads[at];
    thread.patience = kPatience;
    void* registers = memory->registers.data() + at * registers_each_;
    if (!launch_.kernel->meets) start_of(registers);
    const Outcome outcome = launch_.kernel->run(thread, registers);
    ran.advanced |= outcome != Outcome::yielded;
    ran.looked |= outcome == Outcome::yielded || thread.patience < kPatience;
    if (outcome == Outcome::finished) states[at] = State::finished;
    if (outcome == Outcome::barrier) states[at] = State::at_barrier;
    if (outcome == Outcome::warp) states[at] = State::in_warp;
  }
  return ran;
}

bool Block::release_barriers() {
  std::set<std::uint32_t> barriers;  // mostly none, or one
  for (std::size_t i = 0; i < threads.size(); ++i)
    if (states[i] == State::at_barrier) barriers.insert(threads[i].meeting.barrier);
  bool released = false;
  for (const std::uint32_t barrier : barriers) released |= meet_at(barrier);
  return released;
}

/// If as many are there as are expected, they go on, and know of each other what they did before.
bool Block::meet_at(std::uint32_t barrier) {
  std::vector<std::size_t> here;
  for (std::size_t i = 0; i < threads.size(); ++i)
    if (states[i] == State::at_barrier && threads[i].meeting.barrier == barrier) here.push_back(i);
  const Meeting& first = threads[here[0]].meeting;
  const std::size_t there = live(), expected = first.expected == 0 ? there : first.expected;
  if (here.size() < expected) return false;
  if (here.size() > expected) fault(threads[here[0]], "more threads have come to the barrier than it is for");
  std::uint64_t count = 0;
  std::array<int, 32> line_of_warp{};
  for (const std::size_t i : here) {
    const Meeting& meeting = threads[i].meeting;
    count += meeting.value;
    int& line = line_of_warp[i / 32];
    if (line != 0 && line != meeting.line)
      fault(threads[i],
            "threads of one warp are at different barriers, the others at line " + std::to_string(line));
    line = meeting.line;
  }
  Known known, released;
  std::uint32_t clock = 0;
  for (const std::size_t i : here) {
    known = join(known, threads[i].known);
    released = join(released, threads[i].released);
    clock = std::max(clock, threads[i].clock);
  }
  for (const std::size_t i : here) {
    Thread& thread = threads[i];
    states[i] = State::ready;
    thread.meeting.result = count;
    thread.meeting.predicate = count == here.size();
    thread.clock = clock + 1;
    if (here.size() == there) thread.block_seen = clock + 1;
    thread.known = known, thread.released = released;
  }
  return true;
}

/// Nobody can run: says who waits for whom.
void Block::explain_standstill() const {
  for (std::size_t i = 0; i < threads.size(); ++i)
    if (states[i] == State::in_warp) explain_missing_lanes(*this, threads[i]);
  fault(unfinished(), "the barrier waits for threads that do not come");
}

const Thread& Block::unfinished() const {
  const auto found = std::find_if(states.begin(), states.end(), [](State s) { return s != State::finished; });
  return threads[static_cast<std::size_t>(found - states.begin())];
}

std::size_t Block::live() const {
  return threads.size() - static_cast<std::size_t>(std::count(states.begin(), states.end(), State::finished));
}

}  // namespace ptx
