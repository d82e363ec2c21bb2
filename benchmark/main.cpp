// SPDX-License-Identifier: BSD-3-Clause
// Measures the floor, our own pipeline and the methods it is compared with on one simulated image. Options are those of
// Google Benchmark, and --large for an image of ten million points.
#include "cases.h"
#include "report.h"

#include <benchmark/benchmark.h>
#include <sys/resource.h>
#include <cstdio>
#include <cstring>

int main(int argc, char** argv) {
  int largest = 1000000, kept = 0;
  for (int i = 0; i < argc; ++i) {
    if (std::strcmp(argv[i], "--large") == 0) {
      largest = 10000000;
    } else {
      argv[kept++] = argv[i];
    }
  }
  argc = kept;
  ppc::bench::addFloor();
  ppc::bench::addPipeline();
  ppc::bench::addMessages();
  ppc::bench::addBaselines();
  ppc::bench::addSizes(largest);
  ppc::bench::addThreads();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  ppc::bench::TableReporter reporter;
  if (benchmark::RunSpecifiedBenchmarks(&reporter) == 0) {
    std::fprintf(stderr, "no benchmark of that name\n");
    return 1;
  }
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  std::printf("\nPeak memory of the process: %.0f MB\n", 1e-3 * static_cast<double>(usage.ru_maxrss));
  return 0;
}
