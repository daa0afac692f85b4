/// Counts the allocations of the calling thread, to test that frame-path calls do not allocate. Add
/// alloc_guard.cpp to the test's sources.
#pragma once

#include <cstdint>

namespace ovws::test {

/// Counts allocations (malloc, calloc, realloc, aligned_alloc, posix_memalign and every operator
/// new) of the constructing thread since construction. EXPECT_EQ(guard.allocations(), 0).
class AllocGuard {
 public:
  AllocGuard();
  std::uint64_t allocations() const;

 private:
  std::uint64_t before_;
};

}  // namespace ovws::test
