// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <benchmark/benchmark.h>
#include <map>
#include <string>
#include <vector>

namespace ppc::bench {

/// @brief Prints the results as Markdown tables, with ratios to the floor (patch moments and a plane a patch) of the same
/// run.
class TableReporter : public benchmark::BenchmarkReporter {
 public:
  bool ReportContext(const Context& context) override;
  void ReportRuns(const std::vector<Run>& runs) override;
  void Finalize() override;

 private:
  struct Result {
    std::string name;  ///< GROUP/CASE
    std::map<std::string, double> counters;
  };
  double milliseconds(const std::string& name) const;  // 0: was not run
  std::vector<Result> group(const std::string& prefix) const;
  void printTimes(const std::string& title, const std::string& prefix, const std::string& rival) const;
  void printStages() const;
  void printSizes() const;
  void printThreads() const;

  std::vector<Result> results_;
};

}  // namespace ppc::bench
