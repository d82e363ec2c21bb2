// SPDX-License-Identifier: BSD-3-Clause
#include "report.h"

#include <algorithm>
#include <cstdio>

namespace ppc::bench {
namespace {

constexpr char kFloor[] = "floor/fits";
constexpr char kStage[] = "stage:";

bool startsWith(const std::string& text, const std::string& prefix) { return text.compare(0, prefix.size(), prefix) == 0; }

std::string format(const char* how, double value) {
  char text[64];
  std::snprintf(text, sizeof(text), how, value);
  return text;
}

std::string ratio(double value, double to) { return to > 0.0 ? format("%.1f", value / to) : "-"; }

}  // namespace

bool TableReporter::ReportContext(const Context& context) {
  std::fprintf(stderr, "%d processors, load %.2f\n", context.cpu_info.num_cpus,
               context.cpu_info.load_avg.empty() ? 0.0 : context.cpu_info.load_avg.front());
  return true;
}

void TableReporter::ReportRuns(const std::vector<Run>& runs) {
  for (const Run& run : runs) {
    if (run.run_type != Run::RT_Iteration) continue;
    if (run.error_occurred) {
      std::fprintf(stderr, "%s: %s\n", run.benchmark_name().c_str(), run.error_message.c_str());
      continue;
    }
    Result result{run.run_name.function_name, {}};
    for (const auto& [name, counter] : run.counters) result.counters[name] = counter.value;
    std::fprintf(stderr, "%-40s %10.3f ms, median of %lld\n", result.name.c_str(), result.counters["median_ms"],
                 static_cast<long long>(run.iterations));
    results_.push_back(std::move(result));
  }
}

double TableReporter::milliseconds(const std::string& name) const {
  for (const Result& result : results_) {
    if (result.name == name) return result.counters.at("median_ms");
  }
  return 0.0;
}

std::vector<TableReporter::Result> TableReporter::group(const std::string& prefix) const {
  std::vector<Result> found;
  for (const Result& result : results_) {
    if (startsWith(result.name, prefix)) found.push_back({result.name.substr(prefix.size()), result.counters});
  }
  return found;
}

void TableReporter::printTimes(const std::string& title, const std::string& prefix, const std::string& rival) const {
  const std::vector<Result> results = group(prefix);
  if (results.empty()) return;
  std::printf("\n| %s | median ms | fastest ms | x floor |%s allocations a frame | MB allocated | peak MB |\n",
              title.c_str(), rival.empty() ? "" : " x ppc |");
  std::printf("| --- | ---: | ---: | ---: |%s ---: | ---: | ---: |\n", rival.empty() ? "" : " ---: |");
  for (const Result& r : results) {
    const double median = r.counters.at("median_ms");
    std::printf("| %s | %.3f | %.3f | %s |", r.name.c_str(), median, r.counters.at("fastest_ms"),
                ratio(median, milliseconds(kFloor)).c_str());
    if (!rival.empty()) std::printf(" %s |", ratio(median, milliseconds(rival)).c_str());
    std::printf(" %.0f | %.2f | %.2f |\n", r.counters.at("allocations"), 1e-6 * r.counters.at("allocated_bytes"),
                1e-6 * r.counters.at("peak_bytes"));
  }
}

void TableReporter::printStages() const {
  for (const Result& r : group("ppc/")) {
    if (r.name != "ranges to polygons") continue;
    std::printf("\n| stage of %s | median ms | fastest ms | x floor (fastest) |\n| --- | ---: | ---: | ---: |\n",
                r.name.c_str());
    for (const auto& [name, value] : r.counters) {
      if (!startsWith(name, kStage)) continue;
      const double fastest = r.counters.at("fastest:" + name.substr(sizeof(kStage) - 1));
      std::printf("| %s | %.3f | %.3f | %s |\n", name.substr(name.find(' ') + 1).c_str(), value, fastest,
                  ratio(fastest, milliseconds(kFloor)).c_str());
    }
  }
}

void TableReporter::printSizes() const {
  constexpr char kCase[] = "/ranges to polygons";
  const std::vector<Result> results = group("size/");
  if (std::none_of(results.begin(), results.end(),
                   [&](const Result& r) { return r.name.find(kCase) != std::string::npos; })) {
    return;
  }
  std::printf("\n| points | floor ms | ranges to polygons ms | ns a point | x floor | peak MB |\n");
  std::printf("| ---: | ---: | ---: | ---: | ---: | ---: |\n");
  for (const Result& r : results) {
    const std::size_t at = r.name.find(kCase);
    if (at == std::string::npos) continue;
    const double floor = milliseconds("size/" + r.name.substr(0, at) + "/floor");
    const double median = r.counters.at("median_ms");
    std::printf("| %.0f | %s | %.3f | %.1f | %s | %.2f |\n", r.counters.at("points"),
                floor > 0.0 ? format("%.3f", floor).c_str() : "-", median, 1e6 * median / r.counters.at("points"),
                ratio(median, floor).c_str(), 1e-6 * r.counters.at("peak_bytes"));
  }
}

void TableReporter::printThreads() const {
  const std::vector<Result> results = group("threads/");
  if (results.empty()) return;
  std::printf("\n| threads | median ms | fastest ms | times as fast (medians) | (fastest) |\n");
  std::printf("| ---: | ---: | ---: | ---: | ---: |\n");
  const bool has_one = results.front().name == "1";
  const auto timesAsFast = [&](const Result& r, const char* counter) {
    return has_one ? format("%.2f", results.front().counters.at(counter) / r.counters.at(counter)) : std::string("-");
  };
  for (const Result& r : results) {
    std::printf("| %s | %.3f | %.3f | %s | %s |\n", r.name.c_str(), r.counters.at("median_ms"), r.counters.at("fastest_ms"),
                timesAsFast(r, "median_ms").c_str(), timesAsFast(r, "fastest_ms").c_str());
  }
}

void TableReporter::Finalize() {
  printTimes("floor", "floor/", "");
  printTimes("the whole", "ppc/", "");
  printStages();
  printTimes("messages", "message/", "");
  printTimes("labels by", "baseline/", "baseline/ppc");
  printSizes();
  printThreads();
}

}  // namespace ppc::bench
