// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/core/region_splitting.h"

#include "patch_plane_clustering/core/parallel.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace ppc {
namespace {

constexpr int kFewestCells = 12, kManyCells = 300;
constexpr double kMisfit = 3.0;  // standard deviations of what whole cells stand off a plane, that noise may leave
// Of straight cuts of labels of many cells, chi-square of a point from which on they are looked for, and gain over that of a
// quadratic surface.
constexpr double kLargeMisfit = 1.03, kLargeGain = 1.4;
constexpr double kPlaneCutGain = 1.5;  // of a cut that is straight on the plane alone, over that of a quadratic surface
// Of divisions, gain over that of a quadratic surface: of parallel sides and of others, as strips of what bends more than
// such a surface does are turned against each other.
constexpr double kParallelGain = 1.3, kTurnedGain = 2.2;
constexpr double kDivisionGain = 2.0;  // over that of a straight cut, where there is one that will do
constexpr double kLeastMisfit = 0.98;  // chi-square of a point below which no division is looked for
constexpr double kWinding = 8.0;       // border over the root of a side's cells: a square has 4, what follows lines more
constexpr double kDivisionLeft = 0.3;  // beyond noise, over what a division explains: there may be a third plane
constexpr double kStepLeft = 0.6;      // likewise, if there is a step for certain
constexpr double kStepHeight = 0.6;    // of a step from cell to cell, in the tolerance: those at an edge have part in both
// What tells a crease for certain: largest cosine between the planes, gain over that of a quadratic surface, over what noise
// may leave, and what may be left if it is more than that, over the gain: points of what is beside a label lie along its
// border. In much noise, bows that are not quadratic pass for creases if less is asked.
struct CreaseLimits {
  double cosine, gain, left;
};
constexpr CreaseLimits kCrease{0.9992, 10.0, 0.05}, kFineCrease{0.9976, 4.0, 0.15};  // in general, also of a fine sensor
constexpr double kSignificance = 30.0;  // of a cut, over one plane and one quadratic surface: far beyond chi-square
constexpr double kNoiseError = 0.1;     // of its variance
constexpr double kMostLeft = 3.0;       // beyond noise, over what two planes explain, where there may be a third one
constexpr double kMinSide = 0.25;       // points of a side over those of a region, as in the second pass
// Of divisions where noise is smooth: share of chi-square that the best straight cut must explain for one to be looked for,
// chi-square of a point of the smaller side that they must explain beyond a quadratic surface, over what is left of one, and
// that of one on the other side's plane, unless both are turned by as much; what is left may be more than on the other side,
// where there are three planes.
constexpr double kSmoothCut = 0.03, kSmoothGain = 1.0, kSmoothStep = 10.0, kSmoothCosine = 0.99, kSmoothLeft = 4.0;

using Place = LabelSplitMemory::Place;
using Part = LabelSplitMemory::Part;
using Work = LabelSplitMemory::Work;
using Surface = std::vector<SurfaceCell>;

class LabelSplitter {
 public:
  LabelSplitter(const BeamGrid& grid, const PatchGrid& cells, const NoiseModel& noise, const CoplanarityTolerance& tolerance,
                int smallest, bool merged, LabelSplitMemory& memory, CellShares& shares, LabelImage& labels)
      : grid_(grid),
        cells_(cells),
        noise_(noise),
        tolerance_(tolerance),
        smallest_(smallest),
        smallest_side_(kMinSide * smallest),
        merged_(merged),
        merged_smooth_(merged && (tolerance.isSmooth() || tolerance.alike_around)),
        shares_(shares),
        labels_(labels),
        count_(memory.count),
        begin_(memory.begin),
        next_(memory.next),
        places_(memory.places),
        leaving_(memory.leaving),
        parts_(memory.parts),
        works_(memory.works),
        splits_(memory.splits),
        side_split_(memory.side_split),
        found_(memory.found) {}

  void splitAll(int threads) {
    if (merged_ && !tolerance_.isWhite() && !merged_smooth_) return;
    listPlaces();
    parts_.clear();
    for (std::size_t label = 1; label + 1 < begin_.size(); ++label) {
      parts_.push_back({static_cast<std::int32_t>(label), begin_[label], begin_[label + 1]});
    }
    const std::size_t whole = parts_.size();
    if (splits_.size() < whole) splits_.resize(whole);  // what each has is kept
    found_.resize(whole);
    forEachPart(threads, static_cast<int>(whole), works_,
                [&](int k, Work& work) { found_[k] = findSplit(parts_[k], work, splits_[k]) ? 1 : 0; });
    for (std::size_t k = 0; k < parts_.size(); ++k) {
      const Part part = parts_[k];
      LabelSplit& split = k < whole ? splits_[k] : side_split_;
      if (k < whole ? found_[k] == 0 : !findSplit(part, works_[0], split)) continue;
      const int middle = splitAt(split, part);
      parts_.push_back({part.label, part.begin, middle});
      parts_.push_back({static_cast<std::int32_t>(shares_.sums.size()) - 1, middle, part.end});
    }
  }

 private:
  // Lists the shares of labels that may be split, label by label.
  void listPlaces() {
    count_.assign(shares_.sums.size(), 0);
    forEachPlace([&](int, int s) { ++count_[shares_.labels[s]]; });
    begin_.assign(1, 0);
    for (std::size_t label = 0; label < count_.size(); ++label) {
      const Moments& sum = shares_.sums[label];
      const bool any_size = tolerance_.isWhite() || merged_smooth_;
      const bool may_split =
          count_[label] >= kFewestCells && sum.n >= smallest_ && (any_size || count_[label] <= kManyCells);
      begin_.push_back(begin_.back() + (may_split ? count_[label] : 0));
    }
    next_ = begin_;
    places_.resize(static_cast<std::size_t>(begin_.back()));
    forEachPlace([&](int k, int s) {
      const std::int32_t label = shares_.labels[s];
      if (begin_[label] != begin_[label + 1]) places_[next_[label]++] = {k, s};
    });
  }

  // Calls f(cell, share) for all but those that stand off their plane because points are missing: they stay what they are.
  template <typename F>
  void forEachPlace(const F& f) const {
    const std::vector<char>& truncated = cells_.truncated;
    for (int k = 0; k + 1 < static_cast<int>(shares_.begin.size()); ++k) {
      if (!truncated.empty() && truncated[k] != 0) continue;
      for (int s = shares_.begin[k]; s < shares_.begin[k + 1]; ++s) f(k, s);
    }
  }

  const Moments& momentsOf(const Place& place) const { return shares_.momentsOf(cells_, place.cell, place.share); }

  // Place of a cell in the image, in columns, along both axes.
  float xOf(const Place& place) const { return static_cast<float>(cells_.patches[place.cell].col_begin); }
  float yOf(const Place& place, float aspect) const {
    return aspect * static_cast<float>(cells_.patches[place.cell].row_begin);
  }

  // Columns of a patch over its rows, in the middle of a part.
  float aspectOf(const Part& part) const {
    const int strip = cells_.patches[places_[(part.begin + part.end) / 2].cell].col_begin / cells_.strip_cols;
    return static_cast<float>(cells_.strip_cols) / static_cast<float>(cells_.strip_rows[strip]);
  }

  static int sizeOf(const Part& part) { return part.end - part.begin; }
  static bool isLarge(const Part& part) { return sizeOf(part) > kManyCells; }

  // Chi-square, beyond the average, of what whole cells stand off their planes, planeOf(i). An error of the noise counts
  // once a cell there, not once a point.
  template <typename F>
  double misfitOf(const Part& part, const F& planeOf) const {
    double chi2 = 0.0;
    for (int i = 0; i < sizeOf(part); ++i) {
      const Moments& m = momentsOf(places_[part.begin + i]);
      const double misfit = m.w - planeOf(i).dot(Eigen::Vector3d(m.x, m.y, m.z));
      if (m.w > 0.0) chi2 += misfit * misfit / m.w;
    }
    return chi2 - sizeOf(part);
  }

  // What noise may leave of it.
  static double noiseOf(const Part& part) { return kMisfit * std::sqrt(2.0 * sizeOf(part)); }

  // What two planes leave to explain. Whole cells tell, unless points within them are off by more than an error of the noise
  // makes them, as lines are.
  double leftOf(const Part& part, const LabelSplit& split) const {
    const double left = split.leftOver();
    const double misfit = misfitOf(
        part, [&](int i) -> const Eigen::Vector3d& { return (split.beyond[i] != 0 ? split.high : split.low).fit.a; });
    return left - misfit < kNoiseError * (split.low.sum.n + split.high.sum.n) ? misfit : left;
  }

  // May be called for several parts at a time.
  bool findSplit(const Part& part, Work& work, LabelSplit& split) const {
    if (sizeOf(part) < kFewestCells) return false;
    const bool large = isLarge(part);
    const Moments& all = shares_.sums[part.label];
    if (all.n < smallest_) return false;
    const PlaneFit fit = fitPlane(all);
    if (merged_smooth_) return findSmoothSplit(part, all, fit, work, split);
    const bool is_misfit =
        tolerance_.isWhite() && misfitOf(part, [&](int) -> const Eigen::Vector3d& { return fit.a; }) > noiseOf(part);
    if (large && !is_misfit) return false;
    measureSurface(part, all, fit, 1.0, work);
    const Surface& surface = work.surface;
    const double bow = bowGain(surface);
    const SurfaceCut cut = findCut(surface, bow, large);
    const bool may_cut = cut.gain >= significance() && (!large || fit.chi2 > kLargeMisfit * all.n);
    const bool may_divide = is_misfit && fit.chi2 >= kLeastMisfit * all.n && isDivided(part, cut, significance(), work);
    if (!may_cut && !may_divide) return false;
    const bool is_cut = may_cut && isSplitByCut(part, cut, bow, fit, surface, work.cut);
    const bool is_divided = may_divide && isSplitByDivision(part, work, bow, fit, split);
    const double least = large ? cut.gain : kDivisionGain * cut.gain;
    if (is_cut && !(is_divided && work.division.score() > least)) split = work.cut;
    return is_cut || is_divided;
  }

  // Places of cells and what they are off the plane of a part. @param weight over that of the noise.
  void measureSurface(const Part& part, const Moments& all, const PlaneFit& fit, double weight, Work& work) const {
    const float aspect = aspectOf(part);
    const SurfaceFrame frame(all, fit);
    work.surface.clear();
    for (int i = part.begin; i < part.end; ++i) {
      Moments cell = momentsOf(places_[i]);
      if (weight != 1.0) cell.scale(weight);
      work.surface.push_back({xOf(places_[i]), yOf(places_[i], aspect), frame.measure(cell)});
    }
  }

  // Where noise is smooth, cells are divided as if it were as much larger as it is for the smallest side: else borders would
  // follow its bumps.
  bool findSmoothSplit(const Part& part, const Moments& all, const PlaneFit& fit, Work& work, LabelSplit& split) const {
    const double inflation = tolerance_.inflationOf(smallest_side_);
    measureSurface(part, all, fit, 1.0 / inflation, work);
    const SurfaceCut cut = bestCut(work.surface, smallest_side_);
    if (cut.gain * inflation < kSmoothCut * fit.chi2 || !isDivided(part, cut, kSignificance, work)) return false;
    split.beyond = work.division.beyond;
    if (!fitSides(part, split)) return false;
    const bool low_is_small = split.low.sum.n < split.high.sum.n;
    const LabelSplit::Side &small = low_is_small ? split.low : split.high, &large = low_is_small ? split.high : split.low;
    const double n = small.sum.n, left = small.fit.chi2 / n, left_of_large = large.fit.chi2 / large.sum.n;
    const double gain = inflation * (work.division.score() - bowGain(work.surface));
    const bool is_turned = small.fit.normal().dot(large.fit.normal()) < kSmoothCosine;
    return gain >= kSignificance * tolerance_.inflationOf(n) && gain > kSmoothGain * small.fit.chi2 &&
           left < kSmoothLeft * std::max(1.0, left_of_large) &&
           (is_turned || chiSquare(small.sum, large.fit.a) > kSmoothStep * small.fit.chi2) &&
           split.isBeyond(tolerance_, noise_, fit);
  }

  // Straight in the image or, if there is none that will do, on the plane, where it must explain more, as a curved surface
  // has better ones there.
  SurfaceCut findCut(const Surface& surface, double bow, bool large) const {
    const SurfaceCut cut = bestCut(surface, smallest_side_);
    if (mayCut(cut, bow, large)) return cut;
    const SurfaceCut on_plane = bestCutOnPlane(surface, smallest_side_);
    return on_plane.gain >= std::max(kPlaneCutGain * bow, bow + 2.0 * significance()) ? on_plane : cut;
  }

  bool mayCut(const SurfaceCut& cut, double bow, bool large) const {
    return cut.gain >= bow + significance() && (!large || cut.gain >= kLargeGain * bow);
  }

  double significance() const { return kSignificance * tolerance_.inflationOf(smallest_side_); }

  bool isSplitByCut(const Part& part, const SurfaceCut& cut, double bow, const PlaneFit& fit, const Surface& surface,
                    LabelSplit& split) const {
    const bool large = isLarge(part);
    if (!mayCut(cut, bow, large)) return false;
    split.beyond.clear();
    for (const SurfaceCell& cell : surface) split.beyond.push_back(cut.isBeyond(cell) ? 1 : 0);
    if (!fitSides(part, split) || (large && !split.areParallel())) return false;
    // Two planes leave no more than noise, or not much more than what they explain.
    if (!split.isBeyond(tolerance_, noise_, fit)) return false;
    if (!tolerance_.isWhite()) return split.leftOver() < split.noise(tolerance_);
    return leftOf(part, split) < std::max(split.noise(tolerance_), kMostLeft * split.explained(fit));
  }

  // Whether two planes explain a part far better, with a border that does not wind through noise.
  bool isDivided(const Part& part, const SurfaceCut& cut, double least, Work& work) const {
    linkCells(part, work);
    SurfaceDivision& division = work.division;
    divideSurface(work.surface, work.links, cut, smallest_side_, work.dividing, division);
    if (division.beyond.empty() || !(division.score() >= least)) return false;
    const auto count = static_cast<std::ptrdiff_t>(division.beyond.size());
    const std::ptrdiff_t beyond = std::count(division.beyond.begin(), division.beyond.end(), 1);
    return division.border <= kWinding * std::sqrt(static_cast<double>(std::min(beyond, count - beyond)));
  }

  bool isSplitByDivision(const Part& part, const Work& work, double bow, const PlaneFit& fit, LabelSplit& split) const {
    const SurfaceDivision& division = work.division;
    if (!(division.score() >= bow + significance())) return false;
    split.beyond = division.beyond;
    if (!fitSides(part, split)) return false;
    if (isCrease(split, division, bow)) return true;
    const bool large = isLarge(part), parallel = split.areParallel();
    if (!(division.score() >= (parallel ? kParallelGain : kTurnedGain) * bow) || (large && !parallel)) return false;
    const double left = leftOf(part, split), noise = split.noise(tolerance_);
    if (left < std::max(noise, kDivisionLeft * division.gain) && split.isBeyond(tolerance_, noise_, fit)) return true;
    return parallel && left < std::max(noise, kStepLeft * division.gain) && isStep(part, work, fit);
  }

  // Whether there is a crease for certain: one quadratic surface leaves far more beyond two planes than noise may, and these
  // leave no more than noise may, or a small part of that.
  bool isCrease(const LabelSplit& split, const SurfaceDivision& division, double bow) const {
    const double cosine = split.low.fit.normal().dot(split.high.fit.normal());
    const double noise = split.noise(tolerance_), over_bow = division.gain - bow, left = split.leftOver();
    const auto meets = [&](const CreaseLimits& limits) {
      return cosine < limits.cosine && over_bow > limits.gain * noise && left < std::max(noise, limits.left * over_bow);
    };
    return meets(kCrease) ||
           (meets(kFineCrease) && tolerance_.isFine(noise_.sigma((split.low.sum + split.high.sum).mean().norm())));
  }

  // Whether the border of a division is a step that a fine sensor tells from waves: cells on both sides of it differ
  // already.
  bool isStep(const Part& part, const Work& work, const PlaneFit& fit) const {
    const std::vector<char>& beyond = work.division.beyond;
    const SurfaceLinks& links = work.links;
    Eigen::Vector3d low = Eigen::Vector3d::Zero(), high = Eigen::Vector3d::Zero();
    for (int i = 0; i < sizeOf(part); ++i) {
      if (beyond[i] == 0) continue;
      for (int k = links.begin[i]; k < links.begin[i + 1]; ++k) {
        const int j = links.cells[k];
        if (beyond[j] != 0) continue;
        low += momentsOf(places_[part.begin + j]).mean();
        high += momentsOf(places_[part.begin + i]).mean();
      }
    }
    const int count = work.division.border;
    if (count == 0) return false;
    const double sigma = noise_.sigma((low + high).norm() / (2 * count));
    const double step = std::abs(fit.normal().dot(high - low)) / count;
    return tolerance_.isFine(sigma) && step > kStepHeight * tolerance_.forNoise(sigma).sigma_distance;
  }

  // Which cells of a part share an edge.
  void linkCells(const Part& part, Work& work) const {
    work.index.resize(cells_.patches.size(), -1);
    for (int i = part.begin; i < part.end; ++i) work.index[places_[i].cell] = i - part.begin;
    work.links.begin.assign(1, 0);
    work.links.cells.clear();
    for (int i = part.begin; i < part.end; ++i) {
      cells_.forEachNeighbour(places_[i].cell, [&](int j) {
        if (work.index[j] >= 0) work.links.cells.push_back(work.index[j]);
      });
      work.links.begin.push_back(static_cast<int>(work.links.cells.size()));
    }
    for (int i = part.begin; i < part.end; ++i) work.index[places_[i].cell] = -1;
  }

  // Whether both sides have enough points.
  bool fitSides(const Part& part, LabelSplit& split) const {
    split.low = split.high = LabelSplit::Side();
    for (int i = part.begin; i < part.end; ++i) {
      (split.beyond[i - part.begin] != 0 ? split.high : split.low).sum += momentsOf(places_[i]);
    }
    split.fit();
    return split.smaller() >= smallest_side_;
  }

  // Gives the side of fewer points a new label. @return the first of its places.
  int splitAt(const LabelSplit& split, const Part& part) {
    const Moments &low = split.low.sum, &high = split.high.sum;
    const char leaves = high.n < low.n ? 1 : 0;
    leaving_.clear();
    auto middle = places_.begin() + part.begin;
    for (int i = part.begin; i < part.end; ++i) {
      const Place place = places_[i];
      if (split.beyond[i - part.begin] == leaves) {
        leaving_.push_back(place);
      } else {
        *middle++ = place;
      }
    }
    std::copy(leaving_.begin(), leaving_.end(), middle);
    const auto fresh = static_cast<std::int32_t>(shares_.sums.size());
    shares_.sums[part.label] = leaves != 0 ? low : high;
    shares_.sums.push_back(leaves != 0 ? high : low);
    for (auto place = middle; place != places_.begin() + part.end; ++place) rename(*place, part.label, fresh);
    return static_cast<int>(middle - places_.begin());
  }

  void rename(const Place& place, std::int32_t label, std::int32_t fresh) {
    shares_.labels[place.share] = fresh;
    if (shares_.only[place.cell] == label) shares_.only[place.cell] = fresh;
    const Patch& cell = cells_.patches[place.cell];
    for (int r = cell.row_begin; r < cell.row_end; ++r) {
      const auto row = labels_.labels.begin() + grid_.index(r, 0);
      std::replace(row + cell.col_begin, row + cell.col_end, label, fresh);
    }
  }

  const BeamGrid& grid_;
  const PatchGrid& cells_;
  const NoiseModel& noise_;
  const CoplanarityTolerance& tolerance_;
  int smallest_;
  double smallest_side_;
  bool merged_, merged_smooth_;
  CellShares& shares_;
  LabelImage& labels_;
  std::vector<int>&count_, &begin_, &next_;
  std::vector<Place>&places_, &leaving_;
  std::vector<Part>& parts_;
  std::vector<Work>& works_;
  std::vector<LabelSplit>& splits_;
  LabelSplit& side_split_;
  std::vector<char>& found_;
};

}  // namespace

bool splitLabels(const BeamGrid& grid, const PatchGrid& cells, const NoiseModel& noise,
                 const CoplanarityTolerance& tolerance, int smallest, bool merged, LabelSplitMemory& memory,
                 CellShares& shares, LabelImage& labels, int threads) {
  const std::size_t before = shares.sums.size();
  LabelSplitter(grid, cells, noise, tolerance, smallest, merged, memory, shares, labels).splitAll(threads);
  return shares.sums.size() > before;
}

}  // namespace ppc
