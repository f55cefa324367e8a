// Instructions of a warp. The threads that one names in its mask, but for those that have finished, wait
// until all of them are at such an instruction with the same mask; then each gets its answer.
#include <algorithm>
#include <bit>

#include "tests/ptx/runtime/block.h"
#include "tests/ptx/runtime/report.h"

namespace ptx {
namespace {

// What a shuffle gives that reads from a lane which does not take part: undefined, so that no result may
// depend on it.
constexpr std::uint32_t kPoison = 0xcdcdcdcd;

struct Warp {
  Block& block;
  std::uint32_t first, count;
  Thread& lane(std::uint32_t i) const { return block.threads[first + i]; }
  State& state(std::uint32_t i) const { return block.states[first + i]; }
};

Warp warp_of(Block& block, std::uint32_t number) {
  const std::uint32_t first = number * 32;
  return {block, first,
          std::min<std::uint32_t>(32, static_cast<std::uint32_t>(block.threads.size()) - first)};
}

/// Those lanes that the mask names and that have not finished.
std::uint32_t awaited(const Warp& warp, std::uint32_t mask) {
  std::uint32_t lanes = 0;
  for (std::uint32_t i = 0; i < warp.count; ++i)
    if (mask >> i & 1 && warp.state(i) != State::finished) lanes |= 1u << i;
  return lanes;
}

/// Those lanes that wait with the same request and mask.
std::uint32_t arrived(const Warp& warp, const Meeting& meeting) {
  std::uint32_t lanes = 0;
  for (std::uint32_t i = 0; i < warp.count; ++i) {
    const Meeting& other = warp.lane(i).meeting;
    if (warp.state(i) == State::in_warp && other.mask == meeting.mask && other.request == meeting.request)
      lanes |= 1u << i;
  }
  return lanes;
}

/// Where a shuffle reads, as the PTX ISA computes it, and whether that lies in the segment.
struct Source {
  std::int64_t lane;
  bool inside;
};
Source source_of(std::uint32_t lane, const Meeting& m) {
  const std::uint32_t segment = m.bound >> 8 & 31, bound = m.bound & 31, offset = m.lane & 31;
  const std::int64_t last = (lane & segment) | (bound & ~segment), start = lane & segment;
  switch (m.request) {
    case Request::shuffle_up: {
      const std::int64_t from = std::int64_t{lane} - offset;
      return {from, from >= last};
    }
    case Request::shuffle_down: {
      const std::int64_t from = std::int64_t{lane} + offset;
      return {from, from <= last};
    }
    case Request::shuffle_across: {
      const std::int64_t from = lane ^ offset;
      return {from, from <= last};
    }
    default: {
      const std::int64_t from = start | (offset & ~segment);
      return {from, from <= last};
    }
  }
}

void shuffle(const Warp& warp, std::uint32_t lanes, std::uint32_t lane) {
  Meeting& meeting = warp.lane(lane).meeting;
  const Source source = source_of(lane, meeting);
  meeting.predicate = source.inside;
  const auto from = source.inside ? static_cast<std::uint32_t>(source.lane) : lane;
  meeting.result = lanes >> from & 1 ? warp.lane(from).meeting.value : kPoison;
}

void vote(const Warp& warp, std::uint32_t lanes) {
  std::uint32_t ballot = 0;
  for (std::uint32_t i = 0; i < warp.count; ++i)
    if (lanes >> i & 1 && warp.lane(i).meeting.value != 0) ballot |= 1u << i;
  for (std::uint32_t i = 0; i < warp.count; ++i) {
    if (!(lanes >> i & 1)) continue;
    Meeting& meeting = warp.lane(i).meeting;
    meeting.result = ballot;
    meeting.predicate = meeting.request == Request::vote_any       ? ballot != 0
                        : meeting.request == Request::vote_uniform ? ballot == 0 || ballot == lanes
                                                                   : ballot == lanes;
  }
}

void match(const Warp& warp, std::uint32_t lanes, std::uint32_t lane) {
  Meeting& meeting = warp.lane(lane).meeting;
  std::uint32_t same = 0;
  for (std::uint32_t i = 0; i < warp.count; ++i)
    if (lanes >> i & 1 && warp.lane(i).meeting.value == meeting.value) same |= 1u << i;
  meeting.predicate = same == lanes;
  meeting.result = meeting.request == Request::match_all && same != lanes ? 0 : same;
}

std::uint32_t reduced(const Meeting& meeting, std::uint32_t a, std::uint32_t b) {
  const auto signed_a = static_cast<std::int32_t>(a), signed_b = static_cast<std::int32_t>(b);
  const bool less = meeting.is_signed ? signed_a < signed_b : a < b;
  switch (meeting.request) {
    case Request::reduce_add:
      return a + b;
    case Request::reduce_min:
      return less ? a : b;
    case Request::reduce_max:
      return less ? b : a;
    case Request::reduce_and:
      return a & b;
    case Request::reduce_or:
      return a | b;
    default:
      return a ^ b;
  }
}

void reduce(const Warp& warp, std::uint32_t lanes) {
  const auto first = static_cast<std::uint32_t>(std::countr_zero(lanes));
  auto total = static_cast<std::uint32_t>(warp.lane(first).meeting.value);
  for (std::uint32_t i = first + 1; i < warp.count; ++i)
    if (lanes >> i & 1)
      total = reduced(warp.lane(i).meeting, total, static_cast<std::uint32_t>(warp.lane(i).meeting.value));
  for (std::uint32_t i = 0; i < warp.count; ++i)
    if (lanes >> i & 1) warp.lane(i).meeting.result = total;
}

/// bar.warp.sync: each knows what the others did before.
void synchronise(const Warp& warp, std::uint32_t lanes) {
  std::uint32_t clock = 0;
  std::array<std::uint32_t, 32> seen{};
  Known known, released;
  for (std::uint32_t i = 0; i < warp.count; ++i) {
    if (!(lanes >> i & 1)) continue;
    const Thread& thread = warp.lane(i);
    clock = std::max(clock, thread.clock + 1);
    for (std::uint32_t other = 0; other < 32; ++other)
      seen[other] = std::max(seen[other], thread.warp_seen[other]);
    known = join(known, thread.known);
    released = join(released, thread.released);
  }
  for (std::uint32_t i = 0; i < warp.count; ++i)
    if (lanes >> i & 1) seen[i] = clock;
  for (std::uint32_t i = 0; i < warp.count; ++i) {
    if (!(lanes >> i & 1)) continue;
    Thread& thread = warp.lane(i);
    thread.clock = clock, thread.warp_seen = seen, thread.known = known, thread.released = released;
  }
}

void answer(const Warp& warp, std::uint32_t lanes, Request request) {
  if (request == Request::sync) return synchronise(warp, lanes);
  if (request >= Request::reduce_add) return reduce(warp, lanes);
  if (request >= Request::vote_all && request <= Request::ballot) return vote(warp, lanes);
  for (std::uint32_t i = 0; i < warp.count; ++i) {
    if (!(lanes >> i & 1)) continue;
    if (request < Request::vote_all)
      shuffle(warp, lanes, i);
    else
      match(warp, lanes, i);
  }
}

std::string list(std::uint32_t lanes) {
  std::string text;
  for (std::uint32_t i = 0; i < 32; ++i)
    if (lanes >> i & 1) text += (text.empty() ? "" : ", ") + std::to_string(i);
  return text;
}

}  // namespace

bool meet_in_warp(Block& block, std::uint32_t number) {
  const Warp warp = warp_of(block, number);
  bool met = false;
  for (std::uint32_t i = 0; i < warp.count; ++i) {
    if (warp.state(i) != State::in_warp) continue;
    const Thread& thread = warp.lane(i);
    if (!(thread.meeting.mask >> i & 1))
      fault(thread, "the mask does not name lane " + std::to_string(i) + ", its own");
    const std::uint32_t lanes = awaited(warp, thread.meeting.mask);
    if (arrived(warp, thread.meeting) != lanes) continue;
    answer(warp, lanes, thread.meeting.request);
    for (std::uint32_t other = 0; other < warp.count; ++other)
      if (lanes >> other & 1) warp.state(other) = State::ready;
    met = true;
  }
  return met;
}

void explain_missing_lanes(const Block& block, const Thread& thread) {
  const Warp warp = warp_of(const_cast<Block&>(block), thread.warp());
  const std::uint32_t missing = awaited(warp, thread.meeting.mask) & ~arrived(warp, thread.meeting);
  const auto first = static_cast<std::uint32_t>(std::countr_zero(missing));
  const Thread& absent = warp.lane(first);
  fault(thread, "lanes that its mask names do not come: " + list(missing) + "; lane " +
                    std::to_string(first) + " waits at line " + std::to_string(absent.meeting.line));
}

}  // namespace ptx
