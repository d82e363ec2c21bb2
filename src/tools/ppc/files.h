// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>

#include <functional>
#include <string>
#include <vector>

namespace ppc {

/// @brief Throws std::runtime_error "FILE: cause" unless `path` is a readable, regular, non-empty file.
void requireReadableFile(const std::string& path);

/// @brief Throws std::runtime_error naming `path` if it is something other than a regular file, or no file can be made in
/// its folder. An empty path is fine.
void requireWritable(const std::string& path);

/// @brief Throws std::runtime_error naming an output that is one of the inputs, or is given twice. Empty paths are fine.
void requireDistinct(const std::vector<std::string>& inputs, const std::vector<std::string>& outputs);

/// @brief Lets `write` fill a file beside `path` and renames it to `path` when it has succeeded, so that no output is ever
/// half written; a program that is interrupted removes what it had begun. The temporary name keeps the extension. @throws
/// std::runtime_error naming `path`; what `write` throws passes.
void writeAtomically(const std::string& path, const std::function<void(const std::string& temporary)>& write);

/// @brief Writes text, whole or not at all. An empty path writes nothing. @throws std::runtime_error naming the file.
void writeText(const std::string& path, const std::string& text);

/// @brief The same for a picture; the extension chooses the format. An empty path writes nothing.
void writeImage(const std::string& path, const cv::Mat& image);

/// @brief While it lives, stderr leads nowhere: for libraries that write there what they also report as an error. For one
/// thread.
class Quiet {
 public:
  Quiet();
  ~Quiet();
  Quiet(const Quiet&) = delete;
  Quiet& operator=(const Quiet&) = delete;

 private:
  int stderr_;
};

/// @brief OUT.png of image 3 of several -> OUT-0003.png; of a single image, or an empty path: unchanged.
std::string numbered(const std::string& path, int index, bool several);

}  // namespace ppc
