// SPDX-License-Identifier: Apache-2.0
// Replaces the allocation functions of the whole test program by ones that count. Include it in one source of a
// program.
#pragma once

#ifdef _WIN32
#include <malloc.h>
#endif

#include <cstdlib>
#include <new>

#include "support/allocations_in.h"

namespace spheretree::test {

[[gnu::noinline]] inline void* countedAllocation(std::size_t size, std::size_t alignment) {
  ++allocations;
#ifdef _WIN32
  if (void* p = ::_aligned_malloc(size + 1, alignment)) return p;
#else
  if (void* p = std::aligned_alloc(alignment, (size + alignment) / alignment * alignment)) return p;
#endif
  throw std::bad_alloc();
}
[[gnu::noinline]] inline void countedFree(void* p) {
#ifdef _WIN32
  ::_aligned_free(p);
#else
  std::free(p);
#endif
}

}  // namespace spheretree::test

// All forms use these two functions.
void* operator new(std::size_t size) { return spheretree::test::countedAllocation(size, 16); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  return spheretree::test::countedAllocation(size, static_cast<std::size_t>(alignment));
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept { return spheretree::test::countedAllocation(size, 16); }
void* operator new[](std::size_t size) { return spheretree::test::countedAllocation(size, 16); }
void* operator new[](std::size_t size, std::align_val_t alignment) {
  return spheretree::test::countedAllocation(size, static_cast<std::size_t>(alignment));
}
void operator delete[](void* p) noexcept { spheretree::test::countedFree(p); }
void operator delete[](void* p, std::size_t) noexcept { spheretree::test::countedFree(p); }
void operator delete[](void* p, std::align_val_t) noexcept { spheretree::test::countedFree(p); }
void operator delete(void* p) noexcept { spheretree::test::countedFree(p); }
void operator delete(void* p, std::size_t) noexcept { spheretree::test::countedFree(p); }
void operator delete(void* p, std::align_val_t) noexcept { spheretree::test::countedFree(p); }
void operator delete(void* p, std::size_t, std::align_val_t) noexcept { spheretree::test::countedFree(p); }
