// SPDX-License-Identifier: BSD-3-Clause
// A fuzz target without a fuzzer: its corpus, and seeded mutations of it, through the same entry.
#include "entry.h"

#include <gtest/gtest.h>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <random>
#include <string>

namespace ppc::fuzz {
namespace {

using Bytes = std::vector<std::uint8_t>;

const std::map<std::string, Bytes>& corpus() {
  static const std::map<std::string, Bytes> files = [] {
    std::map<std::string, Bytes> all;
    for (const auto& entry : std::filesystem::directory_iterator(PPC_FUZZ_CORPUS)) {
      std::ifstream in(entry.path(), std::ios::binary);
      all[entry.path().filename().string()] = Bytes(std::istreambuf_iterator<char>(in), {});
    }
    return all;
  }();
  return files;
}

// The libraries' distributions differ, the engine does not.
// cppcheck-suppress constParameter
std::size_t below(std::size_t n, std::mt19937& random) { return n == 0 ? 0 : random() % n; }

void mutate(Bytes& bytes, const Bytes& other, std::mt19937& random) {
  const std::size_t at = below(bytes.size(), random);
  const auto position = bytes.begin() + static_cast<std::ptrdiff_t>(at);
  switch (below(6, random)) {
    case 0:
      bytes.resize(at);
      break;
    case 1:
      bytes.insert(position, static_cast<std::uint8_t>(random()));
      break;
    case 2:
      bytes.erase(position,
                  position + static_cast<std::ptrdiff_t>(below(std::min<std::size_t>(9, bytes.size() - at), random)));
      break;
    case 3: {
      const auto from = other.begin() + static_cast<std::ptrdiff_t>(below(other.size(), random));
      bytes.erase(position, bytes.end());
      bytes.insert(bytes.end(), from, other.end());
      break;
    }
    case 4:
      if (!bytes.empty()) *position = random() % 2 == 0 ? 0 : 255;
      break;
    default:
      if (!bytes.empty()) *position = static_cast<std::uint8_t>(random());
  }
}

TEST(Corpus, KeepsEveryPromise) {
  ASSERT_FALSE(corpus().empty());
  for (const auto& [name, bytes] : corpus()) {
    EXPECT_NO_THROW(run(Input(bytes.data(), bytes.size()))) << name;
  }
}

// As many as fit into the seconds of PPC_FUZZ_SECONDS (default 4): always the same ones, in the same order.
TEST(Corpus, MutationsKeepEveryPromise) {
  const char* seconds = std::getenv("PPC_FUZZ_SECONDS");
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(seconds != nullptr ? std::atoi(seconds) : 4);
  std::mt19937 random(1);
  std::vector<const std::pair<const std::string, Bytes>*> files;
  for (const auto& file : corpus()) files.push_back(&file);
  int runs = 0;
  while (std::chrono::steady_clock::now() < end) {
    const auto& [name, original] = *files[below(files.size(), random)];
    Bytes bytes = original;
    for (std::size_t n = 1 + below(4, random); n > 0; --n) mutate(bytes, files[below(files.size(), random)]->second, random);
    ASSERT_NO_THROW(run(Input(bytes.data(), bytes.size()))) << "mutation " << runs << ", of " << name;
    ++runs;
  }
  RecordProperty("runs", runs);
  EXPECT_GT(runs, 20);
}

}  // namespace
}  // namespace ppc::fuzz
