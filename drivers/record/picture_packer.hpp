/// Deflate compression of recorded images, compatible with HDF5's built-in filter.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

struct libdeflate_compressor;

namespace ovws {

class PicturePacker {
 public:
  explicit PicturePacker(std::size_t picture_bytes);

  /// Compresses losslessly. Empty if the image would not become smaller. Valid until the next call.
  std::span<const std::byte> pack(std::span<const std::byte> picture);

 private:
  struct Free {
    void operator()(libdeflate_compressor* compressor) const;
  };
  std::unique_ptr<libdeflate_compressor, Free> compressor_;
  std::vector<std::byte> packed_;
};

}  // namespace ovws
