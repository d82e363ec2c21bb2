// SPDX-License-Identifier: BSD-3-Clause
#include "files.h"

#include "output_file.h"

#include <opencv2/imgcodecs.hpp>

#include <filesystem>
#include <fstream>
#include <stdexcept>

namespace patch_plane_clustering {

namespace fs = std::filesystem;

void requireReadableFile(const std::string& path) {
  std::error_code error;
  const auto status = fs::status(path, error);
  if (!fs::exists(status)) throw std::runtime_error(path + ": no such file");
  if (fs::is_directory(status)) throw std::runtime_error(path + ": is a directory");
  if (!fs::is_regular_file(status)) throw std::runtime_error(path + ": is not a regular file");
  if (!std::ifstream(path).good()) throw std::runtime_error(path + ": cannot be read (permission?)");
  if (fs::file_size(path, error) == 0) throw std::runtime_error(path + ": is empty");
}

void writeText(const std::string& path, const std::string& text) {
  if (path.empty()) return;
  requireWritable(path);
  writeWhole(path, [&](const std::string& temporary) {
    std::ofstream out(temporary, std::ios::binary);
    if (!out) throw std::runtime_error(path + ": cannot be written");
    out << text;
    out.close();
    if (!out) throw std::runtime_error(path + ": could not be written to the end (disk full?)");
  });
}

void writeImage(const std::string& path, const cv::Mat& image) {
  if (path.empty()) return;
  requireWritable(path);
  writeWhole(path, [&](const std::string& temporary) {
    bool written = false;
    try {
      written = cv::imwrite(temporary, image);
    } catch (const cv::Exception&) {
      throw std::runtime_error(path + ": is not the name of a picture format that can be written (use .png)");
    }
    if (!written) throw std::runtime_error(path + ": cannot be written");
  });
}

}  // namespace patch_plane_clustering
