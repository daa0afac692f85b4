/// Counts what the calling thread allocates: a test's proof that a frame-path call allocates
/// nothing. Add alloc_guard.cpp to the test's sources.
#pragma once

#include <cstdint>

namespace ovws::test {

/// Allocations (malloc, calloc, realloc, aligned_alloc, posix_memalign and every operator new) of
/// the thread that made it, since it was made. EXPECT_EQ(guard.allocations(), 0).
class AllocGuard {
 public:
  AllocGuard();
  std::uint64_t allocations() const;

 private:
  std::uint64_t before_;
};

}  // namespace ovws::test
