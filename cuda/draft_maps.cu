#include "cuda/draft_maps.h"

#include <algorithm>

namespace parloc::PARLOC_CUDA_NAMESPACE {
namespace {

/// Some scans; a thread per scan and beam.
struct BeamsOfScans {
  const PlacedScan* placed;
  std::size_t scans, most_drawn;
  DrawRules rules;
  /// visit(scan, beam) for each.
  template <class Visit>
  PARLOC_HD void each(const Thread& me, const Visit& visit) const {
    for (std::size_t k = me.first(); k < scans * most_drawn; k += me.stride()) {
      const PlacedScan& p = placed[k / most_drawn];
      if (k % most_drawn < drawn_beams(p.scan, rules))
        visit(p, drawn_beam(p.scan, k % most_drawn, p.pose, rules));
    }
  }
};

/// The tiles that the scans come to.
struct MarkScans {
  BeamsOfScans beams;
  TileSpan span;
  std::uint8_t* touched;
  PARLOC_HD void operator()(const Thread& me) const {
    beams.each(me, [&](const PlacedScan& p, const DrawnBeam& b) {
      walk_beam(b, MarkTile{span, touched + p.map * span.size()});
    });
  }
};

struct AtomicAdd {
  PARLOC_HD void operator()(CellWord* at, CellWord more) const { atomic_add(at, more); }
};

struct DrawScans {
  BeamsOfScans beams;
  SlamMaps maps;
  PARLOC_HD void operator()(const Thread& me) const {
    beams.each(me, [&](const PlacedScan& p, const DrawnBeam& b) {
      walk_beam(b, DrawCell<AtomicAdd>{&b, maps.of(p.map), {}});
    });
  }
};

/// After a scan of each of the maps: a thread per place of their tables and row. Tiles that some other scan
/// touches are tidied with them, which changes nothing: cells that were tidied stay as they are.
struct TidyTiles {
  const PlacedScan* placed;
  std::size_t scans;
  SlamMaps maps;
  const std::uint8_t* touched;
  PARLOC_HD void operator()(const Thread& me) const {
    const std::size_t size = maps.span.size();
    for (std::size_t k = me.first(); k < scans * size * kTileCells; k += me.stride()) {
      const std::size_t at = placed[k / kTileCells / size].map * size + k / kTileCells % size;
      if (touched[at] != 0) tidy_row(maps.pool.at(maps.table[at]), static_cast<std::int32_t>(k % kTileCells));
    }
  }
};

/// By round the scans that are drawn side by side: the next one of each map.
std::vector<std::vector<PlacedScan>> rounds_of(const std::vector<PlacedScan>& placed, std::size_t maps) {
  std::vector<std::size_t> drawn(maps, 0);
  std::vector<std::vector<PlacedScan>> rounds;
  for (const PlacedScan& p : placed) {
    const std::size_t round = drawn[p.map]++;
    if (round == rounds.size()) rounds.emplace_back();
    rounds[round].push_back(p);
  }
  return rounds;
}

}  // namespace

DraftMaps::DraftMaps(const MatcherRules& rules, Queue& queue) : rules_(rules), queue_(queue), store_(queue) {
  new_tiles_.clear(queue);
}

void DraftMaps::clear() {
  count_ = 0;
  span_ = {};
  store_.set_references(count_references({}, store_.capacity()), queue_);
}

void DraftMaps::cover(const std::vector<ScanDrawing>& drawings) {
  const TileSpan span = span_with(span_, drawings, rules_.draw);
  std::size_t count = count_;
  for (const ScanDrawing& d : drawings) count = std::max(count, d.map + 1);
  if (span.size() == span_.size() && count == count_) return;
  std::vector<std::uint32_t> table =
      moved_tables(table_.to_host(count_ * span_.size(), queue_), span_, span, count_);
  table.resize(count * span.size(), kNoTile);
  table_.from_host(table, queue_);
  queue_.wait();
  touched_.reserve(table.size());
  new_tiles_.reserve(table.size());
  queue_.reserve(table.size());
  span_ = span;
  count_ = count;
}

/// A tile wherever one of the scans will write.
void DraftMaps::make_tiles(std::size_t scans, std::size_t most_drawn) {
  const std::size_t places = count_ * span_.size();
  launch(ClearMarks{touched_.data(), places}, blocks_for(places), queue_);
  launch(MarkScans{{placed_.data(), scans, most_drawn, rules_.draw}, span_, touched_.data()},
         blocks_for(scans * most_drawn), queue_);
  // The maps take the place of the particles.
  SlamArgs args;
  args.maps = maps();
  args.particles.capacity = count_;
  args.touched = touched_.data();
  args.tally = new_tiles_.tally();
  SlamStages::find_new_tiles(args, store_, new_tiles_, queue_);
  if (const SlamTally found = new_tiles_.counted(queue_); found.fits == 0) {
    store_.make_room(static_cast<std::size_t>(found.used + found.needed), queue_);
    SlamStages::find_new_tiles(args, store_, new_tiles_, queue_);
  }
  SlamStages::assign_tiles(args, store_, new_tiles_, queue_);
}

void DraftMaps::draw(const std::vector<ScanDrawing>& drawings) {
  if (drawings.empty()) return;
  cover(drawings);
  std::vector<const BeamTable*> tables;
  for (const ScanDrawing& d : drawings) tables.push_back(d.scan);
  const std::vector<Beams> beams = scans_.upload(tables, queue_);
  std::vector<PlacedScan> placed;
  std::size_t most_drawn = 0;
  for (std::size_t k = 0; k < drawings.size(); ++k) {
    placed.push_back({drawings[k].map, beams[k], match_pose(slam_pose(drawings[k].pose), rules_.match)});
    most_drawn = std::max(most_drawn, drawn_beams(beams[k], rules_.draw));
  }
  const auto rounds = rounds_of(placed, count_);
  placed.clear();
  for (const std::vector<PlacedScan>& round : rounds) placed.insert(placed.end(), round.begin(), round.end());
  placed_.from_host(placed, queue_);
  make_tiles(placed.size(), most_drawn);
  const PlacedScan* first = placed_.data();
  for (const std::vector<PlacedScan>& round : rounds) {
    launch(DrawScans{{first, round.size(), most_drawn, rules_.draw}, maps()},
           blocks_for(round.size() * most_drawn), queue_);
    launch(TidyTiles{first, round.size(), maps(), touched_.data()},
           blocks_for(round.size() * span_.size() * kTileCells), queue_);
    first += round.size();
  }
}

TileMap DraftMaps::view(std::size_t map) const {
  const bool drawn = map < count_;
  return {drawn ? span_ : TileSpan{}, drawn ? table_.data() + map * span_.size() : nullptr, store_.pool()};
}

SlamCells DraftMaps::cells(std::size_t map) const {
  std::vector<std::uint32_t> table(map < count_ ? span_.size() : 0);
  const TileMap drawn = view(map);
  if (!table.empty()) copy_up(table.data(), drawn.table, table.size() * sizeof(std::uint32_t), queue_);
  queue_.wait();
  return gather_cells(drawn.span, table.data(),
                      [&](const std::vector<std::uint32_t>& ids, Tile* to) { store_.read(ids, to, queue_); });
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
