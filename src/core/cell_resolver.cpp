// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/cell_resolver.h"

#include "patch_plane_clustering/core/cell_prefetch.h"

#include <algorithm>
#include <cstring>
#include <limits>

namespace ppc {
namespace {

constexpr float kCap = 9.0F;              // squared residual beyond which a point is an outlier: three sigma
constexpr float kMaxWindowCost = 5.0F;    // mean capped cost over the window that a plane may have
constexpr float kMaxOwnResidual = 12.0F;  // squared residual of the point itself

Lanes capped(Lanes squared, LaneMask valid) {
  const Lanes cost = squared < fill(kCap) ? squared : fill(kCap);
  return valid ? cost : Lanes{};
}

}  // namespace

CellResolver::CellResolver(const BeamGrid& grid, const PatchGrid& cells, const std::vector<Eigen::Vector3d>& planes,
                           const NoiseModel& noise, const CoplanarityTolerance& tolerance, ResolverMemory& memory)
    : grid_(grid),
      cells_(cells),
      planes_(planes),
      noise_(noise),
      tolerance_(tolerance),
      center_(cells.center.cast<float>()),
      candidates_(memory.candidates),
      middle_(memory.middle),
      sides_(memory.sides),
      own_(memory.own),
      side_costs_(memory.side_costs),
      across_(memory.across),
      places_(memory.places) {}

CellResiduals CellResolver::residuals(const CellNoise& noise, std::int32_t label) const {
  return CellResiduals(noise, center_, planes_[label].cast<float>());
}

void CellResolver::prefetch(const Patch& cell, const LabelImage& labels) const {
  const int reach = reachOf(cell);
  prefetchCell(grid_, labels, std::max(0, cell.row_begin - reach), std::min(grid_.rows, cell.row_end + reach),
               cell.col_begin);
}

int CellResolver::reachOf(const Patch& cell) const {
  return std::max(1, cells_.strip_rows[cell.col_begin / cells_.strip_cols] / cells_.strip_cols);
}

bool CellResolver::resolve(const Patch& cell, const std::vector<std::int32_t>& candidates, std::int32_t first_open,
                           bool keep, LabelImage& out) {
  const int pixel = middlePixel(grid_, cell);
  if (pixel < 0) return false;
  const CellNoise noise = noiseOf(pixel);
  candidates_.clear();
  for (const std::int32_t label : candidates) candidates_.push_back({label, residuals(noise, label), false});
  layOut(cell);
  bool any = false;
  for (int col = cell.col_begin; col < cell.col_end; col += kLanes) {
    // A cell that ends amid the lanes has the column right of it in the next of them.
    const int lanes = std::min(cell.col_end - col + 1, grid_.cols - col);
    readRows(col, lanes, reach_, last_);
    openPlaces(cell, col, first_open, keep, out);
    if (keep && !findUndecided(out.labels[pixel])) continue;  // as most are amid their own plane
    readWindow(cell, col, lanes);
    for (std::size_t k = 0; k < candidates_.size(); ++k) compete(k);
    any = paint(cell, col, out) || any;
  }
  return any;
}

void CellResolver::layOut(const Patch& cell) {
  reach_ = reachOf(cell);
  top_ = cell.row_begin - reach_;
  last_ = cell.row_end - top_;
  const auto rows = static_cast<std::size_t>(last_ + reach_), all = candidates_.size() * rows;
  if (middle_.size() < rows) {
    middle_.resize(rows);
    across_.resize(rows);
    places_.resize(rows);
    side_costs_.resize(2 * rows + 2);  // an odd number of rows is read as if there were one more
  }
  if (own_.size() < all) own_.resize(all);
  stride_ = rows;
}

void CellResolver::readRows(int col, int lanes, int begin, int end) {
  int i = grid_.index(top_ + begin, col);
  BeamLanes* middle = middle_.data() + begin;
  for (int row = begin; row < end; ++row, i += grid_.cols) {
    *middle++ = lanes >= kLanes ? BeamLanes(grid_, i) : BeamLanes(grid_, i, lanes);
  }
}

void CellResolver::openPlaces(const Patch& cell, int col, std::int32_t first_open, bool keep, const LabelImage& labels) {
  const int count = std::min(kLanes, cell.col_end - col), stride = grid_.cols;
  const LaneMask inside = firstLanes(count), open = fillMask(first_open), kept = keep ? fillMask(-1) : LaneMask{};
  const std::int32_t* now_at = labels.labels.data() + grid_.index(cell.row_begin, col);
  Place* place = places_.data() + reach_;
  Place* const end = places_.data() + last_;
  for (; place != end; ++place, now_at += stride) {
    const LaneMask now = count == kLanes ? loadLanes<LaneMask>(now_at) : loadLanes<LaneMask>(now_at, count);
    place->open = ((now <= LaneMask{}) | (now >= open)) & inside;
    place->winner = now & kept;
    place->undecided = place->open;
    place->best = fill(std::numeric_limits<float>::infinity());
  }
  first_undecided_ = reach_;
  last_undecided_ = last_;
}

// Whether all open pixels with a measurement have a label.
bool CellResolver::isHeldBy(std::int32_t label) const {
  const Place* const places = places_.data();
  const BeamLanes* const middle = middle_.data();
  const LaneMask all = fillMask(label);
  LaneMask others = {};
  for (int row = reach_, end = last_; row < end; ++row) {
    others |= places[row].open & middle[row].valid & (places[row].winner ^ all);
  }
  return !anyLane(others);
}

// Looks for candidates near pixels that have another label: nothing else can change. The residuals of a label that all
// pixels have are not needed for that. @param likely a label that they may have. @return whether there are any.
bool CellResolver::findUndecided(std::int32_t likely) {
  const std::int32_t held = isHeldBy(likely) ? likely : 0;
  Place* const places = places_.data();
  const BeamLanes* const middle = middle_.data();
  const int first = reach_, last = last_;
  for (int row = first; row < last; ++row) places[row].undecided = LaneMask{};
  LaneMask any = {};
  Lanes* own = own_.data();
  for (Candidate& candidate : candidates_) {
    candidate.known = candidate.label != held;
    if (candidate.known) {
      const CellResiduals squared = candidate.squared;
      const LaneMask label = fillMask(candidate.label);
      for (int row = first; row < last; ++row) {
        own[row] = squared(middle[row]);
        const LaneMask rival = places[row].open & (own[row] <= fill(kMaxOwnResidual)) & (places[row].winner != label);
        places[row].undecided |= rival;
        any |= rival;
      }
    }
    own += stride_;
  }
  if (!anyLane(any)) return false;
  while (!anyLane(places[first_undecided_].undecided)) ++first_undecided_;
  while (!anyLane(places[last_undecided_ - 1].undecided)) --last_undecided_;
  return true;
}

// Reads what undecided pixels need beside the cell's own beams, and counts the beams in each pixel's window.
void CellResolver::readWindow(const Patch& cell, int col, int lanes) {
  window_begin_ = std::max(first_undecided_ - reach_, -top_);
  window_end_ = std::min(last_undecided_ + reach_, grid_.rows - top_);
  readRows(col, lanes, window_begin_, std::min(window_end_, reach_));
  readRows(col, lanes, std::max(window_begin_, last_), window_end_);
  // Windows may look beyond the image: nothing is there.
  for (int row = first_undecided_ - reach_; row < window_begin_; ++row) across_[row] = Lanes{};
  for (int row = window_end_; row < last_undecided_ + reach_; ++row) across_[row] = Lanes{};
  const bool left = col > 0, right = cell.col_end - col >= kLanes && col + kLanes < grid_.cols;
  const LaneMask inside = {left ? -1 : 0, right ? -1 : 0, left ? -1 : 0, right ? -1 : 0};
  sides_.clear();
  int i = grid_.index(top_ + window_begin_, col);
  for (int row = window_begin_; row < window_end_; row += 2, i += 2 * grid_.cols) {
    const int below = row + 1 < window_end_ ? i + grid_.cols : i;
    const int pixels[kLanes] = {left ? i - 1 : i, right ? i + kLanes : i, left ? below - 1 : below,
                                right ? below + kLanes : below};
    sides_.emplace_back(grid_, pixels, inside);
  }
  countWindows(inside);
}

// Counts the beams in each undecided pixel's window. @param inside which of the columns beside the cell there are.
void CellResolver::countWindows(LaneMask inside) {
  const BeamLanes* const middle = middle_.data();
  LaneMask all = inside;
  for (const BeamLanes& sides : sides_) all &= sides.valid;
  for (int row = window_begin_; row < window_end_; ++row) all &= middle[row].valid;
  const int window_rows = 2 * reach_ + 1;
  if (window_end_ - window_begin_ == last_undecided_ - first_undecided_ + 2 * reach_ && !anyLane(~all)) {  // as most are
    const Lanes inverse = fill(1.0F / static_cast<float>(3 * window_rows));
    for (int row = first_undecided_; row < last_undecided_; ++row) places_[row].inverse_count = inverse;
    return;
  }
  const auto one = [](LaneMask valid) { return valid ? fill(1.0F) : Lanes{}; };
  for (std::size_t k = 0; k < sides_.size(); ++k) storeLanes(one(sides_[k].valid), &side_costs_[k * kLanes]);
  sumAcross([=](int row) { return one(middle[row].valid); });
  forEachSum([](Place& place, int, Lanes count) { place.inverse_count = 1.0F / (count > fill(1.0F) ? count : fill(1.0F)); });
}

// Sums costs of the middle, cost(row), and of the sides over three columns.
template <typename Cost>
void CellResolver::sumAcross(const Cost& cost) {
  const float* side = side_costs_.data();
  Lanes* const across = across_.data();
  for (int row = window_begin_, end = window_end_; row < end; ++row, side += 2) {
    const Lanes middle = cost(row);
    const Lanes before = __builtin_shufflevector(middle, Lanes{side[0]}, 4, 0, 1, 2);
    const Lanes after = __builtin_shufflevector(middle, Lanes{side[1]}, 1, 2, 3, 4);
    across[row] = before + middle + after;
  }
}

// Calls f(place, its row, sums over each pixel's own window) where there are undecided pixels.
template <typename F>
void CellResolver::forEachSum(const F& f) {
  Place* const places = places_.data();
  const int first = first_undecided_, last = last_undecided_;
  const Lanes* out = across_.data() + first - reach_;
  const Lanes* in = out;
  Lanes sum = {};
  for (const Lanes* const end = out + 2 * reach_ + 1; in != end;) sum += *in++;
  f(places[first], first, sum);
  for (int row = first + 1; row < last; ++row) {
    sum = sum + *in++ - *out++;
    f(places[row], row, sum);
  }
}

// Gives undecided pixels to the k-th candidate where it is likelier than those before.
void CellResolver::compete(std::size_t k) {
  const Candidate& candidate = candidates_[k];
  const CellResiduals squared = candidate.squared;
  const BeamLanes* const middle = middle_.data();
  const Place* const places = places_.data();
  Lanes* const own = &own_[k * stride_];
  const bool known = candidate.known;
  const int first = first_undecided_, last = last_undecided_;
  LaneMask near = {};
  for (int row = first; row < last; ++row) {
    if (!known) own[row] = squared(middle[row]);
    near |= places[row].undecided & (own[row] <= fill(kMaxOwnResidual));
  }
  if (!anyLane(near)) return;
  for (int row = window_begin_, end = known ? reach_ : first; row < end; ++row) own[row] = squared(middle[row]);
  for (int row = known ? last_ : last, end = window_end_; row < end; ++row) own[row] = squared(middle[row]);
  float* side_costs = side_costs_.data();
  for (const BeamLanes& sides : sides_) {
    storeLanes(capped(squared(sides), sides.valid), side_costs);
    side_costs += kLanes;
  }
  sumAcross([=](int row) { return capped(own[row], middle[row].valid); });
  const float log_variance = squared.logVariance();
  const LaneMask label = fillMask(candidate.label);
  forEachSum([=](Place& place, int row, Lanes sum) {
    const Lanes mean = sum * place.inverse_count;
    const Lanes total = mean + log_variance;
    const LaneMask better = (own[row] <= fill(kMaxOwnResidual)) & (mean < fill(kMaxWindowCost)) & (total < place.best);
    place.best = better ? total : place.best;
    place.winner = better ? label : place.winner;
  });
}

// @return whether that changes any label.
bool CellResolver::paint(const Patch& cell, int col, LabelImage& out) const {
  const int count = std::min(kLanes, cell.col_end - col);
  std::int32_t* labels = out.labels.data() + grid_.index(cell.row_begin, col);
  const Place* place = places_.data() + reach_;
  const Place* const end = places_.data() + last_;
  LaneMask changed = {};
  for (const int stride = grid_.cols; place != end; ++place, labels += stride) {
    const LaneMask before = count == kLanes ? loadLanes<LaneMask>(labels) : loadLanes<LaneMask>(labels, count);
    const LaneMask painted = place->open ? place->winner : before;
    changed |= painted ^ before;
    std::memcpy(labels, &painted, sizeof(std::int32_t) * static_cast<std::size_t>(count));
  }
  return anyLane(changed);
}

}  // namespace ppc
