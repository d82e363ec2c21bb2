// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "patch_plane_clustering/core/line_accounts.h"
#include "patch_plane_clustering/core/range_image.h"
#include "patch_plane_clustering/core/scan_line.h"
#include "patch_plane_clustering/core/sweep_assembler.h"
#include "patch_plane_clustering/ros/messages.h"

#include <sensor_msgs/Image.h>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/PointCloud2.h>
#include <std_msgs/Header.h>

namespace ppc {

/// @brief ros::Time of a stamp in seconds; zero for one that ros::Time cannot hold.
ros::Time toTime(double stamp);

/// @brief The image as a message. @param header as it shall be; its frame is that of the line poses.
RangeImageMsg toMessage(const RangeImage& image, const std_msgs::Header& header);

/// @brief The image of a sweep as a message, with the accounts of its lines. @param header as it shall be
RangeImageMsg toMessage(const Sweep& sweep, const std_msgs::Header& header);

/// @brief The accounts as a message; only causes that have occurred.
LineAccountsMsg toMessage(const LineAccounts& accounts);

/// @brief The message as an image, which satisfies checkConsistent(). Poses may be 1000 km from the origin of their frame at
/// most: beams are in single precision, and polygons so far away have no corners.
/// @throws std::invalid_argument naming the first field that is wrong.
RangeImage fromMessage(const RangeImageMsg& message);

/// @brief The same into an image that is there, whose memory is used again. It is left in part changed if this throws.
void fromMessage(const RangeImageMsg& message, RangeImage& image);

/// @brief Organised cloud (height = lines): x, y, z [m] and, if the image has them, intensity; all float32. x, y, z are NaN
/// where there is no measurement. Precondition: checkConsistent(image).
sensor_msgs::PointCloud2 toPointCloud(const RangeImage& image, const std_msgs::Header& header);

/// @brief The ranges as they are, 32FC1 [m].
sensor_msgs::Image toRadialImage(const RangeImage& image, const std_msgs::Header& header);

/// @brief The line of a scan, its stamp shifted by `time_offset` [s]. An infinite range_max becomes the largest float, so
/// that +Inf stays "no return". faultOf() tells whether the line can be used.
ScanLine toScanLine(const sensor_msgs::LaserScan& scan, double time_offset = 0.0);

/// @brief What contradicts itself in a scan beyond faultOf(): angle_max, which a line does not carry. Empty if nothing does.
std::string faultOf(const sensor_msgs::LaserScan& scan);

/// @brief The frame without the leading slash that old drivers give it.
std::string frameName(const std::string& frame_id);

/// @brief The same, and what is wrong with its frame. @param laser_frame the frame that it should have; empty: any
std::string faultOf(const sensor_msgs::LaserScan& scan, const std::string& laser_frame);

}  // namespace ppc
