/// Memory for the images of a recording that wait to be written.
#pragma once

#include <cstddef>

namespace ovws {

/// A buffer that is mapped and unmapped in steps of 1 MiB. In a process with locked memory the
/// kernel fills a whole mapping at once, and page faults of other threads wait meanwhile: small
/// steps keep these waits short.
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
