// SPDX-License-Identifier: BSD-3-Clause
// RangeImage message -> core: a message is refused by name, or everything promised about its segmentation holds.
#include "checks.h"
#include "entry.h"
#include "patch_plane_clustering/ros/range_image_conversions.h"
#include "scene.h"

namespace ppc::fuzz {
namespace {

// Breaks a field of the message, or makes it odd.
void corrupt(Input& input, RangeImageMsg& message) {
  const auto value = input.raw<float>();
  const auto index = [&](std::size_t size) { return input.raw<std::uint16_t>() % size; };
  switch (input.integer(0, 11)) {
    case 0:
      message.height = input.raw<std::uint32_t>();
      break;
    case 1:
      message.width = input.raw<std::uint32_t>();
      break;
    case 2:
      message.poses_per_row = input.raw<std::uint32_t>();
      break;
    case 3:
      message.bearing_min = value;
      break;
    case 4:
      message.bearing_increment = value;
      break;
    case 5:
      message.range_min = value;
      break;
    case 6:
      message.range_max = value;
      break;
    case 7:
      message.tilts.resize(input.raw<std::uint8_t>(), value);
      break;
    case 8:
      message.intensities.resize(input.flag() ? message.ranges.size() : 3, value);
      break;
    case 9:
      message.line_poses[index(message.line_poses.size())].position.y = static_cast<double>(value);
      break;
    case 10:
      message.line_poses[index(message.line_poses.size())].orientation.x = static_cast<double>(value);
      break;
    default:
      message.line_poses[index(message.line_poses.size())].orientation.w *= -1.0;
  }
}

RangeImageMsg takeMessage(Input& input) {
  RangeImage image = takeScan(input);
  const int corruptions = std::max(0, input.integer(0, 9) - 6);
  Input corrupting = input.split(12 * static_cast<std::size_t>(corruptions));
  image.ranges = takeRanges(input, toBeamGrid(image));
  RangeImageMsg message = toMessage(image, std_msgs::Header());
  for (int i = 0; i < corruptions; ++i) corrupt(corrupting, message);
  return message;
}

}  // namespace

void run(Input input) {
  const Config config = takeConfig(input);
  RangeImage image;
  try {
    image = fromMessage(takeMessage(input));
  } catch (const std::invalid_argument&) {
    return;
  }
  const RangeImage back = fromMessage(toMessage(image, std_msgs::Header()));
  require(back.rows == image.rows && back.cols == image.cols && back.line_poses.size() == image.line_poses.size(),
          "a message made from the image is another image");
  require(toRadialImage(image, std_msgs::Header()).data.size() == 4 * image.ranges.size(), "radial image has another size");
  require(toPointCloud(image, std_msgs::Header()).width == static_cast<std::uint32_t>(image.cols), "cloud has another size");
  segmentAndCheck(toBeamGrid(image), config);
}

}  // namespace ppc::fuzz
