// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <unistd.h>
#include <filesystem>
#include <functional>
#include <stdexcept>
#include <string>

namespace patch_plane_clustering {

/// @brief Lets `write` fill a temporary file beside `path` (same extension) and renames it, so that nobody ever sees half a
/// file. @throws std::runtime_error naming the path; what `write` throws passes through. The temporary file is then removed.
inline void writeWhole(const std::string& path, const std::function<void(const std::string&)>& write) {
  namespace fs = std::filesystem;
  const fs::path target(path);
  const fs::path temporary =
      target.parent_path() / ("." + target.stem().string() + "." + std::to_string(getpid()) + target.extension().string());
  std::error_code ignored;
  try {
    write(temporary.string());
    std::error_code error;
    fs::rename(temporary, target, error);
    if (error) throw std::runtime_error("cannot write " + path + ": " + error.message());
  } catch (...) {
    fs::remove(temporary, ignored);
    throw;
  }
}

/// @brief Throws std::runtime_error naming `path` unless a file can be made in its folder.
inline void requireWritable(const std::string& path) {
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  const std::string name = folder.empty() ? "." : folder.string();
  if (access(name.c_str(), W_OK | X_OK) != 0)
    throw std::runtime_error("cannot write " + path + ": folder " + name + " is missing or not writable");
}

/// @brief OUT.png -> OUT-0003.png, where there are several; the name itself where there is one.
inline std::string numberedPath(const std::string& path, int number, bool several) {
  if (!several) return path;
  std::string digits = std::to_string(number);
  digits.insert(0, digits.size() < 4 ? 4 - digits.size() : 0, '0');
  const std::filesystem::path p(path);
  return (p.parent_path() / (p.stem().string() + "-" + digits + p.extension().string())).string();
}

}  // namespace patch_plane_clustering
