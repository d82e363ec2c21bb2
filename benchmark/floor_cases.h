// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "measure.h"

namespace ppc::bench {

/// @brief Ranges of the office to patch moments and, if `fit`, a plane a patch.
Frame floorFrame(int points, bool fit);

}  // namespace ppc::bench
