// SPDX-License-Identifier: BSD-3-Clause
#include "output_bag.h"

#include "files.h"

#include <memory>
#include <stdexcept>

namespace ppc {

void writeBag(const std::string& path, const std::function<void(rosbag::Bag&)>& write) {
  writeAtomically(path, [&](const std::string& temporary) {
    auto bag = std::make_unique<rosbag::Bag>();
    try {
      bag->open(temporary, rosbag::bagmode::Write);
      bag->setCompression(rosbag::compression::LZ4);
      write(*bag);
      bag->close();
    } catch (const std::exception& error) {
      // Given up on purpose: the destructor would try to finish the bag again, and end the program when it cannot.
      static_cast<void>(bag.release());
      if (dynamic_cast<const rosbag::BagException*>(&error) == nullptr) throw;
      throw std::runtime_error(path + ": cannot be written (" + error.what() + ")");
    }
  });
}

}  // namespace ppc
