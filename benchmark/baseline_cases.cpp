// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/baselines/plane_segmenter.h"

#include "cases.h"
#include "measure.h"
#include "workload.h"

#include <memory>

namespace ppc::bench {

void addBaselines() {
  for (const std::string& name : segmenterNames()) {
    const Effort effort{0.0, name == "ppc" ? 9 : 3};  // the others take seconds
    addBenchmark("baseline/" + name, kStandardPoints, effort, [name]() -> Frame {
      const auto grid = std::make_shared<const BeamGrid>(toBeamGrid(officeImage()));
      const std::shared_ptr<PlaneSegmenter> method = makeSegmenter(name);
      return [grid, method](std::vector<StageTime>& stages) {
        LabelImage labels = method->label(*grid, Config(), &stages);
        benchmark::DoNotOptimize(labels.labels.data());
      };
    });
  }
}

}  // namespace ppc::bench
