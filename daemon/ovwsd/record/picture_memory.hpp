/// Memory for pictures that wait to be written.
#pragma once

#include <cstddef>

namespace ovws {

/// Taken and given back a megabyte at a time: the process's memory is locked, so whatever is taken
/// at once is filled at once, and until it is, other threads' page faults wait for it.
class PictureMemory {
 public:
  /// Zeroes. Throws std::bad_alloc.
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
