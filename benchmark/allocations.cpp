// SPDX-License-Identifier: BSD-3-Clause
#include "allocations.h"

#include <malloc.h>
#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <new>

namespace {

std::atomic<bool> counting{false};
std::atomic<std::int64_t> allocations{0}, bytes{0}, held{0}, peak{0};

void* take(std::size_t size, std::size_t alignment) {
  void* const block = alignment > alignof(std::max_align_t)
                          // cppcheck-suppress zerodiv
                          ? std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment)
                          : std::malloc(size == 0 ? 1 : size);
  if (block == nullptr) throw std::bad_alloc();
  if (counting.load(std::memory_order_relaxed)) {
    ++allocations;
    bytes += static_cast<std::int64_t>(size);
    const std::int64_t now = held += static_cast<std::int64_t>(malloc_usable_size(block));
    for (std::int64_t seen = peak; now > seen && !peak.compare_exchange_weak(seen, now);) {
    }
  }
  return block;
}

void give(void* block) {
  if (counting.load(std::memory_order_relaxed)) held -= static_cast<std::int64_t>(malloc_usable_size(block));
  std::free(block);
}

}  // namespace

void* operator new(std::size_t size) { return take(size, 0); }
void* operator new[](std::size_t size) { return take(size, 0); }
void* operator new(std::size_t size, std::align_val_t alignment) { return take(size, static_cast<std::size_t>(alignment)); }
void* operator new[](std::size_t size, std::align_val_t alignment) {
  return take(size, static_cast<std::size_t>(alignment));
}
void operator delete(void* block) noexcept { give(block); }
void operator delete[](void* block) noexcept { give(block); }
void operator delete(void* block, std::size_t) noexcept { give(block); }
void operator delete[](void* block, std::size_t) noexcept { give(block); }
void operator delete(void* block, std::align_val_t) noexcept { give(block); }
void operator delete[](void* block, std::align_val_t) noexcept { give(block); }
void operator delete(void* block, std::size_t, std::align_val_t) noexcept { give(block); }
void operator delete[](void* block, std::size_t, std::align_val_t) noexcept { give(block); }

namespace ppc::bench {

Memory memoryOf(const std::function<void()>& work) {
  allocations = bytes = held = peak = 0;
  counting = true;
  work();
  counting = false;
  return {allocations, bytes, peak};
}

}  // namespace ppc::bench
