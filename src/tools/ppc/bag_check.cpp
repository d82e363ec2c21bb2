// SPDX-License-Identifier: BSD-3-Clause
#include "bag_check.h"

#include <rosbag/constants.h>
#include <rosbag/exceptions.h>
#include <rosbag/stream.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <stdexcept>
#include <vector>

namespace ppc {
namespace {

constexpr char kMagic[] = "#ROSBAG V2.0\n";
constexpr std::uint32_t kMostBytes = 1U << 30U;  // of a chunk: recorders make them of less than one megabyte

using Bytes = std::vector<std::uint8_t>;

struct Damage : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Header of a record: fields by name, each at its length.
class Fields {
 public:
  Fields(const std::uint8_t* bytes, std::size_t size) {
    while (size > 0) {
      std::uint32_t length = 0;
      if (size < sizeof length) throw Damage("has a field that is cut off");
      std::memcpy(&length, bytes, sizeof length);
      bytes += sizeof length;
      size -= sizeof length;
      if (length > size) throw Damage("has a field of " + std::to_string(length) + " bytes");
      const std::string field(reinterpret_cast<const char*>(bytes), length);
      const std::size_t end = field.find(static_cast<char>(rosbag::FIELD_DELIM));
      if (end == std::string::npos) throw Damage("has a field without name");
      values_[field.substr(0, end)] = field.substr(end + 1);
      bytes += length;
      size -= length;
    }
  }

  std::string text(const std::string& name) const {
    const auto found = values_.find(name);
    return found == values_.end() ? std::string() : found->second;
  }

  template <typename Number>
  Number number(const std::string& name) const {
    const std::string bytes = text(name);
    Number value{};
    if (bytes.size() != sizeof value) throw Damage("has no field '" + name + "'");
    std::memcpy(&value, bytes.data(), sizeof value);
    return value;
  }

  bool is(unsigned char op) const { return number<unsigned char>(rosbag::OP_FIELD_NAME) == op; }

 private:
  std::map<std::string, std::string> values_;
};

/// What is read of the file, with every length checked against the bytes that are left.
class File {
 public:
  explicit File(const std::string& path) : in_(path, std::ios::binary), left_(std::filesystem::file_size(path)) {}

  std::uint64_t at() const { return at_; }
  std::uint64_t left() const { return left_; }

  Bytes read(std::size_t size) {
    if (size > left_) throw Damage("is cut off");
    Bytes bytes(size);
    if (!in_.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size))) throw Damage("cannot be read");
    at_ += size;
    left_ -= size;
    return bytes;
  }

  Bytes readWithLength() {
    std::uint32_t length = 0;
    std::memcpy(&length, read(sizeof length).data(), sizeof length);
    return read(length);
  }

 private:
  std::ifstream in_;
  std::uint64_t at_ = 0, left_;
};

Bytes unpack(const Fields& fields, Bytes packed) {
  const std::string compression = fields.text(rosbag::COMPRESSION_FIELD_NAME);
  if (compression == rosbag::COMPRESSION_NONE) return packed;
  const auto size = fields.number<std::uint32_t>(rosbag::SIZE_FIELD_NAME);
  if (size > kMostBytes) throw Damage("holds " + std::to_string(size) + " bytes");
  Bytes bytes(size);
  const auto into = [&](rosbag::Stream&& stream) {
    stream.decompress(bytes.data(), size, packed.data(), static_cast<unsigned>(packed.size()));
  };
  if (compression == rosbag::COMPRESSION_BZ2) {
    into(rosbag::BZ2Stream(nullptr));
  } else if (compression == rosbag::COMPRESSION_LZ4) {
    into(rosbag::LZ4Stream(nullptr));
  } else {
    throw Damage("is packed by a method '" + compression.substr(0, 20) + "'");
  }
  return bytes;
}

// The record of a message at `offset` of a chunk.
void checkMessage(const Bytes& chunk, std::uint64_t offset) {
  const auto lengthAt = [&](std::uint64_t at) {
    std::uint32_t length = 0;
    if (at + sizeof length > chunk.size()) throw Damage("leads out of its chunk");
    std::memcpy(&length, chunk.data() + at, sizeof length);
    return std::uint64_t{length};
  };
  const std::uint64_t header = lengthAt(offset);
  const std::uint64_t data = lengthAt(offset + 4 + header);
  if (offset + 8 + header + data > chunk.size()) throw Damage("leads to a message that is longer than its chunk");
  if (!Fields(chunk.data() + offset + 4, header).is(rosbag::OP_MSG_DATA)) throw Damage("leads to no message");
}

void checkIndex(const Fields& fields, const Bytes& index, const Bytes& chunk) {
  constexpr std::size_t kEntry = 12;  // time and offset
  const auto count = fields.number<std::uint32_t>(rosbag::COUNT_FIELD_NAME);
  if (index.size() / kEntry < count) throw Damage("is shorter than it says");
  for (std::size_t i = 0; i < count; ++i) {
    std::uint32_t offset = 0;
    std::memcpy(&offset, index.data() + kEntry * i + 8, sizeof offset);
    checkMessage(chunk, offset);
  }
}

struct Record {
  Fields fields;
  Bytes data;
};

Record next(File& file) {
  const Bytes header = file.readWithLength();
  return {Fields(header.data(), header.size()), file.readWithLength()};
}

// The records one after the other: chunks, each with the places of its messages behind it, and at the end where the chunks
// are.
// @param at first byte of the record at hand
void checkRecords(File& file, std::uint64_t& at) {
  std::set<std::uint64_t> chunks;
  Bytes chunk;
  while (file.left() > 0) {
    at = file.at();
    Record record = next(file);
    if (record.fields.is(rosbag::OP_CHUNK)) {
      chunk = unpack(record.fields, std::move(record.data));
      chunks.insert(at);
    } else if (record.fields.is(rosbag::OP_INDEX_DATA)) {
      checkIndex(record.fields, record.data, chunk);
    } else if (record.fields.is(rosbag::OP_CHUNK_INFO)) {
      if (chunks.count(record.fields.number<std::uint64_t>(rosbag::CHUNK_POS_FIELD_NAME)) == 0)
        throw Damage("leads to no chunk");
    }
  }
}

}  // namespace

bool isBag(const std::string& path) {
  if (std::filesystem::path(path).extension() == ".bag") return true;
  std::ifstream in(path, std::ios::binary);
  std::string first(8, '\0');
  return in.read(first.data(), 8) && first == "#ROSBAG ";
}

void checkBag(const std::string& path) {
  File file(path);
  const std::string magic(kMagic);
  // Older ones have no chunks; rosbag tells what is no bag at all.
  if (file.left() < magic.size()) return;
  const Bytes first = file.read(magic.size());
  if (!std::equal(first.begin(), first.end(), magic.begin())) return;
  std::uint64_t at = file.at();
  std::string cause;
  try {
    const Fields head = next(file).fields;
    if (!head.text(rosbag::ENCRYPTOR_FIELD_NAME).empty()) return;  // only rosbag has the key
    if (head.number<std::uint64_t>(rosbag::INDEX_POS_FIELD_NAME) != 0) return checkRecords(file, at);
    cause = "was not closed by its recorder (`rosbag reindex` mends it)";
  } catch (const Damage& damage) {
    cause = "is damaged: the record at byte " + std::to_string(at) + " " + damage.what();
  } catch (const rosbag::BagException& error) {
    cause = "is damaged: the record at byte " + std::to_string(at) + " cannot be unpacked (" + error.what() + ")";
  }
  throw std::runtime_error(path + ": " + cause);
}

}  // namespace ppc
