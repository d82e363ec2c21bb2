// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/evaluation/hole_score.h"

#include <algorithm>
#include <iterator>

namespace ppc {
namespace {

// The part of an image that a region spans, with a frame of one pixel around it.
class Silhouette {
 public:
  Silhouette(const LabelImage& labels, std::int32_t id) : labels_(labels) {
    top_ = labels.rows;
    left_ = labels.cols;
    for (int r = 0; r < labels.rows; ++r) {
      for (int c = 0; c < labels.cols; ++c) {
        if (labels.labels[static_cast<std::size_t>(r) * labels.cols + c] != id) continue;
        top_ = std::min(top_, r);
        bottom_ = std::max(bottom_, r);
        left_ = std::min(left_, c);
        right_ = std::max(right_, c);
      }
    }
    if (bottom_ < top_) return;
    --top_, --left_, ++bottom_, ++right_;
    open_.assign(static_cast<std::size_t>(height()) * width(), 1);
    for (int r = top_ + 1; r < bottom_; ++r) {
      for (int c = left_ + 1; c < right_; ++c) {
        if (labels.labels[static_cast<std::size_t>(r) * labels.cols + c] == id) open_[at(r, c)] = 0;
      }
    }
  }

  bool empty() const { return open_.empty(); }
  std::size_t size() const { return open_.size(); }
  bool open(std::size_t i) const { return open_[i] != 0; }

  /// Takes the 4-connected open pixels from one on. @return as indices into the silhouette.
  std::vector<int> flood(int first) {
    std::vector<int> pixels{first};
    open_[first] = 0;
    for (std::size_t head = 0; head < pixels.size(); ++head) {
      const int r = pixels[head] / width(), c = pixels[head] % width();
      const auto visit = [&](int row, int col) {
        if (row < 0 || row >= height() || col < 0 || col >= width()) return;
        const int i = row * width() + col;
        if (open_[i] == 0) return;
        open_[i] = 0;
        pixels.push_back(i);
      };
      visit(r - 1, c);
      visit(r + 1, c);
      visit(r, c - 1);
      visit(r, c + 1);
    }
    return pixels;
  }

  /// Index into the image of an index into the silhouette; only for those inside the frame.
  int imageIndex(int i) const { return (top_ + i / width()) * labels_.cols + left_ + i % width(); }

 private:
  int height() const { return bottom_ - top_ + 1; }
  int width() const { return right_ - left_ + 1; }
  std::size_t at(int r, int c) const { return static_cast<std::size_t>(r - top_) * width() + (c - left_); }

  const LabelImage& labels_;
  int top_ = 0, left_ = 0, bottom_ = -1, right_ = -1;
  std::vector<char> open_;
};

double iou(const Hole& a, const Hole& b) {
  Hole both;
  std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(both));
  return static_cast<double>(both.size()) / static_cast<double>(a.size() + b.size() - both.size());
}

// Whether a hole of the true region `true_id` is left out of, and bounded by, the found region.
bool isOpening(const LabelImage& truth, std::int32_t true_id, const LabelImage& found, std::int32_t found_id,
               const Hole& hole) {
  constexpr double kLeftOut = 0.8, kBounded = 0.5;
  std::vector<int> rim;
  std::size_t outside = 0;
  for (const int i : hole) {
    outside += found.labels[i] != found_id ? 1 : 0;
    // A hole has pixels of its region on all sides: it does not touch the border of the image.
    for (const int j : {i - 1, i + 1, i - truth.cols, i + truth.cols}) {
      if (truth.labels[j] == true_id) rim.push_back(j);
    }
  }
  std::sort(rim.begin(), rim.end());
  rim.erase(std::unique(rim.begin(), rim.end()), rim.end());
  const auto bounding = std::count_if(rim.begin(), rim.end(), [&](int j) { return found.labels[j] == found_id; });
  return static_cast<double>(outside) >= kLeftOut * static_cast<double>(hole.size()) &&
         static_cast<double>(bounding) >= kBounded * static_cast<double>(rim.size());
}

}  // namespace

std::vector<Hole> holesOf(const LabelImage& labels, std::int32_t id, int min_pixels) {
  std::vector<Hole> holes;
  Silhouette silhouette(labels, id);
  if (silhouette.empty()) return holes;
  silhouette.flood(0);  // the frame, and all that is connected with it
  for (std::size_t i = 0; i < silhouette.size(); ++i) {
    if (!silhouette.open(i)) continue;
    Hole hole;
    for (const int pixel : silhouette.flood(static_cast<int>(i))) hole.push_back(silhouette.imageIndex(pixel));
    if (static_cast<int>(hole.size()) < min_pixels) continue;
    std::sort(hole.begin(), hole.end());
    holes.push_back(std::move(hole));
  }
  return holes;
}

HoleScore holeScore(const LabelImage& truth, const LabelImage& found, const RegionOverlap& overlap, int min_pixels) {
  HoleScore score;
  for (std::size_t t = 0; t < overlap.true_ids.size(); ++t) {
    const std::vector<Hole> holes = holesOf(truth, overlap.true_ids[t], min_pixels);
    if (holes.empty()) continue;
    score.true_holes += static_cast<int>(holes.size());
    const auto& common = overlap.common[t];
    const auto most = std::max_element(common.begin(), common.end());
    if (most == common.end() || *most == 0) continue;
    const std::vector<Hole> others = holesOf(found, overlap.found_ids[most - common.begin()], min_pixels / 2);
    for (const Hole& hole : holes) {
      const bool recalled =
          std::any_of(others.begin(), others.end(), [&](const Hole& other) { return iou(hole, other) >= 0.5; });
      score.found_holes += recalled ? 1 : 0;
      const bool opening = isOpening(truth, overlap.true_ids[t], found, overlap.found_ids[most - common.begin()], hole);
      score.found_openings += recalled || opening ? 1 : 0;
    }
  }
  return score;
}

}  // namespace ppc
