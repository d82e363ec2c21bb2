// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/ros/segmentation_conversions.h"

#include "patch_plane_clustering/core/segmenter.h"
#include "patch_plane_clustering/ros/region_color.h"
#include "test_scenes.h"

#include <gtest/gtest.h>
#include <sensor_msgs/image_encodings.h>
#include <sensor_msgs/point_cloud2_iterator.h>
#include <cmath>
#include <functional>
#include <set>
#include <stdexcept>
#include <string>

namespace ppc {
namespace {

using namespace testing_tools;  // NOLINT: one scene header for these tests

struct Segmented {
  BeamGrid grid;
  Segmentation segmentation;
};

Segmented segmentedPlate() {
  Segmented s;
  s.grid = toBeamGrid(fromMessage(scanMessage({plate()}, 7.0)));
  s.segmentation = segment(s.grid, Config());
  return s;
}

TEST(PolygonArray, CarriesPlaneRingsAndArea) {
  const Segmented s = segmentedPlate();
  const PlanarPolygonArray array = toPolygonArray(s.segmentation, headerAt(7.0));
  EXPECT_EQ(array.header.frame_id, "tilt_base");
  EXPECT_EQ(array.header.stamp, ros::Time(7.0));
  ASSERT_EQ(array.polygons.size(), 1U);
  const PlanarPolygonMsg& polygon = array.polygons[0];
  EXPECT_EQ(polygon.id, 1);
  EXPECT_NEAR(polygon.plane.coef[0], -1.0, 1e-4);  // towards the sensor
  EXPECT_NEAR(polygon.plane.coef[1], 0.0, 1e-3);
  EXPECT_NEAR(polygon.plane.coef[2], 0.0, 1e-3);
  EXPECT_NEAR(polygon.plane.coef[3], 2.0, 1e-3);  // -x + 2 = 0
  EXPECT_NEAR(polygon.centroid.x, 2.0, 1e-3);
  EXPECT_NEAR(polygon.area, kPlateArea, 0.02 * kPlateArea);
  EXPECT_EQ(polygon.holes.size(), 1U);
  EXPECT_EQ(polygon.point_count, static_cast<std::uint32_t>(s.segmentation.regions.at(0).points));
  for (const auto& p : polygon.outer.points) EXPECT_NEAR(p.x, 2.0, 1e-3);
}

TEST(PolygonArray, CovarianceIsThatOfTheMessagesCoefficients) {
  Segmentation segmentation;
  PlanarRegion region;
  region.id = 1;
  for (int i = 0; i < 16; ++i) region.covariance(i / 4, i % 4) = 1.0 + i;
  segmentation.regions = {region};
  PlanarPolygon polygon;
  polygon.id = 1;
  segmentation.polygons = {polygon};
  const auto array = toPolygonArray(segmentation, {});
  const auto& covariance = array.polygons.at(0).covariance;
  EXPECT_EQ(covariance[1], 2.0);   // a, b
  EXPECT_EQ(covariance[3], -4.0);  // a, d: the message's d has the other sign
  EXPECT_EQ(covariance[12], -13.0);
  EXPECT_EQ(covariance[15], 16.0);  // d, d
}

TEST(PolygonArray, RefusesAPolygonWithoutRegion) {
  Segmentation segmentation;
  segmentation.polygons.resize(1);
  segmentation.polygons[0].id = 5;
  EXPECT_THROW(toPolygonArray(segmentation, {}), std::invalid_argument);
}

TEST(LabelImageMessage, HoldsTheLabelsRowByRow) {
  const LabelImage labels{2, 3, {0, 1, 2, 3, 70000, 0}};
  const sensor_msgs::Image image = toLabelImage(labels, headerAt(1.0));
  EXPECT_EQ(image.encoding, sensor_msgs::image_encodings::TYPE_32SC1);
  EXPECT_EQ(image.height, 2U);
  EXPECT_EQ(image.width, 3U);
  EXPECT_EQ(image.step, 12U);
  ASSERT_EQ(image.data.size(), 24U);
  std::int32_t label = 0;
  std::memcpy(&label, &image.data[1 * image.step + 1 * 4], 4);
  EXPECT_EQ(label, 70000);
}

TEST(SegmentedCloud, IsOrganisedAndColouredById) {
  const Segmented s = segmentedPlate();
  const auto cloud = toSegmentedCloud(s.grid, s.segmentation.labels, headerAt(7.0));
  ASSERT_EQ(cloud.height, 91U);
  ASSERT_EQ(cloud.width, 121U);
  sensor_msgs::PointCloud2ConstIterator<float> x(cloud, "x");
  sensor_msgs::PointCloud2ConstIterator<std::uint8_t> bgr(cloud, "rgb");
  sensor_msgs::PointCloud2ConstIterator<std::uint32_t> label(cloud, "label");
  int planar = 0, missing = 0;
  for (int i = 0; i < s.grid.size(); ++i, ++x, ++bgr, ++label) {
    ASSERT_EQ(*label, static_cast<std::uint32_t>(s.segmentation.labels.labels[static_cast<std::size_t>(i)]));
    ASSERT_EQ(std::isnan(*x), !s.grid.valid(i));
    const RegionColor color = regionColor(static_cast<std::int32_t>(*label));
    ASSERT_EQ(bgr[0], color.b);
    ASSERT_EQ(bgr[1], color.g);
    ASSERT_EQ(bgr[2], color.r);
    if (*label == 1) {
      ASSERT_NEAR(*x, 2.0, 1e-4);
      ++planar;
    }
    missing += std::isnan(*x);
  }
  EXPECT_EQ(planar, s.segmentation.regions.at(0).points);
  EXPECT_GT(missing, 1000);
}

TEST(RegionColor, IdsThatFollowEachOtherDiffer) {
  std::set<int> colors;
  for (int id = 0; id <= 200; ++id) {
    const RegionColor a = regionColor(id), b = regionColor(id + 1);
    EXPECT_GT(std::abs(a.r - b.r) + std::abs(a.g - b.g) + std::abs(a.b - b.b), 60) << id;
    colors.insert(a.r << 16 | a.g << 8 | a.b);
  }
  EXPECT_GT(colors.size(), 190U);
}

TEST(Statistics, CountPointsVerticesAndCompression) {
  const Segmented s = segmentedPlate();
  const SegmentationStatistics statistics = toStatistics(s.segmentation, headerAt(7.0));
  const auto& polygon = s.segmentation.polygons.at(0);
  EXPECT_EQ(statistics.height, 91U);
  EXPECT_EQ(statistics.width, 121U);
  EXPECT_EQ(statistics.regions, 1U);
  EXPECT_EQ(statistics.polygons, 1U);
  EXPECT_EQ(statistics.vertices, polygon.outer.size() + polygon.holes.at(0).size());
  EXPECT_EQ(statistics.planar_points, static_cast<std::uint32_t>(s.segmentation.regions.at(0).points));
  EXPECT_EQ(statistics.valid_points, static_cast<std::uint32_t>(s.segmentation.valid_points));
  EXPECT_FLOAT_EQ(statistics.compression,
                  static_cast<float>(statistics.valid_points) / static_cast<float>(statistics.vertices));
  ASSERT_EQ(statistics.stage_names.size(), s.segmentation.stages.size());
  ASSERT_EQ(statistics.stage_milliseconds.size(), s.segmentation.stages.size());
  EXPECT_EQ(statistics.stage_names.at(0), s.segmentation.stages.at(0).first);
}

TEST(Statistics, WithoutPolygonsTheCompressionIsZero) { EXPECT_EQ(toStatistics(Segmentation(), {}).compression, 0.0F); }

TEST(Cloud, FieldsInAnyOrderWithAnyPadding) {
  const BeamGrid grid = gridFromCloud(cameraCloud(1.0));
  ASSERT_EQ(grid.rows, 96);
  ASSERT_EQ(grid.cols, 128);
  EXPECT_FALSE(grid.valid(grid.index(10, 3)));
  ASSERT_TRUE(grid.valid(grid.index(10, 4)));
  const Eigen::Vector3f wall = grid.point(grid.index(10, 100)), box = grid.point(grid.index(48, 64));
  EXPECT_NEAR(wall.x(), (100 - 63.5) / 120.0 * 2.0, 1e-5);
  EXPECT_NEAR(wall.y(), (10 - 47.5) / 120.0 * 2.0, 1e-5);
  EXPECT_NEAR(wall.z(), 2.0, 1e-5);
  EXPECT_NEAR(box.z(), 1.0, 1e-5);
}

TEST(Cloud, DoublePrecisionIsRead) {
  sensor_msgs::PointCloud2 cloud;
  cloud.height = cloud.width = 2;
  cloud.point_step = 24;
  cloud.row_step = 48;
  const char* names[] = {"x", "y", "z"};
  for (std::uint32_t i = 0; i < 3; ++i) {
    sensor_msgs::PointField field;
    field.name = names[i];
    field.offset = 8 * i;
    field.datatype = sensor_msgs::PointField::FLOAT64;
    cloud.fields.push_back(field);
  }
  const double points[12] = {1, 0, 0, 1, 1, 0, 1, 0, 1, 1, 1, 1};
  cloud.data.resize(96);
  std::memcpy(cloud.data.data(), points, 96);
  const BeamGrid grid = gridFromCloud(cloud);
  EXPECT_NEAR(grid.range[3], std::sqrt(3.0), 1e-6);
  EXPECT_NEAR(grid.point(1).y(), 1.0, 1e-6);
}

TEST(Cloud, RefusesWhatIsNoOrganisedCloudAndSaysWhy) {
  const struct {
    const char* expected;
    std::function<void(sensor_msgs::PointCloud2&)> spoil;
  } cases[] = {
      {"not organised (height 1", [](auto& c) { c.width *= c.height, c.height = 1; }},
      {"not organised (height 0", [](auto& c) { c.height = 0, c.data.clear(); }},
      {"no field 'z'", [](auto& c) { c.fields[1].name = "depth"; }},
      {"field 'y' has datatype 4", [](auto& c) { c.fields[2].datatype = sensor_msgs::PointField::UINT16; }},
      {"field 'x' at offset 30 ends beyond point_step = 32", [](auto& c) { c.fields[3].offset = 30; }},
      {"field 'x' at offset 4294967295", [](auto& c) { c.fields[3].offset = 0xFFFFFFFFU; }},
      {"row_step = 4112 is less than", [](auto& c) { c.width = 129; }},
      {"data holds", [](auto& c) { c.data.resize(c.data.size() - 17); }},
      {"data holds", [](auto& c) { c.height = 0x7FFFFFFFU; }},
      {"ends beyond point_step = 0", [](auto& c) { c.point_step = 0; }},
      {"is_bigendian", [](auto& c) { c.is_bigendian = !c.is_bigendian; }},
  };
  for (const auto& each : cases) {
    sensor_msgs::PointCloud2 cloud = cameraCloud(1.0);
    each.spoil(cloud);
    try {
      gridFromCloud(cloud);
      ADD_FAILURE() << "accepted: " << each.expected;
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find(each.expected), std::string::npos) << error.what();
    }
  }
}

TEST(Cloud, PaddingOfTheLastRowMayBeMissing) {
  sensor_msgs::PointCloud2 cloud = cameraCloud(1.0);
  cloud.data.resize(cloud.data.size() - 16);
  EXPECT_NEAR(gridFromCloud(cloud).point(95 * 128 + 127).z(), 2.0, 1e-5);
}

}  // namespace
}  // namespace ppc
