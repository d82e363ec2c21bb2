// SPDX-License-Identifier: BSD-3-Clause
#include "files.h"

#include "interruption.h"

#include <opencv2/imgcodecs.hpp>

#include <fcntl.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <vector>

namespace ppc {

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

void requireWritable(const std::string& path) {
  if (path.empty()) return;
  std::error_code ignored;
  const auto status = fs::status(path, ignored);
  // What is renamed over a device or a pipe takes its place for everybody.
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    throw std::runtime_error(path + ": " + (fs::is_directory(status) ? "is a directory" : "is not a regular file"));
  }
  const fs::path folder = fs::path(path).parent_path();
  const std::string name = folder.empty() ? "." : folder.string();
  if (access(name.c_str(), W_OK | X_OK) == 0) return;
  throw std::runtime_error(path + ": cannot be written, folder " + name + " is missing or not writable");
}

void requireDistinct(const std::vector<std::string>& inputs, const std::vector<std::string>& outputs) {
  const auto same = [](const std::string& a, const std::string& b) {
    std::error_code ignored;
    return !a.empty() && !b.empty() &&
           (fs::equivalent(a, b, ignored) || fs::weakly_canonical(a, ignored) == fs::weakly_canonical(b, ignored));
  };
  for (auto output = outputs.begin(); output != outputs.end(); ++output) {
    for (const std::string& input : inputs) {
      if (same(input, *output)) throw std::runtime_error(*output + ": is the input; the output needs a name of its own");
    }
    for (auto other = outputs.begin(); other != output; ++other) {
      if (same(*other, *output)) throw std::runtime_error(*output + ": is the name of two outputs; each needs its own");
    }
  }
}

void writeAtomically(const std::string& path, const std::function<void(const std::string&)>& write) {
  requireWritable(path);
  const fs::path target(path);
  const fs::path temporary = target.parent_path() / ("." + target.stem().string() + "." + std::to_string(getpid()) + ".tmp" +
                                                     target.extension().string());
  std::error_code error, ignored;
  const RemovedWhenInterrupted guard(temporary.string());
  try {
    write(temporary.string());
  } catch (...) {
    fs::remove(temporary, ignored);
    throw;
  }
  fs::rename(temporary, target, error);
  if (!error) return;
  fs::remove(temporary, ignored);
  throw std::runtime_error(path + ": " + error.message());
}

namespace {

void writeBytes(const std::string& path, const char* bytes, std::size_t size) {
  writeAtomically(path, [&](const std::string& temporary) {
    std::ofstream out(temporary, std::ios::binary);
    if (!out) throw std::runtime_error(path + ": cannot be written");
    out.write(bytes, static_cast<std::streamsize>(size));
    out.close();
    if (!out) throw std::runtime_error(path + ": could not be written to the end (disk full?)");
  });
}

}  // namespace

void writeText(const std::string& path, const std::string& text) {
  if (!path.empty()) writeBytes(path, text.data(), text.size());
}

void writeImage(const std::string& path, const cv::Mat& image) {
  if (path.empty()) return;
  // Encoded in memory: OpenCV's own writer takes a full disk for success.
  std::vector<unsigned char> bytes;
  bool encoded = false;
  try {
    const Quiet quiet;
    encoded = cv::imencode(fs::path(path).extension().string(), image, bytes);
  } catch (const cv::Exception&) {
    encoded = false;
  }
  if (!encoded) throw std::runtime_error(path + ": is not the name of a picture format that can be written (use .png)");
  writeBytes(path, reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

Quiet::Quiet() : stderr_(dup(STDERR_FILENO)) {
  std::fflush(stderr);
  const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (stderr_ >= 0 && nowhere >= 0) dup2(nowhere, STDERR_FILENO);
  if (nowhere >= 0) close(nowhere);
}

Quiet::~Quiet() {
  std::fflush(stderr);
  if (stderr_ < 0) return;
  dup2(stderr_, STDERR_FILENO);
  close(stderr_);
}

std::string numbered(const std::string& path, int index, bool several) {
  if (path.empty() || !several) return path;
  const fs::path p(path);
  char suffix[16];
  std::snprintf(suffix, sizeof suffix, "-%04d", index);
  return (p.parent_path() / (p.stem().string() + suffix + p.extension().string())).string();
}

}  // namespace ppc
