// SPDX-License-Identifier: BSD-3-Clause
#include "pcd_header.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <stdexcept>
#include <vector>

namespace ppc {
namespace {

constexpr double kBestCompression = 90.0;  // of LZF, at the most
constexpr double kMostBytesOfPoint = 1e6;
constexpr double kMostPoints = 1e8;  // as of messages: more are a corrupt size, or would eat the memory
const char* const kKeys[] = {"VERSION", "FIELDS", "SIZE", "TYPE", "COUNT", "WIDTH", "HEIGHT", "VIEWPOINT", "POINTS", "DATA"};

using Words = std::vector<std::string>;
using Header = std::map<std::string, Words>;

[[noreturn]] void fail(const std::string& path, const std::string& cause) { throw std::runtime_error(path + ": " + cause); }

// The lines up to DATA; leaves `in` at the first byte after them.
Header readLines(const std::string& path, std::istream& in) {
  Header header;
  std::string line;
  for (int n = 0; n < 100 && std::getline(in, line) && line.size() < 10000; ++n) {
    std::istringstream words(line);
    std::string key;
    words >> key;
    if (key.empty() || key[0] == '#') continue;
    const bool known = std::find(std::begin(kKeys), std::end(kKeys), key) != std::end(kKeys);
    if (!known) fail(path, "is not a PCD file (line " + std::to_string(n + 1) + " of its header is none)");
    Words values;
    for (std::string word; words >> word;) values.push_back(word);
    if (!header.emplace(key, values).second) fail(path, "has two lines " + key + " in its header");
    if (key == "DATA") return header;
  }
  fail(path, "is not a PCD file (no complete header)");
}

// Whole numbers of at least `least`, one for each word.
std::vector<double> numbers(const std::string& path, const Header& header, const std::string& key, double least) {
  std::vector<double> values;
  const auto found = header.find(key);
  if (found == header.end()) fail(path, "is not a PCD file (no " + key + " in its header)");
  for (const std::string& word : found->second) {
    const bool whole = word.find_first_not_of("0123456789") == std::string::npos && word.size() < 16;
    const double value = whole ? std::stod(word) : -1.0;
    if (value < least) fail(path, std::string("has ").append(key).append(" ").append(word) + " in its header");
    values.push_back(value);
  }
  return values;
}

double number(const std::string& path, const Header& header, const std::string& key) {
  const std::vector<double> values = numbers(path, header, key, 0.0);
  if (values.size() != 1) fail(path, "has " + std::to_string(values.size()) + " values of " + key + " in its header");
  return values.front();
}

struct PointSize {
  double values = 0.0;
  double bytes = 0.0;
};

PointSize pointSize(const std::string& path, const Header& header) {
  const auto fields = header.find("FIELDS");
  const std::size_t n = fields == header.end() ? 0 : fields->second.size();
  const std::vector<double> sizes = numbers(path, header, "SIZE", 1.0);
  const std::vector<double> counts =
      header.count("COUNT") != 0 ? numbers(path, header, "COUNT", 1.0) : std::vector<double>(n, 1.0);
  const auto types = header.find("TYPE");
  if (n == 0 || sizes.size() != n || counts.size() != n || types == header.end() || types->second.size() != n) {
    fail(path, "is not a PCD file (FIELDS, SIZE, TYPE and COUNT differ in length)");
  }
  PointSize size;
  for (std::size_t i = 0; i < n; ++i) {
    const std::string kind = types->second[i] + std::to_string(static_cast<int>(std::min(sizes[i], 99.0)));
    if (std::string(" F4 F8 I1 I2 I4 I8 U1 U2 U4 U8 ").find(" " + kind + " ") == std::string::npos) {
      fail(path, "has a field of TYPE and SIZE " + kind + ", which no PCD file has");
    }
    size.values += counts[i];
    size.bytes += counts[i] * sizes[i];
  }
  if (size.bytes > kMostBytesOfPoint) fail(path, "is truncated or no PCD file: its points are too large");
  return size;
}

// Whether VIEWPOINT, position and quaternion (w first), is the origin or missing.
bool seenFromOrigin(const Header& header) {
  constexpr double kTurn = 5e-4;  // half an angle [rad]
  const auto found = header.find("VIEWPOINT");
  if (found == header.end()) return true;
  double values[7] = {};
  if (found->second.size() != std::size(values)) return false;
  for (std::size_t i = 0; i < std::size(values); ++i) {
    const std::string& word = found->second[i];
    char* end = nullptr;
    values[i] = std::strtod(word.c_str(), &end);
    if (end != word.c_str() + word.size()) return false;
  }
  const double away = std::abs(values[0]) + std::abs(values[1]) + std::abs(values[2]);
  const double turned = std::abs(values[4]) + std::abs(values[5]) + std::abs(values[6]);
  return away < 1e-5 && turned < kTurn * std::abs(values[3]);  // not if any is NaN
}

}  // namespace

bool checkPcdHeader(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) fail(path, "cannot be read");
  const Header header = readLines(path, in);
  const std::string data = header.at("DATA").empty() ? "" : header.at("DATA").front();
  if (data != "ascii" && data != "binary" && data != "binary_compressed") fail(path, "has DATA '" + data + "'");
  const PointSize point = pointSize(path, header);
  const double width = number(path, header, "WIDTH"), height = number(path, header, "HEIGHT");
  const double points = header.count("POINTS") != 0 ? number(path, header, "POINTS") : width * height;
  if (width * height < 1 || points < 1) fail(path, "holds no points");

  const double left = static_cast<double>(std::filesystem::file_size(path)) - static_cast<double>(in.tellg());
  const double pixels = std::max(points, width * height);
  // Binary needs all its bytes, ascii two a value but for the last line's end.
  double needed = pixels * point.bytes;
  if (data == "ascii") needed = 2 * pixels * point.values - 1;
  if (data == "binary_compressed") needed = 8 + needed / kBestCompression;
  if (!(needed <= left)) {
    std::ostringstream cause;
    cause << "is truncated: its header promises " << pixels << " points, but only " << left << " bytes follow";
    fail(path, cause.str());
  }
  if (points > kMostPoints) fail(path, "holds more than 100000000 points");
  if (points != width * height) fail(path, "has POINTS that are not WIDTH times HEIGHT");
  if (height <= 1) fail(path, "is not organised (height 1); the neighbourhood of points is needed");
  if (data == "binary_compressed") {
    std::uint32_t sizes[2] = {0, 0};  // compressed and not
    in.read(reinterpret_cast<char*>(sizes), sizeof sizes);
    if (sizes[0] > left - 8 || sizes[1] != pixels * point.bytes)
      fail(path, "is truncated: its compressed size is not right");
  }
  return seenFromOrigin(header);
}

}  // namespace ppc
