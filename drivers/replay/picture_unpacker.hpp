/// Inflates images that PicturePacker has compressed.
#pragma once

#include <cstddef>
#include <memory>
#include <span>

struct libdeflate_decompressor;

namespace ovws {

class PictureUnpacker {
 public:
  PictureUnpacker();

  /// False unless `packed` inflates to exactly `picture.size()` bytes.
  bool unpack(std::span<const std::byte> packed, std::span<std::byte> picture);

 private:
  struct Free {
    void operator()(libdeflate_decompressor* decompressor) const;
  };
  std::unique_ptr<libdeflate_decompressor, Free> decompressor_;
};

}  // namespace ovws
