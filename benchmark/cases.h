// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace ppc::bench {

// Names are GROUP/CASE or, in the group `size`, size/POINTS/CASE. The tables know them.

void addFloor();             ///< floor/...: the yardstick
void addPipeline();          ///< ppc/...: our own, with its stages
void addMessages();          ///< message/...: the same between ROS messages, and the messages that are made on request
void addBaselines();         ///< baseline/...: other methods, labels only
void addSizes(int largest);  ///< size/...: floor and pipeline from 10^4 points to `largest`
void addThreads();           ///< threads/N: the pipeline on one thread, on two and on four, in wall time

}  // namespace ppc::bench
