// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/region_merging.h"

#include "patch_plane_clustering/core/block_moments.h"
#include "patch_plane_clustering/core/parallel.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <utility>

namespace ppc {
namespace {

constexpr double kWholeTolerance = 1.5;  // tolerance over a whole region over that from patch to patch
constexpr double kStepTolerance = 1.0;   // tolerance of a step along a border, likewise
constexpr double kMaxRadius = 0.5;       // of a region, for the tolerance of its angle [m]
// Regions turned by less, in tolerances of the angle, may be one bowed wall. For them:
constexpr double kHardlyTurned = 10.0;
constexpr double kWholeTurn = 4.0;     // tolerance of the angle over a whole region over that from patch to patch
constexpr double kMaxBowRadius = 1.0;  // the radius for it [m]
constexpr double kBowTurn = 0.14;      // largest angle between two parts of one bowed surface [rad]
constexpr double kWideRadius = 8.0;    // least radius of a wide bow [m]
constexpr double kBowEvidence = 1.5;   // least misfit of the planes of both parts at the border over that of one plane there
constexpr double kWideEvidence = 1.1;  // likewise, for parts of a wide bow
constexpr double kBowSignificance = 25.0;  // far beyond chi-square with 3 degrees of freedom
constexpr int kBorderSteps = 2;            // depth of a border in cells
constexpr int kMinBorderPoints = 6;

using LabelPair = std::pair<std::int32_t, std::int32_t>;

// A label as a whole.
struct Whole {
  Moments moments;
  PlaneFit fit;
};

// One plane for both as wholes. Walls bow: regions that are hardly turned against each other may differ by more.
double wholeSimilarity(const Whole& a, const Whole& b, const PlaneFit& joint, const NoiseModel& noise,
                       const CoplanarityTolerance& tolerance) {
  const Moments& small = a.moments.n < b.moments.n ? a.moments : b.moments;
  const double range = small.mean().norm();
  const double sigma = noise.sigma(range);
  CoplanarityTolerance whole = tolerance.forNoise(sigma);
  whole.sigma_distance *= kWholeTolerance;
  double max_radius = kMaxRadius;
  if (a.fit.normal().dot(b.fit.normal()) > std::cos(kHardlyTurned * tolerance.sigma_angle)) {
    whole.sigma_angle *= kWholeTurn;
    max_radius = kMaxBowRadius;
  }
  whole.inflation = tolerance.inflationOf(small.n);
  return similarity(joint.chi2 - a.fit.chi2 - b.fit.chi2, small.n / (sigma * sigma), std::min(small.radius(), max_radius),
                    secantSquared(joint.a, range), whole);
}

double stepSimilarity(const Moments& a, const Moments& b, const PlaneFit& joint, const NoiseModel& noise,
                      const CoplanarityTolerance& tolerance) {
  const Eigen::Vector3d mean_a = a.mean(), mean_b = b.mean();
  const double gap = joint.normal().dot(mean_a - mean_b);
  const double range = 0.5 * (mean_a.norm() + mean_b.norm());
  const double sigma = noise.sigma(range);
  const double variance =
      sigma * sigma / secantSquared(joint.a, range) * (tolerance.inflationOf(a.n) / a.n + tolerance.inflationOf(b.n) / b.n);
  const double step = kStepTolerance * tolerance.forNoise(sigma).sigma_distance;
  return std::exp(-0.5 * gap * gap / (variance + step * step));
}

// One bowed surface (a sagging floor, a wall that is not flat): turned a little, and smooth where the two meet. At a crease
// the planes of the wholes fit their sides of the border best; across a bow, one plane of its own fits the border better.
bool isBowed(const Whole& a, const Whole& b, bool wide, const Moments& side_a, const Moments& side_b,
             const CoplanarityTolerance& tolerance) {
  const double crease = chiSquare(side_a, a.fit.a) + chiSquare(side_b, b.fit.a);
  return crease > (wide ? kWideEvidence : kBowEvidence) * fitPlane(side_a + side_b).chi2 +
                      kBowSignificance * tolerance.inflationOf(std::min(side_a.n, side_b.n));
}

// Whether two parts are turned as little, for the distance between them, as those of a ceiling or wall that sags.
bool isWideBow(const Whole& a, const Whole& b) {
  const double angle = std::acos(std::min(1.0, a.fit.normal().dot(b.fit.normal())));
  return (a.moments.mean() - b.moments.mean()).norm() > kWideRadius * angle;
}

// Two labels that meet, at two cells or in one.
struct Meeting {
  std::uint64_t key;  // both labels in one number, quick to sort by
  int cell, other;    // of the lower and the higher label

  static std::uint64_t keyOf(std::int32_t a, std::int32_t b) {
    return static_cast<std::uint64_t>(std::min(a, b)) << 32U | static_cast<std::uint64_t>(std::max(a, b));
  }
  static LabelPair pairOf(std::uint64_t key) {
    return {static_cast<std::int32_t>(key >> 32U), static_cast<std::int32_t>(key & 0xffffffffU)};
  }
};

// Where labels meet in and from cells [begin, end), cell by cell.
std::vector<Meeting> findMeetings(const PatchGrid& cells, const CellLabels& all, int begin, int end) {
  std::vector<Meeting> meetings;
  meetings.reserve(static_cast<std::size_t>(end - begin));
  for (int i = begin; i < end; ++i) {
    if (!isBorderCell(cells, all.only, i)) continue;
    for (int s = all.begin[i]; s < all.begin[i + 1]; ++s) {
      const std::int32_t a = all.labels[s];
      const auto meet = [&](int t, int j) {
        const std::int32_t b = all.labels[t];
        if (a != b) meetings.push_back({Meeting::keyOf(a, b), a < b ? i : j, a < b ? j : i});
      };
      for (int t = s + 1; t < all.begin[i + 1]; ++t) meet(t, i);
      cells.forEachNeighbour(i, [&](int j) {
        if (j < i) return;
        for (int t = all.begin[j]; t < all.begin[j + 1]; ++t) meet(t, j);
      });
    }
  }
  return meetings;
}

// Where labels meet, cell by cell.
std::vector<Meeting> findMeetings(const PatchGrid& cells, const CellLabels& all, int threads) {
  const int count = static_cast<int>(all.only.size()), parts = std::max(1, threads);
  std::vector<std::vector<Meeting>> found(static_cast<std::size_t>(parts));
  forEachPart(threads, parts, [&](int part) {
    found[part] = findMeetings(cells, all, partBegin(count, parts, part), partBegin(count, parts, part + 1));
  });
  for (int part = 1; part < parts; ++part) found[0].insert(found[0].end(), found[part].begin(), found[part].end());
  return std::move(found[0]);
}

// Meetings [begin, end) of the same two labels.
struct MeetingGroup {
  std::uint64_t key;
  int begin, end;
  bool swapped;  // what had the lower label has the higher one now
};

void sortGroups(std::vector<MeetingGroup>& groups) {
  std::sort(groups.begin(), groups.end(),
            [](const MeetingGroup& a, const MeetingGroup& b) { return a.key != b.key ? a.key < b.key : a.begin < b.begin; });
}

// Brings meetings of the same two labels together. @return one group a pair, in ascending pairs.
std::vector<MeetingGroup> groupMeetings(std::vector<Meeting>& meetings) {
  std::vector<MeetingGroup> groups;  // first, those that were found one after the other: far fewer to sort
  const int count = static_cast<int>(meetings.size());
  for (int begin = 0, end = 0; begin < count; begin = end) {
    for (end = begin + 1; end < count && meetings[end].key == meetings[begin].key;) ++end;
    groups.push_back({meetings[begin].key, begin, end, false});
  }
  sortGroups(groups);
  std::vector<Meeting> sorted;
  sorted.reserve(meetings.size());
  std::size_t kept = 0;
  for (const MeetingGroup& group : groups) {
    const int begin = static_cast<int>(sorted.size());
    sorted.insert(sorted.end(), meetings.begin() + group.begin, meetings.begin() + group.end);
    const int end = static_cast<int>(sorted.size());
    if (kept > 0 && groups[kept - 1].key == group.key) {
      groups[kept - 1].end = end;
    } else {
      groups[kept++] = {group.key, begin, end, false};
    }
  }
  groups.resize(kept);
  std::swap(meetings, sorted);
  return groups;
}

// Gives groups the labels' new names, and drops those that have come to be inside of one. One pair may then have several.
void renameGroups(const std::vector<std::int32_t>& now, std::vector<MeetingGroup>& groups) {
  std::size_t kept = 0;
  for (MeetingGroup group : groups) {
    const LabelPair pair = Meeting::pairOf(group.key);
    const std::int32_t a = now[pair.first], b = now[pair.second];
    if (a == b) continue;
    group.key = Meeting::keyOf(a, b);
    group.swapped = group.swapped != (a > b);
    groups[kept++] = group;
  }
  groups.resize(kept);
  sortGroups(groups);
}

// Height of a step, and the points that it is known from: its variance is that of a point over them, and up to four times
// that, as a cell may meet several others.
struct Step {
  double height = 0.0, points = 0.0;
};

// No step, and that for certain: what noise leaves open counts against it, by the larger of these variances.
bool isLevel(const Step& step, double range, const NoiseModel& noise, const CoplanarityTolerance& tolerance,
             double threshold) {
  if (!(step.points > 0.0)) return false;
  const double sigma = noise.sigma(range);
  const double variance = sigma * sigma * tolerance.inflation / step.points;
  const double allowed = kStepTolerance * tolerance.forNoise(sigma).sigma_distance;
  return step.height * step.height + 4.0 * variance <= greatestMisfit(threshold) * allowed * allowed;
}

// Sums both sides of a border: what the two labels have in cells within kBorderSteps of those where they meet.
class BorderSums {
 public:
  BorderSums(const PatchGrid& cells, const CellShares& all, const CellLabels& labels, const std::vector<Meeting>& meetings,
             const std::vector<std::int32_t>& names)
      : cells_(cells), all_(all), labels_(labels), meetings_(meetings), names_(names), reached_(cells.patches.size(), -1) {}

  // Of all meetings of two labels.
  std::pair<Moments, Moments> measure(const LabelPair& pair, const MeetingGroup* begin, const MeetingGroup* end) {
    ++border_;
    wave_.clear();
    const auto take = [&](int i) {
      if (reached_[i] == border_) return;
      reached_[i] = border_;
      wave_.push_back(i);
    };
    forEachMeeting(begin, end, [&](int cell, int other) {
      take(cell);
      take(other);
    });
    std::size_t next = 0;
    for (int step = 0; step < kBorderSteps; ++step) {
      const std::size_t last = wave_.size();
      for (; next < last; ++next) cells_.forEachNeighbour(wave_[next], take);
    }
    std::pair<Moments, Moments> sums;
    for (const int i : wave_) {
      for (int s = all_.begin[i]; s < all_.begin[i + 1]; ++s) {
        const std::int32_t label = names_[labels_.labels[s]];
        if (label == pair.first) sums.first += all_.shares[s].moments;
        if (label == pair.second) sums.second += all_.shares[s].moments;
      }
    }
    return sums;
  }

  /// The step between two labels along a normal, from the nearest of both: where they meet.
  Step measureStep(const LabelPair& pair, const MeetingGroup* begin, const MeetingGroup* end,
                   const Eigen::Vector3d& normal) const {
    Step step;
    forEachMeeting(begin, end, [&](int cell, int other) {
      const Moments a = momentsIn(cell, pair.first), b = momentsIn(other, pair.second);
      if (a.n == 0 || b.n == 0) return;
      const double points = 1.0 / (1.0 / a.n + 1.0 / b.n);
      step.height += points * normal.dot(b.mean() - a.mean());
      step.points += points;
    });
    if (step.points > 0.0) step.height /= step.points;
    return step;
  }

 private:
  // Calls f(cell of the lower label, of the higher).
  template <typename F>
  void forEachMeeting(const MeetingGroup* begin, const MeetingGroup* end, F&& f) const {
    for (const MeetingGroup* group = begin; group != end; ++group) {
      for (int m = group->begin; m < group->end; ++m) {
        const Meeting& at = meetings_[m];
        f(group->swapped ? at.other : at.cell, group->swapped ? at.cell : at.other);
      }
    }
  }

  // What a label, by its name now, has in a cell.
  Moments momentsIn(int cell, std::int32_t label) const {
    Moments sum;
    for (int s = all_.begin[cell]; s < all_.begin[cell + 1]; ++s) {
      if (names_[labels_.labels[s]] == label) sum += all_.shares[s].moments;
    }
    return sum;
  }

  const PatchGrid& cells_;
  const CellShares& all_;
  const CellLabels& labels_;
  const std::vector<Meeting>& meetings_;
  const std::vector<std::int32_t>& names_;
  std::vector<int> reached_;  // the last border that took the cell
  std::vector<int> wave_;
  int border_ = -1;
};

std::vector<Moments> sumShares(const CellShares& cells) {
  std::int32_t highest = 0;
  for (const CellShares::Share& share : cells.shares) highest = std::max(highest, share.label);
  std::vector<Moments> sums(static_cast<std::size_t>(highest) + 1);
  for (const CellShares::Share& share : cells.shares) sums[share.label] += share.moments;
  return sums;
}

// Whether a block of labels has the same everywhere.
bool uniform(const std::int32_t* corner, int rows, int cols, int stride) {
  const LaneMask label = fillMask(*corner);
  const int whole = cols - cols % kLanes;
  LaneMask others = {};
  for (int r = 0; r < rows; ++r) {
    const std::int32_t* row = corner + static_cast<std::ptrdiff_t>(r) * stride;
    for (int c = 0; c < whole; c += kLanes) others |= loadLanes<LaneMask>(row + c) != label;
    for (int c = whole; c < cols; ++c) others[0] |= row[c] ^ *corner;
  }
  return !anyLane(others);
}

// Valid pixels of a label in a cell.
int countPixels(const BeamGrid& grid, const Patch& cell, const LabelImage& labels, std::int32_t label) {
  int count = 0;
  for (int r = cell.row_begin; r < cell.row_end; ++r) {
    for (int i = grid.index(r, cell.col_begin); i < grid.index(r, cell.col_end); ++i) {
      count += labels.labels[i] == label && grid.valid(i) ? 1 : 0;
    }
  }
  return count;
}

// Adds the shares of one cell.
void shareCell(const BeamGrid& grid, const Patch& cell, const Eigen::Vector3d& center, const NoiseModel& noise,
               const LabelImage& labels, std::vector<std::int32_t>& found, CellShares& out) {
  // The usual cases first: one label on all pixels, or none.
  const std::int32_t* corner = labels.labels.data() + grid.index(cell.row_begin, cell.col_begin);
  if (uniform(corner, cell.row_end - cell.row_begin, cell.col_end - cell.col_begin, labels.cols)) {
    if (*corner > 0 && cell.moments.n > 0) out.shares.push_back({*corner, cell.moments});
    return;
  }
  found.clear();
  for (int r = cell.row_begin; r < cell.row_end; ++r) {
    for (int i = grid.index(r, cell.col_begin); i < grid.index(r, cell.col_end); ++i) {
      const std::int32_t label = labels.labels[i];
      if (label > 0 && std::find(found.begin(), found.end(), label) == found.end()) found.push_back(label);
    }
  }
  for (const std::int32_t label : found) {
    if (found.size() == 1 && countPixels(grid, cell, labels, label) == cell.moments.n) {  // the patch's own sums serve
      out.shares.push_back({label, cell.moments});
      continue;
    }
    const BlockSums sums = sumPixels(grid, cell.row_begin, cell.row_end, cell.col_begin, cell.col_end,
                                     [&](int i, int count) { return labelsAt(labels, i, count) == fillMask(label); });
    if (sums.empty) continue;
    const int n = countLanes(sums.counted);
    const BlockMoments<double> block = momentsOf(sums, center);
    const double sigma = noise.sigma(block.ranges / n);
    out.shares.push_back({label, momentsOf(block, 0, n)});
    out.shares.back().moments.scale(1.0 / (sigma * sigma));
  }
}

// Renames the labels of the shares and adds up those that have become one in a cell.
void rename(const std::vector<std::int32_t>& names, CellShares& cells) {
  std::size_t out = 0;
  for (std::size_t k = 0; k + 1 < cells.begin.size(); ++k) {
    const std::size_t first = out;
    const int begin = cells.begin[k], end = cells.begin[k + 1];
    cells.begin[k] = static_cast<int>(first);
    if (end - begin == 1 && static_cast<int>(first) == begin) {  // nothing to move
      cells.shares[first].label = names[cells.shares[first].label];
      ++out;
      continue;
    }
    for (int s = begin; s < end; ++s) {
      const CellShares::Share share = {names[cells.shares[s].label], cells.shares[s].moments};
      std::size_t at = first;
      while (at < out && cells.shares[at].label != share.label) ++at;
      if (at < out) {
        cells.shares[at].moments += share.moments;
      } else {
        cells.shares[out++] = share;
      }
    }
  }
  cells.begin.back() = static_cast<int>(out);
  cells.shares.resize(out);
}

}  // namespace

CellShares shareCells(const BeamGrid& grid, const PatchGrid& cells, const NoiseModel& noise, const LabelImage& labels,
                      int threads) {
  CellShares shares, memory;
  updateShares(grid, cells, noise, labels, std::vector<char>(cells.patches.size(), 1), shares, memory, threads);
  return shares;
}

void shareClusters(const PatchGrid& patches, const std::vector<int>& cluster_of, CellShares& shares) {
  shares.begin.clear();
  shares.shares.clear();
  for (std::size_t k = 0; k < patches.patches.size(); ++k) {
    shares.begin.push_back(static_cast<int>(shares.shares.size()));
    if (cluster_of[k] >= 0) shares.shares.push_back({cluster_of[k] + 1, patches.patches[k].moments});
  }
  shares.begin.push_back(static_cast<int>(shares.shares.size()));
}

CellLabels::CellLabels(const CellShares& shares, int threads)
    : begin(shares.begin), labels(shares.shares.size()), only(shares.begin.size() - 1) {
  forEachRange(threads, static_cast<int>(only.size()), [&](int first, int last) {
    for (int i = first; i < last; ++i) {
      const int share = begin[i], count = begin[i + 1] - share;
      for (int s = share; s < share + count; ++s) labels[s] = shares.shares[s].label;
      only[i] = count == 1 ? labels[share] : count == 0 ? 0 : -1;
    }
  });
}

void updateShares(const BeamGrid& grid, const PatchGrid& cells, const NoiseModel& noise, const LabelImage& labels,
                  const std::vector<char>& changed, CellShares& shares, CellShares& memory, int threads) {
  std::swap(shares, memory);
  const CellShares& before = memory;
  const int count = static_cast<int>(cells.patches.size());
  const int parts = std::max(1, threads);
  std::vector<CellShares> rest(static_cast<std::size_t>(parts - 1));  // the first part's go where all will be
  forEachPart(threads, parts, [&](int part) {
    CellShares& mine = part == 0 ? shares : rest[part - 1];
    mine.begin.clear();
    mine.shares.clear();
    std::vector<std::int32_t> scratch;
    const int part_end = partBegin(count, parts, part + 1);
    for (int k = partBegin(count, parts, part), next = k; k < part_end; k = next) {
      const auto size = static_cast<int>(mine.shares.size());
      if (changed[k] != 0) {
        next = k + 1;
        mine.begin.push_back(size);
        shareCell(grid, cells.patches[k], cells.center, noise, labels, scratch, mine);
        continue;
      }
      while (next < part_end && changed[next] == 0) ++next;
      const int first = before.begin[k];
      for (int same = k; same < next; ++same) mine.begin.push_back(size + before.begin[same] - first);
      mine.shares.insert(mine.shares.end(), before.shares.begin() + first, before.shares.begin() + before.begin[next]);
    }
  });
  for (const CellShares& part : rest) {
    const auto offset = static_cast<int>(shares.shares.size());
    for (const int begin : part.begin) shares.begin.push_back(offset + begin);
    shares.shares.insert(shares.shares.end(), part.shares.begin(), part.shares.end());
  }
  shares.begin.push_back(static_cast<int>(shares.shares.size()));
}

std::vector<Eigen::Vector3d> labelPlanes(const CellShares& cells) {
  const std::vector<Moments> sums = sumShares(cells);
  std::vector<Eigen::Vector3d> planes;
  planes.reserve(sums.size());
  for (const Moments& m : sums) planes.push_back(fitPlane(m).a);
  return planes;
}

std::vector<std::int32_t> mergeShares(const PatchGrid& cells, const NoiseModel& noise, const CoplanarityTolerance& tolerance,
                                      double threshold, CellShares& shares, std::vector<Eigen::Vector3d>& planes,
                                      int threads) {
  const std::vector<Moments> sums = sumShares(shares);
  std::vector<Whole> whole;
  whole.reserve(sums.size());
  for (const Moments& sum : sums) whole.push_back({sum, fitPlane(sum)});
  std::vector<std::int32_t> names(whole.size());
  std::iota(names.begin(), names.end(), 0);
  std::vector<char> fresh(whole.size(), 1);  // pairs of labels that have not changed need no second look
  const CellLabels labels(shares, threads);
  std::vector<Meeting> meetings = findMeetings(cells, labels, threads);
  std::vector<MeetingGroup> groups = groupMeetings(meetings);
  BorderSums borders(cells, shares, labels, meetings, names);
  std::vector<std::pair<double, LabelPair>> candidates;
  while (true) {
    candidates.clear();
    for (std::size_t begin = 0, end = 0; begin < groups.size(); begin = end) {
      const LabelPair pair = Meeting::pairOf(groups[begin].key);
      while (end < groups.size() && groups[end].key == groups[begin].key) ++end;
      if ((fresh[pair.first] | fresh[pair.second]) == 0) continue;
      const Whole& a = whole[pair.first];
      const Whole& b = whole[pair.second];
      const PlaneFit joint = fitPlane(a.moments + b.moments);
      const double s = wholeSimilarity(a, b, joint, noise, tolerance);
      const bool may_bow = a.fit.normal().dot(b.fit.normal()) > std::cos(kBowTurn);
      if (s < threshold && !may_bow) continue;
      const auto [first, second] = borders.measure(pair, &groups[begin], groups.data() + end);
      if (first.n < kMinBorderPoints || second.n < kMinBorderPoints) continue;
      // Over a wide bow, the plane of both leaves the border: a step shows in the nearest of both sides alone.
      const bool level = stepSimilarity(first, second, joint, noise, tolerance) >= threshold;
      const bool wide = may_bow && isWideBow(a, b);
      if (!level && !wide) continue;
      if (!(level && s >= threshold) && !isBowed(a, b, wide, first, second, tolerance)) continue;
      if (!level) {
        const Eigen::Vector3d normal = (a.fit.normal() + b.fit.normal()).normalized();
        const Step step = borders.measureStep(pair, &groups[begin], groups.data() + end, normal);
        if (!isLevel(step, (first + second).mean().norm(), noise, tolerance, threshold)) continue;
      }
      candidates.emplace_back(-s, pair);
    }
    if (candidates.empty()) break;
    std::sort(candidates.begin(), candidates.end());
    std::vector<char> changed(whole.size(), 0);
    std::vector<std::int32_t> now(whole.size());
    std::iota(now.begin(), now.end(), 0);
    for (const auto& [s, pair] : candidates) {
      if ((changed[pair.first] | changed[pair.second]) != 0) continue;
      changed[pair.first] = changed[pair.second] = 1;
      Whole& joined = whole[pair.first];
      joined.moments += whole[pair.second].moments;
      joined.fit = fitPlane(joined.moments);
      now[pair.second] = pair.first;
    }
    for (std::int32_t& label : names) label = now[label];
    renameGroups(now, groups);
    fresh = changed;
  }
  rename(names, shares);
  planes.assign(whole.size(), Eigen::Vector3d::Zero());
  for (const std::int32_t name : names) planes[name] = whole[name].fit.a;
  return names;
}

std::vector<LabelRun> mergeLabels(const PatchGrid& cells, const NoiseModel& noise, const CoplanarityTolerance& tolerance,
                                  double threshold, CellShares& shares, LabelImage& labels,
                                  std::vector<Eigen::Vector3d>& planes, int threads) {
  const std::vector<std::int32_t> names = mergeShares(cells, noise, tolerance, threshold, shares, planes, threads);
  const std::vector<LabelRun> before = labelRuns(labels);
  renameLabels(names, before, labels);
  std::vector<LabelRun> runs;
  runs.reserve(before.size());
  for (const LabelRun& run : before) appendRun({names[run.label], run.begin, run.end}, runs);
  return runs;
}

}  // namespace ppc
