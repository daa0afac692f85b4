/// Memory for the images of a recording that wait to be written.
#pragma once

#include <cstddef>

namespace ovws {

/// Allocates and frees 1 MiB at a time. The process's memory is locked, so the kernel fills a
/// mapping at once, and page faults of other threads wait until it is full.
class PictureMemory {
 public:
  /// Filled with zeros. Throws std::bad_alloc.
  explicit PictureMemory(std::size_t bytes);
  ~PictureMemory();
  PictureMemory(const PictureMemory&) = delete;
  PictureMemory& operator=(const PictureMemory&) = delete;

  std::byte* data() { return begin_; }

 private:
  std::byte* begin_ = nullptr;
  std::size_t bytes_ = 0;
};

}  // namespace ovws
